//! A scene: what to simulate.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bearing::{self, BearingChoice, BearingInput};
use super::damping::DampingInput;
use super::filling::Filling;
use super::lubricant::{self, LubricantChoice, LubricantInput};
use super::operation::OperationInput;
use super::problem::FieldError;
use super::spindle::SpindleInput;
use super::strict::{NameOr, object, optional_object};
use super::terms::TermsInput;
use super::units::field_error;
use crate::physics::bearing::{Bearing, PerRaceway};
use crate::physics::within;
use crate::simulation::scene::{Scene, SceneParameters};

/// What to simulate. Only `bearing` and `operation.speed_rpm` are required.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}))]
pub struct SceneInput {
    /// A preset name, a bearing, or a preset with changes.
    #[schema(value_type = BearingChoice)]
    pub bearing: NameOr<String, BearingInput>,
    /// Speed, loads and misalignment.
    #[serde(deserialize_with = "object")]
    pub operation: OperationInput,
    /// The spindle. Default: rigid and balanced.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub spindle: Option<SpindleInput>,
    /// A preset name or a lubricant. Default: that of the bearing's preset, else `grease`.
    #[schema(nullable = false, value_type = Option<LubricantChoice>)]
    pub lubricant: Option<NameOr<String, LubricantInput>>,
    /// Damping of the contacts.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub damping: Option<DampingInput>,
    /// Terms of the equations to switch on or off.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub terms: Option<TermsInput>,
    /// Acceleration of gravity along +Y [m/s²]. Default 9.81.
    #[schema(nullable = false, minimum = -1000, maximum = 1000, example = 9.81)]
    pub gravity_m_s2: Option<f64>,
}

/// A scene in both languages: with every default in the user's units, and checked in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedScene {
    pub input: SceneInput,
    /// Pointers from the root of a job to the fields that were left to their default.
    pub defaults: Vec<String>,
    pub scene: Scene,
}

impl SceneInput {
    /// Fills in every default and checks the whole.
    pub fn resolve(mut self) -> Result<ResolvedScene, Vec<FieldError>> {
        let mut filling = Filling::default();
        let parameters = self.parameters(&mut filling);
        if let Some(parameters) = &parameters {
            check_parts(parameters, &mut filling);
        }
        let defaults = filling.into_result()?;
        let unbuildable = || vec![FieldError::new("/scene", "cannot be built")];
        let scene = Scene::new(parameters.ok_or_else(unbuildable)?).map_err(|error| vec![field_error(&error)])?;
        Ok(ResolvedScene { input: self, defaults, scene })
    }

    /// The scene in SI; `None` after an error that leaves no scene to check.
    fn parameters(&mut self, filling: &mut Filling) -> Option<SceneParameters> {
        let operation = self.operation.resolve(filling);
        let terms = self.terms.get_or_insert_default().resolve(filling);
        let gravity = filling.take("/scene/gravity_m_s2", &mut self.gravity_m_s2, 9.81);
        let damping = self.damping.get_or_insert_default().resolve(filling);
        let chosen = bearing::choose(self.bearing.clone(), filling)?;
        let (mut own, base) = (chosen.own, chosen.base);

        let base_materials = base.bearing.materials.clone().unwrap_or_default();
        let materials = own.materials.get_or_insert_default().resolve(filling, &base_materials);
        let raceways = PerRaceway { inner: materials.inner_raceway, outer: materials.outer_raceway };
        let bearing = own.resolve(filling, &base.bearing, materials.ball, raceways);
        let ball_diameter_mm = own.ball_diameter_mm.unwrap_or_default();
        let lubricant = lubricant::resolve(&mut self.lubricant, filling, &base.lubricant, ball_diameter_mm);
        let base_cage = base.bearing.cage.clone().unwrap_or_default();
        let cage = own.cage.get_or_insert_default();
        let cage = cage.resolve(filling, &base_cage, materials.cage, lubricant.kind, damping.pocket);
        let axial_load = self.operation.axial_load_n.unwrap_or_default();
        let spindle = self.spindle.get_or_insert_default().resolve(filling, base.spindle_mass_kg, axial_load);
        self.bearing = NameOr::Object(own);
        Some(SceneParameters {
            bearing,
            cage,
            spindle,
            operation: operation?,
            lubricant,
            raceway_damping: damping.raceway,
            terms,
            gravity,
        })
    }
}

/// Checks each part by itself, so that the first wrong one does not hide the others.
fn check_parts(p: &SceneParameters, filling: &mut Filling) {
    filling.check(Bearing::new(p.bearing).map(drop));
    filling.check(p.cage.check());
    filling.check(p.spindle.check());
    filling.check(p.operation.check());
    filling.check(p.lubricant.check());
    filling.check(p.raceway_damping.check([
        "damping.raceway.restitution",
        "damping.raceway.at_speed",
        "damping.raceway.viscous",
    ]));
    filling.check(within("gravity", p.gravity, -1000.0, 1000.0));
    if filling.errors.is_empty() {
        filling.check(Scene::new(p.clone()).map(drop));
    }
}
