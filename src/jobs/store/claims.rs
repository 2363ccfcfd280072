//! Claims, heartbeats and ends of runs. The queue does not fence its attempts; the claim counter does: only the process that
//! took the job last may write, and every other one learns that its claim is lost.

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::database::Store;
use super::dialect::Dialect;
use super::due;
use super::notifications::ENDED;
use super::pool::Tx;
use super::records::{self, Row};
use super::results::{self, StoredResult};
use super::sealed_request::{SEALED_REQUEST, SealedRequest};
use super::statement::statement;
use super::stored_time::{expiry, stored};
use crate::contract::JobKind;
use crate::jobs::error::JobError;
use crate::jobs::job::{Failure, JobRecord, NewJob, Status};

/// A job that this process runs.
#[derive(Debug, Clone)]
pub struct Claim {
    pub job: Uuid,
    pub owner: String,
    pub number: i64,
    /// `None`: the stored request is not what was written.
    pub request: Option<String>,
    pub keep_for_s: Option<f64>,
    /// Number of earlier runs that ended with their process.
    pub lost: u32,
    pub cancel_requested: bool,
}

impl Claim {
    /// The first claim of a job that starts as it is accepted.
    pub fn at_acceptance(job: &NewJob) -> Self {
        Self {
            job: job.id,
            owner: job.owner.clone(),
            number: 1,
            request: Some(job.request.clone()),
            keep_for_s: job.keep_for_s,
            lost: 0,
            cancel_requested: false,
        }
    }
}

/// How a run ended.
#[derive(Debug)]
pub enum End {
    Succeeded(StoredResult),
    Failed(Failure),
    Cancelled,
}

impl End {
    pub fn status(&self) -> Status {
        match self {
            Self::Succeeded(_) => Status::Succeeded,
            Self::Failed(_) => Status::Failed,
            Self::Cancelled => Status::Cancelled,
        }
    }

    /// The metrics of a succeeded simulation, as JSON text.
    pub fn into_metrics(self) -> Option<String> {
        match self {
            Self::Succeeded(StoredResult::Run { kind: JobKind::Simulation, metrics, .. }) => Some(metrics.content),
            _ => None,
        }
    }
}

/// The answer to a heartbeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heartbeat {
    Alive,
    CancelRequested,
    ClaimLost,
}

impl Heartbeat {
    /// The answer for a row whose cancellation was requested or not; `None`: the claim has no row.
    pub fn of(cancel_requested: Option<bool>) -> Self {
        match cancel_requested {
            None => Self::ClaimLost,
            Some(true) => Self::CancelRequested,
            Some(false) => Self::Alive,
        }
    }
}

#[derive(FromRow)]
struct ClaimedRow {
    owner: String,
    claim: i64,
    keep_for_s: Option<f64>,
    lost: i64,
    cancel_requested: bool,
    #[sqlx(flatten)]
    request: SealedRequest,
}

/// Claims the job; `None`: it has ended, or another delivery has replaced this one.
///
/// After `max_lost_runs` losses no run starts. A process that ends while it writes the failure is not counted as another loss.
pub async fn claim(tx: &mut Tx, job: Uuid, delivery: i64, max_lost_runs: u32) -> Result<Option<Claim>, JobError> {
    let sql = format!(
        "UPDATE jobs SET status = 'running', claim = claim + 1, \
         lost = lost + CASE WHEN status = 'running' AND lost < $4 THEN 1 ELSE 0 END, \
         started_at = $3, heartbeat_at = {}, progress = 0 \
         WHERE id = $1 AND delivery = $2 AND status IN ('queued', 'running') \
         RETURNING owner, claim, keep_for_s, lost, cancel_requested_at IS NOT NULL AS cancel_requested, {SEALED_REQUEST}",
        tx.dialect().now()
    );
    let claim = statement(sql).bind(job).bind(delivery).bind(stored(Timestamp::now()));
    let row: Option<ClaimedRow> = claim.bind(i64::from(max_lost_runs)).optional(&mut *tx).await?;
    Ok(row.map(|row| Claim {
        job,
        request: row.request.opened(job, &row.owner).ok(),
        owner: row.owner,
        number: row.claim,
        keep_for_s: row.keep_for_s,
        lost: u32::try_from(row.lost).unwrap_or(u32::MAX),
        cancel_requested: row.cancel_requested,
    }))
}

impl Store {
    /// Records that the run is alive, with its progress and the time that it used since the last record [s].
    pub async fn heartbeat(&self, claim: &Claim, progress: f64, used_s: f64) -> Result<Heartbeat, JobError> {
        let now = self.dialect().now();
        let sql = format!(
            "UPDATE jobs SET heartbeat_at = {now}, progress = $3 \
             WHERE id = $1 AND claim = $2 AND status = 'running' RETURNING cancel_requested_at IS NOT NULL"
        );
        let mut tx = self.begin().await?;
        let cancel_requested: Option<bool> =
            statement(sql).bind(claim.job).bind(claim.number).bind(progress).value(&mut tx).await?;
        due::charge(&claim.owner, used_s).run(&mut tx).await?;
        tx.commit().await?;
        Ok(Heartbeat::of(cancel_requested))
    }

    /// Returns an interrupted job to the queue. It does not count as lost.
    pub async fn hand_back(&self, claim: &Claim) -> Result<(), JobError> {
        let sql = "UPDATE jobs SET status = 'queued', started_at = NULL, heartbeat_at = NULL, progress = 0 \
                   WHERE id = $1 AND claim = $2 AND status = 'running'";
        statement(sql).bind(claim.job).bind(claim.number).run(&self.writer).await?;
        Ok(())
    }

    /// Writes the end of the run and returns the job's record; `None`: the claim is lost, and nothing is written. `used_s` is the
    /// processor time [s] that no heartbeat has recorded.
    pub async fn finish(
        &self,
        claim: &Claim,
        end: &End,
        progress: f64,
        used_s: f64,
        keep_s: f64,
    ) -> Result<Option<JobRecord>, JobError> {
        let (result, failure) = match end {
            End::Succeeded(result) => (Some((result.id(), result)), None),
            End::Failed(failure) => (None, Some(failure)),
            End::Cancelled => (None, None),
        };
        let insertion =
            |provided| result.map(|(id, result)| results::insertion(id, result, provided)).unwrap_or_default();
        let now = Timestamp::now();
        // A requested cancellation is kept even if the run ended a little earlier.
        let sql = format!(
            "UPDATE jobs SET status = CASE WHEN cancel_requested_at IS NULL THEN $3 ELSE 'cancelled' END, \
             result_id = CASE WHEN cancel_requested_at IS NULL THEN $4 END, \
             error_cause = CASE WHEN cancel_requested_at IS NULL THEN $5 END, \
             error_detail = CASE WHEN cancel_requested_at IS NULL THEN $6 END, \
             progress = CASE WHEN cancel_requested_at IS NULL AND $3 = 'succeeded' THEN 1.0 ELSE $9 END, \
             finished_at = $7, expires_at = $8 \
             WHERE id = $1 AND claim = $2 AND status = 'running' RETURNING {}",
            records::COLUMNS
        );
        let update = statement(sql)
            .bind(claim.job)
            .bind(claim.number)
            .bind(end.status().name())
            .bind(result.map(|(id, _)| id))
            .bind(failure.map(|failure| &failure.cause))
            .bind(failure.map(|failure| &failure.detail))
            .bind(stored(now))
            .bind(stored(expiry(now, claim.keep_for_s.unwrap_or(keep_s))))
            .bind(progress);
        let row: Option<Row> = match self.dialect() {
            // One round trip to the server, its flush included.
            Dialect::Postgres => {
                let notify = format!("SELECT {}, pg_notify('{ENDED}', CAST(id AS TEXT)) FROM ended", records::COLUMNS);
                let inserts = insertion(" FROM ended WHERE status = 'succeeded'");
                let inserts = inserts.into_iter().enumerate().map(|(k, insert)| (format!("insert{k}"), insert));
                let charge = ("charged".to_owned(), due::charge(&claim.owner, used_s));
                let before = [("ended".to_owned(), update), charge].into_iter().chain(inserts);
                statement(notify).with(before).optional(&self.writer).await?
            }
            Dialect::Sqlite => {
                let mut tx = self.begin().await?;
                for insert in insertion(" WHERE TRUE") {
                    insert.run(&mut tx).await?;
                }
                let row: Option<Row> = update.optional(&mut tx).await?;
                // Without a row the claim is lost, and the transaction is rolled back.
                if let Some(row) = &row {
                    if let (Some((id, _)), false) = (result, row.is_succeeded()) {
                        results::remove_orphan(&mut tx, id).await?;
                    }
                    due::charge(&claim.owner, used_s).run(&mut tx).await?;
                    tx.commit().await?;
                }
                row
            }
        };
        row.map(Row::unchecked_record).transpose()
    }
}
