//! A bearing whose rings are moved by a shaft and a housing. Rates and steps of balls and cage at a motion of the rings, and their loads on
//! the rings.

pub(crate) use super::equations::Rings;
use super::equations::{Dynamics, Full, OnRings};
pub(crate) use super::semi_implicit::correction::RingResistance;
use super::semi_implicit::{Node, SemiImplicit};
use super::watch::Watch;
use crate::numerics::lanes::Task;
use crate::physics::frames::Tilt;
use crate::physics::frames::{Vector, dot, subtract};
use crate::simulation::model::state::SpindleState;

/// Force [N] and moments about the angles of its tilt, Y and the new Z [N m], of balls and cage on a ring, and the moment about its
/// axis [N m], which the drive or the housing takes.
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

/// Loads on both rings. The second is nothing where the outer ring does not move.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RingLoads {
    pub inner: RingLoad,
    pub outer: RingLoad,
}

impl Full {
    /// Writes the rates of balls and cage, whose state `y` holds alone, at a motion of the rings. Returns their loads on the rings.
    pub(crate) fn rates_on_ring(
        &self,
        time: f64,
        y: &[f64],
        rings: Rings,
        dy: &mut [f64],
        watch: Option<&mut (dyn Watch + '_)>,
    ) -> RingLoads {
        self.instructions().run(Rates { dynamics: self, time, y, rings, dy, watch })
    }
}

/// One evaluation, compiled for each instruction set.
struct Rates<'a, 'w> {
    dynamics: &'a Full,
    time: f64,
    y: &'a [f64],
    rings: Rings,
    dy: &'a mut [f64],
    watch: Option<&'a mut (dyn Watch + 'w)>,
}

impl Task for Rates<'_, '_> {
    type Answer = RingLoads;

    #[inline(always)]
    fn run(self) -> RingLoads {
        let rings = self.rings;
        let (_, OnRings { sum, on_tilt, on_outer }) =
            self.dynamics.bearing_by(self.time, self.y, rings, self.dy, self.watch);
        RingLoads { inner: RingLoad::of(sum.spindle, on_tilt, rings.inner.tilt), outer: rings.on_outer(on_outer) }
    }
}

impl Rings {
    /// Position and tilt of the inner ring from the outer one.
    pub(crate) fn apart(&self) -> (Vector, [f64; 2]) {
        let SpindleState { position, tilt, .. } = self.inner;
        self.outer.map_or((position, tilt), |outer| {
            (subtract(position, outer.position), [tilt[0] - outer.tilt[0], tilt[1] - outer.tilt[1]])
        })
    }

    /// Load on the outer ring; nothing where it does not move.
    fn on_outer(&self, [force, moment]: [Vector; 2]) -> RingLoad {
        self.outer.map_or_else(RingLoad::default, |ring| RingLoad::of(force, moment, ring.tilt))
    }
}

/// Balls and cage in fixed steps, driven by whoever moves the rings.
pub(crate) struct RingStepper<'m, const PLANAR: bool> {
    method: SemiImplicit<'m, PLANAR>,
    kept: Vec<Node>,
}

impl<'m, const PLANAR: bool> RingStepper<'m, PLANAR> {
    /// Balls and cage at a state, which `y` holds alone.
    pub(crate) fn new(dynamics: &'m Dynamics<PLANAR>, time: f64, y: &[f64], ring: SpindleState) -> Self {
        let layout = dynamics.mechanism().layout;
        let mut state = y.to_vec();
        state.resize(layout.dimension(), 0.0);
        layout.set_spindle(&mut state, &ring);
        Self { method: SemiImplicit::new(dynamics, time, &state, 0.0), kept: Vec::new() }
    }

    /// Starts again at the newest state, at a low order.
    pub(crate) fn begin(&mut self) {
        self.method.begin();
    }

    /// Keeps the newest state for `recall`.
    pub(crate) fn keep(&mut self) {
        self.kept.push(self.method.newest());
    }

    /// Replaces all states but the newest by the kept ones.
    pub(crate) fn recall(&mut self) {
        self.method.set_past(self.kept.drain(..).rev());
    }

    /// Advances balls and cage by a step to a time at which the rings are predicted to move like this. Returns their load on the inner and on the
    /// outer ring after their corrections, each with their resistance to its further motion.
    pub(crate) fn advance(&mut self, end: f64, step: f64, rings: Rings) -> [(RingLoad, RingResistance); 2] {
        self.method.aim(end, step, rings);
        let instructions = self.method.dynamics().instructions();
        instructions.run(Advance { stepper: &mut self.method, rings })
    }

    /// Ends the step.
    pub(crate) fn finish(&mut self) {
        self.method.end_step();
    }

    /// Loads of the balls at the newest state, packed.
    pub(crate) fn step_loads(&self) -> &[f64] {
        self.method.loads()
    }

    /// Deviation of the velocity along the arc from ideal rolling [m/s], of the cage or, without one, of the balls in the mean.
    pub(crate) fn arc_velocity(&self) -> f64 {
        let (layout, state) = (self.method.dynamics().mechanism().layout, self.method.newest_state());
        match layout.cage {
            true => layout.cage(state).arc_velocity,
            false => {
                (0..layout.balls).map(|ball| layout.ball(state, ball).arc_velocity).sum::<f64>() / layout.balls as f64
            }
        }
    }

    /// Deviations of a ball from ideal rolling: velocity along the arc [m/s] and spin [rad/s].
    pub(crate) fn ball_turns(&self, ball: usize) -> (f64, Vector) {
        let ball = self.method.dynamics().mechanism().layout.ball(self.method.newest_state(), ball);
        (ball.arc_velocity, ball.spin)
    }

    /// A ball that touches its neighbour, where there is no cage.
    pub(crate) fn touching(&self) -> Option<usize> {
        self.method.touching()
    }
}

/// One step, compiled for each instruction set.
struct Advance<'a, 'm, const PLANAR: bool> {
    stepper: &'a mut SemiImplicit<'m, PLANAR>,
    rings: Rings,
}

impl<const PLANAR: bool> Task for Advance<'_, '_, PLANAR> {
    type Answer = [(RingLoad, RingResistance); 2];

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let [(force, moment, resistance), (outer_force, outer_moment, outer_resistance)] =
            self.stepper.advance_on_ring();
        let inner = RingLoad::of(force, moment, self.rings.inner.tilt);
        [(inner, resistance), (self.rings.on_outer([outer_force, outer_moment]), outer_resistance)]
    }
}
