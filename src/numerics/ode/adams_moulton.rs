//! The implicit method of Adams and Moulton, order 4, with fixed steps for equations of motion M q̈ = f(t, q, q̇) in a plane
//! that are not stiff; the classical Runge–Kutta method starts it.
//!
//! The new acceleration is predicted by the cubic through the last four, with it place and velocity (which makes them those of
//! Adams and Bashforth), and one step of Newton's method solves the implicit equation: one evaluation a step. Velocities come from the polynomial through the accelerations integrated once, places from the same
//! polynomial integrated twice: a place that took its velocity as just another rate would halve the longest stable step. The
//! equations come with every step, so that they may be compiled into the caller's loop.
//!
//! Stable up to ω h = 0.35 without damping and 1.8 with a tenth of the critical one, where the slope is right.

/// Weights of the accelerations at the end of a step and at the last three times, latest first, over 24: Adams–Moulton
/// (Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, III.1, (1.9)).
const VELOCITY: [f64; 4] = [9.0, 19.0, -5.0, 1.0];
/// Over 360: ∫₀¹ (1 − s) p(s) ds of the same polynomial p.
const PLACE: [f64; 4] = [38.0, 171.0, -36.0, 7.0];

/// Places and velocities.
pub type Motion<const N: usize> = ([f64; N], [f64; N]);

/// A symmetric matrix: yy, yz, zz.
pub type Symmetric = [f64; 3];

/// What the end of a step depends on of the acceleration there: share of the acceleration in the place and in the velocity.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shares {
    pub place: f64,
    pub velocity: f64,
}

/// Equations about a motion whose acceleration is taken to be a: f − M a, and the slope of M a − f over a where places and
/// velocities go along by their shares, M + (share of the place) ∂f/∂q + (share of the velocity) ∂f/∂q̇ with their signs turned.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Defect {
    pub force: [f64; 2],
    pub slope: Symmetric,
}

impl Defect {
    /// Of two parts of the equations together.
    #[inline(always)]
    pub fn and(&self, other: &Self) -> Self {
        let ([a, b], [c, d, e]) = (other.force, other.slope);
        Self {
            force: [self.force[0] + a, self.force[1] + b],
            slope: [self.slope[0] + c, self.slope[1] + d, self.slope[2] + e],
        }
    }
}

/// M q̈ = f(t, q, q̇). The slope may be rough: it only puts right what was predicted.
pub trait EquationsOfMotion {
    fn defect(&self, time: f64, motion: &Motion<2>, acceleration: [f64; 2], shares: Shares) -> Defect;

    /// q̈ at a motion.
    #[inline(always)]
    fn acceleration(&self, time: f64, motion: &Motion<2>) -> [f64; 2] {
        solve(&self.defect(time, motion, [0.0; 2], Shares::default()))
    }
}

/// Change of the acceleration that takes the defect away.
#[inline(always)]
pub fn solve(Defect { force: [y, z], slope: [yy, yz, zz] }: &Defect) -> [f64; 2] {
    let per_determinant = 1.0 / (yy * zz - yz * yz);
    [(zz * y - yz * z) * per_determinant, (yy * z - yz * y) * per_determinant]
}

/// A system on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdamsMoulton {
    start: f64,
    step: f64,
    steps: u64,
    motion: Motion<2>,
    /// At the last four times, latest first, as far as `known`.
    accelerations: [[f64; 2]; 4],
    known: usize,
}

impl AdamsMoulton {
    /// At the start of its way.
    pub fn new(time: f64, motion: Motion<2>, step: f64) -> Self {
        Self { start: time, step, steps: 0, motion, accelerations: [[0.0; 2]; 4], known: 0 }
    }

    pub fn time(&self) -> f64 {
        self.start + self.steps as f64 * self.step
    }

    pub fn motion(&self) -> &Motion<2> {
        &self.motion
    }

    /// At `motion()`; 0 before the first step.
    pub fn acceleration(&self) -> &[f64; 2] {
        &self.accelerations[0]
    }

    /// Evaluations of the equations so far.
    pub fn evaluations(&self) -> u64 {
        // One at the start, and three more in each step by Runge–Kutta.
        self.steps + self.steps.min(1) + 3 * self.steps.min(3)
    }

    /// One step; the first three by Runge–Kutta.
    #[inline(always)]
    pub fn step(&mut self, equations: &impl EquationsOfMotion) {
        if self.known < 4 {
            return self.begin(equations);
        }
        self.steps += 1;
        let [a, b, c, d] = self.accelerations;
        let h = self.step;
        let shares = Shares { place: h * h / 360.0 * PLACE[0], velocity: h / 24.0 * VELOCITY[0] };
        // The latest acceleration comes last: it is what the step waits for.
        let ahead = |i: usize| 4.0 * a[i] - (6.0 * b[i] - (4.0 * c[i] - d[i]));
        let sum = |w: &[f64; 4], new: f64, i: usize| w[1] * a[i] + (w[2] * b[i] + w[3] * c[i]) + w[0] * new;
        let (q, v) = self.motion;
        let place = |new: f64, i: usize| (q[i] + h * v[i]) + (h * h / 360.0) * sum(&PLACE, new, i);
        let velocity = |new: f64, i: usize| v[i] + (h / 24.0) * sum(&VELOCITY, new, i);
        let new = [ahead(0), ahead(1)];
        let (q, v) = ([place(new[0], 0), place(new[1], 1)], [velocity(new[0], 0), velocity(new[1], 1)]);
        let [y, z] = solve(&equations.defect(self.time(), &(q, v), new, shares));
        self.motion = (
            [q[0] + shares.place * y, q[1] + shares.place * z],
            [v[0] + shares.velocity * y, v[1] + shares.velocity * z],
        );
        self.accelerations = [[new[0] + y, new[1] + z], a, b, c];
    }

    /// A step by Runge–Kutta, for want of a past.
    #[inline(always)]
    fn begin(&mut self, equations: &impl EquationsOfMotion) {
        let time = self.time();
        let acceleration = |time: f64, motion: &Motion<2>| equations.acceleration(time, motion);
        if self.known == 0 {
            self.accelerations[0] = acceleration(time, &self.motion);
            self.known = 1;
        }
        let [a, b, c, _] = self.accelerations;
        self.motion = runge_kutta(time, &self.motion, &a, self.step, acceleration);
        self.steps += 1;
        self.known += 1;
        self.accelerations = [acceleration(self.time(), &self.motion), a, b, c];
    }
}

/// One step on by the classical Runge–Kutta method, given the acceleration at its start; evaluates three more.
#[inline(always)]
pub fn runge_kutta<const N: usize>(
    time: f64,
    motion: &Motion<N>,
    acceleration: &[f64; N],
    step: f64,
    f: impl Fn(f64, &Motion<N>) -> [f64; N],
) -> Motion<N> {
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

    /// Two driven, damped pendulums; the mass of each is 2, and the slope is rough on purpose.
    struct Pendulums;

    impl EquationsOfMotion for Pendulums {
        fn defect(&self, time: f64, (q, v): &Motion<2>, acceleration: [f64; 2], shares: Shares) -> Defect {
            let force = |i: usize| -q[i].sin() - 0.1 * v[i] + 0.5 * (1.7 * time + i as f64).cos();
            let slope = 2.0 + 2.0 * (shares.place + 0.1 * shares.velocity);
            Defect {
                force: std::array::from_fn(|i| 2.0 * (force(i) - acceleration[i])),
                slope: [1.02 * slope, 0.0, 0.99 * slope],
            }
        }
    }

    /// As the equations above, but exact where nothing is implicit.
    fn exact(time: f64, (q, v): &Motion<2>) -> [f64; 2] {
        std::array::from_fn(|i| -q[i].sin() - 0.1 * v[i] + 0.5 * (1.7 * time + i as f64).cos())
    }

    const START: Motion<2> = ([1.0, -0.5], [0.0, 0.2]);

    fn adams(steps: u32) -> Motion<2> {
        let step = 2.0 / f64::from(steps);
        let mut method = AdamsMoulton::new(0.0, START, step);
        // From exact values: the start by Runge–Kutta needs exact slopes.
        for k in 0..3 {
            let time = f64::from(k) * step;
            let now = exact(time, &method.motion);
            method.motion = runge_kutta(time, &method.motion, &now, step, exact);
            let [a, b, c, _] = if k == 0 { [now, [0.0; 2], [0.0; 2], [0.0; 2]] } else { method.accelerations };
            method.accelerations = [exact(time + step, &method.motion), a, b, c];
            method.steps += 1;
        }
        method.known = 4;
        for _ in 3..steps {
            method.step(&Pendulums);
        }
        assert!((method.time() - 2.0).abs() < 1e-14);
        *method.motion()
    }

    fn runge(steps: u32) -> Motion<2> {
        let step = 2.0 / f64::from(steps);
        (0..steps).fold(START, |motion, k| {
            let time = f64::from(k) * step;
            runge_kutta(time, &motion, &exact(time, &motion), step, exact)
        })
    }

    #[test]
    fn both_methods_are_of_order_4() {
        let true_end = runge(20_000);
        for method in [adams, runge] {
            let error = |steps| {
                let (q, v) = method(steps);
                (0..2).map(|i| (q[i] - true_end.0[i]).hypot(v[i] - true_end.1[i])).fold(0.0, f64::max)
            };
            let orders: Vec<f64> = [40, 80, 160].map(|n| (error(n) / error(2 * n)).log2()).to_vec();
            assert!(orders.iter().all(|order| (order - 4.0).abs() < 0.35), "{orders:?}");
        }
    }

    /// q̈ + 2ζω q̇ + ω² q = 0 in both directions, with a mass of 3.
    struct Oscillator {
        frequency: f64,
        damping: f64,
        evaluations: std::cell::Cell<u64>,
    }

    impl EquationsOfMotion for Oscillator {
        fn defect(&self, _: f64, (q, v): &Motion<2>, acceleration: [f64; 2], shares: Shares) -> Defect {
            self.evaluations.set(self.evaluations.get() + 1);
            let (square, twice) = (self.frequency * self.frequency, 2.0 * self.damping * self.frequency);
            let slope = 3.0 * (1.0 + shares.place * square + shares.velocity * twice);
            let force = std::array::from_fn(|i| -3.0 * (square * q[i] + twice * v[i] + acceleration[i]));
            Defect { force, slope: [slope, 0.0, slope] }
        }
    }

    /// Growth of an oscillation over 4000 steps at ω h, damped by a share of the critical damping.
    #[test]
    fn steps_are_stable_up_to_where_it_is_said() {
        for (frequency, damping, stable) in STABILITY {
            let oscillator = Oscillator { frequency, damping, evaluations: std::cell::Cell::new(0) };
            let mut method = AdamsMoulton::new(0.0, ([1.0, 0.5], [0.0; 2]), 1.0);
            for _ in 0..4000 {
                method.step(&oscillator);
            }
            assert_eq!(oscillator.evaluations.get(), method.evaluations());
            let largest = method.motion().0.into_iter().map(f64::abs).fold(0.0, f64::max);
            println!("{frequency} {damping} {largest:e}");
            assert_eq!(largest < 1.2, stable, "ω h = {frequency}, ζ = {damping}: {largest}");
        }
    }
    const STABILITY: [(f64, f64, bool); 6] =
        [(0.3, 0.0, true), (0.35, 0.0, true), (0.7, 0.0, false), (0.7, 0.1, true), (1.8, 0.1, true), (2.5, 0.1, false)];
}
