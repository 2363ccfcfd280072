//! The result of an accepted attempt: scatter between windows, warnings, metrics.

use std::rc::Rc;
use std::time::Instant;

use crate::simulation::error::codes::{NotEligible, Quantity, Rejection, Uncertainty, Warning};
use crate::simulation::error::comparison::{Deviation, minute_numbers};
use crate::simulation::error::errors::LevelErrors;
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::stationarity::{
    self, WindowScatter, deviation_of_parts, halves_deviation, is_quiet, quiet_channels, trends,
};
use crate::simulation::error::thresholds::{LONG_RECORD_S, NOTABLE_CHANGE_DB, STATIONARY_SCATTER_DB, WARNED_ERROR_DB};
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::{Scene, Term};
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::terms::{ActiveTerms, Justification, LeftOut};
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::{BATCHES, REPEATED};
use crate::simulation::result::metrics::SolverReport;
use crate::simulation::result::run_result::{Provenance, RunResult};
use crate::simulation::solve::attempt::{Attempt, MIN_EVALUATIONS, Problem, record, run_from};
use crate::simulation::solve::eligibility::active_terms;
use crate::simulation::solve::judge::large_errors;
use crate::simulation::solve::plan::Candidate;
use crate::simulation::solve::startup::{self, InitialState};
use crate::simulation::solve::surface_warnings::{surface_warnings, track_off_equator};
use crate::simulation::solve::verification::or_failure;
use crate::simulation::solve::verify_planar::with_omitted_tilt;

/// Recorded time of a reduced model up to which one later window per batch is recorded [s]. These windows cost little.
const MANY_WINDOWS_S: f64 = 0.5;
/// Time between the recorded time and a later window, over the recorded time [-]. A slow beat would not change in an adjacent window.
const GAP: f64 = 1.0;
/// Evaluations of a later window over those of the run, at most [-].
const LATER_EVALUATIONS: u64 = 4;

/// An accepted attempt, and the candidates before it.
pub(crate) struct Solved {
    pub candidate: Candidate,
    pub attempt: Rc<Attempt>,
    pub report: AccuracyReport,
    pub rejections: Vec<Rejection>,
    pub not_eligible: Vec<NotEligible>,
}

pub(crate) fn assemble(
    problem: &Problem<'_>,
    solved: Solved,
    begin: Instant,
    control: &Control<'_>,
) -> Result<RunResult, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let Solved { candidate, attempt, mut report, rejections, not_eligible } = solved;
    attempt.recording.evaluate(&settings.outputs);
    report = report.with_unresolved(settings.tightened.is_none());
    if scene.operation.is_steady() {
        let windows = window_scatter(problem, &candidate, &attempt, &control.without_live())?;
        report = with_scatter(report, &attempt.recording, windows, &settings.outputs);
        report = with_quiet_levels(report, &attempt.recording);
    }
    let level = Some(candidate.level).filter(|level| level.is_reduced() || settings.rung.is_some());
    let terms = active_terms(scene, &settings.outputs, level)?;
    let (mut report, tilt_window) = with_omitted_tilt(report, &terms, problem, &control.without_live())?;
    report.unverified = minute_numbers(&attempt.recording.quantities());
    report.unverified.extend(slow_numbers(scene, &terms, candidate.level));
    // The periodic model has no initial transient. Neither chaos nor a damped start keeps it.
    let is_damped = attempt.trajectory.is_some() && problem.dynamics(control)?.start.is_damped;
    let keeps_start = candidate.level != ModelLevel::Periodic && !report.is_chaotic && !is_damped;
    report.warnings.extend(startup::warnings(scene, &terms, settings.settle, keeps_start));
    let mut left_out = terms.left_out.clone();
    let bound = report.level_error_db().map(|error| (error, "dB"));
    for left_out in left_out.iter_mut().filter(|left_out| left_out.by == Justification::Judgement) {
        left_out.bound = bound;
    }
    let solver = SolverReport {
        method: attempt.method,
        choice: attempt.trajectory.as_ref().and_then(|trajectory| trajectory.choice.reason),
        level: candidate.level,
        tilt_window,
        rejections,
        not_eligible,
        statistics: attempt.work,
        wall_time: begin.elapsed().as_secs_f64(),
        simulated_time: settings.settle + settings.duration,
        relative_tolerance: attempt.tolerance,
        states: attempt.states,
        strips: attempt.strips,
    };
    let mechanism = Mechanism::new(scene, &terms);
    report.warnings.extend(surface_warnings(scene, &mechanism, settings));
    report.warnings.extend(track_off_equator(scene, &mechanism, &attempt.recording.tracks));
    let account = Provenance { solver, accuracy: report, left_out };
    Ok(RunResult::new(scene, settings, &mechanism, &attempt.recording, account))
}

/// The scatter of the levels between windows of the motion: from the recorded time, and from later windows where it is not stationary.
fn window_scatter(
    problem: &Problem<'_>,
    candidate: &Candidate,
    attempt: &Attempt,
    control: &Control<'_>,
) -> Result<(WindowScatter, Option<SimulationError>), SimulationError> {
    let settings = problem.settings;
    let own = WindowScatter { scatter: stationarity::scatter(&attempt.recording), later: None };
    // A record that is too short for batch means is always compared with later windows.
    let is_short = settings.duration < REPEATED;
    let many = is_short || (candidate.level.is_reduced() && settings.duration <= MANY_WINDOWS_S);
    let is_even = !is_short && own.scatter.worst().is_none_or(|scatter| scatter < STATIONARY_SCATTER_DB);
    if settings.duration >= LONG_RECORD_S || is_even {
        return Ok((own, None));
    }
    (control.live)(&Live::of(Phase::Judging));
    match or_failure(later_window(problem, candidate, attempt, many, control))? {
        Ok(later) if many => {
            let deviation = deviation_of_parts(&attempt.recording, &later);
            Ok((WindowScatter { scatter: deviation, later: Some(deviation) }, None))
        }
        Ok(later) => {
            let deviation = Deviation::of_runs(&attempt.recording, &later).levels;
            Ok((WindowScatter { scatter: own.scatter.larger(deviation), later: Some(deviation) }, None))
        }
        Err(failure) => Ok((own, Some(failure))),
    }
}

/// A later window of the same motion. `many`: as many windows as there are batches.
fn later_window(
    problem: &Problem<'_>,
    candidate: &Candidate,
    attempt: &Attempt,
    many: bool,
    control: &Control<'_>,
) -> Result<Recording, SimulationError> {
    let Problem { scene, settings, .. } = *problem;
    let levels_only =
        Outputs { contacts: false, cage: false, life: false, friction: false, ..settings.outputs.without_signals() };
    let later = RunSettings {
        settle: settings.settle + settings.duration + f64::max(GAP * settings.duration, REPEATED),
        duration: if many { BATCHES as f64 * settings.duration } else { settings.duration },
        outputs: levels_only,
        fixed_step: attempt.step,
        ..settings.clone()
    };
    let Some(trajectory) = &attempt.trajectory else {
        return Ok(record(candidate.level, scene, &later, control)?.0);
    };
    let dynamics = problem.dynamics(control)?;
    let start = InitialState {
        time: settings.settle + settings.duration,
        state: trajectory.end.clone(),
        ..dynamics.start.clone()
    };
    let most = LATER_EVALUATIONS * attempt.work.rhs_evaluations.max(MIN_EVALUATIONS);
    let stepping = Stepping {
        method: trajectory.choice.method,
        relative_tolerance: attempt.tolerance.unwrap_or(settings.relative_tolerance),
        fixed_step: attempt.step,
        most_evaluations: Some(most),
    };
    let later = RunSettings { method: trajectory.choice.method, ..later };
    Ok(run_from(dynamics, &start, &later, &stepping, control)?.recording)
}

/// Numbers of the cage whose slowest motion no window covers. A crown tilts slowly and changes the orbit. The mean speed of a reversal is the small rest
/// of a sum.
fn slow_numbers(scene: &Scene, terms: &ActiveTerms, level: ModelLevel) -> Vec<Quantity> {
    let is_tilt = |omitted: &LeftOut| omitted.term == Term::CageTilt.name() && omitted.by != Justification::Identity;
    let omits_tilt = level != ModelLevel::Full && terms.left_out.iter().any(is_tilt);
    let all = [(Quantity::CageOrbit, omits_tilt), (Quantity::CageSpeed, scene.operation.rotation().reverses())];
    all.into_iter().filter(|(_, is_slow)| *is_slow).map(|(quantity, _)| quantity).collect()
}

/// The report with a remark on very low levels in place of warnings of their large errors.
fn with_quiet_levels(mut report: AccuracyReport, recording: &Recording) -> AccuracyReport {
    let channels = quiet_channels(recording);
    let others = LevelErrors::each(|channel| report.level_errors.of(channel).filter(|_| !is_quiet(recording, channel)));
    if others.worst().is_none_or(|error| error <= WARNED_ERROR_DB) {
        report.drop_uncertain_level();
    }
    report.warnings.extend((!channels.is_empty()).then_some(Warning::StationarityNotChecked { channels }));
    report
}

/// Adds the scatter between windows to the report. A level error is at least a notable scatter, and a trend along the recorded time.
fn with_scatter(
    report: AccuracyReport,
    recording: &Recording,
    (windows, failure): (WindowScatter, Option<SimulationError>),
    outputs: &Outputs,
) -> AccuracyReport {
    let mut report = AccuracyReport { level_scatter: windows.scatter, ..report };
    if report.level_error_db().is_none() {
        return report;
    }
    let trends = if report.is_chaotic { Vec::new() } else { trends(recording, windows.later.as_ref()) };
    let of_trend = LevelErrors::each(|channel| Some(trends.iter().find(|(of, _)| *of == channel)?.1.abs()));
    let notable = LevelErrors::each(|channel| {
        windows.scatter.of(channel).filter(|scatter| *scatter > NOTABLE_CHANGE_DB && !is_quiet(recording, channel))
    });
    let is_uneven = notable.worst().is_some();
    let estimated = report.level_errors;
    report.level_errors = estimated.raised_to(of_trend).raised_to(notable);
    report.changing = report.level_errors.larger_than(&estimated);
    if let (true, Some(errors), Some(halves)) = (is_uneven, report.quantity_errors, halves_deviation(&recording.parts))
    {
        report.quantity_errors = Some(errors.larger(&halves));
    }
    // Large errors are reported once, from the final values.
    let was_uncertain = report.warnings.iter().find_map(|warning| match warning {
        Warning::Uncertain { cause, .. } => Some(*cause),
        _ => None,
    });
    report.warnings.retain(|warning| !matches!(warning, Warning::Uncertain { .. }));
    if report.warnings.is_empty() {
        let cause = was_uncertain.unwrap_or(if is_uneven { Uncertainty::Uneven } else { Uncertainty::Steps });
        report.warnings = large_errors(&report, cause, outputs);
    }
    let worst = trends.iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
    report.warnings.extend(worst.map(|&(channel, change_db)| Warning::NotStationary { channel, change_db }));
    report.warnings.extend(failure.map(Warning::LaterWindowFailed));
    report
}
