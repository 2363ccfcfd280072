//! Turns: a delivery of the queue is a turn, and the work of the owner that is due takes it.
//!
//! Start-time fair queueing over processor time. The virtual time of an owner [s] starts a turn at the greater of its own end and
//! the latest start of all owners; processor time moves its end on. The owner with the least start is due. Time that an owner uses
//! while no other waits is therefore no debt, and an owner that returns has neither credit nor a place behind the others.
//!
//! Every waiting job and shard has a delivery. Work that takes the turn of another gets its delivery, and the other gets that of
//! the work: as many deliveries wait as work does.

use uuid::Uuid;

use super::claims::{self, Claim};
use super::database::Store;
use super::dialect::Dialect;
use super::pool::Tx;
use super::statement::{Statement, statement};
use super::studies::{self, StudyShard};
use crate::jobs::error::JobError;

/// Number of losses from which work runs alone, so that it ends no other run with its process.
const LOSSES_TO_RUN_ALONE: i64 = 2;

/// Priority of a shard within the work of its owner: behind single jobs of default priority.
const SHARD_PRIORITY: i64 = 4;

/// What the turn of a delivery is used for.
#[derive(Debug)]
pub enum Turn {
    /// No unfinished work has this delivery.
    Void,
    /// The work that is due must run alone. The turn is not taken.
    Alone,
    Job(Claim),
    Shard(StudyShard),
}

/// Limits of the runs of a turn.
#[derive(Debug, Clone, Copy)]
pub struct TurnLimits {
    pub max_lost_runs: u32,
    /// Whether no other run may begin meanwhile.
    pub alone: bool,
}

/// Work that can take a turn.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Work {
    job: Uuid,
    owner: String,
    delivery: i64,
    shard: bool,
    /// Number of runs that ended with their process.
    losses: i64,
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

/// The unfinished job of a delivery, and whether it waits.
const JOB_OF_DELIVERY: &str = "SELECT id, owner, status = 'queued', lost FROM jobs \
     WHERE delivery = $1 AND status IN ('queued', 'running')";

/// The shard of a delivery, whether it waits, and the largest number of losses of a point that it was running.
const SHARD_OF_DELIVERY: &str = "SELECT job, owner, waiting_since IS NOT NULL, \
     (SELECT coalesce(max(lost) + 1, 0) FROM points WHERE strand = $1 AND status = 'running') \
     FROM strands WHERE delivery = $1";

/// The queries of a turn, each of which reads an index only.
#[cfg(test)]
pub const QUERIES: [&str; 5] = [DUE_OWNERS, FIRST_JOB, FIRST_SHARD, JOB_OF_DELIVERY, SHARD_OF_DELIVERY];

/// Suffix that locks a row, and passes over one that another process has locked. SQLite has a single writer.
const LOCK_AND_PASS_OVER: &str = " FOR UPDATE SKIP LOCKED";

impl Store {
    /// Takes the turn of a delivery for the work that is due. Work that was lost with its process keeps its own turn.
    pub async fn take_turn(&self, delivery: i64, limits: TurnLimits) -> Result<Turn, JobError> {
        let mut tx = self.begin().await?;
        let mut own = work_of(&mut tx, delivery).await?;
        if own.is_none() && tx.dialect() == Dialect::Postgres {
            // Another process may have given this delivery to other work after the statement began.
            own = work_of(&mut tx, delivery).await?;
        }
        let Some((own, waits)) = own else { return Ok(Turn::Void) };
        let lock = if tx.dialect() == Dialect::Postgres { LOCK_AND_PASS_OVER } else { "" };
        let due = if waits { due(&mut tx, lock).await? } else { None };
        let due = due.map_or_else(|| own.clone(), |(work, _)| work);
        if due.losses >= LOSSES_TO_RUN_ALONE && !limits.alone {
            return Ok(Turn::Alone);
        }
        if due != own {
            exchange(&mut tx, &own, &due).await?;
        }
        let turn = if due.shard {
            studies::take(&mut tx, delivery).await?.map(Turn::Shard)
        } else {
            claims::claim(&mut tx, due.job, delivery, limits.max_lost_runs).await?.map(Turn::Job)
        };
        // At last, as in all transactions: rows of owners are locked after rows of jobs.
        begin_turn(&mut tx, &due.owner).await?;
        tx.commit().await?;
        Ok(turn.unwrap_or(Turn::Void))
    }
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

/// The work that is due, with its priority. `lock` ends the queries for its row.
async fn due(tx: &mut Tx, lock: &str) -> Result<Option<(Work, i64)>, JobError> {
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

/// The unfinished work of a delivery, and whether it waits; its row is locked.
async fn work_of(tx: &mut Tx, delivery: i64) -> Result<Option<(Work, bool)>, JobError> {
    let lock = if tx.dialect() == Dialect::Postgres { " FOR UPDATE" } else { "" };
    for (sql, shard) in [(JOB_OF_DELIVERY, false), (SHARD_OF_DELIVERY, true)] {
        let row: Option<(Uuid, String, bool, i64)> =
            statement(format!("{sql}{lock}")).bind(delivery).optional(&mut *tx).await?;
        if let Some((job, owner, waits, lost)) = row {
            // A running job is lost now.
            let losses = lost + i64::from(!shard && !waits);
            return Ok(Some((Work { job, owner, delivery, shard, losses }, waits)));
        }
    }
    Ok(None)
}

/// Exchanges the deliveries of two waiting works.
async fn exchange(tx: &mut Tx, own: &Work, due: &Work) -> Result<(), JobError> {
    // No delivery is negative. Two shards cannot have one delivery even for a moment.
    let free = -own.delivery;
    give(tx, own, own.delivery, free).await?;
    give(tx, due, due.delivery, own.delivery).await?;
    give(tx, own, free, due.delivery).await
}

async fn give(tx: &mut Tx, work: &Work, from: i64, to: i64) -> Result<(), JobError> {
    if !work.shard {
        let sql = "UPDATE jobs SET delivery = $2 WHERE id = $1";
        statement(sql).bind(work.job).bind(to).run(&mut *tx).await?;
        return Ok(());
    }
    // A point stays with its shard if the end of its run could not be written.
    for sql in [
        "UPDATE strands SET delivery = $2 WHERE delivery = $1",
        "UPDATE points SET strand = $2 WHERE strand = $1 AND status = 'running'",
    ] {
        statement(sql).bind(from).bind(to).run(&mut *tx).await?;
    }
    Ok(())
}
