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
use crate::physics::bearing::PerRaceway;
use crate::physics::defaults::GRAVITY;
use crate::simulation::input::scene::{Scene, SceneParameters};

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
    #[schema(nullable = false, example = 9.81)]
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
    pub fn resolve(self) -> Result<ResolvedScene, Vec<FieldError>> {
        self.resolve_in(Filling::default())
    }

    /// What is wrong beside the parts that could not be read, and are left out here: of the others each by itself, for nothing
    /// that is told of the whole would be true of the scene that is meant.
    pub fn faults_beside(self, unread: &[FieldError]) -> Vec<FieldError> {
        self.resolve_in(Filling::without(unread)).err().unwrap_or_default()
    }

    fn resolve_in(mut self, mut filling: Filling) -> Result<ResolvedScene, Vec<FieldError>> {
        let parameters = self.parameters(&mut filling);
        let scene = filling.built(Scene::new(parameters));
        let defaults = filling.into_result()?;
        let unbuildable = || vec![FieldError::new("/scene", "cannot be built")];
        Ok(ResolvedScene { input: self, defaults, scene: scene.ok_or_else(unbuildable)? })
    }

    /// The scene in SI, with something else in the place of what cannot be had.
    fn parameters(&mut self, filling: &mut Filling) -> SceneParameters {
        let operation = self.operation.resolve(filling);
        let terms = self.terms.get_or_insert_default().resolve(filling);
        let gravity = filling.take("/scene/gravity_m_s2", &mut self.gravity_m_s2, GRAVITY);
        let damping = self.damping.get_or_insert_default().resolve(filling);
        let bearing::ChosenBearing { mut own, base } = bearing::choose(self.bearing.clone(), filling);

        let base_materials = base.bearing.materials.clone().unwrap_or_default();
        let materials = own.materials.get_or_insert_default().resolve(filling, &base_materials);
        let raceways = PerRaceway { inner: materials.inner_raceway, outer: materials.outer_raceway };
        let bearing = own.resolve(filling, &base.bearing, materials.ball, raceways);
        let ball_diameter_mm = own.ball_diameter_mm.unwrap_or_default();
        let lubricant = lubricant::resolve(&mut self.lubricant, filling, base.lubricant, ball_diameter_mm);
        let base_cage = base.bearing.cage.clone().unwrap_or_default();
        let cage = own.cage.get_or_insert_default();
        let cage = cage.resolve(filling, &base_cage, materials.cage, lubricant.kind, damping.pocket);
        let axial_load = self.operation.axial_load_n.unwrap_or_default();
        let spindle = self.spindle.get_or_insert_default().resolve(filling, base.spindle_mass_kg, axial_load);
        self.bearing = NameOr::Object(own);
        let raceway_damping = damping.raceway;
        SceneParameters { bearing, cage, spindle, operation, lubricant, raceway_damping, terms, gravity }
    }
}
