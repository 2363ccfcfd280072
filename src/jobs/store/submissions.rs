//! Submissions: a row of `jobs` with the delivery that the same transaction creates.

use std::collections::HashMap;

use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::digest::{Place, digest_of};
use super::pool::{Lock, Tx};
use super::reuse::Reusable;
use super::statement::statement;
use super::stored_time::{self, stored};
use super::studies;
use crate::jobs::error::JobError;
use crate::jobs::job::{JobRecord, NewJob, Status};

/// Unfinished work of one owner.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Unfinished {
    /// Queued and running single jobs.
    pub jobs: u64,
    /// Unfinished points of queued and running studies.
    pub points: u64,
}

impl Unfinished {
    /// The number of points or of single jobs.
    pub fn of(self, points: bool) -> u64 {
        if points { self.points } else { self.jobs }
    }
}

/// Unfinished work by owner, as triggers count it.
pub(in crate::jobs) const UNFINISHED: &str =
    "SELECT owner, CAST(sum(jobs) AS BIGINT), CAST(sum(points) AS BIGINT) FROM unfinished GROUP BY owner";

/// Unfinished work by owner. On PostgreSQL work that other processes are accepting at the same moment is not counted yet.
pub async fn unfinished(tx: &mut Tx) -> Result<HashMap<String, Unfinished>, JobError> {
    let counts: Vec<(String, i64, i64)> = statement(UNFINISHED).all(&mut *tx).await?;
    let count = |number: i64| u64::try_from(number).unwrap_or(0);
    let of_owner = |(owner, jobs, points)| (owner, Unfinished { jobs: count(jobs), points: count(points) });
    Ok(counts.into_iter().map(of_owner).collect())
}

impl Store {
    /// Adds the counts of closed connections together, so that their number does not grow, and removes counts of nothing.
    pub async fn join_counts(&self) -> Result<(), JobError> {
        let mut tx = self.begin_locked(Lock::Counts).await?;
        if tx.dialect() == Dialect::Postgres {
            let sql = "WITH closed AS (DELETE FROM unfinished WHERE part <> 0 \
                   AND part NOT IN (SELECT pid FROM pg_stat_activity) RETURNING owner, jobs, points) \
                   INSERT INTO unfinished AS u (owner, part, jobs, points) \
                   SELECT owner, 0, sum(jobs), sum(points) FROM closed GROUP BY owner \
                   ON CONFLICT (owner, part) DO UPDATE SET jobs = u.jobs + excluded.jobs, points = u.points + excluded.points";
            statement(sql).run(&mut tx).await?;
        }
        statement("DELETE FROM unfinished WHERE part = 0 AND jobs = 0 AND points = 0").run(&mut tx).await?;
        tx.commit().await
    }
}

const ANY_WAITS: &str = "SELECT EXISTS (SELECT 1 FROM jobs WHERE status = 'queued' AND delivery IS NOT NULL) \
     OR EXISTS (SELECT 1 FROM strands WHERE waiting_since IS NOT NULL)";

/// The queries of a submission: each reads an index, or the counts of unfinished work.
#[cfg(test)]
pub const QUERIES: [&str; 4] = [UNFINISHED, ANY_WAITS, super::reuse::REUSABLE, super::idempotency_keys::FIRST_USE];

/// Returns whether a job or a shard waits for a turn.
pub async fn any_waits(tx: &mut Tx) -> Result<bool, JobError> {
    Ok(statement(ANY_WAITS).value(&mut *tx).await?.unwrap_or(false))
}

/// Inserts a queued job.
pub async fn insert(tx: &mut Tx, job: &NewJob, delivery: i64) -> Result<JobRecord, JobError> {
    let record = job.record();
    insert_row(tx, job, &record, Some(delivery), None).await?;
    Ok(record)
}

/// Inserts a job that started as it was accepted, with the claim of `Claim::at_acceptance` and no delivery. The returned record is
/// that of a queued job, as for any other submission.
pub async fn insert_started(tx: &mut Tx, job: &NewJob) -> Result<JobRecord, JobError> {
    let record = job.record();
    let running = JobRecord { status: Status::Running, started_at: Some(job.created_at), ..record.clone() };
    insert_row(tx, job, &running, None, None).await?;
    Ok(record)
}

/// Inserts a study with its points and shards.
pub async fn insert_study(tx: &mut Tx, job: &NewJob, points: usize, shards: &[i64]) -> Result<JobRecord, JobError> {
    let record = job.record();
    insert_row(tx, job, &record, None, None).await?;
    studies::insert(tx, job.id, points, shards).await?;
    Ok(record)
}

/// Expiry of a job that is answered by an existing result.
pub fn expiry(job: &NewJob, keep_s: f64) -> jiff::Timestamp {
    stored_time::expiry(job.created_at, job.keep_for_s.unwrap_or(keep_s))
}

/// Inserts a job that is answered by an existing result.
pub async fn insert_answered(tx: &mut Tx, job: &NewJob, found: Reusable, keep_s: f64) -> Result<JobRecord, JobError> {
    let now = job.created_at;
    let record = JobRecord {
        status: Status::Succeeded,
        started_at: Some(now),
        finished_at: Some(now),
        expires_at: Some(expiry(job, keep_s)),
        progress: 1.0,
        reused: true,
        ..job.record()
    };
    insert_row(tx, job, &record, None, Some(found.result)).await?;
    Ok(record)
}

async fn insert_row(
    tx: &mut Tx,
    job: &NewJob,
    record: &JobRecord,
    delivery: Option<i64>,
    result: Option<Uuid>,
) -> Result<(), JobError> {
    let now = tx.dialect().now();
    let sql = format!(
        "INSERT INTO jobs (id, owner, kind, status, request, labels, priority, keep_for_s, created_at, \
               started_at, finished_at, expires_at, progress, delivery, content_hash, reused, result_id, claim, points_left, \
               request_digest, heartbeat_at) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19, $20, \
         CASE WHEN $4 = 'running' THEN {now} END)"
    );
    let place = Place::of_request(job.id, &job.owner, &job.content_hash);
    let labels = serde_json::to_string(&job.labels).map_err(|error| JobError::Corrupt(error.to_string()))?;
    statement(sql)
        .bind(job.id)
        .bind(&job.owner)
        .bind(job.kind)
        .bind(record.status.name())
        .bind(&job.request)
        .bind(labels)
        .bind(i64::from(job.priority))
        .bind(job.keep_for_s)
        .bind(stored(record.created_at))
        .bind(record.started_at.map(stored))
        .bind(record.finished_at.map(stored))
        .bind(record.expires_at.map(stored))
        .bind(record.progress)
        .bind(delivery)
        .bind(&job.content_hash)
        .bind(record.reused)
        .bind(result)
        .bind(i64::from(record.status == Status::Running))
        .bind(i64::try_from(job.points.unwrap_or(0)).unwrap_or(i64::MAX))
        .bind(digest_of(&place, job.request.as_bytes()))
        .run(&mut *tx)
        .await?;
    insert_labels(tx, job).await
}

/// Inserts the labels of a job, by which lists find it.
async fn insert_labels(tx: &mut Tx, job: &NewJob) -> Result<(), JobError> {
    if job.labels.is_empty() {
        return Ok(());
    }
    let rows: Vec<String> = (0..job.labels.len()).map(|k| format!("($1, ${}, $2)", k + 3)).collect();
    // A label may be given twice.
    let sql = format!("INSERT INTO job_labels (owner, label, job) VALUES {} ON CONFLICT DO NOTHING", rows.join(", "));
    let insert = statement(sql).bind(&job.owner).bind(job.id);
    job.labels.iter().fold(insert, |insert, label| insert.bind(label)).run(&mut *tx).await?;
    Ok(())
}
