//! How a result came about and how far it can be trusted, as JSON: frequencies, work, accuracy, what was left out.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::units::significant;
use crate::physics::kinematics::CharacteristicFrequencies;
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::error::report::MotionKind;
use crate::simulation::error::report::QuantityErrors;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::terms::{Grounds, LeftOut};
use crate::simulation::result::metrics::SolverReport;

/// Characteristic frequencies [Hz].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrequenciesAnswer {
    /// Turns of the shaft, f_r [Hz].
    pub shaft: f64,
    /// Turns of the cage, FTF [Hz].
    pub cage: f64,
    /// Passes of balls over a place on the outer raceway, BPFO [Hz].
    pub ball_pass_outer: f64,
    /// Passes of balls over a place on the inner raceway, BPFI [Hz].
    pub ball_pass_inner: f64,
    /// Spin of a ball about its own axis, BSF [Hz].
    pub ball_spin: f64,
}

/// What ran, and its work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverAnswer {
    /// The integrator that ran; `auto` and the reduced rungs choose.
    #[schema(example = "gear")]
    pub method: String,
    /// Why that one, in words.
    pub method_reason: String,
    /// The rung of the ladder of models that made the result.
    #[schema(example = "full")]
    pub rung: String,
    /// How the rung was checked against the next richer one, in words.
    pub check: String,
    /// The tolerance that was taken [-]; tighter than asked for where `auto` found more noise than level. Absent where the integrator
    /// follows none: those of the reduced rungs, and fixed steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub relative_tolerance: Option<f64>,
    /// Accepted steps.
    pub steps: u64,
    /// Steps that were tried again with a smaller size.
    pub rejected_steps: u64,
    /// Evaluations of the equations of motion.
    pub rhs_evaluations: u64,
    /// Evaluations of their Jacobian.
    pub jacobian_evaluations: u64,
    /// Factorizations of the matrix of the implicit methods.
    pub factorizations: u64,
    /// Time that the run took [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
    /// Time simulated, settling included [s].
    #[schema(minimum = 0)]
    pub simulated_time_s: f64,
    /// Simulated time over wall time [-].
    #[schema(minimum = 0)]
    pub real_time_factor: f64,
    /// Number of first-order states.
    pub states: u64,
    /// Strips a raceway contact is cut into for traction.
    pub strips: u64,
    /// Mean step of the integrator [s].
    #[schema(minimum = 0)]
    pub mean_step_s: f64,
    /// Smallest step of the integrator [s].
    #[schema(minimum = 0)]
    pub least_step_s: f64,
}

/// How far the result can be trusted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AccuracyAnswer {
    /// Estimated error of the worst acceleration level [dB]; absent where there is no level.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// Estimated error of the largest contact load, as a share of it [-]; absent where nothing could be repeated.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_load_error: Option<f64>,
    /// Estimated error of the cage speed (without a cage, of the balls' mean orbit speed), as a share of it [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub cage_speed_error: Option<f64>,
    /// Estimated error of the largest pocket load, as a share of it [-]; where the cage was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_pocket_load_error: Option<f64>,
    /// Estimated error of the largest slip, as a share of it [-], of the raceway where it is the larger; where contacts were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_slip_error: Option<f64>,
    /// Estimated error of the radius of the cage's orbit, as a share of it [-]; where the cage was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub orbit_radius_error: Option<f64>,
    /// How these errors were estimated, in words.
    pub how: String,
    /// `decaying`: neighbouring runs meet, the motion is regular. `diverging`: they part, it is chaotic.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub motion: Option<MotionName>,
    /// Rate at which neighbouring runs part; negative: they meet [1/s]. Slightly positive is no chaos: azimuths drift apart in the
    /// steadiest motion. Absent where `motion` is: too short to tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub divergence_rate_per_s: Option<f64>,
    /// Present where the level is not resolved (an error of more than 1 dB), where the largest contact load, the cage speed, or,
    /// asked for, the largest pocket load or slip or the cage's orbit is not (more than 10 %, chaotic motion apart), where the kept time is uneven, still settling or too short
    /// a sample of chaos for another stretch to be as stated, where a run could not be judged, or where a fixed step lies
    /// beyond the limit of stability: then the result is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub warning: Option<String>,
    /// Present where `settle_s` is so short that the kept time may still hold the vibration of the start, as the contacts' damping lets
    /// expect, or that of the cage along its axis, where contacts lean and the start was not damped, or where cage and balls may still come
    /// to tilt in viscous oil: no error that is stated contains that.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub settling: Option<String>,
}

/// `decaying`: neighbouring runs meet, or part by less than a factor of e² over the stretch that is watched (10 ms, or the run).
/// `diverging`: they part by more, the motion is chaotic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionName {
    Decaying,
    Diverging,
}

/// A term that is not in the equations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutAnswer {
    /// Name of the term, as in `scene.terms`.
    #[schema(example = "hydrodynamics")]
    pub term: String,
    /// Why it is not there, in words.
    pub reason: String,
    /// On what grounds.
    pub by: GroundsName,
    /// Size of the effect, in `unit`; absent where it is none or unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub bound: Option<f64>,
    /// Of `bound`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub unit: Option<String>,
}

/// `identity`: the result is the same. `judgement`: the effect is bounded. `convention`: by a named
/// convention or on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum GroundsName {
    Identity,
    Judgement,
    Convention,
}

impl From<CharacteristicFrequencies> for FrequenciesAnswer {
    fn from(f: CharacteristicFrequencies) -> Self {
        Self {
            shaft: f.shaft,
            cage: f.cage,
            ball_pass_outer: f.ball_pass_outer,
            ball_pass_inner: f.ball_pass_inner,
            ball_spin: f.ball_spin,
        }
    }
}

impl From<&SolverReport> for SolverAnswer {
    fn from(report: &SolverReport) -> Self {
        let work = &report.statistics;
        Self {
            method: report.method.to_owned(),
            method_reason: report.method_reason.clone(),
            rung: report.rung.to_owned(),
            check: report.check.clone(),
            steps: work.steps,
            rejected_steps: work.rejected_steps,
            rhs_evaluations: work.rhs_evaluations,
            jacobian_evaluations: work.jacobian_evaluations,
            factorizations: work.factorizations,
            wall_time_s: report.wall_time,
            simulated_time_s: report.simulated_time,
            real_time_factor: report.simulated_time / report.wall_time.max(1e-9),
            relative_tolerance: report.relative_tolerance.map(|tolerance| significant(tolerance, 3)),
            states: report.states as u64,
            strips: report.strips as u64,
            mean_step_s: work.advanced / work.steps.max(1) as f64,
            least_step_s: work.least_step,
        }
    }
}

impl AccuracyAnswer {
    /// What is stated of a run, and of its peaks where they are shown.
    pub fn of(report: &AccuracyReport, settling: Option<&str>, outputs: &Outputs) -> Self {
        let share = |of: fn(&QuantityErrors) -> f64| report.quantity_errors.as_ref().map(|e| significant(of(e), 3));
        Self {
            level_error_db: report.level_error_db(),
            max_load_error: share(|errors| errors.max_load),
            cage_speed_error: share(|errors| errors.cage_speed),
            max_pocket_load_error: share(|errors| errors.max_pocket_load).filter(|_| outputs.cage),
            orbit_radius_error: share(|errors| errors.orbit_radius).filter(|_| outputs.cage),
            max_slip_error: share(|errors| errors.max_slip).filter(|_| outputs.contacts),
            how: report.how.clone(),
            motion: report.motion.map(MotionName::from),
            divergence_rate_per_s: report.motion.map(|_| report.divergence_rate),
            warning: report.warning.clone(),
            settling: settling.map(str::to_owned),
        }
    }
}

impl From<MotionKind> for MotionName {
    fn from(motion: MotionKind) -> Self {
        match motion {
            MotionKind::Decaying => Self::Decaying,
            MotionKind::Diverging => Self::Diverging,
        }
    }
}

impl From<&LeftOut> for LeftOutAnswer {
    fn from(left_out: &LeftOut) -> Self {
        let bound = left_out.bound.filter(|bound| bound.0.is_finite());
        Self {
            term: left_out.term.to_owned(),
            reason: left_out.reason.clone(),
            by: match left_out.by {
                Grounds::Identity => GroundsName::Identity,
                Grounds::Judgement => GroundsName::Judgement,
                Grounds::Convention => GroundsName::Convention,
            },
            bound: bound.map(|bound| bound.0),
            unit: bound.map(|bound| bound.1.to_owned()),
        }
    }
}
