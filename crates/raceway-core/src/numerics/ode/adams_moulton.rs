//! The implicit method of Adams and Moulton with fixed steps for equations of motion M q̈ = f(t, q, q̇) in a plane. The
//! equations must not be stiff. The order is the number of nodes. The classical Runge–Kutta method starts it.
//!
//! The polynomial through the last accelerations predicts the new one, and with it place and velocity, as Adams and
//! Bashforth do. One step of Newton's method solves the implicit equation with one evaluation a step. Velocities are
//! the integral of that polynomial, places its double integral. Places integrated from velocities would halve the
//! longest stable step. The equations come with every step, so that they may be compiled into the caller's loop.
//!
//! Limits of stability with an exact slope: with 4 nodes ω h = 0.35 without damping and 1.8 with a tenth of critical
//! damping, with 7 nodes 1 and 1.7.

use super::adams::{Weights, ahead, weights};

/// Nodes that there is room for.
const MAX_NODES: usize = 8;

/// Places and velocities.
pub(crate) type Motion<const N: usize> = ([f64; N], [f64; N]);

/// A symmetric matrix: yy, yz, zz.
pub(crate) type Symmetric = [f64; 3];

/// Shares of the acceleration at the end of a step in the place and in the velocity there [s², s].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shares {
    pub place: f64,
    pub velocity: f64,
}

/// Defect f − M a of the equations for an assumed acceleration a, and the slope of M a − f over a. Places and
/// velocities follow a by their shares, so that the slope is M − (share of the place) ∂f/∂q − (share of the velocity)
/// ∂f/∂q̇.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Defect {
    pub force: [f64; 2],
    pub slope: Symmetric,
}

impl Defect {
    /// Sum over two parts of the equations.
    #[inline(always)]
    pub(crate) fn and(&self, other: &Self) -> Self {
        let ([a, b], [c, d, e]) = (other.force, other.slope);
        Self {
            force: [self.force[0] + a, self.force[1] + b],
            slope: [self.slope[0] + c, self.slope[1] + d, self.slope[2] + e],
        }
    }
}

/// M q̈ = f(t, q, q̇). The slope may be approximate, because it only corrects the prediction.
pub(crate) trait EquationsOfMotion {
    /// Excitation that depends on time alone.
    type Drive;

    fn drive(&self, time: f64) -> Self::Drive;

    fn defect(&self, drive: &Self::Drive, motion: &Motion<2>, acceleration: [f64; 2], shares: Shares) -> Defect;

    /// q̈ at a motion.
    #[inline(always)]
    fn acceleration(&self, drive: &Self::Drive, motion: &Motion<2>) -> [f64; 2] {
        solve(&self.defect(drive, motion, [0.0; 2], Shares::default()))
    }
}

/// Change of the acceleration that takes the defect away.
#[inline(always)]
pub(crate) fn solve(Defect { force: [y, z], slope: [yy, yz, zz] }: &Defect) -> [f64; 2] {
    let per_determinant = 1.0 / (yy * zz - yz * yz);
    [(zz * y - yz * z) * per_determinant, (yy * z - yz * y) * per_determinant]
}

/// Accelerations at the last times, latest first, in a ring that stands there twice, so that they follow each other from `latest`
/// on. It stays in memory: in registers, from which it would have to move on with every step, it leaves no room for more.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Past {
    accelerations: [[f64; 2]; 2 * MAX_NODES],
    latest: usize,
}

impl Past {
    #[inline(always)]
    fn push(&mut self, acceleration: [f64; 2]) {
        self.latest = self.latest.wrapping_sub(1) % MAX_NODES;
        self.accelerations[self.latest] = acceleration;
        self.accelerations[self.latest + MAX_NODES] = acceleration;
    }

    /// start + Σ weight · acceleration, the latest one last: it is what a step waits for.
    #[inline(always)]
    fn sum<const N: usize>(&self, start: [f64; 2], weights: &[f64; N]) -> [f64; 2] {
        let known = &self.accelerations[self.latest % MAX_NODES..][..N];
        let [mut y, mut z] = start;
        for (weight, known) in weights.iter().zip(known).rev() {
            (y, z) = (y + weight * known[0], z + weight * known[1]);
        }
        [y, z]
    }
}

/// Integration by the formula of `N` nodes: the new one and the last N − 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AdamsMoulton<const N: usize> {
    start: f64,
    step: f64,
    steps: u64,
    motion: Motion<2>,
    acceleration: [f64; 2],
    past: Past,
    known: usize,
    /// Weights of the accelerations in the predicted acceleration, place and velocity [-, s², s].
    ahead: [f64; N],
    predict: Weights<N>,
    shares: Shares,
}

impl<const N: usize> AdamsMoulton<N> {
    /// Starts at `(time, motion)`.
    pub(crate) fn new(equations: &impl EquationsOfMotion, time: f64, motion: Motion<2>, step: f64) -> Self {
        let (predict, correct) = (weights::<N>(0.0, N), weights::<N>(1.0, N));
        let acceleration = equations.acceleration(&equations.drive(time), &motion);
        let mut past = Past::default();
        past.push(acceleration);
        Self {
            start: time,
            step,
            steps: 0,
            motion,
            acceleration,
            past,
            known: 1,
            ahead: ahead(N),
            predict: Weights {
                place: predict.place.map(|weight| step * step * weight),
                velocity: predict.velocity.map(|weight| step * weight),
            },
            shares: Shares { place: step * step * correct.place[0], velocity: step * correct.velocity[0] },
        }
    }

    pub(crate) fn time(&self) -> f64 {
        self.after(0)
    }

    /// Time after some more steps.
    #[inline(always)]
    pub(crate) fn after(&self, steps: usize) -> f64 {
        self.start + (self.steps + steps as u64) as f64 * self.step
    }

    pub(crate) fn motion(&self) -> &Motion<2> {
        &self.motion
    }

    pub(crate) fn acceleration(&self) -> &[f64; 2] {
        &self.acceleration
    }

    /// Evaluations of the equations so far.
    pub(crate) fn evaluations(&self) -> u64 {
        // One at the start, and three more in each step by Runge–Kutta.
        self.steps + 1 + 3 * self.steps.min(N as u64 - 1)
    }

    /// Returns true once enough nodes are known for `step`.
    #[inline(always)]
    pub(crate) fn has_begun(&self) -> bool {
        self.known == N
    }

    /// One step, what drives the motion at its end given.
    #[inline(always)]
    pub(crate) fn step<E: EquationsOfMotion>(&mut self, equations: &E, drive: &E::Drive) {
        let (h, shares, (q, v)) = (self.step, self.shares, self.motion);
        let q = self.past.sum([q[0] + h * v[0], q[1] + h * v[1]], &self.predict.place);
        let v = self.past.sum(v, &self.predict.velocity);
        let new = self.past.sum([0.0; 2], &self.ahead);
        let [y, z] = solve(&equations.defect(drive, &(q, v), new, shares));
        self.motion = (
            [q[0] + shares.place * y, q[1] + shares.place * z],
            [v[0] + shares.velocity * y, v[1] + shares.velocity * z],
        );
        self.acceleration = [new[0] + y, new[1] + z];
        self.past.push(self.acceleration);
        self.steps += 1;
    }

    /// One step by Runge–Kutta, for want of a past.
    pub(crate) fn begin(&mut self, equations: &impl EquationsOfMotion) {
        let acceleration = |time: f64, motion: &Motion<2>| equations.acceleration(&equations.drive(time), motion);
        self.motion = runge_kutta(self.time(), &self.motion, &self.acceleration, self.step, acceleration);
        self.steps += 1;
        self.known += 1;
        self.acceleration = acceleration(self.time(), &self.motion);
        self.past.push(self.acceleration);
    }
}

/// One step on by the classical Runge–Kutta method, given the acceleration at its start; evaluates three more.
#[inline(always)]
pub(crate) fn runge_kutta<const N: usize>(
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
        type Drive = f64;

        fn drive(&self, time: f64) -> f64 {
            time
        }

        fn defect(&self, time: &f64, (q, v): &Motion<2>, acceleration: [f64; 2], shares: Shares) -> Defect {
            let force = |i: usize| -q[i].sin() - 0.1 * v[i] + 0.5 * (1.7 * time + i as f64).cos();
            let slope = 2.0 + 2.0 * (shares.place + 0.1 * shares.velocity);
            Defect {
                force: std::array::from_fn(|i| 2.0 * (force(i) - acceleration[i])),
                slope: [1.02 * slope, 0.0, 0.99 * slope],
            }
        }
    }

    /// The equations above, exact where nothing is implicit.
    fn exact(time: f64, (q, v): &Motion<2>) -> [f64; 2] {
        std::array::from_fn(|i| -q[i].sin() - 0.1 * v[i] + 0.5 * (1.7 * time + i as f64).cos())
    }

    const START: Motion<2> = ([1.0, -0.5], [0.0, 0.2]);

    fn adams<const N: usize>(steps: u32) -> Motion<2> {
        let step = 2.0 / f64::from(steps);
        let mut method = AdamsMoulton::<N>::new(&Pendulums, 0.0, START, step);
        // From exact values: the start by Runge–Kutta is of order 4, and needs exact slopes.
        let at = |k: usize| runge_until(k as f64 * step, 50 * k as u32);
        (method.past, method.known, method.steps) = (Past::default(), N, N as u64 - 1);
        (0..N).for_each(|k| method.past.push(exact(k as f64 * step, &at(k))));
        method.motion = at(N - 1);
        while method.steps < u64::from(steps) {
            method.step(&Pendulums, &method.after(1));
        }
        assert!((method.time() - 2.0).abs() < 1e-14);
        *method.motion()
    }

    fn runge_until(end: f64, steps: u32) -> Motion<2> {
        let step = end / f64::from(steps.max(1));
        (0..steps).fold(START, |motion, k| {
            let time = f64::from(k) * step;
            runge_kutta(time, &motion, &exact(time, &motion), step, exact)
        })
    }

    #[test]
    fn methods_have_the_order_of_their_nodes() {
        let true_end = runge_until(2.0, 20_000);
        let runge: fn(u32) -> Motion<2> = |steps| runge_until(2.0, steps);
        for (method, order, first) in [(runge, 4.0, 40), (adams::<4>, 4.0, 40), (adams::<7>, 7.0, 20)] {
            let error = |steps| {
                let (q, v) = method(steps);
                (0..2).map(|i| (q[i] - true_end.0[i]).hypot(v[i] - true_end.1[i])).fold(0.0, f64::max)
            };
            let orders: Vec<f64> = [1, 2].map(|n| (error(n * first) / error(2 * n * first)).log2()).to_vec();
            assert!(orders.iter().all(|found| (found - order).abs() < 0.12 * order), "{orders:?}");
        }
    }

    /// q̈ + 2ζω q̇ + ω² q = 0 in both directions, with a mass of 3.
    struct Oscillator {
        frequency: f64,
        damping: f64,
        evaluations: std::cell::Cell<u64>,
    }

    impl EquationsOfMotion for Oscillator {
        type Drive = ();

        fn drive(&self, _: f64) {}

        fn defect(&self, (): &(), (q, v): &Motion<2>, acceleration: [f64; 2], shares: Shares) -> Defect {
            self.evaluations.set(self.evaluations.get() + 1);
            let (square, twice) = (self.frequency * self.frequency, 2.0 * self.damping * self.frequency);
            let slope = 3.0 * (1.0 + shares.place * square + shares.velocity * twice);
            let force = std::array::from_fn(|i| -3.0 * (square * q[i] + twice * v[i] + acceleration[i]));
            Defect { force, slope: [slope, 0.0, slope] }
        }
    }

    /// Growth of an oscillation over 4000 steps at ω h, damped by a share of the critical damping.
    fn grows<const N: usize>(frequency: f64, damping: f64) -> f64 {
        let oscillator = Oscillator { frequency, damping, evaluations: std::cell::Cell::new(0) };
        let mut method = AdamsMoulton::<N>::new(&oscillator, 0.0, ([1.0, 0.5], [0.0; 2]), 1.0);
        for _ in 0..4000 {
            if method.has_begun() {
                method.step(&oscillator, &());
            } else {
                method.begin(&oscillator);
            }
        }
        assert_eq!(oscillator.evaluations.get(), method.evaluations());
        method.motion().0.into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    #[test]
    fn steps_are_stable_up_to_where_it_is_said() {
        let check = |growth: fn(f64, f64) -> f64, cases: &[(f64, f64, bool)]| {
            for &(frequency, damping, stable) in cases {
                let largest = growth(frequency, damping);
                println!("{frequency} {damping} {largest:e}");
                assert_eq!(largest < 1.2, stable, "ω h = {frequency}, ζ = {damping}: {largest}");
            }
        };
        check(
            grows::<4>,
            &[
                (0.3, 0.0, true),
                (0.35, 0.0, true),
                (0.7, 0.0, false),
                (0.7, 0.1, true),
                (1.8, 0.1, true),
                (2.5, 0.1, false),
            ],
        );
        check(
            grows::<7>,
            &[(0.6, 0.0, true), (1.0, 0.0, true), (1.6, 0.01, true), (1.7, 0.1, true), (2.0, 0.1, false)],
        );
    }
}
