//! Explicit methods of order 4 with fixed steps for small equations of motion q̈ = a(t, q, q̇) that are not stiff: an Adams
//! predictor with one evaluation and one Adams–Moulton correction (PEC), and the classical Runge–Kutta method, which also starts it.
//!
//! Velocities come from the polynomial through the last accelerations integrated once, places from the same polynomial
//! integrated twice: a place that took its velocity as just another rate would halve the longest stable step. Stable up to
//! ω h = 0.7 without damping and 0.4 with a tenth of the critical one. The accelerations come with every step, so that they may be compiled into
//! the caller's loop.

/// Weights of the last four accelerations, latest first, over 24: Adams–Bashforth (Hairer, Nørsett & Wanner, Solving
/// Ordinary Differential Equations I, III.1, (1.5)).
const PREDICT_VELOCITY: [f64; 4] = [55.0, -59.0, 37.0, -9.0];
/// Over 360: ∫₀¹ (1 − s) p(s) ds of the same polynomial p.
const PREDICT_PLACE: [f64; 4] = [323.0, -264.0, 159.0, -38.0];
/// Of the acceleration at the prediction, then of the last three: Adams–Moulton, same source, (1.9).
const CORRECT_VELOCITY: [f64; 4] = [9.0, 19.0, -5.0, 1.0];
const CORRECT_PLACE: [f64; 4] = [38.0, 171.0, -36.0, 7.0];

/// Places and velocities.
pub type Motion<const N: usize> = ([f64; N], [f64; N]);

/// Accelerations q̈ = a(t, q, q̇).
pub trait EquationsOfMotion<const N: usize> {
    fn acceleration(&self, time: f64, motion: &Motion<N>) -> [f64; N];
}

impl<const N: usize, F: Fn(f64, &Motion<N>) -> [f64; N]> EquationsOfMotion<N> for F {
    #[inline(always)]
    fn acceleration(&self, time: f64, motion: &Motion<N>) -> [f64; N] {
        self(time, motion)
    }
}

/// A system on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdamsMoulton<const N: usize> {
    start: f64,
    step: f64,
    steps: u64,
    motion: Motion<N>,
    /// At the last four times, latest first, as far as `known`; taken at the prediction.
    accelerations: [[f64; N]; 4],
    known: usize,
}

impl<const N: usize> AdamsMoulton<N> {
    /// At the start of its way.
    pub fn new(time: f64, motion: Motion<N>, step: f64) -> Self {
        Self { start: time, step, steps: 0, motion, accelerations: [[0.0; N]; 4], known: 0 }
    }

    pub fn time(&self) -> f64 {
        self.start + self.steps as f64 * self.step
    }

    pub fn motion(&self) -> &Motion<N> {
        &self.motion
    }

    /// At `motion()`; 0 before the first step.
    pub fn acceleration(&self) -> &[f64; N] {
        &self.accelerations[0]
    }

    /// Evaluations of the accelerations so far.
    pub fn evaluations(&self) -> u64 {
        // One at the start, and three more in each step by Runge–Kutta.
        self.steps + self.steps.min(1) + 3 * self.steps.min(3)
    }

    /// One step; the first three by Runge–Kutta.
    #[inline(always)]
    pub fn step(&mut self, equations: &impl EquationsOfMotion<N>) {
        if self.known < 4 {
            return self.begin(equations);
        }
        let next = self.start + (self.steps + 1) as f64 * self.step;
        let [a, b, c, d] = self.accelerations;
        let predicted = self.moved(PREDICT_PLACE, PREDICT_VELOCITY, &[a, b, c, d]);
        let there = equations.acceleration(next, &predicted);
        self.motion = self.moved(CORRECT_PLACE, CORRECT_VELOCITY, &[there, a, b, c]);
        self.accelerations = [there, a, b, c];
        self.steps += 1;
    }

    /// A step by Runge–Kutta, for want of a past.
    #[inline(always)]
    fn begin(&mut self, equations: &impl EquationsOfMotion<N>) {
        let time = self.time();
        if self.known == 0 {
            self.accelerations[0] = equations.acceleration(time, &self.motion);
            self.known = 1;
        }
        let [a, b, c, _] = self.accelerations;
        self.motion = runge_kutta(time, &self.motion, &a, self.step, equations);
        self.steps += 1;
        self.known += 1;
        self.accelerations = [equations.acceleration(self.time(), &self.motion), a, b, c];
    }

    #[inline(always)]
    fn moved(&self, place: [f64; 4], velocity: [f64; 4], a: &[[f64; N]; 4]) -> Motion<N> {
        let h = self.step;
        let sum = |w: [f64; 4], i: usize| (w[0] * a[0][i] + w[1] * a[1][i]) + (w[2] * a[2][i] + w[3] * a[3][i]);
        let (q, v) = &self.motion;
        (
            std::array::from_fn(|i| q[i] + h * (v[i] + h / 360.0 * sum(place, i))),
            std::array::from_fn(|i| v[i] + h / 24.0 * sum(velocity, i)),
        )
    }
}

/// One step on by the classical Runge–Kutta method, given the acceleration at its start; evaluates three more.
#[inline(always)]
pub fn runge_kutta<const N: usize>(
    time: f64,
    motion: &Motion<N>,
    acceleration: &[f64; N],
    step: f64,
    equations: &impl EquationsOfMotion<N>,
) -> Motion<N> {
    let f = |time: f64, motion: &Motion<N>| equations.acceleration(time, motion);
    let (q, v) = motion;
    let on = |share: f64, velocity: &[f64; N], acceleration: &[f64; N]| -> Motion<N> {
        let h = share * step;
        (std::array::from_fn(|i| q[i] + h * velocity[i]), std::array::from_fn(|i| v[i] + h * acceleration[i]))
    };
    let two = on(0.5, v, acceleration);
    let a2 = f(time + 0.5 * step, &two);
    let three = on(0.5, &two.1, &a2);
    let a3 = f(time + 0.5 * step, &three);
    let four = on(1.0, &three.1, &a3);
    let a4 = f(time + step, &four);
    let h = step / 6.0;
    (
        std::array::from_fn(|i| q[i] + h * (v[i] + 2.0 * (two.1[i] + three.1[i]) + four.1[i])),
        std::array::from_fn(|i| v[i] + h * (acceleration[i] + 2.0 * (a2[i] + a3[i]) + a4[i])),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A driven, damped pendulum.
    fn pendulum(time: f64, (q, v): &Motion<1>) -> [f64; 1] {
        [-q[0].sin() - 0.1 * v[0] + 0.5 * (1.7 * time).cos()]
    }

    fn adams(steps: u32) -> Motion<1> {
        let evaluations = std::cell::Cell::new(0);
        let mut method = AdamsMoulton::new(0.0, ([1.0], [0.0]), 2.0 / f64::from(steps));
        for _ in 0..steps {
            method.step(&|time: f64, motion: &Motion<1>| {
                evaluations.set(evaluations.get() + 1);
                pendulum(time, motion)
            });
        }
        assert_eq!(evaluations.get(), method.evaluations());
        assert!((method.time() - 2.0).abs() < 1e-14);
        *method.motion()
    }

    fn runge(steps: u32) -> Motion<1> {
        let step = 2.0 / f64::from(steps);
        (0..steps).fold(([1.0], [0.0]), |motion, k| {
            let time = f64::from(k) * step;
            runge_kutta(time, &motion, &pendulum(time, &motion), step, &pendulum)
        })
    }

    #[test]
    fn both_methods_are_of_order_4() {
        let exact = runge(20_000);
        for method in [adams, runge] {
            let error = |steps| {
                let (q, v) = method(steps);
                (q[0] - exact.0[0]).hypot(v[0] - exact.1[0])
            };
            let orders: Vec<f64> = [40, 80, 160].map(|n| (error(n) / error(2 * n)).log2()).to_vec();
            assert!(orders.iter().all(|order| (order - 4.0).abs() < 0.35), "{orders:?}");
        }
    }

    /// Growth of an oscillation over 4000 steps at ω h, damped by a share of the critical damping.
    #[test]
    fn steps_are_stable_up_to_where_it_is_said() {
        for (frequency, damping, stable) in [(0.3, 0.0, true), (0.4, 0.1, true), (0.7, 0.1, false), (1.0, 0.0, false)] {
            let mut method = AdamsMoulton::new(0.0, ([1.0], [0.0]), 1.0);
            for _ in 0..4000 {
                method.step(&|_: f64, (q, v): &Motion<1>| [-frequency * (frequency * q[0] + 2.0 * damping * v[0])]);
            }
            assert_eq!(method.motion().0[0].abs() < 1.2, stable, "ω h = {frequency}, ζ = {damping}");
        }
    }
}
