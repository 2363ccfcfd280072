//! Vibration in frequency bands, from the Hann spectra of an acceleration.

use std::f64::consts::TAU;

use crate::numerics::spectrum::{Bins, HANN_BANDWIDTH};
use crate::simulation::recording::sampling::BAND;

/// Band of the velocity by which machines are judged [Hz] (ISO 20816-1).
pub const SEVERITY_BAND: (f64, f64) = (10.0, 1000.0);
/// Lowest bin that counts: lower ones hold the mean and drift, which the division by the frequency would raise.
pub const LOWEST_BIN: f64 = 2.0;

/// Shortest window whose spectrum resolves a frequency [s].
pub fn shortest_window(frequency: f64) -> f64 {
    LOWEST_BIN / frequency
}

/// Vibration of a channel in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Edges [Hz]; the upper one belongs to the next band.
    pub from: f64,
    pub to: f64,
    /// Root mean square [m/s].
    pub velocity: f64,
    /// Root mean square [m/s²].
    pub acceleration: f64,
}

/// Velocity, bands and power of an acceleration, from its Hann spectra.
#[derive(Debug, Clone, PartialEq)]
pub struct BandMetrics {
    /// Frequency between two bins of the spectra [Hz].
    pub resolution: f64,
    /// The bands that the windows resolve.
    pub bands: Vec<Band>,
    /// Root mean square of the velocity from 10 to 1000 Hz [m/s]; `None` where the windows do not resolve 10 Hz.
    pub severity: Option<f64>,
    /// Mean square of the spectra up to 20 kHz over that of the signal [-]: 1 of steady motion. `None` without motion.
    pub parseval_ratio: Option<f64>,
}

/// Mean squares of acceleration and velocity by band.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Bands {
    /// Frequency between two bins [Hz].
    resolution: f64,
    /// Rising [Hz].
    edges: Vec<f64>,
    squares: Vec<[f64; 2]>,
    /// Sum over the windows of the velocity's mean square in the band of severity [m²/s²].
    severity: f64,
    /// Sum over the windows of the acceleration's mean square up to 20 kHz [m²/s⁴].
    total: f64,
    windows: usize,
}

impl Bands {
    /// Bands between rising edges [Hz] of one window of an acceleration. Velocities are accelerations over the angular frequency, bin by bin
    /// under the Hann window, so that no leakage of strong lines enters low bands.
    pub fn of(bins: &Bins<'_>, edges: &[f64]) -> Self {
        let resolution = bins.resolution();
        let squares = vec![[0.0; 2]; edges.len().saturating_sub(1)];
        let mut bands = Self { resolution, edges: edges.to_vec(), squares, severity: 0.0, total: 0.0, windows: 1 };
        let mut next = 0;
        for bin in LOWEST_BIN as usize..bins.interior() {
            let frequency = bin as f64 * resolution;
            if frequency > BAND {
                break;
            }
            let acceleration = 0.5 * bins.hann_square(bin) / HANN_BANDWIDTH;
            let velocity = acceleration / (TAU * frequency).powi(2);
            bands.total += acceleration;
            if (SEVERITY_BAND.0..SEVERITY_BAND.1).contains(&frequency) {
                bands.severity += velocity;
            }
            while edges.get(next).is_some_and(|edge| frequency >= *edge) {
                next += 1;
            }
            if let Some(squares) = next.checked_sub(1).and_then(|band| bands.squares.get_mut(band)) {
                squares[0] += acceleration;
                squares[1] += velocity;
            }
        }
        bands
    }

    /// Adds a further window of the same length.
    pub fn join(&mut self, other: &Self) {
        for (own, other) in self.squares.iter_mut().flatten().zip(other.squares.iter().flatten()) {
            *own += other;
        }
        self.severity += other.severity;
        self.total += other.total;
        self.windows += other.windows;
    }

    /// Velocity, bands and power of a signal with a root mean square [m/s²].
    pub fn metrics(&self, rms: f64) -> BandMetrics {
        let mean = |squares: f64| squares / self.windows as f64;
        let is_resolved = |from: f64| self.windows > 0 && from >= LOWEST_BIN * self.resolution;
        let edges = self.edges.windows(2).zip(&self.squares);
        let resolved = edges.filter(|(edges, _)| is_resolved(edges[0]));
        BandMetrics {
            resolution: self.resolution,
            bands: resolved
                .map(|(edges, [acceleration, velocity])| Band {
                    from: edges[0],
                    to: edges[1],
                    velocity: mean(*velocity).sqrt(),
                    acceleration: mean(*acceleration).sqrt(),
                })
                .collect(),
            severity: is_resolved(SEVERITY_BAND.0).then(|| mean(self.severity).sqrt()),
            parseval_ratio: (self.windows > 0 && rms > 0.0).then(|| mean(self.total) / (rms * rms)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::SplitMix64;
    use crate::numerics::spectrum::{filtered, transform};
    use crate::numerics::statistics::rms;
    use crate::simulation::input::settings::BAND_EDGES;

    const RATE: f64 = 102_400.0;

    fn metrics(signal: &[f64], edges: &[f64]) -> BandMetrics {
        let mut bands = Bands::default();
        let left = filtered(signal, RATE, BAND, |bins| bands = Bands::of(bins, edges));
        bands.metrics(rms(&left))
    }

    fn tones(tones: &[(f64, f64)], duration: f64) -> Vec<f64> {
        let at = |i: usize| tones.iter().map(|(f, a)| a * (TAU * f * i as f64 / RATE).sin()).sum();
        (0..(duration * RATE) as usize).map(at).collect()
    }

    fn of_tones(of: &[(f64, f64)], duration: f64) -> Vec<Band> {
        metrics(&tones(of, duration), &BAND_EDGES).bands
    }

    /// Three tones of 1 m/s² at 100, 800 and 5000 Hz.
    #[test]
    fn each_tone_is_in_its_band() {
        let found = of_tones(&[(100.0, 1.0), (800.0, 1.0), (5000.0, 1.0)], 1.0);
        for (band, velocity) in found.iter().zip([1125.395e-6, 140.674e-6, 22.508e-6]) {
            assert!((band.velocity / velocity - 1.0).abs() < 1e-4, "{band:?}");
            assert!((band.acceleration - 0.5_f64.sqrt()).abs() < 1e-6, "{band:?}");
        }
        assert_eq!(
            found.iter().map(|band| (band.from, band.to)).collect::<Vec<_>>(),
            [(50.0, 300.0), (300.0, 1800.0), (1800.0, 1e4)]
        );
    }

    /// A tone of 10 m/s² between two bins does not leak into the low bands.
    #[test]
    fn a_strong_tone_does_not_leak() {
        let found = of_tones(&[(5000.5, 10.0)], 1.0);
        assert!((found[2].velocity / 225.057e-6 - 1.0).abs() < 1e-4, "{found:?}");
        assert!(found[0].velocity < 1e-9 && found[1].velocity < 1e-9, "{found:?}");
    }

    /// Without a window, whose noise bandwidth is one bin, the same tone fills the low bands: the Hann window is needed.
    #[test]
    fn a_strong_tone_leaks_without_a_window() {
        let bins = transform(&tones(&[(5000.5, 10.0)], 1.0));
        let velocity = |from: usize, to: usize| {
            let square = |bin: usize| 0.5 * (2.0 / RATE).powi(2) * bins[bin].norm_sqr() / (TAU * bin as f64).powi(2);
            1e6 * (from..to).map(square).sum::<f64>().sqrt()
        };
        let [low, middle] = [velocity(50, 300), velocity(300, 1800)];
        assert!((low - 18.5).abs() < 0.05 && (middle - 7.7).abs() < 0.05, "{low} and {middle} µm/s");
    }

    #[test]
    fn a_short_record_has_no_low_band() {
        let edges = |duration| of_tones(&[(800.0, 1.0)], duration).iter().map(|band| band.from).collect::<Vec<_>>();
        assert_eq!(edges(0.1), [50.0, 300.0, 1800.0]);
        assert_eq!(edges(0.02), [300.0, 1800.0]);
        assert!(Bands::default().metrics(1.0).bands.is_empty());
    }

    /// 1 m/s² at 100 and 800 Hz lie in the band of severity, 5000 Hz does not; the spectra hold the power of all three.
    #[test]
    fn severity_is_the_velocity_up_to_1_khz() {
        let found = metrics(&tones(&[(100.0, 1.0), (800.0, 1.0), (5000.0, 1.0)], 1.0), &BAND_EDGES);
        // The window spreads 100 Hz over three bins, whose mean square over the frequency is larger.
        assert!((found.severity.unwrap() / 1134.154e-6 - 1.0).abs() < 1e-4, "{found:?}");
        assert!((found.parseval_ratio.unwrap() - 1.0).abs() < 1e-6, "{found:?}");
        // 1 g at 159.155 Hz.
        let found = metrics(&tones(&[(159.155, 9.80665)], 1.0), &BAND_EDGES);
        assert!((found.severity.unwrap() / 6.9343e-3 - 1.0).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn severity_needs_two_tenths_of_a_second() {
        let severity = |duration| metrics(&tones(&[(800.0, 1.0)], duration), &BAND_EDGES).severity;
        assert!(severity(0.2).is_some() && severity(0.19).is_none());
        assert!((shortest_window(SEVERITY_BAND.0) - 0.2).abs() < 1e-12);
    }

    /// Noise of 1 m/s² up to half of the sampling rate has the same power in bands of the same width, 1.953·10⁻⁵ (m/s²)²/Hz.
    #[test]
    fn bands_of_noise_have_their_width() {
        let mut random = SplitMix64::new(7);
        let mut uniform = || random.uniform() - 0.5;
        let signal: Vec<f64> = (0..RATE as usize).map(|_| 12_f64.sqrt() * uniform()).collect();
        let found = metrics(&signal, &[1000.0, 6000.0, 11_000.0]);
        for band in &found.bands {
            let density = band.acceleration.powi(2) / 5000.0;
            assert!((density / 1.953e-5 - 1.0).abs() < 0.05, "{density}");
        }
        assert!((found.parseval_ratio.unwrap() - 1.0).abs() < 0.02, "{found:?}");
    }
}
