//! Fixed steps of a bearing between shaft and housing, on its level of the model.

use super::bearing::{BearingOnShaft, CondensedBearing, TiltHold};
use crate::numerics::ode::adams_moulton::Shares;
use crate::physics::frames::Vector;
use crate::physics::statics::Matrix;
use crate::simulation::model::dynamics::on_ring::{RingStepper, Rings};
use crate::simulation::model::radially_condensed::on_ring::{BallSeen, CondensedOnRing, LoadOnRing, RingMotion};
use crate::simulation::model::state::SpindleState;
use crate::simulation::model::step_loads::PackedStepLoads;

/// Balls and cage of a bearing, driven by the motion of its rings.
pub(crate) enum BearingStepper<'m> {
    Full(Box<FullStepper<'m>>),
    RadiallyCondensed(Box<CondensedStepper<'m>>),
}

/// On the level `full`.
pub(crate) struct FullStepper<'m> {
    bearing: &'m BearingOnShaft,
    steps: RingStepper<'m>,
}

/// On the level `radially_condensed`: balls follow the ring in the plane, and linear moments hold its tilt.
pub(crate) struct CondensedStepper<'m> {
    bearing: &'m BearingOnShaft,
    steps: CondensedOnRing<'m>,
    tilt: &'m TiltHold,
}

/// Predicted motion of the rings of a bearing at the end of a step, in its own axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Predicted {
    pub rings: Rings,
    /// Acceleration of the inner ring along Y and Z [m/s²]; not used on `full`.
    pub acceleration: [f64; 2],
    /// Shares of a change of that acceleration in place and velocity.
    pub shares: Shares,
}

/// Load of balls and cage on a ring along the shaft's axes [N, N m], and its decrease by the ring's further motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PortLoad {
    pub wrench: [f64; 5],
    pub resistance: Resistance,
}

/// Decrease of a load by the motion of its ring.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resistance {
    pub stiffness: Matrix,
    pub damping: Matrix,
    /// Over accelerations, with the displacements and velocities that follow them.
    pub slope: Option<Matrix>,
}

impl<'m> BearingStepper<'m> {
    /// A bearing at a motion of its rings; `state`: of balls and cage on `full`.
    pub(crate) fn new(bearing: &'m BearingOnShaft, time: f64, state: &[f64], rings: Rings) -> Self {
        match &bearing.condensed {
            None => {
                let steps = RingStepper::new(&bearing.dynamics, time, state, rings.inner);
                Self::Full(Box::new(FullStepper { bearing, steps }))
            }
            Some(CondensedBearing { model, tilt }) => {
                let steps = CondensedOnRing::new(model, time, &in_plane(&rings.inner, [0.0; 2]));
                Self::RadiallyCondensed(Box::new(CondensedStepper { bearing, steps, tilt }))
            }
        }
    }

    /// Load on the inner ring at the start along the shaft's axes, where it is not that of `full`.
    pub(crate) fn first_load(&self, rings: &Rings) -> Option<[f64; 5]> {
        match self {
            Self::Full(_) => None,
            Self::RadiallyCondensed(of) => Some(of.port(&of.steps.first_load(), &rings.inner).wrench),
        }
    }

    /// Starts again at the newest state, at a low order.
    pub(crate) fn begin(&mut self) {
        match self {
            Self::Full(of) => of.steps.begin(),
            Self::RadiallyCondensed(of) => of.steps.begin(),
        }
    }

    /// Keeps the newest state for `recall`.
    pub(crate) fn keep(&mut self) {
        match self {
            Self::Full(of) => of.steps.keep(),
            Self::RadiallyCondensed(of) => of.steps.keep(),
        }
    }

    /// Replaces all states but the newest by the kept ones.
    pub(crate) fn recall(&mut self) {
        match self {
            Self::Full(of) => of.steps.recall(),
            Self::RadiallyCondensed(of) => of.steps.recall(),
        }
    }

    /// Advances balls and cage by a step to a time. Returns their load on the inner ring, and on the outer one, which counts where that moves.
    pub(crate) fn advance(&mut self, end: f64, step: f64, predicted: &Predicted) -> [Option<PortLoad>; 2] {
        match self {
            Self::Full(of) => of.steps.advance(end, step, predicted.rings).map(|(load, resistance)| {
                let mounted = &of.bearing.mounted;
                let [stiffness, damping] =
                    [resistance.stiffness, resistance.damping].map(|matrix| mounted.along_shaft(&matrix));
                let resistance = Resistance { stiffness, damping, slope: None };
                Some(PortLoad { wrench: of.bearing.on_shaft(&load), resistance })
            }),
            Self::RadiallyCondensed(of) => {
                let ring = in_plane(&predicted.rings.inner, predicted.acceleration);
                let load = of.steps.advance(end, step, &ring, predicted.shares);
                [Some(of.port(&load, &predicted.rings.inner)), None]
            }
        }
    }

    /// Ends the step at the corrected motion of the rings.
    pub(crate) fn finish(&mut self, rings: impl FnOnce() -> Rings) {
        match self {
            Self::Full(of) => of.steps.finish(),
            Self::RadiallyCondensed(of) => of.steps.finish(&in_plane(&rings().inner, [0.0; 2])),
        }
    }

    /// Loads and slip of a ball in the last step.
    pub(crate) fn seen(&self, ball: usize) -> BallSeen {
        match self {
            Self::Full(of) => {
                let now = PackedStepLoads(of.steps.step_loads()).of(ball);
                BallSeen { load: now.load, slip: now.slip_square.map(|square| square.sqrt()), pocket: now.pocket }
            }
            Self::RadiallyCondensed(of) => of.steps.seen(ball),
        }
    }

    /// Speed of the cage; without a cage, mean orbit speed of the balls [rad/s].
    pub(crate) fn cage_speed(&self, time: f64) -> f64 {
        let m = self.bearing().dynamics.mechanism();
        let arc_velocity = match self {
            Self::Full(of) => {
                let (layout, state, balls) = (m.layout, of.steps.state(), m.layout.balls);
                match layout.cage {
                    true => layout.cage(state).arc_velocity,
                    false => (0..balls).map(|ball| layout.ball(state, ball).arc_velocity).sum::<f64>() / balls as f64,
                }
            }
            Self::RadiallyCondensed(of) => of.steps.arc_velocity(),
        };
        m.orbit_speed(&m.rotations(time), arc_velocity)
    }

    /// Spin of a ball in the orbit frame [rad/s].
    pub(crate) fn spin(&self, ball: usize, time: f64) -> Vector {
        let m = self.bearing().dynamics.mechanism();
        let (arc_velocity, [x, y, z]) = match self {
            Self::Full(of) => {
                let ball = m.layout.ball(of.steps.state(), ball);
                (ball.arc_velocity, ball.spin)
            }
            Self::RadiallyCondensed(of) => {
                let (arc_velocity, about_x) = of.steps.ball(ball);
                (arc_velocity, [about_x, 0.0, 0.0])
            }
        };
        [m.rotations(time).turn_speed + x - arc_velocity / m.pitch_radius, y, z]
    }

    /// A ball that touches its neighbour, where there is no cage.
    pub(crate) fn touching(&self) -> Option<usize> {
        match self {
            Self::Full(of) => of.steps.touching(),
            Self::RadiallyCondensed(_) => None,
        }
    }

    fn bearing(&self) -> &'m BearingOnShaft {
        match self {
            Self::Full(of) => of.bearing,
            Self::RadiallyCondensed(of) => of.bearing,
        }
    }
}

impl CondensedStepper<'_> {
    fn port(&self, LoadOnRing { force: [y, z], slope: [yy, yz, zz] }: &LoadOnRing, ring: &SpindleState) -> PortLoad {
        let (mounted, hold) = (&self.bearing.mounted, self.tilt);
        let mut slope = [[0.0; 5]; 5];
        (slope[1][1], slope[1][2], slope[2][1], slope[2][2]) = (*yy, *yz, *yz, *zz);
        let [stiffness, damping] = [&hold.stiffness, &hold.damping].map(|of_tilt| {
            let mut matrix = [[0.0; 5]; 5];
            (0..2).for_each(|row| matrix[3 + row][3..].copy_from_slice(&of_tilt[row]));
            mounted.along_shaft(&matrix)
        });
        let [about_y, about_z] = hold.moment(ring);
        PortLoad {
            wrench: mounted.wrench_on_shaft(&[0.0, *y, *z, about_y, about_z]),
            resistance: Resistance { stiffness, damping, slope: Some(mounted.along_shaft(&slope)) },
        }
    }
}

fn in_plane(ring: &SpindleState, acceleration: [f64; 2]) -> RingMotion {
    let ([_, y, z], [_, vy, vz]) = (ring.position, ring.velocity);
    RingMotion { place: [y, z], velocity: [vy, vz], acceleration }
}
