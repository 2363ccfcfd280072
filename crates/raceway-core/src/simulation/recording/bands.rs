//! Vibration in frequency bands, from the Hann spectra of an acceleration.

use std::f64::consts::TAU;

use crate::numerics::spectrum::{Bins, HANN_BANDWIDTH};

/// Edges of the bands in which bearing vibration is stated as velocity [Hz] (ISO 15242-1).
pub const EDGES: [f64; 4] = [50.0, 300.0, 1800.0, 10_000.0];
/// Lowest bin that counts: lower ones hold the mean and drift, which the division by the frequency would raise.
const LOWEST_BIN: f64 = 2.0;

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

/// Mean squares of acceleration and velocity by band.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Bands {
    /// Frequency between two bins [Hz].
    resolution: f64,
    squares: [[f64; 2]; EDGES.len() - 1],
    windows: usize,
}

impl Bands {
    /// Bands of one window of an acceleration. Velocities are accelerations over the angular frequency, bin by bin under the Hann window, so
    /// that no leakage of strong lines enters low bands.
    pub fn of(bins: &Bins<'_>) -> Self {
        let resolution = bins.resolution();
        let mut edge = 0;
        let mut bands = Self { resolution, squares: Default::default(), windows: 1 };
        let first = (EDGES[0] / resolution).ceil().max(LOWEST_BIN) as usize;
        for bin in first..bins.interior() {
            let frequency = bin as f64 * resolution;
            while edge + 1 < EDGES.len() && frequency >= EDGES[edge + 1] {
                edge += 1;
            }
            let Some([acceleration, velocity]) = bands.squares.get_mut(edge) else { break };
            let square = 0.5 * bins.hann_square(bin) / HANN_BANDWIDTH;
            *acceleration += square;
            *velocity += square / (TAU * frequency).powi(2);
        }
        bands
    }

    /// Adds a further window of the same length.
    pub fn join(&mut self, other: &Self) {
        for (own, other) in self.squares.iter_mut().flatten().zip(other.squares.iter().flatten()) {
            *own += other;
        }
        self.windows += other.windows;
    }

    /// The bands that the length of the windows resolves.
    pub fn bands(&self) -> Vec<Band> {
        let rms = |squares: f64| (squares / self.windows as f64).sqrt();
        let edges = EDGES.windows(2).zip(&self.squares);
        let resolved = edges.filter(|(edges, _)| edges[0] >= LOWEST_BIN * self.resolution && self.windows > 0);
        resolved
            .map(|(edges, [acceleration, velocity])| Band {
                from: edges[0],
                to: edges[1],
                velocity: rms(*velocity),
                acceleration: rms(*acceleration),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::spectrum::filtered;

    const RATE: f64 = 102_400.0;

    fn of_tones(tones: &[(f64, f64)], duration: f64) -> Vec<Band> {
        let signal: Vec<f64> = (0..(duration * RATE) as usize)
            .map(|i| tones.iter().map(|(f, a)| a * (TAU * f * i as f64 / RATE).sin()).sum())
            .collect();
        let mut bands = Bands::default();
        filtered(&signal, RATE, 2e4, |bins| bands = Bands::of(bins));
        bands.bands()
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
        assert!(Bands::default().bands().is_empty());
    }
}
