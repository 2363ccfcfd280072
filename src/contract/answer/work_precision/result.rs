//! The result of an accuracy job.

use raceway_core::simulation::error::comparison::FAINT;
use raceway_core::simulation::error::lyapunov::MotionKind;
use raceway_core::simulation::work_precision::{LEAST_SCALE, MOST_GROWN, SETTLING, WorkPrecision};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::machine::MachineAnswer;
use super::point::PointAnswer;
use super::recommended::{RecommendedAnswer, recommended};
use super::reference::ReferenceAnswer;
use crate::contract::answer::report::{LeftOutAnswer, MotionName};
use crate::contract::answer::scene_heading::scene_heading;
use crate::contract::job::comparison::Comparison;
use crate::contract::job::input::JobInput;
use crate::contract::job::simulation::Simulation;

/// Run time and error of several methods and tolerances, for one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WorkPrecisionAnswer {
    /// The run that all others are compared with.
    pub reference: ReferenceAnswer,
    /// One point for each method and tolerance, in the order of the methods, loosest tolerance first.
    pub points: Vec<PointAnswer>,
    /// The cheapest point whose level is within 0.1, 0.01 and 0.001 dB of the reference, and also the level at each tighter tolerance of
    /// the same method. Cost is processor time where it is measured, else wall time. Absent for an error that no point reaches, or that is
    /// smaller than the error of the reference.
    #[serde(default)]
    pub recommended: Vec<RecommendedAnswer>,
    /// The compared quantities and times.
    pub compared: ComparedAnswer,
    /// Parts that the run times include.
    pub timing: TimingAnswer,
    /// The machine and the build that were timed.
    pub machine: MachineAnswer,
    /// How to repeat the measurement.
    pub repeat: RepeatAnswer,
    /// Terms that are not in the equations, with any method.
    pub left_out: Vec<LeftOutAnswer>,
}

/// The compared quantities and times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedAnswer {
    /// Bearing, speed and load.
    #[serde(default)]
    #[schema(example = "6205, 3000 r/min, 500 N radial")]
    pub scene: String,
    /// Definition of the errors.
    pub quantity: String,
    /// Every run starts at this time [s] from the same state.
    #[schema(minimum = 0)]
    pub begin_s: f64,
    /// Origin of that state.
    pub start: String,
    /// Levels and lines cover `duration_s` after this time [s].
    #[schema(minimum = 0)]
    pub settle_s: f64,
    /// Recorded time after settling [s].
    #[schema(minimum = 0)]
    pub duration_s: f64,
    /// Number of points of the output grid.
    pub grid_points: u64,
    /// Step of the output grid [s].
    #[schema(minimum = 0)]
    pub grid_step_s: f64,
    /// Number of first-order states.
    pub states: u64,
    /// The model level that every run solves.
    pub rung: String,
    /// `decaying` or `diverging`; absent where the run is too short to decide.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub motion: Option<MotionName>,
    /// Rate at which neighbouring trajectories diverge [1/s]; negative: they converge. Not significant where `motion` is absent.
    pub divergence_rate_per_s: f64,
    /// Time over which trajectories are compared, with the reason.
    pub horizon: String,
}

/// Parts that the run times include, and the limit of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TimingAnswer {
    /// Number of timed runs of each point.
    pub repetitions: u64,
    /// Number of threads of a run.
    pub threads: u64,
    /// Parts of a run that the times include.
    pub inside: String,
    /// Parts of a run that the times exclude.
    pub outside: String,
    /// Untimed run before each point.
    pub warm_up: String,
    /// Number of evaluations of the equations after which a run is aborted.
    pub most_evaluations: u64,
    /// Largest number of other runs of the same process during the job, sampled with its progress; absent without a service. Other
    /// runs share memory and caches, so that times grow a little with their number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub most_other_runs: Option<u64>,
}

/// How to repeat the measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RepeatAnswer {
    /// Command to run, with `job` in the file `JOB.json`.
    #[schema(example = "raceway accuracy JOB.json")]
    pub command: String,
    /// The job with all defaults filled in.
    #[schema(value_type = JobInput)]
    pub job: Value,
}

impl WorkPrecisionAnswer {
    pub fn of(comparison: &Comparison, study: &WorkPrecision) -> Self {
        let reference = ReferenceAnswer::from(&study.reference);
        let points: Vec<PointAnswer> = study.points.iter().map(PointAnswer::from).collect();
        Self {
            recommended: recommended(&reference, &points),
            reference,
            points,
            compared: compared(&comparison.base, study),
            timing: TimingAnswer {
                repetitions: comparison.plan.repetitions.into(),
                threads: 1,
                inside: "integration, recording as in any run, interpolation to the output grid".into(),
                outside: "equilibrium, settling, reference, spectra, comparison".into(),
                warm_up: "an untimed run over the first twentieth of the time before each point".into(),
                most_evaluations: study.most_evaluations,
                most_other_runs: None,
            },
            machine: MachineAnswer::here(),
            repeat: RepeatAnswer { command: "raceway accuracy JOB.json".into(), job: comparison.complete() },
            left_out: study.left_out.iter().map(LeftOutAnswer::from).collect(),
        }
    }
}

fn compared(base: &Simulation, study: &WorkPrecision) -> ComparedAnswer {
    let diverging = study.motion == Some(MotionKind::Diverging);
    ComparedAnswer {
        scene: scene_heading(base),
        quantity: format!(
            "(state − reference)/scale; scale: standard deviation of the component in the reference over the grid, at \
             least {LEAST_SCALE} of its natural size; levels and lines: of each channel at most {FAINT} dB below the \
             strongest"
        ),
        begin_s: study.begin,
        start: if study.begin > 0.0 {
            format!("settled by `{}` at a relative tolerance of {:e}", SETTLING.0.name(), SETTLING.1)
        } else {
            "static equilibrium".into()
        },
        settle_s: base.settings.settle,
        duration_s: base.settings.duration,
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
