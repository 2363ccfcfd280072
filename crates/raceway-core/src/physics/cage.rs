//! The crown cage: a rigid body with one pocket per ball.

use super::contact::damping::DampingLaw;
use super::frames::{Tilt, Vector, scale};
use super::limits::Faults;
use super::material::Material;

/// Shape of a pocket seat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PocketSeat {
    /// A spherical cap that ends in a rim, open towards +X: a crown cage.
    Open,
    /// A whole sphere.
    Closed,
}

/// Lubricant between ball and pocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PocketFilm {
    None,
    /// Stiffness of a truncated wedge at the operating speed, damping 3 N s/m.
    Wedge,
    /// K_c = 11 N / C_p of the literature.
    Empirical11,
    /// Stiffness [N/m] and damping [N s/m] as given.
    Given {
        stiffness: f64,
        damping: f64,
    },
}

/// Land guidance of the cage: a short journal bearing between cage and outer ring shoulder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuidingLand {
    /// Diametral clearance [m].
    pub clearance: f64,
    /// Diameter of the land [m].
    pub diameter: f64,
    /// Axial width of the land [m].
    pub width: f64,
}

/// A cage, unchecked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CageParameters {
    pub material: Material,
    /// [kg]
    pub mass: f64,
    /// Moment of inertia about the cage axis [kg m²].
    pub axial_inertia: f64,
    /// Moment of inertia about any transverse axis [kg m²].
    pub transverse_inertia: f64,
    /// Distance `L` from the centre of mass to the pocket plane, along +X [m].
    pub offset: f64,
    /// Diametral pocket clearance [m]; `C_p` is half of it.
    pub pocket_clearance: f64,
    pub seat: PocketSeat,
    /// Angle between mouth axis and rim, seen from the pocket centre [rad].
    pub rim_angle: f64,
    /// Half width `w_p` of the seat for the film [m].
    pub seat_half_width: f64,
    pub film: PocketFilm,
    /// Coefficient of dry friction in the pocket [-].
    pub friction: f64,
    /// Slip speed at which friction is fully developed [m/s].
    pub friction_speed: f64,
    /// Stiffness of the cage bars in series with the pocket contact [N/m]; `None`: rigid bars.
    pub bar_stiffness: Option<f64>,
    /// `None`: the cage is guided by its balls.
    pub land: Option<GuidingLand>,
    pub damping: DampingLaw,
}

impl CageParameters {
    /// Returns true where both sides are alike, so that the cage has no axial force while it stays in the plane of its
    /// balls.
    pub(crate) fn is_symmetric(&self) -> bool {
        self.offset == 0.0 && self.seat == PocketSeat::Closed
    }

    /// Records values outside the limits.
    pub(crate) fn check(&self, faults: &mut Faults) {
        self.material.check(
            [
                "bearing.materials.cage.elastic_modulus",
                "bearing.materials.cage.poisson_ratio",
                "bearing.materials.cage.density",
            ],
            faults,
        );
        faults.check("bearing.cage.mass", self.mass);
        faults.check("bearing.cage.axial_inertia", self.axial_inertia);
        faults.check("bearing.cage.transverse_inertia", self.transverse_inertia);
        faults.check("bearing.cage.offset", self.offset);
        faults.check("bearing.cage.pocket_clearance", self.pocket_clearance);
        faults.check("bearing.cage.rim_angle", self.rim_angle);
        faults.check("bearing.cage.seat_half_width", self.seat_half_width);
        faults.check("bearing.cage.friction", self.friction);
        faults.check("bearing.cage.friction_speed", self.friction_speed);
        if let Some(stiffness) = self.bar_stiffness {
            faults.check("bearing.cage.bar_stiffness", stiffness);
        }
        if let Some(land) = self.land {
            faults.check("bearing.cage.land.clearance", land.clearance);
            faults.check("bearing.cage.land.diameter", land.diameter);
            faults.check("bearing.cage.land.width", land.width);
        }
        if let PocketFilm::Given { stiffness, damping } = self.film {
            faults.check("bearing.cage.film.stiffness", stiffness);
            faults.check("bearing.cage.film.damping", damping);
        }
        self.damping.check(["damping.pocket.restitution", "damping.pocket.at_speed", "damping.pocket.viscous"], faults);
    }
}

/// Motion of the cage: centre of mass in the inertial frame, angular velocity in its tilted, not spinning frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CageMotion {
    /// [m]
    pub centre: Vector,
    /// [m/s]
    pub velocity: Vector,
    pub tilt: Tilt,
    /// Angular velocity of the cage [rad/s].
    pub spin: Vector,
}

/// Accelerations of the cage.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CageAcceleration {
    /// [m/s²], inertial frame
    pub linear: Vector,
    /// Rate of change of the angular velocity's components in the tilted frame [rad/s²].
    pub angular: Vector,
}

impl CageParameters {
    /// Equations (7)–(12): Newton for the centre of mass and Euler about it, for a body of revolution in
    /// a frame that tilts with it but does not spin. `force` [N] in the inertial frame, gravity left out;
    /// `moment` [N m] in the tilted frame.
    #[inline(always)]
    pub(crate) fn acceleration(
        &self,
        motion: &CageMotion,
        force: Vector,
        moment: Vector,
        gravity: f64,
    ) -> CageAcceleration {
        let (axial, transverse) = (self.axial_inertia, self.transverse_inertia);
        let CageAcceleration { linear, angular } = self.response(force, moment);
        let [spin, about_y, about_z] = motion.spin;
        // The frame itself turns about x by −β̇ sin-part of its Cardan angles.
        let frame = about_y * motion.tilt.tangent_about_z();
        let gyroscopic = axial / transverse * spin - frame;
        CageAcceleration {
            linear: [linear[0], linear[1] + gravity, linear[2]],
            angular: [angular[0], angular[1] - gyroscopic * about_z, angular[2] + gyroscopic * about_y],
        }
    }

    /// Accelerations due to a force and a moment.
    #[inline(always)]
    pub(crate) fn response(&self, force: Vector, moment: Vector) -> CageAcceleration {
        let (per_axial, per_transverse) = (1.0 / self.axial_inertia, 1.0 / self.transverse_inertia);
        CageAcceleration {
            linear: scale(1.0 / self.mass, force),
            angular: [moment[0] * per_axial, moment[1] * per_transverse, moment[2] * per_transverse],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::frames::{length, subtract};

    /// A free body of revolution keeps its angular momentum in the inertial frame (regular precession),
    /// integrated by the midpoint rule over many turns.
    #[test]
    fn a_free_cage_keeps_its_angular_momentum() {
        let cage = crate::physics::examples::article_cage();
        // (tilt about y, tilt about z, ω in the tilted frame)
        let rates = |y: [f64; 5]| {
            let motion = CageMotion {
                centre: [0.0; 3],
                velocity: [0.0; 3],
                tilt: Tilt::new(y[0], y[1]),
                spin: [y[2], y[3], y[4]],
            };
            let a = cage.acceleration(&motion, [0.0; 3], [0.0; 3], 0.0).angular;
            [y[3] / y[1].cos(), y[4], a[0], a[1], a[2]]
        };
        let momentum = |y: [f64; 5]| {
            let body = [cage.axial_inertia * y[2], cage.transverse_inertia * y[3], cage.transverse_inertia * y[4]];
            Tilt::new(y[0], y[1]).to_inertial(body)
        };
        let mut y = [0.02, -0.03, 2000.0, 40.0, -25.0];
        let before = momentum(y);
        let step = 1e-7;
        for _ in 0..100_000 {
            let k = rates(y);
            let middle = std::array::from_fn(|i| y[i] + 0.5 * step * k[i]);
            let k = rates(middle);
            y = std::array::from_fn(|i| y[i] + step * k[i]);
        }
        assert!(length(subtract(momentum(y), before)) < 1e-6 * length(before));
        assert!(y[0].abs() > 1e-6);
    }
}
