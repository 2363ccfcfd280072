//! A study: a scene and the axes along which it is varied. Each point of the grid is a simulation of its own, made from the request
//! with the values of the point in it. With uncertain inputs it is a simulation for each sample of them.

use std::collections::HashSet;

use raceway_core::simulation::solve::plan::model_levels;
use raceway_core::study::Grid;
use serde_json::{Value, json};

use super::axis::{AxisInput, MAX_POINTS};
use super::input::JobInput;
use super::kind::JobKind;
use super::many_runs::{already_varied, refuse_signals};
use super::range::Range;
use super::robust::Robust;
use super::sampled_inputs::{check_inputs, without_replaced};
use super::simulation::{Draft, Simulation};
use super::variation::Variation;
use super::varied::{MAX_NAME, Varied, at_axis};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, MAX_ERRORS, Refusal};
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::scene_input::ResolvedScene;

const MAX_AXES: usize = 4;
/// Largest number of values of a range, and of a list, that are checked before the job is accepted; evenly spread.
const MAX_CHECKED_OF_RANGE: usize = 64;
const MAX_CHECKED_OF_LIST: usize = 512;
/// Largest size of all scenes that are built for these checks, as JSON [bytes]; but at least `MIN_CHECKED` values are checked. The
/// others are checked when their point is simulated.
const MAX_CHECKED_BYTES: usize = 256 << 10;
const MIN_CHECKED: usize = 8;

/// A checked axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub varied: Varied,
    pub values: Vec<Value>,
    /// Index among the axes of the request.
    index: usize,
    /// True if the request lists the values; otherwise it gives their ends.
    is_listed: bool,
}

/// How points take values from the axes.
#[derive(Debug, Clone, PartialEq)]
pub enum Layout {
    /// Every value of an axis with every value of the others.
    Grid(Grid),
    /// The first value of every axis, then the second of every axis, and so on.
    List,
}

impl Layout {
    /// Places of a point on the axes.
    pub fn places(&self, point: usize, axes: usize) -> Vec<usize> {
        match self {
            Self::Grid(grid) => grid.places(point),
            Self::List => vec![point; axes],
        }
    }
}

/// A checked study.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The scene as it is without the values of the axes, and the settings of all points.
    pub base: Simulation,
    pub axes: Vec<Axis>,
    pub layout: Layout,
    /// Uncertain inputs of each point.
    pub robust: Option<Robust>,
    /// Number of simulations: points of the grid times samples.
    pub points: usize,
    variation: Variation,
}

/// The axes of a request and their number of points.
fn axes(input: &mut JobInput, defaults: &mut Defaults) -> (Vec<Axis>, usize) {
    let axes = input.axes.take();
    let is_missing = axes.is_none();
    let given = axes.unwrap_or_default();
    if is_missing {
        defaults.refuse("/axes", format!("required, but missing: 1 to {MAX_AXES} axes"));
        return (Vec::new(), 0);
    } else if given.is_empty() || given.len() > MAX_AXES {
        defaults.refuse("/axes", format!("{} axes: must be from 1 to {MAX_AXES}", given.len()));
        return (Vec::new(), 0);
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (index, axis) in given.into_iter().enumerate() {
        let pointer = format!("/axes/{index}");
        let Some(axis) = axis_of(axis.0, index, defaults) else { continue };
        if let Some(other) = axes.iter().find(|other| other.varied.overlaps(&axis.varied)) {
            defaults.refuse(pointer, already_varied(&axis.varied, &other.varied));
        } else {
            axes.push(axis);
        }
    }
    let points = Grid::new(axes.iter().map(|axis| axis.values.len()).collect()).points();
    match points.filter(|points| *points <= MAX_POINTS) {
        Some(points) => (axes, points),
        None => {
            let product = points.map_or("more".to_owned(), |points| points.to_string());
            defaults.refuse("/axes", format!("a grid of {product} points: at most {MAX_POINTS}"));
            (axes, 0)
        }
    }
}

/// Number of simulations of a grid.
fn simulations(points: usize, robust: Option<&Robust>, defaults: &mut Defaults) -> usize {
    let samples = robust.map_or(1, |robust| robust.cube.len());
    let runs = points * samples;
    if runs > MAX_POINTS {
        let detail = format!("{samples}: {points} points are {runs} simulations: at most {MAX_POINTS}");
        defaults.refuse("/samples", detail);
    }
    runs
}

fn axis_of(axis: AxisInput, index: usize, defaults: &mut Defaults) -> Option<Axis> {
    let pointer = &format!("/axes/{index}");
    let at = |field: &str| format!("{pointer}/{field}");
    let is_listed = axis.values.is_some();
    let varied = Varied::of(axis.path, axis.quantity, pointer, defaults)?;
    let values = match (axis.values, axis.from, axis.to, axis.count) {
        (Some(values), None, None, None) => {
            if axis.scale.is_some() {
                defaults.refuse(at("scale"), "goes with `from`, `to` and `count`, not with `values`");
            }
            listed_values(values, &at("values"), defaults)?
        }
        (None, Some(from), Some(to), Some(count)) => {
            spaced(&Range::of(from, to, axis.scale.as_deref(), pointer, defaults)?, count, pointer, defaults)?
        }
        _ => {
            defaults.refuse(pointer, "takes either `values` or all of `from`, `to` and `count`");
            return None;
        }
    };
    if varied.takes_names() || values.iter().all(Value::is_number) {
        return Some(Axis { varied, values, index, is_listed });
    }
    defaults.refuse(at("values"), format!("`{}` takes numbers", varied.name));
    None
}

fn listed_values(values: Vec<Value>, pointer: &str, defaults: &mut Defaults) -> Option<Vec<Value>> {
    if values.is_empty() || values.len() > MAX_POINTS {
        defaults.refuse(pointer, format!("{} values: must be from 1 to {MAX_POINTS}", values.len()));
        return None;
    }
    let known_errors = defaults.errors.len();
    let mut known = HashSet::new();
    for (place, value) in values.iter().enumerate() {
        // Zero has two signs.
        let number = value.as_f64().map(|number| (number + 0.0).to_bits());
        let detail = if value.as_str().is_some_and(|name| name.chars().count() > MAX_NAME) {
            format!("more than {MAX_NAME} characters")
        } else if !(value.is_number() || value.is_string()) {
            "must be a number or a name".to_owned()
        } else if !known.insert((number, value.as_str())) {
            "given more than once".to_owned()
        } else {
            continue;
        };
        defaults.refuse(format!("{pointer}/{place}"), detail);
        if defaults.errors.len() >= known_errors + MAX_ERRORS {
            break;
        }
    }
    (defaults.errors.len() == known_errors).then_some(values)
}

fn spaced(range: &Range, count: u32, pointer: &str, defaults: &mut Defaults) -> Option<Vec<Value>> {
    if !(2..=MAX_POINTS as u32).contains(&count) {
        defaults.refuse(format!("{pointer}/count"), format!("{count}: must be from 2 to {MAX_POINTS}"));
        return None;
    }
    let values: Vec<f64> = (0..count).map(|k| range.at(f64::from(k) / f64::from(count - 1))).collect();
    if values.windows(2).any(|pair| pair[0] == pair[1]) {
        defaults.refuse(
            format!("{pointer}/to"),
            format!("too close to `from`: {count} values of nine digits would repeat"),
        );
        return None;
    }
    Some(values.into_iter().map(Value::from).collect())
}

/// Refuses values with which no scene can be built. Each listed value, and a sample of a range, is combined with the middle values of
/// the other axes, then with their first and their last values. Some values are valid only in combination; the points of invalid
/// combinations fail one by one.
fn refuse_values(axes: &[Axis], variation: &Variation, defaults: &mut Defaults) {
    let most = defaults.errors.len() + MAX_ERRORS;
    for axis in axes {
        let pointer = format!("/axes/{}", axis.index);
        if let Some(detail) = variation.refuses(&axis.varied) {
            defaults.refuse(format!("{pointer}/path"), detail);
            continue;
        }
        let last = axis.values.len() - 1;
        // Each check builds the whole scene, and a short request can ask for thousands of values.
        let sample = if axis.is_listed { MAX_CHECKED_OF_LIST } else { MAX_CHECKED_OF_RANGE };
        let checked = last.min((MAX_CHECKED_BYTES / variation.bytes()).clamp(MIN_CHECKED, sample));
        let mut between = false;
        for place in (0..=checked).map(|k| k * last / checked.max(1)) {
            let value = &axis.values[place];
            let Some(detail) = refused_value(axis, value, axes, variation) else { continue };
            if axis.is_listed {
                defaults.refuse(format!("{pointer}/values/{place}"), detail);
            } else if place == 0 {
                defaults.refuse(format!("{pointer}/from"), detail);
            } else if place == last {
                defaults.refuse(format!("{pointer}/to"), detail);
            } else if !between {
                between = true;
                defaults.refuse(format!("{pointer}/count"), format!("at {value}: {detail}"));
            }
            if defaults.errors.len() >= most {
                return;
            }
        }
    }
}

/// Reason why no scene can be built with this value of an axis; `None`: it can, or the values of other axes are the reason.
fn refused_value(axis: &Axis, value: &Value, axes: &[Axis], variation: &Variation) -> Option<String> {
    let others = || axes.iter().filter(|other| other.index != axis.index);
    let combined = |choose: &dyn Fn(usize) -> usize| {
        let others = others().map(|other| (&other.varied, other.values[choose(other.values.len())].clone()));
        variation.scene(others.chain([(&axis.varied, value.clone())])).err()
    };
    let refusal = combined(&|count| count / 2)?;
    if axes.len() > 1 {
        combined(&|_| 0)?;
        combined(&|count| count - 1)?;
    }
    let Refusal::Invalid { errors } = refusal else { return None };
    let of_axis = |error: &&FieldError| !others().any(|other| other.varied.sets(&error.pointer));
    errors.iter().find(of_axis).map(|error| axis.varied.message(error))
}

impl Study {
    /// The study of a request of this kind. Refused also where none of a sample of points can be built: then the axes are wrong.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = Draft::of(JobKind::Study, request, uploads)?;
        refuse_signals(JobKind::Study, &draft.input, &mut draft.defaults);
        let (axes, grid_points) = axes(&mut draft.input, &mut draft.defaults);
        let robust = Robust::of(JobKind::Study, &mut draft, axes.iter().map(|axis| &axis.varied));
        let points = simulations(grid_points, robust.as_ref(), &mut draft.defaults);
        let settings = draft.settings();
        let inputs = robust.as_ref().map_or(&[][..], |robust| &robust.inputs);
        let varied = |scene| Variation::new(&without_replaced(&draft.request, inputs), scene, uploads);
        let variation = draft.scene_json().map(varied);
        // Of a refused grid no value is checked: each check builds a scene.
        if let Some(variation) = variation.as_ref().filter(|_| points > 0) {
            refuse_values(&axes, variation, &mut draft.defaults);
        }
        let base = draft.simulation(settings, model_levels)?;
        let variation =
            variation.unwrap_or_else(|| Variation::new(&base.submission.request, base.scene_json(), uploads));
        check_inputs(inputs, &variation)?;
        let grid = Grid::new(axes.iter().map(|axis| axis.values.len()).collect());
        let study = Self { base, axes, layout: Layout::Grid(grid), robust, points, variation };
        study.probe()?;
        Ok(study)
    }

    /// The points of listed values, of which each axis has as many.
    pub fn listed(base: Simulation, axes: Vec<(Varied, Vec<Value>)>, variation: Variation) -> Self {
        let points = axes.first().map_or(0, |axis| axis.1.len());
        let axes = axes.into_iter().enumerate();
        let axes = axes.map(|(index, (varied, values))| Axis { varied, values, index, is_listed: true }).collect();
        Self { base, axes, layout: Layout::List, robust: None, points, variation }
    }

    /// The scene with values of some axes; faster than the whole simulation.
    pub fn scene<'a>(&self, values: impl Iterator<Item = (&'a Varied, Value)>) -> Result<ResolvedScene, Refusal> {
        self.variation.scene(values)
    }

    /// The request that all points share.
    pub fn base_request(&self) -> &Value {
        self.variation.base()
    }

    /// Refuses the study unless some point of a sample of the grid can be built.
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
            at_axis(error, self.axes.iter().map(|axis| &axis.varied))
        };
        first.map_or(Ok(()), |refusal| Err(refusal.map_errors(at_point)))
    }

    /// True if the result of an identical finished simulation may be returned for a point.
    pub fn reuses(&self) -> bool {
        self.base.submission.reuse
    }

    /// Number of simulations of each point of the grid.
    pub fn samples(&self) -> usize {
        self.robust.as_ref().map_or(1, |robust| robust.cube.len())
    }

    /// Places of a point of the grid on the axes.
    pub fn places(&self, point: usize) -> Vec<usize> {
        self.layout.places(point, self.axes.len())
    }

    /// Values of a point of the grid, one for each axis.
    pub fn values(&self, point: usize) -> Vec<&Value> {
        self.places(point).into_iter().zip(&self.axes).map(|(place, axis)| &axis.values[place]).collect()
    }

    /// A simulation, those of one point of the grid behind each other.
    pub fn point(&self, number: usize) -> Result<Simulation, Refusal> {
        let (point, sample) = (number / self.samples(), number % self.samples());
        let of_axes = self.axes.iter().map(|axis| &axis.varied).zip(self.values(point).into_iter().cloned());
        let of_inputs = self.robust.iter().flat_map(|robust| robust.values(sample));
        self.variation.simulation(of_axes.chain(of_inputs))
    }

    /// Everything that determines the results, as JSON.
    pub fn canonical(&self) -> Value {
        let axes = self.axes.iter().map(|axis| json!({"axis": axis.varied.name, "values": axis.values}));
        let mut canonical = json!({ "base": self.variation.base(), "axes": axes.collect::<Vec<_>>() });
        if let Some(robust) = &self.robust {
            canonical["robust"] = robust.canonical().clone();
        }
        canonical
    }
}
