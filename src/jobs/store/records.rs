//! Jobs read, listed and cancelled.

use std::collections::BTreeSet;

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::digest::{Place, Sealed};
use super::part_names::{METRICS, REQUEST};
use super::pool::Tx;
use super::sealed_request::SealedRequest;
use super::statement::{Statement, Value, statement};
use super::stored_time::{stored, time};
use crate::contract::JobKind;
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
pub(super) const COLUMNS: &str = "id, kind, status, request, request_digest, content_hash, labels, priority, created_at, started_at, finished_at, expires_at, \
                       cancel_requested_at, progress, reused, error_cause, error_detail";

/// A row of the table `jobs`.
#[derive(FromRow)]
pub(super) struct Row {
    id: Uuid,
    kind: String,
    status: String,
    #[sqlx(flatten)]
    request: SealedRequest,
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
    result_id: Option<Uuid>,
    metrics: Option<String>,
    digest: Option<Vec<u8>>,
}

impl Row {
    pub(super) fn is_succeeded(&self) -> bool {
        self.status == Status::Succeeded.name()
    }

    /// The record, if the row is that of this job and its owner.
    pub(super) fn record(self, job: Uuid, owner: &str) -> Result<JobRecord, JobError> {
        self.request.check(job, owner)?;
        self.unchecked_record()
    }

    /// The record of a row that was compared when its job was claimed.
    pub(super) fn unchecked_record(self) -> Result<JobRecord, JobError> {
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
            request: self.request.unchecked(),
            progress: self.progress,
            reused: self.reused,
        })
    }
}

impl Store {
    /// A job of this owner.
    pub async fn job(&self, owner: &str, id: Uuid) -> Result<JobRecord, JobError> {
        let sql = format!("SELECT {COLUMNS} FROM jobs WHERE id = $1 AND owner = $2");
        let read = async {
            let row: Option<Row> = statement(sql).bind(id).bind(owner).optional(&self.readers).await?;
            row.ok_or(JobError::NotFound)?.record(id, owner)
        };
        self.noted(id, REQUEST, read.await).await
    }

    /// A job of this owner, with the metrics of a succeeded simulation, as JSON text.
    pub async fn job_with_metrics(&self, owner: &str, id: Uuid) -> Result<(JobRecord, Option<String>), JobError> {
        let sql = format!(
            "SELECT {COLUMNS}, result_id, results.metrics AS metrics, results.digest AS digest \
             FROM jobs LEFT JOIN results ON results.id = jobs.result_id WHERE jobs.id = $1 AND owner = $2",
            COLUMNS = COLUMNS.replacen("id", "jobs.id", 1)
        );
        let read = async {
            let found: Option<RowWithMetrics> = statement(sql).bind(id).bind(owner).optional(&self.readers).await?;
            let RowWithMetrics { row, result_id, metrics, digest } = found.ok_or(JobError::NotFound)?;
            let metrics = match (result_id, metrics) {
                (Some(result), Some(metrics)) => {
                    Some(Sealed::stored((metrics, digest)).opened(&Place::of_result(result, METRICS))?)
                }
                (Some(_), None) => return Err(JobError::Corrupt("its row is missing".to_owned())),
                (None, _) => None,
            };
            // Jobs of other kinds have a report, or metrics of another form.
            let record = row.record(id, owner)?;
            let metrics = metrics.filter(|_| record.kind == JobKind::Simulation.name());
            Ok((record, metrics))
        };
        self.noted(id, METRICS, read.await).await
    }

    /// A page of this owner's jobs, newest first, and the job after which the next page starts.
    pub async fn jobs(&self, owner: &str, filter: &Filter) -> Result<(Vec<JobRecord>, Option<Uuid>), JobError> {
        let list = List::of(owner, filter, self.dialect());
        let floor: Option<Uuid> = match list.floor() {
            Some(floor) => floor.value(&self.lists).await?,
            None => None,
        };
        let (mut page, mut bytes, mut more) = (Vec::new(), 0, false);
        let mut corrupt = Vec::new();
        let takes_more = |row: Row| {
            more = page.len() == filter.limit as usize || bytes > PAGE_BYTES;
            if !more {
                bytes += row.request.bytes();
                let id = row.id;
                match row.record(id, owner) {
                    Err(error) if error.is_corruption() => corrupt.push((id, error)),
                    record => page.push(record?),
                }
            }
            Ok(!more)
        };
        list.page(floor).each(&self.lists, takes_more).await?;
        // They are left out: the other jobs can be read.
        for (job, error) in corrupt {
            drop(self.noted::<()>(job, REQUEST, Err(error)).await);
        }
        let next = if more { page.last().map(|record| record.id) } else { floor };
        Ok((page, next))
    }
}

/// Largest number of jobs that a page looks at: filters that no index serves end the page there, whatever the owner has. A page that finds
/// nothing then takes no longer than the largest page of jobs: a look takes 0.3 µs, that page 6 ms (`.ci/checks/stored_data.py label`, SQLite).
const MAX_LOOKS: i64 = 10_000;

/// A list of jobs: the rows of an index that stand together, newest first, and conditions on each of them.
struct List {
    /// Conditions by which the index finds the rows. The rows of several are merged.
    sources: Vec<String>,
    /// The table of the index.
    table: &'static str,
    /// The table, with the jobs.
    with_jobs: &'static str,
    /// Column of the job in the index.
    job: &'static str,
    /// Conditions beyond the index.
    conditions: String,
    values: Vec<Value>,
    /// Number of the first values, which the sources contain. PostgreSQL refuses values that a statement does not contain.
    source_values: usize,
    limit: u32,
}

impl List {
    fn of(owner: &str, filter: &Filter, dialect: Dialect) -> Self {
        let mut values = vec![owner.into()];
        let mut place = |value: Value| {
            values.push(value);
            format!("${}", values.len())
        };
        let first_label = filter.labels.first().map(|label| place(label.into()));
        let before = filter.before.map(|before| place(before.into()));
        let source_values = 1 + usize::from(first_label.is_some()) + usize::from(before.is_some());
        let other_labels: Vec<String> = filter.labels.iter().skip(1).map(|label| place(label.into())).collect();
        // Each once: the rows of two equal sources would be listed twice.
        let statuses: Vec<&str> =
            BTreeSet::from_iter(filter.statuses.iter().map(|status| status.name())).into_iter().collect();
        let status_in = format!("jobs.status IN ('{}')", statuses.join("', '"));
        let mut conditions = Vec::new();
        // The rarest of the indexed properties cannot be known without a count. A label selects fewer jobs than a status.
        let (table, with_jobs, job) = match first_label.is_none() {
            true => ("jobs", "jobs", "jobs.id"),
            false => ("job_labels", dialect.jobs_of_labels(), "job_labels.job"),
        };
        let sources = match (first_label, statuses.is_empty()) {
            (Some(first), no_status) => {
                conditions.extend(other_labels.iter().map(|label| dialect.has_label(label)));
                conditions.extend((!no_status).then_some(status_in));
                vec![format!("job_labels.owner = $1 AND job_labels.label = {first}")]
            }
            (None, true) => vec!["jobs.owner = $1".to_owned()],
            (None, false) => {
                statuses.iter().map(|status| format!("jobs.owner = $1 AND jobs.status = '{status}'")).collect()
            }
        };
        if !filter.kinds.is_empty() {
            let kinds: Vec<String> = filter.kinds.iter().map(|kind| place(kind.into())).collect();
            conditions.push(format!("jobs.kind IN ({})", kinds.join(", ")));
        }
        conditions.extend(
            filter.without_labels.iter().map(|label| format!("NOT {}", dialect.has_label(&place(label.into())))),
        );
        let before = before.map(|before| format!(" AND {job} < {before}")).unwrap_or_default();
        Self {
            sources: sources.into_iter().map(|source| source + &before).collect(),
            table,
            with_jobs,
            job,
            conditions: conditions.into_iter().map(|condition| format!(" AND {condition}")).collect(),
            values,
            source_values,
            limit: filter.limit,
        }
    }

    /// The query of the last job that a page looks at; `None` if the index alone selects the jobs.
    fn floor(&self) -> Option<Statement> {
        let found = |source: &String| format!("SELECT {} AS id FROM {} WHERE {source}", self.job, self.table);
        let sql = format!("{} ORDER BY id DESC LIMIT 1 OFFSET {}", self.merged(found), MAX_LOOKS - 1);
        let bound = |sql| self.values[..self.source_values].iter().cloned().fold(statement(sql), Statement::bind);
        (!self.conditions.is_empty()).then(|| bound(sql))
    }

    /// The query of a page, with one job more.
    fn page(&self, floor: Option<Uuid>) -> Statement {
        let place = self.values.len() + 1;
        let above = floor.map(|_| format!(" AND {} >= ${place}", self.job)).unwrap_or_default();
        let columns = COLUMNS.replacen("id", &format!("{} AS id", self.job), 1);
        let found = |source: &String| {
            format!("SELECT {columns} FROM {} WHERE {source}{above}{}", self.with_jobs, self.conditions)
        };
        let sql = format!("{} ORDER BY id DESC LIMIT {}", self.merged(found), i64::from(self.limit) + 1);
        self.bound(sql, floor)
    }

    /// The union of the sources, whose order the database keeps while it merges them.
    fn merged(&self, select: impl Fn(&String) -> String) -> String {
        self.sources.iter().map(select).collect::<Vec<_>>().join(" UNION ALL ")
    }

    fn bound(&self, sql: String, floor: Option<Uuid>) -> Statement {
        self.values.iter().cloned().chain(floor.map(Value::from)).fold(statement(sql), Statement::bind)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::store::location::Location;
    use crate::jobs::store::test_database::new_on_postgres;

    /// Rows of one owner, with a label of all jobs, one of every hundredth and one of one, and of another owner.
    async fn filled(location: Location) -> Store {
        let store = Store::open(&location, 1, None).await.expect("the database opens");
        store.migrate().await.expect("the tables are made");
        let (id, bytes) = match store.dialect() {
            Dialect::Sqlite => ("randomblob(16)", "x'00'"),
            Dialect::Postgres => ("gen_random_uuid()", "CAST('\\x00' AS BYTEA)"),
        };
        let labels = [("all", "1 = 1"), ("hundredth", "created_at % 100 = 7"), ("one", "created_at = 7")];
        let mut sql = vec![format!(
            "INSERT INTO jobs (id, owner, kind, status, request, labels, priority, created_at, finished_at, content_hash, error_cause) \
             WITH RECURSIVE n (i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i < 29999) \
             SELECT {id}, CASE WHEN i % 3 = 0 THEN 'b' ELSE 'a' END, 'simulation', \
             CASE WHEN i % 500 = 0 THEN 'failed' ELSE 'cancelled' END, '{{}}', '[]', 2, i, i, {bytes}, \
             CASE WHEN i % 500 = 0 THEN 'internal' END FROM n"
        )];
        sql.extend(labels.map(|(label, condition)| {
            format!("INSERT INTO job_labels SELECT owner, '{label}', id FROM jobs WHERE {condition}")
        }));
        if store.dialect() == Dialect::Postgres {
            sql.push("ANALYZE".to_owned());
        }
        for sql in sql {
            statement(sql).run(&store.writer).await.expect("the rows are right");
        }
        store
    }

    fn filters() -> [Filter; 7] {
        let of = |labels: &[&str], statuses: &[Status]| Filter {
            labels: labels.iter().map(|label| (*label).to_owned()).collect(),
            statuses: statuses.to_vec(),
            limit: 50,
            ..Filter::default()
        };
        let failed = [Status::Failed];
        [
            of(&[], &[]),
            of(&["one"], &[]),
            of(&["all"], &failed),
            of(&["all", "one"], &[]),
            of(&[], &failed),
            of(&[], &[Status::Failed, Status::Running, Status::Failed]),
            Filter { without_labels: vec!["all".to_owned()], before: Some(Uuid::max()), ..of(&[], &[]) },
        ]
    }

    async fn assert_plans(store: &Store) {
        for filter in filters() {
            let list = List::of("a", &filter, store.dialect());
            for query in [Some(list.page(None)), Some(list.page(Some(Uuid::nil()))), list.floor()].into_iter().flatten()
            {
                let plan: Vec<String> = match store.dialect() {
                    Dialect::Sqlite => {
                        let steps: Vec<(i64, i64, i64, String)> =
                            query.explained("EXPLAIN QUERY PLAN").all(&store.lists).await.expect("a plan");
                        steps.into_iter().map(|step| step.3).collect()
                    }
                    Dialect::Postgres => query.explained("EXPLAIN").values(&store.lists).await.expect("a plan"),
                };
                let plan = plan.join("\n");
                // PostgreSQL sorts a few rows by itself.
                for costly in ["SCAN jobs", "SCAN job_labels", "TEMP B-TREE", "Seq Scan", "Hash", "Merge Join"] {
                    assert!(!plan.contains(costly), "{filter:?}:\n{plan}");
                }
                let index = match (filter.labels.is_empty(), filter.statuses.is_empty()) {
                    (false, _) => "job_labels",
                    (true, false) => "jobs_by_status",
                    (true, true) => "jobs_of_owner",
                };
                assert!(plan.contains(index), "{filter:?}:\n{plan}");
            }
        }
    }

    async fn assert_pages(store: &Store) {
        let of = |labels: &[&str], statuses: &[Status]| Filter {
            labels: labels.iter().map(|label| (*label).to_owned()).collect(),
            statuses: statuses.to_vec(),
            limit: 50,
            ..Filter::default()
        };
        let cases = [
            (of(&[], &[Status::Failed, Status::Failed]), 40),
            (of(&["one"], &[]), 1),
            (of(&["all"], &[Status::Failed]), 40),
        ];
        for (mut filter, count) in cases {
            let (mut found, mut pages) = (Vec::new(), 0);
            loop {
                let (page, next) = store.jobs("a", &filter).await.expect("a page");
                found.extend(page.into_iter().map(|job| job.id));
                pages += 1;
                filter.before = next;
                if next.is_none() {
                    break;
                }
            }
            assert_eq!(found.len(), count, "{filter:?}");
            assert!(found.is_sorted_by(|one, next| one > next));
            // 20 000 jobs of the owner have the label, and a page looks at 10 000.
            assert!(pages <= 3, "{filter:?}: {pages} pages");
        }
    }

    fn checked(location: Location) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        runtime.block_on(async {
            let store = filled(location).await;
            assert_plans(&store).await;
            assert_pages(&store).await;
            store.disconnect().await;
        });
    }

    #[test]
    fn lists_read_an_index_in_order() {
        let place = tempfile::tempdir().expect("a directory");
        checked(Location::File(place.path().join("jobs.db")));
    }

    #[test]
    fn lists_read_an_index_in_order_on_postgres() {
        if let Some(database) = new_on_postgres("") {
            checked(database);
        }
    }
}
