//! Steps of fixed length through the full equations, linearly implicit in what is stiff: one evaluation a step.
//!
//! Each ball and the cage are advanced by backward differentiation of order 2, whose equation is solved by one step of Newton
//! from an extrapolated state ŷ:
//!
//! ```text
//! y = Σ α_i y_{n+1−i} + β h (f(ŷ) + A (y − ŷ))
//! ```
//!
//! A holds what answers fastest, from closed forms: the normal loads of both raceways and of the pocket, the turning of their
//! directions, and traction. A ball is two systems of three equations, motion in its meridian plane with the spin about the
//! orbit, and motion along the orbit with the other spins; the cage is taken entry by entry. What A leaves out is explicit and
//! costs stability, not order. The spindle, hundreds of times as heavy, is predicted by Adams–Bashforth and corrected by
//! Adams–Moulton, under the loads that the balls' corrections leave. Contacts that ring far above the band of interest are damped
//! by long steps, as a radially condensed ball is.

use std::array::from_fn;
use std::cell::{Cell, OnceCell};

use super::Dynamics;
use super::dynamics::{Balls, Reaction, Slopes};
use super::sight::{Seen, Sight};
use crate::numerics::lanes::{LANES, Lanes, SideBySide, Task, larger, side_by_side};
use crate::numerics::ode::adams::{Weights, ahead, weights};
use crate::numerics::ode::{Choice, IntegrationError, Integrator, Method, Statistics};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Vector, cross, dot, scale};
use crate::physics::pocket::PocketSlopes;
use crate::physics::raceway::ContactSlopes;
use crate::simulation::state::{BallState, CageState, SpindleState};

/// Nodes of the spindle's formulas; as many states are remembered.
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

/// Formulas of a step after so many nodes.
#[derive(Debug, Clone, Copy)]
struct Formulas {
    backward: Backward,
    /// Of the spindle: through the known nodes, and through the new one and the others but the oldest.
    predict: Weights<NODES>,
    correct: Weights<NODES>,
    /// The acceleration with which the one formula is the other.
    ahead: [f64; NODES],
}

impl Formulas {
    fn new(known: usize) -> Self {
        // From a single node there is nothing to correct by.
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
struct Node {
    balls: Vec<BallState<Lanes>>,
    rates: Vec<BallState<Lanes>>,
    cage: CageState,
    cage_rates: CageState,
    spindle: SpindleState,
    /// Of the spindle.
    acceleration: Vector,
}

/// The motion on its way.
pub(super) struct SemiImplicit<'m, const PLANAR: bool> {
    dynamics: &'m Dynamics<PLANAR>,
    /// Step that was asked for; that which is taken divides the time to the next stop.
    asked: f64,
    step: f64,
    time: f64,
    previous: f64,
    /// Newest first.
    nodes: [Box<Node>; NODES],
    /// How many of them count; 0: the method has to start.
    known: usize,
    formulas: Formulas,
    /// Room for one group of balls after the other.
    balls: Balls,
    slopes: Slopes<Lanes>,
    corrected: Corrected,
    work: Statistics,
    /// The newest node as a state where that was asked for, room for the next, and what was seen at the node.
    flat: OnceCell<Vec<f64>>,
    room: Cell<Vec<f64>>,
    sight: Vec<f64>,
}

impl<'m, const PLANAR: bool> SemiImplicit<'m, PLANAR> {
    pub fn new(dynamics: &'m Dynamics<PLANAR>, time: f64, state: &[f64], step: f64) -> Self {
        let layout = dynamics.mechanism().layout;
        let groups = (0..layout.balls).step_by(LANES);
        let balls: Vec<_> = groups.map(|first| layout.side_by_side::<PLANAR>(state, first)).collect();
        let node = Box::new(Node {
            rates: balls.iter().map(rates_of_places).collect(),
            balls,
            cage: layout.cage(state),
            cage_rates: CageState::default(),
            spindle: layout.spindle(state),
            acceleration: [0.0; 3],
        });
        let nodes = from_fn(|_| node.clone());
        let (work, formulas) = (Statistics::default(), Formulas::new(1));
        let (balls, slopes, corrected) = (Balls::default(), Slopes::default(), Corrected::default());
        let (previous, flat, room) = (time, OnceCell::new(), Cell::new(vec![0.0; layout.dimension()]));
        let sight = vec![0.0; Sight::numbers(layout.balls.div_ceil(LANES))];
        Self {
            dynamics,
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
            flat,
            room,
            sight,
        }
    }

    /// Initial acceleration, then short steps of rising order, and every sixteenth of them as the past of the long ones.
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

    /// One step, compiled for the processor's instructions. Whole steps lead to `limit`, to rounding, and end at it: beyond a kink of
    /// the speed they would see the slope after it.
    fn advance(&mut self, limit: f64) {
        let end = self.time + self.step;
        let end = if (limit - end).abs() < 1e-3 * self.step { limit } else { end };
        self.previous = self.time;
        self.time = end;
        self.dynamics.instructions().run(Step { integrator: self });
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
        let (dynamics, h, layout) = (self.dynamics, self.step, self.dynamics.mechanism().layout);
        let Formulas { backward: formula, predict, correct, ahead } = self.formulas;
        let share = h * formula.rate;
        let shares = (h * h * correct.place[0], h * correct.velocity[0]);
        self.nodes.rotate_right(1);
        let accelerations: [Vector; NODES] = from_fn(|i| self.nodes[(i + 1) % NODES].acceleration);
        let [new, now, before, ..] = self.nodes.each_mut().map(|node| &mut **node);

        // Prediction.
        let rise = weighed(&predict.velocity, &accelerations);
        let lift = weighed(&predict.place, &accelerations);
        let foreseen = weighed(&ahead, &accelerations);
        let a = now.spindle;
        new.spindle = SpindleState {
            position: from_fn(|i| a.position[i] + h * (a.velocity[i] + h * lift[i])),
            velocity: from_fn(|i| a.velocity[i] + h * rise[i]),
        };
        let past_cage = formula.past_of_cage(&now.cage, &before.cage);
        let cage = formula.predicted_cage(&now.cage, &before.cage, &past_cage, share);
        let border = dynamics.border(cage, new.spindle, dynamics.mechanism().speed.at(self.time));

        // Balls.
        let mut sum = Reaction::default();
        let mut stiff = Stiff::default();
        let (balls, slopes, corrected) = (&mut self.balls, &mut self.slopes, &mut self.corrected);
        for group in 0..now.balls.len() {
            let first = group * LANES;
            let (past, predicted) = formula.predicted_balls(&now.balls[group], &before.balls[group], share);
            dynamics.balls(first, &predicted, &border, balls, None, Some(slopes));
            dynamics.correct(&past, &predicted, balls, slopes, share, corrected);
            (new.balls[group], new.rates[group]) = (corrected.state, corrected.rates);
            corrected.seen.put_into(&mut self.sight, group);
            balls.reaction.sum_into(&mut sum, layout.balls - first);
            corrected.reaction.sum_into(&mut sum, layout.balls - first);
            dynamics.stiffness(balls, slopes, shares, share).sum_into(&mut stiff, layout.balls - first);
        }

        // Cage and spindle, under what the balls' corrections leave.
        let mut rates = dynamics.cage_rates(&border.cage, &border.pose, &sum, border.shaft);
        if PLANAR {
            rates = in_plane(rates);
        }
        if layout.cage {
            let response = dynamics.cage_stiffness(&stiff);
            (new.cage, new.cage_rates) = corrected_cage(&past_cage, &cage, &rates, &response, share);
        }
        let mut acceleration = dynamics.spindle_rates(&border.spindle, sum.spindle, border.shaft).velocity;
        if !layout.axial_spindle {
            acceleration[0] = 0.0;
        }
        let per_mass = 1.0 / dynamics.mechanism().spindle_mass;
        let change: Vector = from_fn(|i| (acceleration[i] - foreseen[i]) / (1.0 + stiff.spindle[i] * per_mass));
        new.acceleration = from_fn(|i| foreseen[i] + change[i]);
        for (i, change) in change.into_iter().enumerate() {
            new.spindle.position[i] += shares.0 * change;
            new.spindle.velocity[i] += shares.1 * change;
        }
        self.sight[..3].copy_from_slice(&new.acceleration);
    }
}

/// One step, to be compiled for each instruction set.
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

/// What a further motion passes on to the border per unit of it: stiffness and damping, by the shares that a step has of them.
#[derive(Debug, Clone, Copy, Default)]
struct Stiff<T = f64> {
    /// Spindle, by direction of the inertial frame, times the step's shares [kg].
    spindle: Vector<T>,
    /// Cage, along and about its axes, times the step's share [N s/m, N m s].
    cage: Vector<T>,
    about: Vector<T>,
}
side_by_side!(Stiff { spindle, cage, about });

impl Stiff<Lanes> {
    /// Adds those of the first `balls` lanes to `sum`, one ball after the other.
    #[inline(always)]
    fn sum_into(&self, sum: &mut Stiff, balls: usize) {
        for lane in 0..LANES.min(balls) {
            let one = self.at(lane);
            for i in 0..3 {
                sum.spindle[i] += one.spindle[i];
                sum.cage[i] += one.cage[i];
                sum.about[i] += one.about[i];
            }
        }
    }
}

/// Balls at the end of a step.
#[derive(Debug, Clone, Copy, Default)]
struct Corrected {
    state: BallState<Lanes>,
    rates: BallState<Lanes>,
    /// What the correction passes on to cage and spindle.
    reaction: Reaction<Lanes>,
    /// Loads and slip after it.
    seen: Seen<Lanes>,
}

impl Backward {
    /// Σ past_i y_{n−i} of the balls, and their predicted state: velocities by extrapolation, places as these take them.
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

/// Without motion along X and tilts, which pockets of a crown cage would drive.
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

/// Places of a cage take its predicted rates and what the velocities are corrected by.
fn corrected_cage(
    past: &CageState,
    predicted: &CageState,
    rates: &CageState,
    stiffness: &CageState,
    share: f64,
) -> (CageState, CageState) {
    let change = |past: f64, predicted: f64, rate: f64, stiffness: f64| {
        (past + share * rate - predicted) / (1.0 + share * stiffness)
    };
    let velocity: Vector =
        from_fn(|i| change(past.velocity[i], predicted.velocity[i], rates.velocity[i], stiffness.velocity[i]));
    let arc = change(past.arc_velocity, predicted.arc_velocity, rates.arc_velocity, stiffness.arc_velocity);
    let tilt: [f64; 2] =
        from_fn(|i| change(past.tilt_rate[i], predicted.tilt_rate[i], rates.tilt_rate[i], stiffness.tilt_rate[i]));
    let state = CageState {
        centre: from_fn(|i| past.centre[i] + share * (rates.centre[i] + velocity[i])),
        arc: past.arc + share * (rates.arc + arc),
        tilt: from_fn(|i| past.tilt[i] + share * (rates.tilt[i] + tilt[i])),
        velocity: from_fn(|i| predicted.velocity[i] + velocity[i]),
        arc_velocity: predicted.arc_velocity + arc,
        tilt_rate: from_fn(|i| predicted.tilt_rate[i] + tilt[i]),
    };
    (state, state.combined(1.0 / share, past, -1.0 / share))
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

/// Solution of a symmetric, positive definite system of three equations; the matrix as xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn solve([xx, xy, xz, yy, yz, zz]: [f64; 6], [a, b, c]: Vector) -> Vector {
    let (xx_, xy_, xz_) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let per_determinant = 1.0 / (xx * xx_ + xy * xy_ + xz * xz_);
    let (yy_, yz_, zz_) = (xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy);
    [
        per_determinant * (xx_ * a + xy_ * b + xz_ * c),
        per_determinant * (xy_ * a + yy_ * b + yz_ * c),
        per_determinant * (xz_ * a + yz_ * b + zz_ * c),
    ]
}

/// What a contact adds to the system of a ball: outer products of directions with their strengths.
#[inline(always)]
fn add_product(matrix: &mut [f64; 6], strength: f64, [x, y, z]: Vector) {
    let [sx, sy] = [strength * x, strength * y];
    matrix[0] += sx * x;
    matrix[1] += sx * y;
    matrix[2] += sx * z;
    matrix[3] += sy * y;
    matrix[4] += sy * z;
    matrix[5] += strength * z * z;
}

/// The answer of one contact over a step: directions that it resists, with their strengths [N s/m]; the first three of (axial
/// velocity, radial velocity, spin about the orbit), the last of (orbit velocity, spin about x, spin about the radius).
struct Answer {
    normal: (f64, Vector),
    turning: (f64, Vector),
    across: (f64, Vector),
    along: (f64, Vector),
}

impl Answer {
    #[inline(always)]
    fn of(slopes: &ContactSlopes, radius: f64, share: f64) -> Self {
        let (a, r) = slopes.towards;
        Self {
            normal: (share * slopes.stiffness + slopes.damping, [a, r, 0.0]),
            turning: (share * slopes.turning, [-r, a, 0.0]),
            across: (slopes.grip, [-r, a, radius]),
            along: (slopes.grip, [1.0, radius * r, -radius * a]),
        }
    }

    /// Adds what resists to both systems.
    #[inline(always)]
    fn add_to(&self, meridian: &mut [f64; 6], orbit: &mut [f64; 6]) {
        add_product(meridian, self.normal.0, self.normal.1);
        add_product(meridian, self.turning.0, self.turning.1);
        add_product(meridian, self.across.0, self.across.1);
        add_product(orbit, self.along.0, self.along.1);
    }

    /// Force on the ball that a change of its velocities brings.
    #[inline(always)]
    fn force(&self, meridian: Vector, orbit: Vector) -> Vector {
        let pull = |(strength, direction): (f64, Vector), change: Vector| -strength * dot(direction, change);
        let (normal, turning, across) =
            (pull(self.normal, meridian), pull(self.turning, meridian), pull(self.across, meridian));
        let in_plane = |i: usize| normal * self.normal.1[i] + turning * self.turning.1[i] + across * self.across.1[i];
        [in_plane(0), in_plane(1), pull(self.along, orbit)]
    }

    /// Normal load after a change of the ball's velocities, where there was one.
    #[inline(always)]
    fn load(&self, before: f64, meridian: Vector) -> f64 {
        larger(before + self.normal.0 * dot(self.normal.1, meridian), 0.0)
    }

    /// Square of the slip after it: what the ball gains the raceway loses.
    #[inline(always)]
    fn slip_square(&self, (along, across): (f64, f64), meridian: Vector, orbit: Vector) -> f64 {
        let (along, across) = (along - dot(self.along.1, orbit), across - dot(self.across.1, meridian));
        along * along + across * across
    }
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    /// Balls at the end of a step: one step of Newton from the predicted state.
    #[inline(always)]
    fn correct(
        &self,
        past: &BallState<Lanes>,
        predicted: &BallState<Lanes>,
        balls: &Balls,
        slopes: &Slopes<Lanes>,
        share: f64,
        corrected: &mut Corrected,
    ) {
        let m = self.mechanism();
        let (mass, inertia, radius) = (m.ball_mass, m.ball_inertia, m.ball_radius);
        for lane in 0..LANES {
            let (old, from, rates) = (past.at(lane), predicted.at(lane), balls.rates.at(lane));
            let PerRaceway { inner, outer } =
                PerRaceway { inner: slopes.raceway.inner.at(lane), outer: slopes.raceway.outer.at(lane) };
            let PocketSlopes { normal, stiffness, damping } = slopes.pocket.at(lane);
            let pocket = share * stiffness + damping;
            let inner = Answer::of(&inner, radius, share);
            let outer = Answer::of(&outer, radius, share);

            let (mut meridian, mut orbit) = (
                [mass, 0.0, 0.0, mass, 0.0, inertia].map(|m| m / share),
                [mass, 0.0, 0.0, inertia, 0.0, inertia].map(|m| m / share),
            );
            inner.add_to(&mut meridian, &mut orbit);
            outer.add_to(&mut meridian, &mut orbit);
            add_product(&mut meridian, pocket, [normal[0], normal[1], 0.0]);
            orbit[0] += pocket * normal[2] * normal[2];

            let missing = |old: f64, from: f64, rate: f64| (old - from) / share + rate;
            let in_plane = solve(
                meridian,
                [
                    mass * missing(old.axial_velocity, from.axial_velocity, rates.axial_velocity),
                    mass * missing(old.radial_velocity, from.radial_velocity, rates.radial_velocity),
                    inertia * missing(old.spin[2], from.spin[2], rates.spin[2]),
                ],
            );
            let along = solve(
                orbit,
                [
                    mass * missing(old.arc_velocity, from.arc_velocity, rates.arc_velocity),
                    inertia * missing(old.spin[0], from.spin[0], rates.spin[0]),
                    inertia * missing(old.spin[1], from.spin[1], rates.spin[1]),
                ],
            );
            // In the plane they are none, but for what pockets of a leaning cage would do.
            let (in_plane, along) = match PLANAR {
                true => ([0.0, in_plane[1], 0.0], [along[0], along[1], 0.0]),
                false => (in_plane, along),
            };
            let state = BallState {
                axial: from.axial + share * in_plane[0],
                radial: from.radial + share * in_plane[1],
                arc: from.arc + share * along[0],
                axial_velocity: from.axial_velocity + in_plane[0],
                radial_velocity: from.radial_velocity + in_plane[1],
                arc_velocity: from.arc_velocity + along[0],
                spin: [from.spin[0] + along[1], from.spin[1] + along[2], from.spin[2] + in_plane[2]],
            };
            corrected.state.put(lane, state);
            corrected.rates.put(lane, state.combined(1.0 / share, &old, -1.0 / share));
            // What the spindle and the cage feel of it.
            let azimuth = balls.motion.azimuth.at(lane);
            let spindle = scale(-1.0, azimuth.to_inertial(inner.force(in_plane, along)));
            let pull = pocket * dot(normal, [in_plane[0], in_plane[1], along[0]]);
            let cage_force = scale(pull, azimuth.to_inertial(normal));
            let cage_moment = cross(slopes.arm.at(lane), cage_force);
            corrected.reaction.put(lane, Reaction { spindle, cage_force, cage_moment });
            let before = slopes.seen.at(lane);
            let slip = slopes.slip.at(lane);
            corrected.seen.put(
                lane,
                Seen {
                    load: PerRaceway {
                        inner: inner.load(before.load.inner, in_plane),
                        outer: outer.load(before.load.outer, in_plane),
                    },
                    slip_square: PerRaceway {
                        inner: inner.slip_square(slip.inner, in_plane, along),
                        outer: outer.slip_square(slip.outer, in_plane, along),
                    },
                    pocket: larger(before.pocket - pull, 0.0),
                    ..before
                },
            );
        }
    }

    /// What balls would pass on to spindle and cage if these moved: by the `shares` that a step has of the spindle's place and
    /// velocity, and by its `share` of the cage's places.
    #[inline(always)]
    fn stiffness(&self, balls: &Balls, slopes: &Slopes<Lanes>, shares: (f64, f64), share: f64) -> Stiff<Lanes> {
        let mut stiff = Stiff::default();
        for lane in 0..LANES {
            let (azimuth, inner, pocket) =
                (balls.motion.azimuth.at(lane), slopes.raceway.inner.at(lane), slopes.pocket.at(lane));
            let normal = azimuth.to_inertial([inner.towards.0, inner.towards.1, 0.0]);
            let strength = shares.0 * inner.stiffness + shares.1 * inner.damping;
            let of_pocket = share * pocket.stiffness + pocket.damping;
            let push = azimuth.to_inertial(pocket.normal);
            let turn = cross(slopes.arm.at(lane), push);
            stiff.put(
                lane,
                Stiff {
                    spindle: normal.map(|n| strength * n * n),
                    cage: push.map(|n| of_pocket * n * n),
                    about: turn.map(|n| of_pocket * n * n),
                },
            );
        }
        stiff
    }

    /// The same of the cage's velocities [1/s].
    fn cage_stiffness(&self, stiff: &Stiff) -> CageState {
        let cage = &self.mechanism().cage;
        let [x, y, z] = stiff.about;
        CageState {
            velocity: stiff.cage.map(|s| s / cage.mass),
            arc_velocity: x / cage.axial_inertia,
            tilt_rate: [y / cage.transverse_inertia, z / cage.transverse_inertia],
            ..CageState::default()
        }
    }
}

impl<const PLANAR: bool> Integrator for SemiImplicit<'_, PLANAR> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        // A stop that whole steps do not lead to.
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
            layout.set_cage(&mut state, &node.cage);
            layout.set_spindle(&mut state, &node.spindle);
            state
        })
    }

    fn sight(&self) -> Option<&[f64]> {
        Some(&self.sight)
    }

    /// By the cubic through places, or velocities, and their rates at both ends.
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
        let cage = old.cage.combined(value[0], &new.cage, value[1]);
        let rates = old.cage_rates.combined(rate[0], &new.cage_rates, rate[1]);
        layout.set_cage(state, &cage.combined(1.0, &rates, 1.0));
        let blend = |a: Vector, b: Vector, da: Vector, db: Vector| -> Vector {
            from_fn(|i| value[0] * a[i] + value[1] * b[i] + rate[0] * da[i] + rate[1] * db[i])
        };
        let (a, b) = (old.spindle, new.spindle);
        let position = blend(a.position, b.position, a.velocity, b.velocity);
        let velocity = blend(a.velocity, b.velocity, old.acceleration, new.acceleration);
        layout.set_spindle(state, &SpindleState { position, velocity });
    }

    fn restart(&mut self) {
        self.known = 0;
        self.time = self.time.next_up();
    }

    fn statistics(&self) -> Statistics {
        self.work
    }

    fn choice(&self) -> Choice {
        let reason =
            format!("steps of {:.2} µs, implicit in what is stiff: tried before error control", 1e6 * self.step);
        Choice { method: Method::SemiImplicit, reason: Some(reason) }
    }
}
