//! An optimum job: a scene, one or two ranges, and a metric to minimize or maximize.

use raceway_core::simulation::solve::plan::model_levels;
use raceway_core::study::{Goal, most_runs};
use serde_json::{Map, Value, json};

use super::axis::AxisInput;
use super::distribution::Sampled;
use super::input::{GoalName, JobInput};
use super::kind::JobKind;
use super::many_runs::{already_varied, refuse_signals};
use super::metric::{LEVEL, examples, part_of, unavailable};
use super::range::{Range, Scale};
use super::robust::Robust;
use super::sampled_inputs::{check_inputs, varied_request};
use super::simulation::{Draft, Simulation};
use super::variation::Variation;
use super::varied::{Varied, at_axis};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::uploads::Uploads;

const MAX_AXES: usize = 2;
/// Best points of a robust search that are repeated with more samples.
pub const MAX_REPEATED: usize = 3;
/// Share of a range at which the scene is checked; no simple fraction, so that whole numbers are not met by chance.
const INSIDE: f64 = 0.381_966;

/// A checked optimum job.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// The scene as it is without the values of the axes, and the settings of all runs.
    pub base: Simulation,
    pub objective: Objective,
    /// Uncertain inputs over which a statistic of the metric is optimized.
    pub robust: Option<Robust>,
    variation: Variation,
}

/// Ranges, metric and goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    pub axes: Vec<(Varied, Range)>,
    /// Pointer to the metric.
    pub metric: String,
    pub goal: Goal,
}

impl Search {
    /// The search of a request of this kind. Refused also where the scene cannot be built inside the ranges or at their ends, or where
    /// its results never contain the metric.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut draft = Draft::of(JobKind::Optimum, request, uploads)?;
        refuse_signals(JobKind::Optimum, &draft.input, &mut draft.defaults);
        let objective = Objective::of(&mut draft.input, &mut draft.defaults);
        let robust = Robust::of(JobKind::Optimum, &mut draft, objective.axes.iter().map(|(varied, _)| varied));
        let settings = draft.settings();
        let base = draft.simulation(settings, model_levels)?;
        let inputs = robust.as_ref().map_or(&[][..], |robust| &robust.inputs);
        let request = varied_request(&base.submission.request, json!(base.outputs.metrics), inputs);
        let variation = Variation::new(&request, base.scene_json(), uploads);
        check_inputs(inputs, &variation)?;
        let search = Self { base, objective, robust, variation };
        for (index, (varied, _)) in search.objective.axes.iter().enumerate() {
            if let Some(detail) = search.variation.refuses(varied) {
                return Err(FieldError::new(format!("/axes/{index}/path"), detail).into());
            }
        }
        let inside = vec![INSIDE; search.objective.axes.len()];
        for axis in 0..search.objective.axes.len() {
            search.check_ends(axis, &inside)?;
        }
        let at_axis = |error| at_axis(inside_ranges(error), search.objective.axes.iter().map(|(varied, _)| varied));
        let simulation = search.simulation(&inside).map_err(|refusal| refusal.map_errors(at_axis))?;
        unavailable(&search.objective.metric, simulation.scene())
            .map_or(Ok(search), |detail| Err(FieldError::new("/metric", detail).into()))
    }

    /// Refuses a range with one end at which the scene cannot be built. Where it cannot be built at both, the ends are not the reason.
    fn check_ends(&self, axis: usize, inside: &[f64]) -> Result<(), Refusal> {
        let refusal = |share: f64| {
            let mut at = inside.to_vec();
            at[axis] = share;
            self.simulation(&at).err()
        };
        let (end, refusal) = match (refusal(0.0), refusal(1.0)) {
            (Some(refusal), None) => ("from", refusal),
            (None, Some(refusal)) => ("to", refusal),
            _ => return Ok(()),
        };
        let varied = &self.objective.axes[axis].0;
        Err(refusal.map_errors(|error| FieldError::new(format!("/axes/{axis}/{end}"), varied.message(&error))))
    }

    /// Values at shares of the ranges.
    pub fn values(&self, at: &[f64]) -> Vec<f64> {
        self.objective.axes.iter().zip(at).map(|((_, range), share)| range.at(*share)).collect()
    }

    /// The simulation at shares of the ranges, with nominal inputs.
    pub fn simulation(&self, at: &[f64]) -> Result<Simulation, Refusal> {
        self.with_inputs(at, |_, input| input.nominal())
    }

    /// The simulation at shares of the ranges and probabilities of the inputs.
    pub fn sampled(&self, at: &[f64], probabilities: &[f64]) -> Result<Simulation, Refusal> {
        self.with_inputs(at, |place, input| input.value(probabilities.get(place).copied().unwrap_or(0.5)))
    }

    fn with_inputs(&self, at: &[f64], value: impl Fn(usize, &Sampled) -> Value) -> Result<Simulation, Refusal> {
        let values = self.values(at).into_iter().map(Value::from);
        let axes = self.objective.axes.iter().map(|(varied, _)| varied).zip(values);
        let inputs = self.robust.iter().flat_map(|robust| robust.inputs.iter().enumerate());
        self.variation.simulation(axes.chain(inputs.map(|(place, input)| (&input.varied, value(place, input)))))
    }

    /// Approximate largest number of runs.
    pub fn most_runs(&self) -> usize {
        let points = most_runs(self.objective.axes.len());
        self.robust.as_ref().map_or(points, |robust| points * robust.cube.len() + MAX_REPEATED * robust.fine.len() + 1)
    }

    /// Everything that determines the result, as JSON.
    pub fn canonical(&self) -> Value {
        let axis = |(varied, range): &(Varied, Range)| json!({ "axis": varied.name, "from": range.from, "to": range.to, "log": range.scale == Scale::Log });
        let mut canonical = json!({
            "base": self.variation.base(),
            "axes": self.objective.axes.iter().map(axis).collect::<Vec<_>>(),
            "metric": self.objective.metric,
            "goal": self.goal_name(),
        });
        if let Some(robust) = &self.robust {
            canonical["robust"] = robust.canonical().clone();
        }
        canonical
    }

    pub fn goal_name(&self) -> GoalName {
        match self.objective.goal {
            Goal::Least => GoalName::Minimum,
            Goal::Largest => GoalName::Maximum,
        }
    }

    /// Values at shares of the ranges, by axis.
    pub fn point(&self, at: &[f64]) -> Map<String, Value> {
        let names = self.objective.axes.iter().map(|(varied, _)| varied.name.clone());
        names.zip(self.values(at).into_iter().map(Value::from)).collect()
    }
}

impl Objective {
    /// The objective of a request. Unless the request names metrics, only the part that contains the metric is computed.
    pub fn of(input: &mut JobInput, defaults: &mut Defaults) -> Self {
        let axes = input.axes.take();
        let is_missing = axes.is_none();
        let given = axes.unwrap_or_default();
        if is_missing {
            defaults.refuse("/axes", format!("required, but missing: 1 to {MAX_AXES} axes"));
        } else if given.is_empty() || given.len() > MAX_AXES {
            defaults.refuse("/axes", format!("{} axes: must be from 1 to {MAX_AXES}", given.len()));
        }
        let mut axes: Vec<(Varied, Range)> = Vec::new();
        for (number, axis) in given.into_iter().take(MAX_AXES).enumerate() {
            let pointer = format!("/axes/{number}");
            let Some(axis) = axis_of(axis.0, &pointer, defaults) else { continue };
            if let Some(other) = axes.iter().find(|other| other.0.overlaps(&axis.0)) {
                defaults.refuse(pointer, already_varied(&axis.0, &other.0));
            } else {
                axes.push(axis);
            }
        }
        let metric = defaults.require("/metric", &input.metric, LEVEL.to_owned());
        let part = part_of(&metric);
        if part.is_none() {
            let metric: String = metric.chars().take(100).collect();
            defaults.refuse("/metric", format!("unknown metric `{metric}`; metrics are, for example, {}", examples()));
        }
        if let Some(part) = part {
            let asked = input.outputs.get_or_insert_default().metrics.get_or_insert_with(|| vec![part]);
            if !asked.contains(&part) {
                defaults.refuse("/outputs/metrics", format!("must contain `{}`, the part of `{metric}`", part.name()));
            }
        }
        let goal = match defaults.fill("/goal", &mut input.goal, GoalName::Minimum) {
            GoalName::Minimum => Goal::Least,
            GoalName::Maximum => Goal::Largest,
        };
        Self { axes, metric, goal }
    }
}

fn axis_of(axis: AxisInput, pointer: &str, defaults: &mut Defaults) -> Option<(Varied, Range)> {
    let varied = Varied::of(axis.path, axis.quantity, pointer, defaults)?;
    match (axis.from, axis.to, axis.values, axis.count) {
        (Some(from), Some(to), None, None) => {
            Some((varied, Range::of(from, to, axis.scale.as_deref(), pointer, defaults)?))
        }
        _ => {
            defaults.refuse(pointer, "takes `from` and `to`; a grid of values is a job of kind `study`");
            None
        }
    }
}

/// The error of a simulation inside the ranges.
fn inside_ranges(error: FieldError) -> FieldError {
    if error.detail.contains("must be a whole number") {
        let detail = "takes whole numbers only: use a study, whose axis lists them";
        return FieldError::new(error.pointer, detail);
    }
    FieldError::new(error.pointer, format!("inside the ranges, all of whose values must be valid: {}", error.detail))
}
