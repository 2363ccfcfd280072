//! Errors of requests about jobs. A failed simulation is not an error here but the end of its job.

use std::fmt::Display;
use std::io::ErrorKind;

use jiff::Timestamp;

use super::job::{ExpiredJob, Status};

/// Reason why a request about jobs failed.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    #[error("there is no such job")]
    NotFound,
    /// The job has expired, and its result is gone.
    #[error("the job has expired")]
    Expired(Box<ExpiredJob>),
    /// The job has not ended.
    #[error("the job is {}", .0.name())]
    NotReady(Status),
    /// The job ended without a result.
    #[error("the job is {}", .0.name())]
    NoResult(Status),
    /// Jobs of this kind never have such a result.
    #[error("the job is of kind {kind}")]
    OtherKind { kind: String },
    /// Only studies can be resumed.
    #[error("the job is of kind {kind}")]
    NoStudy { kind: String },
    /// The study is queued or running, or has no points left.
    #[error("the job is {}", .0.name())]
    CannotResume(Status),
    /// The job's status forbids it.
    #[error("the job is {}", .0.name())]
    Conflict(Status),
    /// No signal is kept for the channel; `kept` lists the channels that have one.
    #[error("no signal is kept for that channel")]
    UnknownChannel { kept: Vec<String> },
    /// The idempotency key was used with another body.
    #[error("the idempotency key belongs to another request")]
    KeyReused,
    /// `limit` of all owners, or of one.
    #[error("{limit} jobs are unfinished")]
    QueueFull { limit: u64, of_owner: bool },
    /// A study of `points` beside the `unfinished` ones is more than `limit`, of all owners or of one.
    #[error("{points} points and {unfinished} unfinished ones are more than {limit}")]
    PointsFull { points: usize, unfinished: u64, limit: u64, of_owner: bool },
    /// A study has more points than its owner may have unfinished: it would never be accepted.
    #[error("{points} points are more than {limit}")]
    StudyTooLarge { points: usize, limit: u64 },
    #[error("there is no such series")]
    NoSeries,
    /// The values of the series are gone.
    #[error("the series {hash} expired at {expired_at:.0}")]
    SeriesExpired { hash: String, expired_at: Timestamp },
    #[error("an unfinished job names the series")]
    SeriesInUse,
    /// The series of an owner would take more than `limit` bytes.
    #[error("{used} bytes of {limit} are used")]
    SeriesFull { used: i64, limit: i64 },
    #[error("the service is stopping")]
    Stopping,
    #[error("no space is left for the database")]
    DiskFull,
    #[error("the database accepts no writes")]
    NotWritable,
    /// Writes to the database file would be lost with this process.
    #[error("the database file was moved, removed or replaced; put it back, or restart")]
    Displaced,
    #[error("another server uses the database {0}")]
    Locked(String),
    #[error("database: {0}")]
    Database(#[source] sqlx::Error),
    #[error("migration: {0}")]
    Migration(String),
    #[error("queue: {0}")]
    Queue(#[source] riverqueue::Error),
    #[error("a stored record cannot be read: {0}")]
    Corrupt(String),
    /// A part of a stored result is not what was written.
    #[error("the stored {part} of the job are not what was written")]
    ResultCorrupt { part: String },
    #[error("cannot open the database {path}: {reason}")]
    CannotOpen { path: String, reason: String },
    #[error("{0}")]
    Io(#[from] std::io::Error),
}

impl JobError {
    /// The database cannot be opened.
    pub fn opening(place: impl Display, reason: impl Display) -> Self {
        Self::CannotOpen { path: place.to_string(), reason: reason.to_string() }
    }

    /// Returns whether the database exists without our tables, because it was created anew.
    pub fn lacks_tables(&self) -> bool {
        matches!(self, Self::Database(sqlx::Error::Database(error)) if error.code().is_some_and(|code| code == NO_TABLE))
    }

    /// Returns whether a stored answer is not what was written: its digest differs, it cannot be decoded, or the database finds its
    /// own file malformed.
    pub fn is_corruption(&self) -> bool {
        match self {
            Self::Corrupt(_) | Self::ResultCorrupt { .. } => true,
            // From the decompression.
            Self::Io(error) => {
                matches!(error.kind(), ErrorKind::InvalidData | ErrorKind::InvalidInput | ErrorKind::UnexpectedEof)
            }
            Self::Database(sqlx::Error::ColumnDecode { .. } | sqlx::Error::Decode(_)) => true,
            Self::Database(sqlx::Error::Database(error)) => {
                let code = error.code().unwrap_or_default();
                match error.try_downcast_ref::<sqlx::postgres::PgDatabaseError>() {
                    Some(_) => POSTGRES_CORRUPT.contains(&&*code),
                    None => code.parse::<i64>().is_ok_and(|code| SQLITE_CORRUPT.contains(&(code & 0xff))),
                }
            }
            _ => false,
        }
    }

    /// Returns whether the database is unreachable for now, or accepts no writes.
    pub fn is_away(&self) -> bool {
        let error = match self {
            Self::NotWritable | Self::Displaced => return true,
            Self::Database(error) => error,
            _ => return false,
        };
        match error {
            sqlx::Error::Io(_) | sqlx::Error::PoolTimedOut | sqlx::Error::PoolClosed | sqlx::Error::WorkerCrashed => {
                true
            }
            sqlx::Error::Protocol(_) | sqlx::Error::Tls(_) => true,
            sqlx::Error::Database(error) => {
                let code = error.code().unwrap_or_default();
                if error.try_downcast_ref::<sqlx::postgres::PgDatabaseError>().is_none() {
                    return code.parse::<i64>().is_ok_and(|code| SQLITE_AWAY.contains(&(code & 0xff)));
                }
                // PostgreSQL: no connection, too many connections, shutting down or starting, read-only, login refused, no such
                // database, no tables, tables that are being brought up to date.
                ["08", "53300", "57P", "25006", "28", "3D000", NO_TABLE, NO_COLUMN]
                    .iter()
                    .any(|class| code.starts_with(class))
            }
            _ => false,
        }
    }
}

/// SQLite's "database or disk is full". Its other errors of writes have other causes, such as a failing disk.
const SQLITE_FULL: i64 = 13;
/// SQLite's "database is locked" (by another connection or within this one), "attempt to write a readonly database", "disk I/O error"
/// and "unable to open database file". Extended codes hold these in the low byte.
const SQLITE_AWAY: [i64; 5] = [5, 6, 8, 10, 14];
/// SQLite's "database disk image is malformed" and "file is not a database". Extended codes hold these in the low byte.
const SQLITE_CORRUPT: [i64; 2] = [11, 26];
/// PostgreSQL's `data_corrupted` and `index_corrupted`.
const POSTGRES_CORRUPT: [&str; 2] = ["XX001", "XX002"];
/// PostgreSQL's `undefined_table`.
const NO_TABLE: &str = "42P01";
/// PostgreSQL's `undefined_column`.
const NO_COLUMN: &str = "42703";
/// PostgreSQL's `disk_full`.
const POSTGRES_DISK_FULL: &str = "53100";

impl From<sqlx::Error> for JobError {
    fn from(error: sqlx::Error) -> Self {
        if is_full_disk(&error) {
            tracing::error!(%error, "a write failed because the disk is full");
            return Self::DiskFull;
        }
        Self::Database(error)
    }
}

fn is_full_disk(error: &sqlx::Error) -> bool {
    let Some(error) = error.as_database_error() else { return false };
    let code = error.code().unwrap_or_default();
    if error.try_downcast_ref::<sqlx::postgres::PgDatabaseError>().is_some() {
        return code == POSTGRES_DISK_FULL;
    }
    code.parse() == Ok(SQLITE_FULL)
}

impl From<riverqueue::Error> for JobError {
    fn from(error: riverqueue::Error) -> Self {
        match error {
            riverqueue::Error::Database(error) => error.into(),
            other => Self::Queue(other),
        }
    }
}
