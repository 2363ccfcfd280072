//! Runs of the rungs that integrate the spindle alone: `spindle_only` in time with fixed steps, `periodic` by its steady
//! orbit. Both leave a `Recording`, so that metrics, spectra and lines need not know.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use crate::numerics::interpolation::Interpolator;
use crate::numerics::lanes::{InstructionSet, Task};
use crate::numerics::ode::adams_moulton::{AdamsMoulton, EquationsOfMotion};
use crate::numerics::ode::{IntegrationError, Statistics};
use crate::numerics::periodic::{PeriodicOrbit, Search};
use crate::numerics::statistics::{peak, rms};
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::damping::DampingLaw;
use crate::physics::spindle::AxialHold;
use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::Mechanism;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::radially_condensed::{MOST_STEPS, Pace};
use crate::simulation::model::spindle_only::{Corrections, Driven, SpindleMotion, SpindleOnly};
use crate::simulation::model::terms::Needs;
use crate::simulation::recording::record::ContactExtremes;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::sampling::kept_values;
use crate::simulation::recording::windows::Recorder;

/// Nodes of the method, and the longest step times the frequency of the stiffest direction: there it errs by up to 0.01 dB.
const NODES: usize = 7;
const LONGEST_STEP: f64 = 0.6;
/// The longest step [s]: 19.5 µs are good to 0.01 dB, the next longer ones are not.
const LONGEST: f64 = 20e-6;
/// The same of a periodic motion, whose every passage begins anew by a method of order 4.
const SHOT_NODES: usize = 4;
const LONGEST_TURN_OF_SHOT: f64 = 0.35;
/// The longest step with which a periodic motion is sought [s]; the motion that is found is followed to finer ones.
const LONGEST_SHOT: f64 = 1e-5;
/// Relative change of a level at which halving the steps of a periodic motion ends: the next halving would change it by a
/// fifth of that, 0.004 dB. Steps meet the same contacts at the same places in each passage, so that their errors at touch, of
/// order 2½, add up there where those of a run in time are chance.
const LEVEL_CHANGE: f64 = 2e-3;
const MOST_HALVINGS: usize = 4;
/// Evaluations of a passage beyond its steps, for its start by Runge–Kutta.
const RESTART: u64 = 10;
/// Steps of a passage beyond which a run in time is no slower.
const MOST_STEPS_A_PASSAGE: usize = 100_000;
/// Steps between two looks at `Control`, and at the speed.
const STEPS_PER_LOOK: usize = 64;
/// Values of an extended motion between two looks at `Control`.
const VALUES_PER_LOOK: usize = 1 << 14;
/// Relative change of speed after which the centrifugal force is taken anew.
const SPEED_CHANGE: f64 = 1e-3;
/// Ball passages in time before a periodic motion is sought, again after ever more of them.
const PASSAGES: [usize; 3] = [6, 24, 96];
const MOST_PASSAGES: usize = 200;
/// How near to the periodic motion the motion from rest has to come, in amplitudes.
const SETTLED: f64 = 0.2;
/// Floquet radius from which on a periodic motion does not count as the answer.
pub const LARGEST_RADIUS: f64 = 0.98;
/// Points looked at per point integrated, when a periodic motion is extended.
const FINER: usize = 8;

/// Signals kept of every step: place, velocity, acceleration of y and z.
const SIGNALS: [(Axis, Motion); 6] = [
    (Axis::Y, Motion::Displacement),
    (Axis::Z, Motion::Displacement),
    (Axis::Y, Motion::Velocity),
    (Axis::Z, Motion::Velocity),
    (Axis::Y, Motion::Acceleration),
    (Axis::Z, Motion::Acceleration),
];
type Signals = [Vec<f64>; 6];
/// Of one step.
type Frame = [f64; SIGNALS.len()];

/// Why the spindle alone cannot stand for this scene and these outputs; `None`: it can.
pub fn unable(scene: &Scene, needs: &Needs, outputs: &Outputs) -> Option<String> {
    let channels = || outputs.spectra.iter().chain(&outputs.series);
    let of_spindle = |channel: &Channel| matches!(channel, Channel::Spindle(Axis::Y | Axis::Z, _));
    let reason = if scene.operation.load[0] != 0.0 {
        "an axial load acts"
    } else if needs.axial_spindle {
        "the spindle moves along X"
    } else if scene.spindle.axial != AxialHold::Fixed && scene.spindle.axial != AxialHold::Offset(0.0) {
        "the spindle is held off its centre along X"
    } else if scene.operation.misalignment != [0.0; 2] {
        "the spindle is misaligned"
    } else if !needs.cage {
        "without a cage nothing keeps the balls apart"
    } else if needs.raceway.hydrodynamics {
        "rolling friction and pressure forces of the film act on the spindle"
    } else if matches!(scene.raceway_damping, DampingLaw::Viscous { coefficient } if coefficient != 0.0) {
        "raceways with a viscous damper have no condensed law"
    } else if outputs.contacts {
        "contacts are asked for (`outputs.metrics` without \"contacts\" does not)"
    } else if outputs.cage {
        "the cage's motion is asked for (`outputs.metrics` without \"cage\" does not)"
    } else if !channels().all(of_spindle) {
        "a channel besides y and z of the spindle is asked for"
    } else {
        return None;
    };
    Some(reason.into())
}

/// Why there is no steady orbit of one ball passage; `None`: there may be one.
pub fn unable_periodic(scene: &Scene, needs: &Needs, outputs: &Outputs) -> Option<String> {
    let reason = if !scene.operation.speed.is_constant() {
        "the speed changes"
    } else if scene.operating_speed() == 0.0 {
        "nothing turns"
    } else if needs.unbalance {
        "unbalance turns with the spindle and not with the balls"
    } else {
        return unable(scene, needs, outputs);
    };
    Some(reason.into())
}

fn prepared(
    scene: &Scene,
    settings: &RunSettings,
    rung: &'static str,
    unable: fn(&Scene, &Needs, &Outputs) -> Option<String>,
) -> Result<(SpindleOnly, Mechanism), SimulationError> {
    let needs = Needs::of(scene, &settings.outputs, Some(ModelLevel::Full))?;
    if let Some(reason) = unable(scene, &needs, &settings.outputs) {
        return Err(SimulationError::Unable { rung, reason });
    }
    let mechanism = Mechanism::new(scene, &needs);
    Ok((
        SpindleOnly::new(&mechanism, scene.raceway_damping.resolve().chi, mechanism.orbit_ratio, Corrections::ALL),
        mechanism,
    ))
}

/// ModelLevel `spindle_only`: simulates the scene in time. `settings.fixed_step` bounds the step.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let (mut model, mechanism) = prepared(scene, settings, "spindle_only", unable)?;
    let (rest, frequency) = model.rest();
    let pace = Pace::of(settings.fixed_step.unwrap_or(LONGEST.min(LONGEST_STEP / frequency)));
    let step = pace.step();
    if pace.steps > MOST_STEPS {
        let reason = format!("the spindle on its contacts is too quick for it: it needs steps of {step:.1e} s");
        return Err(SimulationError::Unable { rung: "spindle_only", reason });
    }
    let values = kept_values(settings.duration);
    let before = (settings.settle / step).floor() as usize;
    // The grid of steps meets the first kept value; the run begins up to a step after time 0.
    let begin = settings.settle - before as f64 * step;
    let mut recorder = Recorder::new(spindle_channels(), &settings.outputs, values);
    // Values between steps need steps on either side; before the first of all steps there is a standstill.
    let mut interpolator = Interpolator::new(pace.steps, pace.values);
    let delay = if pace.is_long() { Interpolator::<{ SIGNALS.len() }>::DELAY } else { 0 };
    let mut primed = before >= delay;
    let first = if primed { before - delay } else { before };
    let all = before + ((values - 1) * pace.steps).div_ceil(pace.values) + delay + 1;
    let set = InstructionSet::best();
    let mut fitted = model.speed(begin).0;
    model.refit(fitted);
    let mut method = AdamsMoulton::<NODES>::new(&model, begin, (rest, [0.0; 2]), step);
    for from in (0..all).step_by(STEPS_PER_LOOK) {
        let to = (from + STEPS_PER_LOOK).min(all);
        let (speed, constant) = model.speed(method.time());
        if !constant && (speed - fitted).abs() > SPEED_CHANGE * fitted.abs() {
            fitted = speed;
            model.refit(speed);
        }
        let mut frames = [Frame::default(); STEPS_PER_LOOK];
        set.run(Advance { model: &model, method: &mut method, begins: from == 0, frames: &mut frames[..to - from] });
        let kept = &frames[first.clamp(from, to) - from..to - from];
        if !pace.is_long() {
            let done = from.max(first) - first;
            let next = done.next_multiple_of(pace.steps) - done;
            kept.iter().skip(next).step_by(pace.steps).for_each(|frame| recorder.push(frame));
        } else if let Some(frame) = kept.first() {
            if !primed {
                interpolator.prime(frame);
                primed = true;
            }
            recorder.extend(interpolator.push(kept, set));
        }
        let time = method.time();
        if let Some(component) = not_finite(method.motion()) {
            let source = IntegrationError::NotFinite { time, step, component };
            return Err(SimulationError::Integration { source, entry: "the spindle".into() });
        }
        if from % (16 * STEPS_PER_LOOK) == 0 {
            if (control.stop)() {
                return Err(SimulationError::Stopped { time });
            }
            (control.progress)(to as f64 / all as f64);
            let phase = if to < before { Phase::Settling } else { Phase::Recording };
            (control.live)(&Live { phase, accelerations: &|| recorder.accelerations() });
        }
    }
    let statistics = statistics(all as u64 - 1, method.evaluations(), step);
    let start = begin + before as f64 * step;
    Ok((recording(&model, &mechanism, start, settings.duration, recorder, None), statistics))
}

fn not_finite((place, velocity): &SpindleMotion) -> Option<usize> {
    place.iter().chain(velocity).position(|value| !value.is_finite())
}

fn statistics(steps: u64, rhs_evaluations: u64, step: f64) -> Statistics {
    let advanced = steps as f64 * step;
    Statistics { steps, rhs_evaluations, least_step: step, advanced, ..Statistics::default() }
}

/// Some points of a run, one step after another; the first point of all is where it begins.
struct Advance<'a> {
    model: &'a SpindleOnly,
    method: &'a mut AdamsMoulton<NODES>,
    begins: bool,
    frames: &'a mut [Frame],
}

impl Task for Advance<'_> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        let Self { model, method: at, begins, frames } = self;
        let mut begun = 0;
        while begun < frames.len() && !at.has_begun() {
            if begun > 0 || !begins {
                at.begin(model);
            }
            frames[begun] = frame(at);
            begun += 1;
        }
        let frames = &mut frames[begun..];
        // In registers meanwhile: what is written in parts and read as a whole is waited for. And nothing is called
        // between two steps, which would have to empty the registers.
        let mut method = *at;
        let mut drives = [Driven::default(); STEPS_PER_LOOK];
        model.drives(|step| method.after(step + 1), &mut drives);
        for (kept, drive) in frames.iter_mut().zip(&drives) {
            method.step(model, drive);
            *kept = frame(&method);
        }
        *at = method;
    }
}

#[inline(always)]
fn frame(method: &AdamsMoulton<NODES>) -> Frame {
    let (([y, z], [vy, vz]), [ay, az]) = (*method.motion(), *method.acceleration());
    [y, z, vy, vz, ay, az]
}

fn spindle_channels() -> [Channel; 6] {
    SIGNALS.map(|(axis, motion)| Channel::Spindle(axis, motion))
}

fn recording(
    model: &SpindleOnly,
    mechanism: &Mechanism,
    start: f64,
    duration: f64,
    recorder: Recorder,
    total_variance: Option<[f64; 6]>,
) -> Recording {
    let (signals, whirl) = recorder.finish();
    let balls = mechanism.layout.balls;
    let none = ContactExtremes { max_load: vec![0.0; balls], angle: None, max_slip: 0.0, least_film: None };
    let turned = |time: f64| mechanism.speed.at(time).0;
    let (begin, _) = model.speed(start);
    let mean = if duration > 0.0 { (turned(start + duration) - turned(start)) / duration } else { begin };
    Recording {
        start,
        signals,
        whirl,
        total_variance: spindle_channels().into_iter().zip(total_variance.into_iter().flatten()).collect(),
        contacts: PerRaceway { inner: none.clone(), outer: none },
        max_pocket_load: 0.0,
        direction: if mean < 0.0 { -1.0 } else { 1.0 },
        shaft_speed: mean.abs(),
        cage_speed: (model.orbit_ratio() * mean).abs(),
        ball_spin: ((mechanism.spin_ratio - mechanism.orbit_ratio) * mean).abs(),
        parts: Vec::new(),
        loads: None,
        wander: None,
    }
}

/// A steady motion of the spindle: one ball passage, seen at equal times from azimuth 0 of a ball on.
#[derive(Debug, Clone)]
pub struct Passage {
    /// Time from one ball to the next [s].
    pub length: f64,
    pub orbit: PeriodicOrbit<4>,
    pub statistics: Statistics,
    signals: Signals,
}

/// One passage in a number of steps.
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

/// The steady motion of a scene, refused where it is not stable.
pub fn passage(scene: &Scene, settings: &RunSettings) -> Result<Passage, SimulationError> {
    let (model, _) = prepared(scene, settings, "periodic", unable_periodic)?;
    steady(&model)
}

fn grows(orbit: &PeriodicOrbit<4>) -> String {
    format!("its motion does not repeat with the balls: a disturbance grows by {:.3} in one passage", orbit.radius())
}

fn steady(model: &SpindleOnly) -> Result<Passage, SimulationError> {
    let (rest, frequency) = model.rest();
    if frequency == 0.0 {
        return Err(SimulationError::Unable {
            rung: "periodic",
            reason: "nothing holds the spindle: where it rests it touches no ball".into(),
        });
    }
    let speed = model.speed(0.0).0;
    let length = std::f64::consts::TAU / (model.balls() as f64 * (model.orbit_ratio() * speed).abs());
    let longest = LONGEST_SHOT.min(LONGEST_TURN_OF_SHOT / frequency);
    let coarse = ((length / longest).ceil() as usize).max(16);
    if coarse > MOST_STEPS_A_PASSAGE {
        let reason = format!("a ball passes every {length:.1e} s, which takes {coarse} steps of {longest:.1e} s");
        return Err(SimulationError::Unable { rung: "periodic", reason });
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
    let mut refusal = String::new();
    for passages in PASSAGES {
        state = (periods..passages).fold(state, |state, _| shoot(&state));
        periods = passages.max(periods);
        let mut orbit = match search.find(state, shoot) {
            Ok(orbit) if orbit.radius() < LARGEST_RADIUS => orbit,
            Ok(orbit) => {
                refusal = grows(&orbit);
                continue;
            }
            Err(error) => {
                refusal = error.to_string();
                continue;
            }
        };
        let mut steps = coarse;
        let mut signals = record(&orbit, steps);
        let mut evaluations = (orbit.periods + 1) * (steps as u64 + RESTART);
        let mut change = f64::INFINITY;
        for _ in 0..MOST_HALVINGS {
            steps *= 2;
            let Ok(finer) = search.refine(&orbit, |state| shot(state, steps, None)) else { break };
            let seen = record(&finer, steps);
            // Velocities and accelerations.
            change = (2..6).map(|i| (rms(&seen[i]) / rms(&signals[i]) - 1.0).abs()).fold(0.0, f64::max);
            evaluations += (finer.periods + 1) * (steps as u64 + RESTART);
            (orbit, signals) = (finer, seen);
            if change <= LEVEL_CHANGE {
                break;
            }
        }
        if change.is_nan() || change > LEVEL_CHANGE {
            refusal =
                format!("the motion that repeats with the balls depends on the steps: its levels by {change:.1e}");
            continue;
        }
        // Coarse steps may tell a stable orbit where there is none.
        let orbit = match search.measured(orbit, |state| shot(state, steps, None)) {
            Ok(orbit) => orbit,
            Err(error) => {
                refusal = error.to_string();
                continue;
            }
        };
        evaluations += (1 + orbit.state.len() as u64) * (steps as u64 + RESTART);
        if orbit.radius() >= LARGEST_RADIUS {
            refusal = grows(&orbit);
            continue;
        }
        // A stable orbit need not be the one that a run from rest finds: others may be stable beside it.
        let amplitude: [f64; 4] = std::array::from_fn(|i| peak(&signals[i]).max(1e-3 * search.sizes[i]));
        let away = |state: &[f64; 4]| {
            (0..4).map(|i| (state[i] - orbit.state[i]).abs() / amplitude[i]).fold(0.0, f64::max) > SETTLED
        };
        while away(&state) && periods < MOST_PASSAGES {
            state = shoot(&state);
            periods += 1;
        }
        if away(&state) {
            refusal = "a run from rest settles on another motion than the one that repeats with the balls".into();
            break;
        }
        evaluations += periods as u64 * (coarse as u64 + RESTART);
        let statistics = statistics(evaluations, evaluations, length / steps as f64);
        return Ok(Passage { length, orbit, statistics, signals });
    }
    Err(SimulationError::Unable { rung: "periodic", reason: refusal })
}

impl Passage {
    /// rms of each signal up to a frequency [Hz], mean removed: y, z of place, velocity, acceleration [SI].
    pub fn rms(&self, band: f64) -> [f64; 6] {
        let n = self.signals[0].len();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
        std::array::from_fn(|i| {
            let mut spectrum = transform.make_output_vec();
            let mut signal = self.signals[i].clone();
            // Cannot fail: both have the lengths that the plan was made for.
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

    /// Keeps so many values of the motion at `RATE`; `start`: time of the first one [s].
    fn repeated(
        &self,
        start: f64,
        values: usize,
        control: &Control<'_>,
        mut keep: impl FnMut(&[f64; 6]),
    ) -> Result<(), SimulationError> {
        let fine = self.finer();
        let n = fine[0].len();
        let per_value = n as f64 / (RATE * self.length);
        let first = start / self.length * n as f64;
        // Places and weights are the same for all signals: cubic polynomials through four of the fine points.
        let mut place = first.rem_euclid(n as f64);
        for value in 0..values {
            if value.is_multiple_of(VALUES_PER_LOOK) {
                if (control.stop)() {
                    return Err(SimulationError::Stopped { time: start + value as f64 / RATE });
                }
                (control.progress)(value as f64 / values as f64);
            }
            let whole = place as usize;
            let x = place - whole as f64;
            let (below, above, over) = (x + 1.0, 1.0 - x, 2.0 - x);
            let weights =
                [-x * above * over / 6.0, 0.5 * below * above * over, 0.5 * x * below * over, -x * below * above / 6.0];
            let at = [whole + n - 1, whole, whole + 1, whole + 2].map(|i| i % n);
            keep(&fine.each_ref().map(|fine| (0..4).map(|k| weights[k] * fine[at[k]]).sum()));
            place += per_value;
            if place >= n as f64 {
                place -= n as f64;
            }
        }
        Ok(())
    }

    /// Every signal at more points, by its Fourier series.
    fn finer(&self) -> Signals {
        let n = self.signals[0].len();
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, backward) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(FINER * n));
        std::array::from_fn(|i| {
            let (mut coarse, mut fine) = (forward.make_output_vec(), backward.make_output_vec());
            let mut signal = self.signals[i].clone();
            let mut padded = backward.make_input_vec();
            let _ = forward.process(&mut signal, &mut coarse);
            for (to, from) in padded.iter_mut().zip(&coarse) {
                *to = from / n as f64;
            }
            if n.is_multiple_of(2) {
                padded[n / 2] = Complex::new(0.5 * padded[n / 2].re, 0.0);
            }
            let _ = backward.process(&mut padded, &mut fine);
            fine
        })
    }
}

/// ModelLevel `periodic`: the steady motion, extended over the time asked for.
pub fn simulate_periodic(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let (model, mechanism) = prepared(scene, settings, "periodic", unable_periodic)?;
    if (control.stop)() {
        return Err(SimulationError::Stopped { time: 0.0 });
    }
    let passage = steady(&model)?;
    let values = kept_values(settings.duration);
    let mut recorder = Recorder::new(spindle_channels(), &settings.outputs, values);
    passage.repeated(settings.settle, values, control, |frame| recorder.push(frame))?;
    let total = std::array::from_fn(|i| rms(&passage.signals[i]).powi(2));
    let recording = recording(&model, &mechanism, settings.settle, settings.duration, recorder, Some(total));
    Ok((recording, passage.statistics))
}
