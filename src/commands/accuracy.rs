//! `raceway accuracy`: error against run time for a scene.

use std::io::Write;

use super::exit::{Exit, failed};
use super::local::{self, json};
use super::output_directory::OutputDirectory;
use super::text_tables;
use crate::config::AccuracyOptions;
use crate::contract::{self, ModePrecisionAnswer, Outcome, WorkPrecisionAnswer};
use crate::plots::draw;

/// Runs the comparison, prints it as a table, and writes `accuracy.json` and `work-precision.svg`.
pub fn run(options: &AccuracyOptions) -> Exit {
    let parse = |body: &[u8]| contract::parse_accuracy_request(body, options.repetitions);
    match local::read(&options.scene, parse).and_then(|job| local::execute_into(&job, &options.output, options.quiet)) {
        Ok((Outcome::Accuracy(answer), output)) => {
            finish(&text_tables::work_precision(&answer), write(&answer, &output))
        }
        Ok((Outcome::Modes(answer), output)) => {
            finish(&text_tables::mode_precision(&answer), write_modes(&answer, &output))
        }
        Ok(_) => failed("the job is not of kind accuracy"),
        Err(exit) => exit,
    }
}

fn finish(table: &str, written: Result<(), String>) -> Exit {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{table}") {
        return failed(&format!("stdout: {error}"));
    }
    written.map_or_else(|error| failed(&error), |()| Exit::Success)
}

/// The answer and its plot, as files.
pub fn write(answer: &WorkPrecisionAnswer, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("accuracy.json", &json(answer))?;
    directory.write("work-precision.svg", &draw::work_precision(answer))
}

/// The answer of a shaft and its plot, as files.
pub fn write_modes(answer: &ModePrecisionAnswer, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("accuracy.json", &json(answer))?;
    directory.write("work-precision.svg", &draw::mode_precision(answer))
}
