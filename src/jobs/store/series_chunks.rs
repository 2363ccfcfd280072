//! Time series that a run writes chunk by chunk while it computes, and the removal of those of lost runs.
//!
//! The result of such a run is there before the run has ended, without metrics, and `recordings` names the claim that writes it. The
//! end of the run completes the result and removes that row. A row whose claim no longer runs belongs to a lost run.

use uuid::Uuid;

use super::database::Store;
use super::digest::{Place, Sealed};
use super::part_names::METRICS;
use super::statement::{Statement, statement};
use crate::jobs::error::JobError;

/// A chunk of a series.
#[derive(Debug)]
pub struct Chunk {
    /// Number of the series in the order of the request.
    pub series: i64,
    /// Number of the chunk in the series.
    pub number: i64,
    pub content: Sealed<Vec<u8>>,
}

/// The chunks of all series of a result.
#[derive(Debug)]
pub struct RecordedChunks {
    pub result: Uuid,
    /// True if its first chunks are stored already.
    pub is_stored: bool,
    /// The chunks that are not stored yet.
    pub rest: Vec<Chunk>,
}

impl RecordedChunks {
    /// A new result without series.
    pub fn none() -> Self {
        Self { result: Uuid::now_v7(), is_stored: false, rest: Vec::new() }
    }
}

/// Largest number of chunks that one transaction removes: the writer is shared with submissions.
const MAX_REMOVED: i64 = 32;

/// The metrics of a result that is no simulation's.
pub(super) fn no_metrics(result: Uuid) -> Sealed<String> {
    Sealed::new(&Place::of_result(result, METRICS), String::new())
}

/// Statement that inserts chunks; `provided` is the end of a query that yields one row if they are to be inserted.
pub(super) fn insertion_of_chunks(result: Uuid, chunks: &[Chunk], provided: &str) -> Statement {
    let row = |k| format!("SELECT $1, ${}, ${}, ${}, ${}{provided}", 4 * k + 2, 4 * k + 3, 4 * k + 4, 4 * k + 5);
    let rows: Vec<String> = (0..chunks.len()).map(row).collect();
    // A chunk may be there if the answer to its commit was lost.
    let sql = format!(
        "INSERT INTO series_chunks (result_id, series, number, content, digest) {} ON CONFLICT DO NOTHING",
        rows.join(" UNION ALL ")
    );
    chunks.iter().fold(statement(sql).bind(result), |insert, chunk| {
        let Sealed { content, digest } = &chunk.content;
        insert.bind(chunk.series).bind(chunk.number).bind(content).bind(digest.as_deref())
    })
}

/// Statement that takes a result out of the recordings, because its run has ended.
pub(super) fn completion(result: Uuid, provided: &str) -> Statement {
    statement(format!("DELETE FROM recordings WHERE result_id = $1 AND EXISTS (SELECT 1{provided})")).bind(result)
}

impl Store {
    /// Stores chunks of a result that the run of a claim is writing. Returns whether the claim holds the job: if the job has just been
    /// accepted, it may not be written yet.
    pub async fn append_chunks(&self, job: Uuid, claim: i64, result: Uuid, chunks: &[Chunk]) -> Result<bool, JobError> {
        let mut tx = self.begin().await?;
        let sql = "SELECT 1 FROM jobs WHERE id = $1 AND claim = $2 AND status = 'running'";
        let held = statement(sql).bind(job).bind(claim);
        if held.optional::<(i32,)>(&mut tx).await?.is_none() {
            return Ok(false);
        }
        let Sealed { content, digest } = no_metrics(result);
        let sql = "INSERT INTO results (id, metrics, digest) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING";
        statement(sql).bind(result).bind(content).bind(digest.as_deref()).run(&mut tx).await?;
        let sql = "INSERT INTO recordings (result_id, job, claim) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING";
        statement(sql).bind(result).bind(job).bind(claim).run(&mut tx).await?;
        insertion_of_chunks(result, chunks, " WHERE TRUE").run(&mut tx).await?;
        tx.commit().await?;
        Ok(true)
    }

    /// Removes a result that no run will complete. A completed one stays.
    pub async fn remove_recording(&self, result: Uuid) -> Result<(), JobError> {
        let is_recorded = "EXISTS (SELECT 1 FROM recordings WHERE result_id = $1)";
        let chunks = format!(
            "DELETE FROM series_chunks WHERE (result_id, series, number) IN \
             (SELECT result_id, series, number FROM series_chunks WHERE result_id = $1 AND {is_recorded} LIMIT $2)"
        );
        while statement(chunks.clone()).bind(result).bind(MAX_REMOVED).run(&self.writer).await? > 0 {}
        let sql = format!("DELETE FROM results WHERE id = $1 AND {is_recorded}");
        statement(sql).bind(result).run(&self.writer).await?;
        Ok(())
    }

    /// Removes the results that lost runs were writing; returns their number.
    pub async fn remove_lost_recordings(&self) -> Result<usize, JobError> {
        let sql = "SELECT result_id FROM recordings WHERE NOT EXISTS \
                   (SELECT 1 FROM jobs WHERE id = recordings.job AND claim = recordings.claim AND status = 'running')";
        let lost: Vec<Uuid> = statement(sql).values(&self.readers).await?;
        for result in &lost {
            self.remove_recording(*result).await?;
        }
        Ok(lost.len())
    }
}
