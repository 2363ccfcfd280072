//! Order and size of the next step.

use super::Gear;
use super::coefficients::{Coefficients, MAX_ORDER};
use super::corrector::norm_of_sum;
use crate::numerics::ode::system::OdeSystem;

/// Target error of the next step over the allowed error, at the same, the next lower and the next higher order. High
/// orders are favoured: their steps cost the same, and err less than they are estimated to.
const AIM: [f64; 3] = [1.0 / 4.0, 1.0 / 4.0, 1.0 / 2.0];
/// A step must gain this much to grow, so that differences and factors are not upset for little.
const MIN_GAIN: f64 = 1.2;
const MAX_GAIN: f64 = 4.0;
/// Failed error tests of one step after which its history is discarded.
const DISTRUST: u32 = 3;

impl<S: OdeSystem + ?Sized> Gear<'_, S> {
    /// Order and size of the next step, seen from an accepted try that is not yet taken over.
    #[inline(always)]
    pub(super) fn plan(&self, step: f64, error: f64, c: &Coefficients) -> (usize, f64) {
        let k = self.order;
        let same = gain(error, k, AIM[0]);
        let lower = self.gain_lower(c);
        if self.starting && k < MAX_ORDER && same > 1.0 && same > lower {
            return (k + 1, 2.0 * step);
        }
        let failing = 1.5 * error > 1.0;
        if self.settled < k {
            // Too early to judge the order; but a step about to fail is made shorter at once.
            return (k, if failing { step * same.min(0.9) } else { step });
        }
        let (mut best, mut order) = (same, k);
        if lower > best {
            (best, order) = (lower, k - 1);
        }
        if k < MAX_ORDER && self.known > k + 1 {
            let scale = c.scale[k + 1];
            let correction = &self.corrector.correction;
            let higher = norm_of_sum(&self.weights, correction, (-scale, &self.differences[k + 1]));
            let higher = gain(c.error[k + 1] * higher, k + 1, AIM[2]);
            if higher > best {
                (best, order) = (higher, k + 1);
            }
        }
        if best >= MIN_GAIN {
            (order, step * best.min(MAX_GAIN))
        } else if failing || order < k {
            (order, step * best.clamp(0.5, 0.9))
        } else {
            (k, step)
        }
    }

    /// Reduces step and order after a try whose error was too large.
    #[inline(always)]
    pub(super) fn after_rejection(&mut self, step: f64, error: f64, failures: u32, c: &Coefficients) {
        self.starting = false;
        if failures >= DISTRUST {
            self.change(0.25 * step, 1);
            if self.known > 2 {
                self.forget();
            }
            return;
        }
        let lower = self.gain_lower(c);
        let same = gain(error, self.order, 0.5);
        let order = if lower > same { self.order - 1 } else { self.order };
        self.change(step * same.max(lower).clamp(0.25, 0.9), order);
    }

    /// Factor that the step may grow by at the next lower order; 0 at order 1.
    #[inline(always)]
    fn gain_lower(&self, c: &Coefficients) -> f64 {
        let k = self.order;
        if k == 1 {
            return 0.0;
        }
        let scale = c.scale[k];
        let correction = &self.corrector.correction;
        let lower = norm_of_sum(&self.weights, correction, (scale, &self.differences[k]));
        gain(c.error[k - 1] * lower, k - 1, AIM[1])
    }
}

/// Factor on the step that brings an error of order `order` to `aim` tolerances.
fn gain(error: f64, order: usize, aim: f64) -> f64 {
    (aim / error.max(1e-10)).powf(1.0 / (order as f64 + 1.0))
}
