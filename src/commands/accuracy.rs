//! `raceway accuracy`: error against run time for a scene.

use std::io::Write;

use super::local::{self, Directory, badly, json};
use super::{Ended, table};
use crate::config::AccuracyOptions;
use crate::contract::{self, Outcome, WorkPrecisionAnswer};
use crate::plots::draw;

/// Runs the study, prints it as a table, and writes `accuracy.json` and `work-precision.svg`.
pub fn run(options: &AccuracyOptions) -> Ended {
    let parse = |body: &[u8]| contract::parse_accuracy_request(body, options.repetitions);
    match local::read(&options.scene, parse).and_then(|job| local::execute_into(&job, &options.output, options.quiet)) {
        Ok((Outcome::Accuracy(answer), output)) => finish(&answer, &output),
        Ok(_) => badly("the job was no accuracy job"),
        Err(ended) => ended,
    }
}

fn finish(answer: &WorkPrecisionAnswer, output: &Directory) -> Ended {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{}", table::work_precision(answer)) {
        return badly(&format!("stdout: {error}"));
    }
    write(answer, output).map_or_else(|error| badly(&error), |()| Ended::Well)
}

/// The answer and its plot, as files.
pub fn write(answer: &WorkPrecisionAnswer, directory: &Directory) -> Result<(), String> {
    directory.write("accuracy.json", &json(answer))?;
    directory.write("work-precision.svg", &draw::work_precision(answer))
}
