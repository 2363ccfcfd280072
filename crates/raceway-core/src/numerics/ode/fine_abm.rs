//! Precise integration with exponential Adams–Bashforth–Moulton of order 4: the second solver of the article.
//!
//! `ẏ = H y + f(t, y)`. `H` is integrated exactly (W. X. Zhong's precise integration, `phi`), `f` by the cubic through its last
//! values, with weights that are matrices (A. Nørsett, Lect. Notes Math. 109 (1969) 214–219; M. Hochbruck & A. Ostermann, Acta
//! Numerica 19 (2010) 209–286, §2.5). On backward differences of `f` the predictor has the weights φ₁, φ₂, φ₃ + φ₂/2,
//! φ₄ + φ₃ + φ₂/3, the corrector φ₁, φ₂ − φ₁, φ₃ − φ₂/2, φ₄ − φ₂/6; `H = 0` gives the classical pair. Both cubics agree at the
//! last three points, so that the corrector is the predictor plus `h (φ₄ + φ₃ + φ₂/3) ∇⁴f`, which is how it is applied.
//!
//! The grid is uniform; steps are halved and doubled. The first points, and the way to a limit between two points of the grid,
//! are walked by Dormand–Prince at the same tolerance.

mod diagonal;
mod linear_part;
mod past;
mod renewal;
#[cfg(test)]
mod tests;
mod weights;

use self::diagonal::Diagonal;
pub use self::linear_part::LinearPart;
use self::linear_part::Renewal;
use self::past::{MAX_KEPT, MIN_KEPT, Past};
use self::weights::Weights;
use super::dormand_prince::DormandPrince;
use super::integrator::{Choice, IntegrationError, Integrator, Statistics};
use super::method::Method;
use super::stability::{self, Stability};
use super::step_size::{error_norm, is_impossible, stays_broken, worst_component};
use super::structure::{Jacobian, Structure};
use super::system::OdeSystem;
use super::tolerances::Tolerances;

/// Error of the corrector over corrector minus predictor (W. E. Milne), at `H = 0`; less where `H` dominates.
const MILNE: f64 = 19.0 / 270.0;
/// Error norm below which the step is doubled: 2⁻⁵ for the order and half the tolerance.
const DOUBLING_ERROR: f64 = 1.0 / 64.0;
/// Largest `h |∂f/∂y|`, as corrector and predictor show it, at which the step is doubled: the method is stable to 1.28.
const DOUBLING_RATE: f64 = 0.5;
/// That at which it is halved where blocks went out of date, before an instability shows in the error.
const HALVING_RATE: f64 = 1.0;
/// Error norm of a correction too small to tell `∂f/∂y`.
const TELLING: f64 = 1e-3;
/// Steps after a rejection without doubling.
const PAUSE: u64 = 16;
/// Tolerances by which an interpolation by rates may differ from one by states alone.
const INTERPOLATION: f64 = 30.0;

/// The method with its past; allocates on construction, on a renewal of the linear part, and where it starts.
pub struct FineAbm<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    tolerances: Tolerances,
    structure: Structure,
    part: LinearPart,
    linear: Diagonal,
    /// Weights of the step lengths used since the linear part was renewed.
    weights: Vec<Weights>,
    /// Newest point of the grid.
    grid_time: f64,
    /// Length of the next step; 0: not known yet.
    step: f64,
    fixed: bool,
    past: Past,
    /// dy/dt at the newest point and the one before.
    rate: Vec<f64>,
    previous_rate: Vec<f64>,
    differences: [Vec<f64>; 3],
    predicted: Vec<f64>,
    corrected: Vec<f64>,
    correction: Vec<f64>,
    trial_rate: Vec<f64>,
    trial_rest: Vec<f64>,
    zero: Vec<f64>,
    /// One-step method on its way to the next point of the grid.
    walker: Option<DormandPrince<'a, S>>,
    previous_time: f64,
    jacobian: Jacobian,
    displacement: Vec<f64>,
    renewal: Renewal,
    /// Steps before the next doubling.
    wait: u64,
    /// The next step is to be twice as long.
    double: bool,
    /// The last measured `h |∂f/∂y|`.
    rate_of_rest: f64,
    /// Work apart from that of the present walker.
    statistics: Statistics,
}

impl<'a, S: OdeSystem + ?Sized> FineAbm<'a, S> {
    /// Starts at `(time, state)`. With `fixed_step` [s] the error is not controlled.
    pub fn new(
        system: &'a S,
        time: f64,
        state: &[f64],
        tolerances: Tolerances,
        fixed_step: Option<f64>,
        part: LinearPart,
    ) -> Self {
        let n = system.dimension();
        let structure = system.structure();
        let vector = || vec![0.0; n];
        let mut linear = Diagonal::pairs(&structure);
        if part == LinearPart::Blocks {
            linear.blocks.iter_mut().chain([&mut linear.corner]).for_each(|matrix| matrix.fill(0.0));
        }
        let mut method = Self {
            system,
            tolerances,
            part,
            linear,
            weights: Vec::new(),
            grid_time: time,
            step: fixed_step.unwrap_or(0.0),
            fixed: fixed_step.is_some(),
            past: Past::new(n),
            rate: vector(),
            previous_rate: vector(),
            differences: std::array::from_fn(|_| vector()),
            predicted: vector(),
            corrected: state.to_vec(),
            correction: vector(),
            trial_rate: vector(),
            trial_rest: vector(),
            zero: vector(),
            walker: None,
            previous_time: time,
            jacobian: Jacobian::new(&structure),
            structure,
            displacement: vector(),
            renewal: Renewal::new(),
            wait: 0,
            double: false,
            rate_of_rest: 0.0,
            statistics: Statistics::default(),
        };
        method.begin(time);
        method
    }

    /// Starts afresh from `corrected` at `time`.
    fn begin(&mut self, time: f64) {
        self.past.kept = 0;
        self.renewal = Renewal::new();
        (self.wait, self.double, self.rate_of_rest) = (0, false, 0.0);
        self.weights.clear();
        self.grid_time = time;
        self.system.derivative(time, &self.corrected, &mut self.trial_rate);
        self.statistics.rhs_evaluations += 1;
        self.keep_corrected();
        self.walk();
    }

    /// Sets the one-step method on its way from the newest point.
    fn walk(&mut self) {
        self.dismiss_walker();
        self.walker =
            Some(DormandPrince::new(self.system, self.grid_time, self.past.state(), self.tolerances.clone(), None));
    }

    fn dismiss_walker(&mut self) {
        self.statistics = self.statistics();
        self.walker = None;
    }

    /// Makes `corrected` with its `trial_rate` the newest point.
    fn keep_corrected(&mut self) {
        std::mem::swap(&mut self.previous_rate, &mut self.rate);
        std::mem::swap(&mut self.rate, &mut self.trial_rate);
        let (state, rest) = self.past.advance();
        state.copy_from_slice(&self.corrected);
        rest.copy_from_slice(&self.rate);
        self.linear.add_product(-1.0, state, rest, &self.structure);
    }

    /// One step of the one-step method, to the next point of the grid at the latest.
    fn walk_on(&mut self, limit: f64) -> Result<(), IntegrationError> {
        let Some(walker) = &mut self.walker else { return Ok(()) };
        let next = if self.step > 0.0 { self.grid_time + self.step } else { f64::INFINITY };
        walker.step(limit.min(next))?;
        self.previous_time = walker.previous_time();
        let time = walker.time();
        if self.step > 0.0 && time < next {
            return Ok(());
        }
        if self.step == 0.0 {
            // Its first step sets the scale. The grid begins here.
            self.step = 0.5 * (time - self.previous_time);
            self.past.kept = 0;
        }
        self.corrected.copy_from_slice(walker.state());
        self.grid_time = time;
        self.system.derivative(time, &self.corrected, &mut self.trial_rate);
        self.statistics.rhs_evaluations += 1;
        self.keep_corrected();
        Ok(())
    }

    /// Predicts, evaluates and corrects into `corrected` and `correction`; returns the norm of the error.
    fn try_step(&mut self) -> f64 {
        let index = self.prepare_weights();
        let of_differences = &self.weights[index].of_differences;
        let [newest, second, third, fourth] = &self.past.rests[..4] else { return f64::NAN };
        for i in 0..newest.len() {
            let (one, two, three) = (newest[i] - second[i], second[i] - third[i], third[i] - fourth[i]);
            self.differences[0][i] = one;
            self.differences[1][i] = one - two;
            self.differences[2][i] = one - 2.0 * two + three;
        }
        self.correction.fill(0.0);
        of_differences[0].add_product(1.0, &self.rate, &mut self.correction, &self.structure);
        for (weights, difference) in of_differences[1..].iter().zip(&self.differences) {
            weights.add_product(1.0, difference, &mut self.correction, &self.structure);
        }
        for (i, predicted) in self.predicted.iter_mut().enumerate() {
            *predicted = self.past.states[0][i] + self.correction[i];
        }
        let end = self.grid_time + self.step;
        self.system.derivative(end, &self.predicted, &mut self.trial_rest);
        self.statistics.rhs_evaluations += 1;
        self.linear.add_product(-1.0, &self.predicted, &mut self.trial_rest, &self.structure);
        // The fourth difference, which the predictor leaves out.
        let [one, two, three] = &mut self.differences;
        for i in 0..one.len() {
            one[i] = self.trial_rest[i] - (self.past.rests[0][i] + one[i] + two[i] + three[i]);
        }
        self.correction.fill(0.0);
        of_differences[3].add_product(1.0, one, &mut self.correction, &self.structure);
        for (i, corrected) in self.corrected.iter_mut().enumerate() {
            *corrected = self.predicted[i] + self.correction[i];
        }
        let error = MILNE * error_norm(&self.correction, self.past.state(), &self.corrected, &self.tolerances);
        if self.corrected.iter().all(|x| x.is_finite()) { error } else { f64::NAN }
    }

    /// Makes the tried step the last one.
    fn accept(&mut self, error: f64, end: f64) {
        self.system.derivative(end, &self.corrected, &mut self.trial_rate);
        self.statistics.rhs_evaluations += 1;
        self.previous_time = self.grid_time;
        self.grid_time = end;
        self.keep_corrected();
        self.statistics.accept(self.step, false);
        self.renewal.age += 1;
        self.wait = self.wait.saturating_sub(1);
        if error >= TELLING {
            // Change of f over change of the state between prediction and correction.
            for (moved, at_end) in self.trial_rest.iter_mut().zip(&self.past.rests[0]) {
                *moved = at_end - *moved;
            }
            let size = |vector: &[f64]| error_norm(vector, self.past.state(), &self.zero, &self.tolerances);
            self.rate_of_rest = self.step * size(&self.trial_rest) / size(&self.correction);
        }
        self.renew_where_outdated();
        self.plan_doubling(error);
    }

    /// Doubles the step where that is accurate and stable; only before the next one: until then the last may be interpolated.
    fn plan_doubling(&mut self, error: f64) {
        let accurate = error < DOUBLING_ERROR && self.past.kept == MAX_KEPT && self.wait == 0;
        self.double = !self.fixed && accurate && (error < TELLING || self.rate_of_rest < DOUBLING_RATE);
    }

    fn double_step(&mut self) {
        self.double = false;
        self.step *= 2.0;
        self.past.double_step();
        self.rate_of_rest *= 2.0;
    }

    fn halve_step(&mut self) {
        self.wait = PAUSE;
        self.step *= 0.5;
        self.past.halve_step();
        self.rate_of_rest *= 0.5;
    }
}

impl<S: OdeSystem + ?Sized> Integrator for FineAbm<'_, S> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        let arrived = self.past.kept >= MIN_KEPT && self.time() == self.grid_time;
        if self.walker.is_some() && arrived {
            self.dismiss_walker();
        }
        if std::mem::take(&mut self.double) {
            self.double_step();
        }
        // A step that ends a rounding from the limit ends there.
        let slack = 1e-9 * self.step;
        if self.walker.is_none() && self.grid_time + self.step > limit + slack {
            self.walk();
        }
        if self.walker.is_some() {
            return self.walk_on(limit);
        }
        let mut rejections = 0;
        if !self.fixed && self.part == LinearPart::Blocks && self.rate_of_rest > HALVING_RATE {
            self.halve_step();
        }
        loop {
            let error = self.try_step();
            if error <= 1.0 || self.fixed && error.is_finite() {
                let end = self.grid_time + self.step;
                self.accept(error, if (end - limit).abs() <= slack { limit } else { end });
                return Ok(());
            }
            self.statistics.rejected_steps += 1;
            rejections += 1;
            let (time, step) = (self.grid_time, self.step);
            let component = worst_component(&self.correction, self.past.state(), &self.corrected, &self.tolerances);
            if self.fixed || (!error.is_finite() && stays_broken(rejections)) {
                return Err(IntegrationError::NotFinite { time, step, component });
            }
            if is_impossible(rejections, time, step) {
                return Err(IntegrationError::StepTooSmall { time, step, component });
            }
            self.halve_step();
        }
    }

    fn time(&self) -> f64 {
        self.walker.as_ref().map_or(self.grid_time, |walker| walker.time())
    }

    fn previous_time(&self) -> f64 {
        self.previous_time
    }

    fn state(&self) -> &[f64] {
        self.walker.as_ref().map_or(self.past.state(), |walker| walker.state())
    }

    /// The quartic with values and rates at both ends and the value a step before.
    fn interpolate(&self, time: f64, state: &mut [f64]) {
        if let Some(walker) = &self.walker {
            return walker.interpolate(time, state);
        }
        let step = self.grid_time - self.previous_time;
        let x = (time - self.previous_time) / step;
        let rest = 1.0 - x;
        // Quartic term that the value a step before adds to Hermite's cubic.
        let quartic = 0.25 * (x * rest).powi(2);
        let (end, start, before) =
            (x * x * (1.0 + 2.0 * rest) - 5.0 * quartic, rest * rest * (1.0 + 2.0 * x) + 4.0 * quartic, quartic);
        let (end_rate, start_rate) = (step * (2.0 * quartic - x * x * rest), step * (x * rest * rest + 4.0 * quartic));
        // The same from five states: that of a component so stiff that its rates say nothing about the step.
        let weights: [f64; MIN_KEPT] = std::array::from_fn(|k| {
            let others = (0..MIN_KEPT).filter(|&j| j != k);
            others.map(|j| (x - 1.0 + j as f64) / (j as f64 - k as f64)).product()
        });
        for (i, value) in state.iter_mut().enumerate() {
            let by_states: f64 = weights.iter().zip(&self.past.states).map(|(weight, state)| weight * state[i]).sum();
            *value = end * self.past.states[0][i]
                + start * self.past.states[1][i]
                + before * self.past.states[2][i]
                + end_rate * self.rate[i]
                + start_rate * self.previous_rate[i];
            let off = (*value - by_states).abs();
            let most = INTERPOLATION * self.tolerances.allowed(i, self.past.states[0][i]);
            if !self.fixed && (off.is_nan() || off > most) {
                *value = by_states;
            }
        }
    }

    fn restart(&mut self) {
        let time = self.time().next_up();
        let state = self.state().to_vec();
        self.corrected.copy_from_slice(&state);
        if !self.fixed {
            self.step = 0.0;
        }
        self.begin(time);
    }

    fn statistics(&self) -> Statistics {
        self.walker.as_ref().map_or(self.statistics, |walker| self.statistics.and(&walker.statistics()))
    }

    fn choice(&self) -> Choice {
        Choice { method: Method::FineAbm, reason: None }
    }

    /// Stability of the part that is not integrated exactly.
    fn stability(&mut self) -> Option<Stability> {
        let steps = self.walker.is_none() && self.step > 0.0;
        steps.then(|| Stability { rate: self.rate_of_rest / self.step, limit: stability::FINE_ABM })
    }
}
