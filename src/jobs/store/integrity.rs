//! Comparison of stored results with the digests of their writing. A part that differs is recorded with its jobs, so that it answers no other job.

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::digest::{Place, Sealed};
use super::part_names::{METRICS, REPORT, REQUEST, VIEWS, point_name, signal_name};
use super::results::{LONG_ANSWER_BYTES, read_aside};
use super::sealed_request::{SEALED_REQUEST, SealedRequest};
use super::series_reader::head_of;
use super::signal::Signal;
use super::statement::statement;
use super::stored_time::stored;
use crate::jobs::error::JobError;

/// The parts of a stored result by whether they are what was written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Inspection {
    /// Number of parts.
    pub parts: usize,
    /// Total length of the parts [B].
    pub bytes: usize,
    /// Number of parts without digest, which earlier versions wrote.
    pub without_digest: usize,
    /// Parts that are not what was written, by name.
    pub corrupt: Vec<String>,
}

impl Inspection {
    fn add<T: AsRef<[u8]>>(&mut self, part: impl FnOnce() -> String, place: &Place, sealed: &Sealed<T>) {
        self.parts += 1;
        self.bytes += sealed.content.as_ref().len();
        self.without_digest += usize::from(sealed.digest.is_none());
        if !sealed.is_intact(place) {
            self.corrupt.push(part());
        }
    }

    /// An inspection that ended at rows which the database cannot read counts them as one corrupt part.
    fn or_unreadable(inspection: Result<Self, JobError>) -> Result<Self, JobError> {
        match inspection {
            Err(error) if error.is_corruption() => {
                Ok(Self { corrupt: vec![format!("unreadable rows ({error})")], ..Self::default() })
            }
            inspection => inspection,
        }
    }

    /// Adds the parts of another result.
    pub fn merge(&mut self, other: Self) {
        self.parts += other.parts;
        self.bytes += other.bytes;
        self.without_digest += other.without_digest;
        self.corrupt.extend(other.corrupt);
    }
}

/// Parts that `Store::inspect_job` compares.
#[derive(FromRow)]
struct JobRow {
    owner: String,
    lacks_result: bool,
    #[sqlx(flatten)]
    request: SealedRequest,
}

/// Largest number of ids that a page of `Store::jobs_after`, `Store::results_after` and `Store::studies_after` has.
const PAGE: i64 = 500;

impl Store {
    /// Passes on what was read of a job's result. A part that cannot be read as it was written is recorded.
    pub(super) async fn noted<T>(&self, job: Uuid, part: &str, read: Result<T, JobError>) -> Result<T, JobError> {
        match read {
            Err(error) if error.is_corruption() => {
                tracing::error!(%job, part, %error, "a stored result is corrupt");
                self.found_corrupt(job, part).await;
                Err(JobError::ResultCorrupt { part: part.to_owned() })
            }
            read => read,
        }
    }

    /// Counts and records a job with a part that is not what was written.
    pub async fn found_corrupt(&self, job: Uuid, part: &str) {
        self.metrics.found_corrupt();
        if let Err(error) = self.record_corrupt(job, part).await {
            tracing::warn!(%error, %job, "the corrupt result could not be recorded");
        }
    }

    /// Records a job, and those that share its result, as corrupt.
    pub async fn record_corrupt(&self, job: Uuid, part: &str) -> Result<(), JobError> {
        let sql = "INSERT INTO corrupt_results (job, part, found_at) SELECT id, $2, $3 FROM jobs \
                   WHERE id = $1 OR result_id = (SELECT result_id FROM jobs WHERE id = $1) \
                   ON CONFLICT (job) DO NOTHING";
        statement(sql).bind(job).bind(part).bind(stored(Timestamp::now())).run(&self.writer).await?;
        Ok(())
    }

    /// Number of jobs whose stored result is known to be corrupt.
    pub async fn corrupt_results(&self) -> Result<i64, JobError> {
        Ok(statement("SELECT count(*) FROM corrupt_results").value(&self.readers).await?.unwrap_or(0))
    }

    /// Jobs whose stored result is recorded as corrupt.
    pub async fn recorded_corrupt(&self) -> Result<Vec<Uuid>, JobError> {
        statement("SELECT job FROM corrupt_results").values(&self.readers).await
    }

    /// Removes the record of a corrupt result that has been found to be what was written.
    pub async fn forget_corrupt(&self, job: Uuid) -> Result<(), JobError> {
        statement("DELETE FROM corrupt_results WHERE job = $1").bind(job).run(&self.writer).await?;
        Ok(())
    }

    /// Returns whether a result is what was written. If it is not, it is recorded.
    pub async fn is_intact(&self, result: Uuid) -> Result<bool, JobError> {
        let Some(part) = self.inspect_result(result).await?.corrupt.into_iter().next() else { return Ok(true) };
        for job in self.jobs_of_result(result).await?.into_iter().take(1) {
            let corrupt: Result<(), _> = Err(JobError::ResultCorrupt { part: part.clone() });
            drop(self.noted(job, &part, corrupt).await);
        }
        Ok(false)
    }

    /// Compares every part of a result with its digest.
    pub async fn inspect_result(&self, result: Uuid) -> Result<Inspection, JobError> {
        Inspection::or_unreadable(self.try_inspect_result(result).await)
    }

    async fn try_inspect_result(&self, result: Uuid) -> Result<Inspection, JobError> {
        let mut found = Inspection::default();
        let sql = "SELECT metrics, digest FROM results WHERE id = $1";
        let metrics = statement(sql).bind(result).optional::<(String, Option<Vec<u8>>)>(&self.readers).await;
        match metrics {
            Ok(Some(metrics)) => {
                found.add(|| METRICS.to_owned(), &Place::of_result(result, METRICS), &Sealed::stored(metrics));
            }
            Err(error) if !error.is_corruption() => return Err(error),
            // Gone, or no longer text.
            _ => found.corrupt.push(METRICS.to_owned()),
        }
        for (table, part) in [("reports", REPORT), ("views", VIEWS)] {
            let sql = format!("SELECT answer, digest FROM {table} WHERE result_id = $1");
            let answer: Option<(Vec<u8>, Option<Vec<u8>>)> =
                statement(sql).bind(result).optional(&self.readers).await?;
            if let Some(answer) = answer {
                found.add(|| part.to_owned(), &Place::of_result(result, part), &Sealed::stored(answer));
            }
        }
        let long = i64::try_from(LONG_ANSWER_BYTES).unwrap_or(i64::MAX);
        let sql = "SELECT sort, channel, answer, digest FROM signals WHERE result_id = $1 AND length(answer) < $2";
        let add = |(sort, channel, answer, digest): (String, String, Vec<u8>, Option<Vec<u8>>)| {
            let place = Place::of_signal(result, &sort, &channel);
            found.add(|| signal_name(&sort, &channel), &place, &Sealed::stored((answer, digest)));
            Ok(true)
        };
        statement(sql).bind(result).bind(long).each(&self.readers, add).await?;
        let sql = "SELECT sort, channel FROM signals WHERE result_id = $1 AND length(answer) >= $2";
        let keys: Vec<(String, String)> = statement(sql).bind(result).bind(long).all(&self.readers).await?;
        for (sort, channel) in keys {
            let sql = "SELECT answer, digest FROM signals WHERE result_id = $1 AND sort = $2 AND channel = $3";
            let stored: (Vec<u8>, Option<Vec<u8>>) =
                statement(sql).bind(result).bind(&sort).bind(&channel).one(&self.readers).await?;
            let inspect = move |stored| {
                let mut found = Inspection::default();
                let place = Place::of_signal(result, &sort, &channel);
                found.add(|| signal_name(&sort, &channel), &place, &stored);
                Ok(found)
            };
            found.merge(read_aside(Sealed::stored(stored), inspect).await?);
        }
        self.inspect_series(result, &mut found).await?;
        Ok(found)
    }

    /// Compares the chunks of every series with their digests and with the length of the series.
    async fn inspect_series(&self, result: Uuid, found: &mut Inspection) -> Result<(), JobError> {
        // A series in one piece, as earlier versions stored it, is longer.
        let long = i64::try_from(LONG_ANSWER_BYTES).unwrap_or(i64::MAX);
        let sql = "SELECT channel, answer FROM signals WHERE result_id = $1 AND sort = $2 AND length(answer) < $3";
        let heads: Vec<(String, Vec<u8>)> =
            statement(sql).bind(result).bind(Signal::Series.name()).bind(long).all(&self.readers).await?;
        for (channel, answer) in heads {
            // A corrupt head has been found before.
            let Ok(Some(head)) = head_of(&answer) else { continue };
            let part = || signal_name(Signal::Series.name(), &channel);
            let sql = "SELECT number, content, digest FROM series_chunks WHERE result_id = $1 AND series = $2 ORDER BY number";
            let mut chunks = 0;
            let add = |(number, content, digest): (i64, Vec<u8>, Option<Vec<u8>>)| {
                found.add(part, &Place::of_chunk(result, head.number, number), &Sealed::stored((content, digest)));
                chunks += usize::from(number == i64::try_from(chunks).unwrap_or(i64::MAX));
                Ok(true)
            };
            statement(sql).bind(result).bind(head.number).each(&self.readers, add).await?;
            if chunks != head.chunks() {
                found.corrupt.push(part());
            }
        }
        Ok(())
    }

    /// Compares every ended point of a study with its digest.
    pub async fn inspect_points(&self, study: Uuid) -> Result<Inspection, JobError> {
        Inspection::or_unreadable(self.try_inspect_points(study).await)
    }

    async fn try_inspect_points(&self, study: Uuid) -> Result<Inspection, JobError> {
        let mut found = Inspection::default();
        let sql = "SELECT number, status, content_hash, answer, digest FROM points \
                   WHERE job = $1 AND answer IS NOT NULL ORDER BY number";
        type Row = (i64, String, Option<Vec<u8>>, Vec<u8>, Option<Vec<u8>>);
        let add = |(number, status, work, answer, digest): Row| {
            let place = Place::of_point(study, number, &status, work.as_deref());
            found.add(|| point_name(number), &place, &Sealed::stored((answer, digest)));
            Ok(true)
        };
        statement(sql).bind(study).each(&self.readers, add).await?;
        Ok(found)
    }

    /// Compares the request of a job with its digest, and finds whether the result of a succeeded job is there.
    pub async fn inspect_job(&self, job: Uuid) -> Result<Inspection, JobError> {
        Inspection::or_unreadable(self.try_inspect_job(job).await)
    }

    async fn try_inspect_job(&self, job: Uuid) -> Result<Inspection, JobError> {
        let mut found = Inspection::default();
        let sql = format!(
            "SELECT owner, result_id IS NOT NULL AND NOT EXISTS (SELECT 1 FROM results WHERE id = jobs.result_id) AS lacks_result, \
             {SEALED_REQUEST} FROM jobs WHERE id = $1"
        );
        let row: Option<JobRow> = statement(sql).bind(job).optional(&self.readers).await?;
        // It may have been deleted meanwhile.
        let Some(JobRow { owner, lacks_result, request }) = row else { return Ok(found) };
        let (place, sealed) = request.sealed(job, &owner);
        found.add(|| REQUEST.to_owned(), &place, &sealed);
        if lacks_result {
            found.corrupt.push(METRICS.to_owned());
        }
        Ok(found)
    }

    /// The next jobs by id.
    pub async fn jobs_after(&self, last: Uuid) -> Result<Vec<Uuid>, JobError> {
        let sql = "SELECT id FROM jobs WHERE id > $1 ORDER BY id LIMIT $2";
        statement(sql).bind(last).bind(PAGE).values(&self.readers).await
    }

    /// The next results by id.
    pub async fn results_after(&self, last: Uuid) -> Result<Vec<Uuid>, JobError> {
        let sql = "SELECT id FROM results WHERE id > $1 ORDER BY id LIMIT $2";
        statement(sql).bind(last).bind(PAGE).values(&self.readers).await
    }

    /// The next studies by id.
    pub async fn studies_after(&self, last: Uuid) -> Result<Vec<Uuid>, JobError> {
        let sql = "SELECT job FROM studies WHERE job > $1 ORDER BY job LIMIT $2";
        statement(sql).bind(last).bind(PAGE).values(&self.readers).await
    }

    /// The jobs that a result belongs to.
    pub async fn jobs_of_result(&self, result: Uuid) -> Result<Vec<Uuid>, JobError> {
        statement("SELECT id FROM jobs WHERE result_id = $1 ORDER BY id").bind(result).values(&self.readers).await
    }

    /// Faults that SQLite finds in the structure of its file, indexes that disagree with their tables included; none on PostgreSQL,
    /// which has no such check.
    pub async fn structure_faults(&self) -> Result<Vec<String>, JobError> {
        if self.dialect() == Dialect::Postgres {
            return Ok(Vec::new());
        }
        let lines: Vec<String> = statement("PRAGMA integrity_check").values(&self.readers).await?;
        Ok(lines.into_iter().filter(|line| line != "ok").collect())
    }
}
