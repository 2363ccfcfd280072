//! The optimum of a metric: a scene, one or two ranges, and which end of the metric is wished for.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use utoipa::ToSchema;

use super::execute::{Outcome, RunFailure, execute_point};
use super::filling::Filling;
use super::job::{Job, JobInput, JobKind};
use super::outputs::{MetricsPart, channel};
use super::problem::{FieldError, Refusal, listed};
use super::study::{AxisInput, already_varied, refuse_signals};
use super::table::{PointEnd, PointError, uncertain};
use super::variation::{Range, Scale, Variation, Varied, of_an_axis};
use crate::simulation::input::control::Control;
use crate::simulation::input::scene::{Scene, Term, TermChoice};
use crate::study::{self, Goal, Purpose, Uncertain};

const MOST_AXES: usize = 2;
/// A place in the range at which a whole number is no better met than any other.
const NO_ROUND_SHARE: f64 = 0.381_966;
/// Why a point counts as failed although its run did not.
const NO_METRIC: &str = "no-metric";

/// What an optimum job seeks.
#[derive(Debug, Clone, PartialEq)]
pub struct Sought {
    axes: Vec<(Varied, Range)>,
    /// Pointer to the metric.
    metric: String,
    goal: Goal,
    variation: Variation,
}

/// Ranges, metric and goal of a request, before there is a scene.
#[derive(Debug)]
pub struct Wish {
    axes: Vec<(Varied, Range)>,
    metric: String,
    goal: Goal,
}

/// Which end of the metric is the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum GoalName {
    Minimum,
    Maximum,
}

/// The wish of a request; asks for no other metrics than the one it needs, where the request does not say which.
pub fn wish(input: &mut JobInput, filling: &mut Filling) -> Wish {
    refuse_signals(JobKind::Optimum, input, filling);
    let axes = input.axes.take();
    let is_missing = axes.is_none();
    let given = axes.unwrap_or_default();
    if is_missing {
        filling.refuse("/axes", format!("required, but missing: 1 to {MOST_AXES} axes"));
    } else if given.is_empty() || given.len() > MOST_AXES {
        filling.refuse("/axes", format!("{} axes: must be from 1 to {MOST_AXES}", given.len()));
    }
    let mut axes: Vec<(Varied, Range)> = Vec::new();
    for (number, axis) in given.into_iter().take(MOST_AXES).enumerate() {
        let pointer = format!("/axes/{number}");
        let Some(axis) = axis_of(axis.0, &pointer, filling) else { continue };
        if let Some(other) = axes.iter().find(|other| other.0.overlaps(&axis.0)) {
            filling.refuse(pointer, already_varied(&axis.0, &other.0));
        } else {
            axes.push(axis);
        }
    }
    let metric = filling.require("/metric", &input.metric, LEVEL.to_owned());
    let part = part_of(&metric);
    if part.is_none() {
        let metric: String = metric.chars().take(100).collect();
        filling.refuse("/metric", format!("no metric is called `{metric}`; metrics are, for example, {}", examples()));
    }
    if let Some(part) = part {
        let asked = input.outputs.get_or_insert_default().metrics.get_or_insert_with(|| vec![part]);
        if !asked.contains(&part) {
            filling.refuse("/outputs/metrics", format!("must contain `{}`, which `{metric}` belongs to", part.name()));
        }
    }
    let goal = match filling.take("/goal", &mut input.goal, GoalName::Minimum) {
        GoalName::Minimum => Goal::Least,
        GoalName::Maximum => Goal::Largest,
    };
    Wish { axes, metric, goal }
}

fn axis_of(axis: AxisInput, pointer: &str, filling: &mut Filling) -> Option<(Varied, Range)> {
    let varied = Varied::of(axis.path, axis.quantity, pointer, filling)?;
    match (axis.from, axis.to, axis.values, axis.count) {
        (Some(from), Some(to), None, None) => {
            Some((varied, Range::of(from, to, axis.scale.as_deref(), pointer, filling)?))
        }
        _ => {
            filling.refuse(pointer, "takes `from` and `to`; a grid of values is a job of kind `study`");
            None
        }
    }
}

/// Fields that only an optimum job takes.
pub fn refuse_in(kind: JobKind, input: &JobInput, filling: &mut Filling) {
    for (pointer, given) in [("/metric", input.metric.is_some()), ("/goal", input.goal.is_some())] {
        if given {
            filling.refuse(pointer, format!("goes with the kind `optimum`, not with `{}`", kind.name()));
        }
    }
}

const LEVEL: &str = "/channels/spindle.y.acceleration/level_db";

fn examples() -> String {
    listed([LEVEL, "/channels/spindle.z.velocity/rms", "/contacts/inner/max_load_n", "/cage/orbit_radius_um"])
}

/// The part of the metrics that a pointer belongs to; `None` where nothing is there.
fn part_of(metric: &str) -> Option<MetricsPart> {
    const OF_CHANNEL: [&str; 5] = ["rms", "peak", "crest_factor", "kurtosis", "above_band"];
    const OF_RACEWAY: [&str; 6] = [
        "max_load_n",
        "max_pressure_mpa",
        "min_contact_angle_deg",
        "max_contact_angle_deg",
        "max_slip_m_s",
        "min_film_thickness_um",
    ];
    let parts: Vec<&str> = metric.strip_prefix('/')?.split('/').collect();
    let is_channel = |channel: &str| match &channel.split('.').collect::<Vec<_>>()[..] {
        ["spindle", axis, quantity] => {
            ["x", "y", "z"].contains(axis) && ["displacement", "velocity", "acceleration"].contains(quantity)
        }
        _ => false,
    };
    match parts[..] {
        ["channels", channel, "level_db"] if is_channel(channel) && channel.ends_with("acceleration") => {
            Some(MetricsPart::Vibration)
        }
        ["channels", channel, name] if is_channel(channel) && OF_CHANNEL.contains(&name) => {
            Some(MetricsPart::Vibration)
        }
        ["contacts", "inner" | "outer", name] if OF_RACEWAY.contains(&name) => Some(MetricsPart::Contacts),
        ["contacts", "pocket", "max_load_n"]
        | ["kinematics", "cage_speed_hz" | "cage_slip" | "ball_spin_hz"]
        | ["cage", "orbit_radius_um" | "whirl_ratio"] => Some(MetricsPart::Cage),
        _ => None,
    }
}

fn in_the_range(error: FieldError) -> FieldError {
    if error.detail.contains("must be a whole number") {
        let detail = "takes whole numbers: an optimum is sought between them, a study goes from one to the next";
        return FieldError::new(error.pointer, detail);
    }
    FieldError::new(error.pointer, format!("inside of the ranges, which all values must fit: {}", error.detail))
}

/// Why a scene never has the metric; `None`: it may have it.
fn unavailable(metric: &str, scene: &Scene) -> Option<String> {
    let parts: Vec<&str> = metric.split('/').skip(1).collect();
    match parts[..] {
        ["channels", name, _] => channel(name, scene).err(),
        ["contacts", "pocket", _] | ["cage", _] if scene.terms.get(Term::Cage) == TermChoice::Off => {
            Some(format!("`{metric}` exists only with a cage (/scene/terms/cage is off)"))
        }
        _ => None,
    }
}

impl Sought {
    /// Of a request whose scene with every default is `complete`. Refused where the scene cannot be built inside of the
    /// ranges or at their ends, or never has the metric.
    pub fn new(wish: Wish, request: &Value, complete: Value) -> Result<Self, Refusal> {
        let Wish { axes, metric, goal } = wish;
        let mut request = request.clone();
        if let (Some(part), Value::Object(fields)) = (part_of(&metric), &mut request) {
            let outputs = fields.entry("outputs").or_insert_with(|| Value::Object(Map::new()));
            if let Value::Object(outputs) = outputs {
                outputs.entry("metrics").or_insert_with(|| json!([part]));
            }
        }
        let sought = Self { axes, metric, goal, variation: Variation::new(&request, complete) };
        for (place, (varied, _)) in sought.axes.iter().enumerate() {
            if let Some(detail) = sought.variation.refuses(varied) {
                return Err(FieldError::new(format!("/axes/{place}/path"), detail).into());
            }
        }
        let inside = vec![NO_ROUND_SHARE; sought.axes.len()];
        for axis in 0..sought.axes.len() {
            sought.check_ends(axis, &inside)?;
        }
        let in_the_range = |error| of_an_axis(in_the_range(error), sought.axes.iter().map(|(varied, _)| varied));
        let job = sought.job(&inside).map_err(|refusal| refusal.each(in_the_range))?;
        unavailable(&sought.metric, job.scene())
            .map_or(Ok(sought), |detail| Err(FieldError::new("/metric", detail).into()))
    }

    /// Refused where the scene cannot be built at one end of an axis; where it cannot at both, it is not for their values.
    fn check_ends(&self, axis: usize, inside: &[f64]) -> Result<(), Refusal> {
        let refusal = |share: f64| {
            let mut at = inside.to_vec();
            at[axis] = share;
            self.job(&at).err()
        };
        let (end, refusal) = match (refusal(0.0), refusal(1.0)) {
            (Some(refusal), None) => ("from", refusal),
            (None, Some(refusal)) => ("to", refusal),
            _ => return Ok(()),
        };
        let varied = &self.axes[axis].0;
        Err(refusal.each(|error| FieldError::new(format!("/axes/{axis}/{end}"), varied.told(&error))))
    }

    fn values(&self, at: &[f64]) -> Vec<f64> {
        self.axes.iter().zip(at).map(|((_, range), share)| range.at(*share)).collect()
    }

    /// The simulation at shares of the ways along the axes.
    fn job(&self, at: &[f64]) -> Result<Job, Refusal> {
        let values = self.values(at).into_iter().map(Value::from);
        self.variation.job(self.axes.iter().map(|(varied, _)| varied).zip(values))
    }

    /// Runs that it takes at most, about.
    pub fn most_runs(&self) -> usize {
        study::most_runs(self.axes.len())
    }

    /// What decides over the result, as JSON.
    pub fn canonical(&self) -> Value {
        let axis = |(varied, range): &(Varied, Range)| json!({ "axis": varied.name, "from": range.from, "to": range.to, "log": range.scale == Scale::Log });
        json!({
            "base": self.variation.base(),
            "axes": self.axes.iter().map(axis).collect::<Vec<_>>(),
            "metric": self.metric,
            "goal": self.goal_name(),
        })
    }

    fn goal_name(&self) -> GoalName {
        match self.goal {
            Goal::Least => GoalName::Minimum,
            Goal::Largest => GoalName::Maximum,
        }
    }

    fn named(&self, at: &[f64]) -> Map<String, Value> {
        let names = self.axes.iter().map(|(varied, _)| varied.name.clone());
        names.zip(self.values(at).into_iter().map(Value::from)).collect()
    }

    /// Searches, with what simulates jobs.
    pub fn search(
        &self,
        simulate: &dyn Fn(&Job) -> Result<Outcome, RunFailure>,
        control: &Control<'_>,
    ) -> Result<OptimumAnswer, RunFailure> {
        let mut errors: Vec<Option<PointError>> = Vec::new();
        let mut metrics: Vec<Option<Value>> = Vec::new();
        let mut run = |at: &[f64]| -> Result<Option<Uncertain>, RunFailure> {
            if (control.stop)() {
                return Err(RunFailure::Cancelled);
            }
            let end = execute_point(self.job(at), simulate).ok_or(RunFailure::Cancelled)?;
            let (value, found, error) = match end {
                PointEnd::Failed(error) => (None, None, Some(error)),
                PointEnd::Succeeded(metrics) => match uncertain(&metrics, &self.metric) {
                    Some(value) => (Some(value), Some(metrics), None),
                    None => (None, None, Some(self.no_metric())),
                },
            };
            errors.push(error);
            metrics.push(found);
            (control.progress)(errors.len() as f64 / self.most_runs().max(errors.len()) as f64);
            Ok(value)
        };
        let found = study::optimum(self.axes.len(), self.goal, &mut run)?;
        let Some(best) = found.best else {
            let first = errors.into_iter().flatten().next();
            let why = first.map_or(String::new(), |error| format!("; the first: {}: {}", error.cause, error.detail));
            return Err(RunFailure::Failed {
                cause: NO_METRIC,
                detail: format!("none of {} runs has the metric {}{why}", found.evaluations.len(), self.metric),
            });
        };
        Ok(self.answer(&found, best, &errors, metrics.swap_remove(best).unwrap_or_default()))
    }

    fn no_metric(&self) -> PointError {
        PointError {
            cause: NO_METRIC.to_owned(),
            detail: format!("the run has no {}", self.metric),
            errors: Vec::new(),
        }
    }

    fn answer(
        &self,
        found: &study::Optimum,
        best: usize,
        errors: &[Option<PointError>],
        metrics: Value,
    ) -> OptimumAnswer {
        let values_at = |axis: usize, share: f64| self.axes[axis].1.at(share);
        let within = found.band.as_ref().map(|band| {
            let ends = band.iter().enumerate().map(|(axis, ends)| {
                let ends = ends.map(|share| values_at(axis, share));
                (self.axes[axis].0.name.clone(), [ends[0].min(ends[1]), ends[0].max(ends[1])])
            });
            ends.collect::<BTreeMap<_, _>>()
        });
        let is_in_band = |run: &study::Evaluation| {
            let band = found.band.iter().flatten();
            run.at.iter().zip(band).all(|(x, ends)| (ends[0]..=ends[1]).contains(x))
        };
        let at_edge = |axis: &usize| found.edges.as_ref().is_some_and(|edges| edges[*axis]);
        let at_end = |axis: &usize| [0.0, 1.0].contains(&found.evaluations[best].at[*axis]) || at_edge(axis);
        let at_end: Vec<usize> = (0..self.axes.len()).filter(at_end).collect();
        let row = |(run, error): (&study::Evaluation, &Option<PointError>)| RunAnswer {
            point: self.named(&run.at),
            purpose: run.purpose.into(),
            value: run.value.map(|value| value.0),
            error: run.value.and_then(|value| value.1),
            failure: error.clone(),
        };
        let rivals = found
            .evaluations
            .iter()
            .zip(errors)
            .filter(|(run, _)| found.may_be_as_good(run, self.goal) && !is_in_band(run));
        let value = found.evaluations[best].value.unwrap_or((f64::NAN, None));
        OptimumAnswer {
            metric: self.metric.clone(),
            goal: self.goal_name(),
            axes: self
                .axes
                .iter()
                .map(|(varied, range)| RangeAnswer { axis: varied.name.clone(), from: range.from, to: range.to })
                .collect(),
            point: self.named(&found.evaluations[best].at),
            value: value.0,
            error: value.1,
            within,
            at_end_of_range: at_end.into_iter().map(|axis| self.axes[axis].0.name.clone()).collect(),
            rivals: rivals.map(row).collect(),
            runs: found.evaluations.len() as u64,
            failed: errors.iter().flatten().count() as u64,
            evaluations: found.evaluations.iter().zip(errors).map(row).collect(),
            metrics,
        }
    }
}

/// The answer of `GET …/optimum`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OptimumAnswer {
    /// Pointer to the metric.
    #[schema(example = "/channels/spindle.y.acceleration/level_db")]
    pub metric: String,
    /// Which end of the metric is sought.
    pub goal: GoalName,
    /// What is varied, and from where to where.
    pub axes: Vec<RangeAnswer>,
    /// The best point that was run: value by axis.
    #[schema(value_type = BTreeMap<String, f64>)]
    pub point: Map<String, Value>,
    /// The metric there.
    pub value: f64,
    /// Estimated error of the value; absent where nobody knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// How well the point is known, by axis: from … to, with the other axis at its best value. The ends are the nearest points that are
    /// certainly worse, beyond both errors together, the last ones before runs fail, or the ends of the range; between them the errors leave no order. Absent
    /// where the error of the metric is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub within: Option<BTreeMap<String, [f64; 2]>>,
    /// Axes at an end of whose range the best point lies, or beside whose band runs fail: beyond it there may be better ones.
    pub at_end_of_range: Vec<String>,
    /// Runs elsewhere that may be as good.
    pub rivals: Vec<RunAnswer>,
    /// Number of simulations.
    pub runs: u64,
    /// How many of them failed.
    pub failed: u64,
    /// All of them, in their order.
    pub evaluations: Vec<RunAnswer>,
    /// The metrics at the best point, without lines and what was left out.
    #[schema(value_type = BTreeMap<String, Value>)]
    pub metrics: Value,
}

/// A range that is searched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RangeAnswer {
    /// Path into the scene, or quantity.
    #[schema(example = "/bearing/inner_groove_curvature")]
    pub axis: String,
    /// Begin of the range.
    pub from: f64,
    /// End of the range.
    pub to: f64,
}

/// One simulation of the search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RunAnswer {
    /// Value by axis.
    #[schema(value_type = BTreeMap<String, f64>)]
    pub point: Map<String, Value>,
    /// Why the point was run.
    pub purpose: PurposeName,
    /// The metric; absent where the run failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub value: Option<f64>,
    /// Its estimated error; absent where nobody knows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Why the run has no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub failure: Option<PointError>,
}

/// `scan`: on a coarse grid. `search`: down a valley. `band`: to see where points are certainly worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PurposeName {
    Scan,
    Search,
    Band,
}

impl From<Purpose> for PurposeName {
    fn from(purpose: Purpose) -> Self {
        match purpose {
            Purpose::Scan => Self::Scan,
            Purpose::Search => Self::Search,
            Purpose::Band => Self::Band,
        }
    }
}
