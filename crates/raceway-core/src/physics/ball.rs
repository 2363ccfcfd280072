//! A ball: rigid, homogeneous, six degrees of freedom.

use super::bearing::Bearing;
use super::frames::{Azimuth, Vector};
use crate::numerics::lanes::{Lanes, SideBySide, side_by_side};

/// Motion of a ball, vectors in its orbit frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BallMotion<T = f64> {
    /// [rad]
    pub azimuth_angle: T,
    pub azimuth: Azimuth<T>,
    /// [m]
    pub axial: T,
    /// Distance from the bearing axis [m].
    pub radius: T,
    /// θ̇ [rad/s]
    pub orbit_speed: T,
    /// [m/s]
    pub velocity: Vector<T>,
    /// [rad/s]
    pub spin: Vector<T>,
}
side_by_side!(BallMotion { azimuth_angle, azimuth, axial, radius, orbit_speed, velocity, spin });

/// Size and mass of a ball.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallBody<T = f64> {
    /// Radius less the nominal one [m].
    pub oversize: T,
    /// [kg]
    pub mass: T,
    /// Moment of inertia about any axis [kg m²].
    pub inertia: T,
    /// Reciprocals, divided once [1/kg, 1/(kg m²)].
    pub per_mass: T,
    pub per_inertia: T,
}
side_by_side!(BallBody { oversize, mass, inertia, per_mass, per_inertia });

/// Bodies of balls side by side: one for all, or one for each.
pub(crate) trait Bodies: Copy {
    /// The body of a lane.
    fn of(&self, lane: usize) -> BallBody;
    /// Mass and moment of inertia of each lane over a share of a step; equal balls share one division.
    fn over(&self, share: f64) -> (Lanes, Lanes);
}

impl Bodies for BallBody {
    #[inline(always)]
    fn of(&self, _: usize) -> BallBody {
        *self
    }

    #[inline(always)]
    fn over(&self, share: f64) -> (Lanes, Lanes) {
        (Lanes::all(self.mass / share), Lanes::all(self.inertia / share))
    }
}

impl Bodies for BallBody<Lanes> {
    #[inline(always)]
    fn of(&self, lane: usize) -> BallBody {
        self.at(lane)
    }

    #[inline(always)]
    fn over(&self, share: f64) -> (Lanes, Lanes) {
        (Lanes(self.mass.0.map(|mass| mass / share)), Lanes(self.inertia.0.map(|inertia| inertia / share)))
    }
}

impl BallBody {
    /// A ball of a bearing whose diameter deviates from nominal [m].
    pub(crate) fn new(bearing: &Bearing, diameter_deviation: f64) -> Self {
        let ratio = 1.0 + diameter_deviation / bearing.parameters.ball_diameter;
        let (mass, inertia) = (bearing.ball_mass * ratio.powi(3), bearing.ball_inertia * ratio.powi(5));
        let (per_mass, per_inertia) = (1.0 / mass, 1.0 / inertia);
        Self { oversize: 0.5 * diameter_deviation, mass, inertia, per_mass, per_inertia }
    }
}

/// Second derivatives of a ball's coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BallAcceleration {
    /// ẍ [m/s²]
    pub axial: f64,
    /// r̈ [m/s²]
    pub radial: f64,
    /// θ̈ [rad/s²]
    pub azimuthal: f64,
    /// Rates of the components of ω in the orbit frame [rad/s²].
    pub spin: Vector,
}

impl BallMotion {
    /// Equations (1)–(6): m (ẍ, r̈ − r θ̇², r θ̈ + 2 ṙ θ̇) = F and I (ω̇_x, ω̇_r − ω_t θ̇, ω̇_t + ω_r θ̇) = M. The
    /// components of ω belong to a frame that turns with θ̇ about x.
    #[inline(always)]
    pub(crate) fn acceleration(&self, force: Vector, moment: Vector, body: &BallBody) -> BallAcceleration {
        let (orbit, per_mass, per_inertia) = (self.orbit_speed, body.per_mass, body.per_inertia);
        BallAcceleration {
            axial: force[0] * per_mass,
            radial: force[1] * per_mass + self.radius * orbit * orbit,
            azimuthal: (force[2] * per_mass - 2.0 * self.velocity[1] * orbit) / self.radius,
            spin: [
                moment[0] * per_inertia,
                moment[1] * per_inertia + orbit * self.spin[2],
                moment[2] * per_inertia - orbit * self.spin[1],
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A free ball flies straight on and keeps its spin in space, seen from its turning frame.
    #[test]
    fn a_free_ball_keeps_velocity_and_spin() {
        let (azimuth, radius, speed) = (0.3, 2.0, 5.0);
        let motion = BallMotion {
            azimuth_angle: azimuth,
            azimuth: Azimuth::new(azimuth),
            axial: 0.0,
            radius,
            orbit_speed: speed,
            velocity: [0.5, -1.5, radius * speed],
            spin: [1.0, 2.0, 3.0],
        };
        let a = motion.acceleration([0.0; 3], [0.0; 3], &BallBody::default());
        // d²/dt² of (r cos θ, r sin θ) must vanish.
        let (r1, t1) = (motion.velocity[1], speed);
        let radial = a.radial - radius * t1 * t1;
        let across = radius * a.azimuthal + 2.0 * r1 * t1;
        assert_eq!((radial, across, a.axial), (0.0, 0.0, 0.0));
        // dω/dt in space = rate of components + θ̇ x × ω.
        assert_eq!([a.spin[0], a.spin[1] - speed * 3.0, a.spin[2] + speed * 2.0], [0.0; 3]);
    }
}
