//! Messages of a machine.

use raceway_core::machine::codes::{
    LastStep, LaterChange, LeanModel, LevelDeviation, MachineWarning, RejectedStep, StepCause,
};
use raceway_core::machine::input::Machine;
use raceway_core::simulation::error::codes::Warning;
use serde_json::{Value, json};

use super::answer::{MessageAnswer, MessageCode, Severity, message};
use super::bearing::{open_side, overloaded};
use super::warnings::of_warning;
use super::words::{numbers, time};
use crate::contract::json::limits;
use crate::contract::json::numbers::significant;
use crate::contract::json::units::US;

/// Longest time constant that is shown as a number [s].
const LONGEST_SHOWN_S: f64 = 1000.0;

/// The message of a warning, or of a remark.
pub fn of_machine(machine: &Machine, warning: &MachineWarning) -> MessageAnswer {
    let mut severity = Severity::Warning;
    let (code, text, values): (MessageCode, String, Vec<(&str, Value)>) = match warning {
        MachineWarning::StartTransient { time_constant, settle, required, constant_speed } => {
            let is_short = *time_constant <= LONGEST_SHOWN_S;
            let time_constant_s = significant(*time_constant, 3);
            let slowest = if is_short {
                format!("decays with a time constant of {time_constant_s} s")
            } else {
                "hardly decays, or grows,".to_owned()
            };
            let longest = limits::of_rotor_field("/settle_s").map_or(0.0, |limits| limits.highest);
            let remedy = if *required > longest {
                "More damping of the shaft, of mounts and seats (their tilt, too), or a larger load of the bearings shortens it.".to_owned()
            } else if *constant_speed {
                format!("Set settle_s to {required:.2}.")
            } else {
                format!("Hold the first speed for {required:.2} s before anything is recorded.")
            };
            let text = format!(
                "The recorded time may contain free motion from the start: the slowest of shaft and bearings {slowest} \
                 by the linear analysis, and settle_s is {}. {remedy}",
                significant(*settle, 3)
            );
            let values = [("time_constant_s", *time_constant), ("required_settle_s", *required)];
            (MessageCode::StartTransient, text, if is_short { numbers(&values) } else { vec![] })
        }
        MachineWarning::NotStationary { channel, change_db } => {
            let channel = channel.named(machine).to_string();
            let rises = "A level that rises on belongs to a motion that grows by itself, such as whirl.";
            let growth = if *change_db > 0.0 { format!(" {rises}") } else { String::new() };
            let text = format!(
                "Level not stationary: {channel} changed by {change_db:+.1} dB during the recorded time. Increase settle_s, or duration_s if \
                 the level oscillates.{growth}"
            );
            let values = vec![("channel", json!(channel)), ("change_db", json!(significant(*change_db, 3)))];
            (MessageCode::NotStationary, text, values)
        }
        MachineWarning::UnnamedLine { channel, frequency, amplitude } => {
            let channel = channel.named(machine).to_string();
            let [frequency_hz, amplitude] = [*frequency, *amplitude].map(|value| significant(value, 4));
            let text = format!(
                "No order of the shaft, ball passage or load makes the strongest line of {channel}, {amplitude} m/s² at {frequency_hz} Hz. The shaft \
                 may whirl by itself: balls that the pockets of a cage hold can drive it, which the linear analysis and `is_stable` leave out. Wider \
                 pockets or bearings further apart may end it."
            );
            let values = vec![
                ("channel", json!(channel)),
                ("frequency_hz", json!(frequency_hz)),
                ("amplitude", json!(amplitude)),
            ];
            (MessageCode::UnnamedLine, text, values)
        }
        MachineWarning::Uncertain { channel, error_db, allowed_db, step, last } => {
            let channel = channel.named(machine).to_string();
            let half = significant(0.5 * US.to_user(*step), 2);
            let remedy = match last {
                LastStep::Selected => format!("Leave step_us to the program, or set it to {half}."),
                LastStep::Shortest => format!("No shorter step was tried; set step_us to {half}."),
                LastStep::Irregular => {
                    "Twice these steps had no larger error: the motion is irregular, and its level is that of \
                     a sample. Increase duration_s."
                        .to_owned()
                }
            };
            let text = format!(
                "The level of {channel} has an error of {} dB, more than {allowed_db} dB: half of the steps of {} µs change it. {remedy}",
                significant(*error_db, 2),
                significant(US.to_user(*step), 3)
            );
            let values = vec![("channel", json!(channel)), ("level_error_db", json!(significant(*error_db, 3)))];
            (MessageCode::Uncertain, text, values)
        }
        MachineWarning::PartlyVerified { window, change, step } => {
            let later = match change {
                LaterChange::Speed => "the speed changes after it".to_owned(),
                LaterChange::Load { place, at: None } => format!("operation.loads[{place}] changes after it"),
                LaterChange::Load { place, at: Some(at) } => {
                    format!("the shock of operation.loads[{place}] begins at t = {} s", significant(*at, 4))
                }
            };
            let text = format!(
                "The level errors were verified over the first {} of the recorded time only, and {later}. Compare with a run whose step_us \
                 is {}.",
                time(*window),
                significant(0.5 * US.to_user(*step), 3)
            );
            (MessageCode::PartlyVerified, text, numbers(&[("window_s", *window)]))
        }
        MachineWarning::Overloaded { bearing, load, pressure } => {
            return overloaded(&machine.bearings[*bearing].name, *load, *pressure);
        }
        MachineWarning::OpenSide { bearing, load } => return open_side(&machine.bearings[*bearing].name, *load),
        MachineWarning::Surface { bearing, warning } => return of_surface(&machine.bearings[*bearing].name, warning),
        MachineWarning::ModelNotConfirmed(deviation) => {
            let allowed_db = significant(deviation.allowed_db, 6);
            let text = format!(
                "The selected model level {} is not confirmed within {allowed_db} dB: {}. Leave out solver.rung.",
                name(&deviation.model),
                of_deviation(machine, deviation)
            );
            (MessageCode::ModelNotConfirmed, text, level_values(machine, deviation))
        }
        MachineWarning::LevelRejected(deviation) => {
            severity = Severity::Info;
            let text = format!(
                "Rejected: {}. {}, more than {} dB.",
                name(&deviation.model),
                capital(&of_deviation(machine, deviation)),
                significant(deviation.allowed_db, 6)
            );
            (MessageCode::CandidateRejected, text, level_values(machine, deviation))
        }
        MachineWarning::LevelNotEligible { model, reason } => {
            severity = Severity::Info;
            let text = format!("Model level {} gave no result: {reason}.", name(model));
            (MessageCode::ModelNotEligible, text, vec![("rungs", json!([model.level.name()]))])
        }
        MachineWarning::StepRejected(rejected) => {
            severity = Severity::Info;
            of_rejected_step(machine, rejected)
        }
    };
    message(code, severity, text, values)
}

/// A model by its level, and by what it leaves out around the bearings: `full without tilt`.
fn name(model: &LeanModel) -> String {
    let terms: Vec<&str> = model.without.iter().map(|term| term.name()).collect();
    let level = model.level.name();
    if terms.is_empty() { level.to_owned() } else { format!("{level} without {}", terms.join(" and ")) }
}

fn of_deviation(machine: &Machine, LevelDeviation { channel, error_db, window, .. }: &LevelDeviation) -> String {
    let channel = channel.named(machine).to_string();
    format!(
        "over {} the level of {channel} deviates by {} dB from that on full",
        time(*window),
        significant(*error_db, 2)
    )
}

fn level_values(machine: &Machine, deviation: &LevelDeviation) -> Vec<(&'static str, Value)> {
    vec![
        ("rung", json!(deviation.model.level.name())),
        ("channel", json!(deviation.channel.named(machine).to_string())),
        ("level_error_db", json!(significant(deviation.error_db, 3))),
        ("allowed_db", json!(significant(deviation.allowed_db, 6))),
    ]
}

/// The sentence with a capital.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The message of a surface with the name of its bearing.
fn of_surface(bearing: &str, warning: &Warning) -> MessageAnswer {
    let MessageAnswer { code, severity, text, mut values } = of_warning(warning);
    values.insert("bearing".to_owned(), json!(bearing));
    MessageAnswer { code, severity, text: format!("Bearing {bearing}. {text}"), values }
}

fn of_rejected_step(
    machine: &Machine,
    RejectedStep { step, cause, stiff_bearings }: &RejectedStep,
) -> (MessageCode, String, Vec<(&'static str, Value)>) {
    let mut values = vec![("step_s", json!(step))];
    let cause = match cause {
        StepCause::Lost { time, loss } => format!("at t = {} s, {loss}", significant(*time, 3)),
        StepCause::Deviation { channel, error_db } => {
            let channel = channel.named(machine).to_string();
            let error_db = significant(*error_db, 2);
            values.extend([("channel", json!(channel)), ("level_error_db", json!(error_db))]);
            format!("half of them change the level of {channel}, an error of {error_db} dB")
        }
    };
    let mut limit = "";
    if *stiff_bearings {
        values.push(("limit", json!("bearing-stiffness")));
        limit =
            " The bearings are so stiff against the inertia of the parts that they join that they need short steps.";
    }
    let text = format!("Steps of {} µs were rejected: {cause}.{limit}", significant(US.to_user(*step), 3));
    (MessageCode::CandidateRejected, text, values)
}
