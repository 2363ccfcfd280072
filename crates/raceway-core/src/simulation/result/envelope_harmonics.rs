//! Amplitudes of an envelope spectrum at the rates at which defects of a bearing are felt.

use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::physics::kinematics::CharacteristicFrequencies;
use crate::simulation::result::line_label::{TOLERANCE_BINS, TOLERANCE_SHARE};

/// Amplitudes at the first three multiples of a rate, in the unit of the spectrum; `None` where a line of another rate hides the place, or the
/// record is too short for a line so near to 0 Hz.
pub type Harmonics = [Option<f64>; 3];

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
        // The cage last: its multiples by the number of balls are the passages of the outer raceway.
        let rates = [at.shaft, at.ball_pass_outer, at.ball_pass_inner, 2.0 * at.ball_spin, at.cage];
        let harmonics =
            |own: usize| [1.0, 2.0, 3.0].map(|order| amplitude_at(spectrum, &rates, own, order * rates[own]));
        (at.cage > 0.0).then(|| Self {
            shaft: harmonics(0),
            ball_pass_outer: harmonics(1),
            ball_pass_inner: harmonics(2),
            double_ball_spin: harmonics(3),
            cage: harmonics(4),
        })
    }
}

/// Half of the width of a line under the window of the spectra [bins].
const HALF_LINE: usize = 2;

/// Amplitude at a multiple of a rate; `None` where the flank of 0 Hz or a peak of another rate covers the place.
///
/// It is that of the largest peak within the tolerance of a label that is nearer to this multiple than to those of the other rates, interpolated
/// between bins. Without such a peak it is the background.
fn amplitude_at(spectrum: &Spectrum, rates: &[f64; 5], own: usize, frequency: f64) -> Option<f64> {
    let amplitude = &spectrum.amplitude;
    let middle = frequency / spectrum.resolution;
    if middle < HALF_LINE as f64 {
        return None;
    }
    let reach = TOLERANCE_BINS + TOLERANCE_SHARE * middle;
    let last = amplitude.len().saturating_sub(2);
    let bins =
        |reach: f64| ((middle - reach).round().max(1.0) as usize)..=((middle + reach).round() as usize).min(last);
    let is_peak = |bin: &usize| amplitude[*bin] >= amplitude[bin - 1].max(amplitude[bin + 1]);
    let is_own = |bin: &usize| {
        let place = interpolated_peak(spectrum, *bin).0;
        let others = rates[..4].iter().enumerate().filter(|(rate, _)| *rate != own);
        let to_others = others.map(|(_, rate)| (place - rate * (place / rate).round().max(1.0)).abs());
        to_others.fold(f64::INFINITY, f64::min) >= (place - frequency).abs()
    };
    let larger = |&a: &usize, &b: &usize| amplitude[a].total_cmp(&amplitude[b]);
    if let Some(peak) = bins(reach).filter(is_peak).filter(is_own).max_by(larger) {
        return Some(interpolated_peak(spectrum, peak).1);
    }
    let nearest = (middle.round() as usize).clamp(1, last.max(1));
    let is_hidden = bins(reach + HALF_LINE as f64).any(|bin| is_peak(&bin) && amplitude[bin] >= amplitude[nearest]);
    (!is_hidden).then(|| if middle > last as f64 { 0.0 } else { amplitude[nearest] })
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
            outer_ring: 0.0,
            ball_pass: rate,
            ball_pass_outer: rate,
            ball_pass_inner: 160.0,
            ball_spin: 70.0,
        };
        let found = EnvelopeHarmonics::of(&spectrum, &frequencies).unwrap();
        let [first, second, third] = found.ball_pass_outer.map(Option::unwrap);
        assert!((first / 0.4 - 1.0).abs() < 0.01 && (second / 0.2 - 1.0).abs() < 0.01, "{first} {second}");
        assert!(third < 1e-3 && found.ball_pass_inner[0].unwrap() < 1e-3 && found.cage[2].unwrap() < 1e-3, "{found:?}");
    }

    /// Bursts 107 times a second have a line at 321 Hz. It is none of 2 × 162 = 324 Hz, in a record that separates them by two bins and in one that
    /// does not separate them.
    #[test]
    fn a_line_belongs_to_the_nearest_rate() {
        const RATE: f64 = 20_000.0;
        let tau = std::f64::consts::TAU;
        let value = |k: i32| {
            let time = f64::from(k) / RATE;
            let envelope = 1.0 + 0.3 * (tau * 107.0 * time).cos() + 0.2 * (tau * 321.0 * time).cos();
            envelope * (tau * 1000.0 * time).cos()
        };
        let frequencies = CharacteristicFrequencies {
            shaft: 29.95,
            cage: 11.9,
            outer_ring: 0.0,
            ball_pass: 107.0,
            ball_pass_outer: 107.0,
            ball_pass_inner: 162.0,
            ball_spin: 70.5,
        };
        for values in [4_000, 14_000] {
            let signal: Vec<f64> = (0..values).map(value).collect();
            let found =
                EnvelopeHarmonics::of(&envelope_spectrum(&signal, RATE, (400.0, 1600.0)), &frequencies).unwrap();
            assert!((found.ball_pass_outer[2].unwrap() / 0.2 - 1.0).abs() < 0.02, "{found:?}");
            assert_eq!(found.ball_pass_inner[1], None, "{found:?}");
            assert!(found.ball_pass_inner[0].unwrap() < 1e-3, "{found:?}");
        }
    }

    /// Six bursts a second in a record of 0.2 s, whose bins are 5 Hz wide: no rate below 10 Hz has a line of its own, and the largest bin belongs to
    /// none of them.
    #[test]
    fn a_short_record_has_no_lines_of_slow_rates() {
        const RATE: f64 = 20_000.0;
        let tau = std::f64::consts::TAU;
        let value = |k: i32| {
            let time = f64::from(k) / RATE;
            (1.0 + 0.5 * (tau * 6.0 * time).cos()) * (tau * 1000.0 * time).cos()
        };
        let signal: Vec<f64> = (0..4_000).map(value).collect();
        let frequencies = CharacteristicFrequencies {
            shaft: 1.67,
            cage: 0.66,
            outer_ring: 0.0,
            ball_pass: 6.0,
            ball_pass_outer: 6.0,
            ball_pass_inner: 9.0,
            ball_spin: 3.9,
        };
        let found = EnvelopeHarmonics::of(&envelope_spectrum(&signal, RATE, (400.0, 1600.0)), &frequencies).unwrap();
        for slow in [found.shaft[0], found.cage[0], found.ball_pass_outer[0], found.ball_pass_inner[0]] {
            assert_eq!(slow, None, "{found:?}");
        }
    }
}
