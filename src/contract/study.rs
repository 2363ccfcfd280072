//! A study: a scene and the axes along which it is varied. A point of the grid is a simulation of its own, made from the request
//! as if it had said the point's values.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use utoipa::ToSchema;

use super::filling::Filling;
use super::job::{Job, JobInput, JobKind, simulation_of};
use super::problem::{FieldError, Refusal, escape, listed};
use super::strict::{self, object};
use crate::physics::rating::dynamic_load_rating;
use crate::study::Grid;

const MOST_AXES: usize = 4;
const MOST_POINTS: usize = 10_000;
/// Significant digits of values that are computed: what rounding adds is nobody's wish.
const DIGITS: usize = 9;

/// What is varied: a field of the scene, or a quantity made of several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"path": "/bearing/inner_groove_curvature", "values": [0.515, 0.52, 0.53]}))]
pub struct AxisInput {
    /// JSON pointer from the scene to the field; either this or `quantity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, max_length = 200, example = "/bearing/inner_groove_curvature")]
    pub path: Option<String>,
    /// `axial_load_over_rating`: the axial load as a share of the dynamic load rating.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<QuantityName>)]
    pub quantity: Option<String>,
    /// The values, numbers or words; either these or `from`, `to` and `count`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<Vec<AxisValue>>, min_items = 1, max_items = 10000)]
    pub values: Option<Vec<Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.51)]
    pub from: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.54)]
    pub to: Option<f64>,
    /// Number of values, ends included.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "strict::whole_number::<_, 2, { MOST_POINTS as u32 }>"
    )]
    #[schema(nullable = false, minimum = 2, maximum = 10000, example = 7)]
    pub count: Option<u32>,
    /// Default `linear`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<ScaleName>)]
    pub scale: Option<String>,
}

/// Quantities that an axis can vary.
#[derive(ToSchema)]
#[schema(rename_all = "snake_case")]
pub enum QuantityName {
    AxialLoadOverRating,
}

/// How the values of an axis are spaced.
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

/// What an axis sets.
#[derive(Debug, Clone, PartialEq)]
enum Target {
    /// A field of the scene, by reference tokens.
    Field(Vec<String>),
    AxialLoadOverRating,
}

/// An axis, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Pointer or quantity, as in the request.
    pub name: String,
    target: Target,
    pub values: Vec<Value>,
}

/// The study of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    pub axes: Vec<Axis>,
    pub grid: Grid,
    /// Number of points.
    pub points: usize,
    /// Whether the results of identical finished work may answer points.
    reuse: bool,
    /// The request without what belongs to the study alone.
    base: Value,
    /// The scene of the request with every default.
    complete: Value,
}

const AXIAL_LOAD_OVER_RATING: &str = "axial_load_over_rating";

/// The axes of a request and their number of points.
pub fn axes(input: &mut JobInput, filling: &mut Filling) -> (Vec<Axis>, usize) {
    let given = input.axes.take().unwrap_or_default();
    if given.is_empty() || given.len() > MOST_AXES {
        filling.refuse("/axes", format!("{} axes: must be from 1 to {MOST_AXES}", given.len()));
        return (Vec::new(), 0);
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (number, axis) in given.into_iter().enumerate() {
        let pointer = format!("/axes/{number}");
        let Some(axis) = axis_of(axis.0, &pointer, filling) else { continue };
        if axes.iter().any(|other| other.name == axis.name) {
            filling.refuse(pointer, format!("`{}` is varied by another axis already", axis.name));
        } else {
            axes.push(axis);
        }
    }
    let points = Grid::new(axes.iter().map(|axis| axis.values.len()).collect()).points();
    match points.filter(|points| *points <= MOST_POINTS) {
        Some(points) => (axes, points),
        None => {
            let product = points.map_or("more".to_owned(), |points| points.to_string());
            filling.refuse("/axes", format!("a grid of {product} points: at most {MOST_POINTS}"));
            (axes, 0)
        }
    }
}

fn axis_of(axis: AxisInput, pointer: &str, filling: &mut Filling) -> Option<Axis> {
    let at = |field: &str| format!("{pointer}/{field}");
    let (name, target) = match (axis.path, axis.quantity) {
        (Some(path), None) => match tokens(&path) {
            Some(tokens) => (path, Target::Field(tokens)),
            None => {
                filling.refuse(at("path"), "must be a JSON pointer into the scene, such as `/spindle/mass_kg`");
                return None;
            }
        },
        (None, Some(quantity)) if quantity == AXIAL_LOAD_OVER_RATING => (quantity, Target::AxialLoadOverRating),
        (None, Some(quantity)) => {
            let quantity: String = quantity.chars().take(100).collect();
            filling.refuse(
                at("quantity"),
                format!("no quantity is called `{quantity}`; there is `{AXIAL_LOAD_OVER_RATING}`"),
            );
            return None;
        }
        _ => {
            filling.refuse(pointer, "takes either `path` or `quantity`");
            return None;
        }
    };
    let values = match (axis.values, axis.from, axis.to, axis.count) {
        (Some(values), None, None, None) => {
            if axis.scale.is_some() {
                filling.refuse(at("scale"), "goes with `from`, `to` and `count`, not with `values`");
            }
            listed_values(values, &at("values"), filling)?
        }
        (None, Some(from), Some(to), Some(count)) => {
            spaced(from, to, count, axis.scale.as_deref().unwrap_or("linear"), pointer, filling)?
        }
        _ => {
            filling.refuse(pointer, "takes either `values` or all of `from`, `to` and `count`");
            return None;
        }
    };
    if target != Target::AxialLoadOverRating || values.iter().all(Value::is_number) {
        return Some(Axis { name, target, values });
    }
    filling.refuse(at("values"), format!("`{name}` takes numbers"));
    None
}

/// Reference tokens of a pointer to a field; `None` of no such pointer.
fn tokens(path: &str) -> Option<Vec<String>> {
    let tokens: Vec<String> =
        path.strip_prefix('/')?.split('/').map(|t| t.replace("~1", "/").replace("~0", "~")).collect();
    tokens.iter().all(|token| !token.is_empty()).then_some(tokens)
}

fn listed_values(values: Vec<Value>, pointer: &str, filling: &mut Filling) -> Option<Vec<Value>> {
    if values.is_empty() || values.len() > MOST_POINTS {
        filling.refuse(pointer, format!("{} values: must be from 1 to {MOST_POINTS}", values.len()));
        return None;
    }
    for (place, value) in values.iter().enumerate() {
        if !(value.is_number() || value.is_string()) {
            filling.refuse(format!("{pointer}/{place}"), "must be a number or a word");
            return None;
        }
        if values[..place].contains(value) {
            filling.refuse(format!("{pointer}/{place}"), "given more than once");
            return None;
        }
    }
    Some(values)
}

fn spaced(from: f64, to: f64, count: u32, scale: &str, pointer: &str, filling: &mut Filling) -> Option<Vec<Value>> {
    let mut refuse = |field: &str, detail: String| filling.refuse(format!("{pointer}/{field}"), detail);
    if !(2..=MOST_POINTS as u32).contains(&count) {
        refuse("count", format!("{count}: must be from 2 to {MOST_POINTS}"));
        return None;
    }
    if from == to {
        refuse("to", "the same as `from`".to_owned());
        return None;
    }
    let share = |k: u32| f64::from(k) / f64::from(count - 1);
    let value: Box<dyn Fn(u32) -> f64> = match scale {
        "linear" => Box::new(move |k| from + share(k) * (to - from)),
        "log" if from > 0.0 && to > 0.0 => Box::new(move |k| from * (to / from).powf(share(k))),
        "log" => {
            refuse("scale", "`log` needs `from` and `to` above 0".to_owned());
            return None;
        }
        other => {
            let other: String = other.chars().take(100).collect();
            refuse("scale", format!("no scale is called `{other}`; scales are {}", listed(["linear", "log"])));
            return None;
        }
    };
    let rounded = |k: u32| match k {
        0 => from,
        k if k == count - 1 => to,
        k => super::units::significant(value(k), DIGITS),
    };
    Some((0..count).map(|k| Value::from(rounded(k))).collect())
}

/// Fields that only a study takes.
pub fn refuse_in(kind: JobKind, input: &JobInput, filling: &mut Filling) {
    if input.axes.is_some() {
        filling.refuse("/axes", format!("goes with the kind `study`, not with `{}`", kind.name()));
    }
}

/// Fields that a study does not take.
pub fn refuse_foreign(input: &JobInput, filling: &mut Filling) {
    let outputs = input.outputs.clone().unwrap_or_default();
    for (pointer, given) in [("/outputs/spectra", outputs.spectra), ("/outputs/series", outputs.series)] {
        if given.is_some_and(|channels| !channels.is_empty()) {
            filling.refuse(pointer, "a job of kind `study` keeps no signals: run the point as a simulation");
        }
    }
}

impl Study {
    /// A study whose axes are checked, of a request whose scene with every default is `complete`. Refused where none of the points
    /// next to the first can be built: then it is the axes that are wrong.
    pub fn new(axes: Vec<Axis>, points: usize, request: &Value, complete: Value) -> Result<Self, Refusal> {
        let mut base = request.clone();
        if let Value::Object(fields) = &mut base {
            for field in ["axes", "labels", "priority", "reuse", "keep_for_s"] {
                fields.remove(field);
            }
            fields.insert("kind".into(), JobKind::Simulation.name().into());
            let outputs = fields.entry("outputs").or_insert_with(|| Value::Object(Map::new()));
            outputs["spectra"] = json!([]);
        }
        let grid = Grid::new(axes.iter().map(|axis| axis.values.len()).collect());
        let reuse = request.get("reuse").and_then(Value::as_bool).unwrap_or(true);
        let study = Self { axes, grid, points, reuse, base, complete };
        study.probe()?;
        Ok(study)
    }

    /// Whether any of some points spread over the grid can be built.
    fn probe(&self) -> Result<(), Refusal> {
        const PROBES: usize = 64;
        let probes = self.points.min(PROBES);
        let mut first = None;
        for k in 0..probes {
            match self.point(k * (self.points - 1) / (probes - 1).max(1)) {
                Ok(_) => return Ok(()),
                Err(refusal) => first = first.or(Some(refusal)),
            }
        }
        match first {
            Some(Refusal::Invalid { errors }) => {
                let at_point =
                    |error: FieldError| FieldError::new(error.pointer, format!("at the first point: {}", error.detail));
                Err(Refusal::Invalid { errors: errors.into_iter().map(at_point).collect() })
            }
            Some(other) => Err(other),
            None => Ok(()),
        }
    }

    /// Whether the results of identical finished work may answer points.
    pub fn reuses(&self) -> bool {
        self.reuse
    }

    /// Values of a point, axis by axis.
    pub fn values(&self, point: usize) -> Vec<&Value> {
        self.grid.places(point).into_iter().zip(&self.axes).map(|(place, axis)| &axis.values[place]).collect()
    }

    /// The simulation of a point.
    pub fn point(&self, point: usize) -> Result<Job, Refusal> {
        let mut request = self.base.clone();
        let mut load_over_rating = None;
        for (axis, value) in self.axes.iter().zip(self.values(point)) {
            match &axis.target {
                Target::Field(tokens) => set(&mut request["scene"], &self.complete, tokens, value.clone())
                    .map_err(|detail| FieldError::new(format!("/scene{}", axis.name), detail))?,
                Target::AxialLoadOverRating => load_over_rating = value.as_f64(),
            }
        }
        if let Some(share) = load_over_rating {
            // The rating follows from what the other axes have made of the bearing.
            let rating = dynamic_load_rating(&simulation_of(request.clone())?.scene().bearing);
            request["scene"]["operation"]["axial_load_n"] = (share * rating).into();
        }
        simulation_of(request)
    }

    /// What decides over the results, as JSON.
    pub fn canonical(&self) -> Value {
        let axes = self.axes.iter().map(|axis| json!({"axis": axis.name, "values": axis.values}));
        json!({ "base": self.base, "axes": axes.collect::<Vec<_>>() })
    }
}

/// Parts of a scene that fill themselves in around a field.
const OPEN_PARTS: [&str; 3] = ["operation", "spindle", "terms"];

/// Sets a field of a scene. Where the way to it leads through a name, or through nothing, the part stands there with its defaults,
/// as `complete` has it; of a bearing by name, and of the parts that stand open, only the field is given, so that what follows
/// from it still follows.
fn set(scene: &mut Value, complete: &Value, tokens: &[String], value: Value) -> Result<(), String> {
    let Some((field, way)) = tokens.split_last() else { return Err("no field".to_owned()) };
    let (mut at, mut filled, mut path) = (scene, Some(complete), String::new());
    for (depth, token) in way.iter().enumerate() {
        path += &format!("/{}", escape(token));
        filled = filled.and_then(|part| part.get(token));
        let Value::Object(fields) = at else { return Err(format!("`{path}` is no object")) };
        let next = fields.entry(token.as_str()).or_insert(Value::Null);
        if let Value::String(name) = next
            && depth == 0
            && token == "bearing"
        {
            *next = json!({ "preset": name });
        } else if next.is_null() && depth == 0 && OPEN_PARTS.contains(&token.as_str()) {
            *next = json!({});
        } else if !next.is_object() && !next.is_array() {
            *next =
                filled.filter(|part| part.is_object()).cloned().ok_or_else(|| format!("the scene has no `{path}`"))?;
        }
        at = next;
    }
    match at {
        Value::Object(fields) => {
            fields.insert(field.clone(), value);
            Ok(())
        }
        Value::Array(items) => match field.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
            Some(item) => {
                *item = value;
                Ok(())
            }
            None => Err(format!("`{path}` has no item {field}")),
        },
        _ => Err(format!("`{path}` is no object")),
    }
}

/// An axis of a request: an object, in whose place an array is refused.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(transparent)]
#[schema(value_type = AxisInput)]
pub struct StrictAxis(pub AxisInput);

impl<'de> Deserialize<'de> for StrictAxis {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        object(deserializer).map(Self)
    }
}
