//! Idempotency keys and the jobs they created.

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::pool::Tx;
use super::statement::statement;
use super::stored_time::{stored, time};
use crate::jobs::error::JobError;
use crate::jobs::job::{IdempotencyKey, JobRecord, NewJob, Status};

/// The job that a key created, with the fields of the first answer.
#[derive(Debug, FromRow)]
pub struct FirstUse {
    fingerprint: Vec<u8>,
    pub job: Uuid,
    created_at: i64,
    reused: bool,
    expires_at: Option<i64>,
}

impl FirstUse {
    /// The first answer, for the same body sent again.
    pub fn first_answer(&self, again: &NewJob, key: &IdempotencyKey) -> Result<JobRecord, JobError> {
        if self.fingerprint != key.fingerprint {
            return Err(JobError::KeyReused);
        }
        let created_at = time(self.created_at)?;
        let first = JobRecord { id: self.job, created_at, ..again.record() };
        if !self.reused {
            return Ok(first);
        }
        Ok(JobRecord {
            status: Status::Succeeded,
            started_at: Some(created_at),
            finished_at: Some(created_at),
            expires_at: self.expires_at.map(time).transpose()?,
            progress: 1.0,
            reused: true,
            ..first
        })
    }
}

pub(super) const FIRST_USE: &str =
    "SELECT fingerprint, job, created_at, reused, expires_at FROM idempotency_keys WHERE owner = $1 AND key = $2";

/// The first use of a key; `None`: the key is new.
pub async fn first_use(tx: &mut Tx, owner: &str, key: &IdempotencyKey) -> Result<Option<FirstUse>, JobError> {
    statement(FIRST_USE).bind(owner).bind(&key.key).optional(&mut *tx).await
}

/// Records the job that a key creates; returns false if another process has just used the key.
pub async fn record(
    tx: &mut Tx,
    job: &NewJob,
    key: &IdempotencyKey,
    expires: Option<Timestamp>,
) -> Result<bool, JobError> {
    let sql = "INSERT INTO idempotency_keys (owner, key, fingerprint, job, created_at, reused, expires_at) \
               VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING";
    let recorded = statement(sql)
        .bind(&job.owner)
        .bind(&key.key)
        .bind(&key.fingerprint)
        .bind(job.id)
        .bind(stored(job.created_at))
        .bind(expires.is_some())
        .bind(expires.map(stored))
        .run(&mut *tx)
        .await?;
    Ok(recorded == 1)
}
