//! Errors of a run.

use std::fmt;

use crate::numerics::ode::IntegrationError;
use crate::numerics::ode::stability::UnstableStep;
use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::state::Layout;
use crate::simulation::model::terms::UnsupportedChoice;

/// Largest projected number of evaluations of a run: more than a day of one core.
pub(crate) const MAX_EVALUATIONS: f64 = 3e10;

/// Displacement of a spindle that no ball can hold any more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// "radially", "axially", or at the pitch circle by a tilt.
    pub direction: &'static str,
    /// From the centre of the outer ring [m].
    pub displacement: f64,
    /// Largest displacement at which a ball may hold the spindle [m].
    pub limit: f64,
}

impl fmt::Display for Departure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { direction, displacement, limit } = self;
        write!(
            f,
            "it is displaced {direction} by {:.3} mm, and beyond {:.3} mm no ball can hold it",
            1e3 * displacement,
            1e3 * limit
        )
    }
}

/// Cause of a failed run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The scene cannot be given what the request chose.
    #[error(transparent)]
    UnsupportedChoice(#[from] UnsupportedChoice),
    /// A reduced model cannot represent the scene, or not this motion of it.
    #[error("rung {rung} is not applicable: {reason}")]
    NotApplicable { rung: &'static str, reason: Inapplicable },
    #[error("no static equilibrium was found to start from: {0}")]
    NoEquilibrium(String),
    #[error("{source} ({entry})")]
    Integration {
        source: IntegrationError,
        /// Name of the state component, such as "radial velocity of ball 3".
        entry: String,
    },
    /// At the present rate the run would take more evaluations than `MAX_EVALUATIONS`.
    #[error(
        "aborted at t = {time:.3e} s of {end} s: steps of {step:.1e} s on average would take some {evaluations:.0e} evaluations of \
         the equations, more than {MAX_EVALUATIONS:.0e}"
    )]
    TooManyEvaluations { time: f64, end: f64, step: f64, evaluations: f64 },
    /// No ball can hold the spindle any more.
    #[error(
        "the spindle left the bearing at t = {time:.6} s: {departure}. More balls, a cage or a smaller clearance may hold it"
    )]
    SpindleLeft { time: f64, departure: Departure },
    /// `Control::stop` returned true.
    #[error("stopped at t = {time:.9} s")]
    Stopped { time: f64 },
    /// The run took more evaluations of the equations than allowed.
    #[error("stopped at t = {time:.9} s after {evaluations} evaluations of the equations")]
    EvaluationLimit { time: f64, evaluations: u64 },
}

impl SimulationError {
    /// This error with a known cause.
    pub(crate) fn because(self, cause: Option<UnstableStep>) -> Self {
        match (self, cause) {
            (Self::Integration { source, entry }, Some(cause)) => {
                Self::Integration { source, entry: format!("{entry}; {cause}") }
            }
            (error, _) => error,
        }
    }

    /// Error of an integrator, with the name of the state component.
    pub(crate) fn integration(source: IntegrationError, layout: &Layout) -> Self {
        let component = match source {
            IntegrationError::Stopped { time } => return Self::Stopped { time },
            IntegrationError::StepTooSmall { component, .. }
            | IntegrationError::NotFinite { component, .. }
            | IntegrationError::Impact { component, .. } => component,
        };
        Self::Integration { entry: layout.name(component), source }
    }
}
