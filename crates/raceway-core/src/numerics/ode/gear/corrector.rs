//! The corrector: Newton's iteration on factors of `c·I − J` that are kept as long as they serve.

use super::Gear;
use super::coefficients::Coefficients;
use crate::numerics::ode::arrowhead::ArrowheadFactors;
use crate::numerics::ode::step_size::Try;
use crate::numerics::ode::structure::{Jacobian, Structure, displacements};
use crate::numerics::ode::{OdeSystem, Statistics, Tolerances};

/// Corrector iterations a step.
const MOST_ITERATIONS: u32 = 4;
/// Error that the corrector may leave, as a share of that of a step.
const CORRECTOR_ERROR: f64 = 0.05;
/// A factor made for another leading coefficient serves while that is off by less than this share.
const COEFFICIENT_DRIFT: f64 = 0.3;
/// Steps after which a factor, with its Jacobian when that has cost as much as a new one, is made anew.
const FACTOR_AGE: u32 = 20;

/// Newton's iteration: its matrix and how well that does.
pub(super) struct Corrector {
    pub(super) jacobian: Jacobian,
    factors: ArrowheadFactors<f64>,
    /// Leading coefficient that the factors were made for; `None` before the first.
    pub(super) factored_for: Option<f64>,
    /// Steps since the factors were made.
    pub(super) factor_age: u32,
    /// The Jacobian belongs to the step being tried.
    pub(super) current: bool,
    /// Evaluations that the Jacobian took, and iterations beyond one a step since.
    jacobian_cost: u64,
    excess: u64,
    contraction: f64,
    /// Corrector less predictor.
    pub(super) correction: Vec<f64>,
    increment: Vec<f64>,
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

impl<S: OdeSystem + ?Sized> Gear<'_, S> {
    /// Solves for the correction at the end of a step, from the predictor on.
    #[inline(always)]
    pub(super) fn correct(&mut self, tried: &Try, c: &Coefficients) -> Result<(), Failure> {
        let (corrector, end) = (&mut self.corrector, tried.end);
        corrector.correction.fill(0.0);
        self.trial.copy_from_slice(&self.predicted);
        let mut last = 0.0;
        for iteration in 0..MOST_ITERATIONS {
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

    /// Sees to it that factors fit for the leading coefficient exist.
    #[inline(always)]
    fn prepare<S: OdeSystem + ?Sized>(
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
