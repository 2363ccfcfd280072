//! Inputs of the rating life, which the motion does not need.

use raceway_core::physics::life::ratings::MakersRatings;
use raceway_core::simulation::model::rating_life::{LifeInput, ROUGHNESS};

use super::bearing::BearingInput;
use super::oil::OilAtTemperature;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::units::UM;

/// The inputs in SI; an empty field stays empty, because no motion depends on it.
pub fn life_input(
    bearing: &BearingInput,
    contamination: Option<f64>,
    oil: Option<&OilAtTemperature>,
    defaults: &mut Defaults,
) -> LifeInput {
    for (name, value) in [
        ("bearing/dynamic_load_rating_n", bearing.dynamic_load_rating_n),
        ("bearing/static_load_rating_n", bearing.static_load_rating_n),
        ("bearing/f0", bearing.f0),
        ("bearing/fatigue_load_limit_n", bearing.fatigue_load_limit_n),
        ("bearing/raceway_roughness_um", bearing.raceway_roughness_um),
        ("bearing/ball_roughness_um", bearing.ball_roughness_um),
        ("contamination_factor", contamination),
    ] {
        if let Some(value) = value {
            defaults.check(&format!("/scene/{name}"), value);
        }
    }
    LifeInput {
        makers: MakersRatings {
            dynamic: bearing.dynamic_load_rating_n,
            statical: bearing.static_load_rating_n,
            static_factor: bearing.f0,
        },
        fatigue_limit: bearing.fatigue_load_limit_n,
        contamination,
        kinematic_viscosity: oil.map(|oil| oil.kinematic_viscosity),
        raceway_roughness: bearing.raceway_roughness_um.map_or(ROUGHNESS, |roughness| UM.to_si(roughness)),
        ball_roughness: bearing.ball_roughness_um.map_or(ROUGHNESS, |roughness| UM.to_si(roughness)),
    }
}
