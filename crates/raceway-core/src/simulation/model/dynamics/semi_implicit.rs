//! Fixed steps through the full equations, linearly implicit in the stiff terms: one evaluation a step.
//!
//! Each ball and the cage are advanced by backward differentiation of order 2, whose equation is solved by one step of Newton
//! from an extrapolated state ŷ:
//!
//! ```text
//! y = Σ α_i y_{n+1−i} + β h (f(ŷ) + A (y − ŷ))
//! ```
//!
//! A holds the stiffest terms in closed form: the normal loads of both raceways and of the pocket, the turning of their
//! directions, and traction. Each ball gives two systems of three equations: motion in its meridian plane with the spin about the
//! orbit, and motion along the orbit with the other spins. The cage is solved entry by entry. Terms outside A are explicit, which
//! costs stability and not order. The spindle, hundreds of times as heavy, is predicted by Adams–Bashforth and corrected by
//! Adams–Moulton under the loads after the balls' corrections. Long steps damp contact resonances far above the band of interest, as in
//! a radially condensed ball. They do not resolve a collision of balls, at which the method ends.

pub(super) mod correction;

use std::array::from_fn;
use std::cell::{Cell, OnceCell};

use super::ball_group::{Balls, Slopes};
use super::border::{Border, OuterRing};
use super::equations::{Dynamics, Rings};
use super::forces::Reaction;
use crate::numerics::lanes::{LANES, Lanes, SideBySide, Task};
use crate::numerics::ode::adams::{Weights, ahead, weights};
use crate::numerics::ode::{Choice, ChoiceReason, IntegrationError, Integrator, Method, Statistics};
use crate::physics::frames::Vector;
use crate::simulation::model::state::{BallAttitude, BallState, CageState, SpindleState};
use crate::simulation::model::step_loads::PackedStepLoads;
use correction::{Corrected, RingResistance, Stiff, corrected_cage};

/// Nodes of the spindle's formulas, and number of stored states.
const NODES: usize = 4;
/// Short steps to one of full length at the start.
const START: usize = 16;

/// Backward differentiation y = Σ past_i y_{n−i} + rate · h f, and extrapolation by the same nodes.
#[derive(Debug, Clone, Copy)]
struct Backward {
    past: [f64; 2],
    rate: f64,
    ahead: [f64; 2],
}

const BACKWARD: [Backward; 2] = [
    Backward { past: [1.0, 0.0], rate: 1.0, ahead: [1.0, 0.0] },
    Backward { past: [4.0 / 3.0, -1.0 / 3.0], rate: 2.0 / 3.0, ahead: [2.0, -1.0] },
];

/// Formulas of a step with a given number of known nodes.
#[derive(Debug, Clone, Copy)]
struct Formulas {
    backward: Backward,
    /// Prediction of the spindle through the known nodes.
    predict: Weights<NODES>,
    /// Correction of the spindle through the new node and all others but the oldest.
    correct: Weights<NODES>,
    /// Acceleration for which both formulas agree.
    ahead: [f64; NODES],
}

impl Formulas {
    fn new(known: usize) -> Self {
        // A single node allows no correction.
        let nothing = Weights { velocity: [0.0; NODES], place: [0.0; NODES] };
        Self {
            backward: BACKWARD[known.min(2) - 1],
            predict: weights(0.0, known),
            correct: if known > 1 { weights(1.0, known) } else { nothing },
            ahead: ahead(known),
        }
    }
}

/// State and rates at one time.
#[derive(Debug, Clone)]
pub(super) struct Node {
    balls: Vec<BallState<Lanes>>,
    rates: Vec<BallState<Lanes>>,
    /// Attitudes of the balls and their rates; empty where they have none.
    attitudes: Vec<[BallAttitude<Lanes>; 2]>,
    cage: CageState,
    cage_rates: CageState,
    spindle: SpindleState,
    /// Acceleration of the spindle [m/s²].
    acceleration: Vector,
}

/// Integrator with its last states.
pub(super) struct SemiImplicit<'m, const PLANAR: bool> {
    dynamics: &'m Dynamics<PLANAR>,
    /// Predicted motion of an outer ring that moves.
    outer: Option<SpindleState>,
    /// Requested step [s].
    asked: f64,
    /// Actual step [s], which divides the time to the next stop.
    step: f64,
    time: f64,
    previous: f64,
    /// Newest first.
    nodes: [Box<Node>; NODES],
    /// Number of valid nodes; 0: the method has to start.
    known: usize,
    formulas: Formulas,
    /// Work space for one group of balls after the other.
    balls: Balls,
    slopes: Slopes<Lanes>,
    corrected: Corrected,
    work: Statistics,
    /// Predicted states, and their rates caused by neighbouring balls, where there is no cage.
    predicted: Vec<f64>,
    neighbour_rates: Vec<f64>,
    /// A ball that touches the next one.
    touching: Option<usize>,
    /// The newest node as a state, on request.
    flat: OnceCell<Vec<f64>>,
    /// Work space for the next such state.
    room: Cell<Vec<f64>>,
    /// Loads at the newest node, packed.
    step_loads: Vec<f64>,
}

impl<'m, const PLANAR: bool> SemiImplicit<'m, PLANAR> {
    pub(super) fn new(dynamics: &'m Dynamics<PLANAR>, time: f64, state: &[f64], step: f64) -> Self {
        let layout = dynamics.mechanism().layout;
        let groups = (0..layout.balls).step_by(LANES);
        let balls: Vec<_> = groups.clone().map(|first| layout.side_by_side::<PLANAR>(state, first)).collect();
        let rotations = dynamics.mechanism().rotations(time);
        let attitudes = groups.filter(|_| layout.attitude).zip(&balls).map(|(first, balls)| {
            let attitudes = layout.attitudes(state, first);
            [attitudes, dynamics.attitude_rates(balls, &attitudes, &rotations)]
        });
        let node = Box::new(Node {
            attitudes: attitudes.collect(),
            rates: balls.iter().map(rates_of_places).collect(),
            balls,
            cage: layout.cage(state),
            cage_rates: CageState::default(),
            spindle: layout.spindle(state),
            acceleration: [0.0; 3],
        });
        let nodes = from_fn(|_| node.clone());
        let (work, formulas) = (Statistics::default(), Formulas::new(1));
        let balls = Balls::new(layout.tilting_spindle);
        let (slopes, corrected) = (Slopes::default(), Corrected::default());
        let (previous, flat, room) = (time, OnceCell::new(), Cell::new(vec![0.0; layout.dimension()]));
        let step_loads = vec![0.0; PackedStepLoads::numbers(layout.balls.div_ceil(LANES))];
        Self {
            dynamics,
            outer: None,
            asked: step,
            step,
            time,
            previous,
            nodes,
            known: 0,
            formulas,
            balls,
            slopes,
            corrected,
            work,
            predicted: vec![0.0; layout.dimension()],
            neighbour_rates: vec![0.0; layout.dimension()],
            touching: None,
            flat,
            room,
            step_loads,
        }
    }

    /// Starts with the initial acceleration and short steps of rising order; every sixteenth of them becomes a node of the long steps.
    fn start(&mut self, limit: f64) {
        let layout = self.dynamics.mechanism().layout;
        let mut rates = vec![0.0; layout.dimension()];
        self.dynamics.evaluate(self.time, self.state(), &mut rates, None);
        self.nodes[0].acceleration = layout.spindle(&rates).velocity;
        (self.known, self.formulas) = (1, Formulas::new(1));
        let whole = (limit - self.time) / ((limit - self.time) / self.asked - 1e-6).ceil().max(NODES as f64);
        self.step = whole / START as f64;
        let mut past = Vec::with_capacity(NODES);
        for short in 0..(NODES - 1) * START {
            if short % START == 0 {
                past.push(self.nodes[0].clone());
            }
            self.advance(limit);
        }
        for (node, old) in self.nodes[1..].iter_mut().zip(past.into_iter().rev()) {
            *node = old;
        }
        self.step = whole;
        self.work.steps += NODES as u64 - 1;
    }

    /// One step, compiled for the processor's instructions. Whole steps end exactly at `limit`, because beyond a kink of the speed
    /// they would use the slope after it.
    fn advance(&mut self, limit: f64) {
        let end = self.time + self.step;
        let end = if (limit - end).abs() < 1e-3 * self.step { limit } else { end };
        self.previous = self.time;
        self.time = end;
        self.dynamics.instructions().run(Step { integrator: self });
        self.count_step();
    }

    /// Starts again at the newest state with formulas of low order, for short steps by the caller.
    pub(super) fn begin(&mut self) {
        (self.known, self.formulas) = (1, Formulas::new(1));
    }

    pub(super) fn newest(&self) -> Node {
        Node::clone(&self.nodes[0])
    }

    /// Replaces the nodes before the newest.
    pub(super) fn set_past(&mut self, past: impl Iterator<Item = Node>) {
        for (node, old) in self.nodes[1..].iter_mut().zip(past) {
            **node = old;
        }
    }

    /// Begins a step to a time and a predicted motion of the rings.
    pub(super) fn aim(&mut self, end: f64, step: f64, rings: Rings) {
        self.step = step;
        self.previous = self.time;
        self.time = end;
        self.nodes.rotate_right(1);
        self.nodes[0].spindle = rings.inner;
        self.outer = rings.outer;
    }

    /// Advances balls and cage at a predicted motion of the rings. Returns force and moment on the inner and the outer ring, and the resistances to
    /// their motion.
    #[inline(always)]
    pub(super) fn advance_on_ring(&mut self) -> [(Vector, Vector, RingResistance); 2] {
        let BearingStep { reaction, moment, resistance, on_outer, outer_resistance, .. } =
            self.advance_bearing_by::<true>((0.0, 0.0));
        [(reaction.spindle, moment, resistance), (on_outer[0], on_outer[1], outer_resistance)]
    }

    /// Ends a step.
    pub(super) fn end_step(&mut self) {
        self.count_step();
    }

    pub(super) fn dynamics(&self) -> &'m Dynamics<PLANAR> {
        self.dynamics
    }

    pub(super) fn loads(&self) -> &[f64] {
        &self.step_loads
    }

    pub(super) fn newest_state(&self) -> &[f64] {
        self.state()
    }

    pub(super) fn touching(&self) -> Option<usize> {
        self.touching
    }

    fn count_step(&mut self) {
        if self.known < NODES {
            self.known += 1;
            self.formulas = Formulas::new(self.known);
        }
        self.work.rhs_evaluations += 1;
        self.work.factorizations += 1;
        if let Some(old) = self.flat.take() {
            self.room.set(old);
        }
    }

    #[inline(always)]
    fn advance_by(&mut self) {
        let (dynamics, h) = (self.dynamics, self.step);
        let Formulas { predict, correct, ahead, .. } = self.formulas;
        let shares = (h * h * correct.place[0], h * correct.velocity[0]);
        self.nodes.rotate_right(1);
        let accelerations: [Vector; NODES] = from_fn(|i| self.nodes[(i + 1) % NODES].acceleration);

        // Prediction of the spindle.
        let rise = weighed(&predict.velocity, &accelerations);
        let lift = weighed(&predict.place, &accelerations);
        let foreseen = weighed(&ahead, &accelerations);
        let a = self.nodes[1].spindle;
        self.nodes[0].spindle = SpindleState {
            position: from_fn(|i| a.position[i] + h * (a.velocity[i] + h * lift[i])),
            velocity: from_fn(|i| a.velocity[i] + h * rise[i]),
            ..a
        };
        let BearingStep { border, reaction, stiff, .. } = self.advance_bearing_by::<false>(shares);

        // Spindle, under the loads after the balls' corrections.
        let mut acceleration = dynamics.spindle_rates(&border, reaction.spindle, [0.0; 3]).velocity;
        if !dynamics.mechanism().layout.axial_spindle {
            acceleration[0] = 0.0;
        }
        let per_mass = 1.0 / dynamics.mechanism().spindle_mass;
        let change: Vector = from_fn(|i| (acceleration[i] - foreseen[i]) / (1.0 + stiff.spindle[i] * per_mass));
        let new = &mut *self.nodes[0];
        new.acceleration = from_fn(|i| foreseen[i] + change[i]);
        for (i, change) in change.into_iter().enumerate() {
            new.spindle.position[i] += shares.0 * change;
            new.spindle.velocity[i] += shares.1 * change;
        }
        self.step_loads[..3].copy_from_slice(&new.acceleration);
    }

    /// Advances balls and cage to the newest node, whose spindle is predicted. `shares`: of the spindle's place and velocity in the step.
    /// `RING`: the spindle may tilt, and its resistance counts in all directions.
    #[inline(always)]
    fn advance_bearing_by<const RING: bool>(&mut self, shares: (f64, f64)) -> BearingStep {
        let (dynamics, h, layout) = (self.dynamics, self.step, self.dynamics.mechanism().layout);
        let before_step = self.previous;
        let formula = self.formulas.backward;
        let share = h * formula.rate;
        let [new, now, before, ..] = self.nodes.each_mut().map(|node| &mut **node);
        let past_cage = formula.past_of_cage(&now.cage, &before.cage);
        let cage = formula.predicted_cage(&now.cage, &before.cage, &past_cage, share);
        let mut border = dynamics.border(cage, new.spindle, self.time);
        if RING {
            border.outer = self.outer.map(OuterRing::new);
        }

        let neighbours = dynamics.mechanism().neighbours.as_ref();
        if let Some(contact) = neighbours {
            for group in 0..now.balls.len() {
                let (_, predicted) = formula.predicted_balls(&now.balls[group], &before.balls[group], share);
                layout.set_side_by_side::<PLANAR>(&mut self.predicted, group * LANES, &predicted);
            }
            self.neighbour_rates.fill(0.0);
            let (states, touching) = ((&self.predicted[..], &mut self.neighbour_rates[..]), &mut self.touching);
            dynamics.add_neighbours(contact, states, &border.rotations, |ball, load| {
                if load.penetration > 0.0 {
                    *touching = Some(ball);
                }
            });
        }

        // Balls.
        let mut sum = Reaction::default();
        let mut stiff = Stiff::default();
        let (mut moment, mut resistance) = ([0.0; 3], RingResistance::default());
        let (mut on_outer, mut outer_resistance) = ([[0.0; 3]; 2], RingResistance::default());
        let (balls, slopes, corrected) = (&mut self.balls, &mut self.slopes, &mut self.corrected);
        for group in 0..now.balls.len() {
            let first = group * LANES;
            let (past, predicted) = formula.predicted_balls(&now.balls[group], &before.balls[group], share);
            let rotations = [&dynamics.mechanism().rotations(before_step), &border.rotations];
            if let Some([attitude, _]) = now.attitudes.get(group) {
                let advanced = dynamics.advanced_attitudes(attitude, [&now.balls[group], &predicted], rotations, h);
                balls.attitude = Some([advanced, BallAttitude::default()]);
            }
            dynamics.balls(first, &predicted, &border, balls, None, Some(slopes));
            if neighbours.is_some() {
                let caused = layout.side_by_side::<PLANAR>(&self.neighbour_rates, first);
                for lane in 0..LANES {
                    balls.rates.put(lane, balls.rates.at(lane).combined(1.0, &caused.at(lane), 1.0));
                }
            }
            dynamics.correct(first, &past, &predicted, balls, slopes, share, corrected);
            (new.balls[group], new.rates[group]) = (corrected.state, corrected.rates);
            if let Some([attitude, _]) = now.attitudes.get(group) {
                let states = [&now.balls[group], &corrected.state];
                let attitude = dynamics.advanced_attitudes(attitude, states, rotations, h);
                new.attitudes[group] =
                    [attitude, dynamics.attitude_rates(&corrected.state, &attitude, &border.rotations)];
            }
            corrected.loads.put_into(&mut self.step_loads, group);
            balls.reaction.sum_into(&mut sum, layout.balls - first);
            corrected.reaction.sum_into(&mut sum, layout.balls - first);
            dynamics.stiffness(balls, slopes, shares, share).sum_into(&mut stiff, layout.balls - first);
            if RING {
                balls.add_on_tilt(&mut moment, layout.balls - first);
                dynamics.add_to_ring(layout.balls - first, (balls, slopes, corrected), &mut moment, &mut resistance);
                if border.outer.is_some() {
                    balls.add_on_outer(&mut on_outer, layout.balls - first);
                    let moved = (&*balls, &*slopes, &predicted, &*corrected);
                    dynamics.add_to_outer(layout.balls - first, moved, share, &mut on_outer, &mut outer_resistance);
                }
            }
        }
        if RING {
            dynamics.add_land(&border, &mut on_outer);
        }

        // Cage, under the loads after the balls' corrections.
        let mut rates = dynamics.cage_rates(&border, &sum);
        if PLANAR {
            rates = in_plane(rates);
        }
        if layout.cage {
            let response = dynamics.cage_stiffness(&stiff);
            (new.cage, new.cage_rates) = corrected_cage(&past_cage, &cage, &rates, &response, share);
        }
        BearingStep { border, reaction: sum, stiff, moment, resistance, on_outer, outer_resistance }
    }
}

/// Balls and cage after a step: what they exert on the spindle.
struct BearingStep {
    border: Border,
    reaction: Reaction,
    stiff: Stiff,
    /// On a ring that tilts, about its centre, inertial frame [N m].
    moment: Vector,
    resistance: RingResistance,
    /// Force and moment on an outer ring that moves, about its centre, inertial frame [N, N m].
    on_outer: [Vector; 2],
    outer_resistance: RingResistance,
}

/// One step, compiled for each instruction set.
struct Step<'a, 'm, const PLANAR: bool> {
    integrator: &'a mut SemiImplicit<'m, PLANAR>,
}

impl<const PLANAR: bool> Task for Step<'_, '_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.integrator.advance_by();
    }
}

/// Σ weight · value.
#[inline(always)]
fn weighed(weights: &[f64; NODES], values: &[Vector; NODES]) -> Vector {
    from_fn(|i| weights.iter().zip(values).map(|(weight, value)| weight * value[i]).sum())
}

impl Backward {
    /// Σ past_i y_{n−i} of the balls, and their predicted state: velocities by extrapolation, places by integration of these.
    #[inline(always)]
    fn predicted_balls(
        self,
        now: &BallState<Lanes>,
        before: &BallState<Lanes>,
        share: f64,
    ) -> (BallState<Lanes>, BallState<Lanes>) {
        let (mut past, mut predicted) = (BallState::default(), BallState::default());
        for lane in 0..LANES {
            let (a, b) = (now.at(lane), before.at(lane));
            let old = a.combined(self.past[0], &b, self.past[1]);
            let mut ahead = a.combined(self.ahead[0], &b, self.ahead[1]);
            ahead.axial = old.axial + share * ahead.axial_velocity;
            ahead.radial = old.radial + share * ahead.radial_velocity;
            ahead.arc = old.arc + share * ahead.arc_velocity;
            past.put(lane, old);
            predicted.put(lane, ahead);
        }
        (past, predicted)
    }

    fn past_of_cage(self, now: &CageState, before: &CageState) -> CageState {
        now.combined(self.past[0], before, self.past[1])
    }

    fn predicted_cage(self, now: &CageState, before: &CageState, past: &CageState, share: f64) -> CageState {
        let ahead = now.combined(self.ahead[0], before, self.ahead[1]);
        CageState {
            centre: from_fn(|i| past.centre[i] + share * ahead.velocity[i]),
            arc: past.arc + share * ahead.arc_velocity,
            tilt: from_fn(|i| past.tilt[i] + share * ahead.tilt_rate[i]),
            ..ahead
        }
    }
}

/// Rates of the cage without motion along X and tilt, which pockets of a crown cage would drive.
fn in_plane(cage: CageState) -> CageState {
    let without_x = |[_, y, z]: Vector| [0.0, y, z];
    CageState {
        centre: without_x(cage.centre),
        tilt: [0.0; 2],
        velocity: without_x(cage.velocity),
        tilt_rate: [0.0; 2],
        ..cage
    }
}

/// The rates of a ball's places are its velocities.
#[inline(always)]
fn rates_of_places(state: &BallState<Lanes>) -> BallState<Lanes> {
    BallState {
        axial: state.axial_velocity,
        radial: state.radial_velocity,
        arc: state.arc_velocity,
        ..BallState::default()
    }
}

impl<const PLANAR: bool> Integrator for SemiImplicit<'_, PLANAR> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        // The method starts again where whole steps do not meet the stop.
        if self.known > 0 && self.time + self.step > limit + 1e-3 * self.step {
            self.known = 0;
        }
        if self.known == 0 {
            let from = self.time;
            self.start(limit);
            self.previous = from;
            self.work.advanced += self.time - from;
        } else {
            self.advance(limit);
            self.work.accept(self.step, false);
        }
        if let Some(ball) = self.touching {
            let component = ball * self.dynamics.mechanism().layout.ball_size();
            return Err(IntegrationError::Impact { time: self.time, step: self.step, component });
        }
        let Node { acceleration, cage, .. } = &*self.nodes[0];
        let moves = acceleration.iter().chain(&cage.velocity).chain([&cage.arc_velocity]).all(|x| x.is_finite());
        if !moves {
            let component = self.dynamics.mechanism().layout.dimension() - 1;
            return Err(IntegrationError::NotFinite { time: self.time, step: self.step, component });
        }
        Ok(())
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn previous_time(&self) -> f64 {
        self.previous
    }

    fn state(&self) -> &[f64] {
        self.flat.get_or_init(|| {
            let (layout, node) = (self.dynamics.mechanism().layout, &*self.nodes[0]);
            let mut state = self.room.take();
            for (group, balls) in node.balls.iter().enumerate() {
                layout.set_side_by_side::<PLANAR>(&mut state, group * LANES, balls);
            }
            for (group, [attitudes, _]) in node.attitudes.iter().enumerate() {
                layout.set_attitudes(&mut state, group * LANES, attitudes);
            }
            layout.set_cage(&mut state, &node.cage);
            layout.set_spindle(&mut state, &node.spindle);
            state
        })
    }

    fn sight(&self) -> Option<&[f64]> {
        Some(&self.step_loads)
    }

    /// Cubic interpolation through places or velocities and their rates at both ends.
    fn interpolate(&self, time: f64, state: &mut [f64]) {
        let layout = self.dynamics.mechanism().layout;
        // The start takes several steps at once.
        let (h, back) = (self.step, (self.time - time) / self.step);
        let behind = (back as usize).min(NODES - 2);
        let (old, new) = (&*self.nodes[behind + 1], &*self.nodes[behind]);
        let x = 1.0 + behind as f64 - back;
        let (x2, x3) = (x * x, x * x * x);
        let after = 3.0 * x2 - 2.0 * x3;
        let (value, rate) = ([1.0 - after, after], [h * (x - 2.0 * x2 + x3), h * (x3 - x2)]);
        for group in 0..new.balls.len() {
            let mut balls = BallState::default();
            for lane in 0..LANES {
                let values = old.balls[group].at(lane).combined(value[0], &new.balls[group].at(lane), value[1]);
                let rates = old.rates[group].at(lane).combined(rate[0], &new.rates[group].at(lane), rate[1]);
                balls.put(lane, values.combined(1.0, &rates, 1.0));
            }
            layout.set_side_by_side::<PLANAR>(state, group * LANES, &balls);
        }
        for (group, (old, new)) in old.attitudes.iter().zip(&new.attitudes).enumerate() {
            let mut attitudes = BallAttitude::default();
            for lane in 0..LANES {
                let ([a, a_rate], [b, b_rate]) = (old.at(lane), new.at(lane));
                let rates = a_rate.combined(rate[0], &b_rate, rate[1]);
                attitudes.put(lane, a.combined(value[0], &b, value[1]).combined(1.0, &rates, 1.0));
            }
            layout.set_attitudes(state, group * LANES, &attitudes);
        }
        let cage = old.cage.combined(value[0], &new.cage, value[1]);
        let rates = old.cage_rates.combined(rate[0], &new.cage_rates, rate[1]);
        layout.set_cage(state, &cage.combined(1.0, &rates, 1.0));
        let blend = |a: Vector, b: Vector, da: Vector, db: Vector| -> Vector {
            from_fn(|i| value[0] * a[i] + value[1] * b[i] + rate[0] * da[i] + rate[1] * db[i])
        };
        let (a, b) = (old.spindle, new.spindle);
        let position = blend(a.position, b.position, a.velocity, b.velocity);
        let velocity = blend(a.velocity, b.velocity, old.acceleration, new.acceleration);
        layout.set_spindle(state, &SpindleState { position, velocity, ..b });
    }

    fn restart(&mut self) {
        self.known = 0;
        self.time = self.time.next_up();
    }

    fn statistics(&self) -> Statistics {
        self.work
    }

    fn choice(&self) -> Choice {
        Choice { method: Method::SemiImplicit, reason: Some(ChoiceReason::TriedFirst { step: self.step }) }
    }
}
