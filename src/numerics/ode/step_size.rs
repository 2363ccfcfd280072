//! Accept or reject a step, and the size of the next.

use super::Tolerances;

/// Weighted root mean square of `error`: at most 1 when each component errs within its tolerance.
/// NaN where an entry is NaN.
pub fn error_norm(error: &[f64], before: &[f64], after: &[f64], tolerances: &Tolerances) -> f64 {
    let sum: f64 = (0..error.len())
        .map(|i| {
            let scale = tolerances.absolute[i] + tolerances.relative[i] * before[i].abs().max(after[i].abs());
            (error[i] / scale).powi(2)
        })
        .sum();
    (sum / error.len().max(1) as f64).sqrt()
}

/// The component that errs most against its tolerance, for error messages.
pub fn worst_component(error: &[f64], before: &[f64], after: &[f64], tolerances: &Tolerances) -> usize {
    let ratio = |i: usize| {
        let scale = tolerances.absolute[i] + tolerances.relative[i] * before[i].abs().max(after[i].abs());
        let ratio = (error[i] / scale).abs();
        if ratio.is_nan() { f64::INFINITY } else { ratio }
    };
    (0..error.len()).max_by(|&a, &b| ratio(a).total_cmp(&ratio(b))).unwrap_or(0)
}

/// Proportional–integral step-size control after Gustafsson, constants of Hairer, Nørsett & Wanner,
/// *Solving Ordinary Differential Equations I*, §IV.2 (DOPRI5). The integral part keeps the step
/// from oscillating where stability, not accuracy, limits it.
#[derive(Debug, Clone)]
pub struct StepSizeControl {
    /// 1 / (order of the error estimate + 1)
    exponent: f64,
    previous_error: f64,
    just_rejected: bool,
}

const SAFETY: f64 = 0.9;
const INTEGRAL: f64 = 0.04;
const LEAST_FACTOR: f64 = 0.2;
const LARGEST_FACTOR: f64 = 10.0;

impl StepSizeControl {
    /// `order`: order of the error estimate.
    pub fn new(order: u32) -> Self {
        Self { exponent: 1.0 / f64::from(order + 1), previous_error: 1e-4, just_rejected: false }
    }

    /// Factor on the step after an error norm ≤ 1. A step that follows a rejection does not grow.
    pub fn accepted(&mut self, error: f64) -> f64 {
        let error = error.max(1e-10);
        let factor = SAFETY * error.powf(0.75 * INTEGRAL - self.exponent) * self.previous_error.powf(INTEGRAL);
        self.previous_error = error.max(1e-4);
        let most = if std::mem::take(&mut self.just_rejected) { 1.0 } else { LARGEST_FACTOR };
        factor.clamp(LEAST_FACTOR, most)
    }

    /// Factor on the step after an error norm above 1 (NaN included).
    pub fn rejected(&mut self, error: f64) -> f64 {
        self.just_rejected = true;
        let factor = SAFETY * error.powf(-self.exponent);
        if factor.is_finite() { factor.clamp(0.1, 0.9) } else { 0.1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_at_tolerance_has_norm_one() {
        let tolerances = Tolerances::uniform(2, 0.0, 1e-3);
        assert_eq!(error_norm(&[1e-3, -1e-3], &[0.0; 2], &[0.0; 2], &tolerances), 1.0);
        assert!(error_norm(&[f64::NAN, 0.0], &[0.0; 2], &[0.0; 2], &tolerances).is_nan());
        assert_eq!(worst_component(&[1e-4, f64::NAN], &[0.0; 2], &[0.0; 2], &tolerances), 1);
    }

    #[test]
    fn a_rejected_step_shrinks_and_the_next_does_not_grow() {
        let mut control = StepSizeControl::new(4);
        assert!(control.rejected(f64::NAN) == 0.1);
        assert!(control.rejected(2.0) < 0.9);
        assert!(control.accepted(1e-9) <= 1.0);
        assert!(control.accepted(1e-9) > 1.0);
    }
}
