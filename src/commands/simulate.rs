//! `raceway simulate`: a job without a server.

use std::io::Write;

use super::local::{self, Directory, badly, json};
use super::{Ended, accuracy, optimum};
use crate::config::SimulateOptions;
use crate::contract::answer::csv;
use crate::contract::{self, JobKind, Outcome, Simulated, SpectrumKind};
use crate::plots::draw;

/// Runs the job and prints its metrics.
pub fn run(options: &SimulateOptions) -> Ended {
    let done = local::read(&options.job, contract::parse_job_or_scene)
        .and_then(|job| match job.kind() {
            JobKind::Study => Err(local::refused("a job of kind `study`: run it with `raceway study`")),
            _ => Ok(job),
        })
        .and_then(|job| {
            let output = options.output.as_deref().map(Directory::at).transpose();
            let output = output.map_err(|error| badly(&error))?;
            Ok((local::execute(&job, options.quiet)?, output))
        });
    done.map_or_else(|ended| ended, |(outcome, output)| finish(&outcome, output.as_ref()))
}

fn finish(outcome: &Outcome, output: Option<&Directory>) -> Ended {
    let text = match outcome {
        Outcome::Simulation(simulated) => json(&simulated.metrics),
        Outcome::Accuracy(answer) => json(answer),
        Outcome::Optimum(answer) => json(answer),
    };
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = writeln!(stdout, "{text}") {
        return badly(&format!("stdout: {error}"));
    }
    let written = output.map(|directory| match outcome {
        Outcome::Simulation(simulated) => write(simulated, directory),
        Outcome::Accuracy(answer) => accuracy::write(answer, directory),
        Outcome::Optimum(answer) => optimum::write(answer, directory),
    });
    match written {
        Some(Err(error)) => badly(&error),
        _ => Ended::Well,
    }
}

/// Everything the run left, as files.
fn write(outcome: &Simulated, directory: &Directory) -> Result<(), String> {
    directory.write("metrics.json", &json(&outcome.metrics))?;
    for spectrum in &outcome.spectra {
        let sort = match spectrum.kind {
            SpectrumKind::Amplitude => "spectrum",
            SpectrumKind::Envelope => "envelope",
        };
        directory.write(&format!("{sort}.{}.json", spectrum.channel), &json(spectrum))?;
        directory.write(&format!("{sort}.{}.csv", spectrum.channel), &csv::spectrum_csv(spectrum))?;
    }
    for series in &outcome.series {
        directory.write(&format!("series.{}.json", series.channel), &json(series))?;
        directory.write(&format!("series.{}.csv", series.channel), &csv::series_csv(series))?;
    }
    for (name, picture) in draw::pictures(outcome) {
        directory.write(name, &picture)?;
    }
    Ok(())
}
