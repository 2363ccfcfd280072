//! Speed, loads and misalignment.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::FieldError;
use crate::contract::json::shapes::{ObjectOnly, optional_list, optional_object, whole_number};
use crate::contract::json::{
    parameters,
    units::{MM_S, MRAD, RPM},
};
use crate::contract::scene::loads::{self, LoadInput};
use raceway_core::physics::limits::MOST_POINTS;
use raceway_core::physics::operation::{InitialPerturbation, Operation, SpeedProfile};

/// Speed, loads, misalignment and initial perturbation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OperationInput {
    /// Speed of the inner ring.
    pub speed_rpm: SpeedInput,
    /// Speed of the outer ring about its axis, positive in the direction of `speed_rpm`. Default 0: it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub outer_speed_rpm: Option<SpeedInput>,
    /// Radial load on the spindle along +Y, the direction of gravity [N]. Default 0.
    #[schema(nullable = false, example = 200.0)]
    pub radial_load_y_n: Option<f64>,
    /// Radial load on the spindle along +Z [N]. Default 0.
    #[schema(nullable = false)]
    pub radial_load_z_n: Option<f64>,
    /// Axial load on the spindle along +X [N]; requires a spindle that is free in axial direction. Default 0.
    #[schema(nullable = false)]
    pub axial_load_n: Option<f64>,
    /// Loads beside these, constant or not, at most 32. Each acts at the centre of mass of the spindle.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_list")]
    #[schema(nullable = false, max_items = 32)]
    pub loads: Option<Vec<LoadInput>>,
    /// Imposed misalignment of the spindle.
    #[serde(default, deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub misalignment_mrad: Option<MisalignmentInput>,
    /// Initial velocity of every ball and of the cage, for studies of stability. Default: none, the run starts from equilibrium.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "optional_object")]
    #[schema(nullable = false)]
    pub initial_perturbation: Option<InitialPerturbationInput>,
}

/// Initial velocities in random directions. A motion that is unstable then grows from this push, not from rounding errors. Only the model
/// levels `full` and `planar` have it; `planar` omits its part along the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialPerturbationInput {
    /// Magnitude of the velocity of each ball and of the cage, relative to ideal rolling [mm/s].
    #[schema(example = 0.1)]
    pub speed_mm_s: f64,
    /// Seed of the directions: the same seed gives the same directions on every machine. Default 0.
    #[serde(default, deserialize_with = "whole_number::<_, 0, { u32::MAX }>")]
    #[schema(nullable = false, value_type = u64, minimum = 0, maximum = 4_294_967_295_u32, example = 1)]
    pub seed: Option<u32>,
}

/// A constant speed from −500 000 to 500 000 r/min, or a profile of points with linear interpolation. A negative speed reverses the direction.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum SpeedInput {
    Constant(f64),
    Profile(Vec<SpeedPointInput>),
}

/// Speed at a time. The speed is constant before the first point and after the last one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedPointInput {
    /// Time since the start, settling included [s]; increases from point to point.
    #[schema(example = 0.0)]
    pub at_s: f64,
    /// Speed [r/min].
    #[schema(example = 50000.0)]
    pub rpm: f64,
}

/// Misalignment of the spindle about Y and about Z [mrad]. Default 0.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MisalignmentInput {
    /// Rotation about Y [mrad]. Default 0.
    #[schema(nullable = false)]
    pub y: Option<f64>,
    /// Rotation about Z [mrad]. Default 0.
    #[schema(nullable = false)]
    pub z: Option<f64>,
}

impl OperationInput {
    /// The operation of `physics`. After an error of the speed, the speed is zero.
    pub fn resolve(&mut self, defaults: &mut Defaults) -> Operation {
        let mut take =
            |name: &str, field: &mut Option<f64>| defaults.fill(format!("/scene/operation/{name}"), field, 0.0);
        let load = [
            take("axial_load_n", &mut self.axial_load_n),
            take("radial_load_y_n", &mut self.radial_load_y_n),
            take("radial_load_z_n", &mut self.radial_load_z_n),
        ];
        let tilt = self.misalignment_mrad.get_or_insert_default();
        let misalignment = [
            MRAD.to_si(take("misalignment_mrad/y", &mut tilt.y)),
            MRAD.to_si(take("misalignment_mrad/z", &mut tilt.z)),
        ];
        let speed = self.speed_rpm.resolve(SPEED, defaults).unwrap_or_else(SpeedProfile::at_rest);
        let outer_speed = outer_speed(self.outer_speed_rpm.as_ref(), defaults);
        let perturbation = self.initial_perturbation.as_mut().map(|given| {
            let pointer = "/scene/operation/initial_perturbation/seed";
            let seed = defaults.fill(pointer, &mut given.seed, 0);
            InitialPerturbation { speed: MM_S.to_si(given.speed_mm_s), seed: u64::from(seed) }
        });
        let loads = loads::resolve(&mut self.loads, defaults);
        Operation { speed, outer_speed, load, loads, misalignment, perturbation }
    }
}

/// Pointers to the speeds of the rings.
pub(super) const SPEED: &str = "/scene/operation/speed_rpm";
const OUTER_SPEED: &str = "/scene/operation/outer_speed_rpm";

/// The speed of the outer ring; at rest without one, and after an error.
pub(super) fn outer_speed(input: Option<&SpeedInput>, defaults: &mut Defaults) -> SpeedProfile {
    input.and_then(|input| input.resolve(OUTER_SPEED, defaults)).unwrap_or_else(SpeedProfile::at_rest)
}

impl SpeedInput {
    /// The speed profile of `physics`; `None` after an error. `at`: pointer to the field.
    pub fn resolve(&self, at: &str, defaults: &mut Defaults) -> Option<SpeedProfile> {
        let points: Vec<_> = match self {
            Self::Constant(rpm) => vec![(0.0, RPM.to_si(*rpm))],
            Self::Profile(points) => points.iter().map(|point| (point.at_s, RPM.to_si(point.rpm))).collect(),
        };
        let known_errors = defaults.errors.len();
        if let Self::Profile(_) = self {
            // Each point is checked by itself, so that the error has its pointer.
            for (index, point) in points.iter().enumerate().take(MOST_POINTS) {
                for fault in SpeedProfile::new(vec![*point]).err().iter().flatten() {
                    let FieldError { pointer, detail } = parameters::field_error(fault);
                    let name = if pointer.ends_with("/at_s") { "at_s" } else { "rpm" };
                    defaults.refuse(format!("{at}/{index}/{name}"), detail);
                }
            }
        }
        if defaults.errors.len() > known_errors {
            return None;
        }
        let faults = match SpeedProfile::new(points) {
            Ok(profile) => return Some(profile),
            Err(faults) => faults,
        };
        let moved = |error: FieldError| FieldError { pointer: error.pointer.replacen(SPEED, at, 1), ..error };
        defaults.errors.extend(faults.iter().map(parameters::field_error).map(moved));
        None
    }
}

impl<'de> Deserialize<'de> for SpeedInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Speed;
        impl<'de> Visitor<'de> for Speed {
            type Value = SpeedInput;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or an array of {\"at_s\", \"rpm\"}")
            }
            fn visit_f64<E>(self, rpm: f64) -> Result<SpeedInput, E> {
                Ok(SpeedInput::Constant(rpm))
            }
            fn visit_u64<E>(self, rpm: u64) -> Result<SpeedInput, E> {
                Ok(SpeedInput::Constant(rpm as f64))
            }
            fn visit_i64<E>(self, rpm: i64) -> Result<SpeedInput, E> {
                Ok(SpeedInput::Constant(rpm as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, points: A) -> Result<SpeedInput, A::Error> {
                let points = Vec::<ObjectOnly<SpeedPointInput>>::deserialize(SeqAccessDeserializer::new(points))?;
                Ok(SpeedInput::Profile(points.into_iter().map(|point| point.0).collect()))
            }
        }
        deserializer.deserialize_any(Speed)
    }
}
