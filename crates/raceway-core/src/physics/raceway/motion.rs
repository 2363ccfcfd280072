//! Motion of a ball on a raceway, and the loads that answer it.

use crate::numerics::lanes::side_by_side;
use crate::physics::frames::Vector;

/// Motion of a ball relative to the raceway's centre, in the contact's frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct RelativeMotion<T = f64> {
    /// Ball centre along the raceway's axis [m].
    pub axial: T,
    /// Distance of the ball centre from the raceway's axis [m].
    pub radius: T,
    /// Velocity of the ball centre less that of the raceway's centre [m/s].
    pub velocity: Vector<T>,
    /// Angular velocity of the ball [rad/s].
    pub spin: Vector<T>,
    /// Angular speed of the raceway about its axis [rad/s].
    pub raceway_speed: T,
    /// Angular speed at which the contact moves round the raceway's axis [rad/s].
    pub orbit_speed: T,
    /// Azimuth of the ball on the raceway itself, about its own axis [rad]; only a surface profile asks for it.
    pub azimuth: T,
}
side_by_side!(RelativeMotion { axial, radius, velocity, spin, raceway_speed, orbit_speed, azimuth });

impl RelativeMotion {
    /// Rate at which the ball's azimuth on the raceway changes [rad/s].
    #[inline(always)]
    pub(super) fn azimuth_rate(&self) -> f64 {
        self.velocity[2] / self.radius - self.raceway_speed
    }
}

/// Load of a raceway on a ball; the raceway takes the opposite force.
#[derive(Debug, Clone, Copy, Default)]
pub struct RacewayLoad<T = f64> {
    /// [m]; not positive: no contact.
    pub penetration: T,
    /// [N]
    pub normal: T,
    /// Sine and cosine of the contact angle.
    pub angle: (T, T),
    /// Force on the ball [N].
    pub force: Vector<T>,
    /// Moment on the ball about its centre [N m].
    pub moment: Vector<T>,
    /// Slip speed of the raceway over the ball at the contact's centre, along the groove and across it [m/s].
    pub slip: (T, T),
    /// Traction over slip, Σ Q_k μ(u_k)/u_k of the strips [N s/m].
    pub grip: T,
}
side_by_side!(RacewayLoad { penetration, normal, angle, force, moment, slip, grip });

/// Slopes of a contact's loads by the motion of the ball, for linearly implicit methods. Traction has the same slope
/// along the groove and across it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactSlopes<T = f64> {
    /// Unit vector from the ball towards the contact, axial and radial.
    pub towards: (T, T),
    /// Slope of the normal load by penetration [N/m] and by its rate [N s/m].
    pub stiffness: T,
    pub damping: T,
    /// Slope of the force across the groove by displacement across it [N/m], because the normal load turns with its
    /// direction.
    pub turning: T,
    /// Slope of traction by slip [N s/m].
    pub grip: T,
}
side_by_side!(ContactSlopes { towards, stiffness, damping, turning, grip });
