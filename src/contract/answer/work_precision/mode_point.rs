//! Runs of a machine with modes up to one frequency: cost and errors.

use std::collections::BTreeMap;

use raceway_core::machine::channel::MachineChannel;
use raceway_core::machine::input::Machine;
use raceway_core::machine::mode_precision::{ModeMeasured, ModePoint};
use raceway_core::numerics::statistics::median;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::point::{FailedName, SucceededName};

/// Runs with modes up to one frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum ModePointAnswer {
    Succeeded(Box<MeasuredModesAnswer>),
    Failed(FailedModesAnswer),
}

/// A run that failed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FailedModesAnswer {
    /// Always `failed`.
    pub status: FailedName,
    /// Highest frequency of the kept modes over 20 kHz [-].
    #[schema(minimum = 0)]
    pub mode_range: f64,
    /// Reason of the failure.
    pub reason: String,
    /// Wall time until the failure [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
}

/// A finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeasuredModesAnswer {
    /// Always `succeeded`.
    pub status: SucceededName,
    /// Highest frequency of the kept modes over 20 kHz [-].
    #[schema(example = 1.5, minimum = 0)]
    pub mode_range: f64,
    /// Number of coordinates of shaft and housing: modes, and static answers of the rest.
    pub coordinates: u64,
    /// Number of first-order states of shaft, balls and cages.
    pub states: u64,
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
    /// Steps of a run.
    pub steps: u64,
    /// Evaluations of all bearings in a run.
    pub evaluations: u64,
    /// Largest of `level_errors_db` [dB]; absent without motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// Largest of `mode_errors_db` [dB]; absent without motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub mode_error_db: Option<f64>,
    /// Deviation of the level of each acceleration from the reference [dB], by channel: of modes and step together. Channels more than 60 dB
    /// below the strongest are absent.
    pub level_errors_db: BTreeMap<String, f64>,
    /// Deviation from a run with the modes of the reference at the same step [dB], by channel: of the modes alone.
    pub mode_errors_db: BTreeMap<String, f64>,
}

impl ModePointAnswer {
    pub(super) fn of(machine: &Machine, point: &ModePoint) -> Self {
        let wall_times: Vec<f64> = point.taken.iter().map(|taken| taken.wall).collect();
        match &point.measured {
            Ok(measured) => Self::Succeeded(Box::new(measured_answer(machine, point, measured, &wall_times))),
            Err(reason) => Self::Failed(FailedModesAnswer {
                status: FailedName::Failed,
                mode_range: point.range,
                reason: reason.clone(),
                wall_time_s: median(&wall_times).unwrap_or(0.0),
            }),
        }
    }

    /// The measurement, unless the run has failed.
    pub fn measured(&self) -> Option<&MeasuredModesAnswer> {
        match self {
            Self::Succeeded(point) => Some(point),
            Self::Failed(_) => None,
        }
    }

    pub fn mode_range(&self) -> f64 {
        match self {
            Self::Succeeded(point) => point.mode_range,
            Self::Failed(point) => point.mode_range,
        }
    }
}

fn measured_answer(
    machine: &Machine,
    point: &ModePoint,
    measured: &ModeMeasured,
    wall_times: &[f64],
) -> MeasuredModesAnswer {
    let ModeMeasured { size, work, errors, mode_errors } = measured;
    let processor_times: Vec<f64> = point.taken.iter().filter_map(|taken| taken.processor).collect();
    MeasuredModesAnswer {
        status: SucceededName::Succeeded,
        mode_range: point.range,
        coordinates: size.coordinates as u64,
        states: size.states as u64,
        wall_time_s: median(wall_times).unwrap_or(0.0),
        processor_time_s: median(&processor_times),
        wall_time_range_s: vec![
            wall_times.iter().copied().fold(f64::INFINITY, f64::min),
            wall_times.iter().copied().fold(0.0, f64::max),
        ],
        steps: work.steps,
        evaluations: work.evaluations,
        level_error_db: largest(errors),
        mode_error_db: largest(mode_errors),
        level_errors_db: by_channel(machine, errors),
        mode_errors_db: by_channel(machine, mode_errors),
    }
}

fn largest(values: &[(MachineChannel, f64)]) -> Option<f64> {
    values.iter().map(|(_, value)| *value).reduce(f64::max)
}

/// Values by the names of their channels.
pub(super) fn by_channel(machine: &Machine, values: &[(MachineChannel, f64)]) -> BTreeMap<String, f64> {
    values.iter().map(|(channel, value)| (channel.named(machine).to_string(), *value)).collect()
}
