//! Newton's iteration for the correction at the end of a step.

use super::Gear;
use super::coefficients::Coefficients;
use super::corrector::{Failure, norm};
use crate::numerics::ode::step_size::Try;
use crate::numerics::ode::system::OdeSystem;

/// Corrector iterations a step.
const MAX_ITERATIONS: u32 = 4;
/// Error that the corrector may leave, as a share of that of a step.
const CORRECTOR_ERROR: f64 = 0.05;
impl<S: OdeSystem + ?Sized> Gear<'_, S> {
    /// Solves for the correction at the end of a step, from the predictor on.
    #[inline(always)]
    pub(super) fn correct(&mut self, tried: &Try, c: &Coefficients) -> Result<(), Failure> {
        let (corrector, end) = (&mut self.corrector, tried.end);
        corrector.correction.fill(0.0);
        self.trial.copy_from_slice(&self.predicted);
        let mut last = 0.0;
        for iteration in 0..MAX_ITERATIONS {
            self.system.derivative(end, &self.trial, &mut corrector.rate);
            self.statistics.rhs_evaluations += 1;
            if iteration == 0 {
                if !corrector.rate.iter().all(|x| x.is_finite()) {
                    return Err(Failure::NotFinite);
                }
                corrector.prepare(
                    self.system,
                    (end, &self.predicted),
                    &self.tolerances,
                    (tried.step, c.leading),
                    &mut self.statistics,
                )?;
            } else {
                corrector.excess += 1;
            }
            let known = corrector.rate.iter().zip(&self.predicted_rate).zip(&corrector.correction);
            for (increment, ((rate, predicted), correction)) in corrector.increment.iter_mut().zip(known) {
                *increment = rate - predicted - c.leading * correction;
            }
            corrector.factors.solve(&mut corrector.increment);
            // Between the limits of a slow and of a stiff component, for factors of another coefficient.
            let mend = 2.0 / (1.0 + c.leading / corrector.factored_for.unwrap_or(c.leading));
            for (correction, increment) in corrector.correction.iter_mut().zip(&mut corrector.increment) {
                *increment *= mend;
                *correction += *increment;
            }
            for ((trial, predicted), correction) in
                self.trial.iter_mut().zip(&self.predicted).zip(&corrector.correction)
            {
                *trial = predicted + correction;
            }
            let size = norm(&self.weights, &corrector.increment);
            if iteration > 0 {
                corrector.contraction = (0.3 * corrector.contraction).max(size / last);
            }
            if size * corrector.contraction.min(1.0) * c.step_error <= CORRECTOR_ERROR {
                return Ok(());
            }
            let rounding = 16.0 * f64::EPSILON * norm(&self.weights, &self.trial);
            if size <= rounding {
                return Ok(());
            }
            if !size.is_finite() {
                return Err(Failure::NotFinite);
            }
            if iteration > 0 && size > 2.0 * last {
                break;
            }
            last = size;
        }
        Err(Failure::Corrector)
    }
}
