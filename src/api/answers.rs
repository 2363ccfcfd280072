//! Jobs as JSON.

use jiff::Timestamp;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;
use uuid::Uuid;

use super::error::{ApiError, Problem};
use crate::contract::job::outputs::MetricsPart;
use crate::contract::job::{input::JobInput, kind::JobKindName};
use crate::contract::{JobKind, Metrics};
use crate::jobs::{JobError, JobRecord, Status};

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
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
    /// What was to be done.
    #[schema(value_type = JobKindName)]
    pub kind: String,
    /// Where the job stands.
    pub status: StatusName,
    /// Finished share.
    #[schema(minimum = 0, maximum = 1, example = 1.0)]
    pub progress: f64,
    /// When it was accepted (RFC 3339, UTC).
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// Begin of the run; of the last one, if a run was lost or interrupted.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub started_at: Option<Timestamp>,
    /// When it ended, in whatever way.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub finished_at: Option<Timestamp>,
    /// When the job and its result are removed; set once it has ended.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub expires_at: Option<Timestamp>,
    /// When it was asked to stop.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub cancel_requested_at: Option<Timestamp>,
    /// Why the job failed: its `type` ends in `did-not-converge`, `numerical-blowup`, `time-limit`,
    /// `memory-limit`, `worker-lost` or `internal`.
    #[schema(required = true)]
    pub error: Option<Problem>,
    /// Words to find the job by.
    pub labels: Vec<String>,
    /// 1 (first) to 4 (last).
    #[schema(minimum = 1, maximum = 4)]
    pub priority: u8,
    /// Whether the result of identical finished work answered this job.
    pub reused: bool,
    /// The request as it was sent.
    #[schema(value_type = JobInput)]
    pub request: Box<RawValue>,
    /// Paths that make sense for the job now.
    pub links: Links,
    /// With `include=metrics` or `Prefer: wait`, once a simulation has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Metrics, nullable = false, required = false)]
    pub metrics: Option<Box<RawValue>>,
}

/// Paths that make sense for the job now.
#[derive(Debug, Serialize, ToSchema)]
pub struct Links {
    /// The job itself.
    #[serde(rename = "self")]
    pub this: String,
    /// Server-sent events.
    pub events: String,
    /// Cancels the job; a `POST`. While it has not ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cancel: Option<String>,
    /// Of a simulation that has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub metrics: Option<String>,
    /// Which spectra and series are kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub channels: Option<String>,
    /// Of a simulation that keeps spectra and has succeeded: of the first channel; `?channel=` names another.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub spectrum: Option<String>,
    /// Of a simulation that keeps series and has succeeded: of the first channel; `?channel=` names another.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub series: Option<String>,
    /// Of a simulation that has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub spectrum_svg: Option<String>,
    /// Velocity of the spindle over time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub velocity_svg: Option<String>,
    /// Acceleration of the spindle over time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub acceleration_svg: Option<String>,
    /// Paths of the centres of spindle and cage.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub orbit_svg: Option<String>,
    /// Loads of a ball along its way, where contacts were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub loads_svg: Option<String>,
    /// Of a study.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub table: Option<String>,
    /// Of a study over one axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub trend_svg: Option<String>,
    /// Of a study over two axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub map_svg: Option<String>,
    /// Goes on with a study that was cancelled or failed; a `POST`.
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
            links: Links::of(&record),
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
    pub fn with_metrics(self, metrics: Option<String>) -> Result<Self, ApiError> {
        Ok(Self { metrics: metrics.map(raw).transpose()?, ..self })
    }
}

fn raw(json: String) -> Result<Box<RawValue>, ApiError> {
    RawValue::from_string(json).map_err(|error| ApiError::Job(JobError::Corrupt(error.to_string())))
}

/// What in a request decides over links.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Asked {
    axes: Vec<IgnoredAny>,
    outputs: AskedOutputs,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct AskedOutputs {
    /// The usual ones where it does not say.
    spectra: Option<Vec<IgnoredAny>>,
    series: Vec<IgnoredAny>,
    /// All of them where it does not say.
    metrics: Option<Vec<MetricsPart>>,
}

impl Asked {
    fn of(request: &str) -> Self {
        serde_json::from_str(request).unwrap_or_default()
    }
}

impl Links {
    fn of(record: &JobRecord) -> Self {
        let (status, kind) = (record.status, &*record.kind);
        let this = path_of(record.id);
        let asked = Asked::of(&record.request);
        let spectra = asked.outputs.spectra.as_ref().is_none_or(|spectra| !spectra.is_empty());
        let series = !asked.outputs.series.is_empty();
        let contacts = asked.outputs.metrics.as_ref().is_none_or(|parts| parts.contains(&MetricsPart::Contacts));
        let axes = if kind == JobKind::Study.name() { asked.axes.len() } else { 0 };
        let below = |name: &str, when: bool| when.then(|| format!("{this}/{name}"));
        let succeeded = |of: JobKind| status == Status::Succeeded && kind == of.name();
        let (simulated, compared) = (succeeded(JobKind::Simulation), succeeded(JobKind::Accuracy));
        let drawn = simulated && (spectra || series);
        Self {
            events: format!("{this}/events"),
            cancel: below("cancel", !status.is_final()),
            metrics: below("metrics", simulated),
            spectrum: below("spectrum", simulated && spectra),
            channels: below("channels", simulated),
            series: below("series", simulated && series),
            spectrum_svg: below("plots/spectrum.svg", simulated && spectra),
            velocity_svg: below("plots/velocity.svg", drawn),
            acceleration_svg: below("plots/acceleration.svg", drawn),
            orbit_svg: below("plots/orbit.svg", drawn),
            loads_svg: below("plots/loads.svg", drawn && contacts),
            table: below("table", kind == JobKind::Study.name()),
            trend_svg: below("plots/trend.svg", axes == 1),
            map_svg: below("plots/map.svg", axes == 2),
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
