//! A bearing whose inner ring is moved by a shaft: equally spaced balls in radial equilibrium, without states of their own.

use super::equations::SpindleOnly;
use crate::numerics::lanes::{InstructionSet, Task};
use crate::numerics::ode::adams_moulton::Shares;
use crate::simulation::model::ring_motion::{BallSeen, LoadOnRing, RingMotion};

/// Longest step at the motion of a ring [s]. Half steps verify it.
const LONGEST: f64 = 20e-6;

/// Balls between rings that others move. Their loads follow from the motion of the ring at once.
pub(crate) struct SpindleOnlyOnRing<'m> {
    model: &'m SpindleOnly,
    time: f64,
    /// Place of the ring [m].
    place: [f64; 2],
    instructions: InstructionSet,
    /// Load at the start.
    first: LoadOnRing,
}

impl<'m> SpindleOnlyOnRing<'m> {
    /// The balls at a motion of the ring.
    pub(crate) fn new(model: &'m SpindleOnly, time: f64, ring: &RingMotion) -> Self {
        let instructions = InstructionSet::best();
        let first = instructions.run(Load { model, time, ring, shares: Shares::default() });
        Self { model, time, place: ring.place, instructions, first }
    }

    /// Load at the start.
    pub(crate) fn first_load(&self) -> LoadOnRing {
        self.first
    }

    /// Load at a time and a predicted motion of the ring. `shares`: of a change of the ring's acceleration in its place and velocity.
    pub(crate) fn advance(&mut self, end: f64, ring: &RingMotion, shares: Shares) -> LoadOnRing {
        self.time = end;
        self.instructions.run(Load { model: self.model, time: end, ring, shares })
    }

    /// Ends the step with the corrected motion of the ring.
    pub(crate) fn finish(&mut self, ring: &RingMotion) {
        self.place = ring.place;
    }

    /// Elastic loads of a ball.
    pub(crate) fn seen(&self, ball: usize) -> BallSeen {
        BallSeen { load: self.model.loads_of_ball(ball, self.time, self.place), ..BallSeen::default() }
    }
}

impl SpindleOnly {
    /// Longest step at the motion of a ring that resolves waves [s].
    pub(crate) fn longest_step_on_ring(&self) -> f64 {
        LONGEST.min(self.longest_step())
    }
}

/// The loads of one step, compiled for each instruction set.
struct Load<'a> {
    model: &'a SpindleOnly,
    time: f64,
    ring: &'a RingMotion,
    shares: Shares,
}

impl Task for Load<'_> {
    type Answer = LoadOnRing;

    #[inline(always)]
    fn run(self) -> LoadOnRing {
        let RingMotion { place, velocity, acceleration } = *self.ring;
        self.model.of_balls(self.time, &(place, velocity), acceleration, self.shares).into()
    }
}
