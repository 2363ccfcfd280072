//! Judgement of an attempt: it becomes the result, or another candidate is tried in its place.

use std::rc::Rc;

use crate::numerics::ode::Method;
use crate::simulation::error::codes::{Cause, ErrorBasis, Gap, Refinement, Uncertainty, Warning};
use crate::simulation::error::comparison::Deviation;
use crate::simulation::error::errors::{LevelErrors, QuantityErrors};
use crate::simulation::error::lyapunov::MotionKind;
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::stationarity::{of_moving, sampling_errors, sampling_errors_of_quantities, scatter};
use crate::simulation::error::thresholds::{
    HIDDEN_SHARE, INDEPENDENT_NOISE, MAX_GROWTH_PER_STEP, SAMPLE_EFOLDS, SAMPLE_SIGMAS, STALLED_DB, STALLED_SHARE,
    STATED_SHARE, UNRESOLVED_DB, WARNED_ERROR_DB,
};
use crate::simulation::input::settings::{Outputs, RunSettings};
use crate::simulation::model::radially_condensed::RadiallyCondensed;
use crate::simulation::recording::record::Recording;
use crate::simulation::recording::sampling::{RATE, kept_values};
use crate::simulation::solve::attempt::{Attempt, Problem};
use crate::simulation::solve::eligibility::{allowed_deviation, may_tilt_late};
use crate::simulation::solve::fixed_step;
use crate::simulation::solve::plan::{Candidate, CandidateSteps, Reference};
use crate::simulation::solve::verification::{MIN_VALUES, TIGHTEST, Verification};

/// Largest number of fixed steps tried for accuracy, and of samples of a chaotic motion.
const MOST_REFINEMENTS: usize = 3;
/// Tolerance of a repetition of the whole run over the last tolerance [-].
const MUCH_TIGHTER: f64 = 0.01;

/// Verdict on an attempt.
pub(crate) enum Verdict {
    Accept(AccuracyReport),
    /// The previous attempt is the result.
    AcceptPrevious(AccuracyReport),
    /// `refined`: the candidate to try next. `report`: the accuracy report of the rejected attempt.
    Reject {
        cause: Cause,
        refined: Option<Candidate>,
        report: Option<AccuracyReport>,
    },
}

/// Progress of the search.
pub(crate) struct Progress<'a> {
    /// Refinements of this kind of candidate so far.
    pub refinements: usize,
    /// No other candidate is left.
    pub is_last: bool,
    pub previous: Option<&'a (Rc<Attempt>, Verification)>,
}

pub(crate) fn judge(
    candidate: &Candidate,
    attempt: &Attempt,
    verification: &Verification,
    problem: &Problem<'_>,
    progress: &Progress<'_>,
) -> Verdict {
    match (candidate.stepping, candidate.reference) {
        (CandidateSteps::Own(_), _) => reduced(candidate, attempt, verification, problem),
        (CandidateSteps::Fixed(_, step), Reference::IndependentSample) => {
            sample(candidate, step, attempt, verification, problem, progress)
        }
        (CandidateSteps::Fixed(_, step), _) if problem.settings.fixed_step.is_none() => {
            chosen_step(candidate, step, attempt, verification, problem, progress)
        }
        (_, Reference::LooserRun) => looser_run(candidate, attempt, verification, problem, progress),
        _ => controlled(candidate, attempt, verification, problem, progress),
    }
}

fn reject(cause: Cause, refined: Option<Candidate>) -> Verdict {
    Verdict::Reject { cause, refined, report: None }
}

pub(crate) fn deviates(deviation: &Deviation, outputs: &Outputs, allowed_db: f64) -> Cause {
    let asked = deviation.of_asked(outputs);
    let beyond = asked.beyond(outputs, allowed_db);
    Cause::Deviation { levels: asked.levels, quantities: asked.quantities, beyond }
}

/// Verdict on a reduced model: accepted if it stays within its share of `model_tolerance_db` of a richer model all along the run.
fn reduced(candidate: &Candidate, attempt: &Attempt, verification: &Verification, problem: &Problem<'_>) -> Verdict {
    let Problem { scene, settings, .. } = *problem;
    let outputs = &settings.outputs;
    let allowed_db = allowed_deviation(candidate.level, settings.model_tolerance_db);
    let deviation = verification.deviation.unwrap_or(Deviation::UNKNOWN);
    let course = verification.course.filter(|course| !course.within(outputs, settings.model_tolerance_db));
    let cause = if let Some(failure) = &verification.failure {
        Some(Cause::NotVerified(failure.clone()))
    } else if let (None, Some(gap)) = (verification.deviation, verification.gap) {
        Some(Cause::NotCovered(gap))
    } else if !deviation.within(outputs, allowed_db) {
        Some(deviates(&deviation, outputs, allowed_db))
    } else if let Some(gap) = verification.gap {
        Some(Cause::NotCovered(gap))
    } else if let Some(course) = course {
        let Deviation { levels, quantities } = course;
        let beyond = course.beyond(outputs, settings.model_tolerance_db);
        Some(Cause::CourseDiffers { levels, quantities, beyond })
    } else {
        verification.is_chaotic().then_some(Cause::NotCovered(Gap::Chaos))
    };
    // The deviation may come from longer steps than the model's own.
    let own_step = || {
        let model = RadiallyCondensed::new(scene, outputs).ok()?;
        Some(Candidate { stepping: CandidateSteps::Own(Some(model.step_ratio().step())), ..*candidate })
    };
    let refined = attempt.step_deviation.and_then(|_| own_step());
    match cause {
        Some(cause @ (Cause::Deviation { .. } | Cause::CourseDiffers { .. })) if refined.is_some() => {
            reject(cause, refined)
        }
        Some(cause) if settings.rung.is_none() => reject(cause, None),
        cause => Verdict::Accept(reduced_report(candidate, attempt, verification, allowed_db, cause)),
    }
}

/// Accuracy report of a reduced model. `cause`: reason for rejecting it if it had not been selected.
fn reduced_report(
    candidate: &Candidate,
    attempt: &Attempt,
    verification: &Verification,
    allowed_db: f64,
    cause: Option<Cause>,
) -> AccuracyReport {
    let known = verification.deviation.filter(|_| verification.gap.is_none());
    let deviation = match (known, verification.course) {
        (Some(deviation), Some(course)) => deviation.larger(&course),
        (Some(deviation), None) => deviation,
        (None, _) => Deviation::UNKNOWN,
    };
    let basis = if known.is_some() { verification.basis } else { ErrorBasis::None };
    let mut report = AccuracyReport::new(deviation, basis, verification.divergence);
    if report.is_chaotic {
        report.quantity_errors = None;
        if report.level_error_db().is_some() {
            report.level_errors = report.level_errors.larger(sampling_errors(&attempt.recording));
        }
    }
    report.warnings = cause
        .map(|cause| match cause {
            Cause::NotCovered(gap) if verification.deviation.is_some() => Warning::ErrorUnknown(gap),
            cause => Warning::ModelNotConfirmed { level: candidate.level, allowed_db, cause },
        })
        .into_iter()
        .collect();
    report
}

/// Verdict on automatic fixed steps: accepted if the stated error is within its share of `model_tolerance_db`.
fn chosen_step(
    candidate: &Candidate,
    step: f64,
    attempt: &Attempt,
    verification: &Verification,
    problem: &Problem<'_>,
    progress: &Progress<'_>,
) -> Verdict {
    let settings = problem.settings;
    let outputs = &settings.outputs;
    if verification.is_chaotic() {
        return chaotic_step(candidate, step, verification, problem);
    }
    let Some(deviation) = verification.deviation else {
        return reject(not_verified(verification, settings).unwrap_or(Cause::NoDecay), None);
    };
    if let Some(cause) = not_verified(verification, settings) {
        return reject(cause, None);
    }
    let allowed_db = STATED_SHARE * settings.model_tolerance_db;
    let report = AccuracyReport::new(deviation, verification.basis, verification.divergence);
    let Some(excess) = report.excess(outputs, allowed_db) else {
        return reject(deviates(&deviation, outputs, allowed_db), None);
    };
    if let Some(report) = sufficient(&report, verification, &attempt.recording, outputs, allowed_db) {
        return Verdict::Accept(report);
    }
    let next = fixed_step::refined(step, excess);
    let may_refine = progress.refinements + 1 < MOST_REFINEMENTS
        && next >= fixed_step::SHORTEST
        && report.large_errors(outputs).is_empty();
    let stepping = CandidateSteps::Fixed(Method::SemiImplicit, next);
    reject(deviates(&deviation, outputs, allowed_db), may_refine.then_some(Candidate { stepping, ..*candidate }))
}

/// Verdict on chaotic motion in fixed steps. Only its statistics can be compared, with a sample in half of the step.
fn chaotic_step(candidate: &Candidate, step: f64, verification: &Verification, problem: &Problem<'_>) -> Verdict {
    let Problem { scene, settings, .. } = *problem;
    let rate = verification.divergence.map_or(0.0, |divergence| divergence.rate);
    if may_tilt_late(scene) {
        return reject(Cause::NotCovered(Gap::MayTilt), None);
    }
    if let Some(failure) = &verification.failure {
        return reject(Cause::NotVerified(failure.clone()), None);
    }
    if rate * step >= MAX_GROWTH_PER_STEP {
        return reject(Cause::Instability, None);
    }
    if rate * settings.duration <= SAMPLE_EFOLDS {
        return reject(Cause::ShortChaos, None);
    }
    if problem.has_axial_motion_or_tilt() {
        return reject(Cause::NoDecay, None);
    }
    reject(Cause::NotCovered(Gap::Chaos), Some(half_step(candidate, step)))
}

fn half_step(candidate: &Candidate, step: f64) -> Candidate {
    let stepping = CandidateSteps::Fixed(Method::SemiImplicit, fixed_step::HALVED * step);
    Candidate { stepping, reference: Reference::IndependentSample, ..*candidate }
}

/// Verdict on the second of two samples of a chaotic motion: accepted if their levels agree within their standard errors.
fn sample(
    candidate: &Candidate,
    step: f64,
    attempt: &Attempt,
    verification: &Verification,
    problem: &Problem<'_>,
    progress: &Progress<'_>,
) -> Verdict {
    let allowed_db = STATED_SHARE * problem.settings.model_tolerance_db;
    let deviation = verification.deviation.unwrap_or(Deviation::UNKNOWN);
    let scatter = sampling_errors(&attempt.recording);
    let before = progress.previous.map_or(scatter, |(before, _)| sampling_errors(&before.recording));
    let of_both = scatter.zip(&before, f64::hypot);
    let ratio = |deviation: f64, error: f64| deviation / (SAMPLE_SIGMAS * error).max(allowed_db);
    let are_equal = deviation.levels.zip(&of_both, ratio).worst().is_some_and(|ratio| ratio <= 1.0);
    if are_equal {
        let levels = scatter.larger(deviation.levels);
        let quantities = with_sampling(deviation.quantities, &attempt.recording);
        let mut report =
            AccuracyReport::new(Deviation { levels, quantities }, verification.basis, verification.divergence);
        report.warnings = large_errors(&report, Uncertainty::ShortSample, &problem.settings.outputs);
        return Verdict::Accept(report);
    }
    let refined = (progress.refinements + 1 < MOST_REFINEMENTS).then(|| half_step(candidate, step));
    reject(Cause::SamplesDiffer, refined)
}

/// Verdict on error control, or on a selected method, step or tolerance.
fn controlled(
    candidate: &Candidate,
    attempt: &Attempt,
    verification: &Verification,
    problem: &Problem<'_>,
    progress: &Progress<'_>,
) -> Verdict {
    let settings = problem.settings;
    let outputs = &settings.outputs;
    let allowed_db = STATED_SHARE * settings.model_tolerance_db;
    let mut report = dynamics_report(attempt, verification, settings);
    let unresolved = verification.deviation.is_some_and(|deviation| {
        let worst = deviation.levels.worst();
        worst.is_some_and(|error| error > UNRESOLVED_DB || verification.noise > INDEPENDENT_NOISE)
    });
    if let (CandidateSteps::Controlled(_, tolerance), true, false) =
        (candidate.stepping, unresolved && outputs.include_levels(), report.motion == Some(MotionKind::Diverging))
        && let Some(refined) = much_tighter(candidate, tolerance)
    {
        let cause = deviates(&report.deviation(), outputs, allowed_db);
        return Verdict::Reject { cause, refined: Some(refined), report: Some(report) };
    }
    if settings.tightened.is_none() || progress.is_last {
        report = sufficient(&report, verification, &attempt.recording, outputs, allowed_db).unwrap_or(report);
        return Verdict::Accept(report);
    }
    // With axial motion or tilt, the step noise of a loose tolerance may look like chaos.
    let is_believed = !problem.has_axial_motion_or_tilt() || !report.is_chaotic;
    if is_believed {
        if let Some(report) = sufficient(&report, verification, &attempt.recording, outputs, allowed_db) {
            return Verdict::Accept(report);
        }
        let small_sample_error = report.level_error_db().is_some_and(|error| error <= WARNED_ERROR_DB);
        if report.is_chaotic && small_sample_error || report.excess(outputs, allowed_db).is_some_and(|e| e <= 1.0) {
            return Verdict::Accept(report);
        }
    }
    let cause = deviates(&report.deviation(), outputs, allowed_db);
    Verdict::Reject { cause, refined: None, report: Some(report) }
}

/// The whole run at a much tighter tolerance than the last; `None` if no tighter one is left.
fn much_tighter(candidate: &Candidate, tolerance: f64) -> Option<Candidate> {
    let CandidateSteps::Controlled(method, _) = candidate.stepping else { return None };
    let tighter = (MUCH_TIGHTER * tolerance).max(TIGHTEST);
    let stepping = CandidateSteps::Controlled(method, tighter);
    (tighter < tolerance).then_some(Candidate { stepping, reference: Reference::LooserRun, ..*candidate })
}

/// Verdict on a whole run against one at a looser tolerance. Either the level has converged, or the change belongs to the motion itself.
fn looser_run(
    candidate: &Candidate,
    attempt: &Attempt,
    verification: &Verification,
    problem: &Problem<'_>,
    progress: &Progress<'_>,
) -> Verdict {
    let settings = problem.settings;
    let mut deviation = verification.deviation.unwrap_or(Deviation::UNKNOWN);
    // A level that is silent at the tighter tolerance was the noise of the looser steps.
    deviation.levels = of_moving(&deviation.levels, &attempt.recording);
    let change = deviation.levels.worst();
    let before = progress.previous.and_then(|(_, before)| before.deviation).map(|deviation| deviation.levels);
    // The first looser run and its own repetition show the same error of that run. Only the next refinement shows if the change shrinks.
    let stalled = match (change, before.and_then(|before| before.worst())) {
        (Some(change), Some(before)) if progress.refinements > 1 => {
            change > STALLED_SHARE * before && change < STALLED_DB
        }
        _ => false,
    };
    if stalled {
        deviation.levels = deviation.levels.larger(before.unwrap_or_default());
    }
    let basis = if change.is_none() { ErrorBasis::Silence } else { verification.basis };
    let mut report = AccuracyReport::new(deviation, basis, verification.divergence);
    report.warnings = large_errors(&report, Uncertainty::Steps, &settings.outputs);
    let CandidateSteps::Controlled(method, tolerance) = candidate.stepping else { return Verdict::Accept(report) };
    if settings.method != Method::Auto {
        // The run before is the result, and this one its repetition.
        if let ErrorBasis::Repetition { refinement, .. } = &mut report.basis {
            *refinement = Refinement::Tolerance(tolerance, method);
        }
        return Verdict::AcceptPrevious(report);
    }
    match much_tighter(candidate, tolerance) {
        Some(refined) if change.is_some_and(|change| change > UNRESOLVED_DB) && !stalled => {
            let cause = deviates(&deviation, &settings.outputs, STATED_SHARE * settings.model_tolerance_db);
            Verdict::Reject { cause, refined: Some(refined), report: Some(report) }
        }
        _ => Verdict::Accept(report),
    }
}

/// Accuracy report of a run of the dynamics.
fn dynamics_report(attempt: &Attempt, verification: &Verification, settings: &RunSettings) -> AccuracyReport {
    let mut deviation = verification.deviation.unwrap_or(Deviation::UNKNOWN);
    let mut basis = verification.basis;
    let mut report = AccuracyReport::new(deviation, basis, verification.divergence);
    let mut cause = Uncertainty::Steps;
    if report.is_chaotic {
        // The repetition is another sample of the same motion. Its scatter is larger over a part of the time than over the whole time.
        let share = match verification.basis {
            ErrorBasis::Repetition { window, recorded, .. } if settings.fixed_step.is_none() => {
                (window / recorded).sqrt()
            }
            _ => 1.0,
        };
        deviation.levels = sampling_errors(&attempt.recording).larger(deviation.levels.map(|error| share * error));
        deviation.quantities = with_sampling(deviation.quantities, &attempt.recording);
        if let ErrorBasis::Repetition { refinement, .. } = verification.basis {
            basis = ErrorBasis::BatchMeans { refinement };
        }
        report = AccuracyReport::new(deviation, basis, verification.divergence);
        cause = Uncertainty::ShortSample;
    }
    let unstable = attempt.trajectory.as_ref().and_then(|trajectory| trajectory.unstable);
    let failed = unstable.map(Warning::UnstableStep).or_else(|| match not_verified(verification, settings) {
        Some(Cause::NotVerified(failure)) => Some(Warning::NotVerified(failure)),
        _ => None,
    });
    let failed = failed.or_else(|| {
        let part = verification.part.clone();
        part.map(|(window, cause)| Warning::PartlyVerified { window, cause })
    });
    let short = (kept_values(settings.duration) < MIN_VALUES)
        .then(|| Warning::RecordTooShort { recorded: settings.duration, required: MIN_VALUES as f64 / RATE });
    report.warnings = match failed.or(short) {
        Some(warning) => vec![warning],
        None => large_errors(&report, cause, &settings.outputs),
    };
    let too_short = short_chaos(&report, settings).filter(|_| report.warnings.is_empty());
    report.warnings.extend(too_short);
    if report.level_errors.worst().is_none() && report.warnings.is_empty() && verification.deviation.is_some() {
        report.basis = ErrorBasis::Silence;
    }
    report
}

/// Errors of single numbers of chaotic motion, at least their sampling errors. Two samples may agree by chance.
fn with_sampling(errors: Option<QuantityErrors>, recording: &Recording) -> Option<QuantityErrors> {
    let sampling = sampling_errors_of_quantities(&recording.parts);
    errors.map(|errors| sampling.map_or(errors, |sampling| errors.larger(&sampling)))
}

/// Warning of a chaotic motion whose recorded time is too short to be a sample of its statistics.
fn short_chaos(report: &AccuracyReport, settings: &RunSettings) -> Option<Warning> {
    let rate = report.divergence_rate;
    (report.is_chaotic && rate * settings.duration < SAMPLE_EFOLDS)
        .then(|| Warning::ShortChaoticSample { growth_time: 1.0 / rate, required: SAMPLE_EFOLDS / rate })
}

/// Warning of large errors of the requested numbers.
pub(crate) fn large_errors(report: &AccuracyReport, cause: Uncertainty, outputs: &Outputs) -> Vec<Warning> {
    let errors = report.large_errors(outputs);
    let warning = (!errors.is_empty()).then_some(Warning::Uncertain { cause, errors });
    warning.into_iter().collect()
}

/// Cause for which no error is known.
fn not_verified(verification: &Verification, settings: &RunSettings) -> Option<Cause> {
    let is_short = kept_values(settings.duration) < MIN_VALUES;
    match &verification.failure {
        Some(failure) => Some(Cause::NotVerified(failure.clone())),
        None => is_short.then_some(Cause::NotCovered(Gap::ShortRecord)),
    }
}

/// Report of a run that finer steps would not improve: its errors are allowed, or hidden by the scatter between windows of the motion. `None`:
/// finer steps may improve it.
fn sufficient(
    report: &AccuracyReport,
    verification: &Verification,
    recording: &Recording,
    outputs: &Outputs,
    allowed_db: f64,
) -> Option<AccuracyReport> {
    let is_clear = report.warnings.is_empty() && report.large_errors(outputs).is_empty();
    let within = |excess: Option<f64>| is_clear && excess.is_some_and(|excess| excess <= 1.0);
    let scatter = scatter(recording);
    let beside_scatter = || {
        let over = |channel| allowed_db / allowed_db.max(HIDDEN_SHARE * scatter.of(channel).unwrap_or(0.0));
        let level_errors = LevelErrors::each(|channel| Some(report.level_errors.of(channel)? * over(channel)));
        AccuracyReport { level_errors, ..report.clone() }.excess(outputs, allowed_db)
    };
    if within(report.excess(outputs, allowed_db)) || within(beside_scatter()) {
        return Some(report.clone());
    }
    // Finer steps give another course with the same levels: both are equally valid samples.
    let ratio = report.level_errors.zip(&scatter, |error, scatter| error / scatter.max(allowed_db));
    let is_sample = verification.is_whole && verification.noise > INDEPENDENT_NOISE && !report.is_chaotic;
    let only_uncertain = report.warnings.iter().all(|warning| matches!(warning, Warning::Uncertain { .. }));
    (is_sample && only_uncertain && ratio.worst()? <= 1.0)
        .then(|| AccuracyReport { warnings: large_errors(report, Uncertainty::Sensitive, outputs), ..report.clone() })
}
