//! Spectra and time series as JSON.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::numbers::rounded;
use raceway_core::numerics::spectrum::{EnvelopeKind, HANN_BANDWIDTH, Spectrum};
use raceway_core::simulation::input::channel::Channel;
use raceway_core::simulation::result::metrics::SolverReport;
use raceway_core::simulation::result::series::Series;

/// Highest frequency of stored spectra [Hz]: levels cover 20 kHz.
const MAX_FREQUENCY: f64 = 25_600.0;

/// A one-sided spectrum, by default of amplitudes: a sine of amplitude 1 reads 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SpectrumAnswer {
    /// The requested channel.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Amplitude or envelope spectrum.
    pub kind: SpectrumKind,
    /// Kind of the values in `amplitude`.
    #[serde(default)]
    #[schema(required = true)]
    pub scaling: SpectrumScaling,
    /// Unit of `amplitude`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Window function.
    #[schema(example = "hann")]
    pub window: String,
    /// Noise bandwidth of the window [bins]: a mean square is the sum of amplitude²/2 over it.
    #[serde(default = "hann_bandwidth")]
    #[schema(required = true, example = 1.5)]
    pub window_noise_bandwidth_bins: f64,
    /// Number of time windows whose power is averaged; 1 for at most one second.
    #[schema(example = 1)]
    pub averages: usize,
    /// Frequency resolution [Hz].
    #[schema(minimum = 0)]
    pub resolution_hz: f64,
    /// Mean step of the integrator [s].
    #[schema(minimum = 0)]
    pub mean_step_s: f64,
    /// Frequency above which the integrator does not resolve an oscillation [Hz]: less than one step per radian.
    #[schema(minimum = 0)]
    pub damped_above_hz: f64,
    /// Frequencies in ascending order, up to 25.6 kHz [Hz].
    pub frequency_hz: Vec<f64>,
    /// Value at each frequency, in `unit`, with four digits.
    pub amplitude: Vec<f64>,
}

/// Noise bandwidth of spectra that were stored without it.
fn hann_bandwidth() -> f64 {
    HANN_BANDWIDTH
}

/// `amplitude`: spectrum of the signal. `envelope`: spectrum of its envelope after a band-pass filter, or of the square of this envelope
/// (`outputs.envelope`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpectrumKind {
    Amplitude,
    Envelope,
}

/// Kind of the values of a spectrum. `amplitude`: of a sine. `rms`: its root mean square. `psd`: power spectral density, amplitude² / (2 · noise
/// bandwidth · resolution), whose sum times the resolution is the mean square.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpectrumScaling {
    #[default]
    Amplitude,
    Rms,
    Psd,
}

/// Unit of an envelope's spectrum, of a signal in a unit.
pub fn unit_of_envelope(unit: &str, kind: EnvelopeKind) -> String {
    match kind {
        EnvelopeKind::Magnitude => unit.to_owned(),
        EnvelopeKind::Squared => format!("({unit})²"),
    }
}

impl SpectrumAnswer {
    /// Significant digits of an amplitude: rounding changes it by at most 0.004 dB.
    pub const DIGITS: i32 = 4;

    pub fn is_amplitude(&self) -> bool {
        self.kind == SpectrumKind::Amplitude
    }

    pub fn of(
        (channel, unit): (Channel, String),
        kind: SpectrumKind,
        spectrum: &Spectrum,
        solver: &SolverReport,
    ) -> Self {
        let mean_step = solver.statistics.advanced / solver.statistics.steps.max(1) as f64;
        Self::of_steps((channel.to_string(), unit), kind, spectrum, mean_step)
    }

    /// The spectrum of a run in steps of a mean length [s].
    pub fn of_steps(
        (channel, unit): (String, String),
        kind: SpectrumKind,
        spectrum: &Spectrum,
        mean_step: f64,
    ) -> Self {
        Self {
            channel,
            kind,
            unit,
            scaling: SpectrumScaling::Amplitude,
            window: spectrum.window.to_owned(),
            window_noise_bandwidth_bins: HANN_BANDWIDTH,
            averages: spectrum.averages,
            resolution_hz: spectrum.resolution,
            mean_step_s: mean_step,
            damped_above_hz: if mean_step > 0.0 { 0.5 / (std::f64::consts::PI * mean_step) } else { 0.0 },
            frequency_hz: Vec::new(),
            amplitude: spectrum
                .amplitude
                .iter()
                .take((MAX_FREQUENCY / spectrum.resolution) as usize + 1)
                .map(|amplitude| rounded(*amplitude, Self::DIGITS))
                .collect(),
        }
        .with_frequencies()
    }

    /// The spectrum with frequencies from its resolution.
    pub fn with_frequencies(mut self) -> Self {
        self.frequency_hz = (0..self.amplitude.len()).map(|bin| bin as f64 * self.resolution_hz).collect();
        self
    }

    /// The spectrum without its values.
    pub fn head(&self) -> Self {
        Self {
            channel: self.channel.clone(),
            unit: self.unit.clone(),
            window: self.window.clone(),
            frequency_hz: Vec::new(),
            amplitude: Vec::new(),
            ..*self
        }
    }

    /// The part up to this frequency [Hz].
    pub fn up_to(mut self, max_frequency_hz: f64) -> Self {
        let count = self.frequency_hz.partition_point(|&frequency| frequency <= max_frequency_hz);
        self.frequency_hz.truncate(count);
        self.amplitude.truncate(count);
        self
    }

    pub fn is_finite(&self) -> bool {
        self.resolution_hz.is_finite() && self.mean_step_s.is_finite() && self.amplitude.iter().all(|a| a.is_finite())
    }
}

/// A signal over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SeriesAnswer {
    /// The requested channel.
    #[schema(example = "cage.y.displacement")]
    pub channel: String,
    /// Unit of `value`.
    #[schema(example = "µm")]
    pub unit: String,
    /// Time between recorded values [s], also where the answer leaves some out; absent in results of early versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, example = 1.953125e-5)]
    pub dt_s: Option<f64>,
    /// Time since the start of the run, settling included [s].
    pub time_s: Vec<f64>,
    /// Value at each time, in `unit`.
    pub value: Vec<f64>,
}

impl SeriesAnswer {
    pub fn of(series: &Series) -> Self {
        Self::new(&SeriesHead::of(series), series.values.clone())
    }

    pub fn new(head: &SeriesHead, value: Vec<f64>) -> Self {
        let time_s = (0..value.len()).map(|index| head.time(index)).collect();
        Self { channel: head.channel.clone(), unit: head.unit.clone(), dt_s: Some(head.step_s), time_s, value }
    }
}

/// A series without its values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SeriesHead {
    pub channel: String,
    pub unit: String,
    /// Time of the first value since the start of the run [s].
    pub start_s: f64,
    /// Time between values [s].
    pub step_s: f64,
    /// Number of values.
    pub length: usize,
}

impl SeriesHead {
    pub fn of(series: &Series) -> Self {
        Self {
            channel: series.channel.to_string(),
            unit: series.channel.unit().to_owned(),
            start_s: series.start,
            step_s: series.step,
            length: series.length,
        }
    }

    /// Time of a value since the start of the run [s].
    pub fn time(&self, place: usize) -> f64 {
        self.start_s + place as f64 * self.step_s
    }
}

/// Selection of at most `max_points` values of a series that are passed one after another: the least and the greatest of each of half
/// as many intervals, so that peaks are kept.
#[derive(Debug, Clone)]
pub struct Thinning {
    count: usize,
    intervals: usize,
    max_points: usize,
    /// Number of the current interval.
    interval: usize,
    /// Place of the next value.
    next: usize,
    /// Places and values of the least and the greatest value of the current interval.
    extremes: Option<[(usize, f64); 2]>,
    /// Number of selected values.
    selected: usize,
}

impl Thinning {
    /// Selection among `count` values; all of them if they are no more than `max_points`.
    pub fn new(count: usize, max_points: usize) -> Self {
        let intervals = if count > max_points { (max_points / 2).max(1) } else { count };
        Self { count, intervals, max_points, interval: 0, next: 0, extremes: None, selected: 0 }
    }

    /// Passes the next value; `select` receives the selected places and values in their order.
    pub fn pass(&mut self, value: f64, mut select: impl FnMut(usize, f64)) {
        let this = (self.next, value);
        let [least, greatest] = self.extremes.get_or_insert([this; 2]);
        if value.total_cmp(&least.1).is_lt() {
            *least = this;
        }
        if value.total_cmp(&greatest.1).is_ge() {
            *greatest = this;
        }
        self.next += 1;
        if (self.next + 1) * self.intervals <= (self.interval + 1) * self.count {
            return;
        }
        self.interval += 1;
        let Some([least, greatest]) = self.extremes.take() else { return };
        let [first, last] = if least.0 < greatest.0 { [least, greatest] } else { [greatest, least] };
        for (place, value) in [Some(first), Some(last).filter(|last| last.0 != first.0)].into_iter().flatten() {
            if self.selected < self.max_points {
                self.selected += 1;
                select(place, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thinned(values: &[f64], max_points: usize) -> Vec<(usize, f64)> {
        let (mut thinning, mut selected) = (Thinning::new(values.len(), max_points), Vec::new());
        values.iter().for_each(|value| thinning.pass(*value, |place, value| selected.push((place, value))));
        selected
    }

    #[test]
    fn thinning_keeps_the_peak() {
        let mut values = vec![0.0; 10_000];
        values[4321] = 7.0;
        values[4322] = -5.0;
        let thin = thinned(&values, 100);
        assert!(thin.len() <= 100 && thin.is_sorted_by(|one, next| one.0 < next.0));
        assert!(thin.contains(&(4321, 7.0)) && thin.contains(&(4322, -5.0)));
        assert_eq!(thinned(&values, 1).len(), 1);
        assert_eq!(thinned(&values[..7], 7).len(), 7);
        assert_eq!(thinned(&[], 7), []);
    }

    /// By the definition, interval by interval.
    #[test]
    fn each_interval_gives_its_least_and_its_greatest_value() {
        let values: Vec<f64> = (0..1000).map(|k| f64::from(k * 7919 % 1013)).collect();
        for max_points in [2, 3, 10, 333, 998, 999] {
            let intervals = max_points / 2;
            let mut expected = Vec::new();
            for interval in 0..intervals {
                let range = interval * 1000 / intervals..(interval + 1) * 1000 / intervals;
                let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
                expected.extend([range.clone().min_by(by_value), range.max_by(by_value)].into_iter().flatten());
            }
            expected.sort_unstable();
            expected.dedup();
            let places: Vec<usize> = thinned(&values, max_points).into_iter().map(|(place, _)| place).collect();
            assert_eq!(places, expected, "{max_points}");
        }
    }
}
