//! The run that all others of an accuracy job are compared with.

use std::collections::BTreeMap;

use raceway_core::simulation::work_precision::{ABOVE_OWN_ERROR, Reference, level_floor};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The run that all others are compared with, and its own error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ReferenceAnswer {
    /// Method of the reference.
    #[schema(example = "radau")]
    pub method: String,
    /// Its relative tolerance [-].
    #[schema(minimum = 0)]
    pub relative_tolerance: f64,
    /// Level difference between two references, as `level_error_db` of a point [dB]. Absent without motion, where the time is too short
    /// for a level, or where no second reference finished.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub own_error_db: Option<f64>,
    /// Trajectory difference between two references, as `trajectory_error` [-]. Absent for chaotic motion: there each point has its own
    /// compared time (`compared_s`) and its own `reference_trajectory_error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub own_trajectory_error: Option<f64>,
    /// Method of the second reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub check_method: Option<String>,
    /// Relative tolerance of the second reference [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub check_relative_tolerance: Option<f64>,
    /// Chaotic motion only: standard error of the level from ten batch means, largest of all axes [dB]. Smaller level errors are not
    /// significant.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub sampling_error_db: Option<f64>,
    /// Levels of the spindle's accelerations by channel [dB]; absent for directions without motion.
    pub levels_db: BTreeMap<String, f64>,
    /// The compared lines: the three strongest of each channel that is at most 60 dB below the strongest channel.
    pub lines: Vec<ComparedLine>,
    /// Accepted steps.
    pub steps: u64,
    /// Evaluations of the equations of motion.
    pub rhs_evaluations: u64,
    /// Wall time of the reference [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
}

/// A line of the reference's spectra.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedLine {
    /// The channel whose spectrum has the line.
    pub channel: String,
    /// Frequency of the line [Hz].
    #[schema(minimum = 0)]
    pub frequency_hz: f64,
    /// One-sided amplitude [m/s²].
    #[schema(minimum = 0)]
    pub amplitude: f64,
    /// Nearest combination of the bearing's frequencies; empty where none is near.
    pub label: String,
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

/// Error of the reference, in a trajectory [-] and in a level [dB]: smaller errors of a point are not significant. Chaotic trajectories
/// have different compared times and no common value.
pub fn floors(reference: &ReferenceAnswer) -> (Option<f64>, Option<f64>) {
    let own = reference.own_trajectory_error.filter(|own| *own > 0.0 && reference.sampling_error_db.is_none());
    let level = level_floor(reference.own_error_db, reference.sampling_error_db).filter(|floor| *floor > 0.0);
    (own.map(|own| ABOVE_OWN_ERROR * own), level)
}
