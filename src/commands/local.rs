//! A job in this process: read, run with its progress shown, its results written as files.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Ended, progress};
use crate::api::{ApiError, Problem};
use crate::contract::{self, Job, Outcome, Refusal, RunFailure};
use crate::jobs::Failure;
use crate::simulation::input::control::Control;

/// Reads a file, or stdin for `-`, and what `parse` makes of it; tells why not.
pub fn read(path: &Path, parse: impl FnOnce(&[u8]) -> Result<Job, Refusal>) -> Result<Job, Ended> {
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

/// Runs the job, with an estimate and its progress on stderr unless that is to be quiet; tells why it failed.
pub fn execute(job: &Job, quiet: bool) -> Result<Outcome, Ended> {
    let outcome = progress::shown(job, quiet, |progress| {
        contract::execute(job, &Control { progress, ..Control::until(&|| false) })
    });
    outcome.map_err(|failure| match failure {
        RunFailure::Cancelled => badly("cancelled"),
        RunFailure::Failed { cause, detail } => badly(&json(&Problem::of_run(&Failure::new(cause, detail)))),
    })
}

/// The same for a directory that takes the results: without one, nothing is run.
pub fn execute_into(job: &Job, output: &Path, quiet: bool) -> Result<(Outcome, Directory), Ended> {
    let output = Directory::at(output).map_err(|error| badly(&error))?;
    Ok((execute(job, quiet)?, output))
}

/// A directory that results go to.
pub struct Directory {
    path: PathBuf,
}

impl Directory {
    /// Makes it where it is missing, and sees whether it takes files, so that nobody learns that only after a long run; otherwise
    /// says why not.
    pub fn at(path: &Path) -> Result<Self, String> {
        fs::create_dir_all(path).map_err(|error| cannot_write(path, &error))?;
        let trial = path.join(format!(".raceway-{}", uuid::Uuid::now_v7()));
        let tried = fs::File::create_new(&trial).and_then(|_| fs::remove_file(&trial));
        tried.map_err(|error| cannot_write(path, &error))?;
        Ok(Self { path: path.to_owned() })
    }

    pub fn write(&self, name: &str, text: &str) -> Result<(), String> {
        let path = self.path.join(name);
        fs::write(&path, text).map_err(|error| cannot_write(&path, &error))
    }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write {}: {error}", path.display())
}

pub fn json(answer: &impl Serialize) -> String {
    serde_json::to_string_pretty(answer).unwrap_or_default()
}

pub fn refused(why: &str) -> Ended {
    eprintln!("{why}");
    Ended::Refused
}

pub fn badly(why: &str) -> Ended {
    eprintln!("{why}");
    Ended::Badly
}
