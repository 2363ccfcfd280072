//! The result of a run: metrics of every signal, spectra and lines of the accelerations, bearings, and the error.

use std::f64::consts::TAU;

use super::channel::MachineChannel;
use super::codes::{LeanModel, LevelDeviation, MachineWarning};
use super::equations::MachineDynamics;
use super::input::{Machine, MachineBearing};
use super::recording::{BearingRecord, MachineRecording};
use super::settings::MachineSettings;
use super::terms::OmittedTerm;
use crate::numerics::spectrum::{EnvelopeAnalysis, Spectrum, amplitude_and_envelope};
use crate::numerics::statistics::mean;
use crate::physics::kinematics::{BodySpeeds, CharacteristicFrequencies, RingSpeeds, ideal_orbit_ratio};
use crate::physics::operation::{RingRotation, SpeedProfile};
use crate::simulation::error::stationarity::trend_of;
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Term;
use crate::simulation::model::omission::{Condensation, OmissionReason};
use crate::simulation::model::terms::{Justification, LeftOut};
use crate::simulation::recording::bands::BandMetrics;
use crate::simulation::recording::sampling::{BAND, RATE};
use crate::simulation::recording::windows::InBand;
use crate::simulation::result::line_label::LEAST_BINS;
use crate::simulation::result::line_sources::{LineSources, OuterRing};
use crate::simulation::result::lines::{Line, find_lines};
use crate::simulation::result::metrics::{level_db, line_sources};
use crate::simulation::solve::eligibility::omissions;

/// The result of a run, in the units of the channels.
#[derive(Debug, Clone)]
pub struct MachineResult {
    pub channels: Vec<(MachineChannel, SignalMetrics)>,
    /// Values of the kept signals.
    pub series: Vec<(MachineChannel, Vec<f64>)>,
    /// Spectra of the accelerations and of their envelopes.
    pub spectra: Vec<SignalSpectra>,
    pub bearings: Vec<BearingMetrics>,
    /// Natural frequencies of the linear analysis about the operating point below 20 kHz [Hz], each with its damping ratio.
    pub natural_frequencies: Vec<(f64, f64)>,
    /// Number of coordinates of the shaft, and of states of the whole.
    pub coordinates: usize,
    pub states: usize,
    /// Model level of the bearings, and the terms of the system around them that are left out.
    pub level: ModelLevel,
    pub omitted: Vec<OmittedTerm>,
    pub settle: f64,
    pub duration: f64,
    pub accuracy: Accuracy,
    /// Reasons to doubt the numbers, and remarks on the steps.
    pub warnings: Vec<MachineWarning>,
    /// Growth rate of the linear analysis at the first speed [1/s]; negative: all motions decay.
    pub growth_rate: Option<f64>,
}

/// Metrics of a signal in the band of levels, 0 to 20 kHz, in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalMetrics {
    pub mean: f64,
    /// About the mean.
    pub rms: f64,
    pub peak: f64,
    pub crest_factor: Option<f64>,
    pub kurtosis: Option<f64>,
    /// Of an acceleration [dB re 9.81 mm/s²].
    pub level_db: Option<f64>,
    /// Velocity, bands and power, of accelerations only.
    pub bands: Option<BandMetrics>,
    /// Change of the level of an acceleration along the recorded time [dB], where it rises or falls throughout.
    pub trend_db: Option<f64>,
}

/// Spectra of an acceleration with the labelled lines of its amplitude spectrum.
#[derive(Debug, Clone)]
pub struct SignalSpectra {
    pub channel: MachineChannel,
    pub amplitude: Spectrum,
    pub envelope: Spectrum,
    pub lines: Vec<Line>,
    pub envelope_lines: Vec<Line>,
}

/// Loads and motion of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingMetrics {
    pub record: BearingRecord,
    /// At the simulated speeds [Hz].
    pub frequencies: CharacteristicFrequencies,
    /// 1 − cage speed / speed of ideal rolling without a contact angle [-]; `None` at rest, and where no ball moves by itself.
    pub cage_slip: Option<f64>,
    /// True if balls and cage move by themselves, so that slip and loads of pockets are known.
    pub moves_balls: bool,
}

/// How far the numbers can be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// Step [s], and time that was repeated in half steps [s].
    pub step: f64,
    pub window: f64,
    /// Estimated error of the level of each acceleration [dB]; `None` where it is silent.
    pub errors: Vec<(MachineChannel, Option<f64>)>,
    /// Evaluations of the bearings, repetitions included.
    pub evaluations: u64,
    /// Deviations from `full` of a run on another level.
    pub model: Option<ModelErrors>,
}

/// Deviations of a run from one on `full`.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelErrors {
    /// Time that was repeated on `full` [s].
    pub window: f64,
    /// Of the level of each acceleration [dB]; `None` where it is silent or faint.
    pub levels: Vec<(MachineChannel, Option<f64>)>,
}

impl ModelErrors {
    /// The largest.
    pub fn largest(&self) -> Option<(MachineChannel, f64)> {
        let known = self.levels.iter().filter_map(|(channel, error)| Some((*channel, (*error)?)));
        known.max_by(|one, other| one.1.total_cmp(&other.1))
    }
}

impl MachineResult {
    pub(super) fn of(
        machine: &Machine,
        dynamics: &MachineDynamics,
        recording: MachineRecording,
        settings: &MachineSettings,
        accuracy: Accuracy,
    ) -> Self {
        let bearings: Vec<BearingMetrics> = bearings(machine, dynamics, &recording);
        let channels = recording
            .signals
            .iter()
            .map(|(channel, values)| (*channel, metrics(*channel, values, &settings.band_edges)));
        let accelerations = recording.signals.iter().filter(|(channel, _)| channel.is_acceleration());
        let natural = dynamics.free_motion.iter().flat_map(|motion| &motion.oscillating);
        Self {
            channels: channels.collect(),
            series: settings
                .series
                .iter()
                .map(|channel| (*channel, in_unit(*channel, recording.of(*channel))))
                .collect(),
            spectra: accelerations
                .map(|(channel, values)| spectra((*channel, values), machine, &bearings, settings.envelope))
                .collect(),
            natural_frequencies: natural
                .map(|value| (value.im / TAU, -value.re / value.norm()))
                .filter(|(frequency, _)| *frequency < BAND)
                .collect(),
            coordinates: dynamics.frame.len(),
            states: dynamics.states(),
            level: dynamics.level(),
            omitted: Vec::new(),
            settle: recording.start,
            duration: recording.signals[0].1.len() as f64 / RATE,
            growth_rate: dynamics.free_motion.as_ref().map(|motion| motion.growth_rate),
            warnings: Vec::new(),
            accuracy,
            bearings,
        }
    }
}

impl MachineResult {
    /// All terms that are left out. The bound of those of the level together is the deviation from `full` that the run shows.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let of_system: Vec<LeftOut> = self.omitted.iter().map(LeftOut::from).collect();
        // A level that is linear in the tilt is not, where there is none.
        let is_new = |of_level: &LeftOut| of_system.iter().all(|omitted| omitted.term != of_level.term);
        let of_level = left_out(self.level).into_iter().filter(is_new).collect();
        [of_level, of_system].concat()
    }

    /// The largest deviation from `full`, if it is larger than a tolerance [dB].
    pub(super) fn beyond(&self, allowed_db: f64) -> Option<LevelDeviation> {
        let errors = self.accuracy.model.as_ref()?;
        let (window, (channel, error_db)) = (errors.window, errors.largest()?);
        let model = LeanModel { level: self.level, without: self.omitted.iter().map(|omitted| omitted.term).collect() };
        (error_db > allowed_db).then_some(LevelDeviation { model, channel, error_db, allowed_db, window })
    }
}

/// Terms that a level omits.
fn left_out(level: ModelLevel) -> Vec<LeftOut> {
    if level == ModelLevel::Full {
        return Vec::new();
    }
    let reason = OmissionReason::Condensed(level, Condensation::LinearMoments);
    let tilt = LeftOut { term: "tilt", reason, by: Justification::Judgement, bound: None };
    let of_level = if level == ModelLevel::Planar { vec![in_plane()] } else { omissions(level, true) };
    of_level.into_iter().chain([tilt]).collect()
}

/// Motion out of the plane, which `planar` leaves out.
fn in_plane() -> LeftOut {
    let reason = OmissionReason::Condensed(ModelLevel::Planar, Condensation::StaysInPlane);
    LeftOut { term: Term::CageTilt.name(), reason, by: Justification::Judgement, bound: None }
}

fn metrics(channel: MachineChannel, values: &[f64], edges: &[f64]) -> SignalMetrics {
    let in_band = InBand::of(values, edges);
    let (moments, scale) = (in_band.moments, channel.scale());
    let is_acceleration = channel.is_acceleration();
    SignalMetrics {
        mean: scale * mean(values),
        rms: scale * moments.rms(),
        peak: scale * moments.peak(),
        crest_factor: moments.crest_factor(),
        kurtosis: moments.kurtosis(),
        level_db: if is_acceleration { level_db(moments.rms()) } else { None },
        bands: is_acceleration.then(|| in_band.bands.metrics(moments.rms())),
        trend_db: if is_acceleration { trend_of(&in_band) } else { None },
    }
}

fn bearings(machine: &Machine, dynamics: &MachineDynamics, recording: &MachineRecording) -> Vec<BearingMetrics> {
    let rotation = RingRotation { inner: dynamics.speed.clone(), outer: dynamics.outer_speed.clone() };
    let mean = |profile: &SpeedProfile| mean_speed(profile, recording);
    let rings = RingSpeeds { inner: mean(&rotation.inner), outer: mean(&rotation.outer) };
    let moves_balls = dynamics.level() != ModelLevel::SpindleOnly;
    let of = |(bearing, record): (&MachineBearing, &BearingRecord)| {
        let geometry = &bearing.scene.bearing;
        let speeds = BodySpeeds::new(rings, record.cage_speed, record.ball_spin.abs());
        BearingMetrics {
            record: *record,
            frequencies: speeds.in_turns().frequencies(geometry),
            cage_slip: speeds.cage_slip(ideal_orbit_ratio(geometry)).filter(|_| moves_balls && !rotation.reverses()),
            moves_balls,
        }
    };
    machine.bearings.iter().zip(&recording.bearings).map(of).collect()
}

/// Mean speed over the recorded time [rad/s].
fn mean_speed(speed: &SpeedProfile, recording: &MachineRecording) -> f64 {
    let (start, duration) = (recording.start, recording.signals[0].1.len() as f64 / RATE);
    match speed.is_constant() {
        true => speed.at(start).1,
        false => (speed.at(start + duration).0 - speed.at(start).0) / duration,
    }
}

/// Values in the unit of a channel.
fn in_unit(channel: MachineChannel, values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| channel.scale() * value).collect()
}

fn spectra(
    (channel, values): (MachineChannel, &[f64]),
    machine: &Machine,
    bearings: &[BearingMetrics],
    analysis: EnvelopeAnalysis,
) -> SignalSpectra {
    let scaled = in_unit(channel, values);
    let (amplitude, envelope) = amplitude_and_envelope(&scaled, RATE, analysis);
    let is_constant = machine.speed.is_constant() && machine.outer_speed.is_constant();
    let lines = |spectrum: &Spectrum| if is_constant { labelled(spectrum, machine, bearings) } else { Vec::new() };
    SignalSpectra { channel, lines: lines(&amplitude), envelope_lines: lines(&envelope), amplitude, envelope }
}

/// Lines labelled by the bearing whose combination lies nearest; labels of balls and cages name it, as `BPFO@A`.
fn labelled(spectrum: &Spectrum, machine: &Machine, bearings: &[BearingMetrics]) -> Vec<Line> {
    let harmonics = machine.rotor.loads.iter().filter_map(|load| load.load.harmonic());
    let loads: Vec<f64> = harmonics.map(|harmonic| harmonic.frequency(machine.rotor.speed)).collect();
    if machine.bearings.is_empty() {
        return find_lines(spectrum, &LineSources::of_shaft(machine.rotor.speed, &loads), BAND);
    }
    let is_uneven_inner = |bearing: &MachineBearing| !bearing.scene.surfaces.raceway.inner.is_ideal();
    let shaft_is_marked = !machine.rotor.unbalances.is_empty() || machine.bearings.iter().any(is_uneven_inner);
    let mut best: Vec<BearingLine> = Vec::new();
    for (index, (bearing, metrics)) in machine.bearings.iter().zip(bearings).enumerate() {
        let (scene, surfaces) = (&bearing.scene, &bearing.scene.surfaces);
        let outer_ring = match machine.outer_speed.largest() == 0.0 {
            true => OuterRing::Stands,
            false => OuterRing::Turns { is_uneven: !surfaces.raceway.outer.is_ideal() },
        };
        let orders = surfaces.raceway.inner.given_orders();
        let own = metrics.record.heard_spin;
        let frequencies = match own == 0.0 {
            true => metrics.frequencies,
            false => CharacteristicFrequencies { ball_spin: own / TAU, ..metrics.frequencies },
        };
        let sources = line_sources(scene, &frequencies, (shaft_is_marked, outer_ring), (&orders, &loads));
        let is_uneven = scene.has_unequal_balls() || !surfaces.are_ideal();
        let found = find_lines(spectrum, &sources, BAND).into_iter();
        let found = found.map(|line| BearingLine { line, bearings: vec![index], is_uneven });
        if best.is_empty() {
            best = found.collect();
            continue;
        }
        best.iter_mut().zip(found).for_each(|(line, other)| line.join(other, spectrum.resolution));
    }
    best.into_iter().map(|line| line.named(machine)).collect()
}

/// A line, and the bearings that may make it.
struct BearingLine {
    line: Line,
    bearings: Vec<usize>,
    /// True if surfaces or balls of these bearings are uneven.
    is_uneven: bool,
}

impl BearingLine {
    /// Takes the combination of another bearing where that lies nearer. Of two that lie equally near, that of the only uneven bearing is taken. Equal
    /// ones within a bin, whose lines are one peak, name both bearings.
    fn join(&mut self, other: Self, resolution: f64) {
        if other.line.label.is_empty() {
            return;
        }
        let apart = (other.line.deviation - self.line.deviation).abs();
        let is_equal = other.line.label == self.line.label;
        let is_near = apart < if is_equal { resolution } else { LEAST_BINS * resolution };
        if self.line.label.is_empty() {
            *self = other;
        } else if is_near && other.is_uneven != self.is_uneven {
            if other.is_uneven {
                *self = other;
            }
        } else if is_near && is_equal {
            self.bearings.extend(other.bearings);
        } else if other.line.deviation.abs() < self.line.deviation.abs() {
            *self = other;
        }
    }

    /// The line with the names of its bearings, unless the shaft alone makes it.
    fn named(self, machine: &Machine) -> Line {
        let Self { line, bearings, .. } = self;
        let is_of_bearing = ["BPF", "FTF", "BSF"].iter().any(|source| line.label.contains(source));
        if !is_of_bearing {
            return line;
        }
        let names: Vec<&str> = bearings.iter().map(|&index| machine.bearings[index].name.as_str()).collect();
        Line { label: format!("{}@{}", line.label, names.join("/")), ..line }
    }
}
