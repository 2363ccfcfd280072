//! Longest steps with which the radially condensed model stays stable and accurate.

use super::equations::RadiallyCondensed;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::step_ratio::{MAX_STEPS_PER_VALUE, StepRatio};
use crate::simulation::recording::sampling::RATE;

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
impl RadiallyCondensed {
    /// Longest steps that serve: a film holds the balls in their pockets gently, walls do not; the spindle on its loaded
    /// contacts, the cage on a stiff film and steep traction bound them.
    pub fn step_ratio(&self) -> StepRatio {
        let stable = (self.fastest(LARGEST_TURN, LARGEST_FILM_TURN) / RATE).ceil().max(1.0) as usize;
        StepRatio::of_steps(stable.max(if self.is_gentle() { 1 } else { 4 }))
    }

    /// The steps of a run.
    pub fn step_ratio_for(&self, settings: &RunSettings) -> StepRatio {
        settings.fixed_step.map_or(self.step_ratio(), StepRatio::of)
    }

    /// Finer steps than those of a run: its own where it took longer ones, else half of them; `None`: they would be too many.
    pub fn finer_step_ratio(&self, settings: &RunSettings) -> Option<StepRatio> {
        let (own, taken) = (self.step_ratio(), self.step_ratio_for(settings));
        let finer = if taken.is_long() && !own.is_long() { own } else { StepRatio::of_steps(2 * taken.steps) };
        (finer.steps <= MAX_STEPS_PER_VALUE).then_some(finer)
    }

    /// Longer steps that may serve, the longest first: what they do to the levels has to be tried.
    pub fn longer_step_ratios(&self) -> impl Iterator<Item = StepRatio> {
        let film_turn = if self.shows_cage { LARGEST_FILM_TURN } else { LARGEST_FILM_TURN_TRIED };
        let longest =
            if self.is_gentle() { LONGEST.min(1.0 / self.fastest(LARGEST_TURN_TRIED, film_turn)) } else { 0.0 };
        StepRatio::LONG.into_iter().filter(move |ratio| ratio.step() <= longest)
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
}
