//! The result of a machine job as JSON.

use std::collections::BTreeMap;

use raceway_core::machine::channel::MachineChannel;
use raceway_core::machine::input::{Loss, Machine, MachineError};
use raceway_core::machine::result::{BearingMetrics, MachineResult, SignalMetrics, SignalSpectra};
use raceway_core::machine::simulate::simulate_on;
use raceway_core::numerics::spectrum::EnvelopeKind;
use raceway_core::simulation::input::control::Control;
use raceway_core::simulation::input::model_level::ModelLevel;
use raceway_core::simulation::recording::bands::BandMetrics;
use raceway_core::simulation::recording::sampling::RATE;
use raceway_core::simulation::result::lines::Line;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::arrangement::{ArrangementAnswer, arrangements};
use super::failure::{DID_NOT_CONVERGE, NUMERICAL_BLOWUP, RunFailure, SPINDLE_LEFT_BEARING};
use super::headline::{BandAnswer, HeadlineAnswer, bands, in_g, velocity_mm_s};
use super::messages::{self, MessageAnswer};
use super::metrics::LineAnswer;
use super::report::LeftOutAnswer;
use super::signals::{SeriesHead, SpectrumAnswer, SpectrumKind, unit_of_envelope};
use crate::contract::job::machine::MachineJob;
use crate::contract::job::outputs::EnvelopeName;
use crate::contract::json::units::US;

/// Result of a machine job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MachineJobAnswer)]
pub struct MachineAnswer {
    /// Levels of the acceleration of the first sensor in the units and references of the trade; without sensors of the first bearing or body along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub headline: Option<HeadlineAnswer>,
    /// Metrics of each signal from 0 to 20 kHz, by channel: `A.y.acceleration` of the inner ring of bearing A, `A.force.y` and
    /// `A.moment.z` of the shaft on it, `A.tilt.y`, `A.cage.speed`, `sensor.NAME.acceleration`.
    pub channels: BTreeMap<String, MachineChannelAnswer>,
    /// Lines of the spectra of the accelerations, strongest first within each channel. A label that names balls or cage ends in `@` and the
    /// name of the bearing.
    pub lines: Vec<LineAnswer>,
    /// Lines of the spectra of their envelopes (`outputs.envelope_band_hz`).
    pub envelope_lines: Vec<LineAnswer>,
    /// `squared`: `envelope_lines` are those of squared envelopes, in the square of the unit. Absent: of envelopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub envelope: Option<EnvelopeName>,
    /// Loads and motion of each bearing, by its name.
    pub bearings: BTreeMap<String, MachineBearingAnswer>,
    /// How neighbouring bearings face each other by `faces`, along the shaft; of bearings that carry thrust one way. Absent with fewer than two.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arrangements: Vec<ArrangementAnswer>,
    /// Natural motions of shaft and bearings, linear about the operating point, below 20 kHz.
    pub natural_frequencies: Vec<NaturalFrequencyAnswer>,
    /// True if every natural motion decays at the operating speed by the linear analysis, without tractions of balls and pockets of cages; absent where
    /// supports and loaded bearings leave a motion free.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub is_stable: Option<bool>,
    /// Coordinates and steps of the run.
    pub model: MachineModelAnswer,
    /// How far the levels can be trusted.
    pub accuracy: MachineAccuracyAnswer,
    /// Messages about the result: warnings first, then the steps that were rejected. See `MessageCode`.
    // Results of builds before the messages have none.
    #[serde(default)]
    #[schema(required = true)]
    pub messages: Vec<MessageAnswer>,
}

/// Metrics of a signal in its unit, from 0 to 20 kHz.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachineChannelAnswer {
    /// Unit of `mean`, `rms` and `peak`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Mean.
    pub mean: f64,
    /// Root mean square about the mean.
    #[schema(minimum = 0)]
    pub rms: f64,
    /// Largest distance from the mean.
    #[schema(minimum = 0)]
    pub peak: f64,
    /// Peak over rms [-]; absent where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub crest_factor: Option<f64>,
    /// Kurtosis [-]: 3 of noise, 1.5 of a sine; absent where nothing moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub kurtosis: Option<f64>,
    /// Level of an acceleration [dB re 9.81 mm/s²].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub level_db: Option<f64>,
    /// Root mean square about the mean in multiples of g = 9.80665 m/s²; accelerations only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub rms_g: Option<f64>,
    /// Largest distance from the mean in multiples of g; accelerations only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub peak_g: Option<f64>,
    /// Root mean square of the velocity from 10 to 1000 Hz [mm/s], with sharp edges, from Hann spectra; accelerations only, from 0.2 s on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub velocity_10_1000_hz_mm_s: Option<f64>,
    /// Mean square of the Hann spectra up to 20 kHz over that of the signal [-]: 1 of steady motion; accelerations only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub parseval_ratio: Option<f64>,
    /// Vibration of an acceleration in three bands.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<BandAnswer>,
}

/// Loads and motion of a bearing over the recorded time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachineBearingAnswer {
    /// Turns of the shaft [Hz].
    pub shaft_hz: f64,
    /// Turns of the outer ring [Hz]; absent where it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub outer_ring_hz: Option<f64>,
    /// FTF: turns of the cage at its simulated speed [Hz].
    pub cage_hz: f64,
    /// BPFO: balls passing a point of the outer raceway [Hz].
    pub ball_pass_outer_hz: f64,
    /// BPFI: balls passing a point of the inner raceway [Hz].
    pub ball_pass_inner_hz: f64,
    /// BSF: turns of a ball [Hz].
    pub ball_spin_hz: f64,
    /// 1 − cage speed over that of ideal rolling at the free contact angle [-], both as seen from the ring that turns more slowly; absent at
    /// rest and on `spindle_only`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub cage_slip: Option<f64>,
    /// Largest load of a ball on the inner raceway [N].
    #[schema(minimum = 0)]
    pub max_inner_load_n: f64,
    /// Largest load of a ball on the outer raceway [N].
    #[schema(minimum = 0)]
    pub max_outer_load_n: f64,
    /// Largest load of a pocket [N]; absent on `spindle_only`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_pocket_load_n: Option<f64>,
    /// Largest slip of a loaded contact [m/s]; absent on `spindle_only`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub max_slip_m_s: Option<f64>,
}

/// A natural motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NaturalFrequencyAnswer {
    /// [Hz]
    pub frequency_hz: f64,
    /// Damping ratio [-]; negative: the motion grows.
    pub damping_ratio: f64,
}

/// Size and steps of the calculation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachineModelAnswer {
    /// Model level of the bearings.
    // Results of builds before the levels have none.
    #[serde(default = "full")]
    #[schema(required = true, example = "full")]
    pub rung: String,
    /// Terms that the model level omits. The bound of all together is the largest of `accuracy.model_errors_db`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOutAnswer>,
    /// Number of coordinates of the shaft: modes, and static answers of the rest.
    pub coordinates: u64,
    /// Number of first-order states of shaft, balls and cages.
    pub states: u64,
    /// Step [µs].
    pub step_us: f64,
    /// Time before the record [s].
    pub settle_s: f64,
    /// Recorded time [s].
    pub duration_s: f64,
    /// Evaluations of all bearings, repetitions included.
    pub evaluations: u64,
}

/// Estimated errors, from a repetition in half steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MachineAccuracyAnswer {
    /// Time that was repeated [s].
    pub repeated_s: f64,
    /// Estimated error of the level of each acceleration by its steps [dB], by channel; absent of silent and faint ones.
    pub level_errors_db: BTreeMap<String, f64>,
    /// Deviation of these levels from a run on `full` over the same time [dB]; absent on `full`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub model_errors_db: Option<BTreeMap<String, f64>>,
}

/// The level of all results that do not name one.
fn full() -> String {
    ModelLevel::Full.name().to_owned()
}

/// Result and spectra of a machine job.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineOutcome {
    pub answer: MachineAnswer,
    /// Amplitude and envelope spectrum of each acceleration.
    pub spectra: Vec<SpectrumAnswer>,
    /// The kept series, in the order of the request.
    pub series: Vec<MachineSeries>,
}

/// A kept series.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineSeries {
    pub head: SeriesHead,
    /// Empty if a receiver has taken them.
    pub values: Vec<f64>,
    pub is_finite: bool,
}

impl MachineOutcome {
    /// Runs the job.
    pub fn of(job: &MachineJob, control: &Control<'_>) -> Result<Self, RunFailure> {
        let result = simulate_on(job.level, &job.machine, &job.settings, control)?;
        let kind = job.settings.envelope.kind;
        let spectra = spectra(&job.machine, &result, kind);
        let (answer, series) = (answer(job, &result), series(&job.machine, result, control));
        Ok(Self { answer, spectra, series })
    }
}

impl From<MachineError> for RunFailure {
    fn from(error: MachineError) -> Self {
        let cause = match error {
            MachineError::Stopped(_) => return Self::Cancelled,
            MachineError::Lost { cause: Loss::Left { .. }, .. } => SPINDLE_LEFT_BEARING,
            MachineError::Lost { cause: Loss::NotFinite { .. } | Loss::FrameNotFinite, .. } => NUMERICAL_BLOWUP,
            MachineError::Lost { cause: Loss::TooDeep { .. } | Loss::Collision { .. } | Loss::Unresolved, .. }
            | MachineError::Grows { .. }
            | MachineError::TooManyModes(_)
            | MachineError::NotApplicable { .. }
            | MachineError::Rotor(_)
            | MachineError::Bearing { .. } => DID_NOT_CONVERGE,
        };
        Self::Failed { cause, detail: error.to_string() }
    }
}

fn answer(job: &MachineJob, result: &MachineResult) -> MachineAnswer {
    let (machine, envelope) = (&job.machine, job.settings.envelope.kind);
    let named = |channel: &MachineChannel| channel.named(machine).to_string();
    let lines = |of: fn(&SignalSpectra) -> &Vec<Line>| {
        let of_channel = |spectra: &'_ SignalSpectra| -> Vec<LineAnswer> {
            of(spectra).iter().map(|line| line_answer(named(&spectra.channel), line)).collect()
        };
        result.spectra.iter().flat_map(of_channel).collect()
    };
    let known = |errors: &[(MachineChannel, Option<f64>)]| -> BTreeMap<String, f64> {
        errors.iter().filter_map(|(channel, error)| Some((named(channel), (*error)?))).collect()
    };
    let model_errors_db = result.accuracy.model.as_ref().map(|model| known(&model.levels));
    MachineAnswer {
        headline: headline(machine, result),
        channels: result
            .channels
            .iter()
            .map(|(channel, metrics)| (named(channel), channel_answer(channel, metrics)))
            .collect(),
        lines: lines(|spectra| &spectra.lines),
        envelope_lines: lines(|spectra| &spectra.envelope_lines),
        envelope: (envelope == EnvelopeKind::Squared).then_some(EnvelopeName::Squared),
        bearings: machine
            .bearings
            .iter()
            .map(|bearing| bearing.name.clone())
            .zip(result.bearings.iter().map(bearing_answer))
            .collect(),
        arrangements: arrangements(&job.input.scene),
        natural_frequencies: result
            .natural_frequencies
            .iter()
            .map(|&(frequency_hz, damping_ratio)| NaturalFrequencyAnswer { frequency_hz, damping_ratio })
            .collect(),
        is_stable: result.growth_rate.map(|rate| rate < 0.0),
        model: MachineModelAnswer {
            rung: result.level.name().to_owned(),
            left_out: result.left_out().iter().map(LeftOutAnswer::from).collect(),
            coordinates: result.coordinates as u64,
            states: result.states as u64,
            step_us: US.to_user(result.accuracy.step),
            settle_s: result.settle,
            duration_s: result.duration,
            evaluations: result.accuracy.evaluations,
        },
        accuracy: MachineAccuracyAnswer {
            repeated_s: result.accuracy.window,
            level_errors_db: known(&result.accuracy.errors),
            model_errors_db,
        },
        messages: result
            .warnings
            .iter()
            .map(|warning| messages::of_machine(machine, warning))
            .chain(messages_of_bands(machine, result))
            .collect(),
    }
}

/// The headline of the first sensor, bearing or body.
fn headline(machine: &Machine, result: &MachineResult) -> Option<HeadlineAnswer> {
    let (channel, metrics, of) = first_acceleration(machine, result)?;
    HeadlineAnswer::of(channel.named(machine).to_string(), metrics.rms, metrics.peak, of, bands(of, None))
}

/// The channel of the headline with its metrics and bands.
fn first_acceleration<'a>(
    machine: &Machine,
    result: &'a MachineResult,
) -> Option<(MachineChannel, &'a SignalMetrics, &'a BandMetrics)> {
    let first = MachineChannel::first_acceleration(machine);
    let (_, metrics) = result.channels.iter().find(|(channel, _)| *channel == first)?;
    Some((first, metrics, metrics.bands.as_ref()?))
}

/// Messages about the bands of the headline.
fn messages_of_bands(machine: &Machine, result: &MachineResult) -> Vec<MessageAnswer> {
    let Some((channel, metrics, bands)) = first_acceleration(machine, result) else { return Vec::new() };
    let spectra = result.spectra.iter().filter(|spectra| spectra.channel == channel);
    let lines: Vec<&Line> = spectra.flat_map(|spectra| &spectra.lines).collect();
    messages::of_bands(&channel.named(machine).to_string(), metrics.rms, bands, &lines)
}

fn channel_answer(channel: &MachineChannel, metrics: &SignalMetrics) -> MachineChannelAnswer {
    let of_bands = metrics.bands.as_ref();
    MachineChannelAnswer {
        unit: channel.unit().to_owned(),
        mean: metrics.mean,
        rms: metrics.rms,
        peak: metrics.peak,
        crest_factor: metrics.crest_factor,
        kurtosis: metrics.kurtosis,
        level_db: metrics.level_db,
        rms_g: of_bands.map(|_| in_g(metrics.rms)),
        peak_g: of_bands.map(|_| in_g(metrics.peak)),
        velocity_10_1000_hz_mm_s: of_bands.and_then(velocity_mm_s),
        parseval_ratio: of_bands.and_then(|of| of.parseval_ratio),
        bands: of_bands.map(|of| bands(of, None)).unwrap_or_default(),
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

fn bearing_answer(metrics: &BearingMetrics) -> MachineBearingAnswer {
    let (record, at) = (&metrics.record, &metrics.frequencies);
    MachineBearingAnswer {
        shaft_hz: at.shaft,
        outer_ring_hz: (at.outer_ring > 0.0).then_some(at.outer_ring),
        cage_hz: at.cage,
        ball_pass_outer_hz: at.ball_pass_outer,
        ball_pass_inner_hz: at.ball_pass_inner,
        ball_spin_hz: at.ball_spin,
        cage_slip: metrics.cage_slip,
        max_inner_load_n: record.inner_load,
        max_outer_load_n: record.outer_load,
        max_pocket_load_n: metrics.moves_balls.then_some(record.pocket_load),
        max_slip_m_s: metrics.moves_balls.then_some(record.slip),
    }
}

fn spectra(machine: &Machine, result: &MachineResult, envelope: EnvelopeKind) -> Vec<SpectrumAnswer> {
    let of = |spectra: &SignalSpectra| {
        let (channel, unit) = (spectra.channel.named(machine).to_string(), spectra.channel.unit());
        [
            (SpectrumKind::Amplitude, unit.to_owned(), &spectra.amplitude),
            (SpectrumKind::Envelope, unit_of_envelope(unit, envelope), &spectra.envelope),
        ]
        .map(|(kind, unit, spectrum)| {
            SpectrumAnswer::of_steps((channel.clone(), unit), kind, spectrum, result.accuracy.step)
        })
    };
    result.spectra.iter().flat_map(of).collect()
}

/// The kept series. A receiver of `control` takes their values.
fn series(machine: &Machine, result: MachineResult, control: &Control<'_>) -> Vec<MachineSeries> {
    let start = result.settle;
    let sink = control.series.filter(|_| !result.series.is_empty()).map(|sink| (sink, sink.begin()));
    let kept = |(number, (channel, mut values)): (usize, (MachineChannel, Vec<f64>))| {
        let head = SeriesHead {
            channel: channel.named(machine).to_string(),
            unit: channel.unit().to_owned(),
            start_s: start,
            step_s: RATE.recip(),
            length: values.len(),
        };
        let is_finite = values.iter().all(|value| value.is_finite());
        if let Some((sink, recording)) = sink {
            sink.write(recording, number, &values);
            values = Vec::new();
        }
        MachineSeries { head, values, is_finite }
    };
    result.series.into_iter().enumerate().map(kept).collect()
}
