//! The scene of a rotor job: a shaft on its supports.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::rotor_bearings::{self, PreloadInput, RotorBearingInput};
use super::shaft::{ElementsName, ShaftInput};
use super::supports::{self, SupportInput};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::shapes::{object, optional_list};
use crate::contract::json::units::RPM;
use raceway_core::physics::defaults::GRAVITY;
use raceway_core::rotor::input::{Elements, Rotor};

/// A shaft on its supports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RotorSceneInput {
    /// The shaft with its discs and unbalance.
    #[serde(deserialize_with = "object")]
    pub shaft: ShaftInput,
    /// Linear supports, in place of ball bearings or beside them.
    #[serde(default, deserialize_with = "optional_list")]
    #[schema(nullable = false, min_items = 1, max_items = 16)]
    pub supports: Option<Vec<SupportInput>>,
    /// Ball bearings.
    #[serde(default, deserialize_with = "optional_list")]
    #[schema(nullable = false, min_items = 1, max_items = 8)]
    pub bearings: Option<Vec<RotorBearingInput>>,
    /// Rigid preloads of pairs of bearings. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 4)]
    pub preloads: Option<Vec<PreloadInput>>,
    /// Speed and loads.
    #[serde(deserialize_with = "object")]
    pub operation: RotorOperationInput,
    /// Acceleration of gravity along +Y [m/s²]. Default 9.81.
    #[schema(nullable = false, example = 9.81)]
    pub gravity_m_s2: Option<f64>,
}

/// Operating speed, and forces on the mass centre of shaft and discs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RotorOperationInput {
    /// Operating speed [r/min].
    #[schema(example = 12000.0)]
    pub speed_rpm: f64,
    /// Load along +Y, the direction of gravity [N]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub radial_load_y_n: Option<f64>,
    /// Load along +Z [N]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub radial_load_z_n: Option<f64>,
    /// Load along +X [N]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub axial_load_n: Option<f64>,
}

/// Fields of the system around a bearing that no analysis takes yet.
const NOT_YET: [&str; 8] = ["housing", "sensors", "thermal", "fits", "surfaces", "terms", "damping", "lubricant"];

/// Refuses fields of the request's scene that are described, but not supported yet, and removes them.
pub fn refuse_unsupported(request: &mut Value, defaults: &mut Defaults) {
    let scene = request.get_mut("scene").and_then(Value::as_object_mut);
    let Some(scene) = scene else { return };
    for field in NOT_YET {
        if scene.remove(field).is_some() {
            defaults.refuse(format!("/scene/{field}"), "not supported yet by jobs of kind `rotor`");
        }
    }
    if scene.remove("bearing").is_some() {
        defaults.refuse("/scene/bearing", "give `bearings`, a list of which each item has its place `at_mm`");
    }
    if scene.remove("spindle").is_some() {
        defaults
            .refuse("/scene/spindle", "`shaft` takes its place: give its mass and unbalance as discs and unbalances");
    }
    if let Some(loads) = scene.get_mut("operation").and_then(Value::as_object_mut)
        && loads.remove("loads").is_some()
    {
        defaults
            .refuse("/scene/operation/loads", "not supported yet; give radial_load_y_n, radial_load_z_n, axial_load_n");
    }
}

impl RotorSceneInput {
    /// The rotor in SI, and its elements. Errors are noted in `defaults`.
    pub fn resolve(&mut self, defaults: &mut Defaults) -> (Rotor, Elements) {
        const OPERATION: &str = "/scene/operation";
        let operation = &mut self.operation;
        defaults.check_of_rotor(&format!("{OPERATION}/speed_rpm"), operation.speed_rpm);
        let mut load = |name: &str, field: &mut Option<f64>| {
            let pointer = format!("{OPERATION}/{name}");
            let value = defaults.fill(pointer.clone(), field, 0.0);
            defaults.check_of_rotor(&pointer, value);
            value
        };
        let load = [
            load("axial_load_n", &mut operation.axial_load_n),
            load("radial_load_y_n", &mut operation.radial_load_y_n),
            load("radial_load_z_n", &mut operation.radial_load_z_n),
        ];
        let gravity = defaults.fill("/scene/gravity_m_s2", &mut self.gravity_m_s2, GRAVITY);
        defaults.check_of_rotor("/scene/gravity_m_s2", gravity);
        let length_mm: f64 = self.shaft.sections.iter().map(|section| section.length_mm).sum();
        let (shaft, unbalances) = self.shaft.resolve(defaults, load[0]);
        let supports = self.supports.as_mut().map(|supports| supports::resolve(supports, defaults, length_mm));
        if self.bearings.as_ref().is_some_and(Vec::is_empty) {
            defaults.refuse("/scene/bearings", "0 items: must be from 1 to 8");
        }
        let bearings = self.bearings.as_mut().map(|bearings| rotor_bearings::resolve(bearings, defaults, length_mm));
        let (supports, mut bearings) = (supports.unwrap_or_default(), bearings.unwrap_or_default());
        let inputs = self.bearings.as_deref().unwrap_or_default();
        if inputs.is_empty() && self.supports.as_ref().is_none_or(Vec::is_empty) {
            defaults.refuse("/scene/bearings", "required, or `supports`: the shaft needs at least one of both");
        }
        if bearings.len() == inputs.len() {
            bearings =
                rotor_bearings::preload(self.preloads.as_deref().unwrap_or_default(), inputs, bearings, defaults);
        }
        let elements = self.shaft.elements.unwrap_or(ElementsName::Auto).into();
        let speed = RPM.to_si(operation.speed_rpm);
        (Rotor { shaft, unbalances, supports, bearings, speed, gravity, load }, elements)
    }
}
