//! Radau IIA of order 5 with three stages: implicit, L-stable, the reference for all else.
//!
//! E. Hairer & G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., §IV.5 (the method) and §IV.8
//! (transformed Newton iteration, error estimate, step control). The stages are the values of a polynomial of degree 3,
//! the collocation polynomial, whose slope is the right-hand side at three points of the step; All quantities here are
//! those of this polynomial.

mod coefficients;
mod convergence;
mod newton;
#[cfg(test)]
mod tests;

use nalgebra::Complex;

use self::coefficients::{SLOPE_AT_START, basis};
use self::convergence::Convergence;
use super::arrowhead::ArrowheadFactors;
use super::integrator::{Choice, IntegrationError, Integrator, Statistics};
use super::method::Method;
use super::step_size::{Try, error_norm, initial_step, is_impossible, stays_broken, worst_component};
use super::structure::Jacobian;
use super::system::OdeSystem;
use super::tolerances::Tolerances;

/// Iterations of Newton's method in a step.
const MAX_ITERATIONS: u32 = 10;
/// Part of the asked tolerance that may be left to Newton's iteration.
const NEWTON_PART: f64 = 0.03;
/// An iteration that contracts better than this needs no new Jacobian.
const FAST_CONTRACTION: f64 = 0.01;
/// Contraction with a new Jacobian, in proportion to the step, up to which the step may grow.
const SLOWEST_CONTRACTION: f64 = 0.4;
/// Largest number of steps with one Jacobian. An outdated Jacobian that is too stiff hides poor convergence.
const MAX_STEPS: u32 = 30;
/// Growth of the step below which the factors are kept instead.
const MIN_GROWTH: f64 = 1.2;
const MAX_GROWTH: f64 = 8.0;
const MAX_CUT: f64 = 0.2;
const SAFETY: f64 = 0.9;
/// Order of the error estimate, plus one.
const ESTIMATE: f64 = 4.0;

/// Allowed error estimate of a step over the requested tolerance r [-]. The estimate is of order h⁴ and the error at
/// the end of order h⁵. With 0.3 r^⅘ in place of r the error is proportional to r. (§IV.8 takes 0.1 r^⅔, after which
/// the error falls more slowly than r.)
fn slack(tolerances: &Tolerances) -> f64 {
    let relative = tolerances.relative.iter().copied().fold(0.0, f64::max);
    if relative > 0.0 { 0.3 * relative.powf(-0.2) } else { 1.0 }
}

/// Outcome of a try.
enum Outcome {
    /// Error norm at most 1; the iterations it took.
    Passed { error: f64, iterations: u32 },
    /// Error norm above 1.
    Failed { error: f64, iterations: u32 },
    /// Newton's iteration does not converge; a step of this part may.
    Stuck { factor: f64 },
    /// A rate, or the matrix, is not finite.
    Broken,
}

/// An accepted step and its error, for the prediction of the next one.
#[derive(Debug, Clone, Copy)]
struct Accepted {
    step: f64,
    error: f64,
}

/// The method with its workspace; allocates only on construction and for a first step.
pub(crate) struct Radau<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    /// Those of the embedded estimate.
    tolerances: Tolerances,
    /// Largest increment norm that ends Newton's iteration.
    newton_tolerance: f64,
    time: f64,
    state: Vec<f64>,
    /// Right-hand side at `(time, state)`.
    rate: Vec<f64>,
    previous_time: f64,
    previous_state: Vec<f64>,
    /// Collocation polynomial of the last step: stages less the state at its start.
    stages: [Vec<f64>; 3],
    /// Stages of the step tried, their transform T⁻¹ · stages, and the rates at the stages.
    trial_stages: [Vec<f64>; 3],
    transformed: [Vec<f64>; 3],
    rates: [Vec<f64>; 3],
    trial: Vec<f64>,
    /// Right-hand sides and increments of the two transformed systems.
    real: Vec<f64>,
    pair: Vec<Complex<f64>>,
    error: Vec<f64>,
    displacement: Vec<f64>,
    jacobian: Jacobian,
    real_factors: ArrowheadFactors<f64>,
    pair_factors: ArrowheadFactors<Complex<f64>>,
    /// Step that the factors belong to; NaN without factors.
    factored_step: f64,
    /// The Jacobian was evaluated at `(time, state)`.
    jacobian_is_fresh: bool,
    /// The Jacobian converged fast in the last step and is kept for the next.
    jacobian_serves: bool,
    /// Steps since it was evaluated.
    jacobian_age: u32,
    convergence: Convergence,
    accepted: Option<Accepted>,
    /// Size of the next step; infinite until a first one is chosen.
    step: f64,
    /// The next step is the first, or the first after a restart.
    starting: bool,
    /// The last polynomial continues into the next step.
    continues: bool,
    statistics: Statistics,
}

impl<'a, S: OdeSystem + ?Sized> Radau<'a, S> {
    /// Starts at `(time, state)`.
    pub(crate) fn new(system: &'a S, time: f64, state: &[f64], tolerances: Tolerances) -> Self {
        let structure = system.structure();
        let vector = || vec![0.0; state.len()];
        let vectors = || std::array::from_fn(|_| vector());
        let slack = slack(&tolerances);
        let scaled = |tolerances: &[f64]| tolerances.iter().map(|tolerance| slack * tolerance).collect();
        Self {
            system,
            tolerances: Tolerances { relative: scaled(&tolerances.relative), absolute: scaled(&tolerances.absolute) },
            newton_tolerance: NEWTON_PART / slack.max(1.0),
            time,
            state: state.to_vec(),
            rate: vector(),
            previous_time: time,
            previous_state: state.to_vec(),
            stages: vectors(),
            trial_stages: vectors(),
            transformed: vectors(),
            rates: vectors(),
            trial: vector(),
            real: vector(),
            pair: vec![Complex::new(0.0, 0.0); state.len()],
            error: vector(),
            displacement: vector(),
            jacobian: Jacobian::new(&structure),
            real_factors: ArrowheadFactors::new(&structure),
            pair_factors: ArrowheadFactors::new(&structure),
            factored_step: f64::NAN,
            jacobian_is_fresh: false,
            jacobian_serves: false,
            jacobian_age: 0,
            convergence: Convergence::UNKNOWN,
            accepted: None,
            step: f64::INFINITY,
            starting: true,
            continues: false,
            statistics: Statistics::default(),
        }
    }

    /// Evaluates the rate and chooses the first step; after a restart it is at most the last one.
    fn start(&mut self, span: f64) {
        self.system.derivative(self.time, &self.state, &mut self.rate);
        let first = initial_step(self.system, self.time, &self.state, &self.rate, &self.tolerances, 3, span);
        self.statistics.rhs_evaluations += 2;
        self.step = self.step.min(first);
        self.starting = false;
    }

    /// Error norm of the stages: the defect of the polynomial's slope at the start, filtered by the real factors
    /// (IV.8.19). Without the filter stiff components would count for more than their error.
    fn estimate(&mut self, step: f64) -> f64 {
        self.error.copy_from_slice(&self.rate);
        self.filtered_defect(step)
    }

    /// The estimate filtered once more: the right-hand side is taken where the first estimate points (IV.8.20).
    fn estimate_again(&mut self, step: f64) -> f64 {
        for ((at, start), error) in self.trial.iter_mut().zip(&self.state).zip(&self.error) {
            *at = start + error;
        }
        self.system.derivative(self.time, &self.trial, &mut self.error);
        self.statistics.rhs_evaluations += 1;
        self.filtered_defect(step)
    }

    /// Replaces the rate in `error` by the filtered defect against it; its norm.
    fn filtered_defect(&mut self, step: f64) -> f64 {
        for (i, error) in self.error.iter_mut().enumerate() {
            let slope: f64 = (0..3).map(|k| SLOPE_AT_START[k] * self.trial_stages[k][i]).sum();
            *error -= slope / step;
            self.trial[i] = self.state[i] + self.trial_stages[2][i];
        }
        self.real_factors.solve(&mut self.error);
        error_norm(&self.error, &self.state, &self.trial, &self.tolerances)
    }

    /// Tries a step. `doubtful`: the first one, or one after a rejection.
    fn try_step(&mut self, step: f64, doubtful: bool) -> Outcome {
        if self.prepare(step).is_err() {
            return if self.jacobian.is_finite() { Outcome::Stuck { factor: 0.5 } } else { Outcome::Broken };
        }
        self.predict(step);
        let iterations = match self.newton(step) {
            Ok(iterations) => iterations,
            Err(outcome) => return outcome,
        };
        let mut error = self.estimate(step);
        if error > 1.0 && doubtful {
            error = self.estimate_again(step);
        }
        if error <= 1.0 {
            Outcome::Passed { error, iterations }
        } else if error.is_finite() {
            Outcome::Failed { error, iterations }
        } else {
            Outcome::Broken
        }
    }

    /// Factor on the step after an error norm: the more iterations, the more carefully.
    fn factor(error: f64, iterations: u32) -> f64 {
        let most = f64::from(2 * MAX_ITERATIONS);
        let safety = SAFETY * (most + 1.0) / (most + f64::from(iterations));
        (safety * error.powf(-1.0 / ESTIMATE)).clamp(MAX_CUT, MAX_GROWTH)
    }

    /// The step that follows an accepted one: by its error, and at most by how the error has moved (Gustafsson)
    /// and by how far Newton's iteration is good for.
    fn following(&self, step: f64, error: f64, iterations: u32) -> f64 {
        let by_trend = self.accepted.map_or(MAX_GROWTH, |last| {
            let trend = (last.error / (error * error)).powf(1.0 / ESTIMATE);
            (SAFETY * step / last.step * trend).max(MAX_CUT)
        });
        let contraction = if self.jacobian_is_fresh { self.convergence.contraction } else { 0.0 };
        let by_newton = SLOWEST_CONTRACTION / contraction;
        step * Self::factor(error, iterations).min(by_trend).min(by_newton)
    }

    /// Makes the tried step the last one.
    fn accept(&mut self, tried: &Try) {
        self.previous_time = self.time;
        self.time = tried.end;
        self.previous_state.copy_from_slice(&self.state);
        std::mem::swap(&mut self.stages, &mut self.trial_stages);
        for (state, increment) in self.state.iter_mut().zip(&self.stages[2]) {
            *state += increment;
        }
        self.system.derivative(self.time, &self.state, &mut self.rate);
        self.statistics.rhs_evaluations += 1;
        self.statistics.accept(tried.step, tried.cut);
        self.continues = true;
        self.jacobian_is_fresh = false;
        self.jacobian_age += 1;
        self.jacobian_serves = self.convergence.contraction <= FAST_CONTRACTION && self.jacobian_age < MAX_STEPS;
    }

    /// Accepts a step and chooses the next.
    fn pass(&mut self, tried: &Try, doubtful: bool, error: f64, iterations: u32) {
        let step = tried.step;
        let next = self.following(step, error, iterations);
        self.accept(tried);
        self.accepted = Some(Accepted { step, error: error.max(1e-2) });
        let next = if doubtful { next.min(step) } else { next };
        let keeps_factors = !tried.cut && self.jacobian_serves && (1.0..MIN_GROWTH).contains(&(next / step));
        self.step = if keeps_factors { step } else { tried.followed_by(next, self.step) };
    }

    /// The component to blame: NaN where rates are, the last increment, or the error.
    fn culprit(&mut self, outcome: &Outcome) -> usize {
        for i in 0..self.state.len() {
            match outcome {
                Outcome::Broken => self.error[i] = self.rate[i] + self.rates.iter().map(|rate| rate[i]).sum::<f64>(),
                Outcome::Stuck { .. } => self.error[i] = self.real[i],
                _ => {}
            }
        }
        worst_component(&self.error, &self.state, &self.state, &self.tolerances)
    }
}

impl<S: OdeSystem + ?Sized> Integrator for Radau<'_, S> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        if self.starting {
            self.start(limit - self.time);
        }
        let mut rejections = 0;
        loop {
            let tried = Try::new(self.time, self.step, limit);
            let step = tried.step;
            let doubtful = rejections > 0 || self.accepted.is_none();
            let outcome = self.try_step(step, doubtful);
            let stale = !self.jacobian_is_fresh;
            self.step = match outcome {
                Outcome::Passed { error, iterations } => {
                    self.pass(&tried, rejections > 0, error, iterations);
                    return Ok(());
                }
                Outcome::Failed { error, iterations } => step * Self::factor(error, iterations).min(SAFETY),
                // A new Jacobian may do.
                Outcome::Stuck { .. } if stale => step,
                Outcome::Stuck { factor } => step * factor,
                Outcome::Broken => step * 0.1,
            };
            self.statistics.rejected_steps += 1;
            rejections += 1;
            if matches!(outcome, Outcome::Stuck { .. } | Outcome::Broken) {
                self.statistics.newton_failures += 1;
                self.jacobian_serves = false;
            }
            let broken = matches!(outcome, Outcome::Broken);
            if broken && stays_broken(rejections) {
                let component = self.culprit(&outcome);
                return Err(IntegrationError::NotFinite { time: self.time, step, component });
            }
            if is_impossible(rejections, self.time, self.step) {
                let component = self.culprit(&outcome);
                return Err(IntegrationError::StepTooSmall { time: self.time, step: self.step, component });
            }
        }
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn previous_time(&self) -> f64 {
        self.previous_time
    }

    fn state(&self) -> &[f64] {
        &self.state
    }

    fn interpolate(&self, time: f64, state: &mut [f64]) {
        let step = self.time - self.previous_time;
        if step == 0.0 {
            state.copy_from_slice(&self.state);
            return;
        }
        let weights = basis((time - self.previous_time) / step);
        for (i, value) in state.iter_mut().enumerate() {
            let moved: f64 = (0..3).map(|k| weights[k] * self.stages[k][i]).sum();
            *value = self.previous_state[i] + moved;
        }
    }

    fn restart(&mut self) {
        self.time = self.time.next_up();
        self.starting = true;
        self.continues = false;
        self.accepted = None;
        self.jacobian_is_fresh = false;
        self.jacobian_serves = false;
        self.convergence = Convergence::UNKNOWN;
    }

    fn statistics(&self) -> Statistics {
        self.statistics
    }

    fn choice(&self) -> Choice {
        Choice { method: Method::Radau, reason: None }
    }
}
