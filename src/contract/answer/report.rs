//! Solver, accuracy and omitted terms of a result, as JSON.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::messages;
use crate::contract::json::numbers::significant;
use raceway_core::machine::terms::OmittedTerm;
use raceway_core::physics::kinematics::CharacteristicFrequencies;
use raceway_core::simulation::error::codes::Quantity;
use raceway_core::simulation::error::errors::QuantityErrors;
use raceway_core::simulation::error::lyapunov::MotionKind;
use raceway_core::simulation::error::report::AccuracyReport;
use raceway_core::simulation::input::settings::Outputs;
use raceway_core::simulation::model::terms::{Justification, LeftOut};
use raceway_core::simulation::result::metrics::SolverReport;

/// Characteristic frequencies [Hz].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrequenciesAnswer {
    /// Shaft speed, f_r [Hz].
    pub shaft: f64,
    /// Speed of the outer ring, f_o [Hz]; absent where it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub outer_ring: Option<f64>,
    /// Balls passing a direction in space, such as that of the load [Hz]; absent where the outer ring stands, because it is BPFO there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub ball_pass: Option<f64>,
    /// Cage speed, FTF [Hz].
    pub cage: f64,
    /// Ball pass frequency of the outer raceway, BPFO [Hz].
    pub ball_pass_outer: f64,
    /// Ball pass frequency of the inner raceway, BPFI [Hz].
    pub ball_pass_inner: f64,
    /// Ball spin frequency, BSF [Hz]: turns of a ball in the frame of the cage.
    pub ball_spin: f64,
    /// Strikes of a defect on a ball, 2·BSF [Hz]: it meets both raceways in a turn.
    // Results of earlier versions have none.
    #[serde(default)]
    #[schema(required = true)]
    pub ball_defect: f64,
}

/// The solver that ran, and its work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverAnswer {
    /// The integrator that ran: the requested one, the choice of `auto`, or that of a reduced model level.
    #[schema(example = "gear")]
    pub method: String,
    /// Model level of the result.
    #[schema(example = "full")]
    pub rung: String,
    /// Verification of the model level, as one sentence.
    pub check: String,
    /// Relative tolerance of the run [-]; tighter than requested where `auto` found the integration error to exceed the level. Absent for
    /// integrators without a tolerance: those of the reduced model levels, and fixed steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub relative_tolerance: Option<f64>,
    /// Accepted steps.
    pub steps: u64,
    /// Steps that were repeated with a smaller size.
    pub rejected_steps: u64,
    /// Evaluations of the equations of motion.
    pub rhs_evaluations: u64,
    /// Evaluations of their Jacobian.
    pub jacobian_evaluations: u64,
    /// Factorizations of the matrix of the implicit methods.
    pub factorizations: u64,
    /// Wall time of the run [s].
    #[schema(minimum = 0)]
    pub wall_time_s: f64,
    /// Simulated time, settling included [s].
    #[schema(minimum = 0)]
    pub simulated_time_s: f64,
    /// Simulated time divided by wall time [-].
    #[schema(minimum = 0)]
    pub real_time_factor: f64,
    /// Number of first-order states.
    pub states: u64,
    /// Number of strips per raceway contact in the traction integral.
    pub strips: u64,
    /// Mean step of the integrator [s].
    #[schema(minimum = 0)]
    pub mean_step_s: f64,
    /// Smallest step of the integrator [s].
    #[schema(minimum = 0)]
    pub least_step_s: f64,
}

/// Estimated errors of the result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AccuracyAnswer {
    /// Estimated error of the acceleration levels, largest of all channels [dB]; absent where there is no level.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// Relative error of the largest contact load [-]; absent where the run could not be verified.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_load_error: Option<f64>,
    /// Relative error of the cage speed [-]; without a cage, of the mean orbit speed of the balls.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub cage_speed_error: Option<f64>,
    /// Error of `cage_slip` [-]; with the metrics `cage`, absent where `cage_slip` is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub cage_slip_error: Option<f64>,
    /// Relative error of the largest pocket load [-]; with the metrics `cage`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_pocket_load_error: Option<f64>,
    /// Relative error of the largest slip, larger of both raceways [-]; with the metrics `contacts`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_slip_error: Option<f64>,
    /// Relative error of the radius of the cage's orbit [-]; with the metrics `cage`. Absent below 0.01 µm, and on a reduced model level with a
    /// crown cage, whose slow tilt the verification does not cover.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub orbit_radius_error: Option<f64>,
    /// How these errors were estimated, as one sentence.
    pub how: String,
    /// `decaying`: neighbouring trajectories converge, the motion is regular. `diverging`: they diverge, the motion is chaotic.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub motion: Option<MotionName>,
    /// Rate at which neighbouring trajectories diverge [1/s]; negative: they converge. A small positive rate is no chaos: azimuths drift apart
    /// in steady motion, too. Absent where `motion` is absent because the run is too short.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub divergence_rate_per_s: Option<f64>,
}

/// `decaying`: neighbouring trajectories converge, or diverge by less than a factor of e² over 10 ms or the whole run.
/// `diverging`: they diverge by more, the motion is chaotic.
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
    /// Reason of the omission.
    pub reason: String,
    /// Justification of the omission.
    pub by: GroundsName,
    /// Size of the omitted effect, in `unit`; absent where it is zero or unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub bound: Option<f64>,
    /// Unit of `bound`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub unit: Option<String>,
}

/// `identity`: the omission does not change the result. `judgement`: its effect is bounded. `convention`: omitted by a named convention or on
/// request.
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
            outer_ring: (f.outer_ring > 0.0).then_some(f.outer_ring),
            ball_pass: (f.outer_ring > 0.0).then_some(f.ball_pass),
            cage: f.cage,
            ball_pass_outer: f.ball_pass_outer,
            ball_pass_inner: f.ball_pass_inner,
            ball_spin: f.ball_spin,
            ball_defect: 2.0 * f.ball_spin,
        }
    }
}

impl SolverAnswer {
    /// How a run was solved, and how its model level was verified.
    pub fn of(report: &SolverReport, accuracy: &AccuracyReport) -> Self {
        let work = &report.statistics;
        Self {
            method: report.method.to_owned(),
            rung: report.level.name().to_owned(),
            check: messages::check(report, &accuracy.basis),
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
    /// The errors of a run, without those of metrics that were not requested.
    pub fn of(report: &AccuracyReport, outputs: &Outputs) -> Self {
        let share = |of: fn(&QuantityErrors) -> f64, quantity: Quantity| {
            let errors = report.quantity_errors.as_ref().filter(|_| !report.unverified.contains(&quantity));
            errors.map(|errors| significant(of(errors), 3))
        };
        Self {
            level_error_db: report.level_error_db(),
            max_load_error: share(|errors| errors.max_load, Quantity::MaxLoad),
            cage_speed_error: share(|errors| errors.cage_speed, Quantity::CageSpeed),
            cage_slip_error: share(|errors| errors.cage_slip, Quantity::CageSpeed),
            max_pocket_load_error: share(|errors| errors.max_pocket_load, Quantity::PocketLoad)
                .filter(|_| outputs.cage),
            orbit_radius_error: share(|errors| errors.orbit_radius, Quantity::CageOrbit).filter(|_| outputs.cage),
            max_slip_error: share(|errors| errors.max_slip, Quantity::Slip).filter(|_| outputs.contacts),
            how: messages::how(report),
            motion: report.motion.map(MotionName::from),
            divergence_rate_per_s: report.motion.map(|_| report.divergence_rate),
        }
    }

    /// The errors of a run with this slip of the cage.
    pub(super) fn with_slip_of(self, cage_slip: Option<f64>) -> Self {
        Self { cage_slip_error: self.cage_slip_error.filter(|_| cage_slip.is_some()), ..self }
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
            reason: messages::omission(left_out.reason),
            by: match left_out.by {
                Justification::Identity => GroundsName::Identity,
                Justification::Judgement => GroundsName::Judgement,
                Justification::Convention => GroundsName::Convention,
            },
            bound: bound.map(|bound| significant(bound.0, 3)),
            unit: bound.map(|bound| bound.1.to_owned()),
        }
    }
}

impl From<&OmittedTerm> for LeftOutAnswer {
    fn from(omitted: &OmittedTerm) -> Self {
        Self::from(&LeftOut::from(omitted))
    }
}
