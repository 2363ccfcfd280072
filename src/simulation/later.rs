//! What the levels of another stretch of time may differ by: as the kept time tells by how they go up and down along it, and, where they do,
//! as a later stretch shows, for what beats more slowly than the kept time does not show in it.

use super::accuracy;
use super::control::{Control, Live, Phase};
use super::distance::{Distance, LevelErrors};
use super::integration::{SimulationError, Stepping};
use super::run::{Attempt, Setup};
use super::settings::{Outputs, RunSettings};
use super::settling::Beginning;

/// Scatter of a level along the kept time from which on a later stretch is looked at [dB]: of motion that repeats itself it is less.
const UNEVEN: f64 = 0.1;
/// Kept time that is long beside what beats [s]: its own parts tell.
const LONG: f64 = 2.0;
/// Time between the kept stretch and the later one, in kept times, and at least [s]: next to it a slow beat is the same still.
const BETWEEN: f64 = 1.0;
const LEAST_BETWEEN: f64 = accuracy::REPEATED;
/// The later stretch may take so many times the evaluations of the run.
const MOST: u64 = 4;

/// Time that a later stretch and what lies between take after a kept one [s], at most.
pub fn most_time(kept: f64) -> f64 {
    if kept < LONG { between(kept) + kept } else { 0.0 }
}

fn between(kept: f64) -> f64 {
    f64::max(BETWEEN * kept, LEAST_BETWEEN)
}

/// Scatter of the levels of a run, at constant speed.
pub(super) fn scatter(setup: &Setup<'_>, run: &Attempt, control: &Control<'_>) -> Result<LevelErrors, SimulationError> {
    let own = accuracy::scatter(&run.recording);
    let kept = setup.settings.duration;
    // What is too short to tell by itself is held against another in any case.
    let is_even = kept >= accuracy::REPEATED && own.worst().is_none_or(|scatter| scatter < UNEVEN);
    if kept >= LONG || is_even {
        return Ok(own);
    }
    (control.live)(&Live::of(Phase::Judging));
    match stretch(setup, run, &control.aside()) {
        Ok(later) => Ok(own.larger(Distance::of_runs(&run.recording, &later.recording).levels)),
        Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
        // What the kept time tells has to do.
        Err(_) => Ok(own),
    }
}

/// The motion of a run goes on, and as much is kept again later.
fn stretch(setup: &Setup<'_>, run: &Attempt, control: &Control<'_>) -> Result<Attempt, SimulationError> {
    let kept = setup.settings;
    let end = kept.settle + kept.duration;
    let settings = RunSettings {
        settle: end + between(kept.duration),
        outputs: Outputs {
            contacts: false,
            cage: false,
            spectra: Vec::new(),
            series: Vec::new(),
            ..kept.outputs.clone()
        },
        ..kept.clone()
    };
    let beginning = Beginning { time: end, state: run.integrated.end.clone(), ..setup.beginning.clone() };
    let stepping = Stepping {
        relative_tolerance: run.relative_tolerance,
        most_evaluations: Some(MOST * run.integrated.statistics.rhs_evaluations.max(accuracy::LEAST_EVALUATIONS)),
        ..Stepping::of(kept)
    };
    Setup { settings: &settings, beginning: &beginning, ..*setup }.attempt(&stepping, (0.0, 1.0), control)
}
