use super::bearing::{Bearing, BearingKind, BearingParameters, Fit, PerRaceway};
use super::cage::{CageParameters, PocketFilm, PocketSeat};
use super::contact::damping::DampingLaw;
use super::contact::traction::TractionLaw;
use super::lubricant::{Lubricant, LubricantKind};
use super::material::Material;

pub struct Parts {
    pub bearing: Bearing,
    pub cage: CageParameters,
    pub lubricant: Lubricant,
}

pub const STEEL: Material = Material { elastic_modulus: 219e9, poisson_ratio: 0.3, density: 7830.0 };

/// The article's integrated bearing with the defaults of `docs/MODEL.md`.
pub fn article() -> Parts {
    let bearing = Bearing::new(BearingParameters {
        kind: BearingKind::Integrated,
        outer_diameter: 18e-3,
        inner_diameter: 8.5e-3,
        width: 5.9e-3,
        ball_count: 7,
        ball_diameter: 2.778e-3,
        pitch_diameter: 13e-3,
        groove_curvature: PerRaceway { inner: 0.529, outer: 0.529 },
        fit: Fit::RadialClearance(5e-6),
        ball_material: STEEL,
        raceway_material: PerRaceway { inner: STEEL, outer: STEEL },
    })
    .unwrap();
    let cage = CageParameters {
        material: Material { elastic_modulus: 1e9, poisson_ratio: 0.39, density: 1100.0 },
        mass: 0.13e-3,
        axial_inertia: 5.5e-9,
        transverse_inertia: 3e-9,
        offset: 0.7e-3,
        pocket_clearance: 51e-6,
        seat: PocketSeat::Open,
        rim_angle: 65f64.to_radians(),
        seat_half_width: 1e-3,
        film: PocketFilm::Wedge,
        friction: 0.08,
        friction_speed: 0.05,
        bar_stiffness: None,
        land: None,
        damping: DampingLaw::Restitution { restitution: 0.6, at_speed: 0.1 },
    };
    let lubricant = Lubricant {
        kind: LubricantKind::Grease,
        viscosity: 0.02,
        pressure_viscosity: 2e-8,
        fill: 0.05,
        inlet_distance: None,
        traction: TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.05, at_slip: 1.0, limit: 0.036 },
    };
    Parts { bearing, cage, lubricant }
}
