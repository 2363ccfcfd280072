//! `raceway study`: a scene over a grid of values, in this process.

use std::io::Write;

use raceway_core::simulation::input::control::Control;

use super::exit::{Exit, failed};
use super::local::{self, json};
use super::output_directory::OutputDirectory;
use super::{parallel_map, progress, text_tables};
use crate::config::StudyOptions;
use crate::contract::answer::csv;
use crate::contract::{self, Job, Row, Simulation, Study, TableAnswer};
use crate::plots::draw;

/// Runs the study, prints its table, and writes it with its plots.
pub fn run(options: &StudyOptions) -> Exit {
    let job = match local::read(&options.study, contract::parse_study_request) {
        Ok(job) => job,
        Err(exit) => return exit,
    };
    let Job::Study(study) = &job else { return failed("the job is not of kind study") };
    let output = match OutputDirectory::open(&options.output) {
        Ok(output) => output,
        Err(error) => return failed(&error),
    };
    let workers = options.workers.map_or_else(parallel_map::cores, usize::from);
    let answer = table_of(&job, study, workers, options.quiet);
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{}", text_tables::study(&answer)) {
        return failed(&format!("stdout: {error}"));
    }
    match write(&answer, &output) {
        Err(error) => failed(&error),
        Ok(()) if answer.succeeded == 0 => failed("no point succeeded"),
        Ok(()) => Exit::Success,
    }
}

/// Runs all points on `workers` threads.
pub fn table_of(job: &Job, study: &Study, workers: usize, quiet: bool) -> TableAnswer {
    let rows = progress::shown(job, quiet, |progress| {
        parallel_map::map(study.points, workers, progress, |point| row_of(study, point))
    });
    TableAnswer::of(study, rows)
}

/// A point of a study with its end.
pub fn row_of(study: &Study, point: usize) -> Row {
    let control = Control::until(&|| false);
    let simulate = |simulation: Simulation| contract::execute_simulation(&simulation, &control);
    let row = Row::queued(study, point);
    match contract::execute_point(study.point(point), &simulate) {
        Some(end) => row.ended(end),
        None => row,
    }
}

/// The table and its plots, as files.
pub fn write(answer: &TableAnswer, directory: &OutputDirectory) -> Result<(), String> {
    directory.write("table.json", &json(answer))?;
    directory.write("table.csv", &csv::table_csv(answer))?;
    for (name, picture) in [("trend.svg", draw::trend(answer)), ("map.svg", draw::map(answer))] {
        if let Some(picture) = picture {
            directory.write(name, &picture)?;
        }
    }
    Ok(())
}
