//! The scene of a rotor or machine job: a shaft or a rigid spindle on its supports and bearings.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::housing::{HousingInput, PartInput};
use super::loads::{LoadInput, LoadedBody};
use super::operation::{SPEED, SpeedInput, outer_speed};
use super::rotor_bearings::{self, PreloadInput, ResolvedBearing, RotorBearingInput};
use super::scene_input::ResolvedScene;
use super::sensor::{self, SensorInput};
use super::shaft::{ElementsName, ShaftInput};
use super::shaft_loads;
use super::spindle::SpindleInput;
use super::supports::{self, SupportInput};
use super::system_terms::{SystemTermsInput, check_sensors};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::shapes::{object, optional_list, optional_object};
use raceway_core::machine::terms::{OmittedTerm, SystemTerms};
use raceway_core::physics::defaults::GRAVITY;
use raceway_core::physics::limits::MOST_POINTS;
use raceway_core::physics::operation::SpeedProfile;
use raceway_core::rotor::input::{Elements, Rotor, Seat};
use raceway_core::rotor::omission::SystemTerm;
use raceway_core::rotor::sensor::Sensor;
use raceway_core::simulation::model::terms::Justification;

/// A shaft, or a rigid spindle, on its supports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RotorSceneInput {
    /// The shaft with its discs and unbalance. Without it the `spindle` is rigid.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub shaft: Option<ShaftInput>,
    /// A rigid spindle in place of `shaft`; several bearings hold it also against tilt. Its default mass is the sum of those of its bearings. Loads,
    /// unbalance and weight act at its mass centre.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub spindle: Option<SpindleInput>,
    /// Bodies and mounts of the housing, or an imported structure. Default: the ground holds everything.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub housing: Option<HousingInput>,
    /// Linear supports, in place of ball bearings or beside them.
    #[serde(default, deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 16)]
    pub supports: Option<Vec<SupportInput>>,
    /// Ball bearings.
    #[serde(default, deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 8)]
    pub bearings: Option<Vec<RotorBearingInput>>,
    /// Rigid preloads of pairs of bearings. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 4)]
    pub preloads: Option<Vec<PreloadInput>>,
    /// Speed and loads.
    #[serde(deserialize_with = "object")]
    pub operation: RotorOperationInput,
    /// Sensors on the shaft and on bodies and ports of the housing. Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 16)]
    pub sensors: Option<Vec<SensorInput>>,
    /// Terms of the equations of shaft and housing. Default `auto`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub terms: Option<SystemTermsInput>,
    /// Acceleration of gravity along +Y [m/s²]. Default 9.81.
    #[schema(nullable = false, example = 9.81)]
    pub gravity_m_s2: Option<f64>,
}

/// Speed, and loads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RotorOperationInput {
    /// Speed, at least 0. A `rotor` job takes the highest of a profile as its operating speed; a `machine` job starts with the first.
    pub speed_rpm: SpeedInput,
    /// Speed of every outer ring about its axis, positive in the direction of `speed_rpm`. Default 0: they stand. Rings on a part of the housing do not
    /// turn; elastic seats turn along, at a constant speed. A `rotor` job takes the speeds
    /// at which inner and outer rings turn fastest relative to each other, and the outer one at every shaft speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub outer_speed_rpm: Option<SpeedInput>,
    /// Load on the mass centre of shaft and discs along +Y, the direction of gravity [N]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub radial_load_y_n: Option<f64>,
    /// Load on the mass centre along +Z [N]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub radial_load_z_n: Option<f64>,
    /// Load on the mass centre along +X [N]. Default 0.
    #[schema(nullable = false, example = 0.0)]
    pub axial_load_n: Option<f64>,
    /// Loads on places of the shaft, constant or not, at most 32. A `rotor` job takes them as they are at time 0, and the mean of harmonic ones.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 32)]
    pub loads: Option<Vec<LoadInput>>,
}

/// Length of a rigid spindle with one place, and the longest [mm].
const SHORTEST_SPINDLE_MM: f64 = 1.0;
const LONGEST_SPINDLE_MM: f64 = 20_000.0;
/// Fields of the system around a bearing that no analysis takes yet.
const NOT_YET: [&str; 2] = ["thermal", "fits"];
/// Fields that each bearing has of its own.
const OF_BEARINGS: [&str; 3] = ["surfaces", "damping", "lubricant"];

/// Refuses fields of the request's scene that are described, but not supported yet, and removes them.
pub fn refuse_unsupported(request: &mut Value, defaults: &mut Defaults) {
    let scene = request.get_mut("scene").and_then(Value::as_object_mut);
    let Some(scene) = scene else { return };
    for field in NOT_YET {
        if scene.remove(field).is_some() {
            defaults.refuse(format!("/scene/{field}"), "not supported yet with `shaft`");
        }
    }
    let bearings = scene.get_mut("bearings").and_then(Value::as_array_mut);
    for (index, bearing) in bearings.into_iter().flatten().enumerate() {
        let cage = bearing.pointer_mut("/bearing/cage").and_then(Value::as_object_mut);
        if cage.is_some_and(|cage| cage.remove("flexibility").is_some()) {
            defaults.refuse(format!("/scene/bearings/{index}/bearing/cage/flexibility"), "not supported yet");
        }
    }
    for field in OF_BEARINGS {
        if scene.remove(field).is_some() {
            defaults.refuse(format!("/scene/{field}"), format!("give it in each item of `bearings`, as `{field}`"));
        }
    }
    if scene.remove("bearing").is_some() {
        defaults.refuse("/scene/bearing", "give `bearings`, a list of which each item has its place `at_mm`");
    }
    if scene.contains_key("shaft") && scene.remove("spindle").is_some() {
        defaults
            .refuse("/scene/spindle", "`shaft` takes its place: give its mass and unbalance as discs and unbalances");
    }
}

/// A scene of a shaft in SI.
pub struct ResolvedRotor {
    /// Its speed is the first of `speed`. Terms that are off are not in it.
    pub rotor: Rotor,
    /// The rotor with them, where some are off.
    pub complete: Option<Box<Rotor>>,
    pub terms: SystemTerms,
    pub speed: SpeedProfile,
    pub outer_speed: SpeedProfile,
    pub elements: Elements,
    /// The bearings of the rotor alone, in its order.
    pub scenes: Vec<ResolvedScene>,
    pub sensors: Vec<Sensor>,
}

impl ResolvedRotor {
    /// Terms that the rotor is without because they are off.
    pub fn omitted(&self) -> Vec<OmittedTerm> {
        let has = |term: &SystemTerm| self.complete.as_ref().is_some_and(|complete| complete.has(*term));
        let of = |term| OmittedTerm { term, by: Justification::Convention, change_db: None };
        self.terms.off().filter(has).map(of).collect()
    }
}

impl RotorSceneInput {
    /// The rotor in SI, with its bearings and sensors. Errors are noted in `defaults`.
    pub fn resolve(&mut self, defaults: &mut Defaults) -> ResolvedRotor {
        const OPERATION: &str = "/scene/operation";
        let operation = &mut self.operation;
        let speed = shaft_speed(&operation.speed_rpm, defaults);
        let outer_speed = outer_speed(operation.outer_speed_rpm.as_ref(), defaults);
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
        let length_mm = self.length_mm();
        let has_spring = self.bearings.iter().flatten().any(RotorBearingInput::has_spring);
        let shaft = self.shaft.as_mut().map(|shaft| shaft.resolve(defaults, load[0], has_spring));
        let housing = self.housing.as_mut().map(|housing| housing.resolve(defaults)).unwrap_or_default();
        let in_housing = self.housing.as_ref();
        let supports = self.supports.as_mut();
        let supports = supports.map(|supports| supports::resolve(supports, defaults, length_mm, in_housing));
        if self.bearings.as_ref().is_some_and(Vec::is_empty) {
            defaults.refuse("/scene/bearings", "0 items: must be from 1 to 8");
        }
        let bearings = self.bearings.as_mut();
        let bearings = bearings.map(|bearings| rotor_bearings::resolve(bearings, defaults, length_mm, in_housing));
        for PartInput { pointer, name, .. } in self.housing.iter().flat_map(|housing| housing.parts()) {
            if self.bearings.iter().flatten().any(|bearing| bearing.name == name) {
                defaults.refuse(format!("{pointer}/name"), format!("`{name}` is the name of a bearing"));
            }
        }
        let (supports, mut bearings) = (supports.unwrap_or_default(), bearings.unwrap_or_default());
        refuse_turning_seats(&outer_speed, &bearings, defaults);
        let inputs = self.bearings.as_deref().unwrap_or_default();
        if self.shaft.is_none() && inputs.is_empty() {
            defaults.refuse("/scene/shaft", "required, or `bearings` on a rigid spindle");
        } else if inputs.is_empty() && self.supports.as_ref().is_none_or(Vec::is_empty) {
            defaults.refuse("/scene/bearings", "required, or `supports`: the shaft needs at least one of both");
        }
        if bearings.len() == inputs.len() {
            let preloads = self.preloads.as_deref().unwrap_or_default();
            rotor_bearings::preload(preloads, inputs, &mut bearings, defaults);
        }
        let body = if shaft.is_some() { LoadedBody::Shaft } else { LoadedBody::Spindle };
        let (shaft, unbalances) = shaft.unwrap_or_else(|| {
            let acting = (length_mm, load[0], speed.largest());
            self.spindle.get_or_insert_default().resolve_on(&bearings, acting, defaults)
        });
        let elements = match &self.shaft {
            Some(shaft) => shaft.elements.unwrap_or(ElementsName::Auto).into(),
            None => Elements::Sections,
        };
        let on = (body, &shaft, length_mm);
        let loads = shaft_loads::resolve(&mut self.operation.loads, on, speed.largest(), defaults);
        let (bearings, scenes) = bearings.into_iter().map(|bearing| (bearing.rotor, bearing.scene)).unzip();
        let inputs = self.sensors.as_deref().unwrap_or_default();
        let sensors = sensor::resolve((inputs, self.housing.as_ref()), defaults, on);
        let terms = self.terms.as_mut().map(|terms| terms.resolve(defaults)).unwrap_or_default();
        check_sensors(&terms, &sensors, defaults);
        let complete =
            Rotor { shaft, unbalances, supports, bearings, housing, speed: speed.at(0.0).1, gravity, load, loads };
        let rotor = terms.off().fold(complete.clone(), Rotor::without);
        let is_lean = terms.off().next().is_some();
        ResolvedRotor {
            rotor,
            complete: is_lean.then(|| Box::new(complete)),
            terms,
            speed,
            outer_speed,
            elements,
            scenes,
            sensors,
        }
    }
}

/// Refuses outer rings that turn where what carries them cannot turn along.
fn refuse_turning_seats(speed: &SpeedProfile, bearings: &[ResolvedBearing], defaults: &mut Defaults) {
    if speed.largest() == 0.0 {
        return;
    }
    for (index, bearing) in bearings.iter().enumerate() {
        let at = format!("/scene/bearings/{index}/outer_ring");
        if bearing.rotor.on.is_some() {
            let detail = "a part of the housing does not turn with the ring (operation.outer_speed_rpm): leave it out";
            defaults.refuse(format!("{at}/on"), detail);
        }
        if matches!(bearing.rotor.seat, Seat::Elastic { .. }) && !speed.is_constant() {
            let detail =
                "an elastic seat turns with its ring at a constant speed: give operation.outer_speed_rpm as one number";
            defaults.refuse(format!("{at}/seat"), detail);
        }
    }
}

impl RotorSceneInput {
    /// Length of the shaft [mm]; of a rigid spindle up to the farthest place on it.
    fn length_mm(&self) -> f64 {
        if let Some(shaft) = &self.shaft {
            return shaft.sections.iter().map(|section| section.length_mm).sum();
        }
        let bearings = self.bearings.iter().flatten().map(|bearing| bearing.at_mm);
        let supports = self.supports.iter().flatten().map(|support| support.at_mm);
        let sensors = self.sensors.iter().flatten().map(|sensor| sensor.at_mm);
        let loads = self.operation.loads.iter().flatten().filter_map(|load| load.at_mm);
        let centre = self.spindle.iter().filter_map(|spindle| spindle.centre_mm);
        let places = bearings.chain(supports).chain(sensors).chain(loads).chain(centre);
        places.fold(SHORTEST_SPINDLE_MM, f64::max).min(LONGEST_SPINDLE_MM)
    }
}

/// The speed in SI; at rest after an error.
fn shaft_speed(input: &SpeedInput, defaults: &mut Defaults) -> SpeedProfile {
    let known_errors = defaults.errors.len();
    match input {
        SpeedInput::Constant(speed) => {
            defaults.check_of_rotor(SPEED, *speed);
        }
        SpeedInput::Profile(points) => {
            for (index, point) in points.iter().enumerate().take(MOST_POINTS) {
                defaults.check_of_rotor(&format!("{SPEED}/{index}/rpm"), point.rpm);
            }
        }
    }
    let profile = if defaults.errors.len() == known_errors { input.resolve(SPEED, defaults) } else { None };
    profile.unwrap_or_else(SpeedProfile::at_rest)
}
