//! Lost runs, listed workers, and a test write to the disk.

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::notifications::notify_ended;
use super::pool::Tx;
use super::statement::statement;
use super::stored_time::{micros, stored};
use crate::jobs::error::JobError;
use crate::jobs::service_metrics::QueueDepth;

/// Largest number of rows of one transaction: the writer is shared with submissions.
const MAX_ROWS: i64 = 500;

/// Unfinished jobs that no process will run without a new delivery.
///
/// - The delivery is missing or completed.
/// - The process that holds the delivery has died before it claimed the job.
/// - The run, with a delivery or without, has sent no heartbeat for `lost_after`. Runs of this process (`alive`) need none.
pub async fn undeliverable(tx: &mut Tx, lost_after: SignedDuration, alive: &[Uuid]) -> Result<Vec<Uuid>, JobError> {
    let (now, orphaned) = (tx.dialect().now(), tx.dialect().is_orphaned());
    // A job that started as it was accepted never had a delivery. In a file it can only be a run of this process, or of a dead one.
    let had_none = match tx.dialect() {
        Dialect::Sqlite => "FALSE",
        Dialect::Postgres => "jobs.status = 'running' AND jobs.delivery IS NULL",
    };
    let sql = format!(
        "SELECT jobs.id FROM jobs LEFT JOIN river_job ON river_job.id = jobs.delivery \
         WHERE jobs.kind NOT IN ('study', 'uncertainty') AND jobs.status IN ('queued', 'running') AND ((river_job.id IS NULL AND NOT ({had_none})) \
         OR river_job.state IN ('completed', 'cancelled', 'discarded') \
         OR (jobs.status = 'queued' AND {orphaned}) \
         OR (jobs.status = 'running' AND jobs.heartbeat_at < {now} - $1)) LIMIT $2"
    );
    let jobs: Vec<Uuid> = statement(sql).bind(micros(lost_after)).bind(MAX_ROWS).values(&mut *tx).await?;
    Ok(jobs.into_iter().filter(|job| !alive.contains(job)).collect())
}

/// Ends jobs whose cancellation was requested and that no process runs.
pub async fn end_cancelled(tx: &mut Tx, lost_after: SignedDuration, keep_s: f64) -> Result<(), JobError> {
    let now = tx.dialect().now();
    let sql = format!(
        "UPDATE jobs SET status = 'cancelled', finished_at = $1, \
         expires_at = $1 + CAST(coalesce(keep_for_s, $2) * 1e6 AS BIGINT) \
         WHERE kind NOT IN ('study', 'uncertainty') AND cancel_requested_at IS NOT NULL AND (status = 'queued' \
         OR (status = 'running' AND heartbeat_at < {now} - $3)) RETURNING id"
    );
    let ended = statement(sql).bind(stored(Timestamp::now())).bind(keep_s).bind(micros(lost_after));
    for job in ended.values::<Uuid>(&mut *tx).await? {
        notify_ended(&mut *tx, job).await?;
    }
    Ok(())
}

/// Gives a job a new delivery, which makes older ones void. A lost run is queued again and counts as one loss, as in `claim`.
pub async fn redeliver(tx: &mut Tx, id: Uuid, delivery: i64, max_lost_runs: u32) -> Result<(), JobError> {
    let sql = "UPDATE jobs SET delivery = $2, \
               lost = lost + CASE WHEN status = 'running' AND lost < $3 THEN 1 ELSE 0 END, status = 'queued', \
               started_at = NULL, heartbeat_at = NULL, progress = 0 WHERE id = $1 AND status IN ('queued', 'running')";
    statement(sql).bind(id).bind(delivery).bind(i64::from(max_lost_runs)).run(&mut *tx).await?;
    Ok(())
}

/// Lists this process as a worker with `slots` runs at a time, and removes workers that have sent no heartbeat.
pub async fn list_worker(tx: &mut Tx, worker: Uuid, slots: usize, lost_after: SignedDuration) -> Result<(), JobError> {
    let now = tx.dialect().now();
    // A file has one process. On a server workers send heartbeats less often than runs.
    match tx.dialect() {
        Dialect::Sqlite => statement("DELETE FROM workers WHERE id <> $1").bind(worker).run(&mut *tx).await?,
        Dialect::Postgres => {
            let gone = format!("DELETE FROM workers WHERE heartbeat_at < {now} - $1");
            statement(gone).bind(micros(lost_after.saturating_mul(3))).run(&mut *tx).await?
        }
    };
    let sql = format!(
        "INSERT INTO workers (id, slots, heartbeat_at) VALUES ($1, $2, {now}) \
         ON CONFLICT (id) DO UPDATE SET heartbeat_at = excluded.heartbeat_at"
    );
    statement(sql).bind(worker).bind(i64::try_from(slots).unwrap_or(i64::MAX)).run(&mut *tx).await?;
    Ok(())
}

/// Number of runs that all workers together can carry out at a time; at least 1.
pub async fn slots(tx: &mut Tx) -> Result<usize, JobError> {
    let sql = "SELECT CAST(coalesce(sum(slots), 0) AS BIGINT) FROM workers";
    let (slots,): (i64,) = statement(sql).one(&mut *tx).await?;
    Ok(usize::try_from(slots).unwrap_or(1).max(1))
}

impl Store {
    /// The depth of the queue.
    pub async fn queue_depth(&self) -> Result<QueueDepth, JobError> {
        let now = self.dialect().now();
        let sql = format!(
            "SELECT count(*) FILTER (WHERE status = 'queued') AS waiting, \
             count(*) FILTER (WHERE status = 'running') AS running, \
             CAST(coalesce({now} - min(created_at) FILTER (WHERE status = 'queued'), 0) AS DOUBLE PRECISION) / 1e6 AS oldest_waiting_s, \
             (SELECT CAST(coalesce(sum(slots), 0) AS BIGINT) FROM workers) AS slots \
             FROM jobs WHERE status IN ('queued', 'running')"
        );
        let depth: QueueDepth = statement(sql).one(&self.readers).await?;
        // Negative after a clock was set back.
        Ok(QueueDepth { oldest_waiting_s: depth.oldest_waiting_s.max(0.0), ..depth })
    }

    /// Removes a process that ends from the list of workers.
    pub async fn unlist_worker(&self, worker: Uuid) -> Result<(), JobError> {
        statement("DELETE FROM workers WHERE id = $1").bind(worker).run(&self.writer).await?;
        Ok(())
    }

    /// Writes one row; fails if the disk is full or the database is read-only.
    pub async fn try_write(&self) -> Result<(), JobError> {
        let sql = "INSERT INTO writability (id, written_at) VALUES (1, $1) \
                   ON CONFLICT (id) DO UPDATE SET written_at = excluded.written_at";
        statement(sql).bind(stored(Timestamp::now())).run(&self.writer).await?;
        Ok(())
    }
}
