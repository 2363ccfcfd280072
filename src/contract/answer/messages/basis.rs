//! How a result was made: verification of the model level, basis of the errors, choice of the integrator.

use raceway_core::numerics::ode::{ChoiceReason, Method};
use raceway_core::simulation::error::codes::{ErrorBasis, Refinement};
use raceway_core::simulation::error::report::AccuracyReport;
use raceway_core::simulation::input::model_level::ModelLevel;
use raceway_core::simulation::result::metrics::SolverReport;

use super::words::time;

/// How the model level was verified, as one sentence.
pub fn check(solver: &SolverReport, basis: &ErrorBasis) -> String {
    match basis {
        ErrorBasis::RicherModel { level, window } => {
            format!(
                "The model level {} was compared with {} over {}.",
                solver.level.name(),
                level.name(),
                time(*window)
            )
        }
        _ if solver.level.is_reduced() => format!("The model level {} was not verified.", solver.level.name()),
        _ if solver.tilt_window.is_some() => {
            let window = time(solver.tilt_window.unwrap_or(0.0));
            format!("The model level planar was compared with full over {window}.")
        }
        _ if solver.level == ModelLevel::Planar => {
            "The planar dynamics are complete for this scene; left_out names the absent motion.".into()
        }
        _ => "The full dynamics have no richer model to compare with.".into(),
    }
}

/// How the errors were estimated: one sentence, and a second one where levels change along the recorded time.
pub fn how(accuracy: &AccuracyReport) -> String {
    let of_basis = by_basis(&accuracy.basis);
    let changing: Vec<String> = accuracy.changing.iter().map(|channel| channel.to_string()).collect();
    match changing.as_slice() {
        [] => of_basis,
        [one] => {
            format!("{of_basis} That of the level of {one} is its change along the recorded time, which is larger.")
        }
        [others @ .., last] => format!(
            "{of_basis} Those of the levels of {} and {last} are their changes along the recorded time, which are larger.",
            others.join(", ")
        ),
    }
}

fn by_basis(basis: &ErrorBasis) -> String {
    match basis {
        ErrorBasis::None => "No error is stated; see messages.".into(),
        ErrorBasis::Silence => "Nothing moves, so that there is no level to compare.".into(),
        ErrorBasis::RicherModel { level, window } => format!(
            "Errors are the deviation of the run from the model level {} over {}, model and integration together.",
            level.name(),
            time(*window)
        ),
        ErrorBasis::Repetition { refinement, window, recorded } => format!(
            "Errors follow from the deviation of the run from a repetition of {} of the recorded {} {}.",
            time(*window),
            time(*recorded),
            refined(refinement)
        ),
        ErrorBasis::BatchMeans { refinement } => format!(
            "The motion is chaotic: errors are standard errors by ten batch means, or the deviation from another sample {} if that is larger.",
            refined(refinement)
        ),
    }
}

fn refined(refinement: &Refinement) -> String {
    match refinement {
        Refinement::Step(share) if *share > 1.0 => format!("with {share} times the step"),
        Refinement::Step(share) => format!("with {share} of the step"),
        Refinement::Tolerance(tolerance, Method::Auto) => format!("at a relative tolerance of {tolerance:.0e}"),
        Refinement::Tolerance(tolerance, method) => {
            format!("at a relative tolerance of {tolerance:.0e} by {}", method.name())
        }
    }
}

/// Why an integrator runs its method.
pub fn choice_text(reason: &ChoiceReason) -> String {
    let changed = |changes: &u32| match changes {
        0 | 1 => String::new(),
        _ => format!("; the method changed {changes} times"),
    };
    match reason {
        ChoiceReason::ExplicitIsCheaper { explicit, stiff, rate, changes } => format!(
            "cheaper at this tolerance: {explicit:.1e} evaluations for a second of motion, for which gear takes {stiff:.1e}, made comparable; \
             fastest rate |λ| = {rate:.1e} 1/s{}",
            changed(changes)
        ),
        ChoiceReason::NotStiff { rate, changes } => format!(
            "not stiff: explicit steps are short against the fastest rate seen, |λ| = {rate:.1e} 1/s{}",
            changed(changes)
        ),
        ChoiceReason::Stiff { rate, limit, step, changes } => format!(
            "stiff: the fastest rate |λ| = {rate:.1e} 1/s would hold explicit steps to {limit:.1e} s; gear's are {step:.1e} s in the mean, \
             h·|λ| = {:.1}, and cheaper{}",
            step * rate,
            changed(changes)
        ),
        ChoiceReason::TriedFirst { step } => {
            format!("steps of {:.2} µs, implicit in the stiff terms: tried before error control", 1e6 * step)
        }
    }
}
