//! Whose work is due: start-time fair queueing over processor time.
//!
//! The virtual time of an owner [s] starts a turn at the greater of its own end and the latest start of all owners; processor time
//! moves its end on. The owner with the least start is due. Time that an owner uses while no other waits is therefore no debt, and
//! an owner that returns has neither credit nor a place behind the others.

use uuid::Uuid;

use super::pool::Tx;
use super::statement::{Statement, statement};
use crate::jobs::error::JobError;

/// Priority of a shard within the work of its owner: behind single jobs of default priority.
const SHARD_PRIORITY: i64 = 4;

/// Work that can take a turn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Work {
    pub job: Uuid,
    pub owner: String,
    pub delivery: i64,
    pub shard: bool,
    /// Number of runs that ended with their process.
    pub losses: i64,
}

/// Expressions over the owners with waiting jobs and shards. Each step of the recursion is one look into an index, so that its cost
/// grows with the number of owners and not with that of their jobs.
const DUE_OWNERS: &str = "WITH RECURSIVE \
     of_jobs (owner) AS (SELECT min(owner) FROM jobs WHERE status = 'queued' AND delivery IS NOT NULL \
      UNION ALL SELECT (SELECT min(owner) FROM jobs WHERE status = 'queued' AND delivery IS NOT NULL \
      AND owner > of_jobs.owner) FROM of_jobs WHERE of_jobs.owner IS NOT NULL), \
     of_shards (owner) AS (SELECT min(owner) FROM strands WHERE waiting_since IS NOT NULL \
      UNION ALL SELECT (SELECT min(owner) FROM strands WHERE waiting_since IS NOT NULL \
      AND owner > of_shards.owner) FROM of_shards WHERE of_shards.owner IS NOT NULL), \
     latest (start) AS (SELECT coalesce(max(started), 0) FROM turns), \
     waiting (owner) AS (SELECT owner FROM of_jobs UNION SELECT owner FROM of_shards) \
     SELECT waiting.owner FROM waiting CROSS JOIN latest LEFT JOIN turns ON turns.owner = waiting.owner \
     WHERE waiting.owner IS NOT NULL \
     ORDER BY CASE WHEN turns.ended > latest.start THEN turns.ended ELSE latest.start END, coalesce(turns.started, -1)";

/// The waiting job of an owner that goes first.
const FIRST_JOB: &str = "SELECT id, delivery, lost, priority, created_at FROM jobs \
     WHERE owner = $1 AND status = 'queued' AND delivery IS NOT NULL ORDER BY priority, id LIMIT 1";

/// The waiting shard of an owner that goes first.
const FIRST_SHARD: &str = "SELECT job, delivery, waiting_since FROM strands \
     WHERE owner = $1 AND waiting_since IS NOT NULL ORDER BY waiting_since, delivery LIMIT 1";

/// The queries of this file, each of which reads indexes only.
#[cfg(test)]
pub const QUERIES: [&str; 3] = [DUE_OWNERS, FIRST_JOB, FIRST_SHARD];

/// The work that is due, with its priority. `lock` ends the queries for its row.
pub async fn due(tx: &mut Tx, lock: &str) -> Result<Option<(Work, i64)>, JobError> {
    let owners: Vec<String> = statement(DUE_OWNERS).values(&mut *tx).await?;
    for owner in owners {
        let job: Option<(Uuid, i64, i64, i64, i64)> =
            statement(format!("{FIRST_JOB}{lock}")).bind(&owner).optional(&mut *tx).await?;
        let goes_first = |job: &(Uuid, i64, i64, i64, i64)| job.3 < SHARD_PRIORITY;
        let shard: Option<(Uuid, i64, i64)> = match &job {
            Some(job) if goes_first(job) => None,
            _ => statement(format!("{FIRST_SHARD}{lock}")).bind(&owner).optional(&mut *tx).await?,
        };
        return Ok(Some(match (job, shard) {
            (Some((job, delivery, losses, priority, created_at)), shard)
                if shard.is_none_or(|(_, _, since)| created_at <= since) =>
            {
                (Work { job, owner, delivery, shard: false, losses }, priority)
            }
            (_, Some((job, delivery, _))) => (Work { job, owner, delivery, shard: true, losses: 0 }, SHARD_PRIORITY),
            // Other processes have just taken all of it.
            (_, None) => continue,
        }));
    }
    Ok(None)
}

/// Returns whether a running shard of `owner` gives way after a point: to another owner that is due, to its owner's jobs of higher
/// priority, and after its time slice to any work.
pub async fn gives_way(tx: &mut Tx, owner: &str, slice_is_over: bool) -> Result<bool, JobError> {
    let next = due(tx, "").await?;
    Ok(next.is_some_and(|(work, priority)| slice_is_over || work.owner != owner || priority < SHARD_PRIORITY))
}

/// Records that work of an owner begins.
pub async fn begin_turn(tx: &mut Tx, owner: &str) -> Result<(), JobError> {
    let sql = "INSERT INTO turns (owner, started, ended) \
               SELECT $1, latest.start, latest.start FROM (SELECT coalesce(max(started), 0) AS start FROM turns) AS latest WHERE TRUE \
               ON CONFLICT (owner) DO UPDATE SET \
               started = CASE WHEN turns.ended > excluded.started THEN turns.ended ELSE excluded.started END, \
               ended = CASE WHEN turns.ended > excluded.started THEN turns.ended ELSE excluded.started END";
    statement(sql).bind(owner).run(&mut *tx).await?;
    Ok(())
}

/// Statement that charges processor time [s] to an owner.
pub fn charge(owner: &str, seconds: f64) -> Statement {
    statement("UPDATE turns SET ended = ended + $2 WHERE owner = $1").bind(owner).bind(seconds)
}
