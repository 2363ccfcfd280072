//! `raceway simulate`: a job in this process.

use std::io::Write;

use super::exit::{Exit, failed, refused};
use super::local::{self, json};
use super::output_directory::OutputDirectory;
use super::{accuracy, optimum, uncertainty};
use crate::config::SimulateOptions;
use crate::contract::answer::csv;
use crate::contract::answer::orders::of_series;
use crate::contract::job::simulation::varying_speed_rpm;
use crate::contract::{
    self, Job, JobKind, MachineOutcome, Outcome, RotorAnswer, SeriesAnswer, Simulated, SpectrumAnswer, SpectrumKind,
};
use crate::plots::{draw, draw_rotor};

/// Runs the job and prints its metrics.
pub fn run(options: &SimulateOptions) -> Exit {
    let done = local::read(&options.job, contract::parse_job_or_scene)
        .and_then(|job| match job.kind() {
            JobKind::Study => Err(refused("a job of kind `study` needs `raceway study`")),
            _ => Ok(job),
        })
        .and_then(|job| match &job {
            Job::Uncertainty(of_points) => Err(uncertainty::run(&job, of_points, options)),
            _ => Ok(job),
        })
        .and_then(|job| {
            let output = options.output.as_deref().map(OutputDirectory::open).transpose();
            let output = output.map_err(|error| failed(&error))?;
            let outcome = local::execute(&job, options.quiet)?;
            Ok((job, outcome, output))
        });
    done.map_or_else(|exit| exit, |(job, outcome, output)| finish(&job, &outcome, output.as_ref()))
}

fn finish(job: &Job, outcome: &Outcome, output: Option<&OutputDirectory>) -> Exit {
    let text = match outcome {
        Outcome::Simulation(simulated) => json(&simulated.metrics),
        Outcome::Accuracy(answer) => json(answer),
        Outcome::Modes(answer) => json(answer),
        Outcome::Optimum(answer) => json(answer),
        Outcome::Rotor(answer) => json(answer),
        Outcome::Machine(outcome) => json(&outcome.answer),
    };
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = writeln!(stdout, "{text}") {
        return failed(&format!("stdout: {error}"));
    }
    let written = output.map(|directory| match outcome {
        Outcome::Simulation(simulated) => write(job, simulated, directory),
        Outcome::Accuracy(answer) => accuracy::write(answer, directory),
        Outcome::Modes(answer) => accuracy::write_modes(answer, directory),
        Outcome::Optimum(answer) => optimum::write(answer, directory),
        Outcome::Rotor(answer) => write_rotor(answer, directory),
        Outcome::Machine(outcome) => write_machine(job, outcome, directory),
    });
    match written {
        Some(Err(error)) => failed(&error),
        _ => Exit::Success,
    }
}

fn write_rotor(answer: &RotorAnswer, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("rotor.json", &json(answer))?;
    directory.write("campbell.svg", &draw_rotor::campbell(answer))?;
    directory.write("shapes.svg", &draw_rotor::shapes(answer))
}

/// Writes all results as files.
fn write(job: &Job, outcome: &Simulated, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("metrics.json", &json(&outcome.metrics))?;
    write_spectra(&outcome.spectra, directory)?;
    let series: Vec<SeriesAnswer> = outcome.series.iter().map(SeriesAnswer::of).collect();
    let has_waterfall = write_series(job, &series, directory)?;
    for (name, picture) in draw::pictures(outcome, has_waterfall) {
        directory.write(name, &picture)?;
    }
    Ok(())
}

/// Writes the series of a job with its orders and its waterfall; true where it has these.
fn write_series(job: &Job, series: &[SeriesAnswer], directory: &OutputDirectory) -> Result<bool, String> {
    for series in series {
        directory.write(&format!("series.{}.json", series.channel), &json(series))?;
        directory.write(&format!("series.{}.csv", series.channel), &csv::series_csv(series))?;
    }
    let orders = of_series(job, series);
    if let Some((orders, waterfall)) = &orders {
        directory.write("orders.json", &json(orders))?;
        directory.write("orders.csv", &orders.csv())?;
        directory.write("orders.svg", &draw::orders(orders))?;
        directory.write("waterfall.json", &json(waterfall))?;
        directory.write("waterfall.csv", &waterfall.csv())?;
        directory.write("waterfall.svg", &draw::waterfall(waterfall, draw::WATERFALL_RANGE_DB))?;
    }
    Ok(orders.is_some())
}

/// Writes all results of a machine job as files.
fn write_machine(job: &Job, outcome: &MachineOutcome, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("machine.json", &json(&outcome.answer))?;
    write_spectra(&outcome.spectra, directory)?;
    let series = outcome.series.iter().map(|series| SeriesAnswer::new(&series.head, series.values.clone()));
    let has_waterfall = write_series(job, &series.collect::<Vec<_>>(), directory)?;
    let speed = draw::VaryingSpeed { range_rpm: varying_speed_rpm(&job.submission().request), has_waterfall };
    for (name, kind) in [("spectrum.svg", SpectrumKind::Amplitude), ("envelope.svg", SpectrumKind::Envelope)] {
        directory.write(name, &draw::machine_spectra(&outcome.answer, kind, &outcome.spectra, speed))?;
    }
    Ok(())
}

fn write_spectra(spectra: &[SpectrumAnswer], directory: &OutputDirectory) -> Result<(), String> {
    for spectrum in spectra {
        let kind = match spectrum.kind {
            SpectrumKind::Amplitude => "spectrum",
            SpectrumKind::Envelope => "envelope",
        };
        directory.write(&format!("{kind}.{}.json", spectrum.channel), &json(spectrum))?;
        directory.write(&format!("{kind}.{}.csv", spectrum.channel), &csv::spectrum_csv(spectrum))?;
    }
    Ok(())
}
