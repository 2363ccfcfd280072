//! The result of a comparison.

use crate::simulation::error::codes::{ErrorBasis, Gap};
use crate::simulation::error::comparison::Deviation;
use crate::simulation::error::lyapunov::DivergenceEstimate;
use crate::simulation::error::stationarity::halves_deviation;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::recording::record::Recording;

/// Fewest values that are compared.
pub(crate) const MIN_VALUES: usize = 200;
/// Tightest relative tolerance that double precision resolves [-].
pub(crate) const TIGHTEST: f64 = 1e-13;

/// Result of a comparison.
#[derive(Debug, Default)]
pub(crate) struct Verification {
    /// `None`: unknown.
    pub deviation: Option<Deviation>,
    pub basis: ErrorBasis,
    pub divergence: Option<DivergenceEstimate>,
    /// Rms of the difference of the signals over that of the run [-].
    pub noise: f64,
    /// The whole recorded time was repeated.
    pub is_whole: bool,
    /// Effect that the window does not cover.
    pub gap: Option<Gap>,
    /// Deviation of the whole run in finer steps.
    pub course: Option<Deviation>,
    /// The repetition failed.
    pub failure: Option<SimulationError>,
    /// Window that could be repeated [s], and the reason why no longer one could.
    pub part: Option<(f64, SimulationError)>,
}

impl Verification {
    pub fn is_chaotic(&self) -> bool {
        self.divergence.is_some_and(|divergence| divergence.is_chaotic())
    }
}

/// Separates a stop from other failures. A failed verification does not discard a run; only a stop is passed on.
pub(crate) fn or_failure<T>(result: Result<T, SimulationError>) -> Result<Result<T, SimulationError>, SimulationError> {
    match result {
        Err(stopped @ SimulationError::Stopped { .. }) => Err(stopped),
        result => Ok(result),
    }
}

/// Errors of single numbers from a window, at least those between the halves of the recorded time. Slow motions take longer than a window.
pub(crate) fn along_the_run(deviation: Deviation, recording: &Recording) -> Deviation {
    let halves = halves_deviation(&recording.parts);
    let quantities = deviation.quantities.map(|errors| halves.map_or(errors, |halves| errors.larger(&halves)));
    Deviation { quantities, ..deviation }
}
