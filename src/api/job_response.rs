//! Jobs as JSON, with links to their results.

use jiff::Timestamp;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;
use uuid::Uuid;

use super::error::{ApiError, Problem};
use super::status_name::StatusName;
use crate::contract::job::outputs::MetricsPart;
use crate::contract::job::{input::JobInput, kind::JobKindName};
use crate::contract::{JobKind, Metrics};
use crate::jobs::{JobError, JobRecord, Status};

/// A job.
#[derive(Debug, Serialize, ToSchema)]
pub struct JobAnswer {
    /// UUIDv7: later jobs have greater ids.
    pub id: Uuid,
    /// Kind of the job.
    #[schema(value_type = JobKindName)]
    pub kind: String,
    /// Status of the job.
    pub status: StatusName,
    /// Finished share.
    #[schema(minimum = 0, maximum = 1, example = 1.0)]
    pub progress: f64,
    /// Time of acceptance (RFC 3339, UTC).
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// Start of the run; of the last run if one was lost or interrupted.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub started_at: Option<Timestamp>,
    /// Time of the end.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub finished_at: Option<Timestamp>,
    /// Time at which the job and its result are removed; set when it has ended.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub expires_at: Option<Timestamp>,
    /// Time of the first request to cancel.
    #[schema(value_type = Option<String>, format = DateTime, required = true)]
    pub cancel_requested_at: Option<Timestamp>,
    /// Cause of a failed job. Its `type` ends in `did-not-converge`, `numerical-blowup`, `spindle-left-bearing`, `time-limit`,
    /// `memory-limit`, `worker-lost`, `result-corrupt` or `internal`.
    #[schema(required = true)]
    pub error: Option<Problem>,
    /// Labels of the job.
    pub labels: Vec<String>,
    /// 1 (highest) to 4 (lowest).
    #[schema(minimum = 1, maximum = 4)]
    pub priority: u8,
    /// True if an existing result of identical work answered this job.
    pub reused: bool,
    /// The request as it was sent.
    #[schema(value_type = JobInput)]
    pub request: Box<RawValue>,
    /// Paths that are valid for the job now.
    pub links: Links,
    /// Metrics of a succeeded simulation, with `include=metrics` or `Prefer: wait`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Metrics, nullable = false, required = false)]
    pub metrics: Option<Box<RawValue>>,
}

/// Paths that are valid for the job now.
#[derive(Debug, Serialize, ToSchema)]
pub struct Links {
    /// The job itself.
    #[serde(rename = "self")]
    pub this: String,
    /// Server-sent events.
    pub events: String,
    /// Cancels the job (`POST`); present until the job has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cancel: Option<String>,
    /// Metrics of a succeeded simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub metrics: Option<String>,
    /// Channels with a spectrum or a series.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub channels: Option<String>,
    /// Spectrum of the first channel of a succeeded simulation; `?channel=` selects another channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub spectrum: Option<String>,
    /// Series of the first channel of a succeeded simulation; `?channel=` selects another channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub series: Option<String>,
    /// Order spectrum and order tracks of a succeeded simulation with `outputs.orders`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub orders: Option<String>,
    /// Spectra over speed, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub waterfall: Option<String>,
    /// Plot of `orders`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub orders_svg: Option<String>,
    /// Plot of `waterfall`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub waterfall_svg: Option<String>,
    /// Spectra of a succeeded simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub spectrum_svg: Option<String>,
    /// Envelope spectra of the accelerations of a succeeded simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub envelope_svg: Option<String>,
    /// Acceleration of the spindle around its largest peak, if a raceway has a defect.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub impact_svg: Option<String>,
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
    /// Loads of a ball over its orbit, if contacts were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub loads_svg: Option<String>,
    /// Table of a study.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub table: Option<String>,
    /// Trend of a study over one axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub trend_svg: Option<String>,
    /// Map of a study over two axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub map_svg: Option<String>,
    /// Resumes a study that was cancelled or failed (`POST`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub resume: Option<String>,
    /// Distribution of the metrics of an uncertainty job, from the points that have been computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub uncertainty: Option<String>,
    /// Histograms and ranking of an uncertainty job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub uncertainty_svg: Option<String>,
    /// Result of an optimum job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub optimum: Option<String>,
    /// Runs of an optimum job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub optimum_svg: Option<String>,
    /// Result of an accuracy job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub accuracy: Option<String>,
    /// Error against run time of an accuracy job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub work_precision_svg: Option<String>,
    /// Result of a rotor job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub rotor: Option<String>,
    /// Campbell diagram of a rotor job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub campbell_svg: Option<String>,
    /// Mode shapes of a rotor job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub shapes_svg: Option<String>,
    /// Script for ROSS of a rotor job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub rotor_script: Option<String>,
    /// Result of a machine job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub machine: Option<String>,
}

/// A page of jobs.
#[derive(Debug, Serialize, ToSchema)]
pub struct JobList {
    /// Newest first.
    pub jobs: Vec<JobAnswer>,
    /// Path of the next page; null on the last page.
    #[schema(required = true, example = "/v1/jobs?limit=50&cursor=01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f")]
    pub next: Option<String>,
}

/// The path of a job.
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
            error: record.failure.as_ref().map(Problem::of_failure),
            labels: record.labels,
            priority: record.priority,
            reused: record.reused,
            request: raw(record.request)?,
            metrics: None,
        })
    }

    /// The job with its metrics, as JSON text.
    pub fn with_metrics(self, metrics: Option<String>) -> Result<Self, ApiError> {
        Ok(Self { metrics: metrics.map(raw).transpose()?, ..self })
    }
}

fn raw(json: String) -> Result<Box<RawValue>, ApiError> {
    RawValue::from_string(json).map_err(|error| ApiError::Job(JobError::Corrupt(error.to_string())))
}

/// The fields of a request that decide on links.
#[derive(Default, Deserialize)]
#[serde(default)]
struct RequestFields {
    axes: Vec<IgnoredAny>,
    outputs: OutputFields,
    scene: SceneFields,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct SceneFields {
    surfaces: SurfaceFields,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct SurfaceFields {
    inner: RacewayFields,
    outer: RacewayFields,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct RacewayFields {
    defects: Vec<DefectFields>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct DefectFields {
    depth_um: f64,
}

impl SurfaceFields {
    fn have_defects(&self) -> bool {
        self.inner.defects.iter().chain(&self.outer.defects).any(|defect| defect.depth_um > 0.0)
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct OutputFields {
    /// `None`: the default spectra.
    spectra: Option<Vec<IgnoredAny>>,
    series: Vec<IgnoredAny>,
    orders: Option<IgnoredAny>,
    /// `None`: all metrics.
    metrics: Option<Vec<MetricsPart>>,
}

impl RequestFields {
    fn of(request: &str) -> Self {
        serde_json::from_str(request).unwrap_or_default()
    }
}

impl Links {
    fn of(record: &JobRecord) -> Self {
        let (status, kind) = (record.status, &*record.kind);
        let this = path_of(record.id);
        let fields = RequestFields::of(&record.request);
        let spectra = fields.outputs.spectra.as_ref().is_none_or(|spectra| !spectra.is_empty());
        let orders = fields.outputs.orders.is_some();
        let series = orders || !fields.outputs.series.is_empty();
        let contacts = fields.outputs.metrics.as_ref().is_none_or(|parts| parts.contains(&MetricsPart::Contacts));
        let axes = if kind == JobKind::Study.name() { fields.axes.len() } else { 0 };
        let link = |name: &str, when: bool| when.then(|| format!("{this}/{name}"));
        let succeeded = |of: JobKind| status == Status::Succeeded && kind == of.name();
        let (simulated, compared) = (succeeded(JobKind::Simulation), succeeded(JobKind::Accuracy));
        let drawn = simulated && (spectra || series);
        let in_time = succeeded(JobKind::Machine);
        let recorded = simulated || in_time;
        Self {
            events: format!("{this}/events"),
            cancel: link("cancel", !status.is_final()),
            metrics: link("metrics", simulated),
            spectrum: link("spectrum", in_time || simulated && spectra),
            channels: link("channels", recorded),
            series: link("series", recorded && series),
            orders: link("orders", recorded && orders),
            waterfall: link("waterfall", recorded && orders),
            orders_svg: link("plots/orders.svg", recorded && orders),
            waterfall_svg: link("plots/waterfall.svg", recorded && orders),
            spectrum_svg: link("plots/spectrum.svg", in_time || simulated && spectra),
            envelope_svg: link("plots/envelope.svg", in_time || simulated && spectra),
            impact_svg: link("plots/impact.svg", drawn && fields.scene.surfaces.have_defects()),
            velocity_svg: link("plots/velocity.svg", drawn),
            acceleration_svg: link("plots/acceleration.svg", drawn),
            orbit_svg: link("plots/orbit.svg", drawn),
            loads_svg: link("plots/loads.svg", drawn && contacts),
            table: link("table", JobKind::has_points(kind)),
            trend_svg: link("plots/trend.svg", axes == 1),
            map_svg: link("plots/map.svg", axes == 2),
            resume: link("resume", JobKind::has_points(kind) && matches!(status, Status::Cancelled | Status::Failed)),
            uncertainty: link("uncertainty", kind == JobKind::Uncertainty.name()),
            uncertainty_svg: link("plots/uncertainty.svg", kind == JobKind::Uncertainty.name()),
            optimum: link("optimum", succeeded(JobKind::Optimum)),
            optimum_svg: link("plots/optimum.svg", succeeded(JobKind::Optimum)),
            accuracy: link("accuracy", compared),
            rotor: link("rotor", succeeded(JobKind::Rotor)),
            machine: link("machine", in_time),
            campbell_svg: link("plots/campbell.svg", succeeded(JobKind::Rotor)),
            shapes_svg: link("plots/shapes.svg", succeeded(JobKind::Rotor)),
            rotor_script: link("rotor.py", succeeded(JobKind::Rotor)),
            work_precision_svg: link("plots/work-precision.svg", compared),
            this,
        }
    }
}
