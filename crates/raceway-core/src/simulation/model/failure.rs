//! Why a run may fail.

use crate::numerics::ode::IntegrationError;
use crate::simulation::model::state::Layout;
use crate::simulation::model::terms::Unmet;

/// Evaluations of a run that count as endless: more than a day of one core.
pub(crate) const MOST_EVALUATIONS: f64 = 3e10;

/// Why a run failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The scene cannot be given what the request chose.
    #[error(transparent)]
    Unmet(#[from] Unmet),
    /// A reduced rung cannot represent the scene, or not this motion of it.
    #[error("the rung {rung} does not serve: {reason}")]
    Unable { rung: &'static str, reason: String },
    #[error("no static equilibrium was found to start from: {0}")]
    NoEquilibrium(String),
    #[error("{source} ({entry})")]
    Integration {
        source: IntegrationError,
        /// The state component in words, such as "radial velocity of ball 3".
        entry: String,
    },
    /// At the pace so far the run would never end.
    #[error(
        "given up at t = {time:.3e} s of {end} s: steps of {step:.1e} s in the mean would take some {evaluations:.0e} evaluations of \
         the equations, more than {MOST_EVALUATIONS:.0e}"
    )]
    Endless { time: f64, end: f64, step: f64, evaluations: f64 },
    /// `Control::stop` asked for it.
    #[error("stopped at t = {time:.9} s")]
    Stopped { time: f64 },
    /// It took more evaluations of the equations than it may.
    #[error("stopped at t = {time:.9} s after {evaluations} evaluations of the equations")]
    Exhausted { time: f64, evaluations: u64 },
}

impl SimulationError {
    /// The same with a cause that is known.
    pub(crate) fn because(self, cause: Option<String>) -> Self {
        match (self, cause) {
            (Self::Integration { source, entry }, Some(cause)) => {
                Self::Integration { source, entry: format!("{entry}; {cause}") }
            }
            (error, _) => error,
        }
    }

    pub(crate) fn integration(source: IntegrationError, layout: &Layout) -> Self {
        let component = match source {
            IntegrationError::Stopped { time } => return Self::Stopped { time },
            IntegrationError::StepTooSmall { component, .. } | IntegrationError::NotFinite { component, .. } => {
                component
            }
        };
        Self::Integration { entry: layout.name(component), source }
    }
}
