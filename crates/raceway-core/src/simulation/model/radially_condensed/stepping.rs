//! Fixed steps through the radially condensed equations: one evaluation a step.
//!
//! Spindle, balls and cage share one scheme. The motion at the new time is predicted from its past, evaluated there, and corrected by
//! one step of Newton's method towards an implicit formula. Traction and pocket film act on orbit speed and spin of each ball and on
//! the velocity of the cage at rates beyond 1/h. Those take backward differentiation, of order 3 for the balls and 2 for the cage. Here
//! p is the extrapolation of y from the last values, and A the slope of the rates f (2 × 2 for a ball, the diagonal for the cage):
//!
//! ```text
//! (Σ a_i − h A) (y_{n+1} − p) = h f(p) − Σ a_i over p and the past
//! ```
//!
//! Any A keeps the order. The stiffness of films enters A through the share of velocities in places. Azimuths and places of the cage
//! take Adams–Moulton with the new velocities. The spindle is predicted by Adams–Bashforth and corrected by Adams–Moulton with the
//! stiffness and the damping of the raceways. The first steps are of rising order and a sixteenth of the length.
//!
//! Traction couples a ball to the spindle at rates of 1e6/s, and an error of the predicted slip would be many times the force there. So
//! each ball is eliminated from the spindle's equations before their solution, and then follows the spindle. Without the elimination
//! errors are several times as large.

use super::ball::{BallRates, Balls, OneBall, SpindleReaction};
use super::border::Border;
use super::equations::RadiallyCondensed;
use super::evaluation::{BallLoads, Rates, Scratch, StepShares};
use crate::numerics::lanes::{LANES, Lanes, Real, SideBySide, Singles, Task, side_by_side};
use crate::numerics::ode::adams::{Weights, ahead, weights};
use crate::numerics::ode::adams_moulton::{Shares, solve};
use crate::physics::frames::Azimuth;
use crate::simulation::model::heights::Waves;

/// Short steps to one of full length at the start.
const START: usize = 16;
/// Number of stored nodes: highest order of the spindle's motion.
const NODES: usize = 7;
/// Order of the places of balls and cage.
const PLACE_NODES: usize = 3;

/// Backward differentiation of order k: `leading` (y_{n+1} − y_n) = Σ past_i Δ_i + h f, and its extrapolation Σ ahead_i Δ_i.
#[derive(Debug, Clone, Copy)]
pub(super) struct Implicit<T = f64> {
    pub(super) leading: T,
    past: [T; 2],
    ahead: [T; 2],
}

const IMPLICIT: [Implicit; 3] = [
    Implicit { leading: 1.0, past: [0.0; 2], ahead: [0.0; 2] },
    Implicit { leading: 1.5, past: [0.5, 0.0], ahead: [1.0, 0.0] },
    Implicit { leading: 11.0 / 6.0, past: [7.0 / 6.0, -1.0 / 3.0], ahead: [2.0, -1.0] },
];

/// Formulas for a number of known nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Formulas {
    /// Backward differentiation of the balls.
    pub(super) balls: Implicit<f32>,
    /// Backward differentiation of the cage.
    cage: Implicit,
    /// Prediction of the spindle through the known nodes.
    predict: Weights<NODES>,
    /// Correction of the spindle through the new node and all others but the oldest.
    correct: Weights<NODES>,
    /// Weights of the velocities of balls and cage in their places, the new one first.
    pub(super) moulton: [f64; PLACE_NODES],
    /// Acceleration for which prediction and correction of the spindle agree.
    ahead: [f64; NODES],
}

impl Formulas {
    pub(super) fn new(known: usize) -> Self {
        Self {
            balls: IMPLICIT[known.min(3) - 1].single(),
            cage: IMPLICIT[known.min(2) - 1],
            predict: weights(0.0, known),
            correct: weights(1.0, known),
            moulton: weights(1.0, known + 1).velocity,
            ahead: ahead(known),
        }
    }
}

/// The motion at one time.
#[derive(Debug, Clone, Default)]
pub(super) struct Node {
    pub(super) balls: Vec<Balls>,
    /// ∫ spin dt of the balls less that of ideal rolling [rad]; empty where all balls are spheres.
    pub(super) turned: Vec<Lanes>,
    pub(super) border: Border,
    /// Acceleration of the spindle [m/s²].
    acceleration: [f64; 2],
}

impl Node {
    pub(super) fn at(model: &RadiallyCondensed, balls: Vec<Balls>, border: Border) -> Self {
        let with_waves = model.waves.as_ref().is_some_and(Waves::are_of_balls);
        let turned = if with_waves { vec![Lanes::default(); model.groups()] } else { Vec::new() };
        Self { balls, turned, border, acceleration: [0.0; 2] }
    }

    /// Predicts the balls from their past, newest first. `missing`: residuals of their implicit formulas.
    #[inline(always)]
    pub(super) fn predict_balls(
        &mut self,
        past: [&Self; 3],
        missing: &mut [[Singles; 2]],
        formulas: &Formulas,
        h: f64,
    ) {
        for (group, balls) in self.balls.iter_mut().enumerate() {
            (*balls, missing[group]) = ahead_of(past.map(|node| &node.balls[group]), formulas, h);
        }
        self.turn_on(past[0], h);
    }

    /// Corrects balls and cage after a change of the spindle's velocity (y, z) [m/s].
    #[inline(always)]
    pub(super) fn correct(
        &mut self,
        past: [&Self; 3],
        rates: &Rates,
        changes: &[Change<Singles>],
        gained: [f64; 2],
        (formulas, h): (&Formulas, f64),
    ) {
        let place = h * formulas.moulton[0];
        let gained = gained.map(|gained| gained as f32);
        for (group, balls) in self.balls.iter_mut().enumerate() {
            changes[group].correct(balls, &rates.balls[group].azimuth, gained, place as f32);
        }
        self.turn_on(past[0], h);
        self.border.correct_cage(past.map(|node| &node.border), rates, &formulas.cage, h, place);
    }

    /// Turns the balls on from an earlier node by the mean of their spins over a time step.
    #[inline(always)]
    fn turn_on(&mut self, from: &Self, step: f64) {
        for (group, turned) in self.turned.iter_mut().enumerate() {
            for lane in 0..LANES {
                let spins = f64::from(from.balls[group].spin[lane]) + f64::from(self.balls[group].spin[lane]);
                turned[lane] = from.turned[group][lane] + 0.5 * step * spins;
            }
        }
    }
}

/// Observer of the motion. Code that is always inlined there is compiled for the vector instructions of the steps.
pub trait Observe {
    /// Observes the corrected motion at one time.
    fn observe(&mut self, stepper: &Stepper<'_>);
}

impl<F: FnMut(&Stepper<'_>)> Observe for F {
    #[inline(always)]
    fn observe(&mut self, stepper: &Stepper<'_>) {
        self(stepper);
    }
}

/// Integrator with its last states.
pub struct Stepper<'m> {
    model: &'m RadiallyCondensed,
    begin: f64,
    step: f64,
    /// Steps since `begin`.
    count: u64,
    evaluations: u64,
    /// Newest first.
    nodes: [Box<Node>; NODES],
    formulas: Formulas,
    /// True if the newest node is predicted and not yet corrected.
    is_predicted: bool,
    rates: Rates,
    /// Residuals of the implicit formulas at the prediction, without forces: velocity along the arc and spin, times `leading`.
    missing: Vec<[Singles; 2]>,
    changes: Vec<Change<Singles>>,
    scratch: Scratch,
}

impl<'m> Stepper<'m> {
    /// Integrator from a state at a time [s], in steps of a length [s].
    pub fn new(model: &'m RadiallyCondensed, time: f64, balls: Vec<Balls>, border: Border, step: f64) -> Self {
        let node = Node::at(model, balls, border);
        let mut stepper = Self {
            model,
            begin: time,
            step: step / START as f64,
            count: 0,
            evaluations: 0,
            nodes: std::array::from_fn(|_| Box::new(node.clone())),
            formulas: Formulas::new(1),
            is_predicted: false,
            rates: Rates { balls: vec![BallRates::default(); model.groups()], ..Rates::default() },
            missing: vec![Default::default(); model.groups()],
            changes: vec![Change::default(); model.groups()],
            scratch: Scratch::new(model.groups()),
        };
        model.instructions.run(Start { stepper: &mut stepper });
        stepper.step = step;
        stepper.count = NODES as u64 - 1;
        stepper.is_predicted = false;
        stepper
    }

    /// Current time [s].
    pub fn time(&self) -> f64 {
        self.begin + self.count as f64 * self.step
    }

    /// Length of a step [s].
    pub(crate) fn step_length(&self) -> f64 {
        self.step
    }

    /// Number of full steps, including those of the start.
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

    /// Accelerations of the spindle at the observed time [m/s²].
    pub(crate) fn spindle_acceleration(&self) -> [f64; 2] {
        self.nodes[0].acceleration
    }

    /// Loads and slip of the balls at the observed time.
    pub(crate) fn ball_loads(&self) -> &[BallLoads] {
        &self.scratch.ball_loads
    }

    /// Advances by a number of steps and passes the motion before each to `observer`.
    pub fn advance(&mut self, steps: u64, observer: &mut impl Observe) {
        self.model.instructions.run(Stretch { stepper: self, steps, observer });
    }

    /// Evaluates the rates where the motion was predicted, and corrects it.
    #[inline(always)]
    fn rate(&mut self) {
        let (time, h) = (self.time(), self.step);
        let Weights { velocity, place } = &self.formulas.correct;
        // Without a prediction, place and velocity are the initial ones.
        let share = if self.is_predicted { h } else { 0.0 };
        let shares = Shares { place: h * share * place[0], velocity: share * velocity[0] };
        let step = StepShares { spindle: shares, cage: shares.velocity };
        let [new, now, before, earlier, ..] = self.nodes.each_mut().map(|node| &mut **node);
        let predicted = new.acceleration;
        let turning = self.model.rates(
            time,
            &new.balls,
            &new.turned,
            &new.border,
            predicted,
            step,
            &mut self.rates,
            &mut self.scratch,
        );
        self.evaluations += 1;
        let formulas = &self.formulas;
        if self.is_predicted {
            let step = (formulas.balls.leading, h, shares.velocity);
            eliminate(self.model, step, &self.missing, &mut self.rates, &mut self.changes);
        }
        let change = solve(&self.model.defect(time, turning, predicted, &self.rates.passed));
        let Border { spindle, spindle_velocity, .. } = new.border;
        new.acceleration = std::array::from_fn(|i| predicted[i] + change[i]);
        new.border.spindle = std::array::from_fn(|i| spindle[i] + shares.place * change[i]);
        new.border.spindle_velocity = std::array::from_fn(|i| spindle_velocity[i] + shares.velocity * change[i]);
        if self.is_predicted {
            let gained = change.map(|change| shares.velocity * change);
            new.correct([now, before, earlier], &self.rates, &self.changes, gained, (formulas, h));
        }
    }

    /// Predicts the motion one step later, after `rate`.
    #[inline(always)]
    fn step(&mut self) {
        let (h, formulas) = (self.step, &self.formulas);
        // The oldest node is overwritten by the newest.
        self.nodes.rotate_right(1);
        // Newest first; the first place still holds the oldest node.
        let accelerations = std::array::from_fn(|i| self.nodes[(i + 1) % NODES].acceleration);
        let [new, now, before, earlier, ..] = self.nodes.each_mut().map(|node| &mut **node);
        new.predict_balls([now, before, earlier], &mut self.missing, formulas, h);
        // Both directions of each quantity together: values stored in pairs can be loaded in pairs.
        let a = &now.border;
        let rise = weighed(&formulas.predict.velocity, &accelerations);
        let lift = weighed(&formulas.predict.place, &accelerations);
        new.acceleration = weighed(&formulas.ahead, &accelerations);
        let spindle = std::array::from_fn(|i| a.spindle[i] + h * (a.spindle_velocity[i] + h * lift[i]));
        let spindle_velocity = std::array::from_fn(|i| a.spindle_velocity[i] + h * rise[i]);
        let past = [a, &before.border, &earlier.border];
        new.border = Border::predicted(past, (spindle, spindle_velocity), formulas, h);
        self.count += 1;
        self.is_predicted = true;
    }
}

impl Border {
    /// Prediction of the cage from its past, newest first, at a place and a velocity of the spindle.
    #[inline(always)]
    pub(super) fn predicted(
        past: [&Self; 3],
        (spindle, spindle_velocity): ([f64; 2], [f64; 2]),
        formulas: &Formulas,
        h: f64,
    ) -> Self {
        let [now, before, _] = past;
        let velocities = past.map(|border| border.cage_velocity);
        let cage_velocity: [f64; 3] = std::array::from_fn(|i| formulas.cage.extrapolated(velocities.map(|v| v[i])));
        let moved = weighed(&formulas.moulton, &[cage_velocity, now.cage_velocity, before.cage_velocity]);
        Self {
            spindle,
            spindle_velocity,
            cage: std::array::from_fn(|i| now.cage[i] + h * moved[i]),
            cage_arc: now.cage_arc + h * moved[2],
            cage_velocity,
        }
    }

    /// One step of Newton's method from the predicted velocities of the cage to those of the formula. Pockets damp each direction
    /// independently. `past`: newest first; `place`: share of velocities in places [s].
    #[inline(always)]
    fn correct_cage(&mut self, past: [&Self; 3], rates: &Rates, formula: &Implicit, h: f64, place: f64) {
        let past = past.map(|border| border.cage_velocity);
        let change: [f64; 3] = std::array::from_fn(|i| {
            let missing = formula.missing(past.map(|velocity| velocity[i])) + h * rates.cage[i];
            missing / (formula.leading + h * rates.cage_damping[i])
        });
        self.cage_velocity = std::array::from_fn(|i| self.cage_velocity[i] + change[i]);
        self.cage = std::array::from_fn(|i| self.cage[i] + place * change[i]);
        self.cage_arc += place * change[2];
    }
}

/// Short steps of the start; every sixteenth becomes a node of the full steps.
struct Start<'s, 'm> {
    stepper: &'s mut Stepper<'m>,
}

impl Task for Start<'_, '_> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        let (stepper, mut past) = (self.stepper, Vec::new());
        loop {
            stepper.rate();
            if stepper.count == ((NODES - 1) * START) as u64 {
                break;
            }
            if stepper.count.is_multiple_of(START as u64) {
                past.push(stepper.nodes[0].clone());
            }
            stepper.formulas = Formulas::new((stepper.count as usize + 1).min(NODES));
            stepper.step();
        }
        for (i, node) in past.into_iter().rev().enumerate() {
            stepper.nodes[i + 1] = node;
        }
    }
}

/// A number of steps, compiled for each instruction set.
struct Stretch<'a, 's, 'm, L> {
    stepper: &'s mut Stepper<'m>,
    steps: u64,
    observer: &'a mut L,
}

impl<L: Observe> Task for Stretch<'_, '_, '_, L> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        for _ in 0..self.steps {
            self.stepper.rate();
            self.observer.observe(self.stepper);
            self.stepper.step();
        }
    }
}

/// Σ weight · value. The newest value is added last, because a step waits for it.
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
        }
    }
}

impl<T: Real> Implicit<T> {
    /// Extrapolation from the past values, newest first.
    #[inline(always)]
    fn extrapolated(&self, [y, y1, y2]: [T; 3]) -> T {
        y + (self.ahead[0] * (y - y1) + self.ahead[1] * (y1 - y2))
    }

    /// Residual of the formula at the extrapolation, without forces, times `leading`.
    #[inline(always)]
    fn missing(&self, [y, y1, y2]: [T; 3]) -> T {
        let short = |i: usize| self.past[i] - self.leading * self.ahead[i];
        short(0) * (y - y1) + short(1) * (y1 - y2)
    }
}

/// Prediction of eight balls from their past, newest first, and the residuals of velocity along the arc and of spin.
#[inline(always)]
fn ahead_of([now, before, earlier]: [&Balls; 3], formulas: &Formulas, h: f64) -> (Balls, [Singles; 2]) {
    let (c, moulton, h) = (formulas.balls, formulas.moulton.map(|weight| weight as f32), h as f32);
    let (mut new, mut on, mut missing) = (Balls::default(), Singles::default(), [Singles::default(); 2]);
    for lane in 0..LANES {
        let (v, v1, v2) = (now.arc_velocity[lane], before.arc_velocity[lane], earlier.arc_velocity[lane]);
        let arc_velocity = c.extrapolated([v, v1, v2]);
        let [moved] = weighed(&moulton, &[[arc_velocity], [v], [v1]]);
        new.arc_velocity[lane] = arc_velocity;
        let spins = [now.spin[lane], before.spin[lane], earlier.spin[lane]];
        new.spin[lane] = c.extrapolated(spins);
        (missing[0][lane], missing[1][lane]) = (c.missing([v, v1, v2]), c.missing(spins));
        on[lane] = h * moved;
    }
    // Double precision has a loop of its own.
    for lane in 0..LANES {
        new.arc[lane] = now.arc[lane] + f64::from(on[lane]);
    }
    (new, missing)
}

/// Change of eight balls by one step of Newton's method at the predicted spindle, and its slope over the spindle's velocity across the
/// balls.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Change<T = f32> {
    arc_velocity: T,
    spin: T,
    arc_by_spindle: T,
    spin_by_spindle: T,
}
side_by_side!(Change { arc_velocity, spin, arc_by_spindle, spin_by_spindle });

/// Elimination of all balls from the spindle's equations. `step`: factor of the new value in the formula of the balls, time step [s], and share
/// of the spindle's acceleration in its velocity [s].
#[inline(always)]
pub(super) fn eliminate(
    model: &RadiallyCondensed,
    step: (f32, f64, f64),
    missing: &[[Singles; 2]],
    rates: &mut Rates,
    changes: &mut [Change<Singles>],
) {
    for (group, change) in changes.iter_mut().enumerate() {
        let present = &model.present[group];
        *change = eliminated(&missing[group], &rates.balls[group], step, &model.one, present, &mut rates.passed);
    }
}

/// Elimination of eight balls from the spindle's equations, whose traction is then that of balls that follow the spindle.
#[inline(always)]
fn eliminated(
    missing: &[Singles; 2],
    rates: &BallRates<Singles>,
    (leading, h, velocity_share): (f32, f64, f64),
    one: &OneBall,
    present: &Singles,
    passed: &mut SpindleReaction<Singles>,
) -> Change<Singles> {
    let (missing, h, share, rates, present) = (*missing, h as f32, velocity_share as f32, *rates, *present);
    let (radius, per_mass, per_inertia) = (one.radius, one.per_mass, one.per_inertia);
    let (mut changes, mut sums) = (Change::<Singles>::default(), *passed);
    for lane in 0..LANES {
        let f = rates.at(lane);
        let (right_v, right_p) = (missing[0][lane] + h * f.arc_velocity, missing[1][lane] + h * f.spin);
        // A = [−a, b; d, −e]
        let (b, d) = (h * f.arc_by_spin, h * f.spin_by_arc);
        let (vv, pp) = (leading + h * f.arc_by_arc, leading + h * f.spin_by_spin);
        let per_determinant = 1.0 / (vv * pp - b * d);
        let (push_v, push_p) = (h * f.traction * per_mass, -h * f.traction * radius * per_inertia);
        let one = Change {
            arc_velocity: per_determinant * (pp * right_v + b * right_p),
            spin: per_determinant * (vv * right_p + d * right_v),
            arc_by_spindle: per_determinant * (pp * push_v + b * push_p),
            spin_by_spindle: per_determinant * (vv * push_p + d * push_v),
        };
        changes.put(lane, one);
        let (cosine, sine) = (f.azimuth.cosine, f.azimuth.sine);
        let held = present[lane] * f.traction;
        let push = held * (one.arc_velocity - radius * one.spin);
        let slope = share * held * (1.0 - one.arc_by_spindle + radius * one.spin_by_spindle);
        sums.force.0[lane] -= push * sine;
        sums.force.1[lane] += push * cosine;
        sums.slope[0][lane] += slope * sine * sine;
        sums.slope[1][lane] -= slope * sine * cosine;
        sums.slope[2][lane] += slope * cosine * cosine;
    }
    *passed = sums;
    changes
}

impl Change<Singles> {
    /// Corrects eight balls after a change of the spindle's velocity (y, z) [m/s]; `place`: share of velocities in places [s].
    #[inline(always)]
    fn correct(&self, balls: &mut Balls, azimuth: &Azimuth<Singles>, [y, z]: [f32; 2], place: f32) {
        let (mut new, mut on) = (*balls, Singles::default());
        for lane in 0..LANES {
            let (one, azimuth) = (self.at(lane), azimuth.at(lane));
            let across = z * azimuth.cosine - y * azimuth.sine;
            let change = one.arc_velocity + one.arc_by_spindle * across;
            new.arc_velocity[lane] += change;
            new.spin[lane] += one.spin + one.spin_by_spindle * across;
            on[lane] = place * change;
        }
        // Double precision has a loop of its own.
        for lane in 0..LANES {
            new.arc[lane] += f64::from(on[lane]);
        }
        *balls = new;
    }
}
