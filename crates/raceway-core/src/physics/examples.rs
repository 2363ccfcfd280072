//! Bearings with published numbers, for tests.

use super::bearing::{Bearing, BearingKind, BearingParameters, Fit, PerRaceway};
use super::cage::{CageParameters, PocketFilm, PocketSeat};
use super::contact::damping::DampingLaw;
use super::contact::traction::TractionLaw;
use super::lubricant::{Lubricant, LubricantKind};
use super::material::Material;

/// A deep-groove bearing of steel, sizes in mm, with generous rings.
pub(crate) fn deep_groove(balls: usize, d: f64, pitch: f64, f: [f64; 2], clearance: f64, modulus: f64) -> Bearing {
    let steel = Material { elastic_modulus: modulus, poisson_ratio: 0.3, density: 7830.0 };
    Bearing::new(BearingParameters {
        kind: BearingKind::DeepGroove,
        outer_diameter: (pitch + 1.8 * d) * 1e-3,
        inner_diameter: (pitch - 1.8 * d) * 1e-3,
        width: 2.0 * d * 1e-3,
        ball_count: balls,
        ball_diameter: d * 1e-3,
        pitch_diameter: pitch * 1e-3,
        groove_curvature: PerRaceway { inner: f[0], outer: f[1] },
        fit: Fit::RadialClearance(clearance),
        ball_material: steel,
        raceway_material: PerRaceway { inner: steel, outer: steel },
    })
    .unwrap()
}

/// The integrated bearing of Zhi et al., Appl. Sci. 2025, 15(1), 98, table 1.
pub(crate) fn article_bearing() -> Bearing {
    deep_groove(7, 2.778, 13.0, [0.529, 0.529], 5e-6, 219e9)
}

/// A light grease base oil that fills a twentieth of the free volume.
pub(crate) fn article_lubricant() -> Lubricant {
    Lubricant {
        kind: LubricantKind::Grease,
        viscosity: 0.02,
        pressure_viscosity: 2e-8,
        fill: 0.05,
        inlet_distance: None,
        traction: TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.05, at_slip: 1.0, limit: 0.036 },
    }
}

/// The article's crown cage of PA46 with the defaults of `docs/explanation/parameters.md`.
pub(crate) fn article_cage() -> CageParameters {
    CageParameters {
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
    }
}
