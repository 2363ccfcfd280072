//! Accuracy of a result: its errors, the basis of their estimate, and warnings to the user.

use crate::simulation::error::codes::{ErrorBasis, Quantity, QuantityError, Uncertainty, Warning};
use crate::simulation::error::comparison::Deviation;
use crate::simulation::error::errors::{LevelErrors, QuantityErrors};
use crate::simulation::error::lyapunov::{DivergenceEstimate, MotionKind};
use crate::simulation::error::thresholds::{WARNED_ERROR_DB, WARNED_ERROR_SHARE};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::settings::Outputs;

/// Accuracy of the result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AccuracyReport {
    /// Estimated errors of the levels [dB].
    pub level_errors: LevelErrors,
    /// Channels whose level error is the change of the level along the recorded time, because that is larger than what `basis` gives.
    pub changing: Vec<Channel>,
    /// Estimated errors of single numbers; `None`: unknown.
    pub quantity_errors: Option<QuantityErrors>,
    /// Numbers whose slowest motion the verification does not cover. They state no error.
    pub unverified: Vec<Quantity>,
    /// Changes under refinement of the levels that are not resolved [dB]. These levels have no error.
    pub unresolved: LevelErrors,
    /// Standard deviation of a level between windows as long as the recorded time [dB].
    pub level_scatter: LevelErrors,
    pub basis: ErrorBasis,
    /// Kind of motion; `None`: the run is too short to show it.
    pub motion: Option<MotionKind>,
    /// The motion is chaotic at constant speed: levels are means over a sample of it.
    pub is_chaotic: bool,
    /// Rate at which neighbouring trajectories diverge [1/s]; negative: they converge.
    pub divergence_rate: f64,
    pub warnings: Vec<Warning>,
}

impl AccuracyReport {
    pub(crate) fn new(deviation: Deviation, basis: ErrorBasis, divergence: Option<DivergenceEstimate>) -> Self {
        Self {
            level_errors: deviation.levels,
            quantity_errors: deviation.quantities,
            basis,
            motion: divergence.and_then(|divergence| divergence.motion()),
            is_chaotic: divergence.is_some_and(|divergence| divergence.is_chaotic()),
            divergence_rate: divergence.map_or(0.0, |divergence| divergence.rate),
            ..Self::default()
        }
    }

    /// Largest level error [dB]; `None` if no level error is known.
    pub fn level_error_db(&self) -> Option<f64> {
        self.level_errors.worst()
    }

    pub(crate) fn deviation(&self) -> Deviation {
        Deviation { levels: self.level_errors, quantities: self.quantity_errors }
    }

    /// This report without errors of levels that refinement changes by more than `WARNED_ERROR_DB`. Such a repetition is another answer and
    /// bounds nothing. Samples of a sensitive motion are no refinement: they scatter as its windows do.
    pub(crate) fn with_unresolved(mut self, is_selected: bool) -> Self {
        let is_sensitive =
            |warning: &Warning| matches!(warning, Warning::Uncertain { cause: Uncertainty::Sensitive, .. });
        let is_refined = matches!(self.basis, ErrorBasis::Repetition { .. });
        if !is_refined || self.is_chaotic || self.warnings.iter().any(is_sensitive) {
            return self;
        }
        let changes = self.level_errors;
        let is_large = |channel| changes.of(channel).filter(|change| *change > WARNED_ERROR_DB);
        self.unresolved = LevelErrors::each(is_large);
        let Some(change_db) = self.unresolved.worst() else { return self };
        self.level_errors = LevelErrors::each(|channel| changes.of(channel).filter(|_| is_large(channel).is_none()));
        self.drop_uncertain_level();
        self.warnings.insert(0, Warning::NotResolved { change_db, is_selected });
        self
    }

    /// This report with another warning.
    pub(crate) fn with(mut self, warning: Warning) -> Self {
        self.warnings.push(warning);
        self
    }

    /// Drops the level from the warning of large errors.
    pub(crate) fn drop_uncertain_level(&mut self) {
        for warning in &mut self.warnings {
            if let Warning::Uncertain { errors, .. } = warning {
                errors.retain(|error| error.quantity != Quantity::Level);
            }
        }
        self.warnings.retain(|warning| !matches!(warning, Warning::Uncertain { errors, .. } if errors.is_empty()));
    }

    /// The largest stated error over its allowed value [-]; `None` if one is unknown. The level of silence has no error.
    pub(crate) fn excess(&self, outputs: &Outputs, tolerance_db: f64) -> Option<f64> {
        let silent = self.quantity_errors.is_some() && self.level_errors.worst().is_none();
        let levels = if silent { LevelErrors::each(|_| Some(0.0)) } else { self.level_errors };
        Deviation { levels, ..self.deviation() }.excess(outputs, tolerance_db)
    }

    /// The requested numbers whose errors require a warning.
    pub(crate) fn large_errors(&self, outputs: &Outputs) -> Vec<QuantityError> {
        // The level of a short chaotic sample shows by itself that single numbers are uncertain.
        let quantities = self.quantity_errors.filter(|_| !self.is_chaotic || !outputs.include_levels());
        let level = self.level_error_db().filter(|_| outputs.include_levels());
        let share = |error: fn(&QuantityErrors) -> f64, shown: bool| quantities.as_ref().filter(|_| shown).map(error);
        let all = [
            (Quantity::Level, level, WARNED_ERROR_DB),
            (Quantity::MaxLoad, share(|errors| errors.max_load, true), WARNED_ERROR_SHARE),
            (Quantity::CageSpeed, share(|errors| errors.cage_speed, true), WARNED_ERROR_SHARE),
            (Quantity::PocketLoad, share(|errors| errors.max_pocket_load, outputs.cage), WARNED_ERROR_SHARE),
            (Quantity::Slip, share(|errors| errors.max_slip, outputs.contacts), WARNED_ERROR_SHARE),
            (Quantity::CageOrbit, share(|errors| errors.orbit_radius, outputs.cage), WARNED_ERROR_SHARE),
        ];
        let is_large = |(quantity, error, limit): (Quantity, Option<f64>, f64)| {
            let error = error.filter(|error| *error > limit && !self.unverified.contains(&quantity))?;
            let channel = self.level_errors.worst_channel().filter(|_| quantity == Quantity::Level);
            Some(QuantityError { quantity, error, channel })
        };
        all.into_iter().filter_map(is_large).collect()
    }
}
