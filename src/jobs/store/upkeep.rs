//! What was lost, what has expired, and whether the disk takes writes.

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::{Store, records, stored};
use crate::jobs::JobError;
use crate::jobs::queue::Tx;

/// Rows a round of removal takes at most: the writer is shared with submissions.
const ROUND: i64 = 500;

/// Unfinished jobs that nothing will run any more: their delivery is gone or ended, or their worker gave
/// no sign of life for `lost_after`. `alive` are the runs of this process, which need no sign.
pub async fn stranded(tx: &mut Tx, lost_after: SignedDuration, alive: &[Uuid]) -> Result<Vec<(Uuid, u8)>, JobError> {
    let sql = "SELECT jobs.id, jobs.priority FROM jobs LEFT JOIN river_job ON river_job.id = jobs.delivery \
               WHERE jobs.kind <> 'study' AND jobs.status IN ('queued', 'running') AND (river_job.id IS NULL \
               OR river_job.state IN ('completed', 'cancelled', 'discarded') \
               OR (jobs.status = 'running' AND jobs.heartbeat_at < $1)) LIMIT $2";
    let silent_since = Timestamp::now().saturating_sub(lost_after).unwrap_or(Timestamp::MIN);
    let rows: Vec<(Uuid, i64)> =
        sqlx::query_as(sql).bind(stored(silent_since)).bind(ROUND).fetch_all(&mut **tx).await?;
    let stranded = rows.into_iter().filter(|row| !alive.contains(&row.0));
    Ok(stranded.map(|(id, priority)| (id, u8::try_from(priority).unwrap_or(2))).collect())
}

/// Gives a job a new delivery, which makes older ones void.
pub async fn redeliver(tx: &mut Tx, id: Uuid, delivery: i64) -> Result<(), JobError> {
    let sql = "UPDATE jobs SET delivery = $2 WHERE id = $1";
    sqlx::query(sql).bind(id).bind(delivery).execute(&mut **tx).await?;
    Ok(())
}

impl Store {
    /// Jobs whose time is over.
    pub async fn expired(&self) -> Result<Vec<Uuid>, JobError> {
        let sql = "SELECT id FROM jobs WHERE expires_at < $1 LIMIT $2";
        Ok(sqlx::query_scalar(sql).bind(stored(Timestamp::now())).bind(ROUND).fetch_all(&self.readers).await?)
    }

    /// Removes jobs whose time is over.
    pub async fn remove(&self, jobs: &[Uuid]) -> Result<(), JobError> {
        let mut tx = self.begin().await?;
        for job in jobs {
            records::delete(&mut tx, *job).await?;
        }
        Ok(tx.commit().await?)
    }

    /// Writes something, to see whether the disk takes it.
    pub async fn try_write(&self) -> Result<(), JobError> {
        let sql = "INSERT INTO writability (id, written_at) VALUES (1, $1) \
                   ON CONFLICT (id) DO UPDATE SET written_at = excluded.written_at";
        sqlx::query(sql).bind(stored(Timestamp::now())).execute(&self.writer).await?;
        Ok(())
    }
}
