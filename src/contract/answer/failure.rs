//! Failures of runs.

use raceway_core::numerics::ode::IntegrationError;
use raceway_core::simulation::model::failure::SimulationError;

/// Reason why a job has no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RunFailure {
    /// `Control::stop` returned true.
    #[error("cancelled")]
    Cancelled,
    /// `cause` is a code, `detail` its description.
    #[error("{cause}: {detail}")]
    Failed { cause: &'static str, detail: String },
}

/// Causes of failures.
pub const DID_NOT_CONVERGE: &str = "did-not-converge";
pub const NUMERICAL_BLOWUP: &str = "numerical-blowup";
pub const SPINDLE_LEFT_BEARING: &str = "spindle-left-bearing";
pub const INTERNAL: &str = "internal";

impl From<SimulationError> for RunFailure {
    fn from(error: SimulationError) -> Self {
        let cause = match &error {
            SimulationError::Stopped { .. } => return Self::Cancelled,
            SimulationError::Integration { source: IntegrationError::Stopped { .. }, .. } => return Self::Cancelled,
            SimulationError::Integration { source: IntegrationError::NotFinite { .. }, .. } => NUMERICAL_BLOWUP,
            SimulationError::SpindleLeft { .. } => SPINDLE_LEFT_BEARING,
            SimulationError::Integration {
                source: IntegrationError::StepTooSmall { .. } | IntegrationError::Impact { .. },
                ..
            }
            | SimulationError::EvaluationLimit { .. }
            | SimulationError::NoEquilibrium(_)
            | SimulationError::NotApplicable { .. }
            | SimulationError::TooManyEvaluations { .. } => DID_NOT_CONVERGE,
            // A checked job was refused before.
            SimulationError::UnsupportedChoice(_) => INTERNAL,
        };
        Self::Failed { cause, detail: error.to_string() }
    }
}
