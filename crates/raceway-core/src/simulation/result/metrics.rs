//! Summary metrics of a run, in the units of results.

use std::f64::consts::SQRT_2;

use crate::numerics::ode::{ChoiceReason, Statistics};
use crate::numerics::spectrum::{HANN_BANDWIDTH, Spectrum};
use crate::numerics::statistics::CentralMoments;
use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::{self, CharacteristicFrequencies};
use crate::simulation::error::codes::{NotEligible, Rejection};
use crate::simulation::error::report::AccuracyReport;
use crate::simulation::input::channel::{Channel, Motion};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::{BAND_EDGES, RunSettings};
use crate::simulation::model::Mechanism;
use crate::simulation::model::contact_resonance::ContactResonance;
use crate::simulation::recording::bands::BandMetrics;
use crate::simulation::recording::off_raceway::OffShare;
use crate::simulation::recording::power_balance::PowerBalance;
use crate::simulation::recording::record::{ContactExtremes, Recording};
use crate::simulation::recording::sampling::{ACCELERATIONS, BAND, RATE};
use crate::simulation::recording::spectra::ChannelSpectra;
use crate::simulation::recording::windows::{InBand, Whirl};
use crate::simulation::result::envelope_harmonics::EnvelopeHarmonics;
use crate::simulation::result::line_sources::{LineSources, OuterRing};
use crate::simulation::result::lines::{Line, find_lines};
use crate::simulation::result::series::Series;

/// Statistics of one channel over the kept time, mean removed, 0–20 kHz, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMetrics {
    pub rms: f64,
    pub peak: f64,
    /// peak / rms; absent where rms is 0.
    pub crest_factor: Option<f64>,
    /// Fourth moment over squared variance (3 for Gaussian noise); absent where rms is 0.
    pub kurtosis: Option<f64>,
    /// 20 lg(rms / 9.81e-3 m/s²) [dB], accelerations that are not 0 only.
    pub level_db: Option<f64>,
    /// Share of the signal's power above 20 kHz [-].
    pub above_band: f64,
    /// Velocity, bands and power, of accelerations only.
    pub bands: Option<BandMetrics>,
}

/// One kind of raceway contact over all balls and the kept time.
#[derive(Debug, Clone, PartialEq)]
pub struct RacewayContactMetrics {
    /// [N]
    pub max_load: f64,
    /// [MPa]
    pub max_pressure: f64,
    /// Range of the contact angles under load [deg]; `None`: never in contact.
    pub contact_angle: Option<(f64, f64)>,
    /// Largest slip speed at a contact's centre under load [m/s].
    pub max_slip: f64,
    /// Smallest minimum film thickness under load [µm]; `None` where it was not requested or the contacts are dry.
    pub min_film_thickness: Option<f64>,
    /// Largest load of each ball [N].
    pub max_load_per_ball: Vec<f64>,
    /// Share of the time that balls in the load zone do not touch the raceway; `None` on ideal raceways and spindle-only models.
    pub off: Option<OffShare>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ContactMetrics {
    pub raceway: PerRaceway<RacewayContactMetrics>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct CageMetrics {
    /// Mean speed [Hz].
    pub speed: f64,
    /// 1 − speed / FTF at the loaded contact angles; absent at rest and where too few balls carry load.
    pub slip: Option<f64>,
    /// 1 − speed / FTF at the free contact angle; absent at rest.
    pub slip_free_angle: Option<f64>,
    /// Mean spin of the balls about their own axes [Hz].
    pub ball_spin: f64,
    /// Rms distance of the cage centre from its mean position [µm].
    pub orbit_radius: f64,
    /// Mean orbit rate of the cage centre over the cage speed; absent at rest.
    pub whirl_ratio: Option<f64>,
    /// Largest pocket load [N]; film included.
    pub max_pocket_load: f64,
}

/// Method and work of the solver.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverReport {
    pub method: &'static str,
    /// Why `auto` runs this method.
    pub choice: Option<ChoiceReason>,
    pub level: ModelLevel,
    /// Candidates that did not become the result, in the order in which they were tried.
    /// Window of a comparison with the full dynamics [s], where the request omits the tilt of balls and cage.
    pub tilt_window: Option<f64>,
    pub rejections: Vec<Rejection>,
    /// Model levels that were no candidates.
    pub not_eligible: Vec<NotEligible>,
    pub statistics: Statistics,
    /// [s]
    pub wall_time: f64,
    /// [s]
    pub simulated_time: f64,
    /// Relative tolerance of the run [-]; `None` for an integrator without error control.
    pub relative_tolerance: Option<f64>,
    /// Number of first-order states.
    pub states: usize,
    /// Strips a raceway contact is cut into for traction.
    pub strips: usize,
}

/// Everything a user reads first.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// In the order x, y, z; velocity and acceleration (and displacement) of the spindle; empty when vibration was not asked for.
    pub channels: Vec<(Channel, ChannelMetrics)>,
    /// Absent when not asked for.
    pub contacts: Option<ContactMetrics>,
    /// Absent when not asked for, or when the scene has no cage.
    pub cage: Option<CageMetrics>,
    /// Power means of the loads of the balls on both raceways [N]; absent when not asked for.
    pub load_means: Option<PerRaceway<f64>>,
    /// Torques; absent when not asked for, and at rest.
    pub friction: Option<FrictionTorque>,
    /// Mean speed of one ring relative to the other [rad/s].
    pub relative_speed: f64,
    /// From the simulated cage and ball speed [Hz].
    pub frequencies: CharacteristicFrequencies,
    /// Strongest first within a channel.
    pub lines: Vec<(Channel, Line)>,
    /// Lines of the envelopes of accelerations, likewise.
    pub envelope_lines: Vec<(Channel, Line)>,
    /// Of accelerations, where surfaces are not ideal.
    pub envelope_harmonics: Vec<(Channel, EnvelopeHarmonics)>,
    /// Of the spindle on its contacts; empty on ideal raceways and equal balls.
    pub resonances: Vec<ContactResonance>,
    pub solver: SolverReport,
    pub accuracy: AccuracyReport,
}

/// Reference of the acceleration level, equation (15) [m/s²].
pub(crate) const REFERENCE_ACCELERATION: f64 = 9.81e-3;
/// Unit of a level in full, for headings.
pub const LEVEL_UNIT: &str = "dB re 9.81 mm/s²";

/// Level of an acceleration rms [m/s²], L = 20 lg(rms / 9.81e-3) [dB], equation (15); `None` for 0.
pub fn level_db(rms: f64) -> Option<f64> {
    (rms > 0.0).then(|| 20.0 * (rms / REFERENCE_ACCELERATION).log10())
}

/// Spread of a signal at rest, caused by rounding alone, as a share of the size of its values [-].
const STANDSTILL: f64 = 1e-12;

/// Metrics of one channel, from its values taken as one window, and its variance before the filter (SI).
pub fn channel_metrics(channel: Channel, signal: &[f64], total_variance: f64) -> ChannelMetrics {
    in_band_metrics(channel, &InBand::of(signal, &BAND_EDGES), total_variance)
}

/// Metrics of one channel from its statistics.
pub(crate) fn in_band_metrics(channel: Channel, in_band: &InBand, total_variance: f64) -> ChannelMetrics {
    let still = in_band.moments.peak() <= STANDSTILL * in_band.largest;
    let moments = if still { CentralMoments::default() } else { in_band.moments };
    let rms = moments.rms();
    let above = if total_variance > 0.0 && rms > 0.0 { 1.0 - rms * rms / total_variance } else { 0.0 };
    let acceleration = matches!(channel, Channel::Spindle(_, Motion::Acceleration));
    ChannelMetrics {
        rms: channel.scale() * rms,
        peak: channel.scale() * moments.peak(),
        crest_factor: moments.crest_factor(),
        kurtosis: moments.kurtosis(),
        level_db: if acceleration { level_db(rms) } else { None },
        above_band: above.clamp(0.0, 1.0),
        bands: acceleration.then(|| in_band.bands.metrics(rms)),
    }
}

/// Metrics of the spindle's channels.
pub fn vibration(recording: &Recording) -> Vec<(Channel, ChannelMetrics)> {
    let of_spindle = recording.signals.iter().filter(|signal| matches!(signal.channel, Channel::Spindle(..)));
    let one = |channel: Channel, in_band: &InBand| in_band_metrics(channel, in_band, recording.total_variance(channel));
    of_spindle.map(|signal| (signal.channel, one(signal.channel, signal.in_band()))).collect()
}

/// Metrics of the raceway contacts.
pub fn contacts(mechanism: &Mechanism, recording: &Recording) -> ContactMetrics {
    let raceway = &mechanism.raceway;
    let one = |extremes: &ContactExtremes, pressure: &dyn Fn(f64) -> f64| {
        let max_load = extremes.max_load.iter().copied().fold(0.0, f64::max);
        RacewayContactMetrics {
            max_load,
            max_pressure: 1e-6 * pressure(max_load),
            contact_angle: extremes.angle.map(|(least, most)| (least.to_degrees(), most.to_degrees())),
            max_slip: extremes.max_slip,
            min_film_thickness: extremes.least_film.map(|film| 1e6 * film),
            max_load_per_ball: extremes.max_load.clone(),
            off: extremes.off,
        }
    };
    ContactMetrics {
        raceway: PerRaceway {
            inner: one(&recording.contacts.inner, &|load| raceway.inner.hertz().max_pressure(load)),
            outer: one(&recording.contacts.outer, &|load| raceway.outer.hertz().max_pressure(load)),
        },
    }
}

/// Metrics of the cage; `None` where the model has none.
pub fn cage(scene: &Scene, recording: &Recording) -> Option<CageMetrics> {
    let orbit_radius = recording.orbit_radius()?;
    let free_angle = kinematics::ideal_orbit_ratio(&scene.bearing);
    let turns = |speed: f64| speed / std::f64::consts::TAU;
    let speeds = &recording.speeds;
    let has_ideal = !scene.operation.rotation().reverses();
    Some(CageMetrics {
        speed: turns(speeds.cage),
        slip: recording.cage_slip().filter(|_| has_ideal),
        slip_free_angle: speeds.cage_slip(free_angle).filter(|_| has_ideal),
        ball_spin: turns(speeds.ball_spin),
        orbit_radius: 1e6 * orbit_radius,
        whirl_ratio: recording
            .whirl()
            .filter(|_| speeds.shaft.max(speeds.outer_ring) > 0.0)
            .map(|whirl| recording.direction * whirl.rate() / speeds.cage),
        max_pocket_load: recording.max_pocket_load,
    })
}

/// Torque of friction about the axis: mean powers over the mean speed of the rings relative to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionTorque {
    /// [W]
    pub powers: PowerBalance,
    /// [rad/s]
    pub speed: f64,
}

impl FrictionTorque {
    /// Torque [N m] of a power [W].
    pub fn of(&self, power: f64) -> f64 {
        power / self.speed
    }
}

/// Torque of friction; `None` where it was not recorded, and where the rings stand or turn back and forth.
pub fn friction(scene: &Scene, recording: &Recording) -> Option<FrictionTorque> {
    let speed = recording.speeds.relative;
    let turns = speed > 0.0 && !scene.operation.rotation().reverses();
    recording.powers.filter(|_| turns).map(|powers| FrictionTorque { powers, speed })
}

/// Characteristic frequencies at the simulated speeds [Hz].
pub fn frequencies(scene: &Scene, recording: &Recording) -> CharacteristicFrequencies {
    recording.speeds.in_turns().frequencies(&scene.bearing)
}

/// Frequencies of lines at the simulated speeds [Hz], with the spin of the balls that make lines: those with defects, else those with waves.
fn line_frequencies(scene: &Scene, recording: &Recording) -> CharacteristicFrequencies {
    let heard = scene.surfaces.heard_balls();
    let spins = || heard.iter().zip(&recording.tracks).filter(|(is_heard, _)| **is_heard).map(|(_, track)| track.spin);
    let own = (spins().count() > 0).then(|| spins().sum::<f64>() / spins().count() as f64);
    let all = frequencies(scene, recording);
    CharacteristicFrequencies { ball_spin: own.map_or(all.ball_spin, |spin| spin / std::f64::consts::TAU), ..all }
}

/// Amplitudes of the envelopes at the rates of defects, where they are computed; none where the speed varies, and of channels whose level is
/// not resolved.
pub(crate) fn envelope_harmonics(
    scene: &Scene,
    recording: &Recording,
    settings: &RunSettings,
    accuracy: &AccuracyReport,
) -> Vec<(Channel, EnvelopeHarmonics)> {
    if !settings.outputs.envelope_harmonics || !scene.operation.has_constant_speeds() {
        return Vec::new();
    }
    let at = line_frequencies(scene, recording);
    let one = |channel: &Channel| {
        let spectra = recording.of(*channel)?.spectra()?;
        let harmonics = EnvelopeHarmonics::of(&spectra.envelope, &at)?;
        accuracy.unresolved.of(*channel).is_none().then_some((*channel, harmonics))
    };
    ACCELERATIONS.iter().filter_map(one).collect()
}

/// Spectra of the asked-for channels, in their units.
pub fn spectra(recording: &Recording, settings: &RunSettings) -> Vec<ChannelSpectra> {
    let one = |channel: &Channel| recording.of(*channel)?.spectra().cloned();
    settings.outputs.spectra.iter().filter_map(one).collect()
}

/// Which spectra of the channels have their lines listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spectra {
    Amplitude,
    /// Of accelerations only: impacts show in them.
    Envelope,
}

/// Lines of all spectra of a kind. A line has no label where the speed varies, and where it is weaker than the noise that the error of the level allows. A
/// spectrum whose level is not resolved has no lines.
pub fn lines(
    scene: &Scene,
    recording: &Recording,
    spectra: &[ChannelSpectra],
    kind: Spectra,
    accuracy: &AccuracyReport,
) -> Vec<(Channel, Line)> {
    if spectra.is_empty() {
        return Vec::new();
    }
    let is_constant = scene.operation.has_constant_speeds();
    let turns = |whirl: Option<Whirl>| whirl.map_or(0.0, |whirl| whirl.rate().abs() / std::f64::consts::TAU);
    let loads: Vec<f64> = scene.operation.load_frequencies(recording.speeds.shaft).collect();
    let orders = scene.surfaces.raceway.inner.given_orders();
    let is_balanced = scene.spindle.unbalance_product(scene.operating_speed()) == 0.0;
    let rings = (!is_balanced || !scene.surfaces.raceway.inner.is_ideal(), outer_ring(scene));
    let of_bearing = line_sources(scene, &line_frequencies(scene, recording), rings, (&orders, &loads));
    let sources = &LineSources {
        cage_whirl: turns(recording.whirl()),
        spindle_whirl: turns(recording.spindle_whirl()),
        ..of_bearing
    };
    let of_channel = |spectra: &ChannelSpectra| {
        let spectrum = match kind {
            Spectra::Amplitude => &spectra.amplitude,
            Spectra::Envelope if !ACCELERATIONS.contains(&spectra.channel) => return Vec::new(),
            Spectra::Envelope => &spectra.envelope,
        };
        let acceleration = spectra.channel.acceleration();
        if acceleration.is_some_and(|of| accuracy.unresolved.of(of).is_some()) {
            return Vec::new();
        }
        let error_db = acceleration.and_then(|of| accuracy.level_errors.of(of)).unwrap_or(0.0);
        let noise = allowed_noise(spectrum, error_db);
        let name = |line: Line| match is_constant && line.amplitude > SQRT_2 * noise {
            true => line,
            false => Line { label: String::new(), deviation: 0.0, ..line },
        };
        let lines = find_lines(spectrum, sources, BAND);
        lines.into_iter().map(|line| (spectra.channel, name(line))).collect::<Vec<_>>()
    };
    spectra.iter().flat_map(of_channel).collect()
}

/// Root mean square of the noise that a spectrum may contain beside its signal, if its level is off by `error_db`.
fn allowed_noise(spectrum: &Spectrum, error_db: f64) -> f64 {
    let in_band = spectrum.amplitude.iter().take((BAND / spectrum.resolution) as usize);
    let power = 0.5 * in_band.map(|amplitude| amplitude * amplitude).sum::<f64>() / HANN_BANDWIDTH;
    power.sqrt() * (10_f64.powf(error_db / 20.0) - 1.0)
}

/// Motion of the outer ring of a scene.
pub(crate) fn outer_ring(scene: &Scene) -> OuterRing {
    match scene.operation.rotation().outer_stands() {
        true => OuterRing::Stands,
        false => OuterRing::Turns { is_uneven: !scene.surfaces.raceway.outer.is_ideal() },
    }
}

/// Frequencies that name the lines of a bearing. Only frequencies that can appear in a spectrum are there: something marks the rotation of the shaft, as
/// unbalance or the surface of an inner raceway does; the surface of its raceway marks the outer ring, waves and defects mark a ball.
///
/// `inner_orders` and `loads` as in [`LineSources`].
pub(crate) fn line_sources<'a>(
    scene: &Scene,
    frequencies: &CharacteristicFrequencies,
    (shaft_is_marked, outer_ring): (bool, OuterRing),
    (inner_orders, loads): (&'a [i32], &'a [f64]),
) -> LineSources<'a> {
    let PerRaceway { inner, outer } = &scene.surfaces.raceway;
    let there = |is_there: bool| if is_there { 1.0 } else { 0.0 };
    let shaft = there(shaft_is_marked);
    let ball = there(scene.surfaces.have_uneven_balls());
    let ring = there(outer_ring == OuterRing::Stands || !outer.is_ideal());
    LineSources {
        frequencies: CharacteristicFrequencies {
            outer_ring: ring * frequencies.outer_ring,
            ball_pass_outer: ring * frequencies.ball_pass_outer,
            shaft: shaft * frequencies.shaft,
            ball_pass_inner: shaft * frequencies.ball_pass_inner,
            ball_spin: ball * frequencies.ball_spin,
            ..*frequencies
        },
        uneven_inner: !inner.is_ideal(),
        inner_orders,
        outer_ring,
        uneven_raceways: !(inner.is_ideal() && outer.is_ideal()),
        odd_ball_orders: scene.surfaces.have_odd_ball_orders(),
        unequal_balls: scene.has_unequal_balls(),
        ..LineSources::of_shaft(0.0, loads)
    }
}

/// The requested time series, whose values their receiver has.
pub fn series(recording: &Recording, settings: &RunSettings) -> Vec<Series> {
    let Some(recorded) = &recording.series else { return Vec::new() };
    recorded.keep();
    let one = |(number, channel): (usize, &Channel)| Series {
        number,
        channel: *channel,
        start: recording.start,
        step: 1.0 / RATE,
        length: recorded.length(number),
        is_finite: recorded.is_finite(number),
        values: Vec::new(),
    };
    // A reduced model may lack a channel.
    settings.outputs.series.iter().enumerate().map(one).filter(|series| series.length > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equation (15): 1 m/s² is 40.17 dB.
    #[test]
    fn one_metre_per_second_squared_is_40_17_db() {
        assert!((level_db(1.0).unwrap() - 40.17).abs() < 0.005);
        assert_eq!(level_db(0.0), None);
        assert_eq!(LEVEL_UNIT, format!("dB re {:.2} mm/s²", 1e3 * REFERENCE_ACCELERATION));
    }
}
