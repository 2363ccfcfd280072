//! `raceway optimum`: the best point of one range or two, in this process.

use std::io::Write;
use std::path::Path;

use super::local::{self, Directory, badly, json};
use super::{Ended, table};
use crate::config::OptimumOptions;
use crate::contract::{self, OptimumAnswer, Outcome};
use crate::render;

/// Searches, prints what was found, and writes it with its plot.
pub fn run(options: &OptimumOptions) -> Ended {
    match local::read(&options.job, contract::parse_optimum_request).and_then(|job| local::execute(&job, options.quiet))
    {
        Ok(Outcome::Optimum(answer)) => finish(&answer, &options.output),
        Ok(_) => badly("the job was no optimum job"),
        Err(ended) => ended,
    }
}

fn finish(answer: &OptimumAnswer, output: &Path) -> Ended {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{}", table::optimum(answer)) {
        return badly(&format!("stdout: {error}"));
    }
    write(answer, output).map_or_else(|error| badly(&error), |()| Ended::Well)
}

/// The answer and its plot, as files.
pub fn write(answer: &OptimumAnswer, directory: &Path) -> Result<(), String> {
    let directory = Directory::at(directory)?;
    directory.write("optimum.json", &json(answer))?;
    directory.write("optimum.svg", &render::optimum(answer))
}
