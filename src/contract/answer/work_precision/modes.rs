//! The result of an accuracy job of a shaft.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use raceway_core::machine::input::Machine;
use raceway_core::machine::mode_precision::ModePrecision;
use raceway_core::simulation::error::comparison::FAINT;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::machine::MachineAnswer;
use super::mode_point::{MeasuredModesAnswer, ModePointAnswer, by_channel};
use super::recommended::RECOMMENDED_ERRORS_DB;
use super::result::{RepeatAnswer, WorkPrecisionAnswer};
use crate::contract::job::mode_comparison::ModeComparison;
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::units::US;

/// Result of an accuracy job: of methods and tolerances for a scene of one bearing, of the number of modes for a scene with a `shaft`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum AccuracyJobAnswer {
    Methods(Box<WorkPrecisionAnswer>),
    Modes(Box<ModePrecisionAnswer>),
}

/// Run time and error of several numbers of modes, for one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModePrecisionAnswer {
    /// The run that all others are compared with.
    pub reference: ModeReferenceAnswer,
    /// One point for each of `mode_ranges`, in their order.
    pub points: Vec<ModePointAnswer>,
    /// The cheapest point whose levels are within 0.1, 0.01 and 0.001 dB of the reference, and also those of each point with more modes. Cost is
    /// processor time where it is measured, else wall time. Absent for an error that no point reaches.
    pub recommended: Vec<RecommendedModesAnswer>,
    /// The compared quantities and times.
    pub compared: ComparedModesAnswer,
    /// Parts that the run times include.
    pub timing: ModeTimingAnswer,
    /// The machine and the build that were timed.
    pub machine: MachineAnswer,
    /// How to repeat the measurement.
    pub repeat: RepeatAnswer,
}

/// The run that all others are compared with: more modes, and half steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModeReferenceAnswer {
    /// Highest frequency of its modes over 20 kHz [-].
    #[schema(example = 5.0, minimum = 0)]
    pub mode_range: f64,
    /// Its step [µs]: half of that of all other runs.
    #[schema(minimum = 0)]
    pub step_us: f64,
    /// Number of coordinates of shaft and housing.
    pub coordinates: u64,
    /// Number of first-order states of shaft, balls and cages.
    pub states: u64,
    /// The compared levels by channel [dB re 9.81 mm/s²]; absent of channels that are silent or more than 60 dB below the strongest.
    pub levels_db: BTreeMap<String, f64>,
    /// Deviation of a run with the same modes at the step of all other runs [dB], by channel: the error of that step alone. An error of order 2
    /// is a third as large in the reference itself. In chaotic motion it shows by how much two runs differ by chance.
    pub step_errors_db: BTreeMap<String, f64>,
    /// Evaluations of all bearings: of the reference, of the run at the step of the others, and of longer steps that were rejected.
    pub evaluations: u64,
    /// Wall time of all these, analysis of the shaft included [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
}

/// The cheapest point within a level error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RecommendedModesAnswer {
    /// Largest accepted deviation of a level from the reference [dB].
    #[schema(example = 0.01, minimum = 0)]
    pub within_db: f64,
    /// Highest frequency of the kept modes over 20 kHz [-].
    #[schema(example = 1.5, minimum = 0)]
    pub mode_range: f64,
    /// Wall time of the point [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
    /// Processor time of the point [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub processor_time_s: Option<f64>,
    /// Largest level error of the point [dB].
    #[schema(minimum = 0)]
    pub level_error_db: f64,
}

/// The compared quantities and times of a machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedModesAnswer {
    /// Bearings and speed.
    #[schema(example = "shaft on A, B, 12000 r/min")]
    pub scene: String,
    /// Definition of the errors.
    pub quantity: String,
    /// Origin of the state that each run starts from.
    pub start: String,
    /// Step of all runs but the reference [µs].
    #[schema(minimum = 0)]
    pub step_us: f64,
    /// Time simulated before the record [s].
    #[schema(minimum = 0)]
    pub settle_s: f64,
    /// Recorded time [s].
    #[schema(minimum = 0)]
    pub duration_s: f64,
}

/// Parts that the run times of a machine include.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ModeTimingAnswer {
    /// Number of timed runs of each point.
    pub repetitions: u64,
    /// Number of threads of a run.
    pub threads: u64,
    /// Parts of a run that the times include.
    pub inside: String,
    /// Parts of a run that the times exclude.
    pub outside: String,
    /// Largest number of other runs of the same process during the job, sampled with its progress; absent without a service.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub most_other_runs: Option<u64>,
}

impl ModePrecisionAnswer {
    pub fn of(comparison: &ModeComparison, found: &ModePrecision) -> Self {
        let (machine, plan, reference) = (&comparison.machine, &comparison.plan, &found.reference);
        let points: Vec<_> = found.points.iter().map(|point| ModePointAnswer::of(machine, point)).collect();
        let step_us = significant(US.to_user(found.step), 9);
        Self {
            reference: ModeReferenceAnswer {
                mode_range: plan.reference_range,
                step_us: 0.5 * step_us,
                coordinates: reference.size.coordinates as u64,
                states: reference.size.states as u64,
                levels_db: by_channel(machine, &reference.levels),
                step_errors_db: by_channel(machine, &reference.step_errors),
                evaluations: reference.work.evaluations,
                wall_time_s: reference.taken.wall,
            },
            recommended: recommended(&points),
            points,
            compared: ComparedModesAnswer {
                scene: heading(machine),
                quantity: format!(
                    "level of each acceleration from 0 to 20 kHz, at most {FAINT} dB below the strongest, less that of the reference"
                ),
                start: "static equilibrium, with the linear response to unbalance and harmonic loads".into(),
                step_us,
                settle_s: found.settle,
                duration_s: found.duration,
            },
            timing: ModeTimingAnswer {
                repetitions: plan.repetitions.into(),
                threads: 1,
                inside: "settling, record, as in any run".into(),
                outside: "modes, equilibrium, reference, comparison".into(),
                most_other_runs: None,
            },
            machine: MachineAnswer::here(),
            repeat: RepeatAnswer { command: "raceway accuracy JOB.json".into(), job: comparison.complete() },
        }
    }
}

/// Bearings and speed: `shaft on A, B, 12000 r/min`.
fn heading(machine: &Machine) -> String {
    let rpm = |speed: f64| short(significant(60.0 * speed / TAU, 6));
    let points = machine.speed.points();
    let speeds = points.iter().map(|point| point.1);
    let (least, most) = (speeds.clone().fold(f64::INFINITY, f64::min), speeds.fold(0.0, f64::max));
    let speed = match machine.speed.is_constant() {
        true => rpm(machine.speed.at(0.0).1),
        false => format!("{} to {}", rpm(least), rpm(most)),
    };
    let names: Vec<&str> = machine.bearings.iter().map(|bearing| bearing.name.as_str()).collect();
    let held = if names.is_empty() { "supports".to_owned() } else { names.join(", ") };
    format!("shaft on {held}, {speed} r/min")
}

/// One recommendation for each error that some point reaches, largest error first.
fn recommended(points: &[ModePointAnswer]) -> Vec<RecommendedModesAnswer> {
    RECOMMENDED_ERRORS_DB.into_iter().filter_map(|within_db| cheapest(within_db, points)).collect()
}

/// The point with the least processor time, or the least wall time where the processor time of some point is unknown.
fn cheapest(within_db: f64, points: &[ModePointAnswer]) -> Option<RecommendedModesAnswer> {
    let measured = || points.iter().filter_map(ModePointAnswer::measured);
    let by_processor = measured().all(|point| point.processor_time_s.is_some());
    let time = |point: &MeasuredModesAnswer| match point.processor_time_s {
        Some(time) if by_processor => time,
        _ => point.wall_time_s,
    };
    let is_within = |point: &MeasuredModesAnswer| point.level_error_db.is_some_and(|error| error <= within_db);
    // Few modes may match the levels by chance; more of them must match, too.
    let is_confirmed =
        |point: &MeasuredModesAnswer| measured().filter(|other| other.mode_range >= point.mode_range).all(is_within);
    let best = measured().filter(|point| is_confirmed(point)).min_by(|a, b| time(a).total_cmp(&time(b)))?;
    Some(RecommendedModesAnswer {
        within_db,
        mode_range: best.mode_range,
        wall_time_s: best.wall_time_s,
        processor_time_s: best.processor_time_s,
        level_error_db: best.level_error_db?,
    })
}
