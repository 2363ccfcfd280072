//! Bearings, materials and lubricants by name.

use std::collections::BTreeMap;

use serde::Serialize;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
use utoipa::{PartialSchema, ToSchema};

use crate::contract::json::defaults::Defaults;
use crate::contract::json::given_fields::given_fields;
use crate::contract::json::shapes::NameOr;
use crate::contract::scene::bearing::{BearingInput, BearingType};
use crate::contract::scene::cage::{CageInput, FilmName};
use crate::contract::scene::lubricant::{LubricantInput, LubricantKindName, TractionInput, TractionLawName};
use crate::contract::scene::material::{MaterialInput, MaterialsInput};
use crate::contract::scene::scaling::{self, Size};

/// The usual materials of balls and raceways, and of cages.
pub const STEEL: &str = "gcr15";
pub const POLYAMIDE: &str = "pa46";

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
    "Name of a bearing of `GET /v1/presets`." BearingName: bearing_names();
    "Name of a material of `GET /v1/presets`." MaterialName: MATERIALS.map(|material| material.0);
    "Name of a lubricant of `GET /v1/presets`." LubricantName: LUBRICANTS.map(|lubricant| lubricant.name);
}

const fn solid(elastic_modulus_gpa: f64, poisson_ratio: f64, density_kg_m3: f64) -> MaterialInput {
    MaterialInput { elastic_modulus_gpa, poisson_ratio, density_kg_m3 }
}

/// Name, where the values come from, values.
pub const MATERIALS: [(&str, &str, MaterialInput); 4] = [
    (STEEL, "bearing steel GCr15; the article's Table 2", solid(219.0, 0.3, 7830.0)),
    (POLYAMIDE, "polyamide 46; the article's Table 3", solid(1.0, 0.39, 1100.0)),
    ("aisi-52100", "bearing steel 100Cr6; usual data-sheet values", solid(210.0, 0.3, 7810.0)),
    ("si3n4", "silicon nitride of hybrid bearings; usual data-sheet values", solid(310.0, 0.26, 3240.0)),
];

/// A lubricant by name.
pub struct LubricantPreset {
    pub name: &'static str,
    pub description: &'static str,
    kind: LubricantKindName,
    pub viscosity_pa_s: f64,
    pub pressure_viscosity_per_pa: f64,
    pub fill: f64,
    pub law: TractionLawName,
}

const fn fluid(
    name: &'static str,
    description: &'static str,
    kind: LubricantKindName,
    viscosity_pa_s: f64,
    pressure_viscosity_per_pa: f64,
    fill: f64,
    law: TractionLawName,
) -> LubricantPreset {
    LubricantPreset { name, description, kind, viscosity_pa_s, pressure_viscosity_per_pa, fill, law }
}

pub const LUBRICANTS: [LubricantPreset; 3] = [
    fluid(
        "grease",
        "light grease, base oil at about 70 °C, channelled; hydrodynamic forces left out by convention",
        LubricantKindName::Grease,
        0.02,
        2e-8,
        0.05,
        TractionLawName::FourParameter,
    ),
    fluid(
        "oil",
        "light mineral oil (about ISO VG 32 at 60 °C), a small sump",
        LubricantKindName::Oil,
        0.013,
        1.8e-8,
        0.1,
        TractionLawName::FourParameter,
    ),
    fluid(
        "dry",
        "no lubricant: no film, friction by Coulomb's law, no pocket film",
        LubricantKindName::Dry,
        0.0,
        0.0,
        0.0,
        TractionLawName::Coulomb,
    ),
];

/// A bearing with all that its name sets.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingPreset {
    pub name: String,
    pub description: String,
    pub bearing: BearingInput,
    pub spindle_mass_kg: f64,
    pub lubricant: String,
}

/// Names of all bearings.
pub fn bearing_names() -> impl Iterator<Item = &'static str> {
    ["article-integrated", "article-deep-groove", "608", "6203", "6204", "6205", "6206", "6208", "6210"].into_iter()
}

/// The bearing of that name.
pub fn bearing(name: &str) -> Option<BearingPreset> {
    let preset = match name {
        "article-integrated" => integrated(),
        "article-deep-groove" => article(
            "deep-groove bearing the article compares with (Table 4), otherwise as the integrated one",
            (BearingType::DeepGroove, 20.0, 8.0, 6.3),
            (2.38, 14.0),
        ),
        "608" => catalogue("8 × 22 × 7 mm", (22.0, 8.0, 7.0), 7, (3.969, 15.0)),
        "6203" => catalogue("17 × 40 × 12 mm", (40.0, 17.0, 12.0), 8, (6.746, 28.5)),
        "6204" => catalogue("20 × 47 × 14 mm", (47.0, 20.0, 14.0), 8, (7.938, 33.5)),
        // 0.3126 in and 1.537 in, as in the published fault orders of the 6205-2RS
        "6205" => catalogue("25 × 52 × 15 mm", (52.0, 25.0, 15.0), 9, (7.94004, 39.0398)),
        "6206" => catalogue("30 × 62 × 16 mm", (62.0, 30.0, 16.0), 9, (9.525, 46.0)),
        "6208" => catalogue("40 × 80 × 18 mm", (80.0, 40.0, 18.0), 9, (11.906, 60.0)),
        "6210" => catalogue("50 × 90 × 20 mm", (90.0, 50.0, 20.0), 10, (12.7, 70.0)),
        _ => return None,
    };
    Some(BearingPreset { name: name.to_owned(), ..preset })
}

/// The article's own bearing.
pub fn integrated() -> BearingPreset {
    article(
        "integrated bearing of the article (Table 1) with this program's choices for what it leaves open",
        (BearingType::Integrated, 18.0, 8.5, 5.9),
        (2.778, 13.0),
    )
}

/// A bearing of the article: (type, D, bore, B), (d, D_m) in mm.
fn article(description: &str, outside: (BearingType, f64, f64, f64), inside: (f64, f64)) -> BearingPreset {
    let (kind, outer, bore, width) = outside;
    let size = Size { bore_mm: bore, ball_diameter_mm: inside.0, pitch_diameter_mm: inside.1 };
    let mut preset = scaling::defaults(size, kind);
    let own = &mut preset.bearing;
    set_dimensions(own, (outer, bore, width), 7, inside);
    own.inner_groove_curvature = Some(0.529);
    own.outer_groove_curvature = Some(0.529);
    own.radial_clearance_um = Some(5.0);
    own.cage = Some(CageInput {
        pocket_clearance_mm: Some(0.051),
        mass_g: Some(0.13),
        axial_inertia_kg_m2: Some(5.5e-9),
        transverse_inertia_kg_m2: Some(3e-9),
        offset_mm: Some(0.7),
        seat_half_width_mm: Some(1.0),
        ..scaling::crown_cage(size)
    });
    BearingPreset { description: description.to_owned(), spindle_mass_kg: 0.05, ..preset }
}

/// A catalogue bearing: (D, bore, B), Z, (d, D_m) in mm.
fn catalogue(size: &str, outside: (f64, f64, f64), balls: u32, inside: (f64, f64)) -> BearingPreset {
    let dimensions = Size { bore_mm: outside.1, ball_diameter_mm: inside.0, pitch_diameter_mm: inside.1 };
    let mut preset = scaling::defaults(dimensions, BearingType::DeepGroove);
    set_dimensions(&mut preset.bearing, outside, balls, inside);
    BearingPreset {
        description: format!("deep-groove ball bearing, {size}, clearance in the middle of group N"),
        ..preset
    }
}

fn set_dimensions(bearing: &mut BearingInput, outside: (f64, f64, f64), balls: u32, inside: (f64, f64)) {
    bearing.outer_diameter_mm = Some(outside.0);
    bearing.inner_diameter_mm = Some(outside.1);
    bearing.width_mm = Some(outside.2);
    bearing.ball_count = Some(balls);
    bearing.ball_diameter_mm = Some(inside.0);
    bearing.pitch_diameter_mm = Some(inside.1);
}

/// The material of that name.
pub fn material(name: &str) -> Option<MaterialInput> {
    MATERIALS.iter().find(|material| material.0 == name).map(|material| material.2)
}

/// The lubricant of that name, its kind alone given.
pub fn lubricant(name: &str) -> Option<LubricantInput> {
    let preset = LUBRICANTS.iter().find(|preset| preset.name == name)?;
    Some(LubricantInput { kind: Some(preset.kind), ..LubricantInput::default() })
}

/// The lubricant whose values are the defaults of a kind.
pub fn lubricant_of(kind: LubricantKindName) -> &'static LubricantPreset {
    LUBRICANTS.iter().find(|preset| preset.kind == kind).unwrap_or(&LUBRICANTS[0])
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
    let bearings = bearing_names().filter_map(|name| Some((name.to_owned(), bearing_answer(bearing(name)?)))).collect();
    let materials = MATERIALS.iter().map(|&(name, description, of)| {
        let MaterialInput { elastic_modulus_gpa, poisson_ratio, density_kg_m3 } = of;
        (name.to_owned(), MaterialPresetAnswer { description, elastic_modulus_gpa, poisson_ratio, density_kg_m3 })
    });
    let lubricants = LUBRICANTS.iter().map(|preset| (preset.name.to_owned(), lubricant_answer(preset)));
    PresetsAnswer { bearings, materials: materials.collect(), lubricants: lubricants.collect() }
}

fn bearing_answer(mut preset: BearingPreset) -> BearingPresetAnswer {
    let materials = preset.bearing.materials.get_or_insert_default();
    materials.resolve(&mut Defaults::default(), &MaterialsInput::default());
    if let Some(cage) = &mut preset.bearing.cage {
        cage.film = Some(NameOr::Name(FilmName::Wedge));
    }
    BearingPresetAnswer {
        description: preset.description,
        bearing: given_fields(&preset.bearing),
        spindle_mass_kg: preset.spindle_mass_kg,
        lubricant: preset.lubricant,
    }
}

fn lubricant_answer(preset: &LubricantPreset) -> LubricantPresetAnswer {
    let mut traction = TractionInput::default();
    traction.resolve(&mut Defaults::default(), preset.law);
    let all = LubricantInput {
        kind: Some(preset.kind),
        viscosity_pa_s: Some(preset.viscosity_pa_s),
        pressure_viscosity_per_pa: Some(preset.pressure_viscosity_per_pa),
        fill: Some(preset.fill),
        inlet_distance_mm: None,
        traction: Some(traction),
    };
    LubricantPresetAnswer { description: preset.description, lubricant: given_fields(&all) }
}
