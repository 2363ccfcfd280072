//! `raceway study`: a scene over a grid of values, in this process.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};

use super::local::{self, Directory, badly, json};
use super::{Ended, progress, table};
use crate::config::StudyOptions;
use crate::contract::{self, Job, Row, Study, TableAnswer};
use crate::render;
use crate::simulation::run::Control;

/// Runs the study, prints its table, and writes it with its plots.
pub fn run(options: &StudyOptions) -> Ended {
    let job = match local::read(&options.study, contract::parse_study_request) {
        Ok(job) => job,
        Err(ended) => return ended,
    };
    let Some(study) = &job.study else { return badly("the job was no study") };
    let workers = options.workers.map_or_else(cores, usize::from);
    let answer = table_of(&job, study, workers, options.quiet);
    let mut stdout = std::io::stdout().lock();
    if let Err(error) = write!(stdout, "{}", table::study(&answer)) {
        return badly(&format!("stdout: {error}"));
    }
    match write(&answer, &options.output) {
        Err(error) => badly(&error),
        Ok(()) if answer.succeeded == 0 => badly("no point succeeded"),
        Ok(()) => Ended::Well,
    }
}

/// Points at a time where nobody says.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Runs all points, so many at a time.
pub fn table_of(job: &Job, study: &Study, workers: usize, quiet: bool) -> TableAnswer {
    let rows = progress::shown(job, quiet, |progress| run_all(study, workers, progress));
    TableAnswer::of(study, rows)
}

fn run_all(study: &Study, workers: usize, progress: &dyn Fn(f64)) -> Vec<Row> {
    let rows = Mutex::new((0..study.points).map(|point| Row::queued(study, point)).collect::<Vec<_>>());
    let next = AtomicUsize::new(0);
    let (done, ended) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..workers.min(study.points) {
            let done = done.clone();
            let (next, rows) = (&next, &rows);
            scope.spawn(move || {
                loop {
                    let point = next.fetch_add(1, Ordering::Relaxed);
                    if point >= study.points {
                        return;
                    }
                    let simulate = |job: &Job| contract::execute(job, &Control { stop: &|| false, progress: &|_| () });
                    let end = contract::execute_point(study.point(point), &simulate);
                    let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
                    if let (Some(end), Some(row)) = (end, rows.get_mut(point)) {
                        *row = row.clone().ended(end);
                    }
                    drop(rows);
                    let _ = done.send(());
                }
            });
        }
        drop(done);
        for count in 1..=study.points {
            if ended.recv().is_err() {
                break;
            }
            progress(count as f64 / study.points as f64);
        }
    });
    rows.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// The table and its plots, as files.
pub fn write(answer: &TableAnswer, directory: &Path) -> Result<(), String> {
    let directory = Directory::at(directory)?;
    directory.write("table.json", &json(answer))?;
    directory.write("table.csv", &render::table_csv(answer))?;
    for (name, picture) in [("trend.svg", render::trend(answer)), ("map.svg", render::map(answer))] {
        if let Some(picture) = picture {
            directory.write(name, &picture)?;
        }
    }
    Ok(())
}
