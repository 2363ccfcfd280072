//! Longest steps with which the radially condensed model stays stable and accurate.

use super::equations::RadiallyCondensed;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::step_ratio::{MAX_STEPS_PER_VALUE, StepRatio};
use crate::simulation::recording::sampling::RATE;

/// Largest product of the step with the damping rate of the spindle on its contacts at rest [-].
const MAX_DECAY: f64 = 0.2;
/// Largest product of the step with the frequency of the spindle on its contacts at rest [rad].
const MAX_PHASE: f64 = 0.4;
/// That phase for longer steps, which a run has to verify [rad].
const MAX_PHASE_VERIFIED: f64 = 0.9;
/// Largest product of the step with the traction rate of a ball [-]: beyond it, the slope of traction changes too much between steps.
const MAX_TRACTION_DECAY: f64 = 100.0;
/// Largest product of the step with the frequency of the cage on its film [rad]: beyond it, the steps damp that motion by a decibel or more.
const MAX_FILM_PHASE: f64 = 0.75;
/// That phase for longer steps, which a run has to verify, where no output shows the motion of the cage [rad].
const MAX_FILM_PHASE_VERIFIED: f64 = 1.0;
/// The longest step to verify [s]: 19.5 µs. Longer steps are stable, too, but gain little next to a verification that takes ten times as
/// long.
const MAX_STEP: f64 = 20e-6;
/// Longest step at the motion of a ring [s]: twice that of the full dynamics. Half steps verify it.
const LONGEST_ON_RING: f64 = 11e-6;

impl RadiallyCondensed {
    /// Longest steps that are stable and accurate. The spindle on its loaded contacts, the cage on a stiff film, steep traction and waves of
    /// the raceways bound them. Pocket walls need shorter steps than films.
    pub fn step_ratio(&self) -> StepRatio {
        let stable = (self.fastest(MAX_PHASE, MAX_FILM_PHASE) / RATE).ceil().max(1.0) as usize;
        StepRatio::of_steps(stable.max(if self.is_gentle() { 1 } else { 4 }))
    }

    /// The steps of a run.
    pub fn step_ratio_for(&self, settings: &RunSettings) -> StepRatio {
        settings.fixed_step.map_or(self.step_ratio(), StepRatio::of)
    }

    /// Finer steps than those of a run: `step_ratio` where the run took longer ones, else half of its steps; `None` where they would be too
    /// many.
    pub(crate) fn finer_step_ratio(&self, settings: &RunSettings) -> Option<StepRatio> {
        let (own, taken) = (self.step_ratio(), self.step_ratio_for(settings));
        let finer = if taken.is_long() && !own.is_long() { own } else { StepRatio::of_steps(2 * taken.steps) };
        (finer.steps <= MAX_STEPS_PER_VALUE).then_some(finer)
    }

    /// Longer steps that may be accurate, the longest first. Their effect on the levels has to be verified.
    pub fn longer_step_ratios(&self) -> impl Iterator<Item = StepRatio> {
        let film_turn = if self.shows_cage { MAX_FILM_PHASE } else { MAX_FILM_PHASE_VERIFIED };
        let longest =
            if self.is_gentle() { MAX_STEP.min(1.0 / self.fastest(MAX_PHASE_VERIFIED, film_turn)) } else { 0.0 };
        StepRatio::LONG.into_iter().filter(move |ratio| ratio.step() <= longest)
    }

    /// Returns whether only films act in the pockets, as long as balls stay off the walls.
    fn is_gentle(&self) -> bool {
        !self.mechanism().layout.cage || self.pockets_are_damped()
    }

    /// Reciprocal of the longest step that damping, traction, waves and loads allow [1/s], with given largest phases of the spindle on its contacts and of
    /// the cage on its film [rad].
    fn fastest(&self, turn: f64, film_turn: f64) -> f64 {
        (self.spindle_rates[0] / MAX_DECAY).max(self.spindle_rates[1] / turn).max(self.fastest_of_balls(film_turn))
    }

    fn fastest_of_balls(&self, film_turn: f64) -> f64 {
        let on_film = if self.mechanism().layout.cage { self.film_frequency() } else { 0.0 };
        (on_film / film_turn)
            .max(self.traction_rate / MAX_TRACTION_DECAY)
            .max(1.0 / self.mechanism().longest_excited_step())
            .max(1.0 / self.mechanism().defect_step)
    }

    /// Longest step of balls and cage where others move the ring [s].
    pub(crate) fn longest_step_on_ring(&self) -> f64 {
        let longest = if self.is_gentle() { LONGEST_ON_RING } else { StepRatio::of_steps(4).step() };
        longest.min(1.0 / self.fastest_of_balls(MAX_FILM_PHASE))
    }
}
