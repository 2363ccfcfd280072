//! `raceway optimum`: the best point over one or two ranges, in this process.

use std::io::Write;

use super::exit::{Exit, failed};
use super::local::{self, json};
use super::output_directory::OutputDirectory;
use super::text_tables;
use crate::config::OptimumOptions;
use crate::contract::{self, OptimumAnswer, Outcome};
use crate::plots::draw;

/// Searches, prints the optimum, and writes it with its plot.
pub fn run(options: &OptimumOptions) -> Exit {
    let job = local::read(&options.job, contract::parse_optimum_request);
    match job.and_then(|job| local::execute_into(&job, &options.output, options.quiet)) {
        Ok((Outcome::Optimum(answer), output)) => finish(&answer, &output),
        Ok(_) => failed("the job is not of kind optimum"),
        Err(exit) => exit,
    }
}

fn finish(answer: &OptimumAnswer, output: &OutputDirectory) -> Exit {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{}", text_tables::optimum(answer)) {
        return failed(&format!("stdout: {error}"));
    }
    write(answer, output).map_or_else(|error| failed(&error), |()| Exit::Success)
}

/// The answer and its plot, as files.
pub fn write(answer: &OptimumAnswer, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("optimum.json", &json(answer))?;
    directory.write("optimum.svg", &draw::optimum(answer))
}
