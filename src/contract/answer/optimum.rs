//! The result of an optimum job, and the search that finds it.

use std::collections::BTreeMap;

use raceway_core::simulation::input::control::Control;
use raceway_core::study::{self, Purpose, Uncertain};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::failure::RunFailure;
use super::point::{PointEnd, PointError};
use super::uncertainty::{is_best_at_zero, uncertain};
use crate::contract::job::input::GoalName;
use crate::contract::job::search::Search;
use crate::contract::job::simulation::Simulation;
use crate::contract::json::problem::Refusal;

/// Cause of a point that failed although its run did not.
const NO_METRIC: &str = "no-metric";

/// The response of `GET …/optimum`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OptimumAnswer {
    /// Pointer to the metric.
    #[schema(example = "/channels/spindle.y.acceleration/level_db")]
    pub metric: String,
    /// Whether the metric was minimized or maximized.
    pub goal: GoalName,
    /// The varied fields and their ranges.
    pub axes: Vec<RangeAnswer>,
    /// The best simulated point: value by axis.
    #[schema(value_type = BTreeMap<String, f64>)]
    pub point: Map<String, Value>,
    /// The metric at this point.
    pub value: f64,
    /// Estimated error of the value; absent where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Uncertainty of the point, by axis: an interval, with the other axis at its best value. Its ends are the nearest points that are
    /// worse by more than both errors together, the last points before runs fail, or the ends of the range. Inside the interval the errors
    /// are larger than the differences. Absent where the error of the metric is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub within: Option<BTreeMap<String, [f64; 2]>>,
    /// Axes whose range ends at the best point, or at a part where runs fail: there may be better points beyond.
    pub at_end_of_range: Vec<String>,
    /// Runs outside `within` whose value may be as good.
    pub rivals: Vec<RunAnswer>,
    /// Number of simulations.
    pub runs: u64,
    /// Number of simulations that failed.
    pub failed: u64,
    /// All simulations, in the order of the search.
    pub evaluations: Vec<RunAnswer>,
    /// The metrics at the best point, without `lines` and `left_out`.
    #[schema(value_type = BTreeMap<String, Value>)]
    pub metrics: Value,
}

/// A searched range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RangeAnswer {
    /// Path into the scene, or quantity.
    #[schema(example = "/bearing/inner_groove_curvature")]
    pub axis: String,
    /// Start of the range.
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
    /// Purpose of the run.
    pub purpose: PurposeName,
    /// The metric; absent where the run failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub value: Option<f64>,
    /// Estimated error of the metric; absent where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Reason why the run has no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub failure: Option<PointError>,
}

/// `scan`: on a coarse grid. `search`: descent from the best point of the grid. `band`: to find the uncertainty of the optimum.
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

impl OptimumAnswer {
    /// Searches for the optimum. `run_point` runs one simulation; `None`: it was stopped.
    pub fn of(
        search: &Search,
        run_point: &dyn Fn(Result<Simulation, Refusal>) -> Option<PointEnd>,
        control: &Control<'_>,
    ) -> Result<Self, RunFailure> {
        let metric = &search.objective.metric;
        let of_magnitude = is_best_at_zero(metric);
        let mut values: Vec<Option<Uncertain>> = Vec::new();
        let mut errors: Vec<Option<PointError>> = Vec::new();
        let mut metrics: Vec<Option<Value>> = Vec::new();
        let mut run = |at: &[f64]| -> Result<Option<Uncertain>, RunFailure> {
            if (control.stop)() {
                return Err(RunFailure::Cancelled);
            }
            let end = run_point(search.simulation(at)).ok_or(RunFailure::Cancelled)?;
            let (value, found, error) = match end {
                PointEnd::Failed(error) => (None, None, Some(error)),
                PointEnd::Succeeded(metrics) => match uncertain(&metrics, metric) {
                    Some(value) => (Some(value), Some(metrics), None),
                    None => (None, None, Some(no_metric(metric))),
                },
            };
            values.push(value);
            errors.push(error);
            metrics.push(found);
            (control.progress)(errors.len() as f64 / search.most_runs().max(errors.len()) as f64);
            Ok(value.map(|(value, error)| (if of_magnitude { value.abs() } else { value }, error)))
        };
        let found = study::optimum(search.objective.axes.len(), search.objective.goal, &mut run)?;
        let Some(best) = found.best else {
            let first = errors.into_iter().flatten().next();
            let why = first.map_or(String::new(), |error| format!("; first error: {}: {}", error.cause, error.detail));
            return Err(RunFailure::Failed {
                cause: NO_METRIC,
                detail: format!("none of {} runs has the metric {metric}{why}", found.evaluations.len()),
            });
        };
        let runs: Vec<_> = values.into_iter().zip(errors).collect();
        Ok(answer(search, &found, best, &runs, metrics.swap_remove(best).unwrap_or_default()))
    }
}

fn no_metric(metric: &str) -> PointError {
    PointError { cause: NO_METRIC.to_owned(), detail: format!("the run has no metric {metric}"), errors: Vec::new() }
}

fn answer(
    search: &Search,
    found: &study::Optimum,
    best: usize,
    ends: &[(Option<Uncertain>, Option<PointError>)],
    metrics: Value,
) -> OptimumAnswer {
    let values_at = |axis: usize, share: f64| search.objective.axes[axis].1.at(share);
    let within = found.band.as_ref().map(|band| {
        let ends = band.iter().enumerate().map(|(axis, ends)| {
            let ends = ends.map(|share| values_at(axis, share));
            (search.objective.axes[axis].0.name.clone(), [ends[0].min(ends[1]), ends[0].max(ends[1])])
        });
        ends.collect::<BTreeMap<_, _>>()
    });
    let is_in_band = |run: &study::Evaluation| {
        let band = found.band.iter().flatten();
        run.at.iter().zip(band).all(|(x, ends)| (ends[0]..=ends[1]).contains(x))
    };
    let at_edge = |axis: &usize| found.edges.as_ref().is_some_and(|edges| edges[*axis]);
    let at_end = |axis: &usize| [0.0, 1.0].contains(&found.evaluations[best].at[*axis]) || at_edge(axis);
    let at_end: Vec<usize> = (0..search.objective.axes.len()).filter(at_end).collect();
    let row = |(run, (value, error)): (&study::Evaluation, &(Option<Uncertain>, Option<PointError>))| RunAnswer {
        point: search.point(&run.at),
        purpose: run.purpose.into(),
        value: value.map(|value| value.0),
        error: value.and_then(|value| value.1),
        failure: error.clone(),
    };
    let rivals = found
        .evaluations
        .iter()
        .zip(ends)
        .filter(|(run, _)| found.may_be_as_good(run, search.objective.goal) && !is_in_band(run));
    let value = ends[best].0.unwrap_or((f64::NAN, None));
    OptimumAnswer {
        metric: search.objective.metric.clone(),
        goal: search.goal_name(),
        axes: search
            .objective
            .axes
            .iter()
            .map(|(varied, range)| RangeAnswer { axis: varied.name.clone(), from: range.from, to: range.to })
            .collect(),
        point: search.point(&found.evaluations[best].at),
        value: value.0,
        error: value.1,
        within,
        at_end_of_range: at_end.into_iter().map(|axis| search.objective.axes[axis].0.name.clone()).collect(),
        rivals: rivals.map(row).collect(),
        runs: found.evaluations.len() as u64,
        failed: ends.iter().filter(|(_, error)| error.is_some()).count() as u64,
        evaluations: found.evaluations.iter().zip(ends).map(row).collect(),
        metrics,
    }
}
