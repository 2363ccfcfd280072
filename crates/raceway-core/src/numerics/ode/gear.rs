//! Gear's method: backward differentiation of variable step and order 1–5, predictor and corrector.
//!
//! Variable coefficients on modified divided differences with a fixed leading coefficient (K. R. Jackson & R.
//! Sacks-Davis, ACM Trans. Math. Softw. 6 (1980) 295–318; K. E. Brenan, S. L. Campbell & L. R. Petzold, *Numerical
//! Solution of Initial-Value Problems in Differential-Algebraic Equations*, §5.2): step and order may change at every
//! step, as they must where balls enter and leave the loaded zone. The corrector is solved by Newton's iteration on
//! factors of `c·I − J` that are kept while the iteration converges fast.

mod coefficients;
mod corrector;
mod newton;
mod order;
#[cfg(test)]
mod tests;

use self::coefficients::{Coefficients, DIFFERENCES};
use self::corrector::{Corrector, Failure, norm};
use super::integrator::{Choice, IntegrationError, Integrator, Statistics};
use super::method::Method;
use super::step_size::{Try, initial_step, is_impossible, largest};
use super::system::OdeSystem;
use super::tolerances::Tolerances;
use crate::numerics::lanes::{InstructionSet, Task};

/// Allowed error of a step over the tolerance, because errors add up over the steps.
const SHARE: f64 = 0.25;

/// The method with its workspace; allocates only on construction.
pub(crate) struct Gear<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    tolerances: Tolerances,
    instructions: InstructionSet,
    order: usize,
    time: f64,
    previous_time: f64,
    /// Size of the next step.
    step: f64,
    /// Modified divided differences at `time`: the first is the state.
    differences: Vec<Vec<f64>>,
    /// Number of differences that rest on steps.
    known: usize,
    /// Sizes of the last steps, latest first.
    steps: [f64; DIFFERENCES],
    /// Order of the last step.
    last_order: usize,
    /// Steps since order or step size changed.
    settled: usize,
    /// Order and step still grow from the start.
    starting: bool,
    corrector: Corrector,
    predicted: Vec<f64>,
    predicted_rate: Vec<f64>,
    trial: Vec<f64>,
    /// 1 over the allowed error of each entry in a step.
    weights: Vec<f64>,
    statistics: Statistics,
}

impl<'a, S: OdeSystem + ?Sized> Gear<'a, S> {
    /// Starts at `(time, state)` with order 1.
    pub(crate) fn new(system: &'a S, time: f64, state: &[f64], tolerances: Tolerances) -> Self {
        let n = system.dimension();
        let vector = || vec![0.0; n];
        let structure = system.structure();
        let mut differences: Vec<Vec<f64>> = (0..DIFFERENCES).map(|_| vector()).collect();
        differences[0].copy_from_slice(state);
        Self {
            system,
            tolerances,
            instructions: InstructionSet::best(),
            order: 1,
            time,
            previous_time: time,
            step: f64::INFINITY,
            differences,
            // No history: the first step evaluates the rate and its change.
            known: 0,
            steps: [0.0; DIFFERENCES],
            last_order: 1,
            settled: 0,
            starting: true,
            corrector: Corrector::new(&structure),
            predicted: vector(),
            predicted_rate: vector(),
            trial: vector(),
            weights: vector(),
            statistics: Statistics::default(),
        }
    }

    /// Order 1 from the state and its rate; after a restart the step is at most the last one.
    fn start(&mut self, span: f64) {
        let rate = &mut self.corrector.rate;
        self.system.derivative(self.time, &self.differences[0], rate);
        self.statistics.rhs_evaluations += 2;
        let first = initial_step(self.system, self.time, &self.differences[0], rate, &self.tolerances, 1, span);
        self.step = self.step.min(first);
        self.forget();
        self.starting = true;
        self.corrector.factored_for = None;
    }

    #[inline(always)]
    fn predict(&mut self, c: &Coefficients) {
        self.predicted.copy_from_slice(&self.differences[0]);
        self.predicted_rate.fill(0.0);
        for i in 1..=self.order {
            let (value, slope) = (c.scale[i], c.scale[i] * c.rate[i]);
            for ((predicted, rate), difference) in
                self.predicted.iter_mut().zip(&mut self.predicted_rate).zip(&self.differences[i])
            {
                *predicted += value * difference;
                *rate += slope * difference;
            }
        }
    }

    /// Takes the corrected state as the next one and updates the differences.
    #[inline(always)]
    fn accept(&mut self, tried: &Try, c: &Coefficients) {
        let k = self.order;
        let correction = &self.corrector.correction;
        if self.known > k + 1 {
            let (lower, upper) = self.differences.split_at_mut(k + 2);
            for ((next, difference), e) in upper[0].iter_mut().zip(&lower[k + 1]).zip(correction) {
                *next = e - c.scale[k + 1] * difference;
            }
            self.known = k + 3;
        } else {
            self.known = k + 2;
        }
        self.differences[k + 1].copy_from_slice(correction);
        for i in (0..=k).rev() {
            let (lower, upper) = self.differences.split_at_mut(i + 1);
            for (difference, above) in lower[i].iter_mut().zip(&upper[0]) {
                *difference = c.scale[i] * *difference + above;
            }
        }
        self.steps.rotate_right(1);
        self.steps[0] = tried.step;
        self.previous_time = self.time;
        self.time = tried.end;
        self.last_order = k;
        self.statistics.accept(tried.step, tried.cut);
        self.corrector.factor_age += 1;
        self.corrector.current = false;
    }

    /// Takes an accepted try over and plans the next step.
    #[inline(always)]
    fn conclude(&mut self, tried: &Try, error: f64, c: &Coefficients) {
        let (order, next) = self.plan(tried.step, error, c);
        // Growth ends where the error no longer allows both a step of twice the size and the next order.
        self.starting &= order > self.order;
        self.accept(tried, c);
        if order == self.last_order && next == tried.step {
            self.settled += 1;
        } else {
            (self.order, self.settled) = (order, 0);
        }
        self.step = tried.followed_by(next, self.step);
    }

    fn change(&mut self, step: f64, order: usize) {
        (self.step, self.order, self.settled) = (step, order, 0);
    }

    /// Back to order 1 with the rate at the last point; the past no longer counts.
    fn forget(&mut self) {
        self.system.derivative(self.time, &self.differences[0], &mut self.corrector.rate);
        self.statistics.rhs_evaluations += 1;
        for (difference, rate) in self.differences[1].iter_mut().zip(&self.corrector.rate) {
            *difference = self.step * *rate;
        }
        self.steps = [self.step; DIFFERENCES];
        (self.order, self.known, self.settled) = (1, 2, 0);
    }

    /// Fastest rate |λ| of the last Jacobian.
    pub(crate) fn fastest_rate(&self) -> f64 {
        self.corrector.jacobian.fastest_rate(&self.weights)
    }

    /// The entry that the last correction moved most against its tolerance.
    fn worst_component(&self) -> usize {
        largest(self.weights.len(), |i| (self.corrector.correction[i] * self.weights[i]).abs())
    }
}

/// One step, to be compiled for each instruction set.
struct Step<'g, 'a, S: OdeSystem + ?Sized> {
    method: &'g mut Gear<'a, S>,
    limit: f64,
}

impl<S: OdeSystem + ?Sized> Task for Step<'_, '_, S> {
    type Answer = Result<(), IntegrationError>;

    #[inline(always)]
    fn run(self) -> Self::Answer {
        self.method.step_by(self.limit)
    }
}

impl<S: OdeSystem + ?Sized> Gear<'_, S> {
    #[inline(always)]
    fn step_by(&mut self, limit: f64) -> Result<(), IntegrationError> {
        if self.known == 0 {
            self.start(limit - self.time);
        }
        for (weight, allowed) in self.weights.iter_mut().zip(self.tolerances.all_allowed(&self.differences[0])) {
            *weight = 1.0 / (SHARE * allowed);
        }
        let (mut tries, mut too_large) = (0, 0);
        loop {
            let tried = Try::new(self.time, self.step, limit);
            let step = tried.step;
            let c = Coefficients::new(step, &self.steps, self.order);
            self.predict(&c);
            let failure = match self.correct(&tried, &c) {
                Ok(()) => {
                    let error = c.step_error * norm(&self.weights, &self.corrector.correction);
                    if error <= 1.0 {
                        self.conclude(&tried, error, &c);
                        return Ok(());
                    }
                    too_large += 1;
                    self.after_rejection(step, error, too_large, &c);
                    None
                }
                Err(failure) => {
                    self.statistics.newton_failures += 1;
                    if self.corrector.current || self.corrector.factored_for.is_none() {
                        self.change(0.25 * step, self.order);
                        self.starting = false;
                    }
                    // The next try starts from a Jacobian of its own.
                    self.corrector.factored_for = None;
                    self.corrector.current = false;
                    Some(failure)
                }
            };
            self.statistics.rejected_steps += 1;
            tries += 1;
            if is_impossible(tries, self.time, self.step) {
                let component = self.worst_component();
                return Err(match failure {
                    Some(Failure::NotFinite) => IntegrationError::NotFinite { time: self.time, step, component },
                    _ => IntegrationError::StepTooSmall { time: self.time, step: self.step, component },
                });
            }
        }
    }
}

impl<S: OdeSystem + ?Sized> Integrator for Gear<'_, S> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        self.instructions.run(Step { method: self, limit })
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn previous_time(&self) -> f64 {
        self.previous_time
    }

    fn state(&self) -> &[f64] {
        &self.differences[0]
    }

    /// The polynomial through the last states, as many as the order of the last step and one more.
    fn interpolate(&self, time: f64, state: &mut [f64]) {
        state.copy_from_slice(&self.differences[0]);
        if self.time == self.previous_time {
            return;
        }
        let offset = time - self.time;
        // Newton's form: products of (time − t_j)/(t_n − t_{j−1}).
        let (mut product, mut back) = (1.0, 0.0);
        for i in 1..=self.last_order {
            product *= (offset + back) / (back + self.steps[i - 1]);
            back += self.steps[i - 1];
            for (value, difference) in state.iter_mut().zip(&self.differences[i]) {
                *value += product * difference;
            }
        }
    }

    fn restart(&mut self) {
        self.time = self.time.next_up();
        self.known = 0;
    }

    fn statistics(&self) -> Statistics {
        self.statistics
    }

    fn choice(&self) -> Choice {
        Choice { method: Method::Gear, reason: None }
    }
}
