//! Vibration in frequency bands, from a Hann spectrum of an acceleration.

use std::f64::consts::TAU;

use crate::numerics::spectrum::Spectrum;

/// Edges of the bands in which bearing vibration is stated as velocity [Hz] (ISO 15242-1).
pub const EDGES: [f64; 4] = [50.0, 300.0, 1800.0, 10_000.0];
/// Lowest frequency of a bin that counts [Hz]: division by the frequency raises drift below it.
const LOWEST: f64 = 10.0;
/// Bins at the start of a Hann spectrum that hold its mean and drift.
const DRIFT_BINS: f64 = 2.0;
/// Noise bandwidth of the Hann window in bins: the sum of squares of a line exceeds its square by this factor.
const NOISE_BANDWIDTH: f64 = 1.5;

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

/// The bands of a spectrum of an acceleration [m/s²]. A band that the resolution does not reach is missing.
pub fn bands(spectrum: &Spectrum) -> Vec<Band> {
    let lowest = LOWEST.max(DRIFT_BINS * spectrum.resolution);
    let edges = EDGES.windows(2).map(|edges| (edges[0], edges[1])).filter(|(from, _)| *from >= lowest);
    edges.map(|(from, to)| band(spectrum, from, to)).collect()
}

/// Velocities are accelerations over the angular frequency, bin by bin, so that no leakage of strong lines enters low bands.
fn band(spectrum: &Spectrum, from: f64, to: f64) -> Band {
    let bins =
        spectrum.amplitude.iter().enumerate().map(|(bin, amplitude)| (bin as f64 * spectrum.resolution, amplitude));
    let inside = bins.filter(|(frequency, _)| (from..to).contains(frequency));
    let (mut acceleration, mut velocity) = (0.0, 0.0);
    for (frequency, amplitude) in inside {
        acceleration += amplitude * amplitude;
        velocity += (amplitude / (TAU * frequency)).powi(2);
    }
    let rms = |squares: f64| (squares / (2.0 * NOISE_BANDWIDTH)).sqrt();
    Band { from, to, velocity: rms(velocity), acceleration: rms(acceleration) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::spectrum::amplitude_spectrum;

    const RATE: f64 = 102_400.0;

    fn of_tones(tones: &[(f64, f64)], duration: f64) -> Vec<Band> {
        let signal: Vec<f64> = (0..(duration * RATE) as usize)
            .map(|i| tones.iter().map(|(f, a)| a * (TAU * f * i as f64 / RATE).sin()).sum())
            .collect();
        bands(&amplitude_spectrum(&signal, RATE))
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

    #[test]
    fn a_short_record_has_no_low_band() {
        let edges = |duration| of_tones(&[(800.0, 1.0)], duration).iter().map(|band| band.from).collect::<Vec<_>>();
        assert_eq!(edges(0.1), [50.0, 300.0, 1800.0]);
        assert_eq!(edges(0.02), [300.0, 1800.0]);
        assert!(bands(&amplitude_spectrum(&[], RATE)).iter().all(|band| band.acceleration == 0.0));
    }
}
