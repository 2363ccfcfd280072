//! The presets of `physics` as a response.

use std::collections::BTreeMap;

use raceway_core::physics::presets::{self, BearingPreset, LubricantPreset, MaterialPreset, SurfacePreset};
use serde::Serialize;
use utoipa::ToSchema;

use super::bearing::BearingInput;
use super::bearing_base::BearingBase;
use super::cage::FilmName;
use super::lubricant::{LubricantInput, TractionInput, TractionLawName};
use super::material::MaterialInput;
use super::surfaces::RandomWavinessInput;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::shapes::NameOr;

/// All presets by name, each with all defaults that it sets.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PresetsAnswer {
    /// Bearings by name.
    pub bearings: BTreeMap<String, BearingPresetAnswer>,
    /// Materials by name.
    pub materials: BTreeMap<String, MaterialPresetAnswer>,
    /// Lubricants by name.
    pub lubricants: BTreeMap<String, LubricantPresetAnswer>,
    /// Surfaces of both raceways by name.
    pub surfaces: BTreeMap<String, SurfacePresetAnswer>,
}

/// A bearing and its defaults.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct BearingPresetAnswer {
    /// Description.
    pub description: String,
    /// All fields of the bearing.
    #[schema(value_type = BearingInput)]
    pub bearing: serde_json::Value,
    /// Default mass of the spindle [kg].
    #[schema(minimum = 0)]
    pub spindle_mass_kg: f64,
    /// Name of the default lubricant.
    pub lubricant: String,
}

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MaterialPresetAnswer {
    /// Description, with the source of the values.
    pub description: &'static str,
    /// Young's modulus [GPa].
    #[schema(minimum = 0)]
    pub elastic_modulus_gpa: f64,
    /// Poisson's ratio [-].
    #[schema(minimum = 0, maximum = 0.5)]
    pub poisson_ratio: f64,
    /// Density [kg/m³].
    #[schema(minimum = 0)]
    pub density_kg_m3: f64,
}

/// A lubricant.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LubricantPresetAnswer {
    /// Description.
    pub description: &'static str,
    /// All fields of the lubricant; the inlet distance follows from the ball diameter.
    #[schema(value_type = LubricantInput)]
    pub lubricant: serde_json::Value,
}

/// Surfaces of both raceways.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SurfacePresetAnswer {
    /// Description, with the source of the values.
    pub description: &'static str,
    /// Random waviness of each raceway that gives none itself.
    #[schema(value_type = RandomWavinessInput)]
    pub random_waviness: serde_json::Value,
}

/// The response of `GET /v1/presets`.
pub fn presets_answer() -> PresetsAnswer {
    let bearings = presets::bearing_names().filter_map(presets::bearing);
    let materials = presets::MATERIALS.iter();
    let lubricants = presets::LUBRICANTS.iter();
    PresetsAnswer {
        bearings: bearings.map(|preset| (preset.name.to_owned(), bearing_answer(preset))).collect(),
        materials: materials.map(|preset| (preset.name.to_owned(), material_answer(preset))).collect(),
        lubricants: lubricants.map(|preset| (preset.name.to_owned(), lubricant_answer(preset))).collect(),
        surfaces: presets::SURFACES.iter().map(|preset| (preset.name.to_owned(), surface_answer(preset))).collect(),
    }
}

fn bearing_answer(preset: BearingPreset) -> BearingPresetAnswer {
    let description = preset.description.clone();
    let mut base = BearingBase::from(preset);
    if let Some(cage) = &mut base.bearing.cage {
        cage.film = Some(NameOr::Name(FilmName::Wedge));
    }
    BearingPresetAnswer {
        description,
        bearing: given_fields(&base.bearing),
        spindle_mass_kg: base.spindle_mass_kg,
        lubricant: base.lubricant.to_owned(),
    }
}

fn material_answer(preset: &MaterialPreset) -> MaterialPresetAnswer {
    let MaterialInput { elastic_modulus_gpa, poisson_ratio, density_kg_m3 } = preset.material.into();
    MaterialPresetAnswer { description: preset.description, elastic_modulus_gpa, poisson_ratio, density_kg_m3 }
}

fn surface_answer(preset: &SurfacePreset) -> SurfacePresetAnswer {
    let mut random = RandomWavinessInput::of(preset);
    random.fill("", &mut Defaults::default());
    SurfacePresetAnswer { description: preset.description, random_waviness: given_fields(&random) }
}

fn lubricant_answer(preset: &LubricantPreset) -> LubricantPresetAnswer {
    let lubricant = &preset.lubricant;
    let mut traction = TractionInput::default();
    traction.resolve(&mut Defaults::default(), TractionLawName::from(lubricant.traction));
    let all = LubricantInput {
        kind: Some(lubricant.kind.into()),
        viscosity_pa_s: Some(lubricant.viscosity),
        pressure_viscosity_per_pa: Some(lubricant.pressure_viscosity),
        fill: Some(lubricant.fill),
        traction: Some(traction),
        ..LubricantInput::default()
    };
    LubricantPresetAnswer { description: preset.description, lubricant: given_fields(&all) }
}
