//! Removed jobs. Expired ones are remembered with their last state for a while, and idempotency keys as long as that.

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::database::Store;
use super::pool::Tx;
use super::results;
use super::statement::{Executor, Statement, statement};
use super::stored_time::{micros, stored, time};
use crate::jobs::error::JobError;
use crate::jobs::job::{ExpiredJob, Status};

/// Largest number of rows of one transaction: the writer is shared with submissions.
const MAX_ROWS: i64 = 500;

/// Shortest time for which a key is kept after its first use.
const MIN_KEY_RETENTION: SignedDuration = SignedDuration::from_hours(24);

/// An expired job of this owner, if it is remembered.
pub async fn expired<'a>(
    place: impl Into<Executor<'a>>,
    owner: &str,
    id: Uuid,
) -> Result<Option<ExpiredJob>, JobError> {
    let sql = "SELECT kind, status, finished_at, removed_at FROM removed_jobs \
               WHERE id = $1 AND owner = $2 AND status IS NOT NULL";
    let row: Option<(String, String, i64, i64)> = statement(sql).bind(id).bind(owner).optional(place).await?;
    row.map(|(kind, status, finished_at, expired_at)| {
        let status = Status::parse(&status).ok_or_else(|| JobError::Corrupt(format!("status of job {id}")))?;
        Ok(ExpiredJob { id, kind, status, finished_at: time(finished_at)?, expired_at: time(expired_at)? })
    })
    .transpose()
}

/// Removes an ended job, and its result unless another job shares it. The key that made it is kept for a day after its first use.
pub async fn delete(tx: &mut Tx, id: Uuid) -> Result<(), JobError> {
    let sql = "INSERT INTO removed_jobs (id, owner, removed_at, forget_at) \
               SELECT job, owner, $2, created_at + $3 FROM idempotency_keys WHERE job = $1 ON CONFLICT (id) DO NOTHING";
    let removed = statement(sql).bind(id).bind(stored(Timestamp::now())).bind(micros(MIN_KEY_RETENTION));
    removed.run(&mut *tx).await?;
    let sql = "DELETE FROM jobs WHERE id = $1 RETURNING result_id";
    let result: Option<Option<Uuid>> = statement(sql).bind(id).value(&mut *tx).await?;
    match result.flatten() {
        Some(result) => results::remove_orphan(tx, result).await,
        None => Ok(()),
    }
}

/// A statement whose places from `from` on are these ids, listed in its text at `{ids}`.
fn of_ids(sql: &str, from: usize, ids: &[Uuid]) -> Statement {
    let places: Vec<String> = (from..from + ids.len()).map(|place| format!("${place}")).collect();
    statement(sql.replace("{ids}", &places.join(", ")))
}

fn bound(statement: Statement, ids: &[Uuid]) -> Statement {
    ids.iter().fold(statement, Statement::bind)
}

impl Store {
    /// An expired job of this owner, if it is remembered.
    pub async fn expired_job(&self, owner: &str, id: Uuid) -> Result<Option<ExpiredJob>, JobError> {
        expired(&self.readers, owner, id).await
    }

    /// Removes some expired jobs and remembers them for `remembered`; returns whether there may be more.
    pub async fn expire(&self, remembered: SignedDuration) -> Result<bool, JobError> {
        let now = stored(Timestamp::now());
        let sql = "SELECT EXISTS (SELECT 1 FROM jobs WHERE expires_at < $1)";
        if !statement(sql).bind(now).value(&self.readers).await?.unwrap_or(false) {
            return Ok(false);
        }
        let mut tx = self.begin().await?;
        let sql = format!(
            "SELECT id FROM jobs WHERE expires_at < $1 ORDER BY expires_at LIMIT $2{}",
            self.dialect().for_update_of_free_rows()
        );
        let ids: Vec<Uuid> = statement(sql).bind(now).bind(MAX_ROWS).values(&mut tx).await?;
        if ids.is_empty() {
            return Ok(false);
        }
        // A key is kept for a day, and as long as its job is remembered.
        let sql = "INSERT INTO removed_jobs (id, owner, kind, status, finished_at, removed_at, forget_at) \
                   SELECT id, owner, kind, status, finished_at, $1, CASE WHEN created_at + $2 > $3 THEN created_at + $2 ELSE $3 END \
                   FROM jobs WHERE id IN ({ids}) ON CONFLICT (id) DO NOTHING";
        let removed = of_ids(sql, 4, &ids).bind(now).bind(micros(MIN_KEY_RETENTION));
        bound(removed.bind(now.saturating_add(micros(remembered))), &ids).run(&mut tx).await?;
        let sql = "DELETE FROM jobs WHERE id IN ({ids}) RETURNING result_id";
        let results: Vec<Option<Uuid>> = bound(of_ids(sql, 1, &ids), &ids).values(&mut tx).await?;
        let mut results: Vec<Uuid> = results.into_iter().flatten().collect();
        results.sort_unstable();
        results.dedup();
        results::remove_orphans(&mut tx, &results).await?;
        tx.commit().await?;
        Ok(ids.len() == MAX_ROWS as usize)
    }

    /// Forgets some removed jobs and their keys; returns whether there may be more.
    pub async fn forget(&self) -> Result<bool, JobError> {
        let sql = "SELECT id FROM removed_jobs WHERE forget_at < $1 LIMIT $2";
        let old = statement(sql).bind(stored(Timestamp::now())).bind(MAX_ROWS);
        let ids: Vec<Uuid> = old.values(&self.readers).await?;
        if ids.is_empty() {
            return Ok(false);
        }
        let mut tx = self.begin().await?;
        for (table, column) in [("idempotency_keys", "job"), ("removed_jobs", "id")] {
            let sql = format!("DELETE FROM {table} WHERE {column} IN ({{ids}})");
            bound(of_ids(&sql, 1, &ids), &ids).run(&mut tx).await?;
        }
        tx.commit().await?;
        Ok(ids.len() == MAX_ROWS as usize)
    }
}
