//! Error against run time, as JSON.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::job::{Job, JobInput};
use super::machine::MachineAnswer;
use super::recommended::{RecommendedAnswer, recommended};
use super::report::{LeftOutAnswer, MotionName};
use super::words::scene_in_words;
use crate::numerics::statistics::median;
use crate::simulation::error::comparison::FAINT;
use crate::simulation::work_precision::{
    ABOVE_OWN_ERROR, LEAST_SCALE, MOST_GROWN, Measured, Plan, Point, Reference, SETTLING, TrajectoryError,
    WorkPrecision, level_floor,
};

/// Methods and tolerances of one scene: what each costs and how far it is from the reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WorkPrecisionAnswer {
    /// What every run is compared with.
    pub reference: ReferenceAnswer,
    /// In the order of the methods, loosest tolerance first.
    pub points: Vec<PointAnswer>,
    /// The cheapest point whose level, and that of every tighter tolerance of its method, is within 0.1, 0.01 and 0.001 dB
    /// of the reference; by processor time where the system tells it. What no point reaches, or what the reference is too
    /// uncertain to tell, is missing.
    #[serde(default)]
    pub recommended: Vec<RecommendedAnswer>,
    /// What is compared, over which time.
    pub compared: ComparedAnswer,
    /// What is timed.
    pub timing: TimingAnswer,
    /// Where it was timed.
    pub machine: MachineAnswer,
    /// How to measure the same again.
    pub repeat: RepeatAnswer,
    /// What is not in the equations, whoever solves them.
    pub left_out: Vec<LeftOutAnswer>,
}

/// What every run is compared with, and its own error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ReferenceAnswer {
    /// Method of the reference.
    #[schema(example = "radau")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(minimum = 0)]
    pub relative_tolerance: f64,
    /// Difference of the levels of two references, as `level_error_db` of a point [dB]; absent where nothing moves, where
    /// the time is too short for a level, or where no second reference finished.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub own_error_db: Option<f64>,
    /// Difference of the trajectories of two references, as `trajectory_error` [-]. Absent in a chaotic motion: each
    /// point is compared over a time of its own (`compared_s`), and has it for that as `reference_trajectory_error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub own_trajectory_error: Option<f64>,
    /// The second reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub check_method: Option<String>,
    /// Relative tolerance of the second reference [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub check_relative_tolerance: Option<f64>,
    /// Chaotic motion only: standard error of the level by ten batch means, worst of all axes as in `level_error_db` [dB].
    /// Smaller level errors say nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub sampling_error_db: Option<f64>,
    /// Levels of the spindle's accelerations by channel [dB]; what stands still has none.
    pub levels_db: BTreeMap<String, f64>,
    /// The lines that are compared: the three strongest of each channel that is no more than 60 dB below the stronger.
    pub lines: Vec<ComparedLine>,
    /// Accepted steps.
    pub steps: u64,
    /// Evaluations of the equations of motion.
    pub rhs_evaluations: u64,
    /// Time that the reference took [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
}

/// A line of the reference's spectra.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedLine {
    /// The channel whose spectrum has the line.
    pub channel: String,
    /// Where it stands [Hz].
    #[schema(minimum = 0)]
    pub frequency_hz: f64,
    /// One-sided amplitude [m/s²].
    #[schema(minimum = 0)]
    pub amplitude: f64,
    /// Empty where no combination of the bearing's frequencies is near.
    pub label: String,
}

/// One method at one tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum PointAnswer {
    Succeeded(Box<MeasuredAnswer>),
    Failed(FailedAnswer),
}

/// The status of a run that has reached its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SucceededName {
    Succeeded,
}

/// The status of a run that has not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FailedName {
    Failed,
}

/// A run that has not reached its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FailedAnswer {
    /// Always `failed`.
    pub status: FailedName,
    /// The method asked for.
    #[schema(example = "dormand_prince")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(minimum = 0)]
    pub relative_tolerance: f64,
    /// Why, in words.
    pub reason: String,
    /// Until it failed [s]; absent where it was not tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub wall_time_s: Option<f64>,
}

/// What a finished run has shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeasuredAnswer {
    /// Always `succeeded`.
    pub status: SucceededName,
    /// The method asked for.
    #[schema(example = "gear")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(minimum = 0)]
    pub relative_tolerance: f64,
    /// Median over the repetitions [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
    /// What of it the processor gave to the run, median over the repetitions [s]: on a busy machine the fairer of the
    /// two; absent where the system does not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub processor_time_s: Option<f64>,
    /// Shortest and longest of the repetitions [s].
    #[schema(min_items = 2, max_items = 2)]
    pub wall_time_range_s: Vec<f64>,
    /// The method that ran; `auto` chooses.
    pub ran: String,
    /// Why that one, where it was chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub ran_because: Option<String>,
    /// Root mean square over components and output grid of the distance from the reference over the component's scale
    /// [-]; absent where a chaotic motion parts from the reference at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub trajectory_error: Option<f64>,
    /// Largest over components and output grid [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub largest_error: Option<f64>,
    /// Root mean square over the components at the last point compared [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub end_error: Option<f64>,
    /// Time over which the trajectories are compared, from `compared.begin_s` [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub compared_s: Option<f64>,
    /// `trajectory_error` over `relative_tolerance` [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error_over_tolerance: Option<f64>,
    /// The reference's own trajectory error over the same time [-]; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub reference_trajectory_error: Option<f64>,
    /// The trajectory's error is below ten times that, and says nothing.
    pub below_reference: bool,
    /// Worst of the levels of the spindle's accelerations (x where it moves there, y, z) [dB], without one more than 60 dB below
    /// another: such a level is made of rounding and tolerances, and every run makes its own. Absent where nothing moves
    /// or the time is too short for a level.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// The level's error is below ten times the reference's own, in chaotic motion below the sampling error or the reference's own, and says
    /// nothing.
    pub level_below_reference: bool,
    /// Worst of `reference.lines` [Hz].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub line_frequency_error_hz: Option<f64>,
    /// Relative, worst of `reference.lines` [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub line_amplitude_error: Option<f64>,
    /// Accepted steps.
    pub steps: u64,
    /// Steps that were tried again with a smaller size.
    pub rejected_steps: u64,
    /// Newton iterations of implicit methods that did not converge.
    pub newton_failures: u64,
    /// Evaluations of the equations of motion.
    pub rhs_evaluations: u64,
    /// Evaluations of their Jacobian.
    pub jacobian_evaluations: u64,
    /// Factorizations of the matrix of the implicit methods.
    pub factorizations: u64,
    /// Mean step [s].
    #[schema(minimum = 0)]
    pub mean_step_s: f64,
    /// Smallest step [s].
    #[schema(minimum = 0)]
    pub least_step_s: f64,
}

/// What is compared, over which time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedAnswer {
    /// Bearing, speed and load, in words.
    #[serde(default)]
    #[schema(example = "6205, 3000 r/min, 500 N radial")]
    pub scene: String,
    /// How errors are made from states, in words.
    pub quantity: String,
    /// Every run starts at this time [s] from the same state.
    #[schema(minimum = 0)]
    pub begin_s: f64,
    /// How that state came about.
    pub start: String,
    /// Levels and lines are of `duration_s` after this time [s].
    #[schema(minimum = 0)]
    pub settle_s: f64,
    /// Time simulated and kept after settling [s].
    #[schema(minimum = 0)]
    pub duration_s: f64,
    /// Points of the output grid.
    pub grid_points: u64,
    /// Distance of the points of the output grid [s].
    #[schema(minimum = 0)]
    pub grid_step_s: f64,
    /// Number of first-order states.
    pub states: u64,
    /// The rung of the ladder of models that every run solves.
    pub rung: String,
    /// `decaying` or `diverging`; absent where the run is too short to tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub motion: Option<MotionName>,
    /// Rate at which neighbouring runs part; negative: they meet [1/s]. Says nothing where `motion` is absent.
    pub divergence_rate_per_s: f64,
    /// Over which time trajectories are compared, and why, in words.
    pub horizon: String,
}

/// What is timed, and what a run may take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TimingAnswer {
    /// Timed runs of each point.
    pub repetitions: u64,
    /// Threads of a run.
    pub threads: u64,
    /// What the times contain, in words.
    pub inside: String,
    /// What they do not contain, in words.
    pub outside: String,
    /// What runs before it is timed, in words.
    pub warm_up: String,
    /// Evaluations of the equations after which a run is given up.
    pub most_evaluations: u64,
}

/// How to measure the same again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RepeatAnswer {
    /// With `job` in the file `JOB.json`.
    #[schema(example = "raceway accuracy JOB.json")]
    pub command: String,
    /// The whole job, every default filled in.
    #[schema(value_type = JobInput)]
    pub job: Value,
}

impl WorkPrecisionAnswer {
    pub fn of(job: &Job, plan: &Plan, study: &WorkPrecision) -> Self {
        let reference = ReferenceAnswer::from(&study.reference);
        let points: Vec<PointAnswer> = study.points.iter().map(PointAnswer::from).collect();
        Self {
            recommended: recommended(&reference, &points),
            reference,
            points,
            compared: compared(job, study),
            timing: TimingAnswer {
                repetitions: plan.repetitions.into(),
                threads: 1,
                inside: "integration, looks at the motion as in any run, interpolation to the output grid".into(),
                outside: "equilibrium, settling, reference, spectra, comparison".into(),
                warm_up: "before each point an untimed run over the first twentieth of the time".into(),
                most_evaluations: study.most_evaluations,
            },
            machine: MachineAnswer::here(),
            repeat: RepeatAnswer { command: "raceway accuracy JOB.json".into(), job: job.complete() },
            left_out: study.left_out.iter().map(LeftOutAnswer::from).collect(),
        }
    }
}

fn compared(job: &Job, study: &WorkPrecision) -> ComparedAnswer {
    let diverging = study.motion == Some(crate::simulation::error::report::MotionKind::Diverging);
    ComparedAnswer {
        scene: scene_in_words(job),
        quantity: format!(
            "(state − reference)/scale; scale: standard deviation of the component in the reference over the grid, at \
             least {LEAST_SCALE} of its natural size; levels and lines: of each channel no more than {FAINT} dB below the \
             stronger"
        ),
        begin_s: study.begin,
        start: if study.begin > 0.0 {
            format!("settled by `{}` at a relative tolerance of {:e}", SETTLING.0.name(), SETTLING.1)
        } else {
            "static equilibrium".into()
        },
        settle_s: job.settings.settle,
        duration_s: job.settings.duration,
        grid_points: study.grid.1 as u64,
        grid_step_s: study.grid.0,
        states: study.states as u64,
        rung: study.rung.to_owned(),
        motion: study.motion.map(MotionName::from),
        divergence_rate_per_s: study.divergence_rate,
        horizon: if diverging {
            format!(
                "chaotic: trajectories are compared while tolerance · exp(rate · time) < {MOST_GROWN} (`compared_s`), \
                 levels over the whole time and with their sampling error"
            )
        } else {
            "the whole time".into()
        },
    }
}

impl From<&Reference> for ReferenceAnswer {
    fn from(reference: &Reference) -> Self {
        let levels = reference.levels.iter().filter_map(|(channel, level)| Some((channel.to_string(), (*level)?)));
        let lines = reference.lines.iter().map(|(channel, line)| ComparedLine {
            channel: channel.to_string(),
            frequency_hz: line.frequency,
            amplitude: line.amplitude,
            label: line.label.clone(),
        });
        Self {
            method: reference.method.name().to_owned(),
            relative_tolerance: reference.relative_tolerance,
            own_error_db: reference.own_error_db,
            own_trajectory_error: reference.own_trajectory.map(|own| own.rms),
            check_method: reference.check.map(|check| check.0.name().to_owned()),
            check_relative_tolerance: reference.check.map(|check| check.1),
            sampling_error_db: reference.sampling_error_db,
            levels_db: levels.collect(),
            lines: lines.collect(),
            steps: reference.statistics.steps,
            rhs_evaluations: reference.statistics.rhs_evaluations,
            wall_time_s: reference.taken.wall,
        }
    }
}

impl From<&Point> for PointAnswer {
    fn from(point: &Point) -> Self {
        match &point.measured {
            Ok(measured) => Self::Succeeded(Box::new(measured_answer(point, measured))),
            Err(reason) => Self::Failed(FailedAnswer {
                status: FailedName::Failed,
                method: point.method.name().to_owned(),
                relative_tolerance: point.relative_tolerance,
                reason: reason.clone(),
                wall_time_s: median(&wall_times(point)),
            }),
        }
    }
}

impl PointAnswer {
    /// What it has shown, unless it has failed.
    pub fn measured(&self) -> Option<&MeasuredAnswer> {
        match self {
            Self::Succeeded(point) => Some(point),
            Self::Failed(_) => None,
        }
    }

    pub fn method(&self) -> &str {
        match self {
            Self::Succeeded(point) => &point.method,
            Self::Failed(point) => &point.method,
        }
    }

    pub fn relative_tolerance(&self) -> f64 {
        match self {
            Self::Succeeded(point) => point.relative_tolerance,
            Self::Failed(point) => point.relative_tolerance,
        }
    }
}

/// Of each repetition [s].
fn wall_times(point: &Point) -> Vec<f64> {
    point.taken.iter().map(|taken| taken.wall).collect()
}

fn measured_answer(point: &Point, measured: &Measured) -> MeasuredAnswer {
    let Measured { choice, statistics, errors, own_trajectory, below_reference, level_below_reference } = measured;
    let trajectory = |of: fn(&TrajectoryError) -> f64| errors.trajectory.as_ref().map(of);
    let wall_times = wall_times(point);
    let least = wall_times.iter().copied().fold(f64::INFINITY, f64::min);
    let most = wall_times.iter().copied().fold(0.0, f64::max);
    let processor_times: Vec<f64> = point.taken.iter().filter_map(|taken| taken.processor).collect();
    MeasuredAnswer {
        status: SucceededName::Succeeded,
        method: point.method.name().to_owned(),
        relative_tolerance: point.relative_tolerance,
        wall_time_s: median(&wall_times).unwrap_or(0.0),
        processor_time_s: median(&processor_times),
        wall_time_range_s: vec![least, most],
        ran: choice.method.name().to_owned(),
        ran_because: choice.reason.clone(),
        trajectory_error: trajectory(|error| error.rms),
        largest_error: trajectory(|error| error.largest),
        end_error: trajectory(|error| error.end),
        compared_s: trajectory(|error| error.compared),
        error_over_tolerance: errors.trajectory.map(|error| error.rms / point.relative_tolerance),
        reference_trajectory_error: *own_trajectory,
        below_reference: *below_reference,
        level_error_db: errors.level_db,
        level_below_reference: *level_below_reference,
        line_frequency_error_hz: errors.line_frequency,
        line_amplitude_error: errors.line_amplitude,
        steps: statistics.steps,
        rejected_steps: statistics.rejected_steps,
        newton_failures: statistics.newton_failures,
        rhs_evaluations: statistics.rhs_evaluations,
        jacobian_evaluations: statistics.jacobian_evaluations,
        factorizations: statistics.factorizations,
        mean_step_s: statistics.advanced / statistics.steps.max(1) as f64,
        least_step_s: statistics.least_step,
    }
}

/// Errors below this are the reference's own, in a trajectory and in a level [dB]: what plots draw as a floor. Chaotic
/// trajectories are each compared over a time of their own, and have no common one.
pub fn floors(reference: &ReferenceAnswer) -> (Option<f64>, Option<f64>) {
    let own = reference.own_trajectory_error.filter(|own| *own > 0.0 && reference.sampling_error_db.is_none());
    let level = level_floor(reference.own_error_db, reference.sampling_error_db).filter(|floor| *floor > 0.0);
    (own.map(|own| ABOVE_OWN_ERROR * own), level)
}
