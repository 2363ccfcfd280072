//! The steady motion of one ball passage: found by shooting, verified by finer steps and by a run from rest.

use realfft::RealFftPlanner;

use super::applicability::inapplicability;
use crate::numerics::lanes::{InstructionSet, Task};
use crate::numerics::ode::Statistics;
use crate::numerics::ode::adams_moulton::{AdamsMoulton, EquationsOfMotion};
use crate::numerics::periodic::{PeriodicOrbit, Search};
use crate::numerics::statistics::{peak, rms};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::spindle_only::equations::SpindleOnly;
use crate::simulation::model::spindle_only::{scene_model, statistics};
use crate::simulation::recording::sampling::SPINDLE_IN_PLANE;

/// Nodes of the Adams–Moulton method: every passage starts again by a method of order 4.
const SHOT_NODES: usize = 4;
/// Largest product of the step with the frequency of the stiffest direction [rad].
const MAX_PHASE: f64 = 0.35;
/// The longest step of the search for a periodic motion [s]; the result is refined with shorter steps.
const MAX_STEP: f64 = 1e-5;
/// Relative change of a level at which halving the steps ends: the next halving would change it by a fifth of that, 0.004 dB. Steps meet
/// the same contacts at the same places in each passage. So their errors at touch, of order 2½, add up, while those of a run in time are
/// random.
const MAX_LEVEL_CHANGE: f64 = 2e-3;
/// Largest number of halvings.
const MAX_HALVINGS: usize = 4;
/// Additional evaluations of a passage for its start by Runge–Kutta.
const START_EVALUATIONS: u64 = 10;
/// Largest number of steps of a passage: with more, a run in time is no slower.
const MAX_STEPS_A_PASSAGE: usize = 100_000;
/// Ball passages simulated from rest before each search.
const PASSAGES: [usize; 3] = [6, 24, 96];
/// Largest number of passages from rest to the periodic motion.
const MAX_PASSAGES: usize = 200;
/// Largest distance of the motion from rest to the periodic motion, in amplitudes [-].
const MAX_DISTANCE: f64 = 0.2;
/// Smallest Floquet radius at which a periodic motion is rejected as unstable or nearly so [-].
pub(crate) const LARGEST_RADIUS: f64 = 0.98;

/// Signals of one passage, in the order of `SPINDLE_IN_PLANE`.
pub(super) type Signals = [Vec<f64>; SPINDLE_IN_PLANE.len()];

/// A steady motion of the spindle: one ball passage, sampled at equal intervals from azimuth 0 of a ball.
#[derive(Debug, Clone)]
pub struct Passage {
    /// Time from one ball to the next [s].
    pub length: f64,
    pub orbit: PeriodicOrbit<4>,
    pub statistics: Statistics,
    pub(super) signals: Signals,
}

/// Simulation of one passage in a number of steps.
struct Shot<'a> {
    model: &'a SpindleOnly,
    length: f64,
    steps: usize,
    state: [f64; 4],
    signals: Option<&'a mut Signals>,
}

impl Task for Shot<'_> {
    type Answer = [f64; 4];

    #[inline(always)]
    fn run(self) -> [f64; 4] {
        let [y, z, vy, vz] = self.state;
        let step = self.length / self.steps as f64;
        let mut method = AdamsMoulton::<SHOT_NODES>::new(self.model, 0.0, ([y, z], [vy, vz]), step);
        let mut signals = self.signals;
        for point in 0..self.steps {
            if method.has_begun() {
                method.step(self.model, &self.model.drive(method.after(1)));
            } else {
                method.begin(self.model);
            }
            if let Some(signals) = &mut signals {
                let (([y, z], [vy, vz]), [ay, az]) = (*method.motion(), *method.acceleration());
                // The last point is the first one of the next passage.
                let at = if point + 1 == self.steps { 0 } else { point + 1 };
                for (signal, value) in signals.iter_mut().zip([y, z, vy, vz, ay, az]) {
                    signal[at] = value;
                }
            }
        }
        let ([y, z], [vy, vz]) = *method.motion();
        [y, z, vy, vz]
    }
}

/// The steady motion of a scene; an error where it is not stable.
pub fn passage(scene: &Scene, settings: &RunSettings) -> Result<Passage, SimulationError> {
    let (model, _) = scene_model(scene, settings, "periodic", inapplicability)?;
    steady(&model)
}

pub(super) fn steady(model: &SpindleOnly) -> Result<Passage, SimulationError> {
    let (rest, frequency) = model.rest();
    if frequency == 0.0 {
        return Err(not_applicable(Inapplicable::NothingHolds));
    }
    let speed = model.speed(0.0).0;
    let length = std::f64::consts::TAU / (model.balls() as f64 * (model.orbit_ratio() * speed).abs());
    let longest = MAX_STEP.min(MAX_PHASE / frequency).min(model.longest_step());
    let coarse = ((length / longest).ceil() as usize).max(16);
    if coarse > MAX_STEPS_A_PASSAGE {
        return Err(not_applicable(Inapplicable::LongPassage { passage: length, steps: coarse, step: longest }));
    }
    let set = InstructionSet::best();
    let shot = |state: &[f64; 4], steps: usize, signals: Option<&mut Signals>| {
        set.run(Shot { model, length, steps, state: *state, signals })
    };
    let shoot = |state: &[f64; 4]| shot(state, coarse, None);
    let record = |orbit: &PeriodicOrbit<4>, steps: usize| {
        let mut signals: Signals = std::array::from_fn(|_| vec![0.0; steps]);
        shot(&orbit.state, steps, Some(&mut signals));
        signals
    };
    let place = 1e-6;
    let search =
        Search { sizes: [place, place, place * frequency, place * frequency], tolerance: 1e-5, iterations: 12 };
    let mut state = [rest[0], rest[1], 0.0, 0.0];
    let mut periods = 0;
    let mut refusal = None;
    for passages in PASSAGES {
        state = (periods..passages).fold(state, |state, _| shoot(&state));
        periods = passages.max(periods);
        let mut orbit = match search.find(state, shoot) {
            Ok(orbit) if orbit.radius() < LARGEST_RADIUS => orbit,
            Ok(orbit) => {
                refusal = Some(Inapplicable::UnstableOrbit { growth: orbit.radius() });
                continue;
            }
            Err(error) => {
                refusal = Some(Inapplicable::NoPeriodicOrbit(error));
                continue;
            }
        };
        let mut steps = coarse;
        let mut signals = record(&orbit, steps);
        let mut evaluations = (orbit.periods + 1) * (steps as u64 + START_EVALUATIONS);
        let mut change = f64::INFINITY;
        for _ in 0..MAX_HALVINGS {
            steps *= 2;
            let Ok(finer) = search.refine(&orbit, |state| shot(state, steps, None)) else { break };
            let seen = record(&finer, steps);
            // Change of velocities and accelerations.
            change = (2..6).map(|i| (rms(&seen[i]) / rms(&signals[i]) - 1.0).abs()).fold(0.0, f64::max);
            evaluations += (finer.periods + 1) * (steps as u64 + START_EVALUATIONS);
            (orbit, signals) = (finer, seen);
            if change <= MAX_LEVEL_CHANGE {
                break;
            }
        }
        if change.is_nan() || change > MAX_LEVEL_CHANGE {
            refusal = Some(Inapplicable::UnresolvedOrbit { change });
            continue;
        }
        // Stability is measured again, because coarse steps may find a stable orbit where none exists.
        let orbit = match search.measured(orbit, |state| shot(state, steps, None)) {
            Ok(orbit) => orbit,
            Err(error) => {
                refusal = Some(Inapplicable::NoPeriodicOrbit(error));
                continue;
            }
        };
        evaluations += (1 + orbit.state.len() as u64) * (steps as u64 + START_EVALUATIONS);
        if orbit.radius() >= LARGEST_RADIUS {
            refusal = Some(Inapplicable::UnstableOrbit { growth: orbit.radius() });
            continue;
        }
        // Several orbits may be stable. Only the one that a run from rest approaches is the answer.
        let amplitude: [f64; 4] = std::array::from_fn(|i| peak(&signals[i]).max(1e-3 * search.sizes[i]));
        let away = |state: &[f64; 4]| {
            (0..4).map(|i| (state[i] - orbit.state[i]).abs() / amplitude[i]).fold(0.0, f64::max) > MAX_DISTANCE
        };
        while away(&state) && periods < MAX_PASSAGES {
            state = shoot(&state);
            periods += 1;
        }
        if away(&state) {
            refusal = Some(Inapplicable::OtherOrbit);
            break;
        }
        evaluations += periods as u64 * (coarse as u64 + START_EVALUATIONS);
        let statistics = statistics(evaluations, evaluations, length / steps as f64);
        return Ok(Passage { length, orbit, statistics, signals });
    }
    Err(not_applicable(refusal.unwrap_or(Inapplicable::OtherOrbit)))
}

fn not_applicable(reason: Inapplicable) -> SimulationError {
    SimulationError::NotApplicable { rung: "periodic", reason }
}

impl Passage {
    /// rms of each signal up to a frequency [Hz] without its mean: y, z of place, velocity, acceleration [SI].
    pub fn rms(&self, band: f64) -> [f64; 6] {
        let n = self.signals[0].len();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
        std::array::from_fn(|i| {
            let mut spectrum = transform.make_output_vec();
            let mut signal = self.signals[i].clone();
            // The transform cannot fail, because both buffers have its lengths.
            let _ = transform.process(&mut signal, &mut spectrum);
            let power: f64 = spectrum
                .iter()
                .enumerate()
                .skip(1)
                .take_while(|(k, _)| *k as f64 <= band * self.length)
                .map(|(k, c)| if 2 * k == n { 0.5 * c.norm_sqr() } else { c.norm_sqr() })
                .sum();
            (2.0 * power).sqrt() / n as f64
        })
    }
}
