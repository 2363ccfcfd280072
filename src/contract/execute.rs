//! From a job to its results.

use serde::Serialize;
use serde_json::Value;

use super::job::{Job, JobKind};
use super::metrics::Metrics;
use super::optimum::OptimumAnswer;
use super::problem::Refusal;
use super::signals::{SeriesAnswer, SpectrumAnswer, SpectrumKind};
use super::table::PointEnd;
use super::views::ViewsAnswer;
use super::work_precision::WorkPrecisionAnswer;
use crate::numerics::ode::IntegrationError;
use crate::simulation::input::control::Control;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::recording::spectra::ChannelSpectra;
use crate::simulation::result::run_result::RunResult;
use crate::simulation::solve::run;
use crate::simulation::work_precision;

/// The results of a job, by its kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    Simulation(Box<Simulated>),
    Accuracy(Box<WorkPrecisionAnswer>),
    Optimum(Box<OptimumAnswer>),
}

/// The results of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    pub metrics: Metrics,
    /// Amplitude and envelope spectrum of each channel asked for.
    pub spectra: Vec<SpectrumAnswer>,
    pub series: Vec<SeriesAnswer>,
    /// For pictures.
    pub views: ViewsAnswer,
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

/// Does what the job asks for. Every number of the outcome is finite.
pub fn execute(job: &Job, control: &Control<'_>) -> Result<Outcome, RunFailure> {
    if job.kind == JobKind::Study {
        return Err(RunFailure::Failed { cause: INTERNAL, detail: "a study is run point by point".into() });
    }
    let outcome = match (&job.plan, &job.sought) {
        (None, Some(sought)) => {
            // Progress is counted in runs; what a single one says of itself would only make it jump.
            let one = Control::until(control.stop);
            Outcome::Optimum(Box::new(sought.search(&|job| execute(job, &one), control)?))
        }
        (None, None) => Outcome::Simulation(Box::new(simulated(job, &run::run(job.scene(), &job.settings, control)?))),
        (Some(plan), _) => {
            let study = work_precision::study(job.scene(), &job.settings, plan, control)?;
            Outcome::Accuracy(Box::new(WorkPrecisionAnswer::of(job, plan, &study)))
        }
    };
    let wrong = match &outcome {
        Outcome::Simulation(simulated) => not_finite(simulated),
        Outcome::Accuracy(answer) => null_of(answer).map(|pointer| format!("accuracy {pointer}")),
        Outcome::Optimum(answer) => null_of(answer).map(|pointer| format!("optimum {pointer}")),
    };
    match wrong {
        None => Ok(outcome),
        Some(what) => Err(RunFailure::Failed { cause: NUMERICAL_BLOWUP, detail: format!("{what} is not finite") }),
    }
}

/// Does one point of a study, from `Study::point`, with what simulates jobs; `None`: told to stop.
pub fn execute_point(
    job: Result<Job, Refusal>,
    simulate: &dyn Fn(&Job) -> Result<Outcome, RunFailure>,
) -> Option<PointEnd> {
    let outcome = match job {
        Ok(job) => simulate(&job),
        Err(refusal) => return Some(PointEnd::Failed(refusal.into())),
    };
    Some(match outcome {
        Ok(Outcome::Simulation(simulated)) => PointEnd::of(&simulated.metrics),
        Ok(Outcome::Accuracy(_) | Outcome::Optimum(_)) => {
            PointEnd::Failed(RunFailure::Failed { cause: INTERNAL, detail: "a point is a simulation".into() }.into())
        }
        Err(RunFailure::Cancelled) => return None,
        Err(failure) => PointEnd::Failed(failure.into()),
    })
}

fn simulated(job: &Job, result: &RunResult) -> Simulated {
    let solver = &result.summary.solver;
    let of_channel = |of: &ChannelSpectra| {
        [(SpectrumKind::Amplitude, &of.amplitude), (SpectrumKind::Envelope, &of.envelope)]
            .map(|(kind, spectrum)| SpectrumAnswer::of(of.channel, kind, spectrum, solver))
    };
    Simulated {
        metrics: Metrics::of(result, &job.settings.outputs),
        spectra: result.spectra.iter().flat_map(of_channel).collect(),
        series: result.series.iter().map(SeriesAnswer::of).collect(),
        views: ViewsAnswer::of(&result.views),
    }
}

/// What in the outcome is not finite.
fn not_finite(outcome: &Simulated) -> Option<String> {
    let spectrum = || outcome.spectra.iter().find(|spectrum| !spectrum.is_finite()).map(|s| &s.channel);
    let series = || outcome.series.iter().find(|series| !series.is_finite()).map(|s| &s.channel);
    null_of(&outcome.metrics)
        .map(|pointer| format!("metric {pointer}"))
        .or_else(|| spectrum().map(|channel| format!("the spectrum of {channel}")))
        .or_else(|| series().map(|channel| format!("the series of {channel}")))
}

/// Pointer to the first number that is not finite: JSON has no infinities, serde_json writes them as null, which no
/// field of a result is otherwise.
fn null_of(answer: &impl Serialize) -> Option<String> {
    null_in(&serde_json::to_value(answer).unwrap_or_default(), "")
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
            | SimulationError::Exhausted { .. }
            | SimulationError::NoEquilibrium(_)
            | SimulationError::Unable { .. }
            | SimulationError::Endless { .. } => DID_NOT_CONVERGE,
            // A checked job has had its needs decided already.
            SimulationError::Unmet(_) => INTERNAL,
        };
        Self::Failed { cause, detail: error.to_string() }
    }
}
