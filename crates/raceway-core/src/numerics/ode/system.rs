//! The system of equations as an integrator sees it.

use super::integrator::Integrator;
use super::structure::{Jacobian, Structure};

/// A system `dy/dt = f(t, y)`. It does not change during a run: all motion is in `y`.
pub trait OdeSystem {
    /// Number of entries of `y`.
    fn dimension(&self) -> usize;
    /// Writes `f(time, state)` into `derivative`; both slices have `dimension()` entries.
    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]);

    /// Which entries of `∂f/∂y` may differ from zero. Default: all.
    fn structure(&self) -> Structure {
        Structure::dense(self.dimension())
    }

    /// The system's own linearly implicit method with fixed steps; `None` where it has none.
    fn own_method<'a>(&'a self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 'a>> {
        let _ = (time, state, step);
        None
    }

    /// Writes `∂f/∂y` at `(time, state)`, where `f` is `rate`, and returns the evaluations of `f` it took. The default
    /// takes difference quotients over `displacement`, which a system with its own Jacobian may ignore.
    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        dense_differences(self, time, state, rate, displacement, jacobian)
    }
}

/// Fills a Jacobian that is all corner by difference quotients; returns the evaluations it took.
pub fn dense_differences(
    system: &(impl OdeSystem + ?Sized),
    time: f64,
    state: &[f64],
    rate: &[f64],
    displacement: &[f64],
    jacobian: &mut Jacobian,
) -> u64 {
    let n = state.len();
    let corner = jacobian.corner_mut();
    let (mut moved, mut moved_rate) = (state.to_vec(), vec![0.0; n]);
    for column in 0..n {
        moved[column] = state[column] + displacement[column];
        // The displacement after rounding.
        let added = moved[column] - state[column];
        system.derivative(time, &moved, &mut moved_rate);
        moved[column] = state[column];
        for row in 0..n {
            corner[row * n + column] = (moved_rate[row] - rate[row]) / added;
        }
    }
    n as u64
}
