//! What a job will cost, before it runs.

use super::job::Job;
use super::resolve::CostAnswer;
use super::units::significant;
use crate::simulation::error::lyapunov::judged_stretch;
use crate::simulation::solve::cost::Cost;
use crate::simulation::solve::plan::Plan;
use crate::simulation::work_precision;

/// Runs at tight tolerances, of which half of an accuracy job consists, over those that a plain job makes [-].
const TIGHT: f64 = 4.0;
/// Runs that the references of an accuracy job are worth [-].
const REFERENCE_RUNS: f64 = 20.0;
/// How much longer an accuracy job may take on a slower machine [-].
const SLOWER: f64 = 2.0;
/// Longest estimate of many runs [s].
const LONGEST: f64 = 1e12;

/// Estimated cost: of the first candidate of the plan, and of all candidates at most.
pub fn estimate(job: &Job) -> CostAnswer {
    let (scene, settings) = (job.scene(), &job.settings);
    let plan = Plan::of(scene, settings).ok();
    let cost = plan.map(|plan| Cost::of(scene, settings, &job.needs, &plan));
    let times = match &job.plan {
        Some(plan) => {
            let time = Cost::of_dynamics(scene, settings, &job.needs, compared_time(job, plan));
            time.map(|time| (TIGHT * time, SLOWER * TIGHT * time))
        }
        None => cost.and_then(|cost| cost.wall_time),
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

/// Time that all runs of a comparison simulate together [s].
fn compared_time(job: &Job, plan: &work_precision::Plan) -> f64 {
    let runs = (plan.methods.len() * plan.relative_tolerances.len()) as f64 * f64::from(plan.repetitions);
    job.settings.settle + 2.0 * judged_stretch(&job.settings) + (runs + REFERENCE_RUNS) * job.settings.duration
}
