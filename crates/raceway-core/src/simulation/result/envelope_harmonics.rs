//! Amplitudes of an envelope spectrum at the rates at which defects of a bearing are felt.

use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::physics::kinematics::CharacteristicFrequencies;
use crate::simulation::result::lines::{TOLERANCE_BINS, TOLERANCE_SHARE};

/// Amplitudes at the first three multiples of a rate, in the unit of the spectrum.
pub type Harmonics = [f64; 3];

/// Amplitudes of an envelope spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeHarmonics {
    pub shaft: Harmonics,
    pub cage: Harmonics,
    pub ball_pass_outer: Harmonics,
    pub ball_pass_inner: Harmonics,
    /// Multiples of twice the spin: a defect meets both raceways in a turn.
    pub double_ball_spin: Harmonics,
}

impl EnvelopeHarmonics {
    /// `None` where the shaft stands still.
    pub(crate) fn of(spectrum: &Spectrum, at: &CharacteristicFrequencies) -> Option<Self> {
        let harmonics = |rate: f64| [1.0, 2.0, 3.0].map(|order| amplitude_at(spectrum, order * rate));
        (at.cage > 0.0).then(|| Self {
            shaft: harmonics(at.shaft),
            cage: harmonics(at.cage),
            ball_pass_outer: harmonics(at.ball_pass_outer),
            ball_pass_inner: harmonics(at.ball_pass_inner),
            double_ball_spin: harmonics(2.0 * at.ball_spin),
        })
    }
}

/// The largest amplitude within the tolerance of a label, interpolated between bins; 0 beyond the spectrum.
fn amplitude_at(spectrum: &Spectrum, frequency: f64) -> f64 {
    let reach = TOLERANCE_BINS + TOLERANCE_SHARE * frequency / spectrum.resolution;
    let middle = frequency / spectrum.resolution;
    let last = spectrum.amplitude.len().saturating_sub(2);
    let bins = ((middle - reach).round().max(1.0) as usize)..=((middle + reach).round() as usize).min(last);
    let largest = bins.max_by(|&a, &b| spectrum.amplitude[a].total_cmp(&spectrum.amplitude[b]));
    largest.map_or(0.0, |bin| interpolated_peak(spectrum, bin).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::spectrum::envelope_spectrum;

    /// Bursts of a resonance at 1000 Hz, 100 times a second: amplitude 1 + 0.4 cos Ωt + 0.2 cos 2Ωt.
    #[test]
    fn harmonics_of_modulated_bursts_are_read_between_bins() {
        const RATE: f64 = 20_000.0;
        let (rate, tau) = (100.3, std::f64::consts::TAU);
        let value = |k: i32| {
            let time = f64::from(k) / RATE;
            let envelope = 1.0 + 0.4 * (tau * rate * time).cos() + 0.2 * (2.0 * tau * rate * time).cos();
            envelope * (tau * 1000.0 * time).cos()
        };
        let signal: Vec<f64> = (0..20_000).map(value).collect();
        let spectrum = envelope_spectrum(&signal, RATE, (500.0, 1500.0));
        let frequencies = CharacteristicFrequencies {
            shaft: 30.0,
            cage: 12.0,
            ball_pass_outer: rate,
            ball_pass_inner: 160.0,
            ball_spin: 70.0,
        };
        let found = EnvelopeHarmonics::of(&spectrum, &frequencies).unwrap();
        let [first, second, third] = found.ball_pass_outer;
        assert!((first / 0.4 - 1.0).abs() < 0.01 && (second / 0.2 - 1.0).abs() < 0.01, "{first} {second}");
        assert!(third < 1e-3 && found.ball_pass_inner[0] < 1e-3 && found.cage[2] < 1e-3, "{found:?}");
    }
}
