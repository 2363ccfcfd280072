//! Steps of fixed length through the radially condensed equations: one evaluation a step.
//!
//! Orbit speed and spin of each ball and the velocity of the cage, which traction and pocket film hold with rates beyond
//! 1/h, are advanced by backward differentiation with the rates extrapolated and their stiff linear part A taken
//! implicitly (2 × 2 a ball, diagonal for the cage; Ascher, Ruuth & Wetton 1995, SIAM J. Numer. Anal. 32, p. 797):
//!
//! ```text
//! Σ a_i y_{n+1−i} = h Σ b_i f_{n−i} + h A (y_{n+1} − Σ b_i y_{n−i})
//! ```
//!
//! A of the current step multiplies a difference that is of the method's own order, so that any A keeps the order. The
//! spindle is predicted by Adams–Bashforth and corrected by Adams–Moulton once its acceleration is known; all positions take
//! Adams–Moulton with the new velocities. The order is `ORDER`; spindle and positions have one more. The first steps are of rising order and a sixteenth of the length.

use super::{BallRates, Balls, Border, Instructions, Lane, RadiallyCondensed, Rates, Scratch, Seen, WIDTH};

/// Order of the method.
pub const ORDER: usize = 3;
/// Short steps to one of full length at the start.
const START: usize = 16;
/// Nodes that are remembered.
const NODES: usize = 4;

/// y_{n+1} − y_n in backward differentiation of order k, times `leading`: Σ past_i Δ_i + h Σ rates_i f_i, and the implicit part's
/// extrapolation Σ ahead_i Δ_i.
struct Implicit {
    leading: f64,
    past: [f64; 2],
    ahead: [f64; 2],
    rates: [f64; 3],
}

const IMPLICIT: [Implicit; 3] = [
    Implicit { leading: 1.0, past: [0.0; 2], ahead: [0.0; 2], rates: [1.0, 0.0, 0.0] },
    Implicit { leading: 1.5, past: [0.5, 0.0], ahead: [1.0, 0.0], rates: [2.0, -1.0, 0.0] },
    Implicit { leading: 11.0 / 6.0, past: [7.0 / 6.0, -1.0 / 3.0], ahead: [2.0, -1.0], rates: [3.0, -3.0, 1.0] },
];
const BASHFORTH: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [1.5, -0.5, 0.0, 0.0],
    [23.0 / 12.0, -16.0 / 12.0, 5.0 / 12.0, 0.0],
    [55.0 / 24.0, -59.0 / 24.0, 37.0 / 24.0, -9.0 / 24.0],
];
/// The first is that of the new velocity.
const MOULTON: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.5, 0.5, 0.0, 0.0],
    [5.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0, 0.0],
    [9.0 / 24.0, 19.0 / 24.0, -5.0 / 24.0, 1.0 / 24.0],
];

/// State and rates at one time.
#[derive(Debug, Clone, Default)]
struct Node {
    balls: Vec<Balls>,
    border: Border,
    rates: Rates,
}

/// The motion on its way.
pub struct Stepper<'m> {
    model: &'m RadiallyCondensed,
    begin: f64,
    step: f64,
    /// Steps since `begin`.
    count: u64,
    evaluations: u64,
    /// Newest first.
    nodes: [Box<Node>; NODES],
    /// How many of them count.
    known: usize,
    scratch: Scratch,
}

impl<'m> Stepper<'m> {
    /// From a state at a time [s], in steps of a length [s].
    pub fn new(model: &'m RadiallyCondensed, time: f64, balls: Vec<Balls>, border: Border, step: f64) -> Self {
        let rates = Rates { balls: vec![Default::default(); model.groups()], ..Rates::default() };
        let node = Node { balls, border, rates };
        let mut stepper = Self {
            model,
            begin: time,
            step: step / START as f64,
            count: 0,
            evaluations: 0,
            nodes: std::array::from_fn(|_| Box::new(node.clone())),
            known: 1,
            scratch: Scratch::new(model),
        };
        // Short steps, then every sixteenth of them as the past of the long ones.
        let mut past = Vec::new();
        for _ in 0..NODES - 1 {
            for short in 0..START {
                stepper.rate();
                if short == 0 {
                    past.push(stepper.nodes[0].clone());
                }
                stepper.advance();
            }
        }
        for (i, node) in past.into_iter().rev().enumerate() {
            stepper.nodes[i + 1] = node;
        }
        stepper.step = step;
        stepper.count = NODES as u64 - 1;
        stepper.known = NODES;
        stepper
    }

    /// [s]
    pub fn time(&self) -> f64 {
        self.begin + self.count as f64 * self.step
    }

    /// Full steps, those of the start included.
    pub fn steps(&self) -> u64 {
        self.count
    }

    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    pub fn balls(&self) -> &[Balls] {
        &self.nodes[0].balls
    }

    pub fn border(&self) -> &Border {
        &self.nodes[0].border
    }

    /// Accelerations of the spindle at the present time, once `rate` has run.
    pub fn spindle_acceleration(&self) -> [f64; 2] {
        self.nodes[0].rates.spindle
    }

    /// What was seen at the present time, once `rate` has run.
    pub fn seen(&self) -> &[Seen] {
        &self.scratch.seen
    }

    /// Evaluates the rates at the present time.
    pub fn rate(&mut self) {
        let time = self.time();
        let node = &mut self.nodes[0];
        self.model.rates(time, &node.balls, &node.border, &mut node.rates, &mut self.scratch);
        self.evaluations += 1;
        self.correct();
    }

    /// The spindle once more by Adams–Moulton, with the acceleration where it was predicted to be.
    fn correct(&mut self) {
        if self.known < NODES {
            return;
        }
        let [now, before, earlier, oldest] = &mut self.nodes;
        let c = &MOULTON[NODES - 1];
        for i in 0..2 {
            let accelerations =
                [now.rates.spindle[i], before.rates.spindle[i], earlier.rates.spindle[i], oldest.rates.spindle[i]];
            let velocity = before.border.spindle_velocity[i] + self.step * weighed(c, accelerations);
            now.border.spindle_velocity[i] = velocity;
            let velocities = [
                velocity,
                before.border.spindle_velocity[i],
                earlier.border.spindle_velocity[i],
                oldest.border.spindle_velocity[i],
            ];
            now.border.spindle[i] = before.border.spindle[i] + self.step * weighed(c, velocities);
        }
    }

    /// One step, after `rate`.
    pub fn advance(&mut self) {
        let known = self.known.min(NODES);
        let implicit = &IMPLICIT[known.min(ORDER) - 1];
        let (bashforth, moulton) = (&BASHFORTH[known.min(4) - 1], &MOULTON[known.min(4) - 1]);
        let h = self.step;
        // The oldest makes room for the newest.
        self.nodes.rotate_right(1);
        let [oldest, now, before, earlier] = &mut self.nodes;
        {
            for group in 0..self.model.groups() {
                let past = [&*now, &*before, &*earlier].map(|node| (&node.balls[group], &node.rates.balls[group]));
                let new = &mut oldest.balls[group];
                match self.model.instructions() {
                    #[cfg(target_arch = "x86_64")]
                    // SAFETY: the processor has what the function is compiled for.
                    Instructions::Avx512 => unsafe { step_balls_avx512(implicit, moulton, h, past, new) },
                    #[cfg(target_arch = "x86_64")]
                    // SAFETY: as above.
                    Instructions::Avx2 => unsafe { step_balls_avx2(implicit, moulton, h, past, new) },
                    Instructions::Baseline => step_balls(implicit, moulton, h, past, new),
                }
            }
            let mut border = Border::default();
            for i in 0..3 {
                let delta = now.border.cage_velocity[i] - before.border.cage_velocity[i];
                let delta_before = before.border.cage_velocity[i] - earlier.border.cage_velocity[i];
                let damping = h * now.rates.cage_damping[i];
                let [c, c1, c2] = implicit.rates;
                let rates = c * now.rates.cage[i] + c1 * before.rates.cage[i] + c2 * earlier.rates.cage[i];
                let pushed = implicit.past[0] * delta
                    + implicit.past[1] * delta_before
                    + damping * (implicit.ahead[0] * delta + implicit.ahead[1] * delta_before)
                    + h * rates;
                border.cage_velocity[i] = now.border.cage_velocity[i] + pushed / (implicit.leading + damping);
            }
            for i in 0..2 {
                let accelerations =
                    [now.rates.spindle[i], before.rates.spindle[i], earlier.rates.spindle[i], oldest.rates.spindle[i]];
                let change = weighed(bashforth, accelerations);
                border.spindle_velocity[i] = now.border.spindle_velocity[i] + h * change;
                let velocities = [
                    border.spindle_velocity[i],
                    now.border.spindle_velocity[i],
                    before.border.spindle_velocity[i],
                    earlier.border.spindle_velocity[i],
                ];
                border.spindle[i] = now.border.spindle[i] + h * weighed(moulton, velocities);
                let velocities = [
                    border.cage_velocity[i],
                    now.border.cage_velocity[i],
                    before.border.cage_velocity[i],
                    earlier.border.cage_velocity[i],
                ];
                border.cage[i] = now.border.cage[i] + h * weighed(moulton, velocities);
            }
            let velocities = [
                border.cage_velocity[2],
                now.border.cage_velocity[2],
                before.border.cage_velocity[2],
                earlier.border.cage_velocity[2],
            ];
            border.cage_arc = now.border.cage_arc + h * weighed(moulton, velocities);
            oldest.border = border;
        }
        self.count += 1;
        self.known = (known + 1).min(NODES);
    }
}

#[inline(always)]
fn weighed(weights: &[f64; 4], values: [f64; 4]) -> f64 {
    (weights[0] * values[0] + weights[1] * values[1]) + (weights[2] * values[2] + weights[3] * values[3])
}

/// States and rates of eight balls, newest first.
type Past<'a> = [(&'a Balls, &'a BallRates); 3];

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
fn step_balls_avx512(c: &Implicit, moulton: &[f64; 4], h: f64, past: Past<'_>, new: &mut Balls) {
    step_balls(c, moulton, h, past, new);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn step_balls_avx2(c: &Implicit, moulton: &[f64; 4], h: f64, past: Past<'_>, new: &mut Balls) {
    step_balls(c, moulton, h, past, new);
}

/// Eight balls a step on.
#[inline(always)]
fn step_balls(
    c: &Implicit,
    moulton: &[f64; 4],
    h: f64,
    [(now, f), (before, f1), (earlier, f2)]: Past<'_>,
    new: &mut Balls,
) {
    for k in 0..WIDTH {
        let part = |now: &Lane, before: &Lane, earlier: &Lane| {
            let (delta, delta_before) = (now.0[k] - before.0[k], before.0[k] - earlier.0[k]);
            (c.past[0] * delta + c.past[1] * delta_before, c.ahead[0] * delta + c.ahead[1] * delta_before)
        };
        let (past_v, ahead_v) = part(&now.arc_velocity, &before.arc_velocity, &earlier.arc_velocity);
        let (past_p, ahead_p) = part(&now.spin, &before.spin, &earlier.spin);
        let rate_v =
            c.rates[0] * f.arc_velocity.0[k] + c.rates[1] * f1.arc_velocity.0[k] + c.rates[2] * f2.arc_velocity.0[k];
        let rate_p = c.rates[0] * f.spin.0[k] + c.rates[1] * f1.spin.0[k] + c.rates[2] * f2.spin.0[k];
        // A = [−a, b; d, −e]
        let (a, b) = (h * f.matrix[0].0[k], h * f.matrix[1].0[k]);
        let (d, e) = (h * f.matrix[2].0[k], h * f.matrix[3].0[k]);
        let right_v = past_v + h * rate_v + a * ahead_v - b * ahead_p;
        let right_p = past_p + h * rate_p - d * ahead_v + e * ahead_p;
        let (vv, pp) = (c.leading + a, c.leading + e);
        let inverse = 1.0 / (vv * pp - b * d);
        let v = now.arc_velocity.0[k] + inverse * (pp * right_v + b * right_p);
        let p = now.spin.0[k] + inverse * (vv * right_p + d * right_v);
        new.arc_velocity.0[k] = v;
        new.spin.0[k] = p;
        let arrived = [v, now.arc_velocity.0[k], before.arc_velocity.0[k], earlier.arc_velocity.0[k]];
        new.arc.0[k] = now.arc.0[k] + h * weighed(moulton, arrived);
    }
}
