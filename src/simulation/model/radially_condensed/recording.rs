//! What a run on this rung leaves behind: the same recording as that of the full dynamics.
//!
//! Steps divide the interval of the kept values, so that nothing is interpolated; the spindle's signals pass the low-pass
//! filter of `numerics/spectrum.rs` on their way from the rate of the steps to that of the kept values.

use super::{Lane, RadiallyCondensed, Seen, Stepper, WIDTH};
use crate::numerics::ode::{IntegrationError, Statistics};
use crate::numerics::spectrum::Decimator;
use crate::physics::bearing::PerRaceway;
use crate::physics::raceway::{RacewayLoad, RelativeMotion};
use crate::simulation::channel::{Axis, BallContact, Channel, Motion};
use crate::simulation::observe::{ContactExtremes, RATE, Recording, kept_values};
use crate::simulation::run::{Control, RunSettings, SimulationError};
use crate::simulation::scene::Scene;

/// Steps between two looks at `Control`.
const STEPS_PER_LOOK: u64 = 256;
/// Largest product of the step with the rate at which the contacts at rest damp the spindle, and with its frequency on them.
const LARGEST_DECAY: f64 = 0.2;
const LARGEST_TURN: f64 = 0.4;
/// A spindle or cage beyond this is lost [m, m/s].
const FARTHEST: f64 = 1.0;
/// Spindle signals that pass the filter.
const FILTERED: usize = 6;

/// How long a step is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Steps to an interval of the kept values, 1/102 400 s: 1 gives 9.8 µs, 2 gives 4.9 µs, 4 gives 2.4 µs.
    pub steps_per_value: usize,
}

impl Pace {
    /// The longest step not longer than this [s].
    pub fn of(longest: f64) -> Self {
        Self { steps_per_value: (1.0 / (RATE * longest)).ceil().max(1.0) as usize }
    }

    /// [s]
    pub fn step(self) -> f64 {
        1.0 / (RATE * self.steps_per_value as f64)
    }
}

/// Simulates a scene on this rung. Deterministic: the same arguments give the same bits.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let model = RadiallyCondensed::new(scene, &settings.outputs)?;
    let pace = settings.fixed_step.map_or(model.pace(), Pace::of);
    model.run(settings, pace, control)
}

impl RadiallyCondensed {
    /// Longest steps that serve: a film holds the balls in their pockets gently, walls do not; and the spindle on its loaded
    /// contacts is advanced explicitly.
    pub fn pace(&self) -> Pace {
        let gentle = !self.mechanism().layout.cage || self.pockets_are_damped();
        let fastest = (self.spindle_rates[0] / LARGEST_DECAY).max(self.spindle_rates[1] / LARGEST_TURN);
        let stable = (fastest / RATE).ceil().max(1.0) as usize;
        Pace { steps_per_value: stable.max(if gentle { 1 } else { 4 }) }
    }

    /// Runs from equilibrium through settling and kept time.
    pub fn run(
        &self,
        settings: &RunSettings,
        pace: Pace,
        control: &Control<'_>,
    ) -> Result<(Recording, Statistics), SimulationError> {
        let run = Run { model: self, settings, pace, control };
        run.run()
    }
}

type Outcome = Result<(Recording, Statistics), SimulationError>;

struct Run<'a> {
    model: &'a RadiallyCondensed,
    settings: &'a RunSettings,
    pace: Pace,
    control: &'a Control<'a>,
}

/// Largest values so far, group by group.
struct Extremes {
    load: Vec<PerRaceway<Lane>>,
    slip: PerRaceway<Lane>,
    pocket: Lane,
}

#[inline(always)]
fn grow(largest: &mut Lane, seen: &Lane) {
    for k in 0..WIDTH {
        largest.0[k] = if seen.0[k] > largest.0[k] { seen.0[k] } else { largest.0[k] };
    }
}

impl Extremes {
    #[inline(always)]
    fn look(&mut self, group: usize, seen: &Seen) {
        grow(&mut self.load[group].inner, &seen.load.inner);
        grow(&mut self.load[group].outer, &seen.load.outer);
        grow(&mut self.pocket, &seen.pocket);
        let slip = |slip: &Lane, load: &Lane| {
            Lane(std::array::from_fn(|k| if load.0[k] > 0.0 { slip.0[k].abs() } else { 0.0 }))
        };
        grow(&mut self.slip.inner, &slip(&seen.slip.inner, &seen.load.inner));
        grow(&mut self.slip.outer, &slip(&seen.slip.outer, &seen.load.outer));
    }
}

impl Run<'_> {
    fn run(&self) -> Outcome {
        let (model, settings) = (self.model, self.settings);
        let m = model.mechanism();
        let factor = self.pace.steps_per_value;
        let step = self.pace.step();
        let values = kept_values(settings.duration);
        let mut decimator = Decimator::new(factor, FILTERED);
        let delay = decimator.delay();
        let axes = [Axis::Y, Axis::Z];
        let channels = axes.map(|axis| {
            [Motion::Displacement, Motion::Velocity, Motion::Acceleration].map(|motion| Channel::Spindle(axis, motion))
        });
        let channels: Vec<Channel> = channels.into_iter().flatten().collect();
        let mut filtered: Vec<Vec<f64>> = (0..FILTERED).map(|_| Vec::with_capacity(values)).collect();
        let mut picked: Vec<(Channel, Vec<f64>)> =
            self.picked().into_iter().map(|channel| (channel, Vec::with_capacity(values))).collect();

        // The first kept value falls on a step: the part of a step before that is a short start.
        let before = (settings.settle / step).floor();
        let offset = settings.settle - before * step;
        let (balls, border) = model.start();
        let mut stepper = Stepper::new(model, offset, balls, border, step);
        let first = (before as u64).max(stepper.steps());
        let primed = first < stepper.steps() + delay as u64;
        let last = first + ((values - 1) * factor + delay) as u64;
        let kept = first..=first + ((values - 1) * factor) as u64;
        let mut sums = [[0.0; 2]; FILTERED];
        let mut origin = [0.0; FILTERED];
        let (mut shaft, mut cage, mut spin, mut looks) = (0.0, 0.0, 0.0, 0.0);
        let wants_extremes = settings.outputs.contacts || settings.outputs.cage;
        let mut extremes = Extremes {
            load: vec![PerRaceway::default(); model.groups()],
            slip: PerRaceway::default(),
            pocket: Lane::default(),
        };
        let mut least_film = PerRaceway { inner: f64::INFINITY, outer: f64::INFINITY };
        let balls_count = m.layout.balls as f64;
        loop {
            let now = stepper.steps();
            let counts = kept.contains(&now);
            let keeps = counts && (now - first).is_multiple_of(factor as u64);
            stepper.rate();
            if counts && wants_extremes {
                stepper.seen().iter().enumerate().for_each(|(group, seen)| extremes.look(group, seen));
            }
            if now + delay as u64 >= first || primed {
                let border = stepper.border();
                let acceleration = stepper.spindle_acceleration();
                let frame = [
                    border.spindle[0],
                    border.spindle_velocity[0],
                    acceleration[0],
                    border.spindle[1],
                    border.spindle_velocity[1],
                    acceleration[1],
                ];
                if now == first {
                    origin = frame;
                    if primed {
                        decimator = Decimator::new(factor, FILTERED);
                        decimator.prime(&frame);
                    }
                }
                if counts {
                    for (sum, (value, origin)) in sums.iter_mut().zip(frame.iter().zip(&origin)) {
                        let off = value - origin;
                        sum[0] += off;
                        sum[1] += off * off;
                    }
                }
                if (!primed || now >= first)
                    && let Some(frame) = decimator.push(&frame)
                {
                    for (signal, value) in filtered.iter_mut().zip(frame) {
                        if signal.len() < values {
                            signal.push(*value);
                        }
                    }
                }
            }
            if keeps {
                let (_, speed, _) = m.speed.at(stepper.time());
                let (mut arc_velocity, mut own) = (0.0, 0.0);
                for ball in 0..m.layout.balls {
                    let balls = &stepper.balls()[ball / WIDTH];
                    arc_velocity += balls.arc_velocity.0[ball % WIDTH] / balls_count;
                    own += balls.spin.0[ball % WIDTH] / balls_count;
                }
                let cage_velocity = if m.layout.cage { stepper.border().cage_velocity[2] } else { arc_velocity };
                shaft += speed;
                cage += m.orbit_ratio * speed + cage_velocity / m.pitch_radius;
                spin += (m.spin_ratio - m.orbit_ratio) * speed + own - arc_velocity / m.pitch_radius;
                looks += 1.0;
                for (channel, signal) in &mut picked {
                    signal.push(self.value(*channel, &stepper, speed));
                }
                if model.needs().film_thickness {
                    self.films(&stepper, speed, &mut least_film);
                }
            }
            if now >= last {
                break;
            }
            stepper.advance();
            if now.is_multiple_of(STEPS_PER_LOOK) {
                self.look(&stepper, last)?;
            }
        }
        self.finite(&stepper)?;
        let count = ((values - 1) * factor + 1) as f64;
        let total_variance = channels
            .iter()
            .zip(&sums)
            .map(|(channel, [sum, squares])| (*channel, ((squares - sum * sum / count) / count).max(0.0)))
            .collect();
        let shaft_mean = shaft / looks;
        let statistics = Statistics {
            steps: stepper.steps(),
            rhs_evaluations: stepper.evaluations(),
            least_step: step,
            advanced: stepper.time() - offset,
            ..Statistics::default()
        };
        let recording = Recording {
            start: settings.settle,
            signals: channels.into_iter().zip(filtered).chain(picked).collect(),
            total_variance,
            contacts: self.contacts(&extremes, least_film),
            max_pocket_load: extremes.pocket.0.into_iter().fold(0.0, f64::max),
            direction: if shaft_mean < 0.0 { -1.0 } else { 1.0 },
            shaft_speed: shaft_mean.abs(),
            cage_speed: (cage / looks).abs(),
            ball_spin: (spin / looks).abs(),
            compared: Vec::new(),
        };
        Ok((recording, statistics))
    }

    /// Channels besides the spindle's.
    fn picked(&self) -> Vec<Channel> {
        let outputs = &self.settings.outputs;
        let orbit = [Channel::CageDisplacement(Axis::Y), Channel::CageDisplacement(Axis::Z)];
        let with_cage = outputs.cage && self.model.mechanism().layout.cage;
        let mut picked: Vec<Channel> = if with_cage { orbit.to_vec() } else { Vec::new() };
        for &channel in outputs.spectra.iter().chain(&outputs.series) {
            if !matches!(channel, Channel::Spindle(..)) && !picked.contains(&channel) {
                picked.push(channel);
            }
        }
        picked
    }

    fn value(&self, channel: Channel, stepper: &Stepper<'_>, speed: f64) -> f64 {
        let m = self.model.mechanism();
        let border = stepper.border();
        match channel {
            Channel::Spindle(..) | Channel::CageDisplacement(Axis::X) => 0.0,
            Channel::CageDisplacement(Axis::Y) => border.cage[0],
            Channel::CageDisplacement(Axis::Z) => border.cage[1],
            Channel::CageSpeed => m.orbit_ratio * speed + border.cage_velocity[2] / m.pitch_radius,
            Channel::BallSpin(ball) => {
                let (balls, k) = (&stepper.balls()[ball / WIDTH], ball % WIDTH);
                let orbit = m.orbit_ratio * speed + balls.arc_velocity.0[k] / m.pitch_radius;
                m.spin_ratio * speed + balls.spin.0[k] - orbit
            }
            Channel::BallLoad(ball, contact) => {
                let (seen, k) = (&stepper.seen()[ball / WIDTH], ball % WIDTH);
                match contact {
                    BallContact::Inner => seen.load.inner.0[k],
                    BallContact::Outer => seen.load.outer.0[k],
                    BallContact::Pocket => seen.pocket.0[k],
                }
            }
        }
    }

    /// Least minimum film thickness under load, looked for at the kept values.
    #[inline(never)]
    fn films(&self, stepper: &Stepper<'_>, speed: f64, least: &mut PerRaceway<f64>) {
        let m = self.model.mechanism();
        for ball in 0..m.layout.balls {
            let (balls, k) = (&stepper.balls()[ball / WIDTH], ball % WIDTH);
            let orbit = m.orbit_ratio * speed + balls.arc_velocity.0[k] / m.pitch_radius;
            let spin = [m.spin_ratio * speed + balls.spin.0[k], 0.0, 0.0];
            let seen = &stepper.seen()[ball / WIDTH];
            let at = |radius: f64, raceway_speed: f64| RelativeMotion {
                axial: 0.0,
                radius,
                velocity: [0.0, 0.0, m.pitch_radius * orbit],
                spin,
                raceway_speed,
                orbit_speed: orbit,
                azimuth: 0.0,
            };
            let film = |contact: &crate::physics::raceway::RacewayContact, motion: RelativeMotion, normal: f64| {
                let load = RacewayLoad { normal, ..RacewayLoad::default() };
                if normal > 0.0 { contact.minimum_film(&motion, &load) } else { f64::INFINITY }
            };
            least.inner = least.inner.min(film(&m.raceway.inner, at(m.pitch_radius, speed), seen.load.inner.0[k]));
            least.outer = least.outer.min(film(&m.raceway.outer, at(m.pitch_radius, 0.0), seen.load.outer.0[k]));
        }
    }

    fn contacts(&self, extremes: &Extremes, least_film: PerRaceway<f64>) -> PerRaceway<ContactExtremes> {
        let m = self.model.mechanism();
        let one = |load: &dyn Fn(&PerRaceway<Lane>) -> Lane, slip: &Lane, film: f64| {
            let max_load: Vec<f64> =
                (0..m.layout.balls).map(|ball| load(&extremes.load[ball / WIDTH]).0[ball % WIDTH]).collect();
            let touched = max_load.iter().any(|load| *load > 0.0);
            ContactExtremes {
                max_load,
                angle: touched.then_some((0.0, 0.0)),
                max_slip: slip.0.iter().copied().fold(0.0, f64::max),
                least_film: film.is_finite().then_some(film),
            }
        };
        PerRaceway {
            inner: one(&|load| load.inner, &extremes.slip.inner, least_film.inner),
            outer: one(&|load| load.outer, &extremes.slip.outer, least_film.outer),
        }
    }

    #[inline(never)]
    fn look(&self, stepper: &Stepper<'_>, last: u64) -> Result<(), SimulationError> {
        if (self.control.stop)() {
            return Err(SimulationError::Stopped { time: stepper.time() });
        }
        self.finite(stepper)?;
        (self.control.progress)(stepper.steps() as f64 / last as f64);
        Ok(())
    }

    fn finite(&self, stepper: &Stepper<'_>) -> Result<(), SimulationError> {
        let border = stepper.border();
        let away = border
            .spindle
            .iter()
            .chain(&border.spindle_velocity)
            .chain(&border.cage)
            .any(|x| x.is_nan() || x.abs() > FARTHEST);
        if away {
            let source = IntegrationError::NotFinite { time: stepper.time(), step: self.pace.step(), component: 0 };
            return Err(SimulationError::Integration { source, entry: "spindle or cage, radially condensed".into() });
        }
        Ok(())
    }
}
