//! SQLite in a file or PostgreSQL on a server. Where the two speak differently, `Dialect` says how.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use sqlx::postgres::{PgConnectOptions, PgPool};
use sqlx::sqlite::SqlitePool;
use sqlx::{AssertSqlSafe, Postgres, Sqlite, Transaction};
use uuid::Uuid;

use super::statement::statement;
use crate::jobs::JobError;

/// Where the records are.
#[derive(Clone)]
pub enum Location {
    File(PathBuf),
    Server(Box<PgConnectOptions>),
}

impl Location {
    /// A PostgreSQL server by its URL; `None` where that is none.
    pub fn server(url: &str) -> Option<Self> {
        PgConnectOptions::from_str(url).ok().map(|options| Self::Server(Box::new(options)))
    }

    /// The product behind it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::File(_) => "SQLite",
            Self::Server(_) => "PostgreSQL",
        }
    }
}

/// Without user and password.
impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Server(options) => {
                let database = options.get_database().unwrap_or_default();
                write!(f, "postgres://{}:{}/{database}", options.get_host(), options.get_port())
            }
        }
    }
}

impl fmt::Debug for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Connections of one kind.
#[derive(Debug, Clone)]
pub enum Pool {
    Sqlite(SqlitePool),
    Postgres(PgPool),
}

/// What the two databases say differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    Sqlite,
    Postgres,
}

impl Dialect {
    /// The database's own clock, in microseconds since 1970: machines that share a database share no other.
    pub fn now(self) -> &'static str {
        match self {
            Self::Sqlite => "CAST((julianday('now') - 2440587.5) * 86400000000.0 AS INTEGER)",
            Self::Postgres => "CAST(extract(epoch FROM clock_timestamp()) * 1000000 AS BIGINT)",
        }
    }

    /// Whether the labels of a job hold what is bound at this place.
    pub fn has_label(self, place: usize) -> String {
        match self {
            Self::Sqlite => {
                format!("EXISTS (SELECT 1 FROM json_each(jobs.labels) AS label WHERE label.value = ${place})")
            }
            Self::Postgres => format!("jsonb_exists(CAST(jobs.labels AS JSONB), ${place})"),
        }
    }

    /// Whether a delivery, `river_job`, is in the hands of a process that is not among the workers any more. The process of a file
    /// has it all delivered again when it starts.
    pub fn is_orphaned(self) -> &'static str {
        match self {
            Self::Sqlite => "FALSE",
            Self::Postgres => {
                "river_job.state = 'running' AND NOT EXISTS (SELECT 1 FROM workers WHERE CAST(workers.id AS TEXT) \
                 = river_job.attempted_by[array_upper(river_job.attempted_by, 1)])"
            }
        }
    }

    /// Keeps the rows that a statement reads from being changed until its transaction ends. On SQLite nobody else writes.
    pub fn for_share(self) -> &'static str {
        match self {
            Self::Sqlite => "",
            Self::Postgres => " FOR SHARE",
        }
    }
}

impl Pool {
    pub fn dialect(&self) -> Dialect {
        match self {
            Self::Sqlite(_) => Dialect::Sqlite,
            Self::Postgres(_) => Dialect::Postgres,
        }
    }

    /// Begins a write transaction.
    pub async fn begin(&self) -> Result<Tx, JobError> {
        Ok(match self {
            Self::Sqlite(pool) => Tx::Sqlite(riverqueue::database::begin_sqlite_write(pool).await?),
            Self::Postgres(pool) => Tx::Postgres(riverqueue::database::begin_postgres(pool).await?),
        })
    }

    /// Begins one that waits until no other process does this. SQLite has one writer at a time anyway.
    pub async fn begin_alone(&self, lock: Lock) -> Result<Tx, JobError> {
        match self {
            Self::Sqlite(_) => self.begin().await,
            // Both in one way to the server and back.
            Self::Postgres(pool) => {
                let begin = format!("BEGIN; SELECT pg_advisory_xact_lock({})", lock as i64);
                Ok(Tx::Postgres(pool.begin_with(AssertSqlSafe(begin)).await?))
            }
        }
    }

    pub async fn close(&self) {
        match self {
            Self::Sqlite(pool) => pool.close().await,
            Self::Postgres(pool) => pool.close().await,
        }
    }
}

/// A write transaction.
#[derive(Debug)]
pub enum Tx {
    Sqlite(Transaction<'static, Sqlite>),
    Postgres(Transaction<'static, Postgres>),
}

/// What only one process does at a time, on servers that several share.
#[derive(Debug, Clone, Copy)]
pub enum Lock {
    /// Bringing the tables up to date.
    Migration = 0x7261_6365,
    /// Taking submissions: limits and idempotency keys are looked up before rows are added.
    Intake,
    /// Looking for what was lost.
    Sweep,
}

impl Tx {
    pub fn dialect(&self) -> Dialect {
        match self {
            Self::Sqlite(_) => Dialect::Sqlite,
            Self::Postgres(_) => Dialect::Postgres,
        }
    }

    pub async fn commit(self) -> Result<(), JobError> {
        match self {
            Self::Sqlite(tx) => tx.commit().await?,
            Self::Postgres(tx) => tx.commit().await?,
        }
        Ok(())
    }

    /// Tells all processes that a job has ended, once the transaction is committed.
    pub async fn tell_ended(&mut self, job: Uuid) -> Result<(), JobError> {
        self.tell(ENDED, job).await
    }

    /// Tells all processes that someone wants a job to end, once the transaction is committed.
    pub async fn tell_cancelled(&mut self, job: Uuid) -> Result<(), JobError> {
        self.tell(CANCELLED, job).await
    }

    async fn tell(&mut self, channel: &str, job: Uuid) -> Result<(), JobError> {
        if self.dialect() == Dialect::Postgres {
            statement("SELECT pg_notify($1, $2)").bind(channel).bind(job.to_string()).run(self).await?;
        }
        Ok(())
    }
}

/// Channels of what processes that share a database tell each other; the message is a job's id.
pub const ENDED: &str = "raceway_ended";
pub const CANCELLED: &str = "raceway_cancelled";
