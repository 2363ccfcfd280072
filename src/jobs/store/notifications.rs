//! Notifications between processes that share a PostgreSQL server. On SQLite there is one process, and nothing is sent.

use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::pool::Tx;
use super::statement::statement;
use crate::jobs::error::JobError;

/// Channel of jobs that have ended; the payload is the job's id.
pub const ENDED: &str = "raceway_ended";
/// Channel of jobs whose cancellation was requested; the payload is the job's id.
pub const CANCELLED: &str = "raceway_cancelled";
/// Channel of new deliveries.
pub const ENQUEUED: &str = "raceway_enqueued";

/// Notifies all processes, once the transaction is committed, that a job has ended.
pub async fn notify_ended(tx: &mut Tx, job: Uuid) -> Result<(), JobError> {
    notify(tx, ENDED, job).await
}

/// Notifies all processes, once the transaction is committed, that the cancellation of a job was requested.
pub async fn notify_cancelled(tx: &mut Tx, job: Uuid) -> Result<(), JobError> {
    notify(tx, CANCELLED, job).await
}

impl Store {
    /// Notifies all processes of new deliveries. It is no part of a submission: all transactions that notify wait for each other until
    /// they are on the disk, and this one does not wait for the disk.
    pub async fn notify_enqueued(&self) -> Result<(), JobError> {
        let mut tx = self.writer.begin_unsynchronized().await?;
        statement("SELECT pg_notify($1, '')").bind(ENQUEUED).run(&mut tx).await?;
        tx.commit().await
    }
}

async fn notify(tx: &mut Tx, channel: &str, job: Uuid) -> Result<(), JobError> {
    if tx.dialect() == Dialect::Postgres {
        statement("SELECT pg_notify($1, $2)").bind(channel).bind(job.to_string()).run(tx).await?;
    }
    Ok(())
}
