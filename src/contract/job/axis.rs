//! An axis of a study or an optimum job as it is sent.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::contract::json::shapes::{object, whole_number};

/// Largest number of points of a grid.
pub const MAX_POINTS: usize = 10_000;

/// An axis: a field of the scene, or a derived quantity, and its values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"path": "/bearing/inner_groove_curvature", "values": [0.515, 0.52, 0.53]}))]
pub struct AxisInput {
    /// JSON pointer from the scene to the varied field; either this or `quantity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 200, example = "/bearing/inner_groove_curvature")]
    pub path: Option<String>,
    /// `axial_load_over_rating`: axial load divided by the dynamic load rating.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<QuantityName>)]
    pub quantity: Option<String>,
    /// The values, numbers or names; either these or `from`, `to` and `count`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<Vec<AxisValue>>, min_items = 1, max_items = 10000)]
    pub values: Option<Vec<Value>>,
    /// First value; with `to` and, in a study, `count`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.51)]
    pub from: Option<f64>,
    /// Last value.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.54)]
    pub to: Option<f64>,
    /// Number of values, both ends included.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "whole_number::<_, 2, { MAX_POINTS as u32 }>"
    )]
    #[schema(nullable = false, minimum = 2, maximum = 10000, example = 7)]
    pub count: Option<u32>,
    /// Spacing of the values. Default `linear`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<ScaleName>)]
    pub scale: Option<String>,
}

/// Derived quantities that an axis can vary.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum QuantityName {
    AxialLoadOverRating,
}

/// Spacing of the values of an axis.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum ScaleName {
    Linear,
    Log,
}

/// A value on an axis.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum AxisValue {
    Number(f64),
    Word(String),
}

/// An axis, read from an object only: derived structs also read arrays.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(transparent)]
#[schema(value_type = AxisInput)]
pub struct StrictAxis(pub AxisInput);

impl<'de> Deserialize<'de> for StrictAxis {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        object(deserializer).map(Self)
    }
}
