//! Jobs looked up and listed, cancelled and deleted.

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::database::{Dialect, Tx};
use super::statement::{Statement, Value, statement};
use super::{Store, results, stored, time};
use crate::jobs::{Failure, JobError, JobRecord, Status};

/// Which jobs a list shows.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    /// One of these; any, where there are none.
    pub statuses: Vec<Status>,
    pub kinds: Vec<String>,
    /// All of these, and none of those.
    pub labels: Vec<String>,
    pub without_labels: Vec<String>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
    pub limit: u32,
}

/// A page ends early when its requests are larger than this, so that no list takes the memory of the service.
const PAGE_BYTES: usize = 1 << 20;

/// What `Row` is read from.
pub(super) const COLUMNS: &str = "id, kind, status, request, labels, priority, created_at, started_at, finished_at, expires_at, \
                       cancel_requested_at, progress, reused, error_cause, error_detail";

/// A job as the tables have it.
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
        // Results of other kinds are reports.
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

/// What lists a page and one job more.
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
pub async fn standing(tx: &mut Tx, owner: &str, id: Uuid) -> Result<(Status, Option<i64>, String), JobError> {
    // An update, so that nobody else changes the row before this transaction ends.
    let sql = "UPDATE jobs SET status = status WHERE id = $1 AND owner = $2 RETURNING status, delivery, kind";
    let row: Option<(String, Option<i64>, String)> = statement(sql).bind(id).bind(owner).optional(&mut *tx).await?;
    let (status, delivery, kind) = row.ok_or(JobError::NotFound)?;
    let status = Status::parse(&status).ok_or_else(|| JobError::Corrupt(format!("status of job {id}")))?;
    Ok((status, delivery, kind))
}

/// Ends a job that has not begun.
pub async fn cancel_queued(tx: &mut Tx, id: Uuid, keep_s: f64) -> Result<(), JobError> {
    let now = Timestamp::now();
    let sql = "UPDATE jobs SET status = 'cancelled', cancel_requested_at = $2, finished_at = $2, \
               expires_at = $2 + CAST(coalesce(keep_for_s, $3) * 1e6 AS BIGINT) WHERE id = $1 AND status = 'queued'";
    statement(sql).bind(id).bind(stored(now)).bind(keep_s).run(&mut *tx).await?;
    Ok(())
}

/// Notes that a running job shall end; the first request counts.
pub async fn request_cancel(tx: &mut Tx, id: Uuid) -> Result<(), JobError> {
    let sql = "UPDATE jobs SET cancel_requested_at = coalesce(cancel_requested_at, $2) WHERE id = $1";
    statement(sql).bind(id).bind(stored(Timestamp::now())).run(&mut *tx).await?;
    Ok(())
}

/// Removes an ended job and what only it points to.
pub async fn delete(tx: &mut Tx, id: Uuid) -> Result<(), JobError> {
    let sql = "DELETE FROM jobs WHERE id = $1 RETURNING result_id";
    let result: Option<Option<Uuid>> = statement(sql).bind(id).value(&mut *tx).await?;
    match result.flatten() {
        Some(result) => results::remove_orphan(tx, result).await,
        None => Ok(()),
    }
}
