//! Levels and lines of a measured record beside those of a prediction.

use raceway_core::measured::lines::{MeasuredLine, lines_of, peaks_of};
use raceway_core::measured::partners::{PredictedLine, SHIFT_BINS, Shifts, partners};
use raceway_core::measured::record::{Division, Record};
use raceway_core::numerics::spectrum::{EnvelopeAnalysis, EnvelopeKind, Spectrum};
use raceway_core::simulation::recording::bands::{LOWEST_BIN, SEVERITY_BAND};
use raceway_core::simulation::recording::sampling::BAND;

use super::measured::{
    ComparedRecordAnswer, EnvelopeComparisonAnswer, GainAnswer, LevelComparisonAnswer, LineComparisonAnswer,
    MeasuredAnswer, UnmatchedLineAnswer, UnmatchedLinesAnswer,
};
use super::metrics::LineAnswer;
use super::signals::{SpectrumAnswer, SpectrumKind, unit_of_envelope};
use super::spectrum_view::SpectrumQuantity;
use crate::contract::job::measurement::{MeasuredUnit, Measurement};
use crate::contract::json::numbers::{short, significant};
use crate::contract::json::problem::{FieldError, Refusal};

/// Largest number of measured lines without a partner, and of further predicted peaks with one.
const MOST_LISTED: usize = 20;
/// Difference of the speeds from which on a note says so [-].
const OTHER_SPEED: f64 = 0.02;

/// Parts of a prediction that a comparison needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Amplitude spectrum of the channel.
    pub spectrum: SpectrumAnswer,
    /// Analysis behind the kept envelope; `None` where none is kept.
    pub envelope: Option<EnvelopeAnalysis>,
    /// Speed of the shaft [Hz].
    pub speed_hz: f64,
    pub lines: Vec<LineAnswer>,
    pub envelope_lines: Vec<LineAnswer>,
    pub level_error_db: Option<f64>,
    pub level_scatter_db: Option<f64>,
    /// True if the level of the channel is resolved.
    pub is_resolved: bool,
}

impl MeasuredAnswer {
    /// The comparison; `None` where `stop` returns true.
    pub fn of(
        measurement: &Measurement,
        prediction: &Prediction,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, Refusal> {
        let predicted = &prediction.spectrum;
        let factor = unit_factor(measurement.unit, &predicted.channel)? * measurement.gain.unwrap_or(1.0);
        let scaled: Vec<f64> = measurement.record().values.iter().map(|value| factor * value).collect();
        let record = Record { values: &scaled, ..measurement.record() };
        let highest = record.highest_frequency();
        let (from, to) = (LOWEST_BIN * predicted.resolution_hz, highest.min(BAND));
        let is_covered = |analysis: &EnvelopeAnalysis| analysis.band.1 <= highest;
        let division =
            Division::of(predicted.resolution_hz, predicted.averages, prediction.envelope.filter(is_covered));
        let averages = record.windows(&division);
        if averages == 0 {
            let [window, duration] =
                [1.0 / predicted.resolution_hz, record.duration()].map(|time| short(significant(time, 4)));
            let detail = format!(
                "{duration} s are analysed: the spectra of the prediction need windows of {window} s. Measure longer, or predict with a shorter duration_s"
            );
            return Err(FieldError::new("/series", detail).into());
        }
        if to <= from {
            let [from, to] = [from, to].map(|frequency| short(significant(frequency, 4)));
            let detail = format!("the record holds frequencies up to {to} Hz: the spectrum begins at {from} Hz");
            return Err(FieldError::new("/series", detail).into());
        }
        let Some(spectra) = record.spectra(&division, stop) else { return Ok(None) };
        let speed = record.turning.speed();
        let head = (predicted.channel.clone(), predicted.unit.clone());
        let measured = SpectrumAnswer::of_steps(head, SpectrumKind::Amplitude, &spectra.amplitude, 0.0);
        let mut notes = vec![TRANSFER.to_owned()];
        notes.extend(prediction_notes(prediction, &division, averages, speed));
        let levels = Levels { measured: &measured, prediction, from, to };
        let levels = levels.all(&measurement.band_edges, &mut notes);
        let speeds = [prediction.speed_hz, speed];
        let own = |line: &&LineAnswer| line.channel == predicted.channel && (from..=to).contains(&line.frequency_hz);
        let lines: Vec<&LineAnswer> = prediction.lines.iter().filter(own).collect();
        let others = other_peaks(predicted, &lines, (from, to));
        let (lines, unmatched) = compared_lines((&lines, &others), &spectra.amplitude, to, speeds, AMPLITUDES);
        let envelope = spectra.envelope.as_ref().zip(division.envelope).map(|(spectrum, analysis)| {
            let decibels = if analysis.kind == EnvelopeKind::Squared { SQUARES } else { AMPLITUDES };
            let own: Vec<&LineAnswer> = prediction.envelope_lines.iter().filter(own).collect();
            let (lines, unmatched) = compared_lines((&own, &[]), spectrum, to, speeds, decibels);
            let unit = unit_of_envelope(&predicted.unit, analysis.kind);
            EnvelopeComparisonAnswer { unit, band_hz: vec![analysis.band.0, analysis.band.1], lines, unmatched }
        });
        if let Some(analysis) = prediction.envelope.filter(|analysis| !is_covered(analysis)) {
            let [low, high, most] =
                [analysis.band.0, analysis.band.1, highest].map(|value| short(significant(value, 4)));
            notes.push(format!(
                "The envelope of {low} to {high} Hz is not compared, because the record holds frequencies up to {most} Hz. Predict with outputs.envelope_band_hz below it."
            ));
        }
        Ok(Some(Self {
            channel: predicted.channel.clone(),
            unit: predicted.unit.clone(),
            gain: measurement.gain.map(|factor| GainAnswer { factor, db: 20.0 * factor.log10() }),
            measured: ComparedRecordAnswer { speed_rpm: 60.0 * speed, averages },
            predicted: ComparedRecordAnswer { speed_rpm: 60.0 * prediction.speed_hz, averages: predicted.averages },
            resolution_hz: predicted.resolution_hz,
            from_hz: from,
            to_hz: to,
            levels,
            lines,
            unmatched,
            envelope,
            notes,
        }))
    }
}

const TRANSFER: &str = "level_ratio_db is an apparent transfer from the bearing to the sensor, whose path is unknown. It is no error of the prediction.";
/// Decibels of a factor on amplitudes, and of one on their squares.
const AMPLITUDES: f64 = 20.0;
const SQUARES: f64 = 10.0;

/// Factor from values in a measured unit to those of a channel; a refusal where the channel is of another motion.
pub fn unit_factor(unit: MeasuredUnit, channel: &str) -> Result<f64, Refusal> {
    let (motion, size) = unit.of_channels();
    match SpectrumQuantity::of(channel) {
        Some(quantity) if quantity.name() == motion => Ok(size),
        _ => {
            let detail = format!("a unit of {motion}, but the channel is `{channel}`");
            Err(FieldError::new("/unit", detail).into())
        }
    }
}

fn prediction_notes(prediction: &Prediction, division: &Division, averages: usize, speed: f64) -> Vec<String> {
    let mut notes = Vec::new();
    if averages < division.count {
        notes.push(format!("The record fills {averages} of the {} windows of the prediction.", division.count));
    }
    if (speed / prediction.speed_hz - 1.0).abs() > OTHER_SPEED {
        let [measured, predicted] = [speed, prediction.speed_hz].map(|hertz| short(significant(60.0 * hertz, 5)));
        notes.push(format!(
            "The shaft was measured at {measured} r/min and predicted at {predicted} r/min. Orders can be compared; levels depend on the speed."
        ));
    }
    if !prediction.is_resolved {
        notes.push("The predicted level is not resolved (message not-resolved): ratios have no meaning.".to_owned());
    }
    notes
}

/// Measured and predicted spectra that are compared from one frequency to another [Hz].
struct Levels<'a> {
    measured: &'a SpectrumAnswer,
    prediction: &'a Prediction,
    from: f64,
    to: f64,
}

impl Levels<'_> {
    /// The level of the whole band, and of an acceleration those of its velocity and of the bands between edges [Hz].
    fn all(&self, edges: &[f64], notes: &mut Vec<String>) -> Vec<LevelComparisonAnswer> {
        let Some(own) = SpectrumQuantity::of(&self.measured.channel) else { return Vec::new() };
        let whole = LevelComparisonAnswer {
            predicted_error_db: self.prediction.level_error_db,
            predicted_scatter_db: self.prediction.level_scatter_db,
            ..self.level(own, self.from, self.to)
        };
        let mut levels = vec![whole];
        if own != SpectrumQuantity::Acceleration {
            return levels;
        }
        // The ends of the compared band are multiples of the resolution up to rounding.
        let covers = |from: f64, to: f64| from >= self.from * (1.0 - 1e-9) && to <= self.to * (1.0 + 1e-9);
        if covers(SEVERITY_BAND.0, SEVERITY_BAND.1) {
            levels.push(self.level(SpectrumQuantity::Velocity, SEVERITY_BAND.0, SEVERITY_BAND.1));
        }
        for ends in edges.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            if covers(from, to) {
                levels.push(self.level(SpectrumQuantity::Acceleration, from, to));
                levels.push(self.level(SpectrumQuantity::Velocity, from, to));
            } else {
                let [from, to, low, high] = [from, to, self.from, self.to].map(|value| short(significant(value, 4)));
                notes.push(format!("The band from {from} to {to} Hz is not compared, because only {low} to {high} Hz is common to both spectra."));
            }
        }
        levels
    }

    fn level(&self, quantity: SpectrumQuantity, from: f64, to: f64) -> LevelComparisonAnswer {
        let own = SpectrumQuantity::of(&self.measured.channel);
        let [measured, predicted] = [self.measured, &self.prediction.spectrum].map(|spectrum| {
            let band = spectrum.band(from, to);
            // The sums of a spectrum are in its own unit, whatever motion it is of.
            if own == Some(quantity) { band.acceleration_rms_m_s2 } else { band.velocity_rms_um_s }
        });
        let unit = if own == Some(quantity) { self.measured.unit.as_str() } else { "µm/s" };
        LevelComparisonAnswer {
            quantity,
            from_hz: from,
            to_hz: to,
            unit: unit.to_owned(),
            measured,
            predicted,
            level_ratio_db: ratio(AMPLITUDES, measured, predicted),
            predicted_error_db: None,
            predicted_scatter_db: None,
        }
    }
}

/// Ratio in decibels; `None` where a value is 0.
fn ratio(decibels: f64, measured: f64, predicted: f64) -> Option<f64> {
    (measured > 0.0 && predicted > 0.0).then(|| decibels * (measured / predicted).log10())
}

/// Peaks of a predicted spectrum between two frequencies [Hz] beside its listed lines, which are no more than the strongest. They have no labels.
fn other_peaks(predicted: &SpectrumAnswer, listed: &[&LineAnswer], (from, to): (f64, f64)) -> Vec<LineAnswer> {
    let spectrum = Spectrum {
        resolution: predicted.resolution_hz,
        amplitude: predicted.amplitude.clone(),
        window: "hann",
        averages: predicted.averages,
    };
    let reach = SHIFT_BINS * predicted.resolution_hz;
    let is_listed = |frequency: f64| listed.iter().any(|line| (line.frequency_hz - frequency).abs() <= reach);
    let others =
        peaks_of(&spectrum, to).into_iter().filter(|peak| peak.frequency >= from && !is_listed(peak.frequency));
    let line = |peak: MeasuredLine| LineAnswer {
        channel: predicted.channel.clone(),
        frequency_hz: peak.frequency,
        amplitude: peak.amplitude,
        label: String::new(),
        deviation_hz: 0.0,
    };
    others.map(line).collect()
}

/// Predicted lines by the order of their shaft, which turns at a speed [Hz].
fn by_order<'a>(lines: &[&'a LineAnswer], speed: f64) -> Vec<PredictedLine<'a>> {
    let line = |line: &&'a LineAnswer| PredictedLine {
        order: line.frequency_hz / speed,
        amplitude: line.amplitude,
        label: &line.label,
    };
    lines.iter().map(line).collect()
}

/// Listed predicted lines with their partners, then other predicted peaks with theirs, strongest first; and lines without one. `speeds`: of the
/// predicted and of the measured shaft [Hz].
fn compared_lines(
    (listed, others): (&[&LineAnswer], &[LineAnswer]),
    spectrum: &Spectrum,
    highest: f64,
    speeds: [f64; 2],
    decibels: f64,
) -> (Vec<LineComparisonAnswer>, UnmatchedLinesAnswer) {
    let measured = lines_of(spectrum, highest);
    let of_shaft = |line: &LineAnswer| line.frequency_hz / speeds[0];
    let reach = SHIFT_BINS * spectrum.resolution / speeds[1];
    let orders =
        |measured: &[MeasuredLine]| measured.iter().map(|line| line.frequency / speeds[1]).collect::<Vec<f64>>();
    let shifts = Shifts::of(&by_order(listed, speeds[0]), &orders(&measured), reach);
    let compared = |line: &LineAnswer, found: &MeasuredLine| {
        let (predicted_order, measured_order) = (of_shaft(line), found.frequency / speeds[1]);
        LineComparisonAnswer {
            label: line.label.clone(),
            predicted_order,
            measured_order,
            order_difference_percent: 100.0 * (measured_order / predicted_order - 1.0),
            predicted_amplitude: line.amplitude,
            measured_amplitude: found.amplitude,
            level_ratio_db: ratio(decibels, found.amplitude, line.amplitude),
            over_floor_db: found.over_floor.map(|over| AMPLITUDES * over.log10()),
        }
    };
    let without = |measured: &[MeasuredLine], taken: &[Option<usize>]| -> Vec<MeasuredLine> {
        let is_left = |(number, _): &(usize, &MeasuredLine)| !taken.contains(&Some(*number));
        measured.iter().enumerate().filter(is_left).map(|(_, line)| *line).collect()
    };
    let of_listed = partners(&by_order(listed, speeds[0]), &orders(&measured), &shifts, reach);
    let left = without(&measured, &of_listed);
    let others: Vec<&LineAnswer> = others.iter().collect();
    let (peaks, left_orders) = (by_order(&others, speeds[0]), orders(&left));
    let of_others = partners(&peaks, &left_orders, &shifts.of_peaks(&peaks, &left_orders, reach), reach);
    let found = listed.iter().zip(&of_listed).filter_map(|(line, at)| Some(compared(line, &measured[(*at)?])));
    let pairs = others.iter().zip(&of_others).filter_map(|(line, at)| Some((line, (*at)?)));
    let shown: Vec<(&&LineAnswer, usize)> = pairs.take(MOST_LISTED).collect();
    let also_found = shown.iter().map(|&(line, at)| compared(line, &left[at]));
    let lines = found.chain(also_found).collect();
    // A pair that is not shown leaves its measured line among those without partner.
    let of_shown: Vec<Option<usize>> = shown.iter().map(|&(_, at)| Some(at)).collect();
    let alone = listed.iter().zip(&of_listed).filter(|(_, partner)| partner.is_none());
    let of_prediction = |(line, _): (&&LineAnswer, &Option<usize>)| UnmatchedLineAnswer {
        label: line.label.clone(),
        order: of_shaft(line),
        frequency_hz: line.frequency_hz,
        amplitude: line.amplitude,
    };
    let of_record = |line: MeasuredLine| UnmatchedLineAnswer {
        label: String::new(),
        order: line.frequency / speeds[1],
        frequency_hz: line.frequency,
        amplitude: line.amplitude,
    };
    let unmatched = UnmatchedLinesAnswer {
        predicted: alone.map(of_prediction).collect(),
        measured: without(&left, &of_shown).into_iter().map(of_record).take(MOST_LISTED).collect(),
    };
    (lines, unmatched)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    use raceway_core::measured::record::Turning;
    use raceway_core::physics::samples::Samples;
    use raceway_core::simulation::input::settings::ENVELOPE;
    use raceway_core::simulation::recording::sampling::RATE;
    use serde_json::json;

    use super::*;
    use crate::contract::job::measurement::MeasurementRequest;
    use crate::contract::json::uploads::Uploads;

    const CHANNEL: &str = "spindle.y.acceleration";
    const HASH: &str = "0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a";

    /// A modulated carrier and two tones, at the orders of a shaft of 50 Hz.
    fn signal(rate: f64, duration: f64, stretch: f64) -> Vec<f64> {
        let at = |time: f64| {
            let turn = TAU * 50.0 * stretch * time;
            (3.585 * turn).sin()
                + 0.3 * (turn + 1.0).sin()
                + 0.5 * (16.0 * turn).sin()
                + 2.0 * (1.0 + 0.5 * (5.415 * turn).cos()) * (100.0 * turn).cos()
        };
        (0..(duration * rate).round() as usize).map(|k| at(k as f64 / rate)).collect()
    }

    fn measurement(rate: f64, values: Vec<f64>, more: &serde_json::Value) -> Measurement {
        let uploads = Uploads::new(BTreeMap::from([(HASH.to_owned(), Arc::new(Samples::new(rate, values).unwrap()))]));
        let mut request = json!({ "series": HASH, "unit": "m/s2" });
        request.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        MeasurementRequest::read(request.to_string().as_bytes()).unwrap().with(&uploads).unwrap()
    }

    /// The prediction: 1 s of the signal at 3000 r/min.
    fn prediction() -> Prediction {
        prediction_of(&signal(RATE, 1.0, 1.0))
    }

    fn prediction_of(values: &[f64]) -> Prediction {
        let record = Record { values, rate: RATE, turning: Turning::Even(50.0) };
        let spectra = record.spectra(&Division::of(1.0, 1, Some(ENVELOPE)), &|| false).unwrap();
        let lines = |spectrum: &Spectrum| {
            let line = |line: MeasuredLine| LineAnswer {
                channel: CHANNEL.to_owned(),
                frequency_hz: line.frequency,
                amplitude: line.amplitude,
                label: format!("{:.3}", line.frequency / 50.0),
                deviation_hz: 0.0,
            };
            lines_of(spectrum, BAND).into_iter().take(20).map(line).collect::<Vec<_>>()
        };
        let head = (CHANNEL.to_owned(), "m/s²".to_owned());
        Prediction {
            spectrum: SpectrumAnswer::of_steps(head, SpectrumKind::Amplitude, &spectra.amplitude, 0.0),
            envelope: Some(ENVELOPE),
            speed_hz: 50.0,
            lines: lines(&spectra.amplitude),
            envelope_lines: lines(&spectra.envelope.unwrap()),
            level_error_db: Some(0.01),
            level_scatter_db: None,
            is_resolved: true,
        }
    }

    fn compared(rate: f64, values: Vec<f64>, more: &serde_json::Value) -> MeasuredAnswer {
        MeasuredAnswer::of(&measurement(rate, values, more), &prediction(), &|| false).unwrap().unwrap()
    }

    /// Largest distance of the ratios of levels, then of lines, from a ratio [dB], and of the order differences from a difference [%].
    fn off(answer: &MeasuredAnswer, ratio_db: f64, difference: f64) -> [f64; 3] {
        let envelope = answer.envelope.as_ref().map(|envelope| envelope.lines.as_slice()).unwrap_or_default();
        let lines = || answer.lines.iter().chain(envelope);
        let distance = |ratio: Option<f64>| (ratio.unwrap() - ratio_db).abs();
        [
            answer.levels.iter().map(|level| distance(level.level_ratio_db)).fold(0.0, f64::max),
            lines().map(|line| distance(line.level_ratio_db)).fold(0.0, f64::max),
            lines().map(|line| (line.order_difference_percent - difference).abs()).fold(0.0, f64::max),
        ]
    }

    /// Two spectra whose amplitudes are rounded to four digits.
    const ROUNDING_DB: f64 = 0.009;

    #[test]
    fn the_predicted_signal_differs_by_nothing() {
        let answer = compared(RATE, signal(RATE, 1.0, 1.0), &json!({ "speed_rpm": 3000 }));
        let [levels, lines, difference] = off(&answer, 0.0, 0.0);
        assert!(levels < 1e-6 && lines < 1e-6 && difference < 1e-6, "{levels} {lines} {difference} {answer:?}");
        assert_eq!(answer.levels.len(), 2 + 2 * 3);
        assert!(answer.lines.len() >= 5 && answer.unmatched.predicted.is_empty(), "{answer:?}");
        assert!(answer.envelope.is_some_and(|envelope| !envelope.lines.is_empty()));
        assert_eq!((answer.notes.len(), answer.gain), (1, None));
    }

    #[test]
    fn twice_the_amplitude_is_6_db() {
        let twice = || signal(RATE, 1.0, 1.0).iter().map(|value| 2.0 * value).collect::<Vec<_>>();
        let answer = compared(RATE, twice(), &json!({ "speed_rpm": 3000 }));
        let [levels, lines, difference] = off(&answer, 6.0206, 0.0);
        assert!(levels < ROUNDING_DB && lines < 1e-4 && difference < 1e-6, "{levels} {lines} {difference}");
        let answer = compared(RATE, twice(), &json!({ "speed_rpm": 3000, "gain": 0.5 }));
        assert!(off(&answer, 0.0, 0.0)[0] < 1e-3);
        assert!((answer.gain.unwrap().db + 6.0206).abs() < 1e-4);
        let in_g = signal(RATE, 1.0, 1.0).iter().map(|value| value / 9.80665).collect();
        let answer = compared(RATE, in_g, &json!({ "speed_rpm": 3000, "unit": "g" }));
        assert!(off(&answer, 0.0, 0.0)[0] < 1e-3);
    }

    /// A line 60 dB below the strongest is not listed among the predicted ones; a measured line there is predicted all the same.
    #[test]
    fn weak_predicted_lines_are_known() {
        let own = signal(RATE, 1.0, 1.0);
        let strong = |k: usize| 5e3 * (TAU * 50.0 * 40.0 * k as f64 / RATE).sin();
        let predicted: Vec<f64> = own.iter().enumerate().map(|(k, value)| value + strong(k)).collect();
        let prediction = prediction_of(&predicted);
        assert_eq!(prediction.lines.len(), 1);
        let measured = measurement(RATE, own, &json!({ "speed_rpm": 3000 }));
        let answer = MeasuredAnswer::of(&measured, &prediction, &|| false).unwrap().unwrap();
        let found: Vec<f64> = answer.lines.iter().map(|line| line.predicted_order.round()).collect();
        assert!([1.0, 4.0, 16.0, 100.0].iter().all(|order| found.contains(order)), "{answer:?}");
        assert!(answer.unmatched.measured.is_empty() && answer.unmatched.predicted.len() == 1, "{answer:?}");
    }

    /// Another rate changes levels by less than 0.01 dB.
    #[test]
    fn another_rate_changes_nothing() {
        let answer = compared(64_000.0, signal(64_000.0, 1.0, 1.0), &json!({ "speed_rpm": 3000 }));
        let [levels, lines, difference] = off(&answer, 0.0, 0.0);
        assert!(levels < 0.01 && lines < 0.01 && difference < 1e-3, "{levels} {lines} {difference}");
        assert_eq!(answer.to_hz, 20_000.0);
        let answer = compared(20_480.0, signal(20_480.0, 1.0, 1.0), &json!({ "speed_rpm": 3000 }));
        assert_eq!((answer.to_hz, answer.envelope), (8192.0, None));
        assert_eq!(answer.notes.len(), 3, "neither the envelope nor the highest band: {:?}", answer.notes);
        assert_eq!(answer.levels.len(), 2 + 2 * 2);
    }

    /// Time is stretched by 1 %: with a tachometer the orders are the same.
    #[test]
    fn a_stretched_time_is_seen_without_tachometer_only() {
        let values = || signal(RATE, 1.1, 1.01);
        let answer = compared(RATE, values(), &json!({ "speed_rpm": 3000 }));
        let [.., difference] = off(&answer, 0.0, 1.0);
        assert!(difference < 0.01 && answer.lines.len() >= 5, "{difference} {answer:?}");
        let pulses: Vec<f64> = (0..=55).map(|k| f64::from(k) / 50.5).collect();
        let answer = compared(RATE, values(), &json!({ "tachometer": { "pulse_times_s": pulses } }));
        let [.., difference] = off(&answer, 0.0, 0.0);
        assert!(difference < 0.01 && answer.lines.len() >= 5, "{difference} {answer:?}");
        assert!((answer.measured.speed_rpm - 3030.0).abs() < 1e-6);
    }

    #[test]
    fn records_that_do_not_fit_are_refused() {
        let refused = |values: Vec<f64>, more: &serde_json::Value| {
            MeasuredAnswer::of(&measurement(RATE, values, more), &prediction(), &|| false).unwrap_err().to_string()
        };
        let short = refused(signal(RATE, 0.5, 1.0), &json!({ "speed_rpm": 3000 }));
        assert!(short.contains("/series: 0.5 s are analysed") && short.contains("windows of 1 s"), "{short}");
        let other = refused(signal(RATE, 1.0, 1.0), &json!({ "speed_rpm": 3000, "unit": "um/s" }));
        assert!(other.contains("/unit: a unit of velocity, but the channel is `spindle.y.acceleration`"), "{other}");
        let slow = measurement(100.0, signal(100.0, 5.0, 1.0), &json!({ "speed_rpm": 3000 }));
        assert!(MeasuredAnswer::of(&slow, &prediction(), &|| false).is_ok());
        let stopped = measurement(RATE, signal(RATE, 1.0, 1.0), &json!({ "speed_rpm": 3000 }));
        assert_eq!(MeasuredAnswer::of(&stopped, &prediction(), &|| true).unwrap(), None);
    }
}
