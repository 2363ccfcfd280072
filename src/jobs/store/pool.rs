//! Connection pools and write transactions of both databases.

use sqlx::postgres::PgPool;
use sqlx::sqlite::SqlitePool;
use sqlx::{AssertSqlSafe, Postgres, Sqlite, Transaction};

use super::dialect::Dialect;
use crate::jobs::error::JobError;

/// A connection pool.
#[derive(Debug, Clone)]
pub enum Pool {
    Sqlite(SqlitePool),
    Postgres(PgPool),
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

    /// Begins a write transaction once no other process holds `lock`. SQLite has one writer at a time anyway.
    pub async fn begin_locked(&self, lock: Lock) -> Result<Tx, JobError> {
        match self {
            Self::Sqlite(_) => self.begin().await,
            // Both statements in one round trip.
            Self::Postgres(pool) => {
                let begin = format!("BEGIN; SELECT pg_advisory_xact_lock({})", lock as i64);
                Ok(Tx::Postgres(pool.begin_with(AssertSqlSafe(begin)).await?))
            }
        }
    }

    /// Begins a write transaction whose end does not wait for the disk, where the server allows that.
    pub async fn begin_unsynchronized(&self) -> Result<Tx, JobError> {
        match self {
            Self::Sqlite(_) => self.begin().await,
            Self::Postgres(pool) => {
                Ok(Tx::Postgres(pool.begin_with("BEGIN; SET LOCAL synchronous_commit TO OFF").await?))
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
}

/// Work that only one process does at a time, by the number of its advisory lock.
#[derive(Debug, Clone, Copy)]
pub enum Lock {
    /// Creating or updating the tables.
    Migration = 0x7261_6365,
    /// Finding lost runs.
    Sweep = 0x7261_6367,
    /// Adding up counts of unfinished work.
    Counts,
}
