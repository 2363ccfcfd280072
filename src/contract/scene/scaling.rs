//! Defaults of a bearing that is no preset, from its dimensions alone.

use crate::contract::json::numbers::significant;
use crate::contract::json::shapes::NameOr;
use crate::contract::scene::bearing::{BearingInput, BearingType};
use crate::contract::scene::cage::{CageInput, SeatName};
use crate::contract::scene::material::MaterialsInput;
use crate::contract::scene::presets::{self, BearingPreset};

/// The dimensions that defaults depend on [mm].
#[derive(Debug, Clone, Copy)]
pub struct Size {
    pub bore_mm: f64,
    pub ball_diameter_mm: f64,
    pub pitch_diameter_mm: f64,
}

/// Groove curvatures 0.52 and 0.53, a clearance in the middle of group N (15° for angular contact), balls
/// and raceways of GCr15, a PA46 crown cage, a solid steel spindle of the bore, grease.
pub fn defaults(size: Size, kind: BearingType) -> BearingPreset {
    let angular = kind == BearingType::AngularContact;
    let steel = || Some(NameOr::Name(presets::STEEL.to_owned()));
    BearingPreset {
        name: String::new(),
        description: String::new(),
        bearing: BearingInput {
            kind: Some(kind),
            inner_groove_curvature: Some(0.52),
            outer_groove_curvature: Some(0.53),
            radial_clearance_um: (!angular).then(|| middle_clearance_um(size.bore_mm)),
            contact_angle_deg: angular.then_some(15.0),
            materials: Some(MaterialsInput {
                ball: steel(),
                inner_raceway: steel(),
                outer_raceway: steel(),
                cage: Some(NameOr::Name(presets::POLYAMIDE.to_owned())),
            }),
            cage: Some(crown_cage(size)),
            ..BearingInput::default()
        },
        spindle_mass_kg: shaft_mass_kg(size.bore_mm),
        lubricant: "grease".to_owned(),
    }
}

/// The article's PA46 crown (0.13 g at D_m 13 mm and d 2.778 mm), scaled: mass as D_m d², the volume of a
/// ring as thick and as wide as the balls are; moments of inertia as mass times D_m²; offset, clearance
/// and seat as d.
pub fn crown_cage(size: Size) -> CageInput {
    let ball = size.ball_diameter_mm / 2.778;
    let pitch = size.pitch_diameter_mm / 13.0;
    let mass = pitch * ball * ball;
    let inertia = mass * pitch * pitch;
    let rounded = |value: f64| Some(significant(value, 4));
    CageInput {
        pocket_clearance_mm: rounded(0.051 * ball),
        mass_g: rounded(0.13 * mass),
        axial_inertia_kg_m2: rounded(5.5e-9 * inertia),
        transverse_inertia_kg_m2: rounded(3e-9 * inertia),
        offset_mm: rounded(0.7 * ball),
        seat: Some(SeatName::Open),
        rim_angle_deg: Some(65.0),
        seat_half_width_mm: rounded(ball),
        film: None,
        friction: Some(0.08),
        friction_speed_m_s: Some(0.05),
        bar_stiffness_n_per_m: None,
        land: None,
    }
}

/// Mass of a solid steel shaft of the bore, 7 bores long [kg].
pub fn shaft_mass_kg(bore_mm: f64) -> f64 {
    let bore = bore_mm / 1e3;
    significant(7830.0 * std::f64::consts::FRAC_PI_4 * bore * bore * 7.0 * bore, 4)
}

/// Middle of the radial internal clearance of group N of deep groove ball bearings by bore [µm] (ISO 5753-1).
fn middle_clearance_um(bore_mm: f64) -> f64 {
    /// (bore up to and including [mm], least, greatest [µm])
    const GROUP_N: [(f64, f64, f64); 26] = [
        (10.0, 2.0, 13.0),
        (18.0, 3.0, 18.0),
        (24.0, 5.0, 20.0),
        (30.0, 5.0, 20.0),
        (40.0, 6.0, 20.0),
        (50.0, 6.0, 23.0),
        (65.0, 8.0, 28.0),
        (80.0, 10.0, 30.0),
        (100.0, 12.0, 36.0),
        (120.0, 15.0, 41.0),
        (140.0, 18.0, 48.0),
        (160.0, 18.0, 53.0),
        (180.0, 20.0, 61.0),
        (200.0, 25.0, 71.0),
        (225.0, 25.0, 85.0),
        (250.0, 30.0, 95.0),
        (280.0, 35.0, 105.0),
        (315.0, 40.0, 115.0),
        (355.0, 45.0, 125.0),
        (400.0, 55.0, 145.0),
        (450.0, 60.0, 170.0),
        (500.0, 70.0, 190.0),
        (560.0, 80.0, 210.0),
        (630.0, 90.0, 230.0),
        (710.0, 110.0, 260.0),
        (f64::INFINITY, 120.0, 290.0),
    ];
    GROUP_N.iter().find(|row| bore_mm <= row.0).map_or(7.5, |row| 0.5 * (row.1 + row.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_article_scales_to_itself() {
        let cage = crown_cage(Size { bore_mm: 8.5, ball_diameter_mm: 2.778, pitch_diameter_mm: 13.0 });
        assert_eq!((cage.mass_g, cage.axial_inertia_kg_m2), (Some(0.13), Some(5.5e-9)));
        assert_eq!((cage.offset_mm, cage.pocket_clearance_mm), (Some(0.7), Some(0.051)));
    }

    #[test]
    fn clearance_is_the_middle_of_group_n() {
        assert_eq!([8.0, 10.0, 20.0, 25.0].map(middle_clearance_um), [7.5, 7.5, 12.5, 12.5]);
    }
}
