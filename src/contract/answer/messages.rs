//! Every sentence about a result that a user reads: one code, one text.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use crate::contract::json::numbers::significant;
use raceway_core::numerics::ode::{ChoiceReason, Method};
use raceway_core::simulation::error::codes::{
    Cause, ErrorBasis, Gap, Ineligible, NotEligible, NotEligibleReason, Quantity, QuantityError, Refinement, Rejection,
    Uncertainty, Warning,
};
use raceway_core::simulation::error::comparison::SILENCE;
use raceway_core::simulation::error::errors::{LevelErrors, QuantityErrors};
use raceway_core::simulation::input::channel::Channel;
use raceway_core::simulation::input::model_level::ModelLevel;
use raceway_core::simulation::model::failure::SimulationError;
use raceway_core::simulation::result::metrics::{SolverReport, level_db};

/// What a user should know about a result or a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MessageAnswer {
    /// What it is about; programs branch on this.
    pub code: MessageCode,
    /// How much it matters.
    pub severity: Severity,
    /// One or two plain sentences: what happened, the numbers, and what to do.
    pub text: String,
    /// The numbers and names of the text, by name with unit.
    #[serde(flatten)]
    #[schema(additional_properties, value_type = BTreeMap<String, Value>)]
    pub values: BTreeMap<String, Value>,
}

/// `info`: how the result was made. `warning`: a reason to doubt a number or the whole result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    Info,
    Warning,
}

/// Code of a message; programs branch on it.
///
/// `uncertain`: Errors of numbers are large. Increase the time or tighten the tolerance that the text names.
///
/// `not-resolved`: Refinement still changes a level by more than 1 dB. The level has no error, is marked `resolved: false`, and is never the best of
/// a study. The text names what may resolve it.
///
/// `not-stationary`: A level rises or falls throughout the recorded time. Increase `settle_s`, or `duration_s` if the level oscillates.
///
/// `stationarity-not-checked`: A level below −20 dB, or below numerical noise, was not checked for changes along the recorded time.
///
/// `short-chaotic-sample`: A chaotic motion was recorded for too short a time. Increase `duration_s`.
///
/// `record-too-short`: The recorded time is too short for an error estimate. Increase `duration_s`.
///
/// `not-verified`: The verification failed, so that no error is known. The text names the failure.
///
/// `partly-verified`: The verification covers the first part of the recorded time alone.
///
/// `later-window-failed`: A later window could not be recorded: the scatter of the levels is that of the recorded time alone.
///
/// `model-not-confirmed`: The selected model level deviates by more than is allowed. Select a richer level, or none.
///
/// `error-unknown`: The window of verification does not cover the run. Leave `solver.rung` out, or select `full`.
///
/// `unstable-step`: The fixed step is unstable and the result is wrong. Shorten `solver.fixed_step_us`.
///
/// `start-transient`: The recorded time may contain free vibration of the start. Increase `settle_s`.
///
/// `cage-transient`: The recorded time may contain vibration of the cage along its axis. Increase `settle_s`.
///
/// `tilt-transient`: Cage and balls may still begin to tilt in viscous oil. Increase `settle_s`.
///
/// `candidate-rejected`: A model level or step was tried and rejected. Another one made the result.
///
/// `model-not-eligible`: A model level was not tried. The text names the reason.
///
/// `method-chosen`: The reason why `auto` runs this integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MessageCode {
    Uncertain,
    NotResolved,
    NotStationary,
    StationarityNotChecked,
    ShortChaoticSample,
    RecordTooShort,
    NotVerified,
    PartlyVerified,
    LaterWindowFailed,
    ModelNotConfirmed,
    ErrorUnknown,
    UnstableStep,
    StartTransient,
    CageTransient,
    TiltTransient,
    CandidateRejected,
    ModelNotEligible,
    MethodChosen,
}

/// Time constants above this are not worth waiting for [s].
const LONG_WAIT_S: f64 = 60.0;

/// Longest time constant that is shown as a number [s].
const LONGEST_SHOWN_S: f64 = 1000.0;

/// The messages of a result: warnings first, then how it was made.
pub fn of_result(warnings: &[Warning], solver: &SolverReport) -> Vec<MessageAnswer> {
    let chosen = solver.choice.iter().map(|reason| {
        let text = format!("Integrator {}: {}.", solver.method, choice_text(reason));
        message(MessageCode::MethodChosen, Severity::Info, text, [("method", json!(solver.method))])
    });
    let warnings = warnings.iter().map(of_warning);
    let rejections = solver.rejections.iter().map(of_rejection);
    let not_eligible = solver.not_eligible.iter().map(of_not_eligible);
    warnings.chain(rejections).chain(not_eligible).chain(chosen).collect()
}

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

/// How the errors were estimated, as one sentence.
pub fn how(basis: &ErrorBasis) -> String {
    match basis {
        ErrorBasis::None => "No error is stated; see messages.".into(),
        ErrorBasis::Silence => "Nothing moves, so that there is no level to compare.".into(),
        ErrorBasis::RicherModel { level, window } => format!(
            "Errors are the deviation of the run from the model level {} over {}, model and integration together.",
            level.name(),
            time(*window)
        ),
        ErrorBasis::Repetition { refinement, window, recorded } => format!(
            "Errors are the deviation of the run from a repetition of {} of the recorded {} {}.",
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

/// The message of a warning.
pub fn of_warning(warning: &Warning) -> MessageAnswer {
    let (code, text, values): (MessageCode, String, Vec<(&str, Value)>) = match warning {
        Warning::Uncertain { cause, errors } => {
            let (reason, remedy) = match cause {
                Uncertainty::Steps => {
                    ("refinement still changes them", "Select a tighter relative_tolerance, or increase duration_s.")
                }
                Uncertainty::Sensitive => ("the least disturbance leads to other peaks", "Increase duration_s."),
                Uncertainty::ShortSample => {
                    ("the motion is chaotic and the recorded time is a short sample of it", "Increase duration_s.")
                }
                Uncertainty::Uneven => ("levels vary along the recorded time", "Increase duration_s, or settle_s."),
            };
            let text = format!("Large errors of {}: {reason}. {remedy}", listed(errors));
            let values = errors.iter().map(|error| (field(error.quantity), json!(significant(error.error, 3))));
            (MessageCode::Uncertain, text, values.collect())
        }
        Warning::NotResolved { change_db, is_selected } => {
            let remedy = match is_selected {
                true => "Leave method, step and tolerance to the program, or tighten them.",
                false => "Select `solver.method` and a tighter `relative_tolerance`, or increase duration_s.",
            };
            let text = format!(
                "A level is not resolved: refinement still changes it by {change_db:.1} dB, so that it has no error and its spectrum no \
                 lines. {remedy}"
            );
            (MessageCode::NotResolved, text, numbers(&[("change_db", *change_db)]))
        }
        Warning::NotStationary { channel, change_db } => {
            let text = format!(
                "Level not stationary: {channel} changed by {change_db:+.1} dB during the recorded time. Increase settle_s, or \
                 duration_s if the level oscillates."
            );
            let values =
                vec![("channel", json!(channel.to_string())), ("change_db", json!(significant(*change_db, 3)))];
            (MessageCode::NotStationary, text, values)
        }
        Warning::StationarityNotChecked { channels } => {
            let level = |(channel, rms): &(Channel, f64)| {
                let noise = if *rms <= SILENCE { ", numerical noise" } else { "" };
                format!("{channel} ({} dB{noise})", signed(level_db(*rms).unwrap_or(f64::NEG_INFINITY)))
            };
            let levels: Vec<String> = channels.iter().map(level).collect();
            let names: Vec<String> = channels.iter().map(|(channel, _)| channel.to_string()).collect();
            let text = format!(
                "Levels below −20 dB were not checked for changes along the recorded time: {}.",
                levels.join(", ")
            );
            (MessageCode::StationarityNotChecked, text, vec![("channels", json!(names))])
        }
        Warning::ShortChaoticSample { growth_time, required } => {
            let text = format!(
                "The motion is chaotic, and disturbances grow by a factor of e in {growth_time:.3} s: the recorded time is too short to be a \
                 sample of it. Set duration_s to {required:.2} or more."
            );
            let values = [("growth_time_s", *growth_time), ("required_duration_s", *required)];
            (MessageCode::ShortChaoticSample, text, numbers(&values))
        }
        Warning::RecordTooShort { recorded, required } => {
            let text = format!(
                "{} are too short for an error estimate. Set duration_s to {} or more.",
                time(*recorded),
                significant(*required, 2)
            );
            (MessageCode::RecordTooShort, text, numbers(&[("required_duration_s", *required)]))
        }
        Warning::NotVerified(failure) => (
            MessageCode::NotVerified,
            format!("No error is known, because the verification failed: {failure}."),
            vec![],
        ),
        Warning::PartlyVerified { window, cause } => {
            let text = format!(
                "The errors were verified over the first {} only, because the repetition of the whole run failed: {cause}.",
                time(*window)
            );
            (MessageCode::PartlyVerified, text, numbers(&[("window_s", *window)]))
        }
        Warning::LaterWindowFailed(failure) => {
            let text = format!(
                "The scatter of the levels is that of the recorded time alone: a later window failed, {failure}."
            );
            (MessageCode::LaterWindowFailed, text, vec![])
        }
        Warning::ModelNotConfirmed { level, allowed_db, cause } => {
            let text = format!(
                "The selected model level {} is not confirmed within {} dB: {}.",
                level.name(),
                significant(*allowed_db, 6),
                cause_text(cause)
            );
            let values = vec![("rung", json!(level.name())), ("allowed_db", json!(significant(*allowed_db, 6)))];
            (MessageCode::ModelNotConfirmed, text, values)
        }
        Warning::ErrorUnknown(gap) => {
            let text =
                format!("No error is stated, because the verification does not cover the run: {}.", gap_text(gap));
            (MessageCode::ErrorUnknown, text, vec![])
        }
        Warning::UnstableStep(unstable) => {
            let largest = unstable.largest_stable();
            let text = format!(
                "Levels can be wrong although the motion stays bounded: {unstable}. Set fixed_step_us to {} or less.",
                significant(1e6 * largest, 2)
            );
            let values = [("step_s", unstable.step), ("largest_stable_step_s", largest)];
            (MessageCode::UnstableStep, text, numbers(&values))
        }
        Warning::StartTransient { time_constant, settle, required, constant_speed } => {
            let remedy = if *required > LONG_WAIT_S {
                "A larger load or more damping shortens it.".to_owned()
            } else if *constant_speed {
                format!("Set settle_s to {required:.2}.")
            } else {
                format!("Hold the first speed for {required:.2} s before anything is recorded.")
            };
            let text = format!(
                "The recorded time may contain the initial transient: free vibration of the spindle decays with a time constant of {} s, and \
                 settle_s is {settle:?}. {remedy}",
                if *time_constant > LONGEST_SHOWN_S {
                    format!("more than {LONGEST_SHOWN_S}")
                } else {
                    significant(*time_constant, 3).to_string()
                }
            );
            let values = [("time_constant_s", *time_constant), ("required_settle_s", *required)];
            (MessageCode::StartTransient, text, numbers(&values))
        }
        Warning::CageTransient { settle, required } => {
            let text = format!(
                "The recorded time may contain vibration of the cage along its axis, which is hardly damped: settle_s is {settle:?}. Set \
                 settle_s to {required} or more."
            );
            (MessageCode::CageTransient, text, numbers(&[("required_settle_s", *required)]))
        }
        Warning::TiltTransient { settle, required } => {
            let text = format!(
                "Cage and balls may still begin to tilt, which takes seconds in so viscous an oil: settle_s is {settle:?}. Set settle_s to \
                 {required}."
            );
            (MessageCode::TiltTransient, text, numbers(&[("required_settle_s", *required)]))
        }
    };
    let severity = if warning.is_remark() { Severity::Info } else { Severity::Warning };
    message(code, severity, text, values)
}

fn of_rejection(rejection: &Rejection) -> MessageAnswer {
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

fn cause_text(cause: &Cause) -> String {
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

fn gap_text(gap: &Gap) -> String {
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
        Gap::ShortRecord => "the recorded time is shorter than its window".into(),
        Gap::Chaos => "neighbouring trajectories diverge".into(),
    }
}

fn ineligible(reason: Ineligible) -> &'static str {
    match reason {
        Ineligible::MethodSelected => "a method or a fixed step was selected",
        Ineligible::NoModelError => "model_tolerance_db is 0",
        Ineligible::TermOn => "a term that it leaves out is on",
        Ineligible::Hydrodynamics => "hydrodynamic forces tilt balls and cage later than its verification shows",
        Ineligible::SpeedChanges => "the speed changes, and its verification shows nothing of later speeds",
        Ineligible::ShortRun => "its verification would take too large a part of the run",
        Ineligible::MayTilt => {
            "cage and balls may tilt in so viscous a lubricant at so low a speed, which its planar verification does not show"
        }
        Ineligible::HeavyCage => {
            "a crown cage so heavy, or so far off its balls, may tilt them, which its planar verification does not show"
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

/// Deviations of a verification, as a list.
fn deviation(levels: &LevelErrors, quantities: Option<&QuantityErrors>) -> String {
    let mut all: Vec<String> = levels.worst().iter().map(|level| format!("{level:.4} dB of a level")).collect();
    if let Some(errors) = quantities {
        let shares = [
            ("the largest load", errors.max_load),
            ("the cage speed", errors.cage_speed),
            ("the slip", errors.max_slip),
            ("the pocket load", errors.max_pocket_load),
            ("the cage orbit", errors.orbit_radius),
        ];
        let named = |(name, share): (&str, f64)| format!("{} % of {name}", significant(100.0 * share, 3));
        all.extend(shares.into_iter().filter(|(_, share)| *share > 0.0).map(named));
    }
    if all.is_empty() { "an unknown amount".into() } else { all.join(", ") }
}

fn exceeded(beyond: &[Quantity]) -> String {
    let names: Vec<&str> = beyond.iter().map(|quantity| name(*quantity)).collect();
    if names.is_empty() { String::new() } else { format!("; too much for {}", names.join(", ")) }
}

fn listed(errors: &[QuantityError]) -> String {
    let one = |QuantityError { quantity, error }: &QuantityError| match quantity {
        Quantity::Level => format!("{} ({error:.1} dB or more)", name(*quantity)),
        _ => format!("{} ({:.0} % or more)", name(*quantity), 100.0 * error),
    };
    errors.iter().map(one).collect::<Vec<String>>().join(", ")
}

fn name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Level => "the level",
        Quantity::MaxLoad => "the largest contact load",
        Quantity::Slip => "the largest slip",
        Quantity::CageSpeed => "the cage speed",
        Quantity::PocketLoad => "the largest pocket load",
        Quantity::CageOrbit => "the orbit of the cage",
    }
}

fn field(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Level => "level_error_db",
        Quantity::MaxLoad => "max_load_error",
        Quantity::Slip => "max_slip_error",
        Quantity::CageSpeed => "cage_speed_error",
        Quantity::PocketLoad => "max_pocket_load_error",
        Quantity::CageOrbit => "orbit_radius_error",
    }
}

fn time(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{} ms", significant(1e3 * seconds, 4))
    } else {
        format!("{} s", significant(seconds, 4))
    }
}

/// A number with one decimal and a minus sign.
fn signed(value: f64) -> String {
    format!("{value:.1}").replace('-', "−")
}

fn numbers<'a>(values: &[(&'a str, f64)]) -> Vec<(&'a str, Value)> {
    values.iter().map(|(name, value)| (*name, json!(significant(*value, 3)))).collect()
}

fn message<'a>(
    code: MessageCode,
    severity: Severity,
    text: String,
    values: impl IntoIterator<Item = (&'a str, Value)>,
) -> MessageAnswer {
    let values = values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    MessageAnswer { code, severity, text, values }
}
