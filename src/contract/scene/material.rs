//! Materials of balls, raceways and cage.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::preset_names::MaterialName;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::listed;
use crate::contract::json::shapes::NameOr;
use crate::contract::json::units::GPA;
use raceway_core::physics::material::{GCR15, Material};
use raceway_core::physics::presets::{self, MATERIALS};

/// An elastic isotropic material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialInput {
    /// Young's modulus [GPa].
    #[schema(example = 219.0)]
    pub elastic_modulus_gpa: f64,
    /// Poisson's ratio [-].
    #[schema(example = 0.3)]
    pub poisson_ratio: f64,
    /// Density [kg/m³].
    #[schema(example = 7830.0)]
    pub density_kg_m3: f64,
}

/// Name of a preset of `GET /v1/presets`, or a material with its constants.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum MaterialChoice {
    /// Name of a preset.
    Name(MaterialName),
    Fields(MaterialInput),
}

/// Materials of a bearing, each a preset name or its constants. Default: that of the bearing's
/// preset; `gcr15` and a cage of `pa46` for a bearing without one.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialsInput {
    /// Material of the balls.
    #[schema(nullable = false, value_type = Option<MaterialChoice>)]
    pub ball: Option<NameOr<String, MaterialInput>>,
    /// Material of the inner raceway.
    #[schema(nullable = false, value_type = Option<MaterialChoice>)]
    pub inner_raceway: Option<NameOr<String, MaterialInput>>,
    /// Material of the outer raceway.
    #[schema(nullable = false, value_type = Option<MaterialChoice>)]
    pub outer_raceway: Option<NameOr<String, MaterialInput>>,
    /// Material of the cage.
    #[schema(nullable = false, value_type = Option<MaterialChoice>)]
    pub cage: Option<NameOr<String, MaterialInput>>,
}

/// Materials in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Materials {
    pub ball: Material,
    pub inner_raceway: Material,
    pub outer_raceway: Material,
    pub cage: Material,
}

impl From<Material> for MaterialInput {
    fn from(material: Material) -> Self {
        Self {
            elastic_modulus_gpa: GPA.to_user(material.elastic_modulus),
            poisson_ratio: material.poisson_ratio,
            density_kg_m3: material.density,
        }
    }
}

impl MaterialsInput {
    /// The materials of `physics`; fills in the defaults of `base`, and replaces names by constants.
    pub fn resolve(&mut self, defaults: &mut Defaults, base: &MaterialsInput) -> Materials {
        let mut one = |part: &str, field: &mut Option<NameOr<String, MaterialInput>>, default| {
            material(defaults, format!("/scene/bearing/materials/{part}"), field, default)
        };
        Materials {
            ball: one("ball", &mut self.ball, &base.ball),
            inner_raceway: one("inner_raceway", &mut self.inner_raceway, &base.inner_raceway),
            outer_raceway: one("outer_raceway", &mut self.outer_raceway, &base.outer_raceway),
            cage: one("cage", &mut self.cage, &base.cage),
        }
    }
}

/// A material in SI; replaces a name by its constants.
pub(super) fn material(
    defaults: &mut Defaults,
    pointer: String,
    field: &mut Option<NameOr<String, MaterialInput>>,
    default: &Option<NameOr<String, MaterialInput>>,
) -> Material {
    let default = default.clone().unwrap_or_else(|| NameOr::Object(GCR15.into()));
    let constants = match defaults.fill(pointer.clone(), field, default) {
        NameOr::Object(constants) => constants,
        NameOr::Name(name) => presets::material(&name).map_or_else(
            || {
                let known = listed(MATERIALS.iter().map(|preset| preset.name));
                defaults.refuse(pointer, format!("unknown material `{name}`; known are {known}"));
                GCR15.into()
            },
            MaterialInput::from,
        ),
    };
    *field = Some(NameOr::Object(constants));
    Material {
        elastic_modulus: GPA.to_si(constants.elastic_modulus_gpa),
        poisson_ratio: constants.poisson_ratio,
        density: constants.density_kg_m3,
    }
}
