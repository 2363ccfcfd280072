//! A scene as it is sent, and as it is checked.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::FieldError;
use crate::contract::json::shapes::{NameOr, object, optional_object};
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::bearing::{BearingChoice, BearingInput};
use crate::contract::scene::bearing_base::{ChosenBearing, choose};
use crate::contract::scene::damping::DampingInput;
use crate::contract::scene::life::life_input;
use crate::contract::scene::lubricant::{self, LubricantChoice, LubricantInput};
use crate::contract::scene::mounted_bearing::mount;
use crate::contract::scene::mounting::{OperatingClearance, RingsAndBalls};
use crate::contract::scene::oil::OilAtTemperature;
use crate::contract::scene::operation::OperationInput;
use crate::contract::scene::spindle::SpindleInput;
use crate::contract::scene::surfaces::SurfacesInput;
use crate::contract::scene::terms::TermsInput;
use raceway_core::physics::bearing::PerRaceway;
use raceway_core::physics::defaults::GRAVITY;
use raceway_core::physics::designation::Designation;
use raceway_core::simulation::input::scene::{Scene, SceneParameters};
use raceway_core::simulation::model::rating_life::LifeInput;

/// The simulated system: bearing, spindle, lubricant and operation. Only `bearing` and `operation.speed_rpm` are required. A list `bearings` of one
/// item, as in jobs of kind `machine`, may stand for `bearing`, `lubricant`, `damping` and `surfaces`.
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
    /// Surfaces of raceways and balls. Default: ideal circles and equal balls.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub surfaces: Option<SurfacesInput>,
    /// Terms of the equations that are switched on or off.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub terms: Option<TermsInput>,
    /// Acceleration of gravity along +Y [m/s²]. Default 9.81.
    #[schema(nullable = false, example = 9.81)]
    pub gravity_m_s2: Option<f64>,
    /// Contamination factor e_C of ISO 281, for `life.a_iso` [-]: 1 in extreme cleanliness, 0.5 to 0.6 in normal one, 0.1 and less in dirt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.5)]
    pub contamination_factor: Option<f64>,
}

/// A checked scene: with all defaults in the user's units, and in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedScene {
    pub input: SceneInput,
    /// Pointers, from the root of a job, to the fields that got their default.
    pub defaults: Vec<String>,
    pub scene: Scene,
    pub ordered: Ordered,
    /// Data of a rating life beside the scene.
    pub life: LifeInput,
}

/// Order codes of the request, for which the resolved scene has numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ordered {
    pub designation: Option<Designation>,
    pub clearance: Option<OperatingClearance>,
    pub oil: Option<OilAtTemperature>,
}

impl SceneInput {
    /// Fills in all defaults and checks the scene.
    pub fn resolve(self, uploads: &Uploads) -> Result<ResolvedScene, Vec<FieldError>> {
        self.resolve_in(Defaults::with(uploads))
    }

    /// Errors of the fields other than those that could not be read, which are missing here. Each field is checked only by itself: errors
    /// of the whole would not apply to the requested scene.
    pub fn errors_without(self, unread: &[FieldError], uploads: &Uploads) -> Vec<FieldError> {
        self.resolve_in(Defaults::without(unread, uploads)).err().unwrap_or_default()
    }

    fn resolve_in(mut self, mut defaults: Defaults) -> Result<ResolvedScene, Vec<FieldError>> {
        let mut ordered = Ordered::default();
        let parameters = self.parameters(&mut defaults, &mut ordered);
        let scene = defaults.built(Scene::new(parameters));
        let life = match &self.bearing {
            NameOr::Object(bearing) => {
                life_input(bearing, self.contamination_factor, ordered.oil.as_ref(), &mut defaults)
            }
            NameOr::Name(_) => LifeInput::default(),
        };
        let defaults = defaults.into_result()?;
        let unbuildable = || vec![FieldError::new("/scene", "cannot be built")];
        Ok(ResolvedScene { input: self, defaults, scene: scene.ok_or_else(unbuildable)?, ordered, life })
    }

    /// The scene in SI. After an error a substitute replaces the wrong value.
    fn parameters(&mut self, defaults: &mut Defaults, ordered: &mut Ordered) -> SceneParameters {
        let operation = self.operation.resolve(defaults);
        let terms = self.terms.get_or_insert_default().resolve(defaults);
        let gravity = defaults.fill("/scene/gravity_m_s2", &mut self.gravity_m_s2, GRAVITY);
        let surfaces = self.surfaces.as_mut().map(|surfaces| surfaces.resolve(defaults)).unwrap_or_default();
        let damping = self.damping.get_or_insert_default().resolve(defaults);
        let ChosenBearing { mut own, base, designation } = choose(self.bearing.clone(), defaults);

        let base_materials = base.bearing.materials.clone().unwrap_or_default();
        let materials = own.materials.get_or_insert_default().resolve(defaults, &base_materials);
        let raceways = PerRaceway { inner: materials.inner_raceway, outer: materials.outer_raceway };
        let group = designation.as_ref().and_then(Designation::clearance_group);
        let of_clearance = RingsAndBalls { rings: raceways, ball: materials.ball };
        ordered.clearance = mount(&mut own, &base.bearing, group, &of_clearance, defaults);
        ordered.designation = designation;
        let bearing = own.resolve(defaults, &base.bearing, materials.ball, raceways);
        let ball_diameter_mm = own.ball_diameter_mm.unwrap_or_default();
        let (lubricant, oil) = lubricant::resolve(&mut self.lubricant, defaults, base.lubricant, ball_diameter_mm);
        ordered.oil = oil;
        let base_cage = base.bearing.cage.clone().unwrap_or_default();
        let cage = own.cage.get_or_insert_default();
        let pocket_deviations = cage.pocket_deviations(defaults);
        let cage = cage.resolve(defaults, &base_cage, materials.cage, lubricant.kind, damping.pocket);
        if self.spindle.as_ref().is_some_and(|spindle| spindle.centre_mm.is_some()) {
            defaults
                .refuse("/scene/spindle/centre_mm", "a bearing alone stands at the mass centre: goes with `bearings`");
        }
        let spindle =
            self.spindle.get_or_insert_default().resolve(defaults, base.spindle_mass_kg, operation.acts_along_x());
        self.bearing = NameOr::Object(own);
        let raceway_damping = damping.raceway;
        SceneParameters {
            bearing,
            cage,
            spindle,
            operation,
            lubricant,
            raceway_damping,
            terms,
            surfaces,
            pocket_deviations,
            gravity,
        }
    }
}
