//! The result of an optimum job, and the search that finds it.

use std::collections::BTreeMap;

use raceway_core::simulation::input::control::Control;
use raceway_core::study::{self, Purpose, Uncertain};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::failure::RunFailure;
use super::point::{PointEnd, PointError};
use super::uncertainty::{is_best_at_zero, over_samples, uncertain};
use crate::contract::job::input::GoalName;
use crate::contract::job::robust::Robust;
use crate::contract::job::search::{MAX_REPEATED, Search};
use crate::contract::job::simulation::Simulation;
use crate::contract::job::statistic::{StatisticChoice, StatisticInput};
use crate::contract::json::problem::Refusal;

/// Cause of a point that failed although its run did not.
const NO_METRIC: &str = "no-metric";

/// The response of `GET …/optimum`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OptimumAnswer {
    /// Pointer to the metric.
    #[schema(example = "/channels/spindle.y.acceleration/level_db")]
    pub metric: String,
    /// Direction of the search.
    pub goal: GoalName,
    /// The varied fields and their ranges.
    pub axes: Vec<RangeAnswer>,
    /// The best simulated point: value by axis.
    #[schema(value_type = BTreeMap<String, f64>)]
    pub point: Map<String, Value>,
    /// The metric at this point; of a robust optimum its statistic over the inputs, by the repeated runs.
    pub value: f64,
    /// Statistic of the metric over the uncertain inputs that `value` holds; absent without inputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, value_type = Option<StatisticChoice>)]
    pub statistic: Option<StatisticInput>,
    /// The metric at this point with nominal inputs; absent without inputs, or where it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub nominal: Option<f64>,
    /// The best points of a robust search, at most three, repeated with more samples; the best of them is the result.
    #[serde(default)]
    pub repeated: Vec<RunAnswer>,
    /// Estimated error of the value; absent where it is unknown. Of a statistic: half of an interval of 95 % by the finite number of samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error: Option<f64>,
    /// Uncertainty of the point, by axis: an interval, with the other axis at its best value. Its ends are the nearest points that are
    /// worse by more than both errors together, the last points before runs fail, or the ends of the range. Inside the interval the errors
    /// are larger than the differences. Absent where the error of the metric is unknown, or where another valley was better when repeated.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub within: Option<BTreeMap<String, [f64; 2]>>,
    /// Axes whose range ends at the best point, or at a part where runs fail: there may be better points beyond.
    pub at_end_of_range: Vec<String>,
    /// Runs outside `within` whose value may be as good; of a robust optimum the other `repeated` points whose intervals overlap that of the result.
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

/// `scan`: on a coarse grid. `search`: descent from the best point of the grid. `band`: to find the uncertainty of the optimum. `repeat`: with more
/// samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PurposeName {
    Scan,
    Search,
    Band,
    Repeat,
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

/// The runs of a search.
struct Runs<'a> {
    search: &'a Search,
    run_point: &'a dyn Fn(Result<Simulation, Refusal>) -> Option<PointEnd>,
    control: &'a Control<'a>,
    /// Simulations up to now.
    count: usize,
}

/// Value or error of a point.
type PointValue = (Option<Uncertain>, Option<PointError>);

impl Runs<'_> {
    /// One simulation: its value and its metrics, or its error.
    fn simulate(&mut self, simulation: Result<Simulation, Refusal>) -> Result<(PointValue, Option<Value>), RunFailure> {
        if (self.control.stop)() {
            return Err(RunFailure::Cancelled);
        }
        let end = (self.run_point)(simulation).ok_or(RunFailure::Cancelled)?;
        self.count += 1;
        (self.control.progress)(self.count as f64 / self.search.most_runs().max(self.count) as f64);
        let metric = &self.search.objective.metric;
        Ok(match end {
            PointEnd::Failed(error) => ((None, Some(error)), None),
            PointEnd::Succeeded(metrics) => match uncertain(&metrics, metric) {
                Some(value) => ((Some(value), None), Some(metrics)),
                None => ((None, Some(no_metric(metric))), None),
            },
        })
    }

    /// The statistic at a point over samples; an error where too many of them have no value.
    fn statistic(&mut self, at: &[f64], robust: &Robust, cube: &[Vec<f64>]) -> Result<PointValue, RunFailure> {
        let (mut values, mut first) = (Vec::with_capacity(cube.len()), None);
        for probabilities in cube {
            let ((value, error), _) = self.simulate(self.search.sampled(at, probabilities))?;
            values.push(value.map(|(value, _)| value));
            first = first.or(error);
        }
        let found = over_samples(robust.statistic, &self.search.objective.metric, &values);
        Ok((found, first.filter(|_| found.is_none())))
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
        let mut runs = Runs { search, run_point, control, count: 0 };
        let mut ends: Vec<PointValue> = Vec::new();
        let mut metrics: Vec<Option<Value>> = Vec::new();
        let mut run = |at: &[f64]| -> Result<Option<Uncertain>, RunFailure> {
            let (end, found) = match &search.robust {
                Some(robust) => (runs.statistic(at, robust, &robust.cube)?, None),
                None => runs.simulate(search.simulation(at))?,
            };
            let value = end.0.map(|(value, error)| (if of_magnitude { value.abs() } else { value }, error));
            ends.push(end);
            metrics.push(found);
            Ok(value)
        };
        let found = study::optimum(search.objective.axes.len(), search.objective.goal, &mut run)?;
        let Some(best) = found.best else {
            let first = ends.into_iter().find_map(|(_, error)| error);
            let why = first.map_or(String::new(), |error| format!("; first error: {}: {}", error.cause, error.detail));
            return Err(RunFailure::Failed {
                cause: NO_METRIC,
                detail: format!("none of {} runs has the metric {metric}{why}", found.evaluations.len()),
            });
        };
        match &search.robust {
            None => Ok(answer(search, &found, best, &ends, metrics.swap_remove(best).unwrap_or_default())),
            Some(robust) => repeated(search, &found, best, &ends, robust, &mut runs),
        }
    }
}

/// Points that differ by less than this share of every range count as one valley.
const SAME_VALLEY: f64 = 0.02;

/// The answer of a robust search: its best points are repeated with more samples.
fn repeated(
    search: &Search,
    found: &study::Optimum,
    best: usize,
    ends: &[PointValue],
    robust: &Robust,
    runs: &mut Runs<'_>,
) -> Result<OptimumAnswer, RunFailure> {
    let cost = |value: f64| search.objective.goal.cost(value);
    let mut order: Vec<usize> = (0..ends.len()).filter(|run| ends[*run].0.is_some()).collect();
    order.sort_by(|a, b| {
        let of = |run: &usize| ends[*run].0.map_or(f64::INFINITY, |value| cost(value.0));
        of(a).total_cmp(&of(b))
    });
    let is_near = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|run| &found.evaluations[run].at);
        a.iter().zip(b).all(|(x, y)| (x - y).abs() < SAME_VALLEY)
    };
    let mut chosen = vec![best];
    for run in order {
        if chosen.len() < MAX_REPEATED && !chosen.iter().any(|other| is_near(run, *other)) {
            chosen.push(run);
        }
    }
    let mut again: Vec<(usize, PointValue)> = Vec::new();
    for run in chosen {
        again.push((run, runs.statistic(&found.evaluations[run].at, robust, &robust.fine)?));
    }
    let of = |(_, (value, _)): &&(usize, PointValue)| value.map_or(f64::INFINITY, |value| cost(value.0));
    let winner = again.iter().min_by(|a, b| of(a).total_cmp(&of(b)));
    let (winner, value) = winner.map_or((best, None), |(run, (value, _))| (*run, *value));
    let at = &found.evaluations[winner].at;
    let ((nominal, _), metrics) = runs.simulate(search.simulation(at))?;
    let mut answer = answer(search, found, best, ends, metrics.unwrap_or_default());
    if winner != best {
        (answer.point, answer.within, answer.at_end_of_range) = (search.point(at), None, Vec::new());
    }
    let (value, error) = value.or(ends[winner].0).unwrap_or((f64::NAN, None));
    (answer.value, answer.error) = (value, error);
    answer.statistic = Some(robust.given_statistic.clone());
    answer.nominal = nominal.map(|(value, _)| value);
    answer.runs = runs.count as u64;
    let row = |(run, (value, failure)): (usize, PointValue)| RunAnswer {
        point: search.point(&found.evaluations[run].at),
        purpose: PurposeName::Repeat,
        value: value.map(|value| value.0),
        error: value.and_then(|value| value.1),
        failure,
    };
    // By the repeated runs, whose intervals are narrower than those of the search.
    let is_rival = |(run, (other, _)): &&(usize, PointValue)| {
        let apart =
            |(other, error): Uncertain| (other - value).abs() <= error.unwrap_or(0.0) + answer.error.unwrap_or(0.0);
        *run != winner && other.is_some_and(apart)
    };
    answer.rivals = again.iter().filter(is_rival).cloned().map(row).collect();
    answer.repeated = again.into_iter().map(row).collect();
    Ok(answer)
}

fn no_metric(metric: &str) -> PointError {
    PointError { cause: NO_METRIC.to_owned(), detail: format!("the run has no metric {metric}"), errors: Vec::new() }
}

fn answer(search: &Search, found: &study::Optimum, best: usize, ends: &[PointValue], metrics: Value) -> OptimumAnswer {
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
        statistic: None,
        nominal: None,
        repeated: Vec::new(),
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
