//! `raceway simulate`: a job without a server.

use std::fs;
use std::io::{IsTerminal, Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU8, Ordering};

use serde::Serialize;

use super::Ended;
use crate::api::{ApiError, Problem};
use crate::config::SimulateOptions;
use crate::contract::{self, Outcome, RunFailure, SpectrumKind};
use crate::jobs::Failure;
use crate::render;
use crate::simulation::run::Control;

/// Runs the job and prints its metrics.
pub fn run(options: &SimulateOptions) -> Ended {
    let body = match read(&options.job) {
        Ok(body) => body,
        Err(error) => return refused(&format!("{}: {error}", options.job.display())),
    };
    let job = match contract::parse_job(&body) {
        Ok(job) => job,
        Err(refusal) => return refused(&json(&ApiError::from(refusal).problem().1)),
    };
    match execute(&job) {
        Ok(outcome) => finish(&outcome, options.output.as_deref()),
        Err(RunFailure::Cancelled) => badly("cancelled"),
        Err(RunFailure::Failed { cause, detail }) => badly(&json(&Problem::of_run(&Failure::new(cause, detail)))),
    }
}

fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    if path != Path::new("-") {
        return fs::read(path);
    }
    let mut body = Vec::new();
    std::io::stdin().lock().read_to_end(&mut body)?;
    Ok(body)
}

fn execute(job: &contract::Job) -> Result<Outcome, RunFailure> {
    let shows_progress = std::io::stderr().is_terminal();
    let shown = AtomicU8::new(u8::MAX);
    let show = |share: f64| {
        let percent = (100.0 * share.clamp(0.0, 1.0)) as u8;
        if shows_progress && shown.swap(percent, Ordering::Relaxed) != percent {
            eprint!("\r{percent:3} % ");
        }
    };
    let outcome = contract::execute(job, &Control { stop: &|| false, progress: &show });
    if shows_progress {
        eprint!("\r      \r");
    }
    outcome
}

fn finish(outcome: &Outcome, output: Option<&Path>) -> Ended {
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = writeln!(stdout, "{}", json(&outcome.metrics)) {
        return badly(&format!("stdout: {error}"));
    }
    match output.map(|directory| write(outcome, directory)) {
        Some(Err(error)) => badly(&error),
        _ => Ended::Well,
    }
}

/// Everything the run left, as files.
fn write(outcome: &Outcome, directory: &Path) -> Result<(), String> {
    let at = |path: &Path, error: std::io::Error| format!("cannot write {}: {error}", path.display());
    fs::create_dir_all(directory).map_err(|error| at(directory, error))?;
    let write = |name: String, text: String| {
        let path = directory.join(name);
        fs::write(&path, text).map_err(|error| at(&path, error))
    };
    write("metrics.json".into(), json(&outcome.metrics))?;
    for spectrum in &outcome.spectra {
        let sort = match spectrum.kind {
            SpectrumKind::Amplitude => "spectrum",
            SpectrumKind::Envelope => "envelope",
        };
        write(format!("{sort}.{}.json", spectrum.channel), json(spectrum))?;
        write(format!("{sort}.{}.csv", spectrum.channel), render::spectrum_csv(spectrum))?;
    }
    for series in &outcome.series {
        write(format!("series.{}.json", series.channel), json(series))?;
        write(format!("series.{}.csv", series.channel), render::series_csv(series))?;
    }
    let amplitudes = outcome.spectra.iter().filter(|spectrum| spectrum.kind == SpectrumKind::Amplitude);
    let amplitudes: Vec<_> = amplitudes.cloned().collect();
    if amplitudes.is_empty() {
        return Ok(());
    }
    write("spectrum.svg".into(), render::spectra(&outcome.metrics, &amplitudes))
}

fn json(answer: &impl Serialize) -> String {
    serde_json::to_string_pretty(answer).unwrap_or_default()
}

fn refused(why: &str) -> Ended {
    eprintln!("{why}");
    Ended::Refused
}

fn badly(why: &str) -> Ended {
    eprintln!("{why}");
    Ended::Badly
}
