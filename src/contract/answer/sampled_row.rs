//! A point of a study over samples of uncertain inputs: the statistic of each metric in place of the metric.

use std::collections::BTreeSet;

use raceway_core::sampling::statistic::Statistic;
use serde_json::{Map, Value};

use super::point::{PointStatus, SamplesAnswer};
use super::table::Row;
use super::uncertainty::{over_samples, uncertain};
use crate::contract::json::problem::escape;

impl Row {
    /// A row from those of all its samples; `None` without any.
    pub fn over_samples(statistic: Statistic, runs: &[Self]) -> Option<Self> {
        let count = |status: PointStatus| runs.iter().filter(|run| run.status == status).count();
        let (succeeded, failed) = (count(PointStatus::Succeeded), count(PointStatus::Failed));
        let status = if succeeded + failed == runs.len() {
            if succeeded > 0 { PointStatus::Succeeded } else { PointStatus::Failed }
        } else if count(PointStatus::Cancelled) > 0 {
            PointStatus::Cancelled
        } else if count(PointStatus::Queued) == runs.len() {
            PointStatus::Queued
        } else {
            PointStatus::Running
        };
        // Those of a failed run are null, which has no number.
        let known: Vec<&Value> = runs.iter().map(|run| run.metrics.as_ref().unwrap_or(&Value::Null)).collect();
        let (metrics, half_intervals) = match status {
            PointStatus::Succeeded => over(statistic, &known, ""),
            _ => None,
        }
        .unzip();
        let with_messages = |mut metrics: Value| {
            metrics["messages"] = messages(&known);
            metrics
        };
        Some(Self {
            point: runs.first()?.point.clone(),
            status,
            reused: runs.iter().all(|run| run.reused),
            metrics: metrics.map(with_messages),
            samples: Some(SamplesAnswer {
                succeeded: succeeded as u64,
                failed: failed as u64,
                half_intervals: half_intervals.unwrap_or_else(|| Map::new().into()),
            }),
            error: runs.iter().find_map(|run| run.error.clone()).filter(|_| status == PointStatus::Failed),
        })
    }
}

/// The statistic of each number below a pointer, and half of its interval; `None` where no sample has a number.
fn over(statistic: Statistic, samples: &[&Value], pointer: &str) -> Option<(Value, Value)> {
    let parts = || samples.iter().filter_map(|metrics| metrics.pointer(pointer));
    let names: BTreeSet<&String> = parts().filter_map(Value::as_object).flat_map(Map::keys).collect();
    if names.is_empty() {
        let values: Vec<Option<f64>> =
            samples.iter().map(|metrics| uncertain(metrics, pointer).map(|(value, _)| value)).collect();
        let (value, half_interval) = over_samples(statistic, pointer, &values)?;
        return Some((value.into(), half_interval.map_or(Value::Null, Value::from)));
    }
    let (mut numbers, mut half_intervals) = (Map::new(), Map::new());
    for name in names {
        let Some((number, half_interval)) = over(statistic, samples, &format!("{pointer}/{}", escape(name))) else {
            continue;
        };
        numbers.insert(name.clone(), number);
        if !half_interval.is_null() {
            half_intervals.insert(name.clone(), half_interval);
        }
    }
    (!numbers.is_empty()).then(|| (numbers.into(), half_intervals.into()))
}

/// The first message of each code.
fn messages(samples: &[&Value]) -> Value {
    let mut first: Vec<&Value> = Vec::new();
    for message in samples.iter().filter_map(|metrics| metrics["messages"].as_array()).flatten() {
        if !first.iter().any(|known| known["code"] == message["code"]) {
            first.push(message);
        }
    }
    first.into_iter().cloned().collect()
}
