//! Jobs read and listed, cancelled and deleted.

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::pool::Tx;
use super::results;
use super::statement::{Statement, Value, statement};
use super::stored_time::{stored, time};
use crate::jobs::error::JobError;
use crate::jobs::job::{Failure, JobRecord, Status};

/// Selection of the jobs in a list.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    /// Any of these; all if empty.
    pub statuses: Vec<Status>,
    /// Any of these; all if empty.
    pub kinds: Vec<String>,
    /// All of these.
    pub labels: Vec<String>,
    /// None of these.
    pub without_labels: Vec<String>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
    pub limit: u32,
}

/// Size of the requests in a page at which the page ends early [B]: it bounds the memory of a list.
const PAGE_BYTES: usize = 1 << 20;

/// Columns of `Row`.
pub(super) const COLUMNS: &str = "id, kind, status, request, labels, priority, created_at, started_at, finished_at, expires_at, \
                       cancel_requested_at, progress, reused, error_cause, error_detail";

/// A row of the table `jobs`.
#[derive(FromRow)]
pub(super) struct Row {
    id: Uuid,
    kind: String,
    status: String,
    request: String,
    labels: String,
    priority: i64,
    created_at: i64,
    started_at: Option<i64>,
    finished_at: Option<i64>,
    expires_at: Option<i64>,
    cancel_requested_at: Option<i64>,
    progress: f64,
    reused: bool,
    error_cause: Option<String>,
    error_detail: Option<String>,
}

#[derive(FromRow)]
struct RowWithMetrics {
    #[sqlx(flatten)]
    row: Row,
    metrics: Option<String>,
}

impl Row {
    pub(super) fn is_succeeded(&self) -> bool {
        self.status == Status::Succeeded.name()
    }

    pub(super) fn record(self) -> Result<JobRecord, JobError> {
        let corrupt = |what: &str| JobError::Corrupt(format!("{what} of job {}", self.id));
        Ok(JobRecord {
            status: Status::parse(&self.status).ok_or_else(|| corrupt("status"))?,
            labels: serde_json::from_str(&self.labels).map_err(|_| corrupt("labels"))?,
            priority: u8::try_from(self.priority).map_err(|_| corrupt("priority"))?,
            created_at: time(self.created_at)?,
            started_at: self.started_at.map(time).transpose()?,
            finished_at: self.finished_at.map(time).transpose()?,
            expires_at: self.expires_at.map(time).transpose()?,
            cancel_requested_at: self.cancel_requested_at.map(time).transpose()?,
            failure: self.error_cause.map(|cause| Failure { cause, detail: self.error_detail.unwrap_or_default() }),
            id: self.id,
            kind: self.kind,
            request: self.request,
            progress: self.progress,
            reused: self.reused,
        })
    }
}

impl Store {
    /// A job of this owner.
    pub async fn job(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        let sql = format!("SELECT {COLUMNS} FROM jobs WHERE id = $1 AND owner = $2");
        let row: Option<Row> = statement(sql).bind(id).bind(owner).optional(&self.readers).await?;
        row.ok_or(JobError::NotFound)?.record()
    }

    /// A job of this owner, with the metrics of a succeeded simulation, as JSON text.
    pub async fn job_with_metrics(&self, owner: &str, id: Uuid) -> Result<(JobRecord, Option<String>), JobError> {
        let sql = format!(
            "SELECT {COLUMNS}, (SELECT metrics FROM results WHERE results.id = jobs.result_id) AS metrics \
             FROM jobs WHERE id = $1 AND owner = $2"
        );
        let found: Option<RowWithMetrics> = statement(sql).bind(id).bind(owner).optional(&self.readers).await?;
        let RowWithMetrics { row, metrics } = found.ok_or(JobError::NotFound)?;
        // Jobs of other kinds have a report and no metrics.
        Ok((row.record()?, metrics.filter(|metrics| !metrics.is_empty())))
    }

    /// A page of this owner's jobs, newest first, and whether there are more.
    pub async fn jobs(&self, owner: &str, filter: &Filter) -> Result<(Vec<JobRecord>, bool), JobError> {
        let list = list(owner, filter, self.dialect());
        let (mut page, mut bytes, mut more) = (Vec::new(), 0, false);
        let takes_more = |row: Row| {
            more = page.len() == filter.limit as usize || bytes > PAGE_BYTES;
            if !more {
                bytes += row.request.len();
                page.push(row.record()?);
            }
            Ok(!more)
        };
        list.each(&self.readers, takes_more).await?;
        Ok((page, more))
    }
}

/// The query of a page, with one job more.
fn list(owner: &str, filter: &Filter, dialect: Dialect) -> Statement {
    let mut values = vec![owner.into()];
    let mut place = |value| {
        values.push(value);
        values.len()
    };
    let mut sql = format!("SELECT {COLUMNS} FROM jobs WHERE owner = $1");
    if let Some(before) = filter.before {
        sql += &format!(" AND id < ${}", place(before.into()));
    }
    let statuses = filter.statuses.iter().map(|status| status.name().into()).collect();
    let kinds = filter.kinds.iter().map(Into::into).collect();
    for (column, any) in [("status", statuses), ("kind", kinds)] {
        let any: Vec<Value> = any;
        if !any.is_empty() {
            let places: Vec<String> = any.into_iter().map(|value| format!("${}", place(value))).collect();
            sql += &format!(" AND {column} IN ({})", places.join(", "));
        }
    }
    for label in &filter.labels {
        sql += &format!(" AND {}", dialect.has_label(place(label.into())));
    }
    for label in &filter.without_labels {
        sql += &format!(" AND NOT {}", dialect.has_label(place(label.into())));
    }
    sql += &format!(" ORDER BY id DESC LIMIT ${}", place((i64::from(filter.limit) + 1).into()));
    values.into_iter().fold(statement(sql), Statement::bind)
}

/// A job's status, delivery and kind, in a transaction that may change them.
pub async fn locked_status(tx: &mut Tx, owner: &str, id: Uuid) -> Result<(Status, Option<i64>, String), JobError> {
    // An update, so that no other transaction changes the row before this one ends.
    let sql = "UPDATE jobs SET status = status WHERE id = $1 AND owner = $2 RETURNING status, delivery, kind";
    let row: Option<(String, Option<i64>, String)> = statement(sql).bind(id).bind(owner).optional(&mut *tx).await?;
    let (status, delivery, kind) = row.ok_or(JobError::NotFound)?;
    let status = Status::parse(&status).ok_or_else(|| JobError::Corrupt(format!("status of job {id}")))?;
    Ok((status, delivery, kind))
}

/// Cancels a job that has not started.
pub async fn cancel_queued(tx: &mut Tx, id: Uuid, keep_s: f64) -> Result<(), JobError> {
    let now = Timestamp::now();
    let sql = "UPDATE jobs SET status = 'cancelled', cancel_requested_at = $2, finished_at = $2, \
               expires_at = $2 + CAST(coalesce(keep_for_s, $3) * 1e6 AS BIGINT) WHERE id = $1 AND status = 'queued'";
    statement(sql).bind(id).bind(stored(now)).bind(keep_s).run(&mut *tx).await?;
    Ok(())
}

/// Records the request to cancel a running job; the time of the first request is kept.
pub async fn request_cancel(tx: &mut Tx, id: Uuid) -> Result<(), JobError> {
    let sql = "UPDATE jobs SET cancel_requested_at = coalesce(cancel_requested_at, $2) WHERE id = $1";
    statement(sql).bind(id).bind(stored(Timestamp::now())).run(&mut *tx).await?;
    Ok(())
}

/// Removes an ended job, and its result unless another job shares it.
pub async fn delete(tx: &mut Tx, id: Uuid) -> Result<(), JobError> {
    let sql = "DELETE FROM jobs WHERE id = $1 RETURNING result_id";
    let result: Option<Option<Uuid>> = statement(sql).bind(id).value(&mut *tx).await?;
    match result.flatten() {
        Some(result) => results::remove_orphan(tx, result).await,
        None => Ok(()),
    }
}
