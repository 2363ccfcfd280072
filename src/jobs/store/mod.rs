//! Every SQL statement about jobs. One connection writes, a few read; every write transaction takes the
//! write lock when it begins, because one that reads first and then writes fails as soon as there is another.

/// Claims, heartbeats and ends, all fenced.
pub mod claims;
/// What an idempotency key has made.
pub mod keys;
/// Jobs looked up and listed, cancelled and deleted.
pub mod records;
/// Results written and read.
pub mod results;
/// Studies and their points.
pub mod studies;
/// Submissions.
pub mod submissions;
/// What was lost, what has expired, and whether the disk takes writes.
pub mod upkeep;

use std::path::Path;
use std::time::Duration;

use jiff::Timestamp;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{AssertSqlSafe, Connection, SqlSafeStr, SqliteConnection};

use super::JobError;
use super::queue::{Queue, Tx};

pub use claims::{Claim, End};
pub use records::Filter;
pub use results::{Signal, StoredResult};

/// Rank of strands in the queue: behind single jobs that say nothing of their own.
pub const PRIORITY_OF_STRANDS: u8 = 4;

/// The database.
#[derive(Debug, Clone)]
pub struct Store {
    writer: SqlitePool,
    readers: SqlitePool,
}

/// Readers; a query takes well under a millisecond, so few serve many.
const READERS: u32 = 3;

impl Store {
    /// Opens the database and brings its tables up to date.
    pub async fn open(path: &Path, max_pages: Option<u32>) -> Result<Self, JobError> {
        let mut options = SqliteConnectOptions::new()
            .filename(path)
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            // A 202 promises that the job survives a power cut.
            .synchronous(SqliteSynchronous::Full)
            .foreign_keys(true)
            .busy_timeout(Duration::from_secs(10));
        if let Some(pages) = max_pages {
            options = options.pragma("max_page_count", pages.to_string());
        }
        let writer = pool(1).connect_with(options.clone()).await?;
        Queue::migrate(&writer).await?;
        migrate(&writer).await?;
        let readers = pool(READERS).connect_lazy_with(options.create_if_missing(false).read_only(true));
        Ok(Self { writer, readers })
    }

    /// The connection that writes, for the queue.
    pub fn writer(&self) -> &SqlitePool {
        &self.writer
    }

    /// Begins a write transaction.
    pub async fn begin(&self) -> Result<Tx, JobError> {
        Ok(riverqueue::database::begin_sqlite_write(&self.writer).await?)
    }

    /// Whether the database answers.
    pub async fn ping(&self) -> Result<(), JobError> {
        sqlx::query("SELECT 1 FROM jobs LIMIT 1").fetch_optional(&self.readers).await?;
        Ok(())
    }

    /// Moves the log into the database file and closes it.
    pub async fn close(&self) {
        self.readers.close().await;
        if let Err(error) = sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(&self.writer).await {
            tracing::warn!(%error, "the log could not be moved into the database file");
        }
        self.writer.close().await;
    }
}

fn pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(Duration::from_secs(30))
        .before_acquire(|connection, _| Box::pin(std::future::ready(Ok(is_outside_transactions(connection)))))
}

/// Whether the connection may be used again. On a full disk SQLite ends a transaction by itself; sqlx then
/// fails to end it, counts it as open for ever, and refuses every later one.
fn is_outside_transactions(connection: &SqliteConnection) -> bool {
    !connection.is_in_transaction()
}

/// Our migrations, in order; never edited once released.
const MIGRATIONS: [(i64, &str, &str); 5] = [
    (1, "jobs", include_str!("../../../migrations/sqlite/0001_jobs.sql")),
    (2, "reports", include_str!("../../../migrations/sqlite/0002_reports.sql")),
    (3, "studies", include_str!("../../../migrations/sqlite/0003_studies.sql")),
    (4, "idempotency keys", include_str!("../../../migrations/sqlite/0004_idempotency_keys.sql")),
    (5, "views", include_str!("../../../migrations/sqlite/0005_views.sql")),
];

async fn migrate(writer: &SqlitePool) -> Result<(), JobError> {
    let migrations = MIGRATIONS.map(|(version, name, sql)| {
        Migration::new(version, name.into(), MigrationType::Simple, AssertSqlSafe(sql).into_sql_str(), false)
    });
    Migrator::with_migrations(migrations.to_vec())
        .run(writer)
        .await
        .map_err(|error| JobError::Migration(error.to_string()))
}

/// A time as it is stored.
fn stored(time: Timestamp) -> i64 {
    time.as_microsecond()
}

/// A stored time.
fn time(microseconds: i64) -> Result<Timestamp, JobError> {
    Timestamp::from_microsecond(microseconds).map_err(|error| JobError::Corrupt(error.to_string()))
}
