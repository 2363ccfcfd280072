//! What the levels of another stretch of time may differ by: as the kept time tells by how they go up and down along it, and, where they do,
//! as a later stretch shows, for what beats more slowly than the kept time does not show in it.

use crate::numerics::statistics::mean;
use crate::simulation::error::comparison::{Distance, LevelErrors, in_parts, level_difference, rms_about_zero};
use crate::simulation::error::estimate;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::BATCHES;
use crate::simulation::recording::sampling::REPEATED;
use crate::simulation::solve::run::{Attempt, Setup};
use crate::simulation::solve::startup::Beginning;

/// Scatter of a level along the kept time from which on a later stretch is looked at [dB]: of motion that repeats itself it is less.
const UNEVEN: f64 = 0.1;
/// Kept time that is long beside what beats [s]: its own parts tell.
const LONG: f64 = 2.0;
/// Time between the kept stretch and the later one, in kept times, and at least [s]: next to it a slow beat is the same still.
const BETWEEN: f64 = 1.0;
const LEAST_BETWEEN: f64 = REPEATED;
/// The later stretch may take so many times the evaluations of the run.
const MOST: u64 = 4;

/// Kept time on a reduced rung up to which as many later stretches are looked at as tell well by how much they differ [s].
const QUICK: f64 = 0.5;

/// Time that a later stretch and what lies between take after a kept one [s], at most.
pub fn most_time(kept: f64) -> f64 {
    if kept < LONG { between(kept) + as_long_as(kept, is_short(kept)) } else { 0.0 }
}

/// Whether the kept time [s] is too short for its own parts to tell anything.
fn is_short(kept: f64) -> bool {
    kept < REPEATED
}

/// Time that is kept later [s], `many`: of as many stretches as there are batches, for one alone may be the same by luck.
fn as_long_as(kept: f64, many: bool) -> f64 {
    if many { BATCHES as f64 * kept } else { kept }
}

fn between(kept: f64) -> f64 {
    f64::max(BETWEEN * kept, LEAST_BETWEEN)
}

/// What the levels of other stretches differ by from those of the kept one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stretches {
    /// One standard deviation [dB].
    pub scatter: LevelErrors,
    /// Of a later one [dB], where one was looked at.
    pub later: Option<LevelErrors>,
    /// Why there is none, where one should have been.
    pub failure: Option<String>,
}

/// Of a run at constant speed on a rung. `later`: keeps the motion of this run by other settings, those of a later stretch. Where many are
/// looked at, they alone tell: of motion that repeats itself parts of the kept time tell too much, for they need not hold whole periods.
pub(crate) fn stretches(
    rung: ModelLevel,
    kept: &Recording,
    settings: &RunSettings,
    later: impl FnOnce(&RunSettings) -> Result<Recording, SimulationError>,
) -> Result<Stretches, SimulationError> {
    let own = Stretches { scatter: estimate::scatter(kept), ..Stretches::default() };
    // What is too short to tell by itself is held against others in any case.
    let is_short = is_short(settings.duration);
    let many = is_short || (rung.is_reduced() && settings.duration <= QUICK);
    let is_even = !is_short && own.scatter.worst().is_none_or(|scatter| scatter < UNEVEN);
    if settings.duration >= LONG || is_even {
        return Ok(own);
    }
    match later(&later_settings(settings, many)) {
        Ok(later) if many => {
            let apart = apart_from_parts(kept, &later);
            Ok(Stretches { scatter: apart, later: Some(apart), failure: None })
        }
        Ok(later) => {
            let apart = Distance::of_runs(kept, &later).levels;
            Ok(Stretches { scatter: own.scatter.larger(apart), later: Some(apart), failure: None })
        }
        Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
        // What the kept time tells has to do.
        Err(error) => Ok(Stretches { failure: Some(error.to_string()), ..own }),
    }
}

/// What a later stretch, or many, keep, and when.
fn later_settings(kept: &RunSettings, many: bool) -> RunSettings {
    let nothing_else =
        Outputs { contacts: false, cage: false, spectra: Vec::new(), series: Vec::new(), ..kept.outputs.clone() };
    RunSettings {
        settle: kept.settle + kept.duration + between(kept.duration),
        duration: as_long_as(kept.duration, many),
        outputs: nothing_else,
        ..kept.clone()
    }
}

/// A later stretch of a run of the dynamics, whose motion goes on from where it has ended.
pub(crate) fn of_dynamics(
    setup: &Setup<'_>,
    run: &Attempt,
    settings: &RunSettings,
    control: &Control<'_>,
) -> Result<Recording, SimulationError> {
    let kept = setup.settings;
    let beginning =
        Beginning { time: kept.settle + kept.duration, state: run.integrated.end.clone(), ..setup.beginning.clone() };
    let stepping = Stepping {
        relative_tolerance: run.relative_tolerance,
        most_evaluations: Some(MOST * run.integrated.statistics.rhs_evaluations.max(estimate::LEAST_EVALUATIONS)),
        ..Stepping::of(kept)
    };
    (control.live)(&Live::of(Phase::Judging));
    let later = Setup { settings, beginning: &beginning, ..*setup };
    Ok(later.attempt(&stepping, (0.0, 1.0), &control.aside())?.recording)
}

/// What the levels of equal parts of a recording, each as long as the kept one, differ by from those of that, rms [dB].
fn apart_from_parts(kept: &Recording, later: &Recording) -> LevelErrors {
    let parts = |recording: &Recording, channel| {
        recording.of(channel).map(|signal| in_parts(&signal.in_band().mean_squares, BATCHES))
    };
    LevelErrors::each(|channel| {
        let level = mean(&parts(kept, channel)?).sqrt();
        let apart = |part: &f64| level_difference((part.sqrt(), level));
        let differences: Vec<f64> = parts(later, channel)?.iter().filter_map(apart).collect();
        (!differences.is_empty()).then(|| rms_about_zero(&differences))
    })
}
