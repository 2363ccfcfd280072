//! Summary metrics of a finished run as JSON. What was not asked for is absent.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use super::report::{AccuracyAnswer, FrequenciesAnswer, GroundsName, LeftOutAnswer, MotionName, SolverAnswer};
use crate::simulation::input::channel::Channel;
use crate::simulation::input::settings::Outputs;
use crate::simulation::result::lines::Line;
use crate::simulation::result::metrics::{CageMetrics, ChannelMetrics, RacewayContactMetrics, Summary};
use crate::simulation::result::run_result::RunResult;

/// Everything a user reads first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Metrics {
    /// Statistics by channel (`vibration`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub channels: Option<BTreeMap<String, ChannelAnswer>>,
    /// Loads, pressures and slip of the balls' contacts (`contacts`, and `cage` for the pockets).
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
    /// At the simulated speeds of cage and balls, as the lines of spectra lie; `POST /v1/scenes/resolve` has those of ideal rolling.
    pub frequencies_hz: FrequenciesAnswer,
    /// Strongest lines of each amplitude spectrum that was asked for (`outputs.spectra`), at most 20 of a channel, strongest first;
    /// of any channel, in its unit. Empty where no spectrum is kept, and where nothing stands out of its floor (`vibration`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub lines: Option<Vec<LineAnswer>>,
    /// What ran, and its work.
    pub solver: SolverAnswer,
    /// How far the result can be trusted.
    pub accuracy: AccuracyAnswer,
    /// What is not in the equations, and why.
    pub left_out: Vec<LeftOutAnswer>,
}

/// One channel over the kept time, mean removed, 0–20 kHz, in the channel's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChannelAnswer {
    /// Of `rms` and `peak`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Root mean square, in `unit`.
    #[schema(minimum = 0)]
    pub rms: f64,
    /// Largest magnitude, in `unit`.
    #[schema(minimum = 0)]
    pub peak: f64,
    /// peak / rms [-]; absent where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub crest_factor: Option<f64>,
    /// Fourth moment over squared variance [-]; absent where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub kurtosis: Option<f64>,
    /// 20 lg(rms / 9.81e-3 m/s²) [dB]; accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_db: Option<f64>,
    /// Estimated error of that level [dB]; absent where it is not known, and where another axis is more than 60 dB louder.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// What the level of another stretch as long may differ by [dB], one standard deviation: from how the level goes up and down along
    /// the kept time, of parts of a tenth, a fifth and a half of it. From 0.1 dB on, and where less than 2 s are kept, at least what a later
    /// stretch as long differs by, which begins a kept time after the end; of less than 10 ms, and on a reduced rung up to 0.5 s, what ten
    /// later ones differ by, rms, in place of that. A large one asks for a longer `duration_s`. Absent where the speed changes, where next to
    /// nothing moves, and where another axis is more than 60 dB louder.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_scatter_db: Option<f64>,
    /// Share of the power above 20 kHz [-].
    #[schema(minimum = 0, maximum = 1)]
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
    /// Largest normal load of a ball [N].
    #[schema(minimum = 0)]
    pub max_load_n: f64,
    /// Largest pressure in a contact [MPa].
    #[schema(minimum = 0)]
    pub max_pressure_mpa: f64,
    /// Least contact angle under load [°]; absent when never in contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub min_contact_angle_deg: Option<f64>,
    /// Largest contact angle under load [°]; absent when never in contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub max_contact_angle_deg: Option<f64>,
    /// Slip speed at the contact's centre [m/s].
    #[schema(minimum = 0)]
    pub max_slip_m_s: f64,
    /// Least minimum film thickness [µm]; absent without a film.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub min_film_thickness_um: Option<f64>,
    /// Largest load of each ball [N], ball 1 first.
    pub max_load_per_ball_n: Vec<f64>,
}

/// Contacts of the balls with the cage's pockets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PocketAnswer {
    /// Largest load of a ball on the cage, film included [N].
    #[schema(minimum = 0)]
    pub max_load_n: f64,
}

/// Mean speeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KinematicsAnswer {
    /// Speed of the cage about the bearing's axis [Hz].
    pub cage_speed_hz: f64,
    /// 1 − cage speed / ideal cage speed [-]; absent at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage_slip: Option<f64>,
    /// Spin of the balls about their own axes [Hz].
    pub ball_spin_hz: f64,
}

/// Motion of the cage centre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CageAnswer {
    /// Rms distance from its mean position [µm].
    #[schema(minimum = 0)]
    pub orbit_radius_um: f64,
    /// Orbit rate over cage speed [-]; absent at rest. No error of it is stated: where the orbit is small it is the least certain of all numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub whirl_ratio: Option<f64>,
}

/// A line of a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LineAnswer {
    /// The channel whose spectrum has the line.
    pub channel: String,
    /// Where it stands [Hz].
    #[schema(minimum = 0)]
    pub frequency_hz: f64,
    /// In the channel's unit; a sine of amplitude 1 reads 1.
    #[schema(minimum = 0)]
    pub amplitude: f64,
    /// Nearest simple combination of the bearing's frequencies; empty when none is near.
    #[schema(example = "2·BPFO")]
    pub label: String,
    /// Frequency less that of the label [Hz].
    pub deviation_hz: f64,
}

impl Metrics {
    pub fn of(result: &RunResult, outputs: &Outputs) -> Self {
        let summary = &result.summary;
        let level = |channel: &Channel| (summary.accuracy.level_errors.of(*channel), summary.scatter.of(*channel));
        let channels = summary
            .channels
            .iter()
            .map(|(channel, m)| (channel.to_string(), channel_answer(channel.unit(), m, level(channel))));
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
            accuracy: AccuracyAnswer::of(&summary.accuracy, summary.settling.as_deref(), outputs),
            left_out: result.left_out.iter().map(LeftOutAnswer::from).collect(),
        }
    }
}

fn channel_answer(
    unit: &str,
    metrics: &ChannelMetrics,
    (level_error_db, level_scatter_db): (Option<f64>, Option<f64>),
) -> ChannelAnswer {
    ChannelAnswer {
        unit: unit.to_owned(),
        rms: metrics.rms,
        peak: metrics.peak,
        crest_factor: metrics.crest_factor,
        kurtosis: metrics.kurtosis,
        level_db: metrics.level_db,
        level_error_db,
        level_scatter_db,
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
