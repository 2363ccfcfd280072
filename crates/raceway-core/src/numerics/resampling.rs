//! Values of a sampled signal between its samples, behind a low-pass filter.

use std::f64::consts::TAU;

use super::special::{kaiser, kaiser_beta, kaiser_length, sinc};

/// Attenuation of what would fold into the passed band [dB]: the promised 80 with a margin.
const ATTENUATION: f64 = 86.0;
/// Entries of the filter's table between two zeros of its sinc; the linear interpolation between them is exact to 10⁻⁵ of the peak.
const ENTRIES: usize = 512;
/// End of the pass band over the kept rate; the stop band begins at 1 − `PASS`.
pub const PASS: f64 = 0.4;

/// A polyphase filter for any ratio of rates and for places at any distance. It passes frequencies up to 0.4 of the kept rate. What would fold
/// into this band is 80 dB lower. The kept rate is the lower one of the signal and of the output.
///
/// The filter is symmetric, so that no phase is bent. Beyond its ends the signal counts as unknown: there the filter uses the samples that
/// exist.
#[derive(Debug, Clone)]
pub(crate) struct Resampler<'a> {
    values: &'a [f64],
    /// Kept rate over the rate of the signal [-], at most 1.
    share: f64,
    /// Half the length of the filter in periods of the kept rate.
    half: f64,
    /// Filter from its middle to its end, and a zero.
    filter: Vec<f64>,
}

impl<'a> Resampler<'a> {
    /// For output at `ratio` times the rate of the signal.
    pub fn new(values: &'a [f64], ratio: f64) -> Self {
        let half = 0.5 * kaiser_length(ATTENUATION, TAU * (1.0 - 2.0 * PASS));
        let beta = kaiser_beta(ATTENUATION);
        let entries = (half * ENTRIES as f64) as usize;
        let entry = |k: usize| kaiser(beta, k as f64 / entries as f64) * sinc(k as f64 / ENTRIES as f64);
        let filter = (0..=entries).map(entry).chain([0.0]).collect();
        Self { values, share: ratio.min(1.0), half, filter }
    }

    /// Value at a place, counted in samples from the first one; 0 without samples near it.
    pub fn at(&self, place: f64) -> f64 {
        let reach = self.half / self.share;
        let first = (place - reach).ceil().max(0.0) as usize;
        let end = ((place + reach).floor() + 1.0).max(0.0) as usize;
        let around = self.values.get(first..end.min(self.values.len())).unwrap_or_default();
        let (mut sum, mut weights) = (0.0, 0.0);
        for (sample, value) in (first..).zip(around) {
            let weight = self.weight((sample as f64 - place).abs() * self.share);
            sum += weight * value;
            weights += weight;
        }
        // The weights of a cut filter do not sum to that of the whole one; a constant stays itself.
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// The filter at a distance from its middle, in periods of the kept rate.
    fn weight(&self, distance: f64) -> f64 {
        let entry = distance * ENTRIES as f64;
        let (below, rest) = (entry as usize, entry.fract());
        match self.filter.get(below..below + 2) {
            Some([low, high]) => low + rest * (high - low),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 48_828.0;

    fn tone(frequency: f64, rate: f64) -> impl Fn(usize) -> f64 {
        move |k| (TAU * frequency * k as f64 / rate + 0.3).sin()
    }

    /// Largest deviation of a resampled tone from itself at another rate, away from the ends.
    fn deviation(frequency: f64, rate: f64) -> f64 {
        let values: Vec<f64> = (0..4000).map(tone(frequency, RATE)).collect();
        let resampler = Resampler::new(&values, rate / RATE);
        let expected = tone(frequency, rate);
        let places = 200..(3800.0 * rate / RATE) as usize;
        places.map(|k| (resampler.at(k as f64 * RATE / rate) - expected(k)).abs()).fold(0.0, f64::max)
    }

    /// Ripple of the pass band and the image beyond the stop band are 10⁻⁴ each.
    #[test]
    fn tones_of_the_pass_band_are_kept() {
        for (frequency, rate) in [(5000.0, 102_400.0), (19_500.0, 102_400.0), (4000.0, 10_000.0), (137.0, 50_000.0)] {
            assert!(deviation(frequency, rate) < 2e-4, "{frequency} Hz at {rate} Hz: {}", deviation(frequency, rate));
        }
    }

    /// 6.1 kHz would fold to 3.9 kHz at 10 kHz.
    #[test]
    fn tones_that_would_fold_are_stopped() {
        for frequency in [6100.0, 9000.0, 16_000.0, 24_000.0] {
            let values: Vec<f64> = (0..4000).map(tone(frequency, RATE)).collect();
            let resampler = Resampler::new(&values, 10_000.0 / RATE);
            let largest = (100..700).map(|k| resampler.at(f64::from(k) * RATE / 1e4).abs()).fold(0.0, f64::max);
            assert!(largest < 1e-4, "{frequency} Hz: {largest}");
        }
    }

    #[test]
    fn samples_are_kept_and_constants_reach_to_the_ends() {
        let values: Vec<f64> = (0..100).map(|k| f64::from(k * k % 17)).collect();
        let resampler = Resampler::new(&values, 1.0);
        assert!(values.iter().enumerate().all(|(k, value)| (resampler.at(k as f64) - value).abs() < 1e-12));
        let constant = [2.0; 20];
        let resampler = Resampler::new(&constant, 0.5);
        assert!([0.0, 0.3, 10.1, 19.0].iter().all(|place| (resampler.at(*place) - 2.0).abs() < 1e-12));
        assert_eq!(Resampler::new(&[], 1.0).at(3.0), 0.0);
        assert_eq!(Resampler::new(&constant, 1.0).at(1e9), 0.0);
    }
}
