//! `raceway optimum`: the best point of one range or two, in this process.

use std::io::Write;

use super::local::{self, Directory, badly, json};
use super::{Ended, table};
use crate::config::OptimumOptions;
use crate::contract::{self, OptimumAnswer, Outcome};
use crate::plots::draw;

/// Searches, prints what was found, and writes it with its plot.
pub fn run(options: &OptimumOptions) -> Ended {
    let job = local::read(&options.job, contract::parse_optimum_request);
    match job.and_then(|job| local::execute_into(&job, &options.output, options.quiet)) {
        Ok((Outcome::Optimum(answer), output)) => finish(&answer, &output),
        Ok(_) => badly("the job was no optimum job"),
        Err(ended) => ended,
    }
}

fn finish(answer: &OptimumAnswer, output: &Directory) -> Ended {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{}", table::optimum(answer)) {
        return badly(&format!("stdout: {error}"));
    }
    write(answer, output).map_or_else(|error| badly(&error), |()| Ended::Well)
}

/// The answer and its plot, as files.
pub fn write(answer: &OptimumAnswer, directory: &Directory) -> Result<(), String> {
    directory.write("optimum.json", &json(answer))?;
    directory.write("optimum.svg", &draw::optimum(answer))
}
