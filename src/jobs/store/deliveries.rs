//! Statements on River's table of deliveries, `river_job`. River itself inserts, hands out and completes its rows.

use std::time::Duration;

use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::pool::{Pool, Tx};
use super::statement::statement;
use crate::jobs::error::JobError;

/// Makes deliveries due whose due time lies further ahead than the queue ever sets one; returns their number.
///
/// After a clock was set back, here or on the machine that inserted them, they would wait for as long as that.
pub async fn hasten(tx: &mut Tx) -> Result<u64, JobError> {
    let (now, later) = match tx.dialect() {
        Dialect::Sqlite => {
            ("strftime('%Y-%m-%d %H:%M:%f', 'now')", "strftime('%Y-%m-%d %H:%M:%f', 'now', '+5 seconds')")
        }
        Dialect::Postgres => ("now()", "now() + INTERVAL '5 seconds'"),
    };
    let sql = format!(
        "UPDATE river_job SET state = 'available', scheduled_at = {now} \
         WHERE state IN ('available', 'scheduled') AND scheduled_at > {later}"
    );
    statement(sql).run(tx).await
}

/// Redelivers what was handed to `process` more than `lost_after` ago and is not `in_hand`; returns the number.
///
/// If a connection breaks while the server answers, the delivery stays handed out, and no process works on it.
pub async fn recall(tx: &mut Tx, process: Uuid, in_hand: &[i64], lost_after: Duration) -> Result<u64, JobError> {
    if tx.dialect() == Dialect::Sqlite {
        return Ok(0);
    }
    let ids = in_hand.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
    let not_in_hand = if ids.is_empty() { String::new() } else { format!(" AND id NOT IN ({ids})") };
    let sql = format!(
        "UPDATE river_job SET state = 'available' WHERE state = 'running' \
         AND attempted_by[array_upper(attempted_by, 1)] = $1 AND attempted_at < now() - $2 * INTERVAL '1 second'{not_in_hand}"
    );
    statement(sql).bind(process.to_string()).bind(lost_after.as_secs_f64()).run(tx).await
}

impl Store {
    /// Redelivers what a dead process was working on, where no other process can be working on it; returns the number.
    pub async fn recover_deliveries(&self) -> Result<u64, JobError> {
        if matches!(self.writer, Pool::Postgres(_)) {
            return Ok(0);
        }
        statement("UPDATE river_job SET state = 'available' WHERE state = 'running'").run(&self.writer).await
    }
}
