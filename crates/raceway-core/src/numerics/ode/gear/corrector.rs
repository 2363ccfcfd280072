//! The matrix of the corrector, factors of `c·I − J` kept over several steps, and norms.

use crate::numerics::ode::arrowhead::ArrowheadFactors;
use crate::numerics::ode::integrator::Statistics;
use crate::numerics::ode::structure::{Jacobian, Structure, displacements};
use crate::numerics::ode::system::OdeSystem;
use crate::numerics::ode::tolerances::Tolerances;

/// Relative difference of leading coefficients up to which factors are reused.
const COEFFICIENT_DRIFT: f64 = 0.3;
/// Steps after which a factor, with its Jacobian when that has cost as much as a new one, is made anew.
const FACTOR_AGE: u32 = 20;

/// Matrix of Newton's iteration and its convergence.
pub(super) struct Corrector {
    pub(super) jacobian: Jacobian,
    pub(super) factors: ArrowheadFactors<f64>,
    /// Leading coefficient that the factors were made for; `None` before the first.
    pub(super) factored_for: Option<f64>,
    /// Steps since the factors were made.
    pub(super) factor_age: u32,
    /// The Jacobian belongs to the step being tried.
    pub(super) current: bool,
    /// Evaluations that the Jacobian took, and iterations beyond one a step since.
    jacobian_cost: u64,
    pub(super) excess: u64,
    pub(super) contraction: f64,
    /// Corrector less predictor.
    pub(super) correction: Vec<f64>,
    pub(super) increment: Vec<f64>,
    pub(super) rate: Vec<f64>,
    displacement: Vec<f64>,
}

/// Why a try failed.
pub(super) enum Failure {
    /// The iteration did not converge.
    Corrector,
    /// The right-hand side or its Jacobian is not finite.
    NotFinite,
}

impl Corrector {
    pub(super) fn new(structure: &Structure) -> Self {
        let vector = || vec![0.0; structure.dimension()];
        Self {
            jacobian: Jacobian::new(structure),
            factors: ArrowheadFactors::new(structure),
            factored_for: None,
            factor_age: 0,
            current: false,
            jacobian_cost: 0,
            excess: 0,
            contraction: 1.0,
            correction: vector(),
            increment: vector(),
            rate: vector(),
            displacement: vector(),
        }
    }

    /// Makes factors that fit the leading coefficient where there are none.
    #[inline(always)]
    pub(super) fn prepare<S: OdeSystem + ?Sized>(
        &mut self,
        system: &S,
        (time, state): (f64, &[f64]),
        tolerances: &Tolerances,
        (step, leading): (f64, f64),
        statistics: &mut Statistics,
    ) -> Result<(), Failure> {
        let drifted = |made_for: f64| (leading / made_for - 1.0).abs() > COEFFICIENT_DRIFT;
        let paid = self.excess >= self.jacobian_cost;
        let outdated = self.factored_for.is_none() || (paid && !self.current);
        let unfit = outdated || self.factored_for.is_some_and(drifted) || self.factor_age > FACTOR_AGE;
        if !unfit {
            return Ok(());
        }
        if outdated && !self.current {
            displacements(state, &self.rate, tolerances, step, &mut self.displacement);
            self.jacobian_cost = system.jacobian(time, state, &self.rate, &self.displacement, &mut self.jacobian);
            statistics.rhs_evaluations += self.jacobian_cost;
            statistics.jacobian_evaluations += 1;
            self.excess = 0;
            self.current = true;
            if !self.jacobian.is_finite() {
                self.factored_for = None;
                return Err(Failure::NotFinite);
            }
        }
        statistics.factorizations += 1;
        self.contraction = 1.0;
        self.factor_age = 0;
        if self.factors.factor(&self.jacobian, leading).is_err() {
            self.factored_for = None;
            return Err(Failure::Corrector);
        }
        self.factored_for = Some(leading);
        Ok(())
    }
}

/// Partial sums of a norm: one sum would wait for itself at every entry.
const SUMS: usize = 8;

/// Weighted root mean square.
#[inline(always)]
pub(super) fn norm(weights: &[f64], a: &[f64]) -> f64 {
    norm_of_sum(weights, a, (0.0, a))
}

/// Weighted root mean square of `a + factor · b`.
#[inline(always)]
pub(super) fn norm_of_sum(weights: &[f64], a: &[f64], (factor, b): (f64, &[f64])) -> f64 {
    let mut sums = [0.0; SUMS];
    let ((all_weights, weights_left), (all_a, a_left), (all_b, b_left)) =
        (weights.as_chunks::<SUMS>(), a.as_chunks::<SUMS>(), b.as_chunks::<SUMS>());
    let mut add = |k: usize, weight: f64, a: f64, b: f64| {
        let x = (a + factor * b) * weight;
        sums[k] += x * x;
    };
    for ((weights, a), b) in all_weights.iter().zip(all_a).zip(all_b) {
        for k in 0..SUMS {
            add(k, weights[k], a[k], b[k]);
        }
    }
    for (k, ((weight, a), b)) in weights_left.iter().zip(a_left).zip(b_left).enumerate() {
        add(k, *weight, *a, *b);
    }
    (sums.iter().sum::<f64>() / weights.len().max(1) as f64).sqrt()
}
