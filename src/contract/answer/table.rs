//! The table of a study: a row for each point, the best points, and the trend of each metric along the axis.

use std::collections::BTreeMap;

use raceway_core::study::{self, Goal};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::point::{PointEnd, PointError, PointStatus, SamplesAnswer};
use super::uncertainty::{is_best_at_zero, uncertain};
use crate::contract::job::axis::AxisValue;
use crate::contract::job::statistic::{StatisticChoice, StatisticInput};
use crate::contract::job::study::{Layout, Study};
use crate::contract::json::problem::escape;

/// Column of the codes of the warnings of a point.
const WARNINGS: &str = "/messages/warning";

/// The response of `GET …/table`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableAnswer {
    /// The axes and their values.
    pub axes: Vec<AxisAnswer>,
    /// Number of points of the grid.
    pub points: u64,
    /// Statistic of the metrics over uncertain inputs; absent without these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<StatisticChoice>)]
    pub statistic: Option<StatisticInput>,
    /// Number of points that have succeeded or failed.
    pub ended: u64,
    /// Number of points that have succeeded.
    pub succeeded: u64,
    /// One row for each point, the last axis changing fastest; of an uncertainty job the nominal point, then the sampled ones.
    pub rows: Vec<Row>,
    /// The best point by each metric that has a best value, by the metric's pointer; empty for an uncertainty job.
    pub best: BTreeMap<String, BestAnswer>,
    /// Trend of each of these metrics along the axis; empty for several axes.
    pub trends: BTreeMap<String, TrendAnswer>,
}

/// An axis of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AxisAnswer {
    /// Path into the scene, or derived quantity.
    #[schema(example = "/bearing/inner_groove_curvature")]
    pub axis: String,
    /// The values, numbers or names.
    #[schema(value_type = Vec<AxisValue>)]
    pub values: Vec<Value>,
}

/// A point with its metrics or its error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Row {
    /// Value by axis.
    #[schema(value_type = BTreeMap<String, AxisValue>)]
    pub point: Map<String, Value>,
    /// Status of the point.
    pub status: PointStatus,
    /// True if the metrics are those of an identical finished simulation.
    #[serde(default)]
    pub reused: bool,
    /// The metrics of the simulation, without `lines` and `left_out`; present once it has succeeded. With uncertain inputs the `statistic` of each number over
    /// the samples, once all of them have ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<BTreeMap<String, Value>>)]
    pub metrics: Option<Value>,
    /// Statistics of the samples of the point; absent without uncertain inputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub samples: Option<SamplesAnswer>,
    /// Reason why the point has no metrics.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub error: Option<PointError>,
}

/// The best point by a metric.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BestAnswer {
    /// Value by axis.
    #[schema(value_type = BTreeMap<String, AxisValue>)]
    pub point: Map<String, Value>,
    /// The metric at this point, in its own unit.
    pub value: f64,
    /// Which value is the best: `minimum`, `maximum`, or `nearest_zero` (the smallest magnitude: cage slip has either sign).
    #[schema(example = "minimum")]
    pub goal: String,
    /// Estimated error of the value; absent where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Number of points that may be as good, the best included: they differ from it by at most both errors together, or their own error
    /// is unknown. Absent where the error of the best is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 1)]
    pub as_good: Option<u64>,
    /// First and last value of these points on each axis, in the order of the axis. Absent where `as_good` is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<BTreeMap<String, Vec<AxisValue>>>)]
    pub within: Option<Map<String, Value>>,
}

/// Trend of a metric along an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TrendAnswer {
    /// Largest value minus smallest value.
    #[schema(minimum = 0)]
    pub span: f64,
    /// Largest estimated error of a point; absent where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// True if the estimated error of each point is less than a tenth of the span; absent where the errors are unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub resolved: Option<bool>,
    /// Rank correlation with the axis: 1 for a metric that only rises, −1 for one that only falls.
    #[schema(minimum = -1, maximum = 1)]
    pub monotony: f64,
}

impl Row {
    /// The row of a simulation that has not started.
    pub fn queued(study: &Study, number: usize) -> Self {
        Self {
            point: named(study, number / study.samples()),
            status: PointStatus::Queued,
            reused: false,
            metrics: None,
            samples: None,
            error: None,
        }
    }

    /// The row with the end of its point.
    pub fn ended(self, end: PointEnd) -> Self {
        match end {
            PointEnd::Succeeded(metrics) => Self { status: PointStatus::Succeeded, metrics: Some(metrics), ..self },
            PointEnd::Failed(error) => Self { status: PointStatus::Failed, error: Some(error), ..self },
        }
    }
}

fn named(study: &Study, point: usize) -> Map<String, Value> {
    study.axes.iter().zip(study.values(point)).map(|(axis, value)| (axis.varied.name.clone(), value.clone())).collect()
}

impl TableAnswer {
    /// From the rows of all simulations, in the order of the grid.
    pub fn of(study: &Study, rows: Vec<Row>) -> Self {
        let rows = match &study.robust {
            None => rows,
            Some(robust) => {
                rows.chunks(study.samples()).filter_map(|runs| Row::over_samples(robust.statistic, runs)).collect()
            }
        };
        let count = |wanted: &[PointStatus]| rows.iter().filter(|row| wanted.contains(&row.status)).count() as u64;
        let mut best = BTreeMap::new();
        let mut trends = BTreeMap::new();
        // Of sampled points none is the best, and they are in no order.
        let compared = if matches!(study.layout, Layout::Grid(_)) { with_best(&rows) } else { Vec::new() };
        for (pointer, best_value) in compared {
            let values: Vec<_> = rows.iter().map(|row| row.uncertain(&pointer)).collect();
            if let Some(found) = best_value.of(&values) {
                best.insert(pointer.clone(), best_answer(study, &found, &values, best_value));
            }
            if let ([_], Some(trend)) = (&study.axes[..], study::trend(&values)) {
                let (span, error, resolved) = (trend.span, trend.error, trend.is_resolved());
                trends.insert(pointer, TrendAnswer { span, error, resolved, monotony: trend.monotony });
            }
        }
        Self {
            axes: study
                .axes
                .iter()
                .map(|axis| AxisAnswer { axis: axis.varied.name.clone(), values: axis.values.clone() })
                .collect(),
            points: rows.len() as u64,
            statistic: study.robust.as_ref().map(|robust| robust.given_statistic.clone()),
            ended: count(&[PointStatus::Succeeded, PointStatus::Failed]),
            succeeded: count(&[PointStatus::Succeeded]),
            rows,
            best,
            trends,
        }
    }

    /// A metric of each point and its estimated error; `None` for points without it.
    pub fn column(&self, pointer: &str) -> Vec<Option<(f64, Option<f64>)>> {
        self.rows.iter().map(|row| row.uncertain(pointer)).collect()
    }

    /// Pointers to the text fields of the metrics that a table shows, where any point has them.
    pub fn text_columns(&self) -> Vec<&'static str> {
        const TEXTS: [&str; 4] = ["/solver/rung", "/solver/method", "/accuracy/motion", WARNINGS];
        let has = |text: &&str| self.rows.iter().any(|row| row.text(text).is_some());
        TEXTS.into_iter().filter(has).collect()
    }

    /// Pointers to all numbers of the metrics, in the order of the metrics.
    pub fn columns(&self) -> Vec<String> {
        let mut columns = Vec::new();
        for metrics in self.rows.iter().filter_map(|row| row.metrics.as_ref()) {
            numbers(metrics, String::new(), &mut |pointer, _| {
                if !columns.contains(&pointer) {
                    columns.push(pointer);
                }
            });
        }
        columns
    }
}

impl Row {
    /// A metric and its estimated error: of the integration, or over samples half of the statistic's interval.
    pub fn uncertain(&self, pointer: &str) -> Option<study::Uncertain> {
        let metrics = self.metrics.as_ref()?;
        match &self.samples {
            None => uncertain(metrics, pointer),
            Some(samples) => {
                let half_interval = samples.half_intervals.pointer(pointer).and_then(Value::as_f64);
                Some((metrics.pointer(pointer)?.as_f64()?, half_interval))
            }
        }
    }

    /// The text of a column.
    pub fn text(&self, column: &str) -> Option<String> {
        let metrics = self.metrics.as_ref()?;
        if column != WARNINGS {
            return metrics.pointer(column)?.as_str().map(str::to_owned);
        }
        let is_warning = |message: &&Value| message["severity"] == "warning";
        let messages = metrics["messages"].as_array()?.iter().filter(is_warning);
        let codes: Vec<&str> = messages.filter_map(|message| message["code"].as_str()).collect();
        (!codes.is_empty()).then(|| codes.join(" "))
    }
}

fn best_answer(study: &Study, found: &study::Best, values: &[Option<study::Uncertain>], best: Best) -> BestAnswer {
    let within = |points: &Vec<usize>| {
        let ends = study.axes.iter().enumerate().map(|(number, axis)| {
            let places = || points.iter().map(|point| study.places(*point)[number]);
            let ends = [places().min(), places().max()].map(|place| axis.values[place.unwrap_or(0)].clone());
            (axis.varied.name.clone(), ends.to_vec().into())
        });
        ends.collect()
    };
    let (value, error) = values[found.point].unwrap_or((found.value, None));
    BestAnswer {
        point: named(study, found.point),
        value,
        goal: best.name().to_owned(),
        error,
        as_good: found.as_good.as_ref().map(|points| points.len() as u64),
        within: found.as_good.as_ref().map(within),
    }
}

/// The best value of a metric.
#[derive(Debug, Clone, Copy)]
enum Best {
    Least,
    Largest,
    /// For a metric of either sign whose best value is 0.
    NearestZero,
}

impl Best {
    fn name(self) -> &'static str {
        match self {
            Self::Least => "minimum",
            Self::Largest => "maximum",
            Self::NearestZero => "nearest_zero",
        }
    }

    fn of(self, values: &[Option<study::Uncertain>]) -> Option<study::Best> {
        match self {
            Self::Least => study::best(values, Goal::Least),
            Self::Largest => study::best(values, Goal::Largest),
            Self::NearestZero => {
                let magnitudes: Vec<_> =
                    values.iter().map(|value| value.map(|(value, error)| (value.abs(), error))).collect();
                study::best(&magnitudes, Goal::Least)
            }
        }
    }
}

/// Metrics that have a best value, by pointer.
fn with_best(rows: &[Row]) -> Vec<(String, Best)> {
    const LEAST: [&str; 9] = [
        "rms",
        "peak",
        "crest_factor",
        "kurtosis",
        "level_db",
        "max_load_n",
        "max_pressure_mpa",
        "max_slip_m_s",
        "orbit_radius_um",
    ];
    let mut found: Vec<(String, Best)> = Vec::new();
    for metrics in rows.iter().filter_map(|row| row.metrics.as_ref()) {
        numbers(metrics, String::new(), &mut |pointer, _| {
            let name = pointer.rsplit('/').next().unwrap_or_default();
            let best = match name {
                "min_film_thickness_um" => Best::Largest,
                _ if is_best_at_zero(&pointer) => Best::NearestZero,
                name if LEAST.contains(&name) => Best::Least,
                _ => return,
            };
            if !found.iter().any(|(known, _)| *known == pointer) {
                found.push((pointer, best));
            }
        });
    }
    found
}

/// Calls `found` with each number and its pointer.
fn numbers(value: &Value, pointer: String, found: &mut impl FnMut(String, f64)) {
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(key, field)| numbers(field, format!("{pointer}/{}", escape(key)), found));
        }
        Value::Number(number) => found(pointer, number.as_f64().unwrap_or(f64::NAN)),
        _ => {}
    }
}
