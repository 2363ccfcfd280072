//! Main sequence of a simulation: plan, execute, verify, judge.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use crate::numerics::ode::IntegrationError;
use crate::simulation::error::codes::{Cause, Rejection};
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::input::control::Control;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::series_sink::SeriesSink;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::integrate::Stepping;
use crate::simulation::recording::series::SeriesInMemory;
use crate::simulation::result::run_result::RunResult;
use crate::simulation::solve::assemble::{Solved, assemble};
use crate::simulation::solve::attempt::{Attempt, MIN_EVALUATIONS, Problem, execute};
use crate::simulation::solve::fixed_step;
use crate::simulation::solve::judge::{Progress, Verdict, judge};
use crate::simulation::solve::plan::{Candidate, CandidateSteps, Plan, Reference};
use crate::simulation::solve::verification::{Verification, or_failure};
use crate::simulation::solve::verify::verify;

/// Share of the remaining progress that a candidate takes; another candidate may have to follow.
const CANDIDATE_SHARE: f64 = 0.8;
/// Share of a candidate's progress that its run takes; the rest is its verification.
const RUN_SHARE: f64 = 0.6;
/// Largest ratio of a candidate's evaluations to those of the last attempt [-]: for a tighter tolerance, and for the whole run at a much tighter
/// one.
const TIGHTER_EVALUATIONS: u64 = 5;
const REPETITION_EVALUATIONS: u64 = 50;

/// Simulates the scene. Deterministic: the same arguments give the same bits apart from wall times. The result holds the requested
/// series, unless `control` names a receiver of them.
pub fn simulate(scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Result<RunResult, SimulationError> {
    let scene = &settings.seen(scene);
    if control.series.is_some() || settings.outputs.series.is_empty() {
        return solve(scene, settings, control);
    }
    let memory = Arc::new(SeriesInMemory::default());
    let sink: Arc<dyn SeriesSink> = memory.clone();
    let mut result = solve(scene, settings, &Control { series: Some(&sink), ..*control })?;
    let mut values = memory.take();
    for series in &mut result.series {
        series.values = values.remove(&series.number).unwrap_or_default();
    }
    Ok(result)
}

/// The first accepted attempt is the result. A rejection may insert a refined candidate. If no candidate is accepted, the last attempt
/// with a report is the result, with the errors that it states.
fn solve(scene: &Scene, settings: &RunSettings, control: &Control<'_>) -> Result<RunResult, SimulationError> {
    let begin = Instant::now();
    let furthest = Cell::new(0.0);
    let report_progress = |share: f64| {
        furthest.set(f64::max(share, furthest.get()));
        (control.progress)(furthest.get());
    };
    let control = &Control { progress: &report_progress, ..*control };
    let mut problem = Problem::new(scene, settings);
    let mut plan = Plan::of(scene, settings)?;
    let mut search = Search::default();
    while let Some(candidate) = plan.next() {
        let share = if plan.is_empty() { 1.0 } else { CANDIDATE_SHARE };
        let from = furthest.get();
        let (middle, to) = (from + RUN_SHARE * share * (1.0 - from), from + share * (1.0 - from));
        let attempt = control.part((from, middle), |control| {
            execute(&candidate, &problem, search.most_evaluations(&candidate), control)
        });
        let attempt = match or_failure(attempt)? {
            Ok(attempt) => Rc::new(attempt),
            Err(failure) => {
                if plan.is_empty() && search.kept.is_none() && !may_halve(&candidate, settings) {
                    return Err(failure);
                }
                search.fail(&candidate, failure, &mut plan, settings);
                continue;
            }
        };
        let verification = control
            .part((middle, to), |control| verify(&candidate, &attempt, search.previous.as_ref(), &problem, control))?;
        let progress =
            Progress { refinements: search.refinements, is_last: plan.is_empty(), previous: search.previous.as_ref() };
        match judge(&candidate, &attempt, &verification, &problem, &progress) {
            Verdict::Accept(report) => search.kept = Some(Kept { candidate, attempt, report, rejection: None }),
            Verdict::AcceptPrevious(report) => {
                // The repetition has verified the attempt before it.
                search.kept = search.kept.take().map(|kept| Kept { report, ..kept });
            }
            Verdict::Reject { cause, refined, report } => {
                if let (CandidateSteps::Fixed(..), Cause::Deviation { .. }) = (candidate.stepping, &cause) {
                    problem.start_in(startup_stepping(refined.as_ref(), settings));
                }
                search.reject(candidate, attempt, verification, (cause, report), refined, &mut plan);
                continue;
            }
        }
        break;
    }
    let Some(Kept { candidate, attempt, report, rejection }) = search.kept else {
        return Err(search.last_failure.unwrap_or(SimulationError::NoEquilibrium("no candidate".into())));
    };
    let mut rejections = search.rejections;
    if let Some(rejection) = rejection {
        rejections.remove(rejection);
    }
    let solved = Solved { candidate, attempt, report, rejections, not_eligible: plan.not_eligible };
    let result = assemble(&problem, solved, begin, control)?;
    (control.progress)(1.0);
    Ok(result)
}

/// State of the search after the candidates so far.
#[derive(Default)]
struct Search {
    rejections: Vec<Rejection>,
    /// The last attempt, the reference of a sample or of a tighter run.
    previous: Option<(Rc<Attempt>, Verification)>,
    refinements: usize,
    /// The result, or the last attempt with a report while candidates are left.
    kept: Option<Kept>,
    last_failure: Option<SimulationError>,
}

/// An attempt that is the result unless a later candidate replaces it.
struct Kept {
    candidate: Candidate,
    attempt: Rc<Attempt>,
    report: AccuracyReport,
    /// Index of its rejection, which is dropped if it becomes the result.
    rejection: Option<usize>,
}

impl Search {
    /// Limit on evaluations of another attempt. An attempt above it is aborted, and the previous result remains valid.
    fn most_evaluations(&self, candidate: &Candidate) -> Option<u64> {
        let CandidateSteps::Controlled(..) = candidate.stepping else { return None };
        let times = match candidate.reference {
            Reference::LooserRun => REPETITION_EVALUATIONS,
            _ => TIGHTER_EVALUATIONS,
        };
        Some(times * self.kept.as_ref()?.attempt.work.rhs_evaluations.max(MIN_EVALUATIONS))
    }

    /// Records a candidate that failed. Fixed steps that diverge are halved; those that meet a collision of balls are not, because no
    /// fixed step resolves it.
    fn fail(&mut self, candidate: &Candidate, failure: SimulationError, plan: &mut Plan, settings: &RunSettings) {
        let is_impact = matches!(failure, SimulationError::Integration { source: IntegrationError::Impact { .. }, .. });
        if let CandidateSteps::Fixed(method, step) = candidate.stepping
            && may_halve(candidate, settings)
            && !is_impact
        {
            let stepping = CandidateSteps::Fixed(method, fixed_step::HALVED * step);
            plan.insert(Candidate { stepping, ..*candidate });
        }
        if candidate.reference == Reference::LooserRun {
            // The result of the looser run remains valid.
            plan.clear();
        }
        self.rejections.push(rejection(candidate, Cause::Failed(failure.clone())));
        self.last_failure = Some(failure);
    }

    fn reject(
        &mut self,
        candidate: Candidate,
        attempt: Rc<Attempt>,
        verification: Verification,
        (cause, report): (Cause, Option<AccuracyReport>),
        refined: Option<Candidate>,
        plan: &mut Plan,
    ) {
        self.rejections.push(rejection(&candidate, cause));
        self.refinements = if refined.is_some() { self.refinements + 1 } else { 0 };
        if refined.is_some_and(|refined| refined.reference == Reference::LooserRun) {
            // After refinement against the noise of the steps, no looser tolerance is tried again.
            plan.clear();
        }
        if let Some(report) = report {
            let rejection = Some(self.rejections.len() - 1);
            self.kept = Some(Kept { candidate, attempt: Rc::clone(&attempt), report, rejection });
        }
        if refined.is_some_and(|refined| refined.is_compared_with_previous()) {
            self.previous = Some((attempt, verification));
        }
        if let Some(refined) = refined {
            plan.insert(refined);
        }
    }
}

/// Steps of the start-up phase after a rejection of fixed steps.
fn startup_stepping(refined: Option<&Candidate>, settings: &RunSettings) -> Stepping {
    match refined.map(|refined| refined.stepping) {
        Some(CandidateSteps::Fixed(_, step)) => fixed_step::by(step),
        _ => Stepping { relative_tolerance: settings.tightest(), ..Stepping::of(settings) },
    }
}

/// True if the fixed steps were chosen automatically and may be halved.
fn may_halve(candidate: &Candidate, settings: &RunSettings) -> bool {
    match candidate.stepping {
        CandidateSteps::Fixed(_, step) => {
            settings.fixed_step.is_none()
                && candidate.reference == Reference::Refined
                && fixed_step::HALVED * step >= fixed_step::SHORTEST
        }
        _ => false,
    }
}

fn rejection(candidate: &Candidate, cause: Cause) -> Rejection {
    let (method, step, tolerance) = match candidate.stepping {
        CandidateSteps::Own(step) => (None, step, None),
        CandidateSteps::Fixed(method, step) => (Some(method), Some(step), None),
        CandidateSteps::Controlled(method, tolerance) => (Some(method), None, Some(tolerance)),
    };
    Rejection { level: candidate.level, method, step, tolerance, cause }
}
