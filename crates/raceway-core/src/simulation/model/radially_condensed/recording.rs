//! What a run on this rung leaves behind: the same recording as that of the full dynamics.
//!
//! Where steps are shorter than the interval of the kept values, the spindle's signals pass the low-pass filter of
//! `numerics/spectrum.rs` on their way to it; where they are longer, values between steps come from `numerics/interpolation.rs`.

use super::looks::{Looks, SIGNALS};
use super::{RadiallyCondensed, Stepper};
use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Interpolator;
use crate::numerics::ode::{IntegrationError, Statistics};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::RATE;
use crate::simulation::recording::sampling::kept_values;

/// Steps between two looks at `Control`.
const STEPS_PER_LOOK: u64 = 256;
/// Largest product of the step with the rate at which the contacts at rest damp the spindle, and with its frequency on them.
const LARGEST_DECAY: f64 = 0.2;
const LARGEST_TURN: f64 = 0.4;
/// The latter of steps that are tried before they are taken.
const LARGEST_TURN_TRIED: f64 = 0.9;
/// Largest product of the step with the rate at which traction holds a ball: beyond, what its slope changes by from step to step
/// is too much.
const LARGEST_HOLD: f64 = 100.0;
/// Largest product of the step with the frequency of the cage on its film: beyond, that motion is damped by a decibel and more.
const LARGEST_FILM_TURN: f64 = 0.75;
/// The same of steps that are tried before they are taken, where nobody looks at that motion.
const LARGEST_FILM_TURN_TRIED: f64 = 1.0;
/// The longest step that is tried [s]: 19.5 µs. Longer ones hold, too, but gain little beside a check that takes ten times as long.
const LONGEST: f64 = 20e-6;
/// So many times as many steps are tried where the motion is lost.
const FINER: usize = 4;
/// A spindle or cage beyond this is lost [m, m/s].
const FARTHEST: f64 = 1.0;

/// Steps to a value beyond which the full dynamics are no slower.
pub const MOST_STEPS: usize = 64;

/// How long a step is: so many steps take as long as so many intervals of the kept values, 1/102 400 s. Either there is one interval,
/// or there are fewer steps than intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    pub steps: usize,
    pub values: usize,
}

impl Pace {
    /// Steps longer than an interval: 24.4, 22.0, 19.5, 17.1, 14.6 and 12.2 µs.
    pub const LONG: [Self; 6] =
        [Self::over(2, 5), Self::over(4, 9), Self::over(1, 2), Self::over(4, 7), Self::over(2, 3), Self::over(4, 5)];

    /// That many steps to a value: 9.8 µs, 4.9 µs, …
    pub const fn of_steps(steps: usize) -> Self {
        Self::over(steps, 1)
    }

    const fn over(steps: usize, values: usize) -> Self {
        Self { steps, values }
    }

    /// The longest step not longer than this [s].
    pub fn of(longest: f64) -> Self {
        // A hair's breadth: the step of a pace, taken for the longest one, is that pace.
        let longest = longest * (1.0 + 1e-9);
        let finer = || Self::of_steps((1.0 / (RATE * longest)).ceil().max(1.0) as usize);
        Self::LONG.into_iter().find(|pace| pace.step() <= longest).unwrap_or_else(finer)
    }

    /// [s]
    pub fn step(self) -> f64 {
        self.values as f64 / (RATE * self.steps as f64)
    }

    /// Whether kept values lie between steps.
    pub fn is_long(self) -> bool {
        self.values > 1
    }

    /// Steps by which the spindle's signals are known later than others.
    fn delay(self) -> usize {
        if self.is_long() { Interpolator::<SIGNALS>::DELAY } else { Decimator::new(self.steps, 1).delay() }
    }
}

/// When something is kept, in steps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    pub pace: Pace,
    /// Steps of the first and of the last kept value, and the number of values.
    pub first: u64,
    pub last: u64,
    pub values: usize,
    /// Steps by which the filter comes later.
    pub delay: usize,
}

/// Simulates a scene on this rung. Deterministic: the same arguments give the same bits.
pub fn simulate(
    scene: &Scene,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    run(&RadiallyCondensed::new(scene, &settings.outputs)?, settings, control)
}

/// The same with the spindle starting a little beside its equilibrium (y, z) [m], and nothing kept that is asked for as a
/// spectrum or a series.
pub fn simulate_beside(
    scene: &Scene,
    displacement: [f64; 2],
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let model = RadiallyCondensed::new(scene, &settings.outputs)?.displaced(displacement);
    let outputs = Outputs { spectra: Vec::new(), series: Vec::new(), ..settings.outputs.clone() };
    run(&model, &RunSettings { outputs, ..settings.clone() }, control)
}

fn run(
    model: &RadiallyCondensed,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<(Recording, Statistics), SimulationError> {
    let mut pace = model.pace_for(settings);
    loop {
        if pace.steps > MOST_STEPS {
            let reason =
                format!("spindle, cage or traction are too quick for it: they need steps of {:.1e} s", pace.step());
            return Err(SimulationError::Unable { rung: "radially_condensed", reason });
        }
        match model.run(settings, pace, control) {
            // What comes later in a run, such as balls thrown against their walls by a changing speed, is not foreseen. Where another
            // rung can follow, it is the quicker way out.
            Err(SimulationError::Integration { .. }) if settings.rung.is_some() && settings.fixed_step.is_none() => {
                pace = Pace::of_steps(FINER * pace.steps);
            }
            ended => return ended,
        }
    }
}

impl RadiallyCondensed {
    /// Longest steps that serve: a film holds the balls in their pockets gently, walls do not; the spindle on its loaded
    /// contacts, the cage on a stiff film and steep traction bound them.
    pub fn pace(&self) -> Pace {
        let stable = (self.fastest(LARGEST_TURN, LARGEST_FILM_TURN) / RATE).ceil().max(1.0) as usize;
        Pace::of_steps(stable.max(if self.is_gentle() { 1 } else { 4 }))
    }

    /// The steps of a run.
    pub fn pace_for(&self, settings: &RunSettings) -> Pace {
        settings.fixed_step.map_or(self.pace(), Pace::of)
    }

    /// Finer steps than those of a run: its own where it took longer ones, else half of them; `None`: they would be too many.
    pub fn finer_pace(&self, settings: &RunSettings) -> Option<Pace> {
        let (own, taken) = (self.pace(), self.pace_for(settings));
        let finer = if taken.is_long() && !own.is_long() { own } else { Pace::of_steps(2 * taken.steps) };
        (finer.steps <= MOST_STEPS).then_some(finer)
    }

    /// Longer steps that may serve, the longest first: what they do to the levels has to be tried.
    pub fn longer_paces(&self) -> impl Iterator<Item = Pace> {
        let film_turn = if self.shows_cage { LARGEST_FILM_TURN } else { LARGEST_FILM_TURN_TRIED };
        let longest =
            if self.is_gentle() { LONGEST.min(1.0 / self.fastest(LARGEST_TURN_TRIED, film_turn)) } else { 0.0 };
        Pace::LONG.into_iter().filter(move |pace| pace.step() <= longest)
    }

    /// Whether nothing but films acts in the pockets, as long as balls stay off their walls.
    fn is_gentle(&self) -> bool {
        !self.mechanism().layout.cage || self.pockets_are_damped()
    }

    /// 1 over the longest step that damping and traction bear, the spindle turning by so much in it on its contacts and the cage on its
    /// film [1/s].
    fn fastest(&self, turn: f64, film_turn: f64) -> f64 {
        let on_film = if self.mechanism().layout.cage { self.film_frequency() } else { 0.0 };
        (self.spindle_rates[0] / LARGEST_DECAY)
            .max(self.spindle_rates[1] / turn)
            .max(on_film / film_turn)
            .max(self.traction_rate / LARGEST_HOLD)
    }

    /// Runs from equilibrium through settling and kept time.
    pub fn run(
        &self,
        settings: &RunSettings,
        pace: Pace,
        control: &Control<'_>,
    ) -> Result<(Recording, Statistics), SimulationError> {
        let step = pace.step();
        let values = kept_values(settings.duration);
        // The first kept value falls on a step: the part of a step before that is a short start.
        let before = (settings.settle / step).floor();
        let offset = settings.settle - before * step;
        let (balls, border) = self.start();
        let mut stepper = Stepper::new(self, offset, balls, border, step);
        let first = (before as u64).max(stepper.steps());
        let last = first + ((values - 1) * pace.steps).div_ceil(pace.values) as u64;
        let delay = pace.delay();
        let schedule = Schedule { pace, first, last, values, delay };
        // A run without time to settle has no past for the filter: it starts from a standstill then.
        let primed = first < stepper.steps() + delay as u64;
        let mut looks = Looks::new(self, &settings.outputs, schedule, primed);
        let all = last + delay as u64 + 1;
        while stepper.steps() < all {
            if (control.stop)() {
                return Err(SimulationError::Stopped { time: stepper.time() });
            }
            stepper.advance(STEPS_PER_LOOK.min(all - stepper.steps()), &mut looks);
            finite(&stepper)?;
            (control.progress)(stepper.steps() as f64 / all as f64);
            let phase = if stepper.steps() < first { Phase::Settling } else { Phase::Recording };
            (control.live)(&Live { phase, accelerations: &|| looks.accelerations() });
        }
        let statistics = Statistics {
            steps: stepper.steps(),
            rhs_evaluations: stepper.evaluations(),
            least_step: step,
            advanced: stepper.time() - offset,
            ..Statistics::default()
        };
        Ok((looks.finish(settings.settle), statistics))
    }
}

fn finite(stepper: &Stepper<'_>) -> Result<(), SimulationError> {
    let border = stepper.border();
    let moved = border.spindle.iter().chain(&border.spindle_velocity).chain(&border.cage);
    if moved.into_iter().any(|x| x.is_nan() || x.abs() > FARTHEST) {
        let source = IntegrationError::NotFinite { time: stepper.time(), step: stepper.step_length(), component: 0 };
        return Err(SimulationError::Integration { source, entry: "spindle or cage, radially condensed".into() });
    }
    Ok(())
}
