//! The weights of a step, matrices made of the functions φ₁…φ₄.

use super::diagonal::{Diagonal, in_panels, row_by_row};
use crate::numerics::ode::phi::{Phi, double, phi};

/// Factors of a step of one length: of the rate and the first three differences of `f`.
#[derive(Debug, Clone)]
pub(super) struct Weights {
    pub(super) step: f64,
    /// φ₁…φ₄ of each block, and of the corner.
    functions: Vec<Phi>,
    pub(super) of_differences: [Diagonal; 4],
}

impl Weights {
    pub(super) fn new(linear: &Diagonal, step: f64) -> Self {
        let functions = linear.matrices().map(|(panels, n)| phi(&times(step, panels, n), n)).collect();
        Self::of(linear, step, functions)
    }

    /// Those of the doubled step, at a fraction of the cost.
    pub(super) fn doubled(&self, linear: &Diagonal) -> Self {
        let mut functions = self.functions.clone();
        for ((panels, n), functions) in linear.matrices().zip(&mut functions) {
            double(functions, &times(self.step, panels, n), n, 1);
        }
        Self::of(linear, 2.0 * self.step, functions)
    }

    fn of(linear: &Diagonal, step: f64, functions: Vec<Phi>) -> Self {
        let weights = |[one, two, three, four]: &Phi, which: usize| -> Vec<f64> {
            let entry = |i: usize| match which {
                0 => one[i],
                1 => two[i],
                2 => three[i] + 0.5 * two[i],
                _ => four[i] + three[i] + two[i] / 3.0,
            };
            (0..one.len()).map(|i| step * entry(i)).collect()
        };
        let of_difference = |which: usize| {
            let mut matrices: Vec<Vec<f64>> = linear
                .matrices()
                .zip(&functions)
                .map(|((_, n), functions)| in_panels(weights(functions, which).into_iter(), n))
                .collect();
            let corner = matrices.pop().unwrap_or_default();
            Diagonal { blocks: matrices, corner, ..*linear }
        };
        Self { step, of_differences: std::array::from_fn(of_difference), functions }
    }
}

/// Row by row.
fn times(step: f64, panels: &[f64], n: usize) -> Vec<f64> {
    row_by_row(panels, n).iter().map(|x| step * x).collect()
}
