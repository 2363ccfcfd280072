//! Calibration: the runs from which thresholds of the program were found, and which show whether they still hold.
//!
//! `cargo bench --bench calibration -- COMMAND …`
//!
//! | command | question |
//! |---|---|
//! | `settling [SEED COUNT] [chosen\|axial]` | Has the initial transient decayed after the default `settle_s`? |
//! | `drawn [SEED COUNT] [axial] [rattling] [crowns] [waves]` | Is a level or number of a randomly drawn scene off by more than stated? |
//! | `extreme [scene=TEXT] [method=NAME] [budget=N]` | Does every method give a correct or a rejected result at the limits of the input? |
//!
//! The same seed gives the same scenes and the same lines.

mod draw;
mod drawn;
mod extreme;
mod settling;
mod threads;

use std::process::ExitCode;

use raceway::contract::Metrics;
use raceway::contract::answer::messages::{MessageCode, Severity};

const USAGE: &str = "usage: cargo bench --bench calibration -- COMMAND …
  settling [SEED COUNT] [chosen|axial]
  drawn [SEED COUNT] [axial] [rattling] [crowns] [waves]
  extreme [scene=TEXT] [method=NAME] [budget=N]";

/// Whether a result carries a warning, apart from vibration of the start.
fn warns(metrics: &Metrics) -> bool {
    const TRANSIENTS: [MessageCode; 3] =
        [MessageCode::StartTransient, MessageCode::CageTransient, MessageCode::TiltTransient];
    let mut messages = metrics.messages.iter();
    messages.any(|message| message.severity == Severity::Warning && !TRANSIENTS.contains(&message.code))
}

fn main() -> ExitCode {
    // cargo itself passes `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    match words.split_first().map(|(command, options)| (command.as_str(), options)) {
        Some(("settling", options)) => settling::run(options),
        Some(("drawn", options)) => drawn::run(options),
        Some(("extreme", options)) => extreme::run(options),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}
