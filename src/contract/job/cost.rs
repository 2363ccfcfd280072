//! Estimated cost of a job.

use super::checked::Job;
use crate::contract::json::numbers::significant;
use raceway_core::numerics::lanes::LANES;
use raceway_core::numerics::ode::Method;
use raceway_core::simulation::error::estimate::is_tossed;
use raceway_core::simulation::error::lyapunov::judged_stretch;
use raceway_core::simulation::error::stationarity;
use raceway_core::simulation::input::model_level::ModelLevel;
use raceway_core::simulation::input::settings::RunSettings;
use raceway_core::simulation::model::Model;
use raceway_core::simulation::model::equilibrium::start_state;
use raceway_core::simulation::model::radially_condensed::{Pace, RadiallyCondensed};
use raceway_core::simulation::model::stiffness::{FastestMode, fastest_mode};
use raceway_core::simulation::model::terms::Grounds;
use raceway_core::simulation::recording::sampling::kept_values;
use raceway_core::simulation::solve::fixed_step;
use raceway_core::simulation::solve::ladder::{self};
use raceway_core::simulation::solve::startup::Shared;
use raceway_core::simulation::work_precision::Plan;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Estimated cost of the job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CostAnswer {
    /// Number of first-order states on the last of `rungs`.
    pub states: u64,
    /// Estimated wall time on one core, order of magnitude [s]: with the first of `rungs`, for one point of a study or one run of an optimum
    /// job. In ordinary scenes within a factor of ten, mostly of three. Chaos and impacts may double it. Slip that saturates early
    /// (`coulomb` over 1e-5 m/s) takes ten to a hundred times as long, most with `radau` and `fine_abm` at loose tolerances. Absent where
    /// the run has no equilibrium to start from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub estimated_wall_time_s: Option<f64>,
    /// Largest estimate [s]: no reduced model level is confirmed, and the last of `rungs` runs again with the terms omitted by judgement and at
    /// a tighter tolerance.
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

/// Time of one ball in one evaluation of the equations, and of each strip of its two contacts on top [s]:
/// of the order of `cargo bench --bench contact` on one core of a slow shared server with AVX2; and how much longer it takes with
/// hydrodynamic forces.
const SECONDS_PER_BALL: f64 = 0.04e-6;
const SECONDS_PER_STRIP: f64 = 0.0055e-6;
const HYDRODYNAMIC: f64 = 1.4;
/// How much longer than estimated what does not depend on the motion may take, on a slower machine.
const SLOWER: f64 = 2.0;
/// Longest estimate [s]; a run that long is never finished.
const LONGEST: f64 = 1e12;
/// Evaluations a step of the explicit method.
const EVALUATIONS: f64 = 6.0;
/// The same of a stiff method, linear algebra included; and its step in the article's case at a tolerance of 1e-5 [s], which shrinks
/// with the sixth root of the tolerance. What a method of higher or lower order does differently lies within the estimate's error.
const STIFF_EVALUATIONS: f64 = 6.0;
const STIFF_STEP: f64 = 1e-6;
const STIFF_TOLERANCE: f64 = 1e-5;
/// A step of fixed length, what it is implicit in included, and the repetition of a part of the run, in evaluations.
const STEPPED_EVALUATIONS: f64 = 2.5;
/// What the repetition of a run costs that tells its error, in runs, and that of one in steps that were asked for, in half of them.
const REPEATED: f64 = 1.0;
const REPEATED_IN_HALVES: f64 = 2.0;
/// Speed of a reduced rung with its repetitions by finer steps, times real time, in its usual steps.
const REDUCED_REAL_TIME_FACTOR: f64 = 8.0;
/// How much longer it takes through the contacts of the full model.
const REDUCED_GENERAL: f64 = 12.0;
/// What the dynamics beside which a reduced rung is checked cost, in runs over that time: they are repeated, too.
const CHECKS: f64 = 3.0;
/// What a look at the contacts costs that is taken for every kept value, in evaluations of the equations.
const LOOK: f64 = 2.0;
/// A run of the condensed rung by name that is made again in a fourth of the step, over one in its own.
const AGAIN: f64 = 4.0;
/// Runs at tight tolerances, of which half of an accuracy job consists, over those that a plain job makes.
const TIGHT: f64 = 4.0;
/// Runs that the references of an accuracy job are worth.
const REFERENCE_RUNS: f64 = 20.0;
/// Two samples of a chaotic motion, the second in half of the steps, over a run that is judged.
const SAMPLED: f64 = 1.5;
/// What impacts and levels that drown in noise add to error control at most: repetitions of the whole run at ever tighter tolerances.
const UNFORESEEN: f64 = 4.0;
/// By what they may cut the steps of a stiff method: balls at the walls of tight pockets, a shaft that turns back.
const CUT_BY_IMPACTS: f64 = 5.0;
/// Longest step that accuracy allows where stability does not bind [s].
const SMOOTH_STEP: f64 = 20e-6;

/// Stability holds the explicit method to short steps, however smooth the motion is: those of the fastest mode of the
/// equations at the start of the run; a stiff method goes its own pace, and `auto` takes the cheaper one. An order of magnitude:
/// impacts, loads that grow later, and levels that drown in noise are not foreseen. No time is given where the run has no equilibrium to
/// start from. Where nobody knows which of two ways a run goes, what lies within the same factor of both. Where steps of a fixed length are tried first, they mostly serve; the most is what error control adds.
pub fn estimate(job: &Job) -> CostAnswer {
    let scene = job.scene();
    let model = Model::new(scene, &job.base().terms);
    let states = model.mechanism().layout.dimension() as u64;
    let mode = start_state(&model).and_then(|start| fastest_mode(&model, &start));
    let times = mode.ok().map(|mode| {
        // As many as stand side by side are evaluated together.
        let balls = scene.bearing.parameters.ball_count.next_multiple_of(LANES) as f64;
        let of_contacts = 2.0 * job.base().terms.raceway.strips as f64 * SECONDS_PER_STRIP;
        let hydrodynamics = |longer: f64| if job.base().terms.raceway.hydrodynamics { longer } else { 1.0 };
        let evaluation = hydrodynamics(HYDRODYNAMIC) * balls * (SECONDS_PER_BALL + of_contacts);
        let by_error_control = |time: f64| time * evaluations_per_second(&job.base().settings, &mode, 1.0) * evaluation;
        let by_impacts =
            |time: f64| time * evaluations_per_second(&job.base().settings, &mode, CUT_BY_IMPACTS) * evaluation;
        let by_dynamics = |time: f64| match fixed_step::may_choose(&job.base().settings) {
            true => time / fixed_step::STEP * STEPPED_EVALUATIONS * evaluation,
            false => by_error_control(time),
        };
        let (settle, duration) = (job.base().settings.settle, job.base().settings.duration);
        let looks = LOOK * kept_values(duration) as f64 * evaluation;
        let shared = Shared::of(scene, &model, &job.base().settings).time;
        let runs = 1.0 + if job.base().settings.fixed_step.is_some() { REPEATED_IN_HALVES } else { REPEATED };
        let later = if scene.operation.speed.is_constant() { stationarity::most_time(duration) } else { 0.0 };
        // What attempts share, the run, its repetition that tells the error, and a later stretch.
        let judged =
            |by: &dyn Fn(f64) -> f64| by_dynamics(shared) + runs * (by(settle - shared + duration) + looks) + by(later);
        let tried = if fixed_step::may_choose(&job.base().settings) { judged(&by_dynamics) } else { 0.0 };
        // Where oil is viscous, steps may blow up while the run settles.
        let settled_anew = if job.base().terms.raceway.hydrodynamics { by_error_control(shared) } else { 0.0 };
        let most = tried + settled_anew + UNFORESEEN * attempts(job) * judged(&by_impacts);
        // Steps of a fixed length mostly serve, but not where the spindle moves along the axis. Of chaos they make two samples.
        let in_steps = fixed_step::may_choose(&job.base().settings);
        let tilts = ladder::tilts_late(scene);
        let either = |one: f64, other: f64| (one * other).sqrt();
        let rattles = model.mechanism().layout.cage && !model.mechanism().pocket.film_is_damped();
        let usual = match model.mechanism().layout.axial_spindle {
            true if in_steps => tried + judged(&by_error_control),
            false if in_steps && rattles => SAMPLED * judged(&by_dynamics),
            false if in_steps && (tilts || is_tossed(&model)) => either(tried, tried + judged(&by_error_control)),
            _ => judged(&by_dynamics),
        };
        let reduced = slower_on_the_condensed_rung(job) * (settle + duration + later) / REDUCED_REAL_TIME_FACTOR;
        let checked = reduced + CHECKS * by_dynamics(ladder::check_time(scene, &job.base().settings));
        let as_planned = |time: f64| [time, SLOWER * time];
        let [estimate, most] = match (plan_of(job), job.base().model_levels.first().filter(|rung| rung.is_reduced())) {
            (Some(plan), _) => as_planned(TIGHT * by_dynamics(compared_time(job, plan))),
            (None, None) => [usual, most],
            (None, Some(rung)) if job.base().model_levels.len() == 1 && *rung != ModelLevel::RadiallyCondensed => {
                as_planned(reduced)
            }
            // It may be made again in a fourth of the step.
            (None, Some(_)) if job.base().model_levels.len() == 1 => [checked, SLOWER * (checked + AGAIN * reduced)],
            (None, Some(_)) if rattles => [checked + usual, checked + most],
            (None, Some(_)) if tilts => [either(checked, checked + usual), checked + most],
            (None, Some(_)) => [checked, checked + most],
        };
        [estimate, most].map(|time| significant(time.min(LONGEST), 2))
    });
    let (estimated_wall_time_s, most_wall_time_s) = (times.map(|t| t[0]), times.map(|t| t[1]));
    let of_all = |each: Option<f64>| Some(significant(each? * job.simulations()? as f64, 2).min(LONGEST));
    CostAnswer {
        states,
        estimated_wall_time_s,
        most_wall_time_s,
        all_wall_time_s: of_all(estimated_wall_time_s),
        most_all_wall_time_s: of_all(most_wall_time_s),
    }
}

/// How many times as long as usual the condensed rung takes: steps may be shorter, and traction go through the contacts of the full model.
fn slower_on_the_condensed_rung(job: &Job) -> f64 {
    let Some(model) = job.base().model_levels.first().filter(|rung| rung.is_reduced()).and_then(|rung| {
        let condensed = *rung == ModelLevel::RadiallyCondensed || job.base().model_levels.len() > 1;
        condensed.then(|| RadiallyCondensed::new(job.scene(), &job.base().settings.outputs).ok()).flatten()
    }) else {
        return 1.0;
    };
    let step = model.pace_for(&job.base().settings).step();
    let general = if model.has_general_traction() { REDUCED_GENERAL } else { 1.0 };
    general * (Pace::of_steps(1).step() / step).max(1.0)
}

/// How often a run of the dynamics may be made: as asked for, with all that judgement has left out, and at a tighter tolerance.
fn attempts(job: &Job) -> f64 {
    let judged = job.base().terms.left_out.iter().any(|left_out| left_out.by == Grounds::Judgement);
    [true, judged, job.base().settings.tightened.is_some()].into_iter().filter(|may_come| *may_come).count() as f64
}

/// Evaluations of the equations for a second of motion; `cut`: of a stiff method's steps.
fn evaluations_per_second(settings: &RunSettings, mode: &FastestMode, cut: f64) -> f64 {
    let explicit = EVALUATIONS / settings.fixed_step.unwrap_or(mode.stable_step().min(SMOOTH_STEP));
    let stiff_step = STIFF_STEP / cut * (settings.relative_tolerance / STIFF_TOLERANCE).powf(1.0 / 6.0);
    match settings.method {
        Method::DormandPrince => explicit,
        _ if settings.fixed_step.is_some() => explicit,
        Method::Auto => explicit.min(STIFF_EVALUATIONS / stiff_step),
        Method::SemiImplicit | Method::Gear | Method::FineAbm | Method::Radau => STIFF_EVALUATIONS / stiff_step,
    }
}

/// Time that all runs of a comparison simulate together [s].
fn compared_time(job: &Job, plan: &Plan) -> f64 {
    let runs = (plan.methods.len() * plan.relative_tolerances.len()) as f64 * f64::from(plan.repetitions);
    job.base().settings.settle
        + 2.0 * judged_stretch(&job.base().settings)
        + (runs + REFERENCE_RUNS) * job.base().settings.duration
}

/// The plan of an accuracy job.
fn plan_of(job: &Job) -> Option<&Plan> {
    match job {
        Job::Accuracy(comparison) => Some(&comparison.plan),
        _ => None,
    }
}
