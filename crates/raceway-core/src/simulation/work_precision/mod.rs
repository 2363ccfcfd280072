//! Error against run time: one scene run by several methods at several tolerances, each compared with a reference whose
//! own error is known.
//!
//! All runs start from the same state, in which the scene has settled, and are looked at alike. What is timed is the
//! integration, the looks at the motion that any run takes, and the interpolation to the output grid; not the
//! equilibrium, the settling, the reference, the spectra and the comparison. One thread; evaluations are bounded.

mod course;
mod errors;

use crate::simulation::recording::sampling::ACCELERATIONS;
use std::cell::Cell;

use crate::numerics::ode::Method;
use crate::numerics::ode::{Choice, Statistics};
use crate::physics::spindle::AxialHold;
use crate::simulation::error::comparison;
use crate::simulation::error::estimate;
use crate::simulation::error::lyapunov;
use crate::simulation::error::report::MotionKind;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::control::Control;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::Model;
use crate::simulation::model::equilibrium::start_state;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::terms::LeftOut;
use crate::simulation::result::lines::Line;
use crate::simulation::result::metrics::{self};
use crate::simulation::solve::ladder;
pub use course::Taken;
use course::{Course, Finished};
use errors::{Comparison, largest};
pub use errors::{Errors, LEAST_SCALE, TrajectoryError};

/// What is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub methods: Vec<Method>,
    pub relative_tolerances: Vec<f64>,
    /// Timed runs of each method at each tolerance; at least 1.
    pub repetitions: u32,
}

/// Methods that may be the reference, best first: the first that finishes is, the next that finishes tells its error.
/// The other method comes first, for it shares no fault with the reference; then the same at another tolerance.
pub const REFERENCES: [(Method, f64); 4] =
    [(Method::Radau, 1e-11), (Method::DormandPrince, 1e-11), (Method::Radau, 1e-10), (Method::DormandPrince, 1e-10)];
/// By what the scene settles: any state that all runs share will do.
pub const SETTLING: (Method, f64) = (Method::Auto, 1e-6);
/// A run may take this many times the evaluations of the cheaper reference.
pub const EVALUATIONS_OVER_REFERENCE: u64 = 20;
/// The first reference may take so many evaluations a simulated second, and at least `LEAST_EVALUATIONS`.
const EVALUATIONS_PER_SECOND: f64 = 5e9;
const LEAST_EVALUATIONS: u64 = 10_000_000;
/// Errors below this many times the reference's own say nothing.
pub const ABOVE_OWN_ERROR: f64 = 10.0;
/// Trajectories are compared as long as the tolerance, grown at the divergence rate, is below this.
pub const MOST_GROWN: f64 = 0.1;

/// What a study leaves behind. Times in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkPrecision {
    /// Time of the state that all runs start from.
    pub begin: f64,
    /// Distance of the points of the output grid, and their number; the first is one distance after `begin`.
    pub grid: (f64, usize),
    pub states: usize,
    pub rung: &'static str,
    /// `None`: the run is too short to tell.
    pub motion: Option<MotionKind>,
    /// [1/s]
    pub divergence_rate: f64,
    pub reference: Reference,
    /// Evaluations that a run might take.
    pub most_evaluations: u64,
    pub points: Vec<Point>,
    pub left_out: Vec<LeftOut>,
}

/// The reference and its own error: its difference from the check.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    pub method: Method,
    pub relative_tolerance: f64,
    /// `None`: no second reference finished, and nothing is known of its error.
    pub check: Option<(Method, f64)>,
    pub own_error_db: Option<f64>,
    /// `None` in chaotic motion, too: each point is compared over a time of its own, and has it for that time.
    pub own_trajectory: Option<TrajectoryError>,
    /// Chaotic motion: what the level of another run of the same length would scatter by, worst of the judged channels [dB].
    pub sampling_error_db: Option<f64>,
    /// Of the spindle's accelerations [dB]; absent where it stands still.
    pub levels: Vec<(Channel, Option<f64>)>,
    /// The lines that are compared.
    pub lines: Vec<(Channel, Line)>,
    pub statistics: Statistics,
    pub taken: Taken,
}

/// One method at one tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub method: Method,
    pub relative_tolerance: f64,
    /// By each repetition until its end or its failure; empty where it was not tried.
    pub taken: Vec<Taken>,
    /// Or why there is no result, in words.
    pub measured: Result<Measured, String>,
}

/// What a finished run has shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// What ran, and why where it chose itself.
    pub choice: Choice,
    pub statistics: Statistics,
    pub errors: Errors,
    /// The reference's own trajectory error (root mean square) over the same time.
    pub own_trajectory: Option<f64>,
    /// The trajectory's error is less than ten times that: it says nothing.
    pub below_reference: bool,
    /// The same of the level, or it is less than the level's sampling error.
    pub level_below_reference: bool,
}

/// Runs the study. Deterministic apart from wall times. `settings` give times, outputs and rung; its method, tolerance
/// and fixed step are not used.
pub fn study(
    scene: &Scene,
    settings: &RunSettings,
    plan: &Plan,
    control: &Control<'_>,
) -> Result<WorkPrecision, SimulationError> {
    let settings = RunSettings {
        method: SETTLING.0,
        relative_tolerance: SETTLING.1,
        fixed_step: None,
        outputs: Outputs { spectra: accelerations(scene), series: Vec::new(), ..settings.outputs.clone() },
        ..settings.clone()
    };
    // A reference that fails is followed by another: what was told is not taken back.
    let furthest = Cell::new(0.0);
    let progress = |share: f64| {
        furthest.set(share.max(furthest.get()));
        (control.progress)(furthest.get());
    };
    let control = &Control { progress: &progress, ..control.aside() };
    let needs = ladder::needs(scene, &settings.outputs, settings.rung, settings.model_tolerance_db)?;
    let model = Model::new(scene, &needs);
    let course = Course::settled(&model, &needs, &settings, start_state(&model)?, control)?;
    let stretch = lyapunov::judged_stretch(&settings);
    let (begin, start) = (course.begin, &course.start);
    let parted = lyapunov::divergence_rate(&model, &settings, begin, start, stretch, u64::MAX, control)?;
    (control.progress)(DIVERGENCE_KNOWN);
    let (motion, divergence_rate) = (parted.motion(), parted.rate);
    let references = references(&course, control)?;
    let growth = if motion == Some(MotionKind::Diverging) { divergence_rate } else { 0.0 };
    let comparison = Comparison::new(scene, &course, &references.first, growth);
    let reference = described(&references, &comparison, motion);
    let points = points(&course, &references, &reference, &comparison, plan, control)?;
    Ok(WorkPrecision {
        begin: course.begin,
        grid: (course.grid_step, course.grid_count),
        states: model.mechanism().layout.dimension(),
        rung: needs.rung.name(),
        motion,
        divergence_rate,
        reference,
        most_evaluations: references.most_evaluations(),
        points,
        left_out: needs.left_out.clone(),
    })
}

/// Shares of the progress at the ends of its parts.
const SETTLED: f64 = 0.05;
const DIVERGENCE_KNOWN: f64 = 0.08;
const REFERENCES_KNOWN: f64 = 0.4;

/// The runs that all others are measured against.
struct References {
    first: Finished,
    first_is: (Method, f64),
    check: Option<(Finished, (Method, f64))>,
}

impl References {
    /// Evaluations that a point may take.
    fn most_evaluations(&self) -> u64 {
        let of = |run: &Finished| run.statistics.rhs_evaluations;
        let cheaper = self.check.as_ref().map_or(of(&self.first), |(check, _)| of(check).min(of(&self.first)));
        EVALUATIONS_OVER_REFERENCE * cheaper
    }
}

/// Fails only when no reference finishes, with the reason of the first.
fn references(course: &Course<'_>, control: &Control<'_>) -> Result<References, SimulationError> {
    let middle = 0.5 * (DIVERGENCE_KNOWN + REFERENCES_KNOWN);
    let mut most = ((EVALUATIONS_PER_SECOND * course.length()) as u64).max(LEAST_EVALUATIONS);
    let mut failure = None;
    let mut first: Option<(Finished, (Method, f64))> = None;
    for (method, relative_tolerance) in REFERENCES {
        let stepping = Stepping { method, relative_tolerance, fixed_step: None, most_evaluations: Some(most) };
        let share = if first.is_none() { (DIVERGENCE_KNOWN, middle) } else { (middle, REFERENCES_KNOWN) };
        match course.run(&stepping, share, control) {
            Err(stopped @ SimulationError::Stopped { .. }) => return Err(stopped),
            Err(error) => drop(failure.get_or_insert(error)),
            Ok(run) => match first.take() {
                None => {
                    most =
                        most.min((EVALUATIONS_OVER_REFERENCE * run.statistics.rhs_evaluations).max(LEAST_EVALUATIONS));
                    first = Some((run, (method, relative_tolerance)));
                }
                // The same run twice would find no error.
                Some(found) if found.0.choice.method == run.choice.method && found.1.1 == relative_tolerance => {
                    first = Some(found);
                }
                Some((found, first_is)) => {
                    let check = Some((run, (method, relative_tolerance)));
                    return Ok(References { first: found, first_is, check });
                }
            },
        }
    }
    match (first, failure) {
        (Some((first, first_is)), _) => Ok(References { first, first_is, check: None }),
        (None, Some(error)) => Err(error),
        (None, None) => Err(SimulationError::NoEquilibrium("no reference is known".into())),
    }
}

fn described(references: &References, comparison: &Comparison<'_>, motion: Option<MotionKind>) -> Reference {
    let first = &references.first;
    let own = references.check.as_ref().map(|(run, (_, tolerance))| comparison.errors(run, *tolerance));
    let chaotic = motion == Some(MotionKind::Diverging);
    Reference {
        method: references.first_is.0,
        relative_tolerance: references.first_is.1,
        check: references.check.as_ref().map(|(_, is)| *is),
        own_error_db: own.as_ref().and_then(|own| own.level_db),
        own_trajectory: own.and_then(|own| own.trajectory).filter(|_| !chaotic),
        sampling_error_db: chaotic.then(|| estimate::sampling_errors(&first.recording).worst()).flatten(),
        levels: comparison.levels.clone(),
        lines: comparison.lines.clone(),
        statistics: first.statistics,
        taken: first.taken,
    }
}

fn points(
    course: &Course<'_>,
    references: &References,
    reference: &Reference,
    comparison: &Comparison<'_>,
    plan: &Plan,
    control: &Control<'_>,
) -> Result<Vec<Point>, SimulationError> {
    let mut loosest_first = plan.relative_tolerances.clone();
    loosest_first.sort_by(|a, b| b.total_cmp(a));
    let most = references.most_evaluations();
    let count = (plan.methods.len() * loosest_first.len()).max(1) as f64;
    let mut points = Vec::new();
    for &method in &plan.methods {
        let mut hopeless = false;
        for &relative_tolerance in &loosest_first {
            let share = |done: usize| REFERENCES_KNOWN + (1.0 - REFERENCES_KNOWN) * done as f64 / count;
            let share = (share(points.len()), share(points.len() + 1));
            let untried = Point {
                method,
                relative_tolerance,
                taken: Vec::new(),
                measured: Err("not tried: a looser tolerance has taken too many evaluations already".into()),
            };
            if hopeless {
                points.push(untried);
                continue;
            }
            let stepping = Stepping { method, relative_tolerance, fixed_step: None, most_evaluations: Some(most) };
            let (taken, ended) = course.timed(&stepping, plan.repetitions, share, control)?;
            hopeless = matches!(ended, Err(SimulationError::Exhausted { .. }));
            let measured = match ended {
                Ok(run) => measured(&run, references, reference, comparison, relative_tolerance),
                Err(SimulationError::Exhausted { time, evaluations }) => Err(format!(
                    "stopped at t = {time:.9} s after {evaluations} evaluations of the equations: a run may take {most}, \
                     {EVALUATIONS_OVER_REFERENCE} times those of the reference"
                )),
                Err(error) => Err(error.to_string()),
            };
            points.push(Point { taken, measured, ..untried });
        }
    }
    Ok(points)
}

fn measured(
    run: &Finished,
    references: &References,
    reference: &Reference,
    comparison: &Comparison<'_>,
    relative_tolerance: f64,
) -> Result<Measured, String> {
    let errors = comparison.errors(run, relative_tolerance);
    if !errors.is_finite() {
        return Err("its error is not finite".into());
    }
    // The reference's own error over the time in which this run is compared.
    let own = references.check.as_ref().and_then(|(check, _)| comparison.trajectory(check, relative_tolerance));
    let below_reference = matches!((&errors.trajectory, own),
        (Some(error), Some(own)) if error.rms < ABOVE_OWN_ERROR * own.rms);
    let floor = level_floor(reference.own_error_db, reference.sampling_error_db);
    let level_below_reference = matches!((errors.level_db, floor), (Some(error), Some(floor)) if error < floor);
    Ok(Measured {
        choice: run.choice.clone(),
        statistics: run.statistics,
        errors,
        own_trajectory: own.map(|own| own.rms),
        below_reference,
        level_below_reference,
    })
}

/// Below this the error of a level says nothing [dB]. In chaotic motion any two runs are samples of the same, the references
/// too.
pub fn level_floor(own_error_db: Option<f64>, sampling_error_db: Option<f64>) -> Option<f64> {
    match sampling_error_db {
        Some(sampling) => largest(Some(sampling), own_error_db),
        None => own_error_db.map(|own| ABOVE_OWN_ERROR * own),
    }
}

/// Accelerations whose levels and lines are compared: that along X where the spindle moves there.
fn accelerations(scene: &Scene) -> Vec<Channel> {
    let moves =
        |channel: &Channel| !matches!(channel, Channel::Spindle(Axis::X, _)) || scene.spindle.axial == AxialHold::Free;
    ACCELERATIONS.into_iter().filter(moves).collect()
}

/// Levels of the accelerations [dB].
fn levels(run: &Finished) -> Vec<(Channel, Option<f64>)> {
    let level = |channel: Channel| {
        let recording = &run.recording;
        let variance = recording.total_variance(channel);
        recording.of(channel).and_then(|signal| metrics::in_band_metrics(channel, signal.in_band(), variance).level_db)
    };
    ACCELERATIONS.into_iter().map(|channel| (channel, level(channel))).collect()
}

#[cfg(test)]
mod tests;
