//! Bearings, materials, lubricants and surfaces by name.

use super::bearing::{BearingKind, PerRaceway};
use super::catalogue::CatalogueBearing;
use super::contact::traction::TractionLaw;
use super::defaults::{BearingDefaults, COULOMB, CrownCage, DefaultFit, Dimensions, FOUR_PARAMETER};
use super::designation::{Designation, UnknownDesignation};
use super::lubricant::{Lubricant, LubricantKind};
use super::material::{GCR15, Material, PA46};

/// A bearing with everything that its name sets.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingPreset {
    pub name: &'static str,
    pub description: String,
    pub dimensions: Dimensions,
    pub defaults: BearingDefaults,
}

/// A material with the source of its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialPreset {
    pub name: &'static str,
    pub description: &'static str,
    pub material: Material,
}

/// A lubricant whose name is that of its kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LubricantPreset {
    pub name: &'static str,
    pub description: &'static str,
    pub lubricant: Lubricant,
}

/// A quality of raceways: amplitude of the random waviness at order 10, falling as 1/order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePreset {
    pub name: &'static str,
    pub description: &'static str,
    /// [m]
    pub amplitude: f64,
}

/// The bearing of that name.
pub fn bearing(name: &str) -> Option<BearingPreset> {
    of_article(name).or_else(|| CATALOGUE.iter().find(|bearing| bearing.0 == name).map(catalogue_preset))
}

fn of_article(name: &str) -> Option<BearingPreset> {
    ARTICLE.iter().find(|bearing| bearing.0 == name).map(article_preset)
}

/// A bearing by a preset's name or by its designation.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedBearing {
    pub preset: BearingPreset,
    /// `None` for names that are no designation.
    pub designation: Option<Designation>,
}

/// The bearing of a preset's name, or of a designation. A preset keeps its own numbers, also with suffixes.
pub fn named(name: &str) -> Result<NamedBearing, UnknownDesignation> {
    // The names of the article's bearings are no designations.
    if let Some(preset) = of_article(name) {
        return Ok(NamedBearing { preset, designation: None });
    }
    match (bearing(name), Designation::read(name)) {
        (Some(preset), designation) => Ok(NamedBearing { preset, designation: designation.ok() }),
        (None, Ok(designation)) => {
            let of_catalogue = designation.bearing;
            let mut preset = bearing(of_catalogue.designation).unwrap_or_else(|| of_designation(of_catalogue));
            if designation.is_hybrid() {
                preset.defaults.ball_material = SILICON_NITRIDE;
            }
            Ok(NamedBearing { preset, designation: Some(designation) })
        }
        (None, Err(unknown)) => Err(unknown),
    }
}

/// The bearing of the catalogue with the defaults for its dimensions.
fn of_designation(bearing: &CatalogueBearing) -> BearingPreset {
    let Dimensions { outer_diameter_mm: outer, inner_diameter_mm: bore, width_mm: width, .. } = bearing.dimensions;
    let kind = match bearing.kind {
        BearingKind::AngularContact => "angular-contact",
        BearingKind::DeepGroove | BearingKind::Integrated => "deep-groove",
    };
    BearingPreset {
        name: bearing.designation,
        description: format!("{kind} ball bearing, {bore} × {outer} × {width} mm"),
        dimensions: bearing.dimensions,
        defaults: bearing.defaults(),
    }
}

/// The article's integrated bearing.
pub fn article_integrated() -> BearingPreset {
    article_preset(&ARTICLE[0])
}

/// Names of all bearings.
pub fn bearing_names() -> impl Iterator<Item = &'static str> {
    ARTICLE.iter().map(|bearing| bearing.0).chain(CATALOGUE.iter().map(|bearing| bearing.0))
}

/// The material of that name.
pub fn material(name: &str) -> Option<Material> {
    MATERIALS.iter().find(|preset| preset.name == name).map(|preset| preset.material)
}

/// The lubricant of that name.
pub fn lubricant(name: &str) -> Option<Lubricant> {
    LUBRICANTS.iter().find(|preset| preset.name == name).map(|preset| preset.lubricant)
}

/// The lubricant whose values are the defaults of a kind.
pub fn lubricant_of(kind: LubricantKind) -> &'static LubricantPreset {
    LUBRICANTS.iter().find(|preset| preset.lubricant.kind == kind).unwrap_or(&LUBRICANTS[0])
}

/// The surfaces of that name.
pub fn surface(name: &str) -> Option<&'static SurfacePreset> {
    SURFACES.iter().find(|preset| preset.name == name)
}

/// Surfaces, the smoothest first. No standard limits the waviness of raceways by order. That amplitudes fall by a power of the order is
/// measured: J. Manuf. Mater. Process. 2025, 9(7), 220, on 17 ground rings. The amplitudes are assumptions, a factor of five apart within
/// the usual 1 to 100 nm.
pub const SURFACES: [SurfacePreset; 3] = [
    SurfacePreset {
        name: "precision",
        description: "1 nm at order 10, falling as 1/order, on both raceways; the amplitude is an assumption",
        amplitude: 1e-9,
    },
    SurfacePreset {
        name: "standard",
        description: "5 nm at order 10, falling as 1/order, on both raceways; the amplitude is an assumption",
        amplitude: 5e-9,
    },
    SurfacePreset {
        name: "worn",
        description: "25 nm at order 10, falling as 1/order, on both raceways; the amplitude is an assumption",
        amplitude: 25e-9,
    },
];

const SILICON_NITRIDE: Material = Material { elastic_modulus: 310e9, poisson_ratio: 0.26, density: 3240.0 };

/// Materials, the usual one of balls and raceways first.
pub const MATERIALS: [MaterialPreset; 4] = [
    MaterialPreset { name: "gcr15", description: "bearing steel GCr15; the article's Table 2", material: GCR15 },
    MaterialPreset { name: "pa46", description: "polyamide 46; the article's Table 3", material: PA46 },
    MaterialPreset {
        name: "aisi-52100",
        description: "bearing steel 100Cr6; usual data-sheet values",
        material: Material { elastic_modulus: 210e9, poisson_ratio: 0.3, density: 7810.0 },
    },
    MaterialPreset {
        name: "si3n4",
        description: "silicon nitride of hybrid bearings; usual data-sheet values",
        material: SILICON_NITRIDE,
    },
];

/// Lubricants, one a kind.
pub const LUBRICANTS: [LubricantPreset; 3] = [
    LubricantPreset {
        name: "grease",
        description: "light grease, base oil at about 70 °C, channelled; hydrodynamic forces left out by convention",
        lubricant: fluid(LubricantKind::Grease, 0.02, 2e-8, 0.05, FOUR_PARAMETER),
    },
    LubricantPreset {
        name: "oil",
        description: "light mineral oil (about ISO VG 32 at 60 °C), a small sump",
        lubricant: fluid(LubricantKind::Oil, 0.013, 1.8e-8, 0.1, FOUR_PARAMETER),
    },
    LubricantPreset {
        name: "dry",
        description: "no lubricant: no film, friction by Coulomb's law, no pocket film",
        lubricant: fluid(LubricantKind::Dry, 0.0, 0.0, 0.0, COULOMB),
    },
];

const fn fluid(
    kind: LubricantKind,
    viscosity: f64,
    pressure_viscosity: f64,
    fill: f64,
    traction: TractionLaw,
) -> Lubricant {
    Lubricant { kind, viscosity, pressure_viscosity, fill, inlet_distance: None, traction }
}

/// Name, description, kind and dimensions of the bearings of Zhi et al., Appl. Sci. 2025, 15(1), 98.
const ARTICLE: [(&str, &str, BearingKind, Dimensions); 2] = [
    (
        "article-integrated",
        "integrated bearing of the article (Table 1) with this program's choices for what it leaves open",
        BearingKind::Integrated,
        dimensions([18.0, 8.5, 5.9], 7, [2.778, 13.0]),
    ),
    (
        "article-deep-groove",
        "deep-groove bearing the article compares with (Table 4), otherwise as the integrated one",
        BearingKind::DeepGroove,
        dimensions([20.0, 8.0, 6.3], 7, [2.38, 14.0]),
    ),
];

/// Name and dimensions of deep-groove bearings of catalogues; balls and pitch circles are those of tables for vibration analysis.
const CATALOGUE: [(&str, Dimensions); 7] = [
    ("608", dimensions([22.0, 8.0, 7.0], 7, [3.969, 15.0])),
    ("6203", dimensions([40.0, 17.0, 12.0], 8, [6.746, 28.5])),
    ("6204", dimensions([47.0, 20.0, 14.0], 8, [7.938, 33.5])),
    // 0.3126 in and 1.537 in, as in the published fault orders of the 6205-2RS
    ("6205", dimensions([52.0, 25.0, 15.0], 9, [7.94004, 39.0398])),
    ("6206", dimensions([62.0, 30.0, 16.0], 9, [9.525, 46.0])),
    ("6208", dimensions([80.0, 40.0, 18.0], 9, [11.906, 60.0])),
    ("6210", dimensions([90.0, 50.0, 20.0], 10, [12.7, 70.0])),
];

/// (D, bore, B), Z, (d, D_m), lengths in mm.
const fn dimensions(outside: [f64; 3], ball_count: usize, balls: [f64; 2]) -> Dimensions {
    Dimensions {
        outer_diameter_mm: outside[0],
        inner_diameter_mm: outside[1],
        width_mm: outside[2],
        ball_count,
        ball_diameter_mm: balls[0],
        pitch_diameter_mm: balls[1],
    }
}

/// The article prints dimensions, curvature, materials and pocket clearance; the rest is a choice of this program.
fn article_preset(
    &(name, description, kind, dimensions): &(&'static str, &str, BearingKind, Dimensions),
) -> BearingPreset {
    let defaults = BearingDefaults::new(kind, &dimensions);
    BearingPreset {
        name,
        description: description.to_owned(),
        dimensions,
        defaults: BearingDefaults {
            groove_curvature: PerRaceway { inner: 0.529, outer: 0.529 },
            fit: DefaultFit::RadialClearanceUm(5.0),
            cage: CrownCage {
                pocket_clearance_mm: 0.051,
                mass_g: 0.13,
                axial_inertia_kg_m2: 5.5e-9,
                transverse_inertia_kg_m2: 3e-9,
                offset_mm: 0.7,
                seat_half_width_mm: 1.0,
                ..defaults.cage
            },
            spindle_mass: 0.05,
            ..defaults
        },
    }
}

fn catalogue_preset(&(name, dimensions): &(&'static str, Dimensions)) -> BearingPreset {
    let Dimensions { outer_diameter_mm: outer, inner_diameter_mm: bore, width_mm: width, .. } = dimensions;
    BearingPreset {
        name,
        description: format!(
            "deep-groove ball bearing, {bore} × {outer} × {width} mm, clearance in the middle of group N"
        ),
        dimensions,
        defaults: BearingDefaults::new(BearingKind::DeepGroove, &dimensions),
    }
}
