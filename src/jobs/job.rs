//! The life of a job: queued → running → succeeded, failed or cancelled. A run that is lost with its process, or returned by a
//! stopping one, goes back to the queue. An ended job never changes its status, except a study that is resumed.

use jiff::Timestamp;
use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::contract::{Job, Simulation};

/// Status of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl Status {
    /// Every status by name.
    pub const ALL: [(Status, &'static str); 5] = [
        (Status::Queued, "queued"),
        (Status::Running, "running"),
        (Status::Succeeded, "succeeded"),
        (Status::Failed, "failed"),
        (Status::Cancelled, "cancelled"),
    ];

    /// The name in requests, answers and the database.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The status with this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|status| status.1 == name).map(|status| status.0)
    }

    /// Returns whether the job has ended.
    pub fn is_final(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

/// Cause of a failed job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// A code, such as `numerical-blowup`.
    pub cause: String,
    /// A sentence for the user.
    pub detail: String,
}

impl Failure {
    pub fn new(cause: &str, detail: impl Into<String>) -> Self {
        Self { cause: cause.to_owned(), detail: detail.into() }
    }
}

/// Causes of failure outside the simulation; `contract` has those of the simulation.
pub const TIME_LIMIT: &str = "time-limit";
pub const WORKER_LOST: &str = "worker-lost";
/// The stored request is not what was written.
pub const RESULT_CORRUPT: &str = "result-corrupt";
pub const INTERNAL: &str = "internal";

/// A job as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub struct JobRecord {
    pub id: Uuid,
    pub kind: String,
    pub status: Status,
    /// The request's JSON text.
    pub request: String,
    pub labels: Vec<String>,
    /// 1 (first) to 4 (last).
    pub priority: u8,
    pub created_at: Timestamp,
    pub started_at: Option<Timestamp>,
    pub finished_at: Option<Timestamp>,
    pub expires_at: Option<Timestamp>,
    pub cancel_requested_at: Option<Timestamp>,
    /// Finished share, 0–1.
    pub progress: f64,
    pub reused: bool,
    pub failure: Option<Failure>,
}

/// Record of an expired job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpiredJob {
    pub id: Uuid,
    pub kind: String,
    pub status: Status,
    pub finished_at: Timestamp,
    pub expired_at: Timestamp,
}

/// A checked job that is not stored yet.
#[derive(Debug, Clone)]
pub struct NewJob {
    pub id: Uuid,
    pub owner: String,
    pub kind: &'static str,
    pub request: String,
    pub labels: Vec<String>,
    pub priority: u8,
    pub keep_for_s: Option<f64>,
    pub reuse: bool,
    /// The existing result that was compared with its digests for this job.
    pub compared: Option<Uuid>,
    pub content_hash: Vec<u8>,
    pub created_at: Timestamp,
    /// Number of points of a job that is run point by point; `None` for any other job.
    pub points: Option<usize>,
    /// Key under which the submission creates at most one job.
    pub key: Option<IdempotencyKey>,
}

/// A client's key for a submission, with a digest of the request body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IdempotencyKey {
    pub key: String,
    pub fingerprint: Vec<u8>,
}

impl IdempotencyKey {
    /// The key of a single job. Requests that differ only in the order of fields are equal.
    pub fn new(key: impl Into<String>, job: &Job) -> Self {
        let mut request = job.submission().request.clone();
        request.sort_all_objects();
        Self { key: key.into(), fingerprint: Sha256::digest(request.to_string()).to_vec() }
    }

    /// The key of a batch.
    pub fn of_batch(key: String, body: &[u8]) -> Self {
        Self { key, fingerprint: Sha256::digest(body).to_vec() }
    }

    /// The key of one job of this batch. It contains a line feed, so no client can send it for a single job.
    pub fn of_item(&self, place: &str) -> Self {
        Self { key: format!("{}\n{place}", self.key), fingerprint: self.fingerprint.clone() }
    }
}

impl NewJob {
    pub fn new(job: &Job, owner: &str, key: Option<IdempotencyKey>) -> Self {
        let submission = job.submission();
        let points = job.points().map(|study| study.points);
        Self {
            key,
            id: Uuid::now_v7(),
            owner: owner.to_owned(),
            kind: job.kind().name(),
            request: submission.request.to_string(),
            labels: submission.labels.clone(),
            priority: submission.priority,
            keep_for_s: submission.keep_for_s,
            // The points of a study are reused one by one.
            reuse: submission.reuse && points.is_none(),
            compared: None,
            points,
            content_hash: content_hash(job),
            created_at: now(),
        }
    }

    /// The record of the job when it is queued.
    pub fn record(&self) -> JobRecord {
        JobRecord {
            id: self.id,
            kind: self.kind.to_owned(),
            status: Status::Queued,
            request: self.request.clone(),
            labels: self.labels.clone(),
            priority: self.priority,
            created_at: self.created_at,
            started_at: None,
            finished_at: None,
            expires_at: None,
            cancel_requested_at: None,
            progress: 0.0,
            reused: false,
            failure: None,
        }
    }
}

/// The current time with the precision of the database, so that it reads the same before and after it is stored.
fn now() -> Timestamp {
    let now = Timestamp::now();
    Timestamp::from_microsecond(now.as_microsecond()).unwrap_or(now)
}

/// Digest of everything that determines the result, the program version included.
pub fn content_hash(job: &Job) -> Vec<u8> {
    digest_of(&job.canonical())
}

/// Digests of work with the metrics of this point: the point itself, and a simulation that also keeps the default spectra.
pub fn point_hashes(point: &Simulation) -> [Vec<u8>; 2] {
    [digest_of(&point.canonical()), digest_of(&point.canonical_with_usual_spectra())]
}

fn digest_of(canonical: &str) -> Vec<u8> {
    let mut digest = Sha256::new();
    digest.update(env!("CARGO_PKG_VERSION"));
    digest.update([0]);
    digest.update(canonical);
    digest.finalize().to_vec()
}
