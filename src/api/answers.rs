//! Jobs as JSON.

use jiff::Timestamp;
use serde::Serialize;
use serde_json::value::RawValue;
use utoipa::ToSchema;
use uuid::Uuid;

use super::error::{ApiError, Problem};
use crate::contract::job::JobInput;
use crate::contract::{JobKind, Metrics};
use crate::jobs::{JobError, JobRecord, Status};

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, serde::Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StatusName {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl From<Status> for StatusName {
    fn from(status: Status) -> Self {
        match status {
            Status::Queued => Self::Queued,
            Status::Running => Self::Running,
            Status::Succeeded => Self::Succeeded,
            Status::Failed => Self::Failed,
            Status::Cancelled => Self::Cancelled,
        }
    }
}

impl From<StatusName> for Status {
    fn from(status: StatusName) -> Self {
        match status {
            StatusName::Queued => Self::Queued,
            StatusName::Running => Self::Running,
            StatusName::Succeeded => Self::Succeeded,
            StatusName::Failed => Self::Failed,
            StatusName::Cancelled => Self::Cancelled,
        }
    }
}

/// A job.
#[derive(Debug, Serialize, ToSchema)]
pub struct JobAnswer {
    /// UUIDv7: later jobs have greater ids.
    pub id: Uuid,
    #[schema(example = "simulation")]
    pub kind: String,
    pub status: StatusName,
    /// Finished share.
    #[schema(minimum = 0, maximum = 1, example = 1.0)]
    pub progress: f64,
    /// RFC 3339.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// Begin of the run; of the last one, if a run was lost or interrupted.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub started_at: Option<Timestamp>,
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub finished_at: Option<Timestamp>,
    /// When the job and its result are removed; set once it has ended.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub expires_at: Option<Timestamp>,
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub cancel_requested_at: Option<Timestamp>,
    /// Why the job failed: its `type` ends in `did-not-converge`, `numerical-blowup`, `time-limit`,
    /// `memory-limit`, `worker-lost` or `internal`.
    #[schema(required = true)]
    pub error: Option<Problem>,
    pub labels: Vec<String>,
    /// 1 (first) to 4 (last).
    #[schema(minimum = 1, maximum = 4)]
    pub priority: u8,
    /// Whether the result of identical finished work answered this job.
    pub reused: bool,
    /// The request as it was sent.
    #[schema(value_type = JobInput)]
    pub request: Box<RawValue>,
    pub links: Links,
    /// With `include=metrics` or `Prefer: wait`, once a simulation has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Metrics, nullable = false, required = false)]
    pub metrics: Option<Box<RawValue>>,
}

/// Paths that make sense for the job now.
#[derive(Debug, Serialize, ToSchema)]
pub struct Links {
    #[serde(rename = "self")]
    pub this: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cancel: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub metrics: Option<String>,
    /// Takes a channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub spectrum: Option<String>,
    /// Takes a channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub series: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub spectrum_svg: Option<String>,
    /// Of a study.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub table: Option<String>,
    /// Of a study that can go on.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub resume: Option<String>,
    /// Of an optimum job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub optimum: Option<String>,
    /// Of an optimum job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub optimum_svg: Option<String>,
    /// Of an accuracy job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub accuracy: Option<String>,
    /// Of an accuracy job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub work_precision_svg: Option<String>,
}

/// A page of jobs.
#[derive(Debug, Serialize, ToSchema)]
pub struct JobList {
    /// Newest first.
    pub jobs: Vec<JobAnswer>,
    /// Path of the next page; null on the last one.
    #[schema(required = true, example = "/v1/jobs?limit=50&cursor=01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f")]
    pub next: Option<String>,
}

/// A job's path.
pub fn path_of(id: Uuid) -> String {
    format!("/v1/jobs/{id}")
}

impl JobAnswer {
    pub fn of(record: JobRecord) -> Result<Self, ApiError> {
        Ok(Self {
            links: Links::of(record.id, record.status, &record.kind),
            id: record.id,
            kind: record.kind,
            status: record.status.into(),
            progress: record.progress,
            created_at: record.created_at,
            started_at: record.started_at,
            finished_at: record.finished_at,
            expires_at: record.expires_at,
            cancel_requested_at: record.cancel_requested_at,
            error: record.failure.as_ref().map(Problem::of_run),
            labels: record.labels,
            priority: record.priority,
            reused: record.reused,
            request: raw(record.request)?,
            metrics: None,
        })
    }

    /// With its metrics, JSON as it is stored.
    pub fn with_metrics(self, metrics: String) -> Result<Self, ApiError> {
        Ok(Self { metrics: Some(raw(metrics)?), ..self })
    }
}

fn raw(json: String) -> Result<Box<RawValue>, ApiError> {
    RawValue::from_string(json).map_err(|error| ApiError::Job(JobError::Corrupt(error.to_string())))
}

impl Links {
    fn of(id: Uuid, status: Status, kind: &str) -> Self {
        let this = path_of(id);
        let below = |name: &str, when: bool| when.then(|| format!("{this}/{name}"));
        let succeeded = |of: JobKind| status == Status::Succeeded && kind == of.name();
        let (simulated, compared) = (succeeded(JobKind::Simulation), succeeded(JobKind::Accuracy));
        Self {
            cancel: below("cancel", !status.is_final()),
            metrics: below("metrics", simulated),
            spectrum: below("spectrum", simulated),
            series: below("series", simulated),
            spectrum_svg: below("plots/spectrum.svg", simulated),
            table: below("table", kind == JobKind::Study.name()),
            resume: below(
                "resume",
                kind == JobKind::Study.name() && matches!(status, Status::Cancelled | Status::Failed),
            ),
            optimum: below("optimum", succeeded(JobKind::Optimum)),
            optimum_svg: below("plots/optimum.svg", succeeded(JobKind::Optimum)),
            accuracy: below("accuracy", compared),
            work_precision_svg: below("plots/work-precision.svg", compared),
            this,
        }
    }
}
