//! Sensors on the shaft and on parts of the housing.

use std::fmt;

use serde::de::value::{SeqAccessDeserializer, StrDeserializer};
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use super::housing::{HousingInput, body};
use super::loads::LoadedBody;
use super::names::check_name;
use super::shaft::check_place;
use super::shaft_loads::held_along_x;
use crate::contract::json::defaults::Defaults;
use crate::contract::json::units::MM;
use raceway_core::physics::frame::shaft::Shaft;
use raceway_core::rotor::sensor::{Part, Sensor};

/// A sensor on the shaft, or on a body or port of the housing. Its channels are `sensor.NAME.displacement`, `.velocity` and `.acceleration`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorInput {
    /// Name: a letter, then letters, digits, `_` or `-`, at most 32.
    #[schema(pattern = "^[A-Za-z][A-Za-z0-9_-]{0,31}$", example = "probe")]
    pub name: String,
    /// `shaft`, or the name of a body or port of the housing that it sits on. Default `shaft`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 32, example = "shaft")]
    pub on: Option<String>,
    /// Reference of the measurement at the same place: `shaft`, or the name of a body or port of the housing. Default: the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 32, example = "head")]
    pub relative_to: Option<String>,
    /// Place along the shaft [mm]; of a sensor that has nothing to do with the shaft also beyond its ends.
    #[schema(example = 150.0)]
    pub at_mm: f64,
    /// Direction in which it measures.
    #[schema(example = "y")]
    pub direction: SensorDirection,
}

/// Direction of a sensor: an axis, or a vector of any length along X, Y, Z, such as [0, 1, 1] for 45° between Y and Z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum SensorDirection {
    Axis(DirectionName),
    Vector([f64; 3]),
}

/// Direction of the inertial frame: `x` along the shaft, `y` along gravity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DirectionName {
    X,
    Y,
    Z,
}

impl<'de> Deserialize<'de> for SensorDirection {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Direction;
        impl<'de> Visitor<'de> for Direction {
            type Value = SensorDirection;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("`x`, `y`, `z` or an array of three numbers")
            }
            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<SensorDirection, E> {
                DirectionName::deserialize(StrDeserializer::new(name)).map(SensorDirection::Axis)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, along: A) -> Result<SensorDirection, A::Error> {
                <[f64; 3]>::deserialize(SeqAccessDeserializer::new(along)).map(SensorDirection::Vector)
            }
        }
        deserializer.deserialize_any(Direction)
    }
}

impl SensorDirection {
    /// The vector of length 1; `None` of one without length.
    fn unit(self) -> Option<[f64; 3]> {
        match self {
            Self::Axis(axis) => Some(std::array::from_fn(|index| f64::from(index == axis as usize))),
            Self::Vector(along) => {
                // Divided by the largest part first, so that squares neither overflow nor vanish.
                let largest = along.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
                let scaled = along.map(|part| part / largest);
                let length = scaled.iter().map(|part| part * part).sum::<f64>().sqrt();
                length.is_finite().then(|| scaled.map(|part| part / length))
            }
        }
    }
}

const POINTER: &str = "/scene/sensors";
const MAX_SENSORS: usize = 16;

/// The sensors in SI. Errors are noted in `defaults`.
pub(super) fn resolve(
    (inputs, housing): (&[SensorInput], Option<&HousingInput>),
    defaults: &mut Defaults,
    (of_shaft, shaft, length_mm): (LoadedBody, &Shaft, f64),
) -> Vec<Sensor> {
    if inputs.len() > MAX_SENSORS {
        defaults.refuse(POINTER, format!("{} sensors: at most {MAX_SENSORS}", inputs.len()));
    }
    let mut sensors = Vec::with_capacity(inputs.len());
    for (index, sensor) in inputs.iter().enumerate() {
        let at = format!("{POINTER}/{index}");
        check_name(&sensor.name, defaults, &at);
        if inputs[..index].iter().any(|other| other.name == sensor.name) {
            defaults.refuse(format!("{at}/name"), format!("`{}` is the name of another sensor", sensor.name));
        }
        let on = part(housing, sensor.on.as_ref(), defaults, format!("{at}/on")).unwrap_or(Part::Shaft);
        let relative_to = part(housing, sensor.relative_to.as_ref(), defaults, format!("{at}/relative_to"));
        if relative_to == Some(on) {
            defaults.refuse(format!("{at}/relative_to"), "must be another part than the one that the sensor sits on");
        }
        let along = sensor.direction.unit().unwrap_or_else(|| {
            defaults.refuse(format!("{at}/direction"), "0, 0, 0: must have one part that is not 0");
            [0.0; 3]
        });
        let (name, place) = (sensor.name.clone(), MM.to_si(sensor.at_mm));
        let resolved = Sensor { name, on, relative_to, at: place, along };
        if resolved.concerns_shaft() {
            check_place(defaults, (&at, "at_mm"), sensor.at_mm, length_mm);
        } else {
            defaults.check_of_rotor(&format!("{at}/at_mm"), sensor.at_mm);
        }
        if along[0] != 0.0 && on == Part::Shaft && !shaft.is_axially_free {
            defaults.refuse(format!("{at}/direction"), held_along_x(of_shaft));
        }
        sensors.push(resolved);
    }
    sensors
}

/// The part with a name; `None` without one, and after an error.
fn part(
    housing: Option<&HousingInput>,
    name: Option<&String>,
    defaults: &mut Defaults,
    pointer: String,
) -> Option<Part> {
    match name {
        Some(name) if name == "shaft" => Some(Part::Shaft),
        name => body(housing, name, defaults, pointer).map(Part::Housing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions of any length have length 1, also where squares overflow or vanish.
    #[test]
    fn directions_have_length_one() {
        for scale in [1e-300, 1.0, 1e300] {
            let [x, y, z] = SensorDirection::Vector([0.0, -3.0 * scale, 4.0 * scale]).unit().unwrap();
            assert!(x == 0.0 && (y + 0.6).abs() < 1e-15 && (z - 0.8).abs() < 1e-15, "{scale}: {y}, {z}");
        }
        assert_eq!(SensorDirection::Axis(DirectionName::Z).unit(), Some([0.0, 0.0, 1.0]));
        assert_eq!(SensorDirection::Vector([0.0; 3]).unit(), None);
    }
}
