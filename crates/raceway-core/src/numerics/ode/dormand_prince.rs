//! Dormand–Prince 5(4): explicit, for scenes that are not stiff.
//!
//! Coefficients: J. R. Dormand & P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19–26, table 2;
//! dense output of order 4: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, §II.6.

use super::integrator::{Choice, IntegrationError, Integrator, Statistics};
use super::method::Method;
use super::stability::{self, Stability};
use super::step_size::{StepSizeControl, Try, error_norm, initial_step, is_impossible, stays_broken, worst_component};
use super::structure::{Jacobian, displacements};
use super::system::OdeSystem;
use super::tolerances::Tolerances;

const C: [f64; 5] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0];
const A: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Difference of the weights of order 5 and 4.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Last coefficient of the dense output.
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// The method with its workspace; allocates only on construction.
pub struct DormandPrince<'a, S: OdeSystem + ?Sized> {
    system: &'a S,
    tolerances: Tolerances,
    time: f64,
    state: Vec<f64>,
    /// Start of the last step.
    previous_time: f64,
    previous_state: Vec<f64>,
    /// Slopes of the last step; the first and the last are the derivatives at its ends.
    slopes: [Vec<f64>; 7],
    trial: Vec<f64>,
    error: Vec<f64>,
    /// Size of the next step; infinite until a first one is chosen.
    step: f64,
    /// The next step is the first, or the first after a restart.
    starting: bool,
    fixed: bool,
    control: StepSizeControl,
    statistics: Statistics,
    /// The last slope belongs to `(time, state)`.
    first_same_as_last: bool,
}

impl<'a, S: OdeSystem + ?Sized> DormandPrince<'a, S> {
    /// Starts at `(time, state)`. With `fixed_step` [s] the error is not controlled.
    pub fn new(system: &'a S, time: f64, state: &[f64], tolerances: Tolerances, fixed_step: Option<f64>) -> Self {
        let n = system.dimension();
        let vector = || vec![0.0; n];
        Self {
            system,
            tolerances,
            time,
            state: state.to_vec(),
            previous_time: time,
            previous_state: state.to_vec(),
            slopes: std::array::from_fn(|_| vector()),
            trial: vector(),
            error: vector(),
            step: fixed_step.unwrap_or(f64::INFINITY),
            starting: fixed_step.is_none(),
            fixed: fixed_step.is_some(),
            control: StepSizeControl::new(4),
            statistics: Statistics::default(),
            first_same_as_last: false,
        }
    }

    /// Chooses the first step; after a restart it is at most the last one.
    fn start(&mut self, span: f64) {
        let slope = &mut self.slopes[6];
        self.system.derivative(self.time, &self.state, slope);
        let first = initial_step(self.system, self.time, &self.state, slope, &self.tolerances, 5, span);
        self.first_same_as_last = true;
        self.statistics.rhs_evaluations += 2;
        self.step = self.step.min(first);
        self.starting = false;
    }

    /// Computes slopes, new state (into `trial`) and error estimate of a step from `(time, state)`.
    fn try_step(&mut self, step: f64) {
        let n = self.state.len();
        if self.first_same_as_last {
            self.slopes.swap(0, 6);
        } else {
            self.system.derivative(self.time, &self.state, &mut self.slopes[0]);
            self.statistics.rhs_evaluations += 1;
        }
        self.first_same_as_last = false;
        for stage in 0..6 {
            let (known, rest) = self.slopes.split_at_mut(stage + 1);
            let row = &A[stage];
            for i in 0..n {
                let mut sum = 0.0;
                for (weight, slope) in row.iter().zip(known.iter()) {
                    sum += weight * slope[i];
                }
                self.trial[i] = self.state[i] + step * sum;
            }
            let at = if stage < 5 { self.time + C[stage] * step } else { self.time + step };
            self.system.derivative(at, &self.trial, &mut rest[0]);
        }
        self.statistics.rhs_evaluations += 6;
        for i in 0..n {
            let mut sum = 0.0;
            for (weight, slope) in E.iter().zip(&self.slopes) {
                sum += weight * slope[i];
            }
            self.error[i] = step * sum;
        }
    }

    /// Fastest rate |λ| that the last step has seen: its last two stages sit at the same time.
    pub(crate) fn fastest_rate(&self) -> f64 {
        let step = self.time - self.previous_time;
        let (mut slopes, mut states) = (0.0, 0.0);
        for i in 0..self.state.len() {
            let scale = self.tolerances.allowed(i, self.state[i]);
            let mut between = 0.0;
            for ((last, before), slope) in A[5].iter().zip(&A[4]).zip(&self.slopes) {
                between += (last - before) * slope[i];
            }
            slopes += ((self.slopes[6][i] - self.slopes[5][i]) / scale).powi(2);
            states += (step * between / scale).powi(2);
        }
        if states > 0.0 { (slopes / states).sqrt() } else { 0.0 }
    }

    /// Makes the tried step the last one.
    fn accept(&mut self, tried: &Try) {
        self.previous_time = self.time;
        std::mem::swap(&mut self.previous_state, &mut self.state);
        std::mem::swap(&mut self.state, &mut self.trial);
        self.time = tried.end;
        self.first_same_as_last = true;
        self.statistics.accept(tried.step, tried.cut);
    }
}

impl<S: OdeSystem + ?Sized> Integrator for DormandPrince<'_, S> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        if self.starting {
            self.start(limit - self.time);
        }
        let mut rejections = 0;
        loop {
            let tried = Try::new(self.time, self.step, limit);
            let step = tried.step;
            self.try_step(step);
            let error = error_norm(&self.error, &self.state, &self.trial, &self.tolerances);
            if self.fixed && error.is_finite() || error <= 1.0 {
                if !self.fixed {
                    self.step = tried.followed_by(step * self.control.accepted(error), self.step);
                }
                self.accept(&tried);
                return Ok(());
            }
            // The slope at the start stays valid for the next try.
            self.slopes.swap(0, 6);
            self.first_same_as_last = true;
            self.statistics.rejected_steps += 1;
            rejections += 1;
            let component = worst_component(&self.error, &self.state, &self.trial, &self.tolerances);
            if self.fixed || (!error.is_finite() && stays_broken(rejections)) {
                return Err(IntegrationError::NotFinite { time: self.time, step, component });
            }
            self.step = step * self.control.rejected(error);
            if is_impossible(rejections, self.time, self.step) {
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
        let theta = (time - self.previous_time) / step;
        let rest = 1.0 - theta;
        for (i, value) in state.iter_mut().enumerate() {
            let difference = self.state[i] - self.previous_state[i];
            let start = step * self.slopes[0][i] - difference;
            let end = difference - step * self.slopes[6][i] - start;
            let mut last = 0.0;
            for (weight, slope) in D.iter().zip(&self.slopes) {
                last += weight * slope[i];
            }
            *value =
                self.previous_state[i] + theta * (difference + rest * (start + theta * (end + rest * step * last)));
        }
    }

    fn restart(&mut self) {
        self.time = self.time.next_up();
        self.first_same_as_last = false;
        if !self.fixed {
            self.control = StepSizeControl::new(4);
            self.starting = true;
        }
    }

    fn statistics(&self) -> Statistics {
        self.statistics
    }

    fn choice(&self) -> Choice {
        Choice { method: Method::DormandPrince, reason: None }
    }

    /// The faster of what the last two stages and what a Jacobian show: where saturation bounds an unstable motion, the
    /// stages see no more than the limit itself.
    fn stability(&mut self) -> Option<Stability> {
        if self.statistics.steps == 0 {
            return None;
        }
        let (state, rate) = (&self.state, &self.slopes[6]);
        let mut displacement = vec![0.0; state.len()];
        let mut jacobian = Jacobian::new(&self.system.structure());
        displacements(state, rate, &self.tolerances, self.time - self.previous_time, &mut displacement);
        self.statistics.rhs_evaluations += self.system.jacobian(self.time, state, rate, &displacement, &mut jacobian);
        self.statistics.jacobian_evaluations += 1;
        let weights: Vec<f64> = (0..state.len()).map(|i| 1.0 / self.tolerances.allowed(i, state[i])).collect();
        let rate = jacobian.fastest_rate(&weights).max(self.fastest_rate());
        Some(Stability { rate, limit: stability::DORMAND_PRINCE })
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_problems::{Kepler, START};
    use super::*;

    fn fixed(steps: u32) -> (f64, f64) {
        let period = std::f64::consts::TAU;
        let step = period / f64::from(steps);
        let mut method = DormandPrince::new(&Kepler, 0.0, &START, Tolerances::uniform(4, 1e-9, 1e-9), Some(step));
        let mut between: f64 = 0.0;
        let mut middle = [0.0; 4];
        while method.time() < period {
            method.step(period).unwrap();
            // Energy and angular momentum at the middle of the step, from the dense output.
            method.interpolate(0.5 * (method.time() + method.previous_time()), &mut middle);
            let momentum = middle[0] * middle[3] - middle[1] * middle[2];
            between = between.max((momentum - START[0] * START[3]).abs());
        }
        let error: f64 = method.state().iter().zip(START).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        (error, between)
    }

    /// Pins the order: halving the step divides the end error by 2⁵, the dense error by at least 2⁴.
    #[test]
    fn observed_order_is_five_and_four_between_steps() {
        let (coarse, fine) = (fixed(800), fixed(1600));
        let order = (coarse.0 / fine.0).log2();
        assert!((order - 5.0).abs() < 0.2, "end point: order {order}");
        let dense = (coarse.1 / fine.1).log2();
        assert!(dense > 3.8, "between steps: order {dense}");
    }

    #[test]
    fn error_falls_with_the_tolerance() {
        let mut last = f64::INFINITY;
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let mut method =
                DormandPrince::new(&Kepler, 0.0, &START, Tolerances::uniform(4, tolerance, tolerance), None);
            while method.time() < std::f64::consts::TAU {
                method.step(std::f64::consts::TAU).unwrap();
            }
            let error = (method.state()[1] - START[1]).abs();
            assert!(error < 200.0 * tolerance && error < last, "{tolerance:e}: {error:e}");
            last = error;
            assert_eq!(method.time(), std::f64::consts::TAU);
        }
    }
}
