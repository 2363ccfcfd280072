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
//! A of the current step multiplies a difference that is of the method's own order, so that any A keeps the order: 3 for the
//! balls, 2 for the cage. The film of the pockets, whose force goes with places, counts in A by what places have of velocities. Azimuths and places of the cage take Adams–Moulton with the new velocities. The spindle is predicted by Adams–Bashforth and corrected by
//! Adams–Moulton, whose equation is solved by one step of Newton with the stiffness and the damping of the raceways: no second
//! evaluation, and the error and the stability of the implicit method. The first steps are of rising order and a sixteenth of
//! the length.

use super::evaluation::Scratch;
use super::{BallRates, Balls, Border, RadiallyCondensed, Rates, Seen};
use crate::numerics::lanes::{LANES, Real, SideBySide, Singles, Task};
use crate::numerics::ode::adams::{Weights, ahead, weights};
use crate::numerics::ode::adams_moulton::{Shares, solve};

/// Short steps to one of full length at the start.
const START: usize = 16;
/// Nodes that are remembered: highest order of the spindle's motion.
pub(super) const NODES: usize = 5;
/// Order of the places of balls and cage.
const PLACE_NODES: usize = 4;

/// y_{n+1} − y_n in backward differentiation of order k, times `leading`: Σ past_i Δ_i + h Σ rates_i f_i, and the implicit part's
/// extrapolation Σ ahead_i Δ_i.
#[derive(Debug, Clone, Copy)]
struct Implicit<T = f64> {
    leading: T,
    past: [T; 2],
    ahead: [T; 2],
    rates: [T; 3],
}

const IMPLICIT: [Implicit; 3] = [
    Implicit { leading: 1.0, past: [0.0; 2], ahead: [0.0; 2], rates: [1.0, 0.0, 0.0] },
    Implicit { leading: 1.5, past: [0.5, 0.0], ahead: [1.0, 0.0], rates: [2.0, -1.0, 0.0] },
    Implicit { leading: 11.0 / 6.0, past: [7.0 / 6.0, -1.0 / 3.0], ahead: [2.0, -1.0], rates: [3.0, -3.0, 1.0] },
];

/// Formulas with as many nodes as are known.
#[derive(Debug, Clone, Copy)]
struct Formulas {
    /// For the balls, and for the cage, whose pockets would not bear extrapolation of order 3 over long steps.
    balls: Implicit<f32>,
    cage: Implicit,
    /// Through the known nodes, and through the new one and the others but the oldest.
    predict: Weights<NODES>,
    correct: Weights<NODES>,
    /// Of the velocities of balls and cage.
    moulton: [f64; PLACE_NODES],
    /// The acceleration with which the one formula is the other.
    ahead: [f64; NODES],
}

impl Formulas {
    fn new(known: usize) -> Self {
        let known = known.min(NODES);
        // From a single node there is nothing to correct by.
        let corrects = known > 1;
        Self {
            balls: IMPLICIT[known.min(3) - 1].single(),
            cage: IMPLICIT[known.min(2) - 1],
            predict: weights(0.0, known),
            correct: if corrects {
                weights(1.0, known)
            } else {
                Weights { velocity: [0.0; NODES], place: [0.0; NODES] }
            },
            moulton: if corrects { weights(1.0, known).velocity } else { [0.0; PLACE_NODES] },
            ahead: ahead(known),
        }
    }
}

/// State and rates at one time.
#[derive(Debug, Clone, Default)]
struct Node {
    balls: Vec<Balls>,
    border: Border,
    rates: Rates,
    /// Of the spindle.
    acceleration: [f64; 2],
}

/// Who looks at the motion. What is always inlined there is compiled for the instructions of the steps.
pub trait Look {
    /// At a time whose rates are known.
    fn look(&mut self, stepper: &Stepper<'_>);
}

impl<F: FnMut(&Stepper<'_>)> Look for F {
    #[inline(always)]
    fn look(&mut self, stepper: &Stepper<'_>) {
        self(stepper);
    }
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
    formulas: Formulas,
    scratch: Scratch,
}

impl<'m> Stepper<'m> {
    /// From a state at a time [s], in steps of a length [s].
    pub fn new(model: &'m RadiallyCondensed, time: f64, balls: Vec<Balls>, border: Border, step: f64) -> Self {
        let rates = Rates { balls: vec![BallRates::default(); model.groups()], ..Rates::default() };
        let node = Node { balls, border, rates, acceleration: [0.0; 2] };
        let mut stepper = Self {
            model,
            begin: time,
            step: step / START as f64,
            count: 0,
            evaluations: 0,
            nodes: std::array::from_fn(|_| Box::new(node.clone())),
            known: 1,
            formulas: Formulas::new(1),
            scratch: Scratch::new(model.groups()),
        };
        // Short steps, then every sixteenth of them as the past of the long ones.
        let mut past = Vec::new();
        for _ in 0..NODES - 1 {
            for _ in 0..START {
                let first = stepper.count.is_multiple_of(START as u64);
                stepper.advance(1, &mut |at: &Stepper<'_>| {
                    if first {
                        past.push(at.nodes[0].clone());
                    }
                });
                if stepper.known < model.nodes(step) {
                    stepper.known += 1;
                    stepper.formulas = Formulas::new(stepper.known);
                }
            }
        }
        for (i, node) in past.into_iter().rev().enumerate() {
            stepper.nodes[i + 1] = node;
        }
        stepper.step = step;
        stepper.count = NODES as u64 - 1;
        stepper
    }

    /// [s]
    pub fn time(&self) -> f64 {
        self.begin + self.count as f64 * self.step
    }

    /// [s]
    pub fn step_length(&self) -> f64 {
        self.step
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

    /// Accelerations of the spindle at the time of a look.
    pub fn spindle_acceleration(&self) -> [f64; 2] {
        self.nodes[0].acceleration
    }

    /// What was seen of the balls at the time of a look.
    pub fn seen(&self) -> &[Seen] {
        &self.scratch.seen
    }

    /// Some steps on, with a look before each, once its rates are known.
    pub fn advance(&mut self, steps: u64, look: &mut impl Look) {
        self.model.instructions.run(Stretch { stepper: self, steps, look });
    }

    /// Evaluates the rates at the present time, and corrects the spindle by Adams–Moulton: one step of Newton from the
    /// acceleration that was predicted, which place and velocity have in them.
    #[inline(always)]
    fn rate(&mut self) {
        let (time, h) = (self.time(), self.step);
        let Weights { velocity, place } = &self.formulas.correct;
        let shares = Shares { place: h * h * place[0], velocity: h * velocity[0] };
        let node = &mut *self.nodes[0];
        let predicted = node.acceleration;
        self.model.rates(time, &node.balls, &node.border, predicted, shares, &mut node.rates, &mut self.scratch);
        self.evaluations += 1;
        let change = solve(&node.rates.spindle);
        let Border { spindle, spindle_velocity, .. } = node.border;
        node.acceleration = std::array::from_fn(|i| predicted[i] + change[i]);
        node.border.spindle = std::array::from_fn(|i| spindle[i] + shares.place * change[i]);
        node.border.spindle_velocity = std::array::from_fn(|i| spindle_velocity[i] + shares.velocity * change[i]);
    }

    /// One step, after `rate`.
    #[inline(always)]
    fn step(&mut self) {
        let (h, formulas) = (self.step, &self.formulas);
        let moulton = &formulas.moulton;
        // The oldest makes room for the newest.
        self.nodes.rotate_right(1);
        // The newest first: the oldest still stands where the new one will.
        let accelerations = std::array::from_fn(|i| self.nodes[(i + 1) % NODES].acceleration);
        let [new, now, before, earlier, ..] = self.nodes.each_mut().map(|node| &mut **node);
        for group in 0..now.balls.len() {
            let past = Past {
                states: (now.balls[group], before.balls[group], earlier.balls[group]),
                rates: (now.rates.balls[group], before.rates.balls[group], earlier.rates.balls[group]),
            };
            new.balls[group] = past.stepped(&formulas.balls, moulton, h);
        }
        // Both directions of each quantity at once: what is stored in pairs can be read in pairs.
        let (a, b, c) = (&now.border, &before.border, &earlier.border);
        let rise = weighed(&formulas.predict.velocity, &accelerations);
        let lift = weighed(&formulas.predict.place, &accelerations);
        new.acceleration = weighed(&formulas.ahead, &accelerations);
        let cage_rates = [now.rates.cage, before.rates.cage, earlier.rates.cage];
        let cage_damping = now.rates.cage_damping;
        let cage_velocities = [a.cage_velocity, b.cage_velocity, c.cage_velocity];
        let cage_velocity: [f64; 3] = std::array::from_fn(|i| {
            let damping = h * cage_damping[i];
            let (pushed, ahead) = formulas.cage.pushed(h, cage_velocities.map(|v| v[i]), cage_rates.map(|f| f[i]));
            cage_velocities[0][i] + (pushed + damping * ahead) / (formulas.cage.leading + damping)
        });
        let moved = weighed(moulton, &[cage_velocity, a.cage_velocity, b.cage_velocity, c.cage_velocity]);
        new.border = Border {
            spindle: std::array::from_fn(|i| a.spindle[i] + h * (a.spindle_velocity[i] + h * lift[i])),
            spindle_velocity: std::array::from_fn(|i| a.spindle_velocity[i] + h * rise[i]),
            cage: std::array::from_fn(|i| a.cage[i] + h * moved[i]),
            cage_arc: a.cage_arc + h * moved[2],
            cage_velocity,
        };
        self.count += 1;
    }
}

/// Steps between two changes of instructions.
struct Stretch<'a, 's, 'm, L> {
    stepper: &'s mut Stepper<'m>,
    steps: u64,
    look: &'a mut L,
}

impl<L: Look> Task for Stretch<'_, '_, '_, L> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        for _ in 0..self.steps {
            self.stepper.rate();
            self.look.look(self.stepper);
            self.stepper.step();
        }
    }
}

/// Σ weight · value, the newest last: it is what a step waits for.
#[inline(always)]
fn weighed<T: Real, const N: usize, const NODES: usize>(weights: &[T; NODES], values: &[[T; N]; NODES]) -> [T; N] {
    let mut sums = [T::of(0.0); N];
    for (weight, value) in weights.iter().zip(values).rev() {
        for (sum, value) in sums.iter_mut().zip(value) {
            *sum = *sum + *weight * *value;
        }
    }
    sums
}

impl Implicit {
    fn single(&self) -> Implicit<f32> {
        Implicit {
            leading: self.leading as f32,
            past: self.past.map(|c| c as f32),
            ahead: self.ahead.map(|c| c as f32),
            rates: self.rates.map(|c| c as f32),
        }
    }
}

impl<T: Real> Implicit<T> {
    /// What pushes a value on, and the extrapolated change that the implicit part starts from; newest first.
    #[inline(always)]
    fn pushed(&self, h: T, values: [T; 3], rates: [T; 3]) -> (T, T) {
        let (delta, before) = (values[0] - values[1], values[1] - values[2]);
        let rate = self.rates[0] * rates[0] + self.rates[1] * rates[1] + self.rates[2] * rates[2];
        (self.past[0] * delta + self.past[1] * before + h * rate, self.ahead[0] * delta + self.ahead[1] * before)
    }
}

/// States and rates of eight balls, newest first.
struct Past {
    states: (Balls, Balls, Balls),
    rates: (BallRates<Singles>, BallRates<Singles>, BallRates<Singles>),
}

impl Past {
    /// A step on.
    #[inline(always)]
    fn stepped(&self, formulas: &Implicit<f32>, moulton: &[f64; PLACE_NODES], h: f64) -> Balls {
        let (c, moulton, h) = (*formulas, moulton.map(|weight| weight as f32), h as f32);
        let (mut new, mut on) = (Balls::default(), Singles::default());
        for lane in 0..LANES {
            let (now, before, earlier) = (self.states.0.at(lane), self.states.1.at(lane), self.states.2.at(lane));
            let (f, f1, f2) = (self.rates.0.at(lane), self.rates.1.at(lane), self.rates.2.at(lane));
            let velocities = [now.arc_velocity, before.arc_velocity, earlier.arc_velocity];
            let spins = [now.spin, before.spin, earlier.spin];
            let (push_v, ahead_v) = c.pushed(h, velocities, [f.arc_velocity, f1.arc_velocity, f2.arc_velocity]);
            let (push_p, ahead_p) = c.pushed(h, spins, [f.spin, f1.spin, f2.spin]);
            // A = [−a, b; d, −e]
            let (a, b, d, e) = (h * f.arc_by_arc, h * f.arc_by_spin, h * f.spin_by_arc, h * f.spin_by_spin);
            let (right_v, right_p) = (push_v + a * ahead_v - b * ahead_p, push_p - d * ahead_v + e * ahead_p);
            let (vv, pp) = (c.leading + a, c.leading + e);
            let per_determinant = 1.0 / (vv * pp - b * d);
            let arc_velocity = now.arc_velocity + per_determinant * (pp * right_v + b * right_p);
            let spin = now.spin + per_determinant * (vv * right_p + d * right_v);
            let [moved] =
                weighed(&moulton, &[[arc_velocity], [now.arc_velocity], [before.arc_velocity], [earlier.arc_velocity]]);
            (new.arc_velocity[lane], new.spin[lane]) = (arc_velocity, spin);
            on[lane] = h * moved;
        }
        // In double precision, so in a loop of its own.
        for lane in 0..LANES {
            new.arc[lane] = self.states.0.arc[lane] + f64::from(on[lane]);
        }
        new
    }
}
