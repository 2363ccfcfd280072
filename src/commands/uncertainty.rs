//! An uncertainty job in this process, as `raceway simulate` runs it.

use std::io::Write;

use super::exit::{Exit, failed};
use super::local::json;
use super::output_directory::OutputDirectory;
use super::study::row_of;
use super::{parallel_map, progress};
use crate::config::SimulateOptions;
use crate::contract::answer::csv;
use crate::contract::job::uncertainty::Uncertainty;
use crate::contract::{Job, TableAnswer, UncertaintyAnswer};
use crate::plots::draw_uncertainty;

/// Runs all points on all cores, prints the distributions, and writes them with the table and the plot.
pub fn run(job: &Job, uncertainty: &Uncertainty, options: &SimulateOptions) -> Exit {
    let output = match options.output.as_deref().map(OutputDirectory::open).transpose() {
        Ok(output) => output,
        Err(error) => return failed(&error),
    };
    let study = &uncertainty.study;
    let rows = progress::shown(job, options.quiet, |progress| {
        parallel_map::map(study.points, parallel_map::cores(), progress, |point| row_of(study, point))
    });
    let answer = UncertaintyAnswer::of(uncertainty, &rows);
    let has_values = !answer.metrics.is_empty();
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = writeln!(stdout, "{}", json(&answer)) {
        return failed(&format!("stdout: {error}"));
    }
    let written = output.map(|directory| {
        let table = TableAnswer::of(study, rows);
        directory.write("uncertainty.json", &json(&answer))?;
        directory.write("uncertainty.svg", &draw_uncertainty::histograms(&answer))?;
        directory.write("table.csv", &csv::table_csv(&table))
    });
    match written {
        Some(Err(error)) => failed(&error),
        _ if !has_values => failed("fewer than two points have a value of a metric"),
        _ => Exit::Success,
    }
}
