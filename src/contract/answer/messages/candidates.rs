//! Candidates that did not become the result.

use serde_json::json;

use super::answer::{MessageAnswer, MessageCode, Severity, message};
use super::words::{deviation, exceeded, time};
use crate::contract::json::numbers::significant;
use raceway_core::simulation::error::codes::{Cause, Gap, Ineligible, NotEligible, NotEligibleReason, Rejection};
use raceway_core::simulation::model::failure::SimulationError;

/// Why a model level is no candidate.
pub fn of_not_eligible(not_eligible: &NotEligible) -> MessageAnswer {
    let levels: Vec<&str> = not_eligible.levels.iter().map(|level| level.name()).collect();
    let reason = match &not_eligible.reason {
        NotEligibleReason::Known(reason) => ineligible(*reason).to_owned(),
        NotEligibleReason::CannotRepresent(reason) => reason.to_string(),
    };
    let text = match &levels[..] {
        [level] => format!("Model level {level} was not tried: {reason}."),
        _ => format!("Model levels {} were not tried: {reason}.", levels.join(", ")),
    };
    message(MessageCode::ModelNotEligible, Severity::Info, text, [("rungs", json!(levels))])
}

pub fn of_rejection(rejection: &Rejection) -> MessageAnswer {
    let stepping = match (rejection.method, rejection.step, rejection.tolerance) {
        (_, Some(step), _) => format!(" in steps of {} µs", significant(1e6 * step, 3)),
        (Some(method), _, Some(tolerance)) => {
            format!(" at a relative tolerance of {tolerance:.0e} ({})", method.name())
        }
        _ => String::new(),
    };
    let text =
        format!("Model level {}{stepping} was rejected: {}.", rejection.level.name(), cause_text(&rejection.cause));
    let mut values = vec![("rung", json!(rejection.level.name()))];
    values.extend(rejection.step.map(|step| ("step_s", json!(step))));
    values.extend(rejection.tolerance.map(|tolerance| ("relative_tolerance", json!(tolerance))));
    values.extend(rejection.method.map(|method| ("method", json!(method.name()))));
    message(MessageCode::CandidateRejected, Severity::Info, text, values)
}

pub fn cause_text(cause: &Cause) -> String {
    match cause {
        Cause::Failed(SimulationError::NotApplicable { reason, .. }) => reason.to_string(),
        Cause::Failed(failure) => format!("it failed, {failure}"),
        Cause::Deviation { levels, quantities, beyond } => {
            format!("the verification deviates by {}{}", deviation(levels, quantities.as_ref()), exceeded(beyond))
        }
        Cause::NotCovered(gap) => format!("the verification does not cover the run, {}", gap_text(gap)),
        Cause::CourseDiffers { levels, quantities, beyond } => format!(
            "finer steps lead the whole run elsewhere, by {}{}",
            deviation(levels, quantities.as_ref()),
            exceeded(beyond)
        ),
        Cause::Instability => "disturbances grow faster than in a chaotic motion, so that the step is unstable".into(),
        Cause::ShortChaos => "disturbances grow, and the recorded time is too short to be a sample of chaos".into(),
        Cause::NoDecay => "disturbances do not decay, and long steps damp light oscillations along the axis".into(),
        Cause::SamplesDiffer => "the motion is chaotic and shows other levels with other steps".into(),
        Cause::NotVerified(failure) => format!("the verification failed, {failure}"),
    }
}

pub fn gap_text(gap: &Gap) -> String {
    let percent = |share: &f64| significant(100.0 * share, 2);
    match gap {
        Gap::CageSpeedChanged(share) => format!("the cage speed changed by {} % after its window", percent(share)),
        Gap::BallsDrifted(share) => {
            format!("balls moved on in their pockets by {} % of their spacing after its window", percent(share))
        }
        Gap::InertiaExceedsPreload(share) => format!(
            "the inertia force of the spindle is {} % (rms) of its static load, and its vibration decays slowly",
            percent(share)
        ),
        Gap::LevelScatters(channel, scatter) => {
            format!("the level of {channel} scatters by {scatter:.1} dB along the recorded time")
        }
        Gap::BallsLeavePlane { before, after, window } => format!(
            "balls leave the plane, with contact angles of {:.2}° and then {:.2}° within {}",
            before.to_degrees(),
            after.to_degrees(),
            time(*window)
        ),
        Gap::MayTilt => "cage and balls may tilt in so viscous a lubricant at so low a speed".into(),
        Gap::HeavyCage => "a crown cage so heavy, or so far off its balls, may tilt them".into(),
        Gap::SpeedChanges => "the speed changes".into(),
        Gap::LoadsChange => "a load changes".into(),
        Gap::ShortRecord => "the recorded time is shorter than its window".into(),
        Gap::Chaos => "neighbouring trajectories diverge".into(),
    }
}

fn ineligible(reason: Ineligible) -> &'static str {
    match reason {
        Ineligible::MethodSelected => "a method or a fixed step was selected",
        Ineligible::NoModelError => "model_tolerance_db is 0",
        Ineligible::TermOn => "a term that it leaves out is on",
        Ineligible::Hydrodynamics => "hydrodynamic forces tilt balls and cage later than a verification shows",
        Ineligible::SpeedChanges => "the speed changes, and a verification shows nothing of later speeds",
        Ineligible::LoadsChange => "a load changes, and a verification shows nothing of later loads",
        Ineligible::ShortRun => "verification would take too large a part of the run",
        Ineligible::MayTilt => {
            "cage and balls may tilt in so viscous a lubricant at so low a speed, which a planar verification does not show"
        }
        Ineligible::HeavyCage => {
            "a crown cage so heavy, or so far off its balls, may tilt them, which a planar verification does not show"
        }
    }
}
