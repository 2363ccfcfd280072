//! One comparison: the deviation of a run from its reference, and whether that covers the run.

use crate::simulation::error::codes::{ErrorBasis, Refinement};
use crate::simulation::error::comparison::Deviation;
use crate::simulation::input::control::{Control, Live, Phase};
use crate::simulation::model::failure::SimulationError;
use crate::simulation::solve::attempt::{Attempt, Problem};
use crate::simulation::solve::plan::{Candidate, Reference};
use crate::simulation::solve::verification::{TIGHTEST, Verification};
use crate::simulation::solve::verify_dynamics::by_refinement;
use crate::simulation::solve::verify_reduced::by_richer_model;
use std::rc::Rc;

/// Compares an attempt with its reference.
pub(crate) fn verify(
    candidate: &Candidate,
    attempt: &Attempt,
    previous: Option<&(Rc<Attempt>, Verification)>,
    problem: &Problem<'_>,
    control: &Control<'_>,
) -> Result<Verification, SimulationError> {
    (control.live)(&Live::of(Phase::Judging));
    let control = &control.without_live();
    match (candidate.reference, previous) {
        (Reference::RicherModel, _) => by_richer_model(candidate.level, attempt, problem, control),
        (Reference::IndependentSample, Some((before, verified))) => Ok(Verification {
            deviation: Some(Deviation::of_samples(&before.recording, &attempt.recording)),
            basis: ErrorBasis::BatchMeans { refinement: Refinement::Step(2.0) },
            divergence: verified.divergence,
            is_whole: true,
            ..Verification::default()
        }),
        (Reference::LooserRun, Some((before, verified))) => {
            // The run itself is the tighter one; the errors are its deviation from the looser run.
            let tolerance = before.tolerance.unwrap_or(TIGHTEST);
            let recorded = problem.settings.duration;
            let refinement = Refinement::Tolerance(tolerance, problem.settings.method);
            Ok(Verification {
                deviation: Some(Deviation::of_runs(&before.recording, &attempt.recording)),
                basis: ErrorBasis::Repetition { refinement, window: recorded, recorded },
                divergence: verified.divergence,
                is_whole: true,
                ..Verification::default()
            })
        }
        _ => by_refinement(attempt, problem, control),
    }
}
