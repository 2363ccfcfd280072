//! The crown cage: a rigid body with a pocket a ball.

use super::contact::damping::DampingLaw;
use super::material::Material;
use super::{InvalidParameter, above, within};

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
    /// Refuses what no cage has.
    pub fn check(&self) -> Result<(), InvalidParameter> {
        self.material.check([
            "bearing.materials.cage.elastic_modulus",
            "bearing.materials.cage.poisson_ratio",
            "bearing.materials.cage.density",
        ])?;
        above("bearing.cage.mass", self.mass, 0.0, 1000.0)?;
        above("bearing.cage.axial_inertia", self.axial_inertia, 0.0, 1e4)?;
        above("bearing.cage.transverse_inertia", self.transverse_inertia, 0.0, 1e4)?;
        within("bearing.cage.offset", self.offset, -1.0, 1.0)?;
        above("bearing.cage.pocket_clearance", self.pocket_clearance, 0.0, 0.1)?;
        within("bearing.cage.rim_angle", self.rim_angle, 0.1, 1.5)?;
        above("bearing.cage.seat_half_width", self.seat_half_width, 0.0, 1.0)?;
        within("bearing.cage.friction", self.friction, 0.0, 2.0)?;
        above("bearing.cage.friction_speed", self.friction_speed, 0.0, 100.0)?;
        if let Some(stiffness) = self.bar_stiffness {
            above("bearing.cage.bar_stiffness", stiffness, 0.0, 1e12)?;
        }
        if let Some(land) = self.land {
            above("bearing.cage.land.clearance", land.clearance, 0.0, 0.1)?;
            above("bearing.cage.land.diameter", land.diameter, 0.0, 10.0)?;
            above("bearing.cage.land.width", land.width, 0.0, 1.0)?;
        }
        if let PocketFilm::Given { stiffness, damping } = self.film {
            within("bearing.cage.film.stiffness", stiffness, 0.0, 1e10)?;
            within("bearing.cage.film.damping", damping, 0.0, 1e5)?;
        }
        self.damping.check(["damping.pocket.restitution", "damping.pocket.at_speed", "damping.pocket.viscous"])
    }
}
