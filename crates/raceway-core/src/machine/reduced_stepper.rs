//! Fixed steps of a bearing on a reduced level: balls follow the ring in the plane, and linear moments hold its tilt.

use super::bearing::{BearingOnShaft, ReducedModel, TiltHold};
use super::port::{PortLoad, Predicted, Resistance, ball_of};
use crate::physics::frames::Vector;
use crate::physics::statics::Matrix;
use crate::simulation::model::dynamics::on_ring::{RingLoad, RingResistance, RingStepper, Rings};
use crate::simulation::model::radially_condensed::on_ring::CondensedOnRing;
use crate::simulation::model::ring_motion::{BallSeen, LoadOnRing, RingMotion};
use crate::simulation::model::spindle_only::on_ring::SpindleOnlyOnRing;
use crate::simulation::model::state::{BallState, Layout, SpindleState};

/// A bearing on a reduced level.
pub(crate) struct ReducedStepper<'m> {
    bearing: &'m BearingOnShaft,
    steps: InPlane<'m>,
    tilt: &'m TiltHold,
}

/// Balls and cage that follow the ring in the plane.
enum InPlane<'m> {
    Planar(Box<RingStepper<'m, true>>),
    RadiallyCondensed(Box<CondensedOnRing<'m>>),
    SpindleOnly(SpindleOnlyOnRing<'m>),
}

impl<'m> ReducedStepper<'m> {
    /// A bearing at a motion of its inner ring; `state`: of balls and cage on `full`.
    pub(super) fn new(
        bearing: &'m BearingOnShaft,
        (model, tilt): (&'m ReducedModel, &'m TiltHold),
        time: f64,
        state: &[f64],
        ring: &SpindleState,
    ) -> Self {
        let steps = match model {
            ReducedModel::Planar(model) => {
                let layouts = [&bearing.dynamics.mechanism().layout, &model.mechanism().layout];
                let steps = RingStepper::new(model, time, &planar_state(layouts, state), planar(ring));
                InPlane::Planar(Box::new(steps))
            }
            ReducedModel::RadiallyCondensed(model) => {
                InPlane::RadiallyCondensed(Box::new(CondensedOnRing::new(model, time, &in_plane(ring, [0.0; 2]))))
            }
            ReducedModel::SpindleOnly(model) => {
                InPlane::SpindleOnly(SpindleOnlyOnRing::new(model, time, &in_plane(ring, [0.0; 2])))
            }
        };
        Self { bearing, steps, tilt }
    }

    /// Load on the ring at the start along the shaft's axes, where it is not that of `full`.
    pub(super) fn first_load(&self, ring: &SpindleState) -> Option<[f64; 5]> {
        let load = match &self.steps {
            InPlane::Planar(_) => return None,
            InPlane::RadiallyCondensed(steps) => steps.first_load(),
            InPlane::SpindleOnly(steps) => steps.first_load(),
        };
        Some(self.over_acceleration(&load, ring).wrench)
    }

    pub(super) fn begin(&mut self) {
        match &mut self.steps {
            InPlane::Planar(steps) => steps.begin(),
            InPlane::RadiallyCondensed(steps) => steps.begin(),
            InPlane::SpindleOnly(_) => {}
        }
    }

    pub(super) fn keep(&mut self) {
        match &mut self.steps {
            InPlane::Planar(steps) => steps.keep(),
            InPlane::RadiallyCondensed(steps) => steps.keep(),
            InPlane::SpindleOnly(_) => {}
        }
    }

    pub(super) fn recall(&mut self) {
        match &mut self.steps {
            InPlane::Planar(steps) => steps.recall(),
            InPlane::RadiallyCondensed(steps) => steps.recall(),
            InPlane::SpindleOnly(_) => {}
        }
    }

    pub(super) fn advance(&mut self, end: f64, step: f64, predicted: &Predicted) -> PortLoad {
        let ring = &predicted.rings.inner;
        let motion = in_plane(ring, predicted.acceleration);
        let load = match &mut self.steps {
            InPlane::Planar(steps) => {
                let rings = Rings { inner: planar(ring), outer: None };
                let [(load, resistance), _] = steps.advance(end, step, rings);
                return self.over_motion(&load, &resistance, ring);
            }
            InPlane::RadiallyCondensed(steps) => steps.advance(end, step, &motion, predicted.shares),
            InPlane::SpindleOnly(steps) => steps.advance(end, &motion, predicted.shares),
        };
        self.over_acceleration(&load, ring)
    }

    pub(super) fn finish(&mut self, ring: impl FnOnce() -> SpindleState) {
        match &mut self.steps {
            InPlane::Planar(steps) => steps.finish(),
            InPlane::RadiallyCondensed(steps) => steps.finish(&in_plane(&ring(), [0.0; 2])),
            InPlane::SpindleOnly(steps) => steps.finish(&in_plane(&ring(), [0.0; 2])),
        }
    }

    pub(super) fn seen(&self, ball: usize) -> BallSeen {
        match &self.steps {
            InPlane::Planar(steps) => ball_of(steps.step_loads(), ball),
            InPlane::RadiallyCondensed(steps) => steps.seen(ball),
            InPlane::SpindleOnly(steps) => steps.seen(ball),
        }
    }

    /// Deviation of the cage's velocity along the arc from ideal rolling, without a cage that of the balls in the mean [m/s].
    pub(super) fn arc_velocity(&self) -> f64 {
        match &self.steps {
            InPlane::Planar(steps) => steps.arc_velocity(),
            InPlane::RadiallyCondensed(steps) => steps.arc_velocity(),
            InPlane::SpindleOnly(_) => 0.0,
        }
    }

    /// Deviations of a ball from ideal rolling: velocity along the arc [m/s] and spin [rad/s].
    pub(super) fn ball_turns(&self, ball: usize) -> (f64, Vector) {
        match &self.steps {
            InPlane::Planar(steps) => steps.ball_turns(ball),
            InPlane::RadiallyCondensed(steps) => {
                let (arc_velocity, about_x) = steps.ball(ball);
                (arc_velocity, [about_x, 0.0, 0.0])
            }
            InPlane::SpindleOnly(_) => (0.0, [0.0; 3]),
        }
    }

    pub(super) fn touching(&self) -> Option<usize> {
        match &self.steps {
            InPlane::Planar(steps) => steps.touching(),
            InPlane::RadiallyCondensed(_) | InPlane::SpindleOnly(_) => None,
        }
    }

    pub(super) fn bearing(&self) -> &'m BearingOnShaft {
        self.bearing
    }

    /// The load at the port, with its slope over the acceleration of the ring.
    fn over_acceleration(
        &self,
        LoadOnRing { force: [y, z], slope: [yy, yz, zz] }: &LoadOnRing,
        ring: &SpindleState,
    ) -> PortLoad {
        let mut slope = [[0.0; 5]; 5];
        (slope[1][1], slope[1][2], slope[2][1], slope[2][2]) = (*yy, *yz, *yz, *zz);
        let slope = Some(self.bearing.mounted.along_shaft(&slope));
        self.with_moments([*y, *z], [[[0.0; 5]; 5]; 2], slope, ring)
    }

    /// The load at the port, with its slopes over displacement and velocity of the ring.
    fn over_motion(&self, load: &RingLoad, resistance: &RingResistance, ring: &SpindleState) -> PortLoad {
        let [_, y, z] = load.force;
        let in_plane = |of: &Matrix| {
            let mut matrix = [[0.0; 5]; 5];
            (1..3).for_each(|row| matrix[row][1..3].copy_from_slice(&of[row][1..3]));
            matrix
        };
        self.with_moments([y, z], [in_plane(&resistance.stiffness), in_plane(&resistance.damping)], None, ring)
    }

    /// Adds the moments that hold the tilt.
    fn with_moments(
        &self,
        [y, z]: [f64; 2],
        [mut stiffness, mut damping]: [Matrix; 2],
        slope: Option<Matrix>,
        ring: &SpindleState,
    ) -> PortLoad {
        let (mounted, hold) = (&self.bearing.mounted, self.tilt);
        for row in 0..2 {
            stiffness[3 + row][3..].copy_from_slice(&hold.stiffness[row]);
            damping[3 + row][3..].copy_from_slice(&hold.damping[row]);
        }
        let [about_y, about_z] = hold.moment(ring);
        let [stiffness, damping] = [stiffness, damping].map(|matrix| mounted.along_shaft(&matrix));
        PortLoad {
            wrench: mounted.wrench_on_shaft(&[0.0, y, z, about_y, about_z]),
            resistance: Resistance { stiffness, damping, slope },
        }
    }
}

fn in_plane(ring: &SpindleState, acceleration: [f64; 2]) -> RingMotion {
    let ([_, y, z], [_, vy, vz]) = (ring.position, ring.velocity);
    RingMotion { place: [y, z], velocity: [vy, vz], acceleration }
}

/// The ring without motion along X and tilt.
fn planar(ring: &SpindleState) -> SpindleState {
    let in_plane = |[_, y, z]: Vector| [0.0, y, z];
    SpindleState { position: in_plane(ring.position), velocity: in_plane(ring.velocity), ..SpindleState::default() }
}

/// Balls and cage of a state on `full` in the layout of `planar`.
fn planar_state([full, planar]: [&Layout; 2], state: &[f64]) -> Vec<f64> {
    let mut of = vec![0.0; planar.dimension()];
    for ball in 0..full.balls {
        let ball_state = BallState { axial: 0.0, axial_velocity: 0.0, ..full.ball(state, ball) };
        planar.set_ball(&mut of, ball, &ball_state);
    }
    planar.set_cage(&mut of, &full.cage(state));
    of
}
