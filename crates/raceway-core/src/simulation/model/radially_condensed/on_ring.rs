//! A bearing whose inner ring is moved by a shaft: steps of balls and cage at a predicted motion of the ring, and their load on it.
//!
//! The balls take part of the ring's acceleration as mass, and of its place and velocity as stiffness and damping. Whoever moves the ring
//! states by its shares how far place and velocity follow a change of the acceleration in a step. One slope over the acceleration then
//! holds all three, as for a rigid spindle.

use super::ball::{BallRates, Balls};
use super::border::Border;
use super::equations::RadiallyCondensed;
use super::evaluation::{Rates, Scratch, StepShares, total};
use super::stepping::{Change, Formulas, Node, eliminate};
use crate::numerics::lanes::{LANES, Singles, Task};
use crate::numerics::ode::adams_moulton::Shares;
use crate::physics::bearing::PerRaceway;
use crate::simulation::model::ring_motion::{BallSeen, LoadOnRing, RingMotion};

/// Number of stored nodes: the formulas of balls and cage use three known ones.
const NODES: usize = 4;
/// Full number of known nodes.
const KNOWN: usize = NODES - 1;

/// Balls and cage in fixed steps, driven by whoever moves the ring.
pub(crate) struct CondensedOnRing<'m> {
    model: &'m RadiallyCondensed,
    /// Newest first.
    nodes: [Box<Node>; NODES],
    kept: Vec<Node>,
    /// Number of known nodes.
    known: usize,
    formulas: Formulas,
    step: f64,
    rates: Rates,
    missing: Vec<[Singles; 2]>,
    changes: Vec<Change<Singles>>,
    scratch: Scratch,
    /// Load at the start.
    first: LoadOnRing,
}

impl<'m> CondensedOnRing<'m> {
    /// Balls in ideal rolling and a centred cage, at a motion of the ring.
    pub(crate) fn new(model: &'m RadiallyCondensed, time: f64, ring: &RingMotion) -> Self {
        let (balls, border) = model.start();
        let border = Border { spindle: ring.place, spindle_velocity: ring.velocity, ..border };
        let node = Node::at(model, balls, border);
        let groups = model.groups();
        let mut rates = Rates { balls: vec![BallRates::default(); groups], ..Rates::default() };
        let mut scratch = Scratch::new(groups);
        let Node { balls, turned, .. } = &node;
        let shares = StepShares::default();
        model.rates(time, balls, turned, &border, ring.acceleration, shares, &mut rates, &mut scratch);
        Self {
            model,
            first: LoadOnRing::of(&rates),
            nodes: std::array::from_fn(|_| Box::new(node.clone())),
            kept: Vec::new(),
            known: 1,
            formulas: Formulas::new(1),
            step: 0.0,
            rates,
            missing: vec![Default::default(); groups],
            changes: vec![Change::default(); groups],
            scratch,
        }
    }

    /// Load at the start.
    pub(crate) fn first_load(&self) -> LoadOnRing {
        self.first
    }

    /// Starts again at the newest state, at a low order.
    pub(crate) fn begin(&mut self) {
        self.know(1);
    }

    fn know(&mut self, known: usize) {
        (self.known, self.formulas) = (known, Formulas::new(known));
    }

    /// Keeps the newest state for `recall`.
    pub(crate) fn keep(&mut self) {
        self.kept.push(Node::clone(&self.nodes[0]));
    }

    /// Replaces all states but the newest by the kept ones.
    pub(crate) fn recall(&mut self) {
        for (node, kept) in self.nodes[1..].iter_mut().zip(self.kept.drain(..).rev()) {
            **node = kept;
        }
    }

    /// Advances balls and cage by a step to a time at which the ring is predicted to move like this. `shares`: of a change of the
    /// ring's acceleration in its place and velocity.
    pub(crate) fn advance(&mut self, end: f64, step: f64, ring: &RingMotion, shares: Shares) -> LoadOnRing {
        self.step = step;
        self.nodes.rotate_right(1);
        self.model.instructions.run(Advance { of: self, end, ring, shares })
    }

    #[inline(always)]
    fn advance_by(&mut self, end: f64, ring: &RingMotion, shares: Shares) -> LoadOnRing {
        let (h, formulas, model) = (self.step, &self.formulas, self.model);
        let [new, now, before, earlier] = self.nodes.each_mut().map(|node| &mut **node);
        new.predict_balls([now, before, earlier], &mut self.missing, formulas, h);
        let past = [&now.border, &before.border, &earlier.border];
        new.border = Border::predicted(past, (ring.place, ring.velocity), formulas, h);
        let step = StepShares { spindle: shares, cage: h * formulas.moulton[0] };
        let (rates, scratch) = (&mut self.rates, &mut self.scratch);
        model.rates(end, &new.balls, &new.turned, &new.border, ring.acceleration, step, rates, scratch);
        let step = (formulas.balls.leading, h, shares.velocity);
        eliminate(model, step, &self.missing, &mut self.rates, &mut self.changes);
        LoadOnRing::of(&self.rates)
    }

    /// Ends the step with the corrected motion of the ring.
    pub(crate) fn finish(&mut self, ring: &RingMotion) {
        self.model.instructions.run(Finish { of: self, ring });
        if self.known < KNOWN {
            self.know(self.known + 1);
        }
    }

    #[inline(always)]
    fn finish_by(&mut self, ring: &RingMotion) {
        let [new, now, before, earlier] = self.nodes.each_mut().map(|node| &mut **node);
        let gained = std::array::from_fn(|i| ring.velocity[i] - new.border.spindle_velocity[i]);
        (new.border.spindle, new.border.spindle_velocity) = (ring.place, ring.velocity);
        new.correct([now, before, earlier], &self.rates, &self.changes, gained, (&self.formulas, self.step));
    }

    /// Deviation of the velocity along the arc from ideal rolling [m/s], of the cage or, without one, of the balls in the mean.
    pub(crate) fn arc_velocity(&self) -> f64 {
        let balls = self.model.mechanism().layout.balls;
        match self.model.mechanism().layout.cage {
            true => self.nodes[0].border.cage_velocity[2],
            false => (0..balls).map(|ball| self.ball(ball).0).sum::<f64>() / balls as f64,
        }
    }

    /// Deviations of a ball from ideal rolling: velocity along the arc [m/s] and spin about X [rad/s].
    pub(crate) fn ball(&self, ball: usize) -> (f64, f64) {
        let (balls, lane): (&Balls, _) = (&self.nodes[0].balls[ball / LANES], ball % LANES);
        (balls.arc_velocity[lane].into(), balls.spin[lane].into())
    }

    /// Loads and slip of a ball in the last step.
    pub(crate) fn seen(&self, ball: usize) -> BallSeen {
        let (seen, lane) = (&self.scratch.ball_loads[ball / LANES], ball % LANES);
        let of =
            |pair: &PerRaceway<Singles>| PerRaceway { inner: pair.inner[lane].into(), outer: pair.outer[lane].into() };
        BallSeen { load: of(&seen.load), slip: of(&seen.slip), pocket: seen.pocket[lane].into() }
    }
}

impl LoadOnRing {
    #[inline(always)]
    fn of(rates: &Rates) -> Self {
        let on_ring = &rates.passed;
        Self { force: [total(&on_ring.force.0), total(&on_ring.force.1)], slope: on_ring.slope.each_ref().map(total) }
    }
}

/// The prediction and evaluation of one step, compiled for each instruction set.
struct Advance<'a, 'm> {
    of: &'a mut CondensedOnRing<'m>,
    end: f64,
    ring: &'a RingMotion,
    shares: Shares,
}

impl Task for Advance<'_, '_> {
    type Answer = LoadOnRing;

    #[inline(always)]
    fn run(self) -> LoadOnRing {
        self.of.advance_by(self.end, self.ring, self.shares)
    }
}

/// The correction of one step, compiled for each instruction set.
struct Finish<'a, 'm> {
    of: &'a mut CondensedOnRing<'m>,
    ring: &'a RingMotion,
}

impl Task for Finish<'_, '_> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.of.finish_by(self.ring);
    }
}
