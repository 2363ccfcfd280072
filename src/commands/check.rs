//! `raceway check`: whether the stored results are what was written.

use super::exit::{Exit, failed};
use crate::config::DatabaseOptions;
use crate::jobs::Location;
use crate::jobs::verification::{Report, verify};

/// Compares every stored result with its digests. stdout lists the faults, stderr sums them up.
pub async fn run(options: DatabaseOptions) -> Exit {
    let location = match options.location() {
        Ok(location) => location,
        Err(error) => return failed(&format!("raceway: {error}")),
    };
    // A mistyped name must not create a database.
    if matches!(&location, Location::File(path) if !path.exists()) {
        return failed(&format!("raceway: there is no database {location}"));
    }
    match verify(&location).await {
        Ok(report) => {
            print(&report);
            if report.is_clean() { Exit::Success } else { Exit::Failure }
        }
        Err(error) => failed(&format!("raceway: {error}")),
    }
}

fn print(report: &Report) {
    for fault in &report.structure {
        println!("structure: {fault}");
    }
    for (job, part) in &report.corrupt {
        println!("{job} corrupt: {part}");
    }
    for job in &report.without_digest {
        println!("{job} without digest");
    }
    eprintln!(
        "{} parts of results compared, {:.1} MB: {} corrupt, {} without digest; {} faults in the structure of the file",
        report.parts.parts,
        1e-6 * report.parts.bytes as f64,
        report.corrupt.len(),
        report.parts.without_digest,
        report.structure.len()
    );
}
