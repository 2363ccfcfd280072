//! The presets of the core as requests and answers have them.

use std::collections::BTreeMap;

use serde::Serialize;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
use utoipa::{PartialSchema, ToSchema};

use super::bearing::{BearingInput, BearingType};
use super::cage::{CageInput, FilmName, SeatName};
use super::filling::Filling;
use super::lubricant::{LubricantInput, TractionInput, TractionLawName};
use super::material::{MaterialInput, MaterialsInput};
use super::strict::NameOr;
use crate::physics::defaults::{BearingDefaults, CrownCage, DefaultFit, Dimensions};
use crate::physics::presets::{self, BearingPreset, LubricantPreset, MaterialPreset};

/// Types that stand for the names of presets in the API's description.
macro_rules! names {
    ($($description:literal $name:ident: $known:expr;)+) => {$(
        #[doc = $description]
        #[derive(Serialize)]
        pub struct $name;

        impl PartialSchema for $name {
            fn schema() -> RefOr<Schema> {
                let names = ObjectBuilder::new().schema_type(Type::String).enum_values(Some($known));
                names.description(Some($description)).into()
            }
        }

        impl ToSchema for $name {}
    )+};
}

names! {
    "Name of a bearing of `GET /v1/presets`." BearingName: presets::bearing_names();
    "Name of a material of `GET /v1/presets`." MaterialName: presets::MATERIALS.map(|material| material.name);
    "Name of a lubricant of `GET /v1/presets`." LubricantName: presets::LUBRICANTS.map(|lubricant| lubricant.name);
}

/// What fills the gaps of a bearing that a request describes.
pub struct BearingBase {
    /// A bearing whose fields are all given.
    pub bearing: BearingInput,
    pub spindle_mass_kg: f64,
    /// Name of a preset.
    pub lubricant: &'static str,
}

impl BearingBase {
    pub fn new(dimensions: &Dimensions, defaults: &BearingDefaults) -> Self {
        let (radial_clearance_um, contact_angle_deg) = match defaults.fit {
            DefaultFit::RadialClearanceUm(clearance) => (Some(clearance), None),
            DefaultFit::ContactAngleDeg(angle) => (None, Some(angle)),
        };
        let material = |material| Some(NameOr::Object(MaterialInput::from(material)));
        let bearing = BearingInput {
            preset: None,
            kind: Some(BearingType::from(defaults.kind)),
            outer_diameter_mm: Some(dimensions.outer_diameter_mm),
            inner_diameter_mm: Some(dimensions.inner_diameter_mm),
            width_mm: Some(dimensions.width_mm),
            ball_count: Some(dimensions.ball_count as u32),
            ball_diameter_mm: Some(dimensions.ball_diameter_mm),
            pitch_diameter_mm: Some(dimensions.pitch_diameter_mm),
            inner_groove_curvature: Some(defaults.groove_curvature.inner),
            outer_groove_curvature: Some(defaults.groove_curvature.outer),
            radial_clearance_um,
            contact_angle_deg,
            materials: Some(MaterialsInput {
                ball: material(defaults.ball_material),
                inner_raceway: material(defaults.raceway_material.inner),
                outer_raceway: material(defaults.raceway_material.outer),
                cage: material(defaults.cage.material),
            }),
            cage: Some(CageInput::from(defaults.cage)),
        };
        let lubricant = presets::lubricant_of(defaults.lubricant).name;
        Self { bearing, spindle_mass_kg: defaults.spindle_mass, lubricant }
    }
}

impl From<BearingPreset> for BearingBase {
    fn from(preset: BearingPreset) -> Self {
        Self::new(&preset.dimensions, &preset.defaults)
    }
}

impl From<CrownCage> for CageInput {
    fn from(cage: CrownCage) -> Self {
        Self {
            pocket_clearance_mm: Some(cage.pocket_clearance_mm),
            mass_g: Some(cage.mass_g),
            axial_inertia_kg_m2: Some(cage.axial_inertia_kg_m2),
            transverse_inertia_kg_m2: Some(cage.transverse_inertia_kg_m2),
            offset_mm: Some(cage.offset_mm),
            seat: Some(SeatName::from(cage.seat)),
            rim_angle_deg: Some(cage.rim_angle_deg),
            seat_half_width_mm: Some(cage.seat_half_width_mm),
            friction: Some(cage.friction),
            friction_speed_m_s: Some(cage.friction_speed_m_s),
            ..Self::default()
        }
    }
}

/// All presets by name, each with every default that it sets.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PresetsAnswer {
    /// Bearings by name.
    pub bearings: BTreeMap<String, BearingPresetAnswer>,
    /// Materials by name.
    pub materials: BTreeMap<String, MaterialPresetAnswer>,
    /// Lubricants by name.
    pub lubricants: BTreeMap<String, LubricantPresetAnswer>,
}

/// A bearing and the defaults that come with it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct BearingPresetAnswer {
    /// What it is, in words.
    pub description: String,
    /// Every field of the bearing.
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
    /// What it is, and where its values come from.
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
    /// What it is, in words.
    pub description: &'static str,
    /// Every field of the lubricant; the inlet distance follows from the ball.
    #[schema(value_type = LubricantInput)]
    pub lubricant: serde_json::Value,
}

/// The answer to `GET /v1/presets`.
pub fn presets_answer() -> PresetsAnswer {
    let bearings = presets::bearing_names().filter_map(presets::bearing);
    let materials = presets::MATERIALS.iter();
    let lubricants = presets::LUBRICANTS.iter();
    PresetsAnswer {
        bearings: bearings.map(|preset| (preset.name.to_owned(), bearing_answer(preset))).collect(),
        materials: materials.map(|preset| (preset.name.to_owned(), material_answer(preset))).collect(),
        lubricants: lubricants.map(|preset| (preset.name.to_owned(), lubricant_answer(preset))).collect(),
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
        bearing: super::given_fields(&base.bearing),
        spindle_mass_kg: base.spindle_mass_kg,
        lubricant: base.lubricant.to_owned(),
    }
}

fn material_answer(preset: &MaterialPreset) -> MaterialPresetAnswer {
    let MaterialInput { elastic_modulus_gpa, poisson_ratio, density_kg_m3 } = preset.material.into();
    MaterialPresetAnswer { description: preset.description, elastic_modulus_gpa, poisson_ratio, density_kg_m3 }
}

fn lubricant_answer(preset: &LubricantPreset) -> LubricantPresetAnswer {
    let lubricant = &preset.lubricant;
    let mut traction = TractionInput::default();
    traction.resolve(&mut Filling::default(), TractionLawName::from(lubricant.traction));
    let all = LubricantInput {
        kind: Some(lubricant.kind.into()),
        viscosity_pa_s: Some(lubricant.viscosity),
        pressure_viscosity_per_pa: Some(lubricant.pressure_viscosity),
        fill: Some(lubricant.fill),
        inlet_distance_mm: None,
        traction: Some(traction),
    };
    LubricantPresetAnswer { description: preset.description, lubricant: super::given_fields(&all) }
}
