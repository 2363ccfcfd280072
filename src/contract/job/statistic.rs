//! The statistic of an optimum over uncertain inputs, as it is sent.

use raceway_core::sampling::statistic::Statistic;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::shapes::NameOr;

/// A statistic by name, or a percentile.
pub type StatisticInput = NameOr<StatisticName, PercentileInput>;

/// A statistic by name, or a percentile.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum StatisticChoice {
    Name(StatisticName),
    Fields(PercentileInput),
}

/// A statistic by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StatisticName {
    Mean,
}

/// A percentile of a metric.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PercentileInput {
    /// Share of the values that do not exceed it [%].
    #[schema(example = 90.0)]
    pub percentile: f64,
}

/// The statistic in the core.
pub fn in_core(given: &StatisticInput) -> Statistic {
    match given {
        NameOr::Name(StatisticName::Mean) => Statistic::Mean,
        NameOr::Object(of) => Statistic::Percentile(of.percentile / 100.0),
    }
}

/// The statistic in words.
pub fn words(given: &StatisticInput) -> String {
    match given {
        NameOr::Name(StatisticName::Mean) => "mean".to_owned(),
        NameOr::Object(of) => format!("percentile {}", of.percentile),
    }
}
