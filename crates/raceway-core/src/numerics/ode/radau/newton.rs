//! Simplified Newton iteration for the stages, on factors that are kept while it converges fast (Hairer & Wanner II,
//! §IV.8).

use nalgebra::Complex;

use super::coefficients::{C, PAIR, REAL, T, T_INVERSE, basis, transform};
use super::convergence::Convergence;
use super::{ESTIMATE, MAX_ITERATIONS, Outcome, Radau};
use crate::numerics::ode::arrowhead::Singular;
use crate::numerics::ode::structure::displacements;
use crate::numerics::ode::system::OdeSystem;

/// Relative difference between a step and that of the factors: no more than the rounding of times.
const SAME_STEP: f64 = 1e-6;
/// Least assumed remainder after a first increment, over the increment; the last step may have converged better than
/// this one.
const MIN_REMAINDER: f64 = 1e-3;

impl<S: OdeSystem + ?Sized> Radau<'_, S> {
    /// Makes Jacobian and factors fit for a step, as far as they are not.
    pub(super) fn prepare(&mut self, step: f64) -> Result<(), Singular> {
        if !self.jacobian_is_fresh && !self.jacobian_serves {
            displacements(&self.state, &self.rate, &self.tolerances, step, &mut self.displacement);
            self.statistics.rhs_evaluations +=
                self.system.jacobian(self.time, &self.state, &self.rate, &self.displacement, &mut self.jacobian);
            self.statistics.jacobian_evaluations += 1;
            self.jacobian_is_fresh = true;
            self.jacobian_age = 0;
            self.factored_step = f64::NAN;
        }
        let fits = (step / self.factored_step - 1.0).abs() < SAME_STEP;
        if !fits {
            self.factored_step = f64::NAN;
            self.statistics.factorizations += 1;
            self.real_factors.factor(&self.jacobian, REAL / step)?;
            self.pair_factors.factor(&self.jacobian, PAIR / step)?;
            self.factored_step = step;
        }
        Ok(())
    }

    /// Initial stages by extrapolation of the last polynomial.
    pub(super) fn predict(&mut self, step: f64) {
        let last = self.time - self.previous_time;
        let weights = C.map(|c| basis(1.0 + c * step / last));
        for i in 0..self.state.len() {
            let stages: [f64; 3] = std::array::from_fn(|k| self.stages[k][i]);
            for (weights, trial) in weights.iter().zip(&mut self.trial_stages) {
                trial[i] = if self.continues {
                    weights[0] * stages[0] + weights[1] * stages[1] + (weights[2] - 1.0) * stages[2]
                } else {
                    0.0
                };
            }
            let transformed = transform(&T_INVERSE, &self.trial_stages, i);
            for (all, value) in self.transformed.iter_mut().zip(transformed) {
                all[i] = value;
            }
        }
    }

    /// Rates at the stages.
    fn evaluate_stages(&mut self, step: f64) {
        for ((c, stage), rate) in C.iter().zip(&self.trial_stages).zip(&mut self.rates) {
            for ((at, start), stage) in self.trial.iter_mut().zip(&self.state).zip(stage) {
                *at = start + stage;
            }
            self.system.derivative(self.time + c * step, &self.trial, rate);
        }
        self.statistics.rhs_evaluations += 3;
    }

    /// One iteration of the simplified Newton method; the norm of its increment.
    fn iterate(&mut self, step: f64) -> f64 {
        self.evaluate_stages(step);
        let n = self.state.len();
        let (real_shift, pair_shift) = (REAL / step, PAIR / step);
        for i in 0..n {
            let rate = transform(&T_INVERSE, &self.rates, i);
            let [real, first, second] = std::array::from_fn(|k| self.transformed[k][i]);
            self.real[i] = rate[0] - real_shift * real;
            self.pair[i] = Complex::new(rate[1], rate[2]) - pair_shift * Complex::new(first, second);
        }
        self.real_factors.solve(&mut self.real);
        self.pair_factors.solve(&mut self.pair);
        let mut sum = 0.0;
        for i in 0..n {
            let increment = [self.real[i], self.pair[i].re, self.pair[i].im];
            for (all, increment) in self.transformed.iter_mut().zip(increment) {
                all[i] += increment;
            }
            let stages = transform(&T, &self.transformed, i);
            for (all, stage) in self.trial_stages.iter_mut().zip(stages) {
                all[i] = stage;
            }
            let weight = self.tolerances.allowed(i, self.state[i]);
            sum += increment.iter().map(|x| (x / weight).powi(2)).sum::<f64>();
        }
        (sum / (3 * n.max(1)) as f64).sqrt()
    }

    /// Norm of an increment that is nothing but rounding of the stages.
    fn rounding(&self) -> f64 {
        let sum: f64 = (0..self.state.len())
            .map(|i| {
                let size = self.trial_stages.iter().map(|stage| stage[i].abs()).fold(self.state[i].abs(), f64::max);
                (size / self.tolerances.allowed(i, self.state[i])).powi(2)
            })
            .sum();
        16.0 * f64::EPSILON * (sum / self.state.len().max(1) as f64).sqrt()
    }

    /// Solves for the stages; the iterations it took.
    pub(super) fn newton(&mut self, step: f64) -> Result<u32, Outcome> {
        // Nothing is known before the second increment; the last step went about as well.
        self.convergence.contraction = 0.0;
        self.convergence.remainder = self.convergence.remainder.max(MIN_REMAINDER).powf(0.8);
        let (mut last, mut last_ratio): (Option<f64>, Option<f64>) = (None, None);
        for iteration in 1..=MAX_ITERATIONS {
            let increment = self.iterate(step);
            if !increment.is_finite() {
                return Err(Outcome::Broken);
            }
            if increment <= self.rounding() {
                return Ok(iteration);
            }
            if let Some(last) = last {
                let ratio = increment / last;
                let contraction = last_ratio.map_or(ratio, |last_ratio| (ratio * last_ratio).sqrt());
                if contraction >= 0.99 {
                    return Err(Outcome::Stuck { factor: 0.5 });
                }
                self.convergence = Convergence { contraction, remainder: contraction / (1.0 - contraction) };
                last_ratio = Some(ratio);
            }
            let left = self.convergence.remainder * increment / self.newton_tolerance;
            if left <= 1.0 {
                return Ok(iteration);
            }
            if last.is_some() {
                let iterations = MAX_ITERATIONS - iteration;
                let expected = left * self.convergence.contraction.powi(iterations as i32);
                if expected >= 1.0 {
                    let exponent = -1.0 / (ESTIMATE + f64::from(iterations));
                    return Err(Outcome::Stuck { factor: 0.8 * expected.min(20.0).powf(exponent) });
                }
            }
            last = Some(increment);
        }
        Err(Outcome::Stuck { factor: 0.5 })
    }
}
