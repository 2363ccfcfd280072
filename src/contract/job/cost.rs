//! Estimated cost of a job.

use raceway_core::simulation::error::lyapunov::judged_stretch;
use raceway_core::simulation::input::settings::RunSettings;
use raceway_core::simulation::solve::cost::Cost;
use raceway_core::simulation::solve::plan::Plan;
use raceway_core::simulation::work_precision;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::checked::Job;
use crate::contract::json::numbers::significant;

/// Estimated cost of the job.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CostAnswer {
    /// Number of first-order states on the last of `rungs`.
    pub states: u64,
    /// Likely wall time on one core, order of magnitude [s], for one point of a study or one run of an optimum job: between that of the first of
    /// `rungs` and that of all. In ordinary scenes within a factor of ten, mostly of three. Chaos and impacts may double it. Slip that saturates early
    /// (`coulomb` over 1e-5 m/s) takes ten to a hundred times as long, most with `radau` and `fine_abm` at loose tolerances. Absent where
    /// the run has no equilibrium to start from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub estimated_wall_time_s: Option<f64>,
    /// Estimated wall time at most [s]: all candidates of the plan are tried, the last at a tighter tolerance. That of a machine takes its step
    /// halved twice; irregular motion and light parts may halve it more often.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub most_wall_time_s: Option<f64>,
    /// `estimated_wall_time_s` times the points of a study, or times `most_runs` of an optimum job [s]. The workers share the points of a
    /// study; an optimum job takes one core. Absent for other kinds.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub all_wall_time_s: Option<f64>,
    /// `most_wall_time_s` times the same number [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub most_all_wall_time_s: Option<f64>,
}

/// Runs at tight tolerances, of which half of an accuracy job consists, over those of a plain job [-].
const TIGHT: f64 = 4.0;
/// Runs that the references of an accuracy job are worth [-].
const REFERENCE_RUNS: f64 = 20.0;
/// Longer time of an accuracy job on a slower machine [-].
const SLOWER: f64 = 2.0;
/// Longest estimate of many runs [s].
const LONGEST: f64 = 1e12;

/// Estimated cost: of the first candidate of the plan, and of all candidates at most. Nothing for a rotor job, which takes milliseconds.
pub fn estimate(job: &Job) -> CostAnswer {
    let Some(base) = job.base() else { return CostAnswer::default() };
    let (scene, settings) = (base.scene(), &base.settings);
    let plan = Plan::of(scene, settings).ok();
    let cost = plan.map(|plan| Cost::of(scene, settings, &base.terms, &plan));
    let times = match job {
        Job::Accuracy(comparison) => {
            let time = Cost::of_dynamics(scene, settings, &base.terms, compared_time(settings, &comparison.plan));
            time.map(|time| (TIGHT * time, SLOWER * TIGHT * time))
        }
        _ => cost.and_then(|cost| cost.wall_time),
    };
    let [first, most] = [times.map(|times| times.0), times.map(|times| times.1)];
    let [first, most] = [first, most].map(|time| time.map(|time| significant(time, 2)));
    let of_all = |each: Option<f64>| Some(significant(each? * job.simulations()? as f64, 2).min(LONGEST));
    CostAnswer {
        states: cost.map_or(0, |cost| cost.states) as u64,
        estimated_wall_time_s: first,
        most_wall_time_s: most,
        all_wall_time_s: of_all(first),
        most_all_wall_time_s: of_all(most),
    }
}

/// Simulated time of all runs of a comparison [s].
fn compared_time(settings: &RunSettings, plan: &work_precision::Plan) -> f64 {
    let runs = (plan.methods.len() * plan.relative_tolerances.len()) as f64 * f64::from(plan.repetitions);
    settings.settle + 2.0 * judged_stretch(settings) + (runs + REFERENCE_RUNS) * settings.duration
}
