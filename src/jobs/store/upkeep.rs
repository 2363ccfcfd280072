//! What was lost, what has expired, and whether the disk takes writes.

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::database::{Dialect, Tx};
use super::statement::statement;
use super::{Store, micros, records, stored};
use crate::jobs::JobError;
use crate::jobs::queue::Delivery;

/// Rows a round of removal takes at most: the writer is shared with submissions.
const ROUND: i64 = 500;

/// Unfinished jobs that nothing will run any more: their delivery is gone or ended, or in the hands of a process that has died before
/// it took them up, or their run, with a delivery or without, gave no sign of life for `lost_after`. `alive` are the runs of this process, which need no sign.
pub async fn stranded(tx: &mut Tx, lost_after: SignedDuration, alive: &[Uuid]) -> Result<Vec<Delivery>, JobError> {
    let (now, orphaned) = (tx.dialect().now(), tx.dialect().is_orphaned());
    // What began with its acceptance never had a delivery; in a file it can only be a run of this process, or of one that is dead.
    let had_none = match tx.dialect() {
        Dialect::Sqlite => "FALSE",
        Dialect::Postgres => "jobs.status = 'running' AND jobs.delivery IS NULL",
    };
    let sql = format!(
        "SELECT jobs.id, jobs.priority FROM jobs LEFT JOIN river_job ON river_job.id = jobs.delivery \
         WHERE jobs.kind <> 'study' AND jobs.status IN ('queued', 'running') AND ((river_job.id IS NULL AND NOT ({had_none})) \
         OR river_job.state IN ('completed', 'cancelled', 'discarded') \
         OR (jobs.status = 'queued' AND {orphaned}) \
         OR (jobs.status = 'running' AND jobs.heartbeat_at < {now} - $1)) LIMIT $2"
    );
    let rows: Vec<(Uuid, i64)> = statement(sql).bind(micros(lost_after)).bind(ROUND).all(&mut *tx).await?;
    let stranded = rows.into_iter().filter(|row| !alive.contains(&row.0));
    Ok(stranded.map(|(id, priority)| Delivery::of_job(id, u8::try_from(priority).unwrap_or(2))).collect())
}

/// Ends jobs that someone wants to end and that nobody runs.
pub async fn end_cancelled(tx: &mut Tx, lost_after: SignedDuration, keep_s: f64) -> Result<(), JobError> {
    let now = tx.dialect().now();
    let sql = format!(
        "UPDATE jobs SET status = 'cancelled', finished_at = $1, \
         expires_at = $1 + CAST(coalesce(keep_for_s, $2) * 1e6 AS BIGINT) \
         WHERE kind <> 'study' AND cancel_requested_at IS NOT NULL AND (status = 'queued' \
         OR (status = 'running' AND heartbeat_at < {now} - $3)) RETURNING id"
    );
    let ended = statement(sql).bind(stored(Timestamp::now())).bind(keep_s).bind(micros(lost_after));
    for job in ended.values::<Uuid>(&mut *tx).await? {
        tx.tell_ended(job).await?;
    }
    Ok(())
}

/// Gives a job a new delivery, which makes older ones void. A run that was lost waits again: it is lost once, however long it waits, and
/// counts as with `claim`.
pub async fn redeliver(tx: &mut Tx, id: Uuid, delivery: i64, max_lost_runs: u32) -> Result<(), JobError> {
    let sql = "UPDATE jobs SET delivery = $2, \
               lost = lost + CASE WHEN status = 'running' AND lost < $3 THEN 1 ELSE 0 END, status = 'queued', \
               started_at = NULL, heartbeat_at = NULL, progress = 0 WHERE id = $1 AND status IN ('queued', 'running')";
    statement(sql).bind(id).bind(delivery).bind(i64::from(max_lost_runs)).run(&mut *tx).await?;
    Ok(())
}

/// Shows that a process is there that runs so many jobs at a time, and forgets those that are not any more.
pub async fn work(tx: &mut Tx, worker: Uuid, slots: usize, lost_after: SignedDuration) -> Result<(), JobError> {
    let now = tx.dialect().now();
    // A file has one process; elsewhere they show themselves less often than runs.
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

/// How the queue stands.
#[derive(Debug, Clone, Copy, PartialEq, sqlx::FromRow)]
pub struct Standing {
    pub waiting: i64,
    pub running: i64,
    /// [s]; 0 where none waits.
    pub oldest_waiting_s: f64,
    /// Places where runs may be.
    pub slots: i64,
}

/// How many jobs all processes together run at a time; 1 where there are none yet.
pub async fn slots(tx: &mut Tx) -> Result<usize, JobError> {
    let sql = "SELECT CAST(coalesce(sum(slots), 0) AS BIGINT) FROM workers";
    let (slots,): (i64,) = statement(sql).one(&mut *tx).await?;
    Ok(usize::try_from(slots).unwrap_or(1).max(1))
}

impl Store {
    /// How the queue stands.
    pub async fn standing(&self) -> Result<Standing, JobError> {
        let now = self.dialect().now();
        let sql = format!(
            "SELECT count(*) FILTER (WHERE status = 'queued') AS waiting, \
             count(*) FILTER (WHERE status = 'running') AS running, \
             CAST(coalesce({now} - min(created_at) FILTER (WHERE status = 'queued'), 0) AS DOUBLE PRECISION) / 1e6 AS oldest_waiting_s, \
             (SELECT CAST(coalesce(sum(slots), 0) AS BIGINT) FROM workers) AS slots \
             FROM jobs WHERE status IN ('queued', 'running')"
        );
        let standing: Standing = statement(sql).one(&self.readers).await?;
        // A clock may have been set back since.
        Ok(Standing { oldest_waiting_s: standing.oldest_waiting_s.max(0.0), ..standing })
    }

    /// Forgets a process that ends.
    pub async fn leave(&self, worker: Uuid) -> Result<(), JobError> {
        statement("DELETE FROM workers WHERE id = $1").bind(worker).run(&self.writer).await?;
        Ok(())
    }

    /// Jobs whose time is over.
    pub async fn expired(&self) -> Result<Vec<Uuid>, JobError> {
        let sql = "SELECT id FROM jobs WHERE expires_at < $1 LIMIT $2";
        statement(sql).bind(stored(Timestamp::now())).bind(ROUND).values(&self.readers).await
    }

    /// Removes jobs whose time is over.
    pub async fn remove(&self, jobs: &[Uuid]) -> Result<(), JobError> {
        let mut tx = self.begin().await?;
        for job in jobs {
            records::delete(&mut tx, *job).await?;
        }
        tx.commit().await
    }

    /// Writes something, to see whether the disk takes it.
    pub async fn try_write(&self) -> Result<(), JobError> {
        let sql = "INSERT INTO writability (id, written_at) VALUES (1, $1) \
                   ON CONFLICT (id) DO UPDATE SET written_at = excluded.written_at";
        statement(sql).bind(stored(Timestamp::now())).run(&self.writer).await?;
        Ok(())
    }
}
