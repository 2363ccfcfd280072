//! Every stored request and result of a database compared with its digests.

use uuid::Uuid;

use super::database_lock::DatabaseLock;
use super::error::JobError;
use super::store::database::Store;
use super::store::integrity::Inspection;
use super::store::location::Location;

/// The state of all stored results.
#[derive(Debug, Default)]
pub struct Report {
    /// Faults in the structure of the file.
    pub structure: Vec<String>,
    /// Jobs with a corrupt part, by part.
    pub corrupt: Vec<(Uuid, String)>,
    /// Jobs with parts that have no digest.
    pub without_digest: Vec<Uuid>,
    /// All parts together.
    pub parts: Inspection,
}

impl Report {
    /// Returns whether nothing is corrupt.
    pub fn is_clean(&self) -> bool {
        self.structure.is_empty() && self.corrupt.is_empty()
    }

    fn add(&mut self, jobs: &[Uuid], found: Inspection) {
        if found.without_digest > 0 {
            self.without_digest.extend(jobs);
        }
        for part in &found.corrupt {
            self.corrupt.extend(jobs.iter().map(|job| (*job, part.clone())));
        }
        self.parts.merge(found);
    }
}

/// Compares every stored result with its digests and records which jobs have corrupt ones. A service may be running.
pub async fn verify(location: &Location) -> Result<Report, JobError> {
    let store = open(location).await?;
    let report = verify_in(&store).await;
    store.disconnect().await;
    report
}

async fn open(location: &Location) -> Result<Store, JobError> {
    let opening = |error| JobError::opening(location, error);
    let store = Store::open(location, 0, None).await.map_err(opening)?;
    let lock = match location {
        // A service that holds the lock has brought the tables up to date.
        Location::File(path) => match DatabaseLock::take(path) {
            Err(JobError::Locked(_)) => return Ok(store),
            lock => Some(lock?),
        },
        Location::Server(_) => None,
    };
    store.migrate().await.map_err(opening)?;
    drop(lock);
    Ok(store)
}

async fn verify_in(store: &Store) -> Result<Report, JobError> {
    let mut report = Report { structure: store.structure_faults().await?, ..Report::default() };
    let mut last = Uuid::nil();
    loop {
        let jobs = store.jobs_after(last).await?;
        let Some(end) = jobs.last() else { break };
        last = *end;
        for job in jobs {
            report.add(&[job], store.inspect_job(job).await?);
        }
    }
    let mut last = Uuid::nil();
    loop {
        let results = store.results_after(last).await?;
        let Some(end) = results.last() else { break };
        last = *end;
        for result in results {
            let found = store.inspect_result(result).await?;
            report.add(&store.jobs_of_result(result).await?, found);
        }
    }
    let mut last = Uuid::nil();
    loop {
        let studies = store.studies_after(last).await?;
        let Some(end) = studies.last() else { break };
        last = *end;
        for study in studies {
            let found = store.inspect_points(study).await?;
            report.add(&[study], found);
        }
    }
    for (job, part) in &report.corrupt {
        store.record_corrupt(*job, part).await?;
    }
    // The part was read wrongly once, or a backup was restored.
    for job in store.recorded_corrupt().await? {
        if report.corrupt.iter().all(|(corrupt, _)| *corrupt != job) {
            store.forget_corrupt(job).await?;
        }
    }
    report.corrupt.sort_unstable();
    report.corrupt.dedup();
    report.without_digest.sort_unstable();
    report.without_digest.dedup();
    Ok(report)
}
