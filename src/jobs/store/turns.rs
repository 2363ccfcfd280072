//! Turns: a delivery of the queue is a turn, and the work of the owner that is due takes it.
//!
//! Every waiting job and shard has a delivery. Work that takes the turn of another gets its delivery, and the other gets that of
//! the work: as many deliveries wait as work does.

use uuid::Uuid;

use super::claims::{self, Claim};
use super::database::Store;
use super::dialect::Dialect;
use super::due::{Work, begin_turn, due};
use super::pool::Tx;
use super::statement::statement;
use super::studies::{self, StudyShard};
use crate::jobs::error::JobError;

/// Number of losses from which work runs alone, so that it ends no other run with its process.
const LOSSES_TO_RUN_ALONE: i64 = 2;

/// Use of the turn of a delivery.
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
    /// True if no other run may begin meanwhile.
    pub alone: bool,
}

/// The unfinished job of a delivery, and whether it waits.
const JOB_OF_DELIVERY: &str = "SELECT id, owner, status = 'queued', lost FROM jobs \
     WHERE delivery = $1 AND status IN ('queued', 'running')";

/// The shard of a delivery, whether it waits, and the largest number of losses of a point that it was running.
const SHARD_OF_DELIVERY: &str = "SELECT job, owner, waiting_since IS NOT NULL, \
     (SELECT coalesce(max(lost) + 1, 0) FROM points WHERE strand = $1 AND status = 'running') \
     FROM strands WHERE delivery = $1";

/// The queries of this file, each of which reads an index only.
#[cfg(test)]
pub const QUERIES: [&str; 2] = [JOB_OF_DELIVERY, SHARD_OF_DELIVERY];

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
