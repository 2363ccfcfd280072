//! A bearing whose inner ring is moved from outside, by a shaft: rates and steps of balls and cage at a motion of the ring, and what they
//! exert on it.

use super::equations::Full;
pub(crate) use super::semi_implicit::correction::RingResistance;
use super::semi_implicit::{Node, SemiImplicit};
use super::watch::Watch;
use crate::numerics::lanes::Task;
use crate::physics::frames::Tilt;
use crate::physics::frames::{Vector, dot};
use crate::simulation::model::state::SpindleState;

/// Force [N] and moments about the angles of its tilt, Y and the new Z [N m], of the balls on the inner ring, and the moment about its
/// axis [N m], which the drive takes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RingLoad {
    pub force: Vector,
    pub moment: [f64; 2],
    pub drive: f64,
}

impl RingLoad {
    fn of(force: Vector, moment: Vector, [about_y, about_z]: [f64; 2]) -> Self {
        let [axis, _, z] = Tilt::new(about_y, about_z).columns;
        Self { force, moment: [moment[1], dot(moment, z)], drive: dot(moment, axis) }
    }

    /// Along x, y, z and about Y and the new Z.
    pub(crate) fn wrench(&self) -> [f64; 5] {
        let ([x, y, z], [about_y, about_z]) = (self.force, self.moment);
        [x, y, z, about_y, about_z]
    }
}

impl Full {
    /// Writes the rates of balls and cage, whose state `y` holds alone, at a motion of the ring. Returns their load on the ring.
    pub(crate) fn rates_on_ring(
        &self,
        time: f64,
        y: &[f64],
        ring: SpindleState,
        dy: &mut [f64],
        watch: Option<&mut (dyn Watch + '_)>,
    ) -> RingLoad {
        self.instructions().run(Rates { dynamics: self, time, y, ring, dy, watch })
    }
}

/// One evaluation, compiled for each instruction set.
struct Rates<'a, 'w> {
    dynamics: &'a Full,
    time: f64,
    y: &'a [f64],
    ring: SpindleState,
    dy: &'a mut [f64],
    watch: Option<&'a mut (dyn Watch + 'w)>,
}

impl Task for Rates<'_, '_> {
    type Answer = RingLoad;

    #[inline(always)]
    fn run(self) -> RingLoad {
        let (_, reaction, moment) = self.dynamics.bearing_by(self.time, self.y, self.ring, self.dy, self.watch);
        RingLoad::of(reaction.spindle, moment, self.ring.tilt)
    }
}

/// Balls and cage in fixed steps, driven by whoever moves the ring.
pub(crate) struct RingStepper<'m>(SemiImplicit<'m, false>);

/// Balls and cage at one time.
pub(crate) struct RingNode(Box<Node>);

impl<'m> RingStepper<'m> {
    /// Balls and cage at a state, which `y` holds alone.
    pub(crate) fn new(dynamics: &'m Full, time: f64, y: &[f64], ring: SpindleState) -> Self {
        let layout = dynamics.mechanism().layout;
        let mut state = y.to_vec();
        state.resize(layout.dimension(), 0.0);
        layout.set_spindle(&mut state, &ring);
        Self(SemiImplicit::new(dynamics, time, &state, 0.0))
    }

    /// Starts again at the newest state, at a low order.
    pub(crate) fn begin(&mut self) {
        self.0.begin();
    }

    /// The newest state.
    pub(crate) fn node(&self) -> RingNode {
        RingNode(self.0.newest())
    }

    /// Replaces all states but the newest by these, newest first.
    pub(crate) fn set_past(&mut self, past: Vec<RingNode>) {
        self.0.set_past(past.into_iter().map(|node| node.0));
    }

    /// Advances balls and cage by a step to a time at which the ring is predicted to move like this. Returns their load on the ring after their
    /// corrections, and their resistance to its further motion.
    pub(crate) fn advance(&mut self, end: f64, step: f64, ring: SpindleState) -> (RingLoad, RingResistance) {
        self.0.aim(end, step, ring);
        let instructions = self.0.dynamics().instructions();
        instructions.run(Advance { stepper: &mut self.0, ring })
    }

    /// Ends the step.
    pub(crate) fn finish(&mut self) {
        self.0.end_step();
    }

    /// Loads of the balls at the newest state, packed.
    pub(crate) fn step_loads(&self) -> &[f64] {
        self.0.loads()
    }

    /// The newest state of balls and cage.
    pub(crate) fn state(&self) -> &[f64] {
        self.0.newest_state()
    }

    /// A ball that touches its neighbour, where there is no cage.
    pub(crate) fn touching(&self) -> Option<usize> {
        self.0.touching()
    }
}

/// One step, compiled for each instruction set.
struct Advance<'a, 'm> {
    stepper: &'a mut SemiImplicit<'m, false>,
    ring: SpindleState,
}

impl Task for Advance<'_, '_> {
    type Answer = (RingLoad, RingResistance);

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let (force, moment, resistance) = self.stepper.advance_on_ring();
        (RingLoad::of(force, moment, self.ring.tilt), resistance)
    }
}
