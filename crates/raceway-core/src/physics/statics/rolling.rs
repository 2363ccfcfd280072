//! Forces of a ball that rolls: centrifugal force, and the tractions that hold its spin axis against the gyroscopic moment.
//!
//! They have no potential. A ball rolls at the centres of both contacts and does not turn about the normal of the outer one (outer raceway
//! control). Both raceways resist the gyroscopic moment with one coefficient of traction, because the ball slips across both alike.

use super::groove::InGroove;
use crate::physics::bearing::{Bearing, PerRaceway};
use crate::physics::kinematics::{self, LoadedBall, RingSpeeds};

/// Traction over the load of the lighter contact beyond which a ball slips [-]: no lubricant transmits more between rolling steel.
const MOST_TRACTION: f64 = 0.1;

/// How the balls of a bearing roll.
#[derive(Debug, Clone)]
pub(super) struct Rolling {
    /// Ratio of the orbit speed in ideal rolling [-].
    ideal_orbit: f64,
    pub(super) ball_radius: f64,
    pub(super) ball_mass: f64,
    ball_inertia: f64,
    /// Balls roll at their loaded contact angles. Otherwise they orbit as in ideal rolling and have no gyroscopic moment.
    pub(super) at_loaded_angles: bool,
}

/// Forces of rolling on a ball [N].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RollingForces {
    pub(super) centrifugal: f64,
    /// Across the grooves, both against the gyroscopic moment.
    pub(super) traction: PerRaceway<f64>,
}

impl Rolling {
    pub(super) fn new(bearing: &Bearing) -> Self {
        Self {
            ideal_orbit: kinematics::ideal_orbit_ratio(bearing),
            ball_radius: 0.5 * bearing.parameters.ball_diameter,
            ball_mass: bearing.ball_mass,
            ball_inertia: bearing.ball_inertia,
            at_loaded_angles: true,
        }
    }

    /// Centrifugal force on a ball in ideal rolling on an orbit of a radius [N].
    pub(super) fn ideal_centrifugal(&self, speeds: RingSpeeds, radius: f64) -> f64 {
        self.centrifugal(speeds.carried(self.ideal_orbit), radius)
    }

    fn centrifugal(&self, orbit: f64, radius: f64) -> f64 {
        self.ball_mass * orbit * orbit * radius
    }

    /// Forces on a ball with an orbit radius [m] in both grooves.
    pub(super) fn forces(&self, speeds: RingSpeeds, orbit_radius: f64, at: &PerRaceway<InGroove>) -> RollingForces {
        let ideal =
            || RollingForces { centrifugal: self.ideal_centrifugal(speeds, orbit_radius), ..Default::default() };
        if !self.at_loaded_angles {
            return ideal();
        }
        let (outer, inner) = (at.outer.direction, at.inner.direction);
        let angle = PerRaceway { inner: (-inner.0, -inner.1), outer };
        let ball = LoadedBall { orbit_radius, ball_radius: self.ball_radius, angle };
        let axis = ball.outer_control();
        let Some((orbit, spin)) = ball.orbit_ratio(axis).zip(ball.spin_ratio(axis)) else { return ideal() };
        let orbit = speeds.carried(orbit);
        // I_b θ̇ ω_r about the orbit, over the arm of both tractions.
        let radial_spin = spin * speeds.relative() * axis.1 / axis.0.hypot(axis.1);
        let moment = self.ball_inertia * orbit * radial_spin;
        // A ball that only one raceway holds is turned by none: its spin axis does not follow its contact.
        let most = 2.0 * MOST_TRACTION * at.inner.load.min(at.outer.load);
        let traction = (moment / self.ball_radius).clamp(-most, most);
        let load = at.inner.load + at.outer.load;
        let share = |raceway: &InGroove| if load > 0.0 { traction * raceway.load / load } else { 0.0 };
        RollingForces {
            centrifugal: self.centrifugal(orbit, orbit_radius),
            traction: PerRaceway { inner: share(&at.inner), outer: share(&at.outer) },
        }
    }
}
