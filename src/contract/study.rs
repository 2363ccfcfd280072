//! A study: a scene and the axes along which it is varied. A point of the grid is a simulation of its own, made from the request
//! as if it had said the point's values.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;

use super::filling::Filling;
use super::job::{Job, JobInput, JobKind};
use super::problem::{FieldError, Refusal};
use super::strict::{self, MOST_FAULTS, object};
use super::variation::{LONGEST_NAME, Range, Variation, Varied, of_an_axis};
use crate::study::Grid;

const MOST_AXES: usize = 4;
const MOST_POINTS: usize = 10_000;
/// Values of a range that are checked at most, ends apart, spread over it.
const MOST_CHECKED: usize = 64;
/// Of one that lists its values, evenly spread, too; less of a scene so large that together they would be more than so many bytes
/// of JSON, but so many at least. What is not checked is found where its point is simulated.
const MOST_LISTED: usize = 512;
const CHECKED_BYTES: usize = 256 << 10;
const LEAST_CHECKED: usize = 8;

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
    /// First value; with `to` and, in a study, `count`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = 0.51)]
    pub from: Option<f64>,
    /// Last value.
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

/// An axis, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub varied: Varied,
    pub values: Vec<Value>,
    /// Place among the axes of the request.
    place: usize,
    /// Whether the request lists the values; else it has their ends.
    is_listed: bool,
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
    variation: Variation,
}

/// The axes of a request and their number of points.
pub fn axes(input: &mut JobInput, filling: &mut Filling) -> (Vec<Axis>, usize) {
    let axes = input.axes.take();
    let is_missing = axes.is_none();
    let given = axes.unwrap_or_default();
    if is_missing {
        filling.refuse("/axes", format!("required, but missing: 1 to {MOST_AXES} axes"));
        return (Vec::new(), 0);
    } else if given.is_empty() || given.len() > MOST_AXES {
        filling.refuse("/axes", format!("{} axes: must be from 1 to {MOST_AXES}", given.len()));
        return (Vec::new(), 0);
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (place, axis) in given.into_iter().enumerate() {
        let pointer = format!("/axes/{place}");
        let Some(axis) = axis_of(axis.0, place, filling) else { continue };
        if let Some(other) = axes.iter().find(|other| other.varied.overlaps(&axis.varied)) {
            filling.refuse(pointer, already_varied(&axis.varied, &other.varied));
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

/// Why an axis cannot stand beside another.
pub fn already_varied(varied: &Varied, other: &Varied) -> String {
    if varied.name == other.name {
        format!("`{}` is varied by another axis already", varied.name)
    } else {
        format!("`{}` sets what the axis `{}` sets, or a part of it", varied.name, other.name)
    }
}

fn axis_of(axis: AxisInput, place: usize, filling: &mut Filling) -> Option<Axis> {
    let pointer = &format!("/axes/{place}");
    let at = |field: &str| format!("{pointer}/{field}");
    let is_listed = axis.values.is_some();
    let varied = Varied::of(axis.path, axis.quantity, pointer, filling)?;
    let values = match (axis.values, axis.from, axis.to, axis.count) {
        (Some(values), None, None, None) => {
            if axis.scale.is_some() {
                filling.refuse(at("scale"), "goes with `from`, `to` and `count`, not with `values`");
            }
            listed_values(values, &at("values"), filling)?
        }
        (None, Some(from), Some(to), Some(count)) => {
            spaced(&Range::of(from, to, axis.scale.as_deref(), pointer, filling)?, count, pointer, filling)?
        }
        _ => {
            filling.refuse(pointer, "takes either `values` or all of `from`, `to` and `count`");
            return None;
        }
    };
    if varied.takes_words() || values.iter().all(Value::is_number) {
        return Some(Axis { varied, values, place, is_listed });
    }
    filling.refuse(at("values"), format!("`{}` takes numbers", varied.name));
    None
}

fn listed_values(values: Vec<Value>, pointer: &str, filling: &mut Filling) -> Option<Vec<Value>> {
    if values.is_empty() || values.len() > MOST_POINTS {
        filling.refuse(pointer, format!("{} values: must be from 1 to {MOST_POINTS}", values.len()));
        return None;
    }
    let known_errors = filling.errors.len();
    for (place, value) in values.iter().enumerate() {
        let same =
            |other: &Value| other == value || other.as_f64().is_some_and(|number| value.as_f64() == Some(number));
        let detail = if value.as_str().is_some_and(|word| word.chars().count() > LONGEST_NAME) {
            format!("more than {LONGEST_NAME} characters")
        } else if !(value.is_number() || value.is_string()) {
            "must be a number or a word".to_owned()
        } else if values[..place].iter().any(same) {
            "given more than once".to_owned()
        } else {
            continue;
        };
        filling.refuse(format!("{pointer}/{place}"), detail);
        if filling.errors.len() >= known_errors + MOST_FAULTS {
            break;
        }
    }
    (filling.errors.len() == known_errors).then_some(values)
}

fn spaced(range: &Range, count: u32, pointer: &str, filling: &mut Filling) -> Option<Vec<Value>> {
    if !(2..=MOST_POINTS as u32).contains(&count) {
        filling.refuse(format!("{pointer}/count"), format!("{count}: must be from 2 to {MOST_POINTS}"));
        return None;
    }
    let values: Vec<f64> = (0..count).map(|k| range.at(f64::from(k) / f64::from(count - 1))).collect();
    if values.windows(2).any(|pair| pair[0] == pair[1]) {
        filling.refuse(format!("{pointer}/to"), format!("too near to `from` for {count} values of nine digits"));
        return None;
    }
    Some(values.into_iter().map(Value::from).collect())
}

/// Refuses values that cannot be, each by itself beside the middle values of the other axes; of a range, some. Where one cannot be there, the first and
/// the last values of the others are tried, too: some values fit each other only in places, and the points elsewhere say so.
pub fn refuse_values(axes: &[Axis], variation: &Variation, filling: &mut Filling) {
    let most = filling.errors.len() + MOST_FAULTS;
    for axis in axes {
        let pointer = format!("/axes/{}", axis.place);
        if let Some(detail) = variation.refuses(&axis.varied) {
            filling.refuse(format!("{pointer}/path"), detail);
            continue;
        }
        let last = axis.values.len() - 1;
        // Every value takes the whole scene to check, and of what is spaced a few words ask for thousands.
        let enough = if axis.is_listed { MOST_LISTED } else { MOST_CHECKED };
        let checked = last.min((CHECKED_BYTES / variation.bytes()).clamp(LEAST_CHECKED, enough));
        let mut between = false;
        for place in (0..=checked).map(|k| k * last / checked.max(1)) {
            let value = &axis.values[place];
            let Some(detail) = refused_value(axis, value, axes, variation) else { continue };
            if axis.is_listed {
                filling.refuse(format!("{pointer}/values/{place}"), detail);
            } else if place == 0 {
                filling.refuse(format!("{pointer}/from"), detail);
            } else if place == last {
                filling.refuse(format!("{pointer}/to"), detail);
            } else if !between {
                between = true;
                filling.refuse(format!("{pointer}/count"), format!("at {value}: {detail}"));
            }
            if filling.errors.len() >= most {
                return;
            }
        }
    }
}

/// Why a value of an axis cannot be, beside whichever values of the others; `None`: it can, or it is they that cannot.
fn refused_value(axis: &Axis, value: &Value, axes: &[Axis], variation: &Variation) -> Option<String> {
    let others = || axes.iter().filter(|other| other.place != axis.place);
    let beside = |choose: &dyn Fn(usize) -> usize| {
        let others = others().map(|other| (&other.varied, other.values[choose(other.values.len())].clone()));
        variation.scene(others.chain([(&axis.varied, value.clone())])).err()
    };
    let refusal = beside(&|count| count / 2)?;
    if axes.len() > 1 {
        beside(&|_| 0)?;
        beside(&|count| count - 1)?;
    }
    let Refusal::Invalid { errors } = refusal else { return None };
    let its_own = |error: &&FieldError| !others().any(|other| other.varied.sets(&error.pointer));
    errors.iter().find(its_own).map(|error| axis.varied.told(error))
}

/// Refuses, in a job of another kind, what is varied.
pub fn refuse_in(kind: JobKind, input: &JobInput, filling: &mut Filling) {
    if input.axes.is_some() {
        filling.refuse("/axes", format!("goes with the kinds `study` and `optimum`, not with `{}`", kind.name()));
    }
}

/// Refuses, in a job of many simulations, to keep the signals of each.
pub fn refuse_signals(kind: JobKind, input: &JobInput, filling: &mut Filling) {
    let outputs = input.outputs.clone().unwrap_or_default();
    for (pointer, given) in [("/outputs/spectra", outputs.spectra), ("/outputs/series", outputs.series)] {
        if given.is_some_and(|channels| !channels.is_empty()) {
            filling.refuse(
                pointer,
                format!("a job of kind `{}` keeps no signals: run the point as a simulation", kind.name()),
            );
        }
    }
}

impl Study {
    /// A study whose axes and their values are checked. Refused where none of some points spread over the grid can be built: then it
    /// is the axes that are wrong.
    pub fn new(axes: Vec<Axis>, points: usize, reuse: bool, variation: Variation) -> Result<Self, Refusal> {
        let grid = Grid::new(axes.iter().map(|axis| axis.values.len()).collect());
        let study = Self { axes, grid, points, reuse, variation };
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
        let at_point = |error: FieldError| {
            let error = FieldError::new(error.pointer, format!("at the first point: {}", error.detail));
            of_an_axis(error, self.axes.iter().map(|axis| &axis.varied))
        };
        first.map_or(Ok(()), |refusal| Err(refusal.each(at_point)))
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
        self.variation.job(self.axes.iter().map(|axis| &axis.varied).zip(self.values(point).into_iter().cloned()))
    }

    /// What decides over the results, as JSON.
    pub fn canonical(&self) -> Value {
        let axes = self.axes.iter().map(|axis| json!({"axis": axis.varied.name, "values": axis.values}));
        json!({ "base": self.variation.base(), "axes": axes.collect::<Vec<_>>() })
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
