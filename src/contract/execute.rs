//! From a job to its results.

use serde_json::Value;

use super::job::Job;
use super::metrics::Metrics;
use super::signals::{SeriesAnswer, SpectrumAnswer, SpectrumKind};
use crate::numerics::ode::IntegrationError;
use crate::simulation::run::{self, Control, RunResult, SimulationError};

/// The results of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    pub metrics: Metrics,
    /// Amplitude and envelope spectrum of each channel asked for.
    pub spectra: Vec<SpectrumAnswer>,
    pub series: Vec<SeriesAnswer>,
}

/// Why a job has no results.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RunFailure {
    /// `Control::stop` asked for it.
    #[error("cancelled")]
    Cancelled,
    /// `cause` is one word for programs, `detail` a sentence for people.
    #[error("{cause}: {detail}")]
    Failed { cause: &'static str, detail: String },
}

/// Causes of failures.
pub const DID_NOT_CONVERGE: &str = "did-not-converge";
pub const NUMERICAL_BLOWUP: &str = "numerical-blowup";
pub const INTERNAL: &str = "internal";

/// Simulates the job's scene. Every number of the outcome is finite.
pub fn execute(job: &Job, control: &Control<'_>) -> Result<Outcome, RunFailure> {
    let result = run::run(job.scene(), &job.settings, control)?;
    outcome(job, &result)
}

fn outcome(job: &Job, result: &RunResult) -> Result<Outcome, RunFailure> {
    let solver = &result.summary.solver;
    let spectra = result.spectra.iter().flat_map(|of| {
        [(SpectrumKind::Amplitude, &of.amplitude), (SpectrumKind::Envelope, &of.envelope)]
            .map(|(kind, spectrum)| SpectrumAnswer::of(of.channel, kind, spectrum, solver))
    });
    let outcome = Outcome {
        metrics: Metrics::of(result, &job.settings.outputs),
        spectra: spectra.collect(),
        series: result.series.iter().map(SeriesAnswer::of).collect(),
    };
    match not_finite(&outcome) {
        None => Ok(outcome),
        Some(what) => Err(RunFailure::Failed { cause: NUMERICAL_BLOWUP, detail: format!("{what} is not finite") }),
    }
}

/// What in the outcome is not finite.
fn not_finite(outcome: &Outcome) -> Option<String> {
    // JSON has no infinities: serde_json writes them as null, which no field of the metrics is otherwise.
    let metrics = serde_json::to_value(&outcome.metrics).unwrap_or_default();
    let spectrum = || outcome.spectra.iter().find(|spectrum| !spectrum.is_finite()).map(|s| &s.channel);
    let series = || outcome.series.iter().find(|series| !series.is_finite()).map(|s| &s.channel);
    null_in(&metrics, "")
        .map(|pointer| format!("metric {pointer}"))
        .or_else(|| spectrum().map(|channel| format!("the spectrum of {channel}")))
        .or_else(|| series().map(|channel| format!("the series of {channel}")))
}

/// Pointer to the first null.
fn null_in(value: &Value, pointer: &str) -> Option<String> {
    match value {
        Value::Null => Some(pointer.to_owned()),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(index, item)| null_in(item, &format!("{pointer}/{index}")))
        }
        Value::Object(fields) => fields.iter().find_map(|(key, field)| null_in(field, &format!("{pointer}/{key}"))),
        _ => None,
    }
}

impl From<SimulationError> for RunFailure {
    fn from(error: SimulationError) -> Self {
        let cause = match &error {
            SimulationError::Stopped { .. } => return Self::Cancelled,
            SimulationError::Integration { source: IntegrationError::Stopped { .. }, .. } => return Self::Cancelled,
            SimulationError::Integration { source: IntegrationError::NotFinite { .. }, .. } => NUMERICAL_BLOWUP,
            SimulationError::Integration { source: IntegrationError::StepTooSmall { .. }, .. }
            | SimulationError::NoEquilibrium(_)
            | SimulationError::Endless { .. } => DID_NOT_CONVERGE,
            // A checked job has had its needs decided already.
            SimulationError::Unmet(_) => INTERNAL,
        };
        Self::Failed { cause, detail: error.to_string() }
    }
}
