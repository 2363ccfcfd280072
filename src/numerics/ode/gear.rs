//! Gear's method: backward differentiation of variable step and order 1–5, predictor and corrector.
//!
//! Variable coefficients on modified divided differences with a fixed leading coefficient (K. R. Jackson &
//! R. Sacks-Davis, ACM Trans. Math. Softw. 6 (1980) 295–318; K. E. Brenan, S. L. Campbell & L. R. Petzold, *Numerical Solution
//! of Initial-Value Problems in Differential-Algebraic Equations*, §5.2): step and order may change at every step, as they
//! must where balls enter and leave the loaded zone. The corrector is solved by Newton's iteration on factors of `c·I − J`
//! that are kept as long as they serve.

use super::arrowhead::ArrowheadFactors;
use super::step_size::{Try, initial_step, is_impossible, largest};
use super::structure::{Jacobian, displacements};
use super::{Choice, IntegrationError, Integrator, Method, OdeSystem, Statistics, Tolerances};

/// Highest order with a useful sector of stability.
pub const MOST_ORDER: usize = 5;
/// Differences kept: the state, as many as the order, and two to judge the next higher order.
const DIFFERENCES: usize = MOST_ORDER + 3;

/// A step may err by this share of the tolerance: errors add up along the way, and the end should be near what was asked.
const SHARE: f64 = 0.25;
/// Corrector iterations a step.
const MOST_ITERATIONS: u32 = 4;
/// Error that the corrector may leave, as a share of that of a step.
const CORRECTOR_ERROR: f64 = 0.05;
/// A factor made for another leading coefficient serves while that is off by less than this share.
const COEFFICIENT_DRIFT: f64 = 0.3;
/// Steps after which a factor, with its Jacobian when that has cost as much as a new one, is made anew.
const FACTOR_AGE: u32 = 20;
/// The error of the next step is aimed at this share of what it may be: at the same, the next lower and the next higher order.
/// High orders are favoured: their steps cost the same, and err less than they are estimated to.
const AIM: [f64; 3] = [1.0 / 4.0, 1.0 / 4.0, 1.0 / 2.0];
/// A step must gain this much to grow, so that differences and factors are not upset for little.
const LEAST_GAIN: f64 = 1.2;
const LARGEST_GAIN: f64 = 4.0;
/// Error-test failures of one step after which its past is distrusted.
const DISTRUST: u32 = 3;

/// The method with its workspace; allocates only on construction.
pub struct Gear<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    tolerances: Tolerances,
    order: usize,
    time: f64,
    previous_time: f64,
    /// Size of the next step.
    step: f64,
    /// Modified divided differences at `time`: the first is the state.
    differences: Vec<Vec<f64>>,
    /// So many of them are backed by steps.
    known: usize,
    /// Sizes of the last steps, the latest first.
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
    /// 1 over what each entry may err by in a step.
    weights: Vec<f64>,
    statistics: Statistics,
}

/// Newton's iteration: its matrix and how well that does.
struct Corrector {
    jacobian: Jacobian,
    factors: ArrowheadFactors<f64>,
    /// Leading coefficient that the factors were made for; `None` before the first.
    factored_for: Option<f64>,
    /// Steps since the factors were made.
    factor_age: u32,
    /// The Jacobian belongs to the step being tried.
    current: bool,
    /// Evaluations that the Jacobian took, and iterations beyond one a step since.
    jacobian_cost: u64,
    excess: u64,
    contraction: f64,
    /// Corrector less predictor.
    correction: Vec<f64>,
    increment: Vec<f64>,
    rate: Vec<f64>,
    displacement: Vec<f64>,
}

/// Coefficients of one step of a given size and order.
struct Coefficients {
    /// Scales the differences to the new step.
    scale: [f64; DIFFERENCES],
    /// Weights of the scaled differences in the predicted rate.
    rate: [f64; DIFFERENCES],
    /// Error of order q from the scaled difference q + 1.
    error: [f64; DIFFERENCES],
    /// c: the corrector's rate is the predicted one and c times the correction.
    leading: f64,
    /// Error of the step from the norm of the correction.
    step_error: f64,
}

/// Why a try failed.
enum Failure {
    /// The iteration did not converge.
    Corrector,
    /// The right-hand side or its Jacobian is not finite.
    NotFinite,
}

impl Coefficients {
    /// `steps`: sizes of the past steps, the latest first.
    fn new(step: f64, steps: &[f64; DIFFERENCES], order: usize) -> Self {
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

impl<'a, S: OdeSystem + ?Sized> Gear<'a, S> {
    /// Starts at `(time, state)` with order 1.
    pub fn new(system: &'a S, time: f64, state: &[f64], tolerances: Tolerances) -> Self {
        let n = system.dimension();
        let vector = || vec![0.0; n];
        let structure = system.structure();
        let mut differences: Vec<Vec<f64>> = (0..DIFFERENCES).map(|_| vector()).collect();
        differences[0].copy_from_slice(state);
        Self {
            system,
            tolerances,
            order: 1,
            time,
            previous_time: time,
            step: f64::INFINITY,
            differences,
            // Nothing yet: the first step begins by looking around.
            known: 0,
            steps: [0.0; DIFFERENCES],
            last_order: 1,
            settled: 0,
            starting: true,
            corrector: Corrector {
                jacobian: Jacobian::new(&structure),
                factors: ArrowheadFactors::new(&structure),
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
            },
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

    fn norm(&self, vector: impl Iterator<Item = f64>) -> f64 {
        norm(&self.weights, vector)
    }

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

    /// Solves for the correction at the end of a step, from the predictor on.
    fn correct(&mut self, tried: &Try, c: &Coefficients) -> Result<(), Failure> {
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
            for (i, increment) in corrector.increment.iter_mut().enumerate() {
                *increment = corrector.rate[i] - self.predicted_rate[i] - c.leading * corrector.correction[i];
            }
            corrector.factors.solve(&mut corrector.increment);
            // Between the limits of a slow and of a stiff component, for factors of another coefficient.
            let mend = 2.0 / (1.0 + c.leading / corrector.factored_for.unwrap_or(c.leading));
            for (i, increment) in corrector.increment.iter_mut().enumerate() {
                *increment *= mend;
                corrector.correction[i] += *increment;
                self.trial[i] = self.predicted[i] + corrector.correction[i];
            }
            let size = norm(&self.weights, corrector.increment.iter().copied());
            if iteration > 0 {
                corrector.contraction = (0.3 * corrector.contraction).max(size / last);
            }
            if size * corrector.contraction.min(1.0) * c.step_error <= CORRECTOR_ERROR {
                return Ok(());
            }
            let rounding = 16.0 * f64::EPSILON * norm(&self.weights, self.trial.iter().copied());
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

    /// Takes the corrected state as the next one and updates the differences.
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

    /// Order and size of the next step, seen from an accepted try that is not yet taken over.
    fn plan(&self, step: f64, error: f64, c: &Coefficients) -> (usize, f64) {
        let k = self.order;
        let same = gain(error, k, AIM[0]);
        let lower = self.gain_lower(c);
        if self.starting && k < MOST_ORDER && same > 1.0 && same > lower {
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
        if k < MOST_ORDER && self.known > k + 1 {
            let scale = c.scale[k + 1];
            let correction = &self.corrector.correction;
            let higher = self.norm(correction.iter().zip(&self.differences[k + 1]).map(|(e, d)| e - scale * d));
            let higher = gain(c.error[k + 1] * higher, k + 1, AIM[2]);
            if higher > best {
                (best, order) = (higher, k + 1);
            }
        }
        if best >= LEAST_GAIN {
            (order, step * best.min(LARGEST_GAIN))
        } else if failing || order < k {
            (order, step * best.clamp(0.5, 0.9))
        } else {
            (k, step)
        }
    }

    /// Takes an accepted try over and plans the next step.
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

    /// Factor that the step may grow by at the next lower order; 0 at order 1.
    fn gain_lower(&self, c: &Coefficients) -> f64 {
        let k = self.order;
        if k == 1 {
            return 0.0;
        }
        let scale = c.scale[k];
        let correction = &self.corrector.correction;
        let lower = self.norm(correction.iter().zip(&self.differences[k]).map(|(e, d)| e + scale * d));
        gain(c.error[k - 1] * lower, k - 1, AIM[1])
    }

    /// Fastest rate |λ| of the last Jacobian.
    pub fn fastest_rate(&self) -> f64 {
        self.corrector.jacobian.fastest_rate(&self.weights)
    }

    /// The entry that the last correction moved most against its tolerance.
    fn worst_component(&self) -> usize {
        largest(self.weights.len(), |i| (self.corrector.correction[i] * self.weights[i]).abs())
    }

    /// What to do after a try whose error was too large.
    fn after_rejection(&mut self, step: f64, error: f64, failures: u32, c: &Coefficients) {
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
}

impl Corrector {
    /// Sees to it that factors fit for the leading coefficient exist.
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

/// Weighted root mean square.
fn norm(weights: &[f64], vector: impl Iterator<Item = f64>) -> f64 {
    let sum: f64 = vector.zip(weights).map(|(x, w)| (x * w) * (x * w)).sum();
    (sum / weights.len().max(1) as f64).sqrt()
}

/// Factor on the step that brings an error of order `order` to `aim` tolerances.
fn gain(error: f64, order: usize, aim: f64) -> f64 {
    (aim / error.max(1e-10)).powf(1.0 / (order as f64 + 1.0))
}

impl<S: OdeSystem + ?Sized> Integrator for Gear<'_, S> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        if self.known == 0 {
            self.start(limit - self.time);
        }
        for (i, weight) in self.weights.iter_mut().enumerate() {
            *weight = 1.0 / (SHARE * self.tolerances.allowed(i, self.differences[0][i]));
        }
        let (mut tries, mut too_large) = (0, 0);
        loop {
            let tried = Try::new(self.time, self.step, limit);
            let step = tried.step;
            let c = Coefficients::new(step, &self.steps, self.order);
            self.predict(&c);
            let failure = match self.correct(&tried, &c) {
                Ok(()) => {
                    let error = c.step_error * self.norm(self.corrector.correction.iter().copied());
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
        self.known = 0;
    }

    fn statistics(&self) -> Statistics {
        self.statistics
    }

    fn choice(&self) -> Choice {
        Choice { method: Method::Gear, reason: None }
    }
}

#[cfg(test)]
mod tests;
