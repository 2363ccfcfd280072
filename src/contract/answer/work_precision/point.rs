//! One method at one tolerance: its cost and its errors.

use raceway_core::numerics::statistics::median;
use raceway_core::simulation::work_precision::{Measured, Point, TrajectoryError};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::answer::messages::choice_text;

/// One method at one tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum PointAnswer {
    Succeeded(Box<MeasuredAnswer>),
    Failed(FailedAnswer),
}

/// Status of a run that finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SucceededName {
    Succeeded,
}

/// Status of a run that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FailedName {
    Failed,
}

/// A run that failed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FailedAnswer {
    /// Always `failed`.
    pub status: FailedName,
    /// The requested method.
    #[schema(example = "dormand_prince")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(minimum = 0)]
    pub relative_tolerance: f64,
    /// Reason of the failure.
    pub reason: String,
    /// Wall time until the failure [s]; absent where the run was not tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub wall_time_s: Option<f64>,
}

/// A finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeasuredAnswer {
    /// Always `succeeded`.
    pub status: SucceededName,
    /// The requested method.
    #[schema(example = "gear")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(minimum = 0)]
    pub relative_tolerance: f64,
    /// Wall time, median over the repetitions [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
    /// Processor time, median over the repetitions [s]; on a busy machine more reliable than wall time. Absent where the system does not
    /// report it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub processor_time_s: Option<f64>,
    /// Shortest and longest wall time of the repetitions [s].
    #[schema(min_items = 2, max_items = 2)]
    pub wall_time_range_s: Vec<f64>,
    /// The method that ran, also where `auto` chose it.
    pub ran: String,
    /// Reason of the choice, where `auto` chose the method.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub ran_because: Option<String>,
    /// Root mean square, over components and output grid, of the deviation from the reference divided by the component's scale [-].
    /// Absent where a chaotic motion diverges from the reference at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub trajectory_error: Option<f64>,
    /// Largest deviation over components and output grid [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub largest_error: Option<f64>,
    /// Root mean square deviation over the components at the last compared time [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub end_error: Option<f64>,
    /// Time over which the trajectories are compared, from `compared.begin_s` [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub compared_s: Option<f64>,
    /// `trajectory_error` divided by `relative_tolerance` [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub error_over_tolerance: Option<f64>,
    /// Trajectory error of the reference over the same time [-]; absent where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub reference_trajectory_error: Option<f64>,
    /// True if the trajectory error is below ten times that of the reference, and therefore not significant.
    pub below_reference: bool,
    /// Largest level error of the spindle's accelerations (y, z, and x where the spindle moves along it) [dB]. Omits levels more than 60 dB
    /// below another: these consist of rounding and truncation errors. Absent without motion, or where the time is too short for a level.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// True if the level error is not significant: below ten times that of the reference; in chaotic motion below the sampling error or the
    /// error of the reference.
    pub level_below_reference: bool,
    /// Largest frequency error of `reference.lines` [Hz].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub line_frequency_error_hz: Option<f64>,
    /// Largest relative amplitude error of `reference.lines` [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub line_amplitude_error: Option<f64>,
    /// Accepted steps.
    pub steps: u64,
    /// Steps that were repeated with a smaller size.
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
    /// Its errors and cost, unless it has failed.
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
        ran_because: choice.reason.as_ref().map(choice_text),
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
