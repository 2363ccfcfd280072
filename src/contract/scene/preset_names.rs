//! Names of presets, for the schemas of fields that take one.

use raceway_core::physics::oil::grades;
use raceway_core::physics::presets;
use raceway_core::physics::seat::{HOUSING_CLASSES, SHAFT_CLASSES};
use serde::Serialize;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
use utoipa::{PartialSchema, ToSchema};

/// Types whose schemas list the names of presets.
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
    "Name of a material of `GET /v1/presets`." MaterialName: presets::MATERIALS.map(|material| material.name);
    "Name of a lubricant of `GET /v1/presets`." LubricantName: presets::LUBRICANTS.map(|lubricant| lubricant.name);
    "ISO viscosity grade: a mineral oil of viscosity index 95." ViscosityGradeName: grades().iter().map(|grade| grade.name);
    "Tolerance class of a shaft (ISO 286)." ShaftClassName: SHAFT_CLASSES;
    "Tolerance class of a housing (ISO 286)." HousingClassName: HOUSING_CLASSES;
    "Name of a quality of raceways of `GET /v1/presets`." SurfaceName: presets::SURFACES.map(|surface| surface.name);
}

/// Name of a bearing of `GET /v1/presets`, or a designation of `GET /v1/catalogue` with suffixes of seals, clearance, tolerance and hybrid
/// bearings, such as `6206-2RS/C3` or `7008C/HC`.
#[derive(Serialize, ToSchema)]
#[schema(value_type = String, examples("6205", "7008C", "6206-2RS/C3"))]
pub struct BearingName(pub String);
