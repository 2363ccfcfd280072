//! A job in this process: reading it, and running it with progress on stderr.

use std::fs;
use std::io::Read;
use std::path::Path;

use raceway_core::simulation::input::control::Control;
use serde::Serialize;

use super::exit::{Exit, failed, refused};
use super::output_directory::OutputDirectory;
use super::progress;
use crate::api::{ApiError, Problem};
use crate::contract::{self, Job, Outcome, Refusal, RunFailure};
use crate::jobs::Failure;

/// Reads and parses a file, or stdin for `-`; prints the reason of a refusal.
pub fn read(path: &Path, parse: impl FnOnce(&[u8]) -> Result<Job, Refusal>) -> Result<Job, Exit> {
    let body = bytes_of(path).map_err(|error| refused(&format!("{}: {error}", path.display())))?;
    parse(&body).map_err(|refusal| refused(&json(&ApiError::from(refusal).problem().1)))
}

fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
    if path != Path::new("-") {
        return fs::read(path);
    }
    let mut body = Vec::new();
    std::io::stdin().lock().read_to_end(&mut body)?;
    Ok(body)
}

/// Runs the job, with an estimate and its progress on stderr unless `quiet`; prints the reason of a failure.
pub fn execute(job: &Job, quiet: bool) -> Result<Outcome, Exit> {
    let outcome = progress::shown(job, quiet, |progress| {
        contract::execute(job, &Control { progress, ..Control::until(&|| false) })
    });
    outcome.map_err(|failure| match failure {
        RunFailure::Cancelled => failed("cancelled"),
        RunFailure::Failed { cause, detail } => failed(&json(&Problem::of_failure(&Failure::new(cause, detail)))),
    })
}

/// Runs the job as `execute`, after checking that the directory for its results is writable.
pub fn execute_into(job: &Job, output: &Path, quiet: bool) -> Result<(Outcome, OutputDirectory), Exit> {
    let output = OutputDirectory::open(output).map_err(|error| failed(&error))?;
    Ok((execute(job, quiet)?, output))
}

/// An answer as indented JSON.
pub fn json(answer: &impl Serialize) -> String {
    serde_json::to_string_pretty(answer).unwrap_or_default()
}
