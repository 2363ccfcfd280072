//! The life of a job: queued → running → succeeded, failed or cancelled. A run that is lost with its
//! process, or handed back by a stopping one, goes back to the queue; nothing leaves an end.

use jiff::Timestamp;
use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::contract::{Job, Simulation};

/// Where a job stands.
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

    /// The status of that name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|status| status.1 == name).map(|status| status.0)
    }

    /// Whether nothing more will happen.
    pub fn is_final(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

/// Why a job failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// One word for programs, such as `numerical-blowup`.
    pub cause: String,
    /// A sentence for people.
    pub detail: String,
}

impl Failure {
    pub fn new(cause: &str, detail: impl Into<String>) -> Self {
        Self { cause: cause.to_owned(), detail: detail.into() }
    }
}

/// Causes that the service itself finds; the simulation's are the contract's.
pub const TIME_LIMIT: &str = "time-limit";
pub const WORKER_LOST: &str = "worker-lost";
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

/// A checked job on its way into the queue.
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
    pub content_hash: Vec<u8>,
    pub created_at: Timestamp,
    /// Points of a study; `None` of any other job.
    pub points: Option<usize>,
    /// What makes the submission one that is made once.
    pub key: Option<IdempotencyKey>,
}

/// A client's name for a submission, with a digest of the body that came with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IdempotencyKey {
    pub key: String,
    pub fingerprint: Vec<u8>,
}

impl IdempotencyKey {
    /// Of a key and the request that came with it; fields in any order are the same request.
    pub fn new(key: impl Into<String>, job: &Job) -> Self {
        let mut request = job.submission().request.clone();
        request.sort_all_objects();
        Self { key: key.into(), fingerprint: Sha256::digest(request.to_string()).to_vec() }
    }

    /// Of a batch, by the key and the body that came with it.
    pub fn of_batch(key: String, body: &[u8]) -> Self {
        Self { key, fingerprint: Sha256::digest(body).to_vec() }
    }

    /// Of the job at a place of this batch. No client can send such a key for a single job.
    pub fn of_item(&self, place: &str) -> Self {
        Self { key: format!("{}\n{place}", self.key), fingerprint: self.fingerprint.clone() }
    }
}

impl NewJob {
    pub fn new(job: &Job, owner: &str, key: Option<IdempotencyKey>) -> Self {
        let submission = job.submission();
        let points = match job {
            Job::Study(study) => Some(study.points),
            _ => None,
        };
        Self {
            key,
            id: Uuid::now_v7(),
            owner: owner.to_owned(),
            kind: job.kind().name(),
            request: submission.request.to_string(),
            labels: submission.labels.clone(),
            priority: submission.priority,
            keep_for_s: submission.keep_for_s,
            // Points of a study are answered one by one.
            reuse: submission.reuse && points.is_none(),
            points,
            content_hash: content_hash(job),
            created_at: now(),
        }
    }

    /// The job as it looks before anything has happened to it.
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

/// This moment as precisely as it is stored: an answer shows the same time before and after.
fn now() -> Timestamp {
    let now = Timestamp::now();
    Timestamp::from_microsecond(now.as_microsecond()).unwrap_or(now)
}

/// Digest of all that determines the result; the version belongs to it, because results move with it.
pub fn content_hash(job: &Job) -> Vec<u8> {
    digest_of(&job.canonical())
}

/// Digests of the work whose metrics are those of a point: of the point, and of the simulation that keeps the usual spectra besides.
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
