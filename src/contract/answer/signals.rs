//! Spectra and time series as JSON.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::json::numbers::rounded;
use raceway_core::numerics::spectrum::Spectrum;
use raceway_core::simulation::input::channel::Channel;
use raceway_core::simulation::result::metrics::SolverReport;
use raceway_core::simulation::result::series::Series;

/// Highest frequency of stored spectra [Hz]: levels cover 20 kHz.
const MAX_FREQUENCY: f64 = 25_600.0;

/// A one-sided amplitude spectrum: a sine of amplitude 1 reads 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SpectrumAnswer {
    /// The requested channel.
    #[schema(example = "spindle.y.acceleration")]
    pub channel: String,
    /// Amplitude or envelope spectrum.
    pub kind: SpectrumKind,
    /// Unit of `amplitude`.
    #[schema(example = "m/s²")]
    pub unit: String,
    /// Window function.
    #[schema(example = "hann")]
    pub window: String,
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
    /// Amplitude at each frequency, in `unit`, with four digits.
    pub amplitude: Vec<f64>,
}

/// `amplitude`: spectrum of the signal. `envelope`: spectrum of its envelope after a band-pass filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpectrumKind {
    Amplitude,
    Envelope,
}

impl SpectrumAnswer {
    /// Significant digits of an amplitude: rounding changes it by at most 0.004 dB.
    pub const DIGITS: i32 = 4;

    pub fn is_amplitude(&self) -> bool {
        self.kind == SpectrumKind::Amplitude
    }

    pub fn of(channel: Channel, kind: SpectrumKind, spectrum: &Spectrum, solver: &SolverReport) -> Self {
        let mean_step = solver.statistics.advanced / solver.statistics.steps.max(1) as f64;
        Self {
            channel: channel.to_string(),
            kind,
            unit: channel.unit().to_owned(),
            window: spectrum.window.to_owned(),
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
    /// Time since the start of the run, settling included [s].
    pub time_s: Vec<f64>,
    /// Value at each time, in `unit`.
    pub value: Vec<f64>,
}

impl SeriesAnswer {
    pub fn of(series: &Series) -> Self {
        Self {
            channel: series.channel.to_string(),
            unit: series.channel.unit().to_owned(),
            time_s: (0..series.values.len()).map(|index| series.start + index as f64 * series.step).collect(),
            value: series.values.clone(),
        }
    }

    /// The part from one time to another [s], both included.
    pub fn between(mut self, from_s: f64, to_s: f64) -> Self {
        let end = self.time_s.partition_point(|&time| time <= to_s);
        let start = self.time_s.partition_point(|&time| time < from_s).min(end);
        self.time_s = self.time_s[start..end].to_vec();
        self.value = self.value[start..end].to_vec();
        self
    }

    /// At most `max_points` points: minimum and maximum of each interval, so that peaks are kept.
    pub fn thinned(self, max_points: usize) -> Self {
        let count = self.value.len();
        if count <= max_points {
            return self;
        }
        let intervals = (max_points / 2).max(1);
        let mut kept = Vec::with_capacity(2 * intervals);
        for interval in 0..intervals {
            let range = interval * count / intervals..(interval + 1) * count / intervals;
            let by_value = |a: &usize, b: &usize| self.value[*a].total_cmp(&self.value[*b]);
            let extremes = (range.clone().min_by(by_value), range.max_by(by_value));
            if let (Some(least), Some(greatest)) = extremes {
                kept.push(least.min(greatest));
                if least != greatest {
                    kept.push(least.max(greatest));
                }
            }
        }
        kept.truncate(max_points);
        let pick = |values: &[f64]| kept.iter().map(|&index| values[index]).collect();
        Self { time_s: pick(&self.time_s), value: pick(&self.value), channel: self.channel, unit: self.unit }
    }

    pub fn is_finite(&self) -> bool {
        self.value.iter().all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_peak() {
        let mut value = vec![0.0; 10_000];
        value[4321] = 7.0;
        value[4322] = -5.0;
        let time_s = (0..10_000).map(f64::from).collect();
        let series = SeriesAnswer { channel: String::new(), unit: String::new(), time_s, value };
        let thin = series.clone().thinned(100);
        assert!(thin.value.len() <= 100 && thin.time_s.is_sorted());
        assert!(thin.value.contains(&7.0) && thin.value.contains(&-5.0));
        assert_eq!(series.clone().thinned(1).value.len(), 1);
        assert_eq!(series.between(10.0, 12.0).time_s, [10.0, 11.0, 12.0]);
    }
}
