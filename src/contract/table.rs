//! The table of a study: a row a point, the best points, and how each metric changes along the axis.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::execute::RunFailure;
use super::metrics::Metrics;
use super::problem::{FieldError, Refusal, escape};
use super::study::{AxisValue, Study};
use crate::study::{self, Goal};

/// Parts of the metrics that are no numbers of the point: a table of them all would be large.
const LEFT_AWAY: [&str; 2] = ["lines", "left_out"];
/// Column of the codes of the warnings of a point.
const WARNINGS: &str = "/messages/warning";

/// The answer of `GET …/table`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableAnswer {
    /// What is varied, with the values of each axis.
    pub axes: Vec<AxisAnswer>,
    /// Points of the grid.
    pub points: u64,
    /// Points that have ended, in whatever way.
    pub ended: u64,
    /// Points that have succeeded.
    pub succeeded: u64,
    /// A row a point, the last axis changing fastest.
    pub rows: Vec<Row>,
    /// The best point by each metric that has a better end, by the metric's pointer.
    pub best: BTreeMap<String, BestAnswer>,
    /// How each of these metrics changes along the axis; empty where there are several axes.
    pub trends: BTreeMap<String, TrendAnswer>,
}

/// An axis of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AxisAnswer {
    /// Path into the scene, or quantity.
    #[schema(example = "/bearing/inner_groove_curvature")]
    pub axis: String,
    /// The values along it, numbers or words.
    #[schema(value_type = Vec<AxisValue>)]
    pub values: Vec<Value>,
}

/// A point and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Row {
    /// Value by axis.
    #[schema(value_type = BTreeMap<String, AxisValue>)]
    pub point: Map<String, Value>,
    /// Where the point stands.
    pub status: PointStatus,
    /// Whether the result of identical finished work answered the point.
    #[serde(default)]
    pub reused: bool,
    /// The metrics of the simulation, without lines and what was left out; present once it has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<BTreeMap<String, Value>>)]
    pub metrics: Option<Value>,
    /// Why it has no metrics.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub error: Option<PointError>,
}

/// Where a point stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PointStatus {
    Queued,
    Running,
    Succeeded,
    Failed,
    /// Its study was cancelled before its end; a resumed one goes on with it.
    Cancelled,
}

/// Why a point has no metrics.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PointError {
    /// One word for programs: that of a failed job, or `invalid` where the scene cannot be built.
    #[schema(example = "numerical-blowup")]
    pub cause: String,
    /// What happened, in words.
    pub detail: String,
    /// The wrong fields of a scene that cannot be built.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<FieldError>,
}

/// The best point by a metric.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BestAnswer {
    /// Value by axis.
    #[schema(value_type = BTreeMap<String, AxisValue>)]
    pub point: Map<String, Value>,
    /// The metric there, in its own unit.
    pub value: f64,
    /// Which value is the best: the least (`minimum`), the largest (`maximum`), or the one of least magnitude (`nearest_zero`: the
    /// cage's slip, which has either sign).
    #[schema(example = "minimum")]
    pub goal: String,
    /// Estimated error of the value; absent where nobody knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Number of points that may be as good, the best among them: they differ from it by no more than both errors together, or
    /// their own error is not known. Absent where the error of the best is not known: then nobody can tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 1)]
    pub as_good: Option<u64>,
    /// Where these lie, by axis: values from … to, in the order of the axis. Absent as `as_good` is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<BTreeMap<String, Vec<AxisValue>>>)]
    pub within: Option<Map<String, Value>>,
}

/// How a metric changes along an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TrendAnswer {
    /// Largest value less the least one.
    #[schema(minimum = 0)]
    pub span: f64,
    /// Largest estimated error of a point; absent where nobody knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Whether no point is wrong by more than a tenth of the span; absent where the errors are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub resolved: Option<bool>,
    /// Rank correlation with the axis: 1 where the metric only rises, −1 where it only falls.
    #[schema(minimum = -1, maximum = 1)]
    pub monotony: f64,
}

/// What became of a point.
#[derive(Debug, Clone, PartialEq)]
pub enum PointEnd {
    Succeeded(Value),
    Failed(PointError),
}

impl PointEnd {
    /// Of a simulation.
    pub fn of(metrics: &Metrics) -> Self {
        Self::of_stored(serde_json::to_value(metrics).unwrap_or_default())
    }

    /// Of the metrics of a simulation as they are stored.
    pub fn of_stored(mut metrics: Value) -> Self {
        if let Value::Object(fields) = &mut metrics {
            LEFT_AWAY.iter().for_each(|part| drop(fields.remove(*part)));
        }
        Self::Succeeded(metrics)
    }
}

impl From<RunFailure> for PointError {
    fn from(failure: RunFailure) -> Self {
        let (cause, detail) = match failure {
            RunFailure::Cancelled => ("cancelled", "the run was told to stop".to_owned()),
            RunFailure::Failed { cause, detail } => (cause, detail),
        };
        Self { cause: cause.to_owned(), detail, errors: Vec::new() }
    }
}

impl From<Refusal> for PointError {
    fn from(refusal: Refusal) -> Self {
        let detail = refusal.to_string();
        let errors = if let Refusal::Invalid { errors } = refusal { errors } else { Vec::new() };
        Self { cause: "invalid".to_owned(), detail, errors }
    }
}

impl Row {
    /// A point of a study, not begun.
    pub fn queued(study: &Study, point: usize) -> Self {
        Self { point: named(study, point), status: PointStatus::Queued, reused: false, metrics: None, error: None }
    }

    /// The same with its end.
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
    /// Of the rows of all points, in their order.
    pub fn of(study: &Study, rows: Vec<Row>) -> Self {
        let count = |wanted: &[PointStatus]| rows.iter().filter(|row| wanted.contains(&row.status)).count() as u64;
        let mut best = BTreeMap::new();
        let mut trends = BTreeMap::new();
        for (pointer, wish) in wished_for(&rows) {
            let values: Vec<_> = rows.iter().map(|row| uncertain(row.metrics.as_ref()?, &pointer)).collect();
            if let Some(found) = wish.best(&values) {
                best.insert(pointer.clone(), best_answer(study, &found, &values, wish));
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
            ended: count(&[PointStatus::Succeeded, PointStatus::Failed]),
            succeeded: count(&[PointStatus::Succeeded]),
            rows,
            best,
            trends,
        }
    }

    /// A metric of every point, where it is known, with its estimated error.
    pub fn column(&self, pointer: &str) -> Vec<Option<(f64, Option<f64>)>> {
        self.rows.iter().map(|row| uncertain(row.metrics.as_ref()?, pointer)).collect()
    }

    /// Columns that tell on what the numbers of a point rest, where any point has them: pointers, and the codes of its warnings.
    pub fn words(&self) -> Vec<&'static str> {
        const WORDS: [&str; 4] = ["/solver/rung", "/solver/method", "/accuracy/motion", WARNINGS];
        let has = |word: &&str| self.rows.iter().any(|row| row.word(word).is_some());
        WORDS.into_iter().filter(has).collect()
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
    /// The cell of a column of words.
    pub fn word(&self, column: &str) -> Option<String> {
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

fn best_answer(study: &Study, found: &study::Best, values: &[Option<study::Uncertain>], wish: Wish) -> BestAnswer {
    let within = |points: &Vec<usize>| {
        let ends = study.axes.iter().enumerate().map(|(number, axis)| {
            let places = || points.iter().map(|point| study.grid.places(*point)[number]);
            let ends = [places().min(), places().max()].map(|place| axis.values[place.unwrap_or(0)].clone());
            (axis.varied.name.clone(), ends.to_vec().into())
        });
        ends.collect()
    };
    let (value, error) = values[found.point].unwrap_or((found.value, None));
    BestAnswer {
        point: named(study, found.point),
        value,
        goal: wish.name().to_owned(),
        error,
        as_good: found.as_good.as_ref().map(|points| points.len() as u64),
        within: found.as_good.as_ref().map(within),
    }
}

/// Which end of a metric is the better one.
#[derive(Debug, Clone, Copy)]
enum Wish {
    Least,
    Largest,
    /// Of a metric that has either sign and is best at 0.
    NearestZero,
}

impl Wish {
    fn name(self) -> &'static str {
        match self {
            Self::Least => "minimum",
            Self::Largest => "maximum",
            Self::NearestZero => "nearest_zero",
        }
    }

    fn best(self, values: &[Option<study::Uncertain>]) -> Option<study::Best> {
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

/// Metrics that have a better end, by pointer.
fn wished_for(rows: &[Row]) -> Vec<(String, Wish)> {
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
    let mut wished: Vec<(String, Wish)> = Vec::new();
    for metrics in rows.iter().filter_map(|row| row.metrics.as_ref()) {
        numbers(metrics, String::new(), &mut |pointer, _| {
            let name = pointer.rsplit('/').next().unwrap_or_default();
            let wish = match name {
                "min_film_thickness_um" => Wish::Largest,
                "cage_slip" => Wish::NearestZero,
                name if LEAST.contains(&name) => Wish::Least,
                _ => return,
            };
            if !wished.iter().any(|(known, _)| *known == pointer) {
                wished.push((pointer, wish));
            }
        });
    }
    wished
}

/// A metric with its error: that of the level along its axis for all that follows from the vibration, those of the largest loads, the largest
/// slip and the cage speed for these and for what follows from them.
pub fn uncertain(metrics: &Value, pointer: &str) -> Option<study::Uncertain> {
    let value = metrics.pointer(pointer)?.as_f64()?;
    let accuracy = |field: &str| metrics.pointer(&format!("/accuracy/{field}")).and_then(Value::as_f64);
    let name = pointer.rsplit('/').next().unwrap_or_default();
    // Of the acceleration along the same axis, or the worst of all where that is not judged.
    let of_level = || {
        let axis = pointer.strip_prefix("/channels/spindle.").and_then(|rest| rest.split('.').next())?;
        metrics.pointer(&format!("/channels/spindle.{axis}.acceleration/level_error_db"))?.as_f64()
    };
    let level_error = || of_level().or_else(|| accuracy("level_error_db"));
    let error = match name {
        "level_db" => level_error(),
        "rms" => level_error().map(|db| value * (10_f64.powf(db / 20.0) - 1.0)),
        "max_load_n" if pointer.contains("pocket") => accuracy("max_pocket_load_error").map(|share| share * value),
        "max_load_n" => accuracy("max_load_error").map(|share| share * value),
        // With the third root of the load.
        "max_pressure_mpa" => accuracy("max_load_error").map(|share| share * value / 3.0),
        "orbit_radius_um" => accuracy("orbit_radius_error").map(|share| share * value),
        "max_slip_m_s" => accuracy("max_slip_error").map(|share| share * value),
        "cage_speed_hz" => accuracy("cage_speed_error").map(|share| share * value),
        // 1 − cage speed / ideal cage speed.
        "cage_slip" => accuracy("cage_speed_error").map(|share| share * (1.0 - value).abs()),
        _ => None,
    };
    Some((value, error))
}

/// Calls with each number and its pointer.
fn numbers(value: &Value, pointer: String, found: &mut impl FnMut(String, f64)) {
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(key, field)| numbers(field, format!("{pointer}/{}", escape(key)), found));
        }
        Value::Number(number) => found(pointer, number.as_f64().unwrap_or(f64::NAN)),
        _ => {}
    }
}
