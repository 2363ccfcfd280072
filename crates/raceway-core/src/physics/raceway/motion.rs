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
    /// Azimuth of the ball on the raceway itself [rad]; only a surface profile asks for it.
    pub azimuth: T,
}
side_by_side!(RelativeMotion { axial, radius, velocity, spin, raceway_speed, orbit_speed, azimuth });

/// What a raceway does to a ball; the raceway feels the opposite force.
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

/// How a contact's loads answer to a ball that moves on: what a linearly implicit method needs of them. Rates of slip are
/// answered by the traction as a whole, with the same grip along the groove and across it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactSlopes<T = f64> {
    /// Unit vector from the ball towards the contact, axial and radial.
    pub towards: (T, T),
    /// Of the normal load, by penetration [N/m] and by its rate [N s/m].
    pub stiffness: T,
    pub damping: T,
    /// Of the force across the groove, by displacement across it: the normal load turns with its direction [N/m].
    pub turning: T,
    /// Of traction, by slip [N s/m].
    pub grip: T,
}
side_by_side!(ContactSlopes { towards, stiffness, damping, turning, grip });
