//! Summary metrics of a finished run as JSON. What was not asked for is absent.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::physics::kinematics::CharacteristicFrequencies;
use crate::simulation::lines::Line;
use crate::simulation::metrics::{
    AccuracyReport, CageMetrics, ChannelMetrics, MotionKind, RacewayContactMetrics, SolverReport, Summary,
};
use crate::simulation::needs::{Grounds, LeftOut};
use crate::simulation::run::{Outputs, RunResult};

/// Everything a user reads first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Metrics {
    /// Statistics by channel (`vibration`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub channels: Option<BTreeMap<String, ChannelAnswer>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub contacts: Option<ContactsAnswer>,
    /// Mean speeds (`cage`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub kinematics: Option<KinematicsAnswer>,
    /// Orbit of the cage centre (`cage`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage: Option<CageAnswer>,
    pub frequencies_hz: FrequenciesAnswer,
    /// Strongest lines of the spectra (`vibration`), strongest first within a channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub lines: Option<Vec<LineAnswer>>,
    pub solver: SolverAnswer,
    pub accuracy: AccuracyAnswer,
    pub left_out: Vec<LeftOutAnswer>,
}

/// One channel over the kept time, mean removed, 0–20 kHz, in the channel's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChannelAnswer {
    #[schema(example = "m/s²")]
    pub unit: String,
    pub rms: f64,
    pub peak: f64,
    /// peak / rms [-]; absent where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub crest_factor: Option<f64>,
    /// Fourth moment over squared variance [-]; absent where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub kurtosis: Option<f64>,
    /// 20 lg(rms / 9.81e-3 m/s²) [dB]; accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_db: Option<f64>,
    /// Share of the power above 20 kHz [-].
    pub above_band: f64,
}

/// Contacts of the balls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ContactsAnswer {
    /// On the inner raceway (`contacts`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub inner: Option<RacewayAnswer>,
    /// On the outer raceway (`contacts`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub outer: Option<RacewayAnswer>,
    /// In the cage's pockets (`cage`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub pocket: Option<PocketAnswer>,
}

/// Contacts on one raceway: extremes over all balls and the kept time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RacewayAnswer {
    /// [N]
    pub max_load_n: f64,
    /// [MPa]
    pub max_pressure_mpa: f64,
    /// Contact angles under load [°]; absent when never in contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub min_contact_angle_deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub max_contact_angle_deg: Option<f64>,
    /// Slip speed at the contact's centre [m/s].
    pub max_slip_m_s: f64,
    /// Least minimum film thickness [µm]; absent without a film.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub min_film_thickness_um: Option<f64>,
    /// Largest load of each ball [N], ball 1 first.
    pub max_load_per_ball_n: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PocketAnswer {
    /// Largest load of a ball on the cage, film included [N].
    pub max_load_n: f64,
}

/// Mean speeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KinematicsAnswer {
    /// [Hz]
    pub cage_speed_hz: f64,
    /// 1 − cage speed / ideal cage speed [-]; absent at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage_slip: Option<f64>,
    /// [Hz]
    pub ball_spin_hz: f64,
}

/// Motion of the cage centre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CageAnswer {
    /// Rms distance from its mean position [µm].
    pub orbit_radius_um: f64,
    /// Orbit rate over cage speed [-]; absent at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub whirl_ratio: Option<f64>,
}

/// Characteristic frequencies [Hz].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrequenciesAnswer {
    pub shaft: f64,
    pub cage: f64,
    pub ball_pass_outer: f64,
    pub ball_pass_inner: f64,
    pub ball_spin: f64,
}

/// A line of a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LineAnswer {
    pub channel: String,
    /// [Hz]
    pub frequency_hz: f64,
    /// In the channel's unit; a sine of amplitude 1 reads 1.
    pub amplitude: f64,
    /// Nearest simple combination of the bearing's frequencies; empty when none is near.
    #[schema(example = "2·BPFO")]
    pub label: String,
    /// Frequency less that of the label [Hz].
    pub deviation_hz: f64,
}

/// What ran, and its work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverAnswer {
    pub method: String,
    pub method_reason: String,
    pub rung: String,
    pub check: String,
    pub steps: u64,
    pub rejected_steps: u64,
    pub rhs_evaluations: u64,
    pub jacobian_evaluations: u64,
    pub factorizations: u64,
    /// [s]
    pub wall_time_s: f64,
    /// [s]
    pub simulated_time_s: f64,
    /// Simulated time over wall time [-].
    pub real_time_factor: f64,
    pub states: u64,
    /// Strips a raceway contact is cut into for traction.
    pub strips: u64,
    /// [s]
    pub mean_step_s: f64,
    /// [s]
    pub least_step_s: f64,
}

/// How far the result can be trusted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AccuracyAnswer {
    /// Estimated error of the worst acceleration level [dB]; absent where there is no level.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_error_db: Option<f64>,
    pub how: String,
    pub motion: MotionName,
    /// Rate at which neighbouring runs part; negative: they meet [1/s].
    pub divergence_rate_per_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionName {
    Decaying,
    Diverging,
}

/// A term that is not in the equations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutAnswer {
    #[schema(example = "hydrodynamics")]
    pub term: String,
    pub reason: String,
    pub by: GroundsName,
    /// Size of the effect, in `unit`; absent where it is none or unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub bound: Option<f64>,
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

impl Metrics {
    pub fn of(result: &RunResult, outputs: &Outputs) -> Self {
        let summary = &result.summary;
        let channels =
            summary.channels.iter().map(|(channel, m)| (channel.to_string(), channel_answer(channel.unit(), m)));
        let lines = summary.lines.iter().map(|(channel, line)| line_answer(channel.to_string(), line));
        Self {
            channels: outputs.vibration.then(|| channels.collect()),
            contacts: contacts(summary),
            kinematics: summary.cage.as_ref().map(kinematics),
            cage: summary
                .cage
                .as_ref()
                .map(|cage| CageAnswer { orbit_radius_um: cage.orbit_radius, whirl_ratio: cage.whirl_ratio }),
            frequencies_hz: summary.frequencies.into(),
            lines: outputs.vibration.then(|| lines.collect()),
            solver: (&summary.solver).into(),
            accuracy: (&summary.accuracy).into(),
            left_out: result.left_out.iter().map(LeftOutAnswer::from).collect(),
        }
    }
}

fn channel_answer(unit: &str, metrics: &ChannelMetrics) -> ChannelAnswer {
    ChannelAnswer {
        unit: unit.to_owned(),
        rms: metrics.rms,
        peak: metrics.peak,
        crest_factor: metrics.crest_factor,
        kurtosis: metrics.kurtosis,
        level_db: metrics.level_db,
        above_band: metrics.above_band,
    }
}

fn line_answer(channel: String, line: &Line) -> LineAnswer {
    LineAnswer {
        channel,
        frequency_hz: line.frequency,
        amplitude: line.amplitude,
        label: line.label.clone(),
        deviation_hz: line.deviation,
    }
}

fn contacts(summary: &Summary) -> Option<ContactsAnswer> {
    if summary.contacts.is_none() && summary.cage.is_none() {
        return None;
    }
    let raceways = summary.contacts.as_ref().map(|contacts| &contacts.raceway);
    Some(ContactsAnswer {
        inner: raceways.map(|raceway| (&raceway.inner).into()),
        outer: raceways.map(|raceway| (&raceway.outer).into()),
        pocket: summary.cage.as_ref().map(|cage| PocketAnswer { max_load_n: cage.max_pocket_load }),
    })
}

fn kinematics(cage: &CageMetrics) -> KinematicsAnswer {
    KinematicsAnswer { cage_speed_hz: cage.speed, cage_slip: cage.slip, ball_spin_hz: cage.ball_spin }
}

impl From<&RacewayContactMetrics> for RacewayAnswer {
    fn from(m: &RacewayContactMetrics) -> Self {
        Self {
            max_load_n: m.max_load,
            max_pressure_mpa: m.max_pressure,
            min_contact_angle_deg: m.contact_angle.map(|range| range.0),
            max_contact_angle_deg: m.contact_angle.map(|range| range.1),
            max_slip_m_s: m.max_slip,
            min_film_thickness_um: m.min_film_thickness,
            max_load_per_ball_n: m.max_load_per_ball.clone(),
        }
    }
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
            states: report.states as u64,
            strips: report.strips as u64,
            mean_step_s: work.advanced / work.steps.max(1) as f64,
            least_step_s: work.least_step,
        }
    }
}

impl From<&AccuracyReport> for AccuracyAnswer {
    fn from(report: &AccuracyReport) -> Self {
        Self {
            level_error_db: report.level_error_db,
            how: report.how.clone(),
            motion: match report.motion {
                MotionKind::Decaying => MotionName::Decaying,
                MotionKind::Diverging => MotionName::Diverging,
            },
            divergence_rate_per_s: report.divergence_rate,
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
