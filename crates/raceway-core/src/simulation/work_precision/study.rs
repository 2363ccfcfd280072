//! The runs of a study: the references, then each method at each tolerance.

use std::cell::Cell;

use super::course::{Course, Finished};
use super::errors::{Comparison, largest};
use super::report::{Measured, Plan, Point, Reference, WorkPrecision};
use crate::numerics::ode::Method;
use crate::physics::spindle::AxialHold;
use crate::simulation::error::lyapunov;
use crate::simulation::error::lyapunov::MotionKind;
use crate::simulation::error::stationarity;
use crate::simulation::input::channel::{Axis, Channel};
use crate::simulation::input::control::Control;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::Model;
use crate::simulation::model::equilibrium::start_state;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::recording::sampling::ACCELERATIONS;
use crate::simulation::solve::eligibility::active_terms;

/// Candidates for the reference, best first. The first that finishes is the reference; its difference from the next that finishes
/// is its error. Another method comes before another tolerance, because it shares no fault with the reference.
pub(crate) const REFERENCES: [(Method, f64); 4] =
    [(Method::Radau, 1e-11), (Method::DormandPrince, 1e-11), (Method::Radau, 1e-10), (Method::DormandPrince, 1e-10)];
/// Method and tolerance of the settling: any common state suffices.
pub const SETTLING: (Method, f64) = (Method::Auto, 1e-6);
/// Largest number of evaluations of a run over those of the cheaper reference [-].
pub(crate) const EVALUATIONS_OVER_REFERENCE: u64 = 20;
/// Largest number of evaluations of the first reference for each simulated second [1/s], at least `MIN_EVALUATIONS`.
const EVALUATIONS_PER_SECOND: f64 = 5e9;
const MIN_EVALUATIONS: u64 = 10_000_000;
/// Smallest significant error over the reference's own [-].
pub const ABOVE_OWN_ERROR: f64 = 10.0;
/// Runs the study. Deterministic apart from wall times. `settings` give times, outputs and rung; its method, tolerance
/// and fixed step are not used.
pub fn study(
    scene: &Scene,
    settings: &RunSettings,
    plan: &Plan,
    control: &Control<'_>,
) -> Result<WorkPrecision, SimulationError> {
    let scene = &settings.seen(scene);
    let settings = RunSettings {
        method: SETTLING.0,
        relative_tolerance: SETTLING.1,
        fixed_step: None,
        outputs: Outputs { spectra: accelerations(scene), series: Vec::new(), ..settings.outputs.clone() },
        ..settings.clone()
    };
    // Another reference follows one that fails. The progress does not fall back meanwhile.
    let furthest = Cell::new(0.0);
    let progress = |share: f64| {
        furthest.set(share.max(furthest.get()));
        (control.progress)(furthest.get());
    };
    let control = &Control { progress: &progress, ..control.without_live() };
    let needs = active_terms(scene, &settings.outputs, settings.rung)?;
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

/// Shares of the progress at the ends of its parts, after the settling.
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
    let mut most = ((EVALUATIONS_PER_SECOND * course.length()) as u64).max(MIN_EVALUATIONS);
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
                    most = most.min((EVALUATIONS_OVER_REFERENCE * run.statistics.rhs_evaluations).max(MIN_EVALUATIONS));
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
        sampling_error_db: chaotic.then(|| stationarity::sampling_errors(&first.recording).worst()).flatten(),
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
            hopeless = matches!(ended, Err(SimulationError::EvaluationLimit { .. }));
            let measured = match ended {
                Ok(run) => measured(&run, references, reference, comparison, relative_tolerance),
                Err(SimulationError::EvaluationLimit { time, evaluations }) => Err(format!(
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

/// Smallest significant error of a level [dB]. In chaotic motion two runs, references included, are samples of one distribution.
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

#[cfg(test)]
mod tests;
