//! Every SQL statement about jobs, for SQLite and for PostgreSQL. On SQLite one connection writes and a few read; every write
//! transaction takes the write lock when it begins, because one that reads first and then writes fails as soon as there is
//! another. On PostgreSQL a transaction that decides by what it has read takes the row first, by an update of it.

/// Claims, heartbeats and ends, all fenced.
pub mod claims;
/// Connections to a file or a server.
pub mod connections;
/// The two databases, and what they say differently.
pub mod database;
/// What an idempotency key has made.
pub mod keys;
/// Links that have gone silent.
#[cfg(target_os = "linux")]
mod link;
/// Our tables, brought up to date.
mod migrations;
/// Spectra as they are stored.
mod packed;
/// Jobs looked up and listed, cancelled and deleted.
pub mod records;
/// Results written and read.
pub mod results;
/// Statements that run on both databases.
pub mod statement;
/// Studies and their points.
pub mod studies;
/// Submissions.
pub mod submissions;
/// Bearer tokens.
pub mod tokens;
/// What was lost, what has expired, and whether the disk takes writes.
pub mod upkeep;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jiff::{SignedDuration, Timestamp};

use super::JobError;
use super::figures::Figures;
use super::queue::Queue;
use database::{Dialect, Lock, Pool, Tx};
use statement::statement;

pub use claims::{Claim, End};
pub use database::Location;
pub use records::Filter;
pub use results::{Signal, StoredResult};

/// Rank of strands in the queue: behind single jobs that say nothing of their own.
pub const PRIORITY_OF_STRANDS: u8 = 4;

/// The database.
#[derive(Debug, Clone)]
pub struct Store {
    writer: Pool,
    readers: Pool,
    pub figures: Arc<Figures>,
    disk_full: Arc<AtomicBool>,
    unwritable: Arc<AtomicBool>,
}

/// Readers of a file; a query takes well under a millisecond, so few serve many.
const READERS: u32 = 3;

/// Connections to a server beside one for each worker: requests, submissions, sweeps, the queue's own.
const CONNECTIONS: u32 = 8;

impl Store {
    /// Opens the database.
    pub async fn open(location: &Location, workers: usize, max_pages: Option<u32>) -> Result<Self, JobError> {
        let (writer, readers) = match location {
            Location::File(path) => {
                let (writer, readers) = connections::open_file(path, READERS, max_pages).await?;
                (Pool::Sqlite(writer), Pool::Sqlite(readers))
            }
            Location::Server(options) => {
                let workers = u32::try_from(workers).unwrap_or(u32::MAX);
                let pool = Pool::Postgres(connections::connect(options, CONNECTIONS.saturating_add(workers)).await?);
                (pool.clone(), pool)
            }
        };
        Ok(Self { writer, readers, figures: Arc::default(), disk_full: Arc::default(), unwritable: Arc::default() })
    }

    /// Brings the tables up to date. Where they are, nothing is written: a user of PostgreSQL who may not make tables can do this.
    pub async fn migrate(&self) -> Result<(), JobError> {
        if self.is_up_to_date().await? {
            return Ok(());
        }
        match self.dialect() {
            Dialect::Sqlite => self.migrate_all().await,
            Dialect::Postgres => {
                // Two processes that make tables at the same time would fail each other.
                let tx = self.begin_alone(Lock::Migration).await?;
                self.migrate_all().await?;
                tx.commit().await
            }
        }
    }

    async fn migrate_all(&self) -> Result<(), JobError> {
        Queue::migrate(&self.writer).await?;
        migrations::migrate(&self.writer).await
    }

    async fn is_up_to_date(&self) -> Result<bool, JobError> {
        Ok(migrations::is_up_to_date(&self.writer).await? && Queue::is_up_to_date(&self.writer).await?)
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
        self.figures.waiting_for(self.writer.begin()).await
    }

    /// Begins one that waits until no other process does this.
    pub async fn begin_alone(&self, lock: Lock) -> Result<Tx, JobError> {
        self.figures.waiting_for(self.writer.begin_alone(lock)).await
    }

    /// Whether the disk did not take what was written last.
    pub fn disk_is_full(&self) -> bool {
        self.disk_full.load(Ordering::Acquire)
    }

    /// Whether the last sweep, which writes, failed.
    pub fn is_unwritable(&self) -> bool {
        self.unwritable.load(Ordering::Acquire)
    }

    /// Remembers whether a sweep was made.
    pub fn note_sweep(&self, was_made: bool) {
        self.unwritable.store(!was_made, Ordering::Release);
    }

    /// Remembers whether the disk took a write.
    pub fn note<T>(&self, written: Result<T, JobError>) -> Result<T, JobError> {
        match &written {
            Ok(_) => self.disk_full.store(false, Ordering::Release),
            Err(JobError::DiskFull) => self.disk_full.store(true, Ordering::Release),
            Err(_) => {}
        }
        written
    }

    /// Whether the database answers.
    pub async fn ping(&self) -> Result<(), JobError> {
        statement("SELECT 1 FROM jobs LIMIT 1").run(&self.readers).await?;
        Ok(())
    }

    /// Closes the database, which others go on to use.
    pub async fn disconnect(&self) {
        self.readers.close().await;
        self.writer.close().await;
    }

    /// Closes the database; of a file, moves the log into it first.
    pub async fn close(&self) {
        self.readers.close().await;
        if self.dialect() == Dialect::Sqlite
            && let Err(error) = statement("PRAGMA wal_checkpoint(TRUNCATE)").run(&self.writer).await
        {
            tracing::warn!(%error, "the log could not be moved into the database file");
        }
        self.writer.close().await;
    }
}

/// A span of time as it is stored.
fn micros(span: SignedDuration) -> i64 {
    i64::try_from(span.as_micros()).unwrap_or(i64::MAX / 2)
}

/// A time as it is stored.
fn stored(time: Timestamp) -> i64 {
    time.as_microsecond()
}

/// A stored time.
fn time(microseconds: i64) -> Result<Timestamp, JobError> {
    Timestamp::from_microsecond(microseconds).map_err(|error| JobError::Corrupt(error.to_string()))
}
