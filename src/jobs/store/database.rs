//! The open database: its connections, its tables, and whether it accepts writes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::dialect::Dialect;
use super::location::Location;
use super::pool::{Lock, Pool, Tx};
use super::statement::statement;
use super::{connections, migrations};
use crate::jobs::error::JobError;
use crate::jobs::service_metrics::ServiceMetrics;

/// The database. Other files of this folder add the statements about their tables.
#[derive(Debug, Clone)]
pub struct Store {
    pub(super) writer: Pool,
    pub(super) readers: Pool,
    /// Connections of lists, apart from those of single jobs: a search among many jobs delays no status.
    pub(super) lists: Pool,
    pub metrics: Arc<ServiceMetrics>,
    disk_full: Arc<AtomicBool>,
    unwritable: Arc<AtomicBool>,
}

/// Longest time for which a request waits for the database, shorter than the ten seconds after which its answer is promised.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(8);

/// The result of a short operation of a request; an error if the database does not answer in time.
///
/// The write may take effect later nevertheless.
pub async fn in_time<T>(operation: impl Future<Output = Result<T, JobError>>) -> Result<T, JobError> {
    let answered = tokio::time::timeout(ANSWER_TIMEOUT, operation).await;
    answered.unwrap_or(Err(JobError::Database(sqlx::Error::PoolTimedOut)))
}

/// Connections that read a file. A query takes well under a millisecond, so a few are enough.
const READERS: u32 = 3;

/// Connections that read lists from a file. One leaves the other cores to all other requests.
const LIST_READERS: u32 = 1;

/// Connections to a server that read lists.
const LIST_CONNECTIONS: u32 = 2;

/// Connections to a server in addition to one for each worker: requests, submissions, sweeps, and the queue's own; lists have more.
const CONNECTIONS: u32 = 6;

impl Store {
    /// Opens the database.
    pub async fn open(location: &Location, workers: usize, max_pages: Option<u32>) -> Result<Self, JobError> {
        let (writer, readers, lists) = match location {
            Location::File(path) => {
                let file = connections::open_file(path, [READERS, LIST_READERS], max_pages).await?;
                let [readers, lists] = file.readers.map(Pool::Sqlite);
                (Pool::Sqlite(file.writer), readers, lists)
            }
            Location::Server(options) => {
                let workers = u32::try_from(workers).unwrap_or(u32::MAX);
                let connections = [CONNECTIONS.saturating_add(workers), LIST_CONNECTIONS];
                let [pool, lists] = connections::connect(options, connections).await?.map(Pool::Postgres);
                (pool.clone(), pool, lists)
            }
        };
        Ok(Self {
            writer,
            readers,
            lists,
            metrics: Arc::default(),
            disk_full: Arc::default(),
            unwritable: Arc::default(),
        })
    }

    /// Brings the tables up to date.
    ///
    /// Nothing is written if they are: a PostgreSQL user without the right to create tables can call this.
    pub async fn migrate(&self) -> Result<(), JobError> {
        if migrations::is_up_to_date(&self.writer).await? {
            return Ok(());
        }
        match self.dialect() {
            Dialect::Sqlite => migrations::migrate(&self.writer).await,
            Dialect::Postgres => {
                // Two processes that create tables at the same time would make each other fail.
                let tx = self.begin_locked(Lock::Migration).await?;
                migrations::migrate(&self.writer).await?;
                tx.commit().await
            }
        }
    }

    /// The connections that write, for the queue.
    pub fn writer(&self) -> &Pool {
        &self.writer
    }

    pub fn dialect(&self) -> Dialect {
        self.writer.dialect()
    }

    /// Begins a write transaction.
    pub async fn begin(&self) -> Result<Tx, JobError> {
        self.metrics.measure_wait(self.writer.begin()).await
    }

    /// Begins a write transaction once no other process holds `lock`.
    pub async fn begin_locked(&self, lock: Lock) -> Result<Tx, JobError> {
        self.metrics.measure_wait(self.writer.begin_locked(lock)).await
    }

    /// Returns whether the last write failed because the disk is full.
    pub fn disk_is_full(&self) -> bool {
        self.disk_full.load(Ordering::Acquire)
    }

    /// Returns whether the last sweep, which writes, failed.
    pub fn is_unwritable(&self) -> bool {
        self.unwritable.load(Ordering::Acquire)
    }

    /// Records whether a sweep succeeded.
    pub fn note_sweep(&self, succeeded: bool) {
        self.unwritable.store(!succeeded, Ordering::Release);
    }

    /// Records whether the disk accepted a write, and passes the result on.
    pub fn note<T>(&self, written: Result<T, JobError>) -> Result<T, JobError> {
        match &written {
            Ok(_) => self.disk_full.store(false, Ordering::Release),
            Err(JobError::DiskFull) => self.disk_full.store(true, Ordering::Release),
            Err(_) => {}
        }
        written
    }

    /// Closes the connections to a database that other processes continue to use.
    pub async fn disconnect(&self) {
        self.lists.close().await;
        self.readers.close().await;
        self.writer.close().await;
    }

    /// Closes the database, and moves the log of a file into the file first.
    pub async fn close(&self) {
        self.lists.close().await;
        self.readers.close().await;
        if self.dialect() == Dialect::Sqlite
            && let Err(error) = statement("PRAGMA wal_checkpoint(TRUNCATE)").run(&self.writer).await
        {
            tracing::warn!(%error, "the log could not be moved into the database file");
        }
        self.writer.close().await;
    }
}
