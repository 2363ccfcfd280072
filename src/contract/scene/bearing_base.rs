//! The preset or the defaults behind a requested bearing.

use raceway_core::physics::defaults::{BearingDefaults, DefaultFit, Dimensions};
use raceway_core::physics::designation::{Designation, Suffix, UnknownDesignation};
use raceway_core::physics::presets::{self, BearingPreset};

use super::bearing::{BearingInput, BearingType};
use super::cage::CageInput;
use super::material::{MaterialInput, MaterialsInput};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::NameOr;

/// The requested bearing, and the base that fills its empty fields.
pub struct ChosenBearing {
    pub own: BearingInput,
    pub base: BearingBase,
    /// That of its name.
    pub designation: Option<Designation>,
}

/// The requested bearing with the named preset, or with the defaults for its dimensions. After an error another bearing replaces it, so that
/// the other fields can still be checked.
pub fn choose(bearing: NameOr<String, BearingInput>, defaults: &mut Defaults) -> ChosenBearing {
    let (name, pointer, own) = match bearing {
        NameOr::Name(name) => (Some(name), "/scene/bearing", BearingInput::default()),
        NameOr::Object(mut own) => (own.preset.take(), "/scene/bearing/preset", own),
    };
    let mut designation = None;
    let base = match name {
        Some(name) => match presets::named(&name) {
            Ok(named) => {
                designation = named.designation;
                Some(BearingBase::from(named.preset))
            }
            Err(unknown) => {
                defaults.refuse(pointer, refusal(&name, unknown));
                None
            }
        },
        None if defaults.is_unread("/scene/bearing/preset") => None,
        None => {
            let kind = own.kind.unwrap_or(BearingType::DeepGroove).in_physics();
            dimensions(&own, defaults).map(|size| BearingBase::new(&size, &BearingDefaults::new(kind, &size)))
        }
    };
    let base = base.unwrap_or_else(|| {
        defaults.substitute();
        presets::article_integrated().into()
    });
    ChosenBearing { own, base, designation }
}

/// Why a name is no bearing, with the names that may be meant.
fn refusal(name: &str, unknown: UnknownDesignation) -> String {
    match unknown {
        UnknownDesignation::Bearing { similar } => {
            let known = listed(presets::bearing_names());
            let also = match similar.is_empty() {
                true => "the designations of GET /v1/catalogue are known, too".to_owned(),
                false => format!("similar designations of GET /v1/catalogue are {}", listed(similar)),
            };
            format!("unknown bearing `{name}`; known are {known}; {also}")
        }
        UnknownDesignation::Suffix { bearing, rest } => {
            format!(
                "unknown suffix `{rest}` of {bearing}; the catalogue has `{bearing}`, and knows {}",
                listed(Suffix::all())
            )
        }
        UnknownDesignation::Arrangement { bearing, arrangement } => format!(
            "`{name}`: {arrangement} is a pair of {bearing}; give `kind` `machine` with both in `bearings`; `faces` makes the arrangement"
        ),
        UnknownDesignation::TwoGroups { bearing } => format!("`{name}`: {bearing} with two clearance groups"),
    }
}

/// Dimensions of a bearing without a preset; `None` after an error for each missing one.
fn dimensions(bearing: &BearingInput, defaults: &mut Defaults) -> Option<Dimensions> {
    let known_errors = defaults.errors.len();
    let mut number = |name: &str, field| defaults.require(format!("/scene/bearing/{name}"), field, f64::NAN);
    let size = Dimensions {
        inner_diameter_mm: number("inner_diameter_mm", &bearing.inner_diameter_mm),
        ball_diameter_mm: number("ball_diameter_mm", &bearing.ball_diameter_mm),
        pitch_diameter_mm: number("pitch_diameter_mm", &bearing.pitch_diameter_mm),
        outer_diameter_mm: number("outer_diameter_mm", &bearing.outer_diameter_mm),
        width_mm: number("width_mm", &bearing.width_mm),
        ball_count: defaults.require("/scene/bearing/ball_count", &bearing.ball_count, 0) as usize,
    };
    (defaults.errors.len() == known_errors).then_some(size)
}

/// Values for the empty fields of a requested bearing.
pub struct BearingBase {
    /// A bearing with all fields given.
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
            ..BearingInput::default()
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
