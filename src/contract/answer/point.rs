//! A point of a study, or of the search for an optimum: its status and its end.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::failure::RunFailure;
use super::metrics::Metrics;
use crate::contract::json::problem::{FieldError, Refusal};

/// Parts of the metrics that a table omits: lists of all points would be large.
const OMITTED: [&str; 3] = ["lines", "envelope_lines", "left_out"];

/// Status of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PointStatus {
    Queued,
    Running,
    Succeeded,
    Failed,
    /// The study was cancelled before the point ended; resuming the study runs it.
    Cancelled,
}

/// The end of a point.
#[derive(Debug, Clone, PartialEq)]
pub enum PointEnd {
    Succeeded(Value),
    Failed(PointError),
}

impl PointEnd {
    /// From the metrics of a simulation.
    pub fn of(metrics: &Metrics) -> Self {
        Self::of_stored(serde_json::to_value(metrics).unwrap_or_default())
    }

    /// From the metrics of a simulation as they are stored.
    pub fn of_stored(mut metrics: Value) -> Self {
        if let Value::Object(fields) = &mut metrics {
            OMITTED.iter().for_each(|part| drop(fields.remove(*part)));
        }
        Self::Succeeded(metrics)
    }
}

/// Error of a point without metrics.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PointError {
    /// Code of the cause: that of a failed job, or `invalid` where the scene cannot be built.
    #[schema(example = "numerical-blowup")]
    pub cause: String,
    /// Description of the error.
    pub detail: String,
    /// The wrong fields of a scene that cannot be built.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<FieldError>,
}

/// Statistics of the samples of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SamplesAnswer {
    /// Number of samples that have succeeded. A metric that more than 5 % of all samples do not have has no statistic.
    pub succeeded: u64,
    /// Number of samples that have failed.
    pub failed: u64,
    /// Half of an interval that contains the statistic with at least 95 % probability, of a percentile the longer side: numbers in the places of those of
    /// `metrics`. It supposes independent draws; of Sobol points it is mostly too wide. A number is absent where there are too few samples.
    #[schema(value_type = BTreeMap<String, Value>)]
    pub half_intervals: Value,
}

impl From<RunFailure> for PointError {
    fn from(failure: RunFailure) -> Self {
        let (cause, detail) = match failure {
            RunFailure::Cancelled => ("cancelled", "the run was cancelled".to_owned()),
            RunFailure::Failed { cause, detail } => (cause, detail),
        };
        Self { cause: cause.to_owned(), detail, errors: Vec::new() }
    }
}

impl From<Refusal> for PointError {
    fn from(refusal: Refusal) -> Self {
        let detail = refusal.to_string();
        let errors = if let Refusal::Invalid { errors } = refusal { errors } else { Vec::new() };
        Self { cause: "invalid".to_owned(), detail, errors }
    }
}
