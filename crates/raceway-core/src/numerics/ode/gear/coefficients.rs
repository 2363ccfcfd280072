//! Coefficients of backward differentiation over steps of any sizes, with a fixed leading coefficient.

/// Highest order with a useful sector of stability.
pub(super) const MAX_ORDER: usize = 5;
/// Differences kept: the state, as many as the order, and two to judge the next higher order.
pub(super) const DIFFERENCES: usize = MAX_ORDER + 3;

/// Coefficients of one step of a given size and order.
pub(super) struct Coefficients {
    /// Scales the differences to the new step.
    pub(super) scale: [f64; DIFFERENCES],
    /// Weights of the scaled differences in the predicted rate.
    pub(super) rate: [f64; DIFFERENCES],
    /// Error of order q from the scaled difference q + 1.
    pub(super) error: [f64; DIFFERENCES],
    /// c: the corrector's rate is the predicted one and c times the correction.
    pub(super) leading: f64,
    /// Error of the step from the norm of the correction.
    pub(super) step_error: f64,
}

impl Coefficients {
    /// `steps`: sizes of the past steps, the latest first.
    pub(super) fn new(step: f64, steps: &[f64; DIFFERENCES], order: usize) -> Self {
        let mut c = Self {
            scale: [1.0; DIFFERENCES],
            rate: [0.0; DIFFERENCES],
            error: [1.0; DIFFERENCES],
            leading: 0.0,
            step_error: 0.0,
        };
        // Time from the new point back to the i-th last one, and the same seen from the last point.
        let (mut back, mut back_before) = (step, 0.0);
        let (mut harmonic, mut sum) = (0.0, 0.0);
        for i in 1..DIFFERENCES.min(order + 3) {
            back_before += steps[i - 1];
            c.scale[i] = c.scale[i - 1] * back / back_before;
            c.rate[i] = c.rate[i - 1] + 1.0 / back;
            if i <= order {
                harmonic += 1.0 / i as f64;
                sum += step / back;
            }
            back = step + back_before;
            c.error[i] = i as f64 * c.error[i - 1] * step / back;
            if i == order {
                let next = step / back;
                c.step_error = (next + sum - harmonic).abs().max(next);
            }
        }
        c.leading = harmonic / step;
        c
    }
}
