//! Physical defaults of quantities that catalogues do not list, from the dimensions of the bearing.
//!
//! Lengths, masses and angles here have the units of catalogues, so that a default is a short decimal number; the methods named
//! `parameters` convert to SI.

use std::f64::consts::{FRAC_PI_4, PI};

use super::bearing::{BearingKind, BearingParameters, Fit, PerRaceway};
use super::cage::{CageParameters, PocketFilm, PocketSeat};
use super::clearance::default_clearance_um;
use super::contact::damping::DampingLaw;
use super::contact::traction::TractionLaw;
use super::lubricant::LubricantKind;
use super::material::{GCR15, Material, PA46};
use super::spindle::SpindleInertia;
use crate::numerics::rounding::significant;

/// Acceleration of gravity [m/s²].
pub const GRAVITY: f64 = 9.81;
/// Restitution of steel on steel and of steel on polyamide, by order of magnitude [-].
pub const RACEWAY_RESTITUTION: f64 = 0.9;
pub const POCKET_RESTITUTION: f64 = 0.6;
/// Impact speed at which these restitutions hold [m/s].
pub const IMPACT_SPEED: f64 = 0.1;

/// Default damping of balls on raceways and in pockets.
pub const RACEWAY_DAMPING: DampingLaw =
    DampingLaw::Restitution { restitution: RACEWAY_RESTITUTION, at_speed: IMPACT_SPEED };
pub const POCKET_DAMPING: DampingLaw =
    DampingLaw::Restitution { restitution: POCKET_RESTITUTION, at_speed: IMPACT_SPEED };

/// Default coefficients of each traction law. `SlideRoll` has none, because no fit for a real oil is public.
pub const FOUR_PARAMETER: TractionLaw =
    TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.05, at_slip: 1.0, limit: 0.036 };
pub const EYRING: TractionLaw = TractionLaw::Eyring { stress: 5e6, limit: 0.08 };
pub const COULOMB: TractionLaw = TractionLaw::Coulomb { coefficient: 0.1, regularisation: 0.05 };

/// Main dimensions and balls, as catalogues and tables for vibration analysis print them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dimensions {
    /// Outer diameter D [mm].
    pub outer_diameter_mm: f64,
    /// Bore; of an integrated bearing the diameter of its spindle [mm].
    pub inner_diameter_mm: f64,
    /// Width B [mm].
    pub width_mm: f64,
    /// Number of balls Z [-].
    pub ball_count: usize,
    /// Ball diameter d [mm].
    pub ball_diameter_mm: f64,
    /// Pitch diameter D_m [mm].
    pub pitch_diameter_mm: f64,
}

/// Clearance or contact angle; one determines the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefaultFit {
    /// Diametral radial clearance [µm].
    RadialClearanceUm(f64),
    /// Free contact angle [°].
    ContactAngleDeg(f64),
}

/// A crown cage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrownCage {
    pub material: Material,
    /// Diametral clearance of a ball in its pocket [mm].
    pub pocket_clearance_mm: f64,
    /// Mass [g].
    pub mass_g: f64,
    /// Moment of inertia about the bearing axis [kg m²].
    pub axial_inertia_kg_m2: f64,
    /// Moment of inertia about a transverse axis [kg m²].
    pub transverse_inertia_kg_m2: f64,
    /// Distance from the centre of mass to the plane of the pockets, along +X [mm].
    pub offset_mm: f64,
    pub seat: PocketSeat,
    /// Angle between the axis of the pocket's mouth and its rim [°].
    pub rim_angle_deg: f64,
    /// Half width of the pocket's seat [mm].
    pub seat_half_width_mm: f64,
    /// Coefficient of dry friction in the pockets [-].
    pub friction: f64,
    /// Slip speed at which that friction is fully developed [m/s].
    pub friction_speed_m_s: f64,
}

/// Defaults of the quantities that the dimensions do not set, with spindle and lubricant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingDefaults {
    pub kind: BearingKind,
    /// Groove radius over ball diameter [-].
    pub groove_curvature: PerRaceway<f64>,
    pub fit: DefaultFit,
    pub ball_material: Material,
    pub raceway_material: PerRaceway<Material>,
    pub cage: CrownCage,
    /// [kg]
    pub spindle_mass: f64,
    pub lubricant: LubricantKind,
}

impl BearingDefaults {
    /// Defaults for these dimensions: groove curvatures 0.52 and 0.53, and a clearance in the middle of group N (15°
    /// for angular contact). Balls and raceways are GCr15, the crown cage PA46, the spindle solid steel of the bore,
    /// the lubricant grease.
    pub fn new(kind: BearingKind, dimensions: &Dimensions) -> Self {
        Self {
            kind,
            groove_curvature: PerRaceway { inner: 0.52, outer: 0.53 },
            fit: match kind {
                BearingKind::AngularContact => DefaultFit::ContactAngleDeg(15.0),
                BearingKind::Integrated | BearingKind::DeepGroove => {
                    DefaultFit::RadialClearanceUm(default_clearance_um(dimensions.inner_diameter_mm))
                }
            },
            ball_material: GCR15,
            raceway_material: PerRaceway { inner: GCR15, outer: GCR15 },
            cage: CrownCage::scaled(dimensions.ball_diameter_mm, dimensions.pitch_diameter_mm),
            spindle_mass: shaft_mass(dimensions.inner_diameter_mm),
            lubricant: LubricantKind::Grease,
        }
    }

    /// The bearing in SI.
    pub fn parameters(&self, dimensions: &Dimensions) -> BearingParameters {
        BearingParameters {
            kind: self.kind,
            outer_diameter: dimensions.outer_diameter_mm / 1e3,
            inner_diameter: dimensions.inner_diameter_mm / 1e3,
            width: dimensions.width_mm / 1e3,
            ball_count: dimensions.ball_count,
            ball_diameter: dimensions.ball_diameter_mm / 1e3,
            pitch_diameter: dimensions.pitch_diameter_mm / 1e3,
            groove_curvature: self.groove_curvature,
            fit: match self.fit {
                DefaultFit::RadialClearanceUm(clearance) => Fit::RadialClearance(clearance / 1e6),
                DefaultFit::ContactAngleDeg(angle) => Fit::ContactAngle(angle * PI / 180.0),
            },
            ball_material: self.ball_material,
            raceway_material: self.raceway_material,
        }
    }
}

impl CrownCage {
    /// The article's PA46 crown (0.13 g at D_m 13 mm and d 2.778 mm), scaled by ball and pitch diameter [mm].
    ///
    /// The mass scales as D_m d², the volume of a ring as thick and as wide as the balls. Moments of inertia scale as
    /// mass times D_m². Offset, clearance and seat scale as d.
    pub fn scaled(ball_diameter_mm: f64, pitch_diameter_mm: f64) -> Self {
        let ball = ball_diameter_mm / 2.778;
        let pitch = pitch_diameter_mm / 13.0;
        let mass = pitch * ball * ball;
        let inertia = mass * pitch * pitch;
        let rounded = |value: f64| significant(value, 4);
        Self {
            material: PA46,
            pocket_clearance_mm: rounded(0.051 * ball),
            mass_g: rounded(0.13 * mass),
            axial_inertia_kg_m2: rounded(5.5e-9 * inertia),
            transverse_inertia_kg_m2: rounded(3e-9 * inertia),
            offset_mm: rounded(0.7 * ball),
            seat: PocketSeat::Open,
            rim_angle_deg: 65.0,
            seat_half_width_mm: rounded(ball),
            friction: 0.08,
            friction_speed_m_s: 0.05,
        }
    }

    /// The cage in SI, guided by its balls, with rigid bars and the default film and damping.
    pub fn parameters(&self, lubricant: LubricantKind) -> CageParameters {
        CageParameters {
            material: self.material,
            mass: self.mass_g / 1e3,
            axial_inertia: self.axial_inertia_kg_m2,
            transverse_inertia: self.transverse_inertia_kg_m2,
            offset: self.offset_mm / 1e3,
            pocket_clearance: self.pocket_clearance_mm / 1e3,
            seat: self.seat,
            rim_angle: self.rim_angle_deg * PI / 180.0,
            seat_half_width: self.seat_half_width_mm / 1e3,
            film: pocket_film(lubricant),
            friction: self.friction,
            friction_speed: self.friction_speed_m_s,
            bar_stiffness: None,
            land: None,
            damping: POCKET_DAMPING,
        }
    }
}

/// Film in the pockets: none in a dry bearing.
pub fn pocket_film(lubricant: LubricantKind) -> PocketFilm {
    match lubricant {
        LubricantKind::Dry => PocketFilm::None,
        LubricantKind::Grease | LubricantKind::Oil => PocketFilm::Wedge,
    }
}

/// Mass of a solid steel shaft of the bore [mm], 7 bores long [kg].
pub fn shaft_mass(bore_mm: f64) -> f64 {
    let bore = bore_mm / 1e3;
    significant(GCR15.density * FRAC_PI_4 * bore * bore * SHAFT_LENGTH * bore, 4)
}

/// Length of a shaft over its diameter [-].
const SHAFT_LENGTH: f64 = 7.0;

/// Moments of inertia of a solid steel shaft of this shape and a mass [kg].
pub fn spindle_inertia(mass: f64) -> SpindleInertia {
    let diameter = (mass / (GCR15.density * FRAC_PI_4 * SHAFT_LENGTH)).cbrt();
    let of_cylinder = SpindleInertia::of_cylinder(mass, diameter, SHAFT_LENGTH * diameter);
    SpindleInertia { transverse: significant(of_cylinder.transverse, 4), axial: significant(of_cylinder.axial, 4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_article_scales_to_itself() {
        let cage = CrownCage::scaled(2.778, 13.0);
        assert_eq!((cage.mass_g, cage.axial_inertia_kg_m2), (0.13, 5.5e-9));
        assert_eq!((cage.offset_mm, cage.pocket_clearance_mm), (0.7, 0.051));
    }
}
