//! Names of presets, for the schemas of fields that take one.

use raceway_core::physics::presets;
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
    "Name of a bearing of `GET /v1/presets`." BearingName: presets::bearing_names();
    "Name of a material of `GET /v1/presets`." MaterialName: presets::MATERIALS.map(|material| material.name);
    "Name of a lubricant of `GET /v1/presets`." LubricantName: presets::LUBRICANTS.map(|lubricant| lubricant.name);
    "Name of a quality of raceways of `GET /v1/presets`." SurfaceName: presets::SURFACES.map(|surface| surface.name);
}
