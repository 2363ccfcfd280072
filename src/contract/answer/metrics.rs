//! Summary metrics of a finished run as JSON. Metrics that were not requested are absent.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::envelope::EnvelopeAnswer;
use super::friction::FrictionAnswer;
use super::headline::{BandAnswer, HeadlineAnswer, bands, in_g, velocity_mm_s};
use super::life::LifeAnswer;
use super::messages::{self, MessageAnswer};
use super::report::{AccuracyAnswer, FrequenciesAnswer, LeftOutAnswer, SolverAnswer};
use super::resonance::ResonanceAnswer;
use crate::contract::job::outputs::EnvelopeName;
use crate::contract::job::simulation::Simulation;
use crate::contract::json::units::RPM;
use raceway_core::numerics::spectrum::EnvelopeKind;
use raceway_core::physics::lubricant::LubricantKind;
use raceway_core::simulation::error::report::AccuracyReport;
use raceway_core::simulation::input::channel::{Axis, Channel, Motion};
use raceway_core::simulation::input::scene::{Scene, Term, TermChoice};
use raceway_core::simulation::recording::bands::BandMetrics;
use raceway_core::simulation::result::lines::Line;
use raceway_core::simulation::result::metrics::{CageMetrics, ChannelMetrics, RacewayContactMetrics, Summary};
use raceway_core::simulation::result::run_result::RunResult;

/// Summary of a finished simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Metrics {
    /// Levels of the spindle's acceleration along y in the units and references of the trade (metrics `vibration`); absent where the level is not
    /// resolved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub headline: Option<HeadlineAnswer>,
    /// Statistics by channel (metrics `vibration`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub channels: Option<BTreeMap<String, ChannelAnswer>>,
    /// Loads, pressures and slip of the balls' contacts (metrics `contacts`; for the pockets `cage`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub contacts: Option<ContactsAnswer>,
    /// Mean speeds (metrics `cage`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub kinematics: Option<KinematicsAnswer>,
    /// Orbit of the cage centre (metrics `cage`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage: Option<CageAnswer>,
    /// Rating life (metrics `life`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub life: Option<LifeAnswer>,
    /// Torque of friction (metrics `friction`); absent at rest, and where the speed changes its sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub friction: Option<FrictionAnswer>,
    /// Frequencies at the simulated speeds of cage and balls, which are those of the spectral lines. `POST /v1/scenes/resolve` returns those
    /// of rolling at the free and at the loaded contact angles.
    pub frequencies_hz: FrequenciesAnswer,
    /// Strongest lines of each requested amplitude spectrum (`outputs.spectra`), at most 20 for each channel, strongest first, in the
    /// channel's unit (metrics `vibration`). Empty without spectra, and where no line exceeds the noise floor.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub lines: Option<Vec<LineAnswer>>,
    /// Lines of the envelope spectra of accelerations, likewise: at these rates impacts excite resonances.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub envelope_lines: Option<Vec<LineAnswer>>,
    /// `squared`: `envelope_lines` and `envelope` are those of squared envelopes, in the square of the unit. Absent: of envelopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub envelope: Option<EnvelopeName>,
    /// Resonances of the spindle on its loaded contacts, which impacts excite, the lowest first; absent where all raceways are ideal circles and
    /// all balls are alike (metrics `vibration`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resonances: Vec<ResonanceAnswer>,
    /// The solver that ran, and its work.
    pub solver: SolverAnswer,
    /// Estimated errors of the result.
    pub accuracy: AccuracyAnswer,
    /// Messages about the result: warnings first, then how the result was made. See `MessageCode`.
    // Results of releases before the codes have none.
    #[serde(default)]
    #[schema(required = true)]
    pub messages: Vec<MessageAnswer>,
    /// Terms that are not in the equations, with the reason.
    pub left_out: Vec<LeftOutAnswer>,
}

/// Statistics of a channel over the recorded time, mean removed, 0–20 kHz, in the channel's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChannelAnswer {
    /// Unit of `rms` and `peak`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Root mean square, in `unit`.
    #[schema(minimum = 0)]
    pub rms: f64,
    /// Largest magnitude, in `unit`.
    #[schema(minimum = 0)]
    pub peak: f64,
    /// Root mean square in multiples of g = 9.80665 m/s²; accelerations only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub rms_g: Option<f64>,
    /// Largest magnitude in multiples of g; accelerations only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub peak_g: Option<f64>,
    /// Crest factor, peak / rms [-]; absent without motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub crest_factor: Option<f64>,
    /// Kurtosis, fourth moment divided by squared variance [-]; absent without motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub kurtosis: Option<f64>,
    /// Level, 20 lg(rms / 9.81e-3 m/s²) [dB]; accelerations only.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_db: Option<f64>,
    /// Estimated error of the level [dB]; absent where it is unknown, and where the level of another axis is more than 60 dB higher.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_error_db: Option<f64>,
    /// `false`: refinement still changes the level by more than 1 dB, so that neither the level nor its spectrum can be used; see the message
    /// `not-resolved`. Absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, example = false)]
    pub resolved: Option<bool>,
    /// Standard deviation of the level between time windows of the length `duration_s` [dB]; reduce it by a longer `duration_s`. Estimated
    /// from parts of a tenth, a fifth and a half of the recorded time. From 0.1 dB on, and for less than 2 s, at least the difference to one
    /// later window. For less than 10 ms, and on a reduced model level up to 0.5 s, the rms difference to ten later windows. Absent at
    /// changing speed, almost without motion, and where the level of another axis is more than 60 dB higher.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub level_scatter_db: Option<f64>,
    /// Share of the power above 20 kHz [-].
    #[schema(minimum = 0, maximum = 1)]
    pub above_band: f64,
    /// Root mean square of the velocity from 10 to 1000 Hz [mm/s], the band of ISO 20816-1, with sharp edges, from Hann spectra; accelerations with
    /// a resolved level only. Absent where less than 0.2 s was recorded, which does not resolve 10 Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub velocity_10_1000_hz_mm_s: Option<f64>,
    /// Mean square of the Hann spectra up to 20 kHz over that of the signal [-]. 1 of steady motion; velocities and bands of motion that swells
    /// or decays within the record are off by as much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub parseval_ratio: Option<f64>,
    /// Vibration in bands, those of ISO 15242-1 by default (`outputs.bands_hz`), from Hann spectra; accelerations with a resolved level only.
    /// Bands that the recorded time does not resolve are missing. The standard measures the outer ring at 1800 r/min; no quality class follows
    /// from these numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub bands: Option<Vec<BandAnswer>>,
    /// Envelope at the rates of defects; accelerations with a resolved level at constant speed, where raceways are no ideal circles or balls
    /// differ. Ideal bearings have none, because no fault modulates their envelope; `envelope_lines` are listed for them, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub envelope: Option<EnvelopeAnswer>,
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

/// Contacts on one raceway: extremes over all balls and the recorded time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RacewayAnswer {
    /// Largest normal load of a ball [N].
    #[schema(minimum = 0)]
    pub max_load_n: f64,
    /// Largest pressure in a contact [MPa].
    #[schema(minimum = 0)]
    pub max_pressure_mpa: f64,
    /// Smallest contact angle under load [°]; absent without contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub min_contact_angle_deg: Option<f64>,
    /// Largest contact angle under load [°]; absent without contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub max_contact_angle_deg: Option<f64>,
    /// Largest slip speed at the centre of a contact [m/s].
    #[schema(minimum = 0)]
    pub max_slip_m_s: f64,
    /// Smallest minimum film thickness [µm]; absent without a film.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub min_film_thickness_um: Option<f64>,
    /// Largest load of each ball [N], ball 1 first.
    pub max_load_per_ball_n: Vec<f64>,
    /// Share of their time in the load zone that balls do not touch this raceway [-], mean of all balls. The load zone: azimuths at which
    /// the inner raceway presses a ball in the static equilibrium on ideal raceways. Absent if all raceways are ideal circles, without a
    /// load zone, and on model levels without balls. Its error is not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 1)]
    pub mean_off_share: Option<f64>,
    /// The same of the ball with the largest share [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 1)]
    pub max_off_share: Option<f64>,
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
    /// 1 − cage speed / speed of rolling at the loaded contact angles [-], both as seen from the ring that turns more slowly. Positive: the
    /// cage lags, as it does when balls skid. Small negative values are no skidding: conformity and spin in the contacts raise the cage speed. The speed of rolling is the mean over
    /// time and the balls that touch both raceways, weighted by their outer load, at their simulated angles and spin axes. Absent at rest,
    /// and where on average fewer than a tenth of the balls carry load.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage_slip: Option<f64>,
    /// 1 − cage speed / speed of rolling at the free contact angle, 0 for a deep-groove bearing [-]; absent at rest. It contains the change of the contact angle under
    /// load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage_slip_free_angle: Option<f64>,
    /// Spin of the balls about their own axes [Hz].
    pub ball_spin_hz: f64,
}

/// Motion of the cage centre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CageAnswer {
    /// Rms distance of the cage centre from its mean position [µm].
    #[schema(minimum = 0)]
    pub orbit_radius_um: f64,
    /// Orbit rate divided by cage speed [-]; absent at rest. Its error is not estimated, and is large for small orbits.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub whirl_ratio: Option<f64>,
}

/// A line of a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LineAnswer {
    /// The channel whose spectrum has the line.
    pub channel: String,
    /// Frequency of the line [Hz].
    #[schema(minimum = 0)]
    pub frequency_hz: f64,
    /// Amplitude in the channel's unit; a sine of amplitude 1 gives 1.
    #[schema(minimum = 0)]
    pub amplitude: f64,
    /// Nearest simple combination of the bearing's frequencies, or `cage whirl` or `spindle whirl` at the rate of whirl; empty where none
    /// is near.
    #[schema(example = "2·BPFO")]
    pub label: String,
    /// Frequency of the line minus that of the label [Hz].
    pub deviation_hz: f64,
}

impl Metrics {
    pub fn of(result: &RunResult, simulation: &Simulation) -> Self {
        let (summary, scene, outputs) = (&result.summary, simulation.scene(), &simulation.settings.outputs);
        let speed = constant_speed_rpm(scene);
        let channels = summary.channels.iter().map(|(channel, m)| {
            let found = summary.envelope_harmonics.iter().find(|(of, _)| of == channel);
            let reference = match outputs.envelope.kind {
                EnvelopeKind::Magnitude => m.rms,
                EnvelopeKind::Squared => m.rms * m.rms,
            };
            let envelope = found.map(|(_, harmonics)| EnvelopeAnswer::of(harmonics, reference));
            let answer = channel_answer(m, &summary.accuracy, *channel, speed);
            (channel.to_string(), ChannelAnswer { envelope, ..answer })
        });
        let channels: Option<BTreeMap<String, ChannelAnswer>> = outputs.vibration.then(|| channels.collect());
        let lines = |of: &[(Channel, Line)]| {
            outputs.vibration.then(|| of.iter().map(|(channel, line)| line_answer(channel.to_string(), line)).collect())
        };
        let headline = outputs.vibration.then(|| headline(summary)).flatten();
        let of_result = messages::of_result(&summary.accuracy.warnings, &summary.solver);
        let of_bands = headline.map(|(metrics, bands)| {
            let own = summary.lines.iter().filter(|(channel, _)| *channel == HEADLINE).map(|(_, line)| line);
            messages::of_bands(&HEADLINE.to_string(), metrics.rms, bands, &own.collect::<Vec<_>>())
        });
        let of_bands = of_bands.into_iter().flatten();
        let of_friction = adds_forces_for_friction(simulation).then(messages::friction_adds_forces).into_iter();
        Self {
            headline: headline.and_then(|(metrics, bands)| headline_answer(metrics, bands, speed)),
            channels,
            contacts: contacts(summary),
            kinematics: summary.cage.as_ref().map(kinematics),
            cage: summary
                .cage
                .as_ref()
                .map(|cage| CageAnswer { orbit_radius_um: cage.orbit_radius, whirl_ratio: cage.whirl_ratio }),
            life: LifeAnswer::of_run(simulation, summary),
            friction: FrictionAnswer::of_run(simulation, summary),
            frequencies_hz: summary.frequencies.into(),
            lines: lines(&summary.lines),
            envelope_lines: lines(&summary.envelope_lines),
            envelope: (outputs.envelope.kind == EnvelopeKind::Squared).then_some(EnvelopeName::Squared),
            resonances: summary.resonances.iter().map(ResonanceAnswer::from).collect(),
            solver: SolverAnswer::of(&summary.solver, &summary.accuracy),
            accuracy: AccuracyAnswer::of(&summary.accuracy, outputs)
                .with_slip_of(summary.cage.as_ref().and_then(|cage| cage.slip)),
            messages: of_bands.chain(of_friction).chain(of_result).collect(),
            left_out: result.left_out.iter().map(LeftOutAnswer::from).collect(),
        }
    }
}

fn channel_answer(
    metrics: &ChannelMetrics,
    accuracy: &AccuracyReport,
    channel: Channel,
    speed_rpm: Option<f64>,
) -> ChannelAnswer {
    let is_acceleration = metrics.bands.is_some();
    let bands = metrics.bands.as_ref().filter(|_| accuracy.unresolved.of(channel).is_none());
    ChannelAnswer {
        unit: channel.unit().to_owned(),
        rms: metrics.rms,
        peak: metrics.peak,
        rms_g: is_acceleration.then(|| in_g(metrics.rms)),
        peak_g: is_acceleration.then(|| in_g(metrics.peak)),
        crest_factor: metrics.crest_factor,
        kurtosis: metrics.kurtosis,
        level_db: metrics.level_db,
        level_error_db: accuracy.level_errors.of(channel),
        resolved: accuracy.unresolved.of(channel).map(|_| false),
        level_scatter_db: accuracy.level_scatter.of(channel),
        above_band: metrics.above_band,
        velocity_10_1000_hz_mm_s: bands.and_then(velocity_mm_s),
        parseval_ratio: bands.and_then(|of| of.parseval_ratio),
        bands: bands.map(|of| bands_of(of, channel, speed_rpm)).filter(|bands| !bands.is_empty()),
        envelope: None,
    }
}

/// The channel of the headline.
const HEADLINE: Channel = Channel::Spindle(Axis::Y, Motion::Acceleration);

/// Metrics and bands of the channel of the headline; `None` where it is not recorded, or not resolved.
fn headline(summary: &Summary) -> Option<(&ChannelMetrics, &BandMetrics)> {
    let (_, metrics) = summary.channels.iter().find(|(channel, _)| *channel == HEADLINE)?;
    let bands = metrics.bands.as_ref().filter(|_| summary.accuracy.unresolved.of(HEADLINE).is_none())?;
    Some((metrics, bands))
}

fn headline_answer(metrics: &ChannelMetrics, of: &BandMetrics, speed_rpm: Option<f64>) -> Option<HeadlineAnswer> {
    HeadlineAnswer::of(HEADLINE.to_string(), metrics.rms, metrics.peak, of, bands_of(of, HEADLINE, speed_rpm))
}

/// True if hydrodynamic forces act in grease because a friction moment is asked for.
fn adds_forces_for_friction(simulation: &Simulation) -> bool {
    let (scene, outputs) = (simulation.scene(), &simulation.settings.outputs);
    let is_open = scene.terms.get(Term::Hydrodynamics) == TermChoice::Auto;
    outputs.friction && is_open && scene.lubricant.kind == LubricantKind::Grease && scene.lubricant.viscosity > 0.0
}

fn bands_of(metrics: &BandMetrics, channel: Channel, speed_rpm: Option<f64>) -> Vec<BandAnswer> {
    let is_radial = matches!(channel, Channel::Spindle(Axis::Y | Axis::Z, _));
    bands(metrics, speed_rpm.filter(|_| is_radial))
}

/// Speed of the shaft [r/min], where both rings keep theirs.
fn constant_speed_rpm(scene: &Scene) -> Option<f64> {
    scene.operation.has_constant_speeds().then(|| RPM.to_user(scene.operation.speed.at(0.0).1))
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
    KinematicsAnswer {
        cage_speed_hz: cage.speed,
        cage_slip: cage.slip,
        cage_slip_free_angle: cage.slip_free_angle,
        ball_spin_hz: cage.ball_spin,
    }
}

impl From<&RacewayContactMetrics> for RacewayAnswer {
    fn from(m: &RacewayContactMetrics) -> Self {
        Self {
            max_load_n: m.max_load,
            max_pressure_mpa: m.max_pressure,
            // Adding 0 turns −0 into 0.
            min_contact_angle_deg: m.contact_angle.map(|range| range.0 + 0.0),
            max_contact_angle_deg: m.contact_angle.map(|range| range.1 + 0.0),
            max_slip_m_s: m.max_slip,
            min_film_thickness_um: m.min_film_thickness,
            max_load_per_ball_n: m.max_load_per_ball.clone(),
            mean_off_share: m.off.map(|off| off.mean),
            max_off_share: m.off.map(|off| off.largest),
        }
    }
}
