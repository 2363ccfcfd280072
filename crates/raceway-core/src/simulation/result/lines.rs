//! Lines of a spectrum, found and labelled by combinations of the bearing's frequencies.

use super::line_label::{Place, label};
use super::line_sources::LineSources;
use super::peaks::line_bins;
use crate::numerics::spectrum::{Spectrum, interpolated_peak, spread_of_place};

/// A line of a spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Frequency of the line [Hz].
    pub frequency: f64,
    /// One-sided amplitude in the channel's unit: a sine of amplitude 1 reads 1.
    pub amplitude: f64,
    /// Nearest small combination, such as `2·BPFO` or `BPFO − f_r`; empty when none is near.
    pub label: String,
    /// Frequency less that of the label [Hz]; 0 without a label.
    pub deviation: f64,
}

/// Largest number of listed lines.
const MAX_LINES: usize = 20;

/// The strongest lines of a spectrum up to `highest` [Hz], strongest first, at most 20. A line is a local maximum above the local
/// floor, interpolated between bins. Its label is the simplest combination of the bearing's frequencies within half a bin plus 0.02 %, and
/// within the uncertainty of its place, or the whirl of cage or spindle.
pub(crate) fn find_lines(spectrum: &Spectrum, sources: &LineSources<'_>, highest: f64) -> Vec<Line> {
    let mut lines: Vec<Line> = line_bins(spectrum, highest)
        // Interpolation raises a line by at most 18 %; a few more are kept until their order is known.
        .take(2 * MAX_LINES)
        .map(|bin| {
            let (frequency, amplitude) = interpolated_peak(spectrum, bin);
            let place = Place { frequency, spread: spread_of_place(spectrum, bin) };
            let (label, deviation) = label(place, sources, spectrum.resolution);
            Line { frequency, amplitude, label, deviation }
        })
        .collect();
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    lines.truncate(MAX_LINES);
    lines
}

#[cfg(test)]
mod tests {
    use super::super::line_examples::{seven_balls, spectrum_of, without_whirl};
    use super::*;
    use crate::physics::kinematics::CharacteristicFrequencies;

    /// A steady tone 0.3 bins beside 4·BSF is not labelled by it; a line whose frequency wanders by as much is.
    #[test]
    fn no_label_by_chance() {
        let f = CharacteristicFrequencies { ball_spin: 200.225, ..seven_balls() };
        let sources = without_whirl(f);
        let beside = 4.0 * f.ball_spin + 3.0;
        let of = |spread: f64| label(Place { frequency: beside, spread }, &sources, 10.0).0;
        assert_eq!([of(0.0), of(0.5), of(3.0)], ["", "", "4·BSF"]);
        let steady = find_lines(&spectrum_of(&[(beside, 1.0)], 0.0), &sources, 5000.0);
        assert!((steady[0].frequency - beside).abs() < 0.05 && steady[0].label.is_empty(), "{steady:?}");
        let wandering = find_lines(&spectrum_of(&[(beside, 1.0), (beside - 5.0, 0.8)], 0.0), &sources, 5000.0);
        assert_eq!(wandering[0].label, "4·BSF", "{wandering:?}");
    }

    #[test]
    fn two_tones_off_bin_in_noise_are_the_two_strongest_lines() {
        let bpfo = seven_balls().ball_pass_outer;
        let lines =
            find_lines(&spectrum_of(&[(bpfo, 2.0), (2.0 * bpfo, 0.5)], 0.05), &without_whirl(seven_balls()), 20_000.0);
        assert_eq!(lines[0].label, "BPFO");
        assert_eq!(lines[1].label, "2·BPFO");
        assert!((lines[0].amplitude / 2.0 - 1.0).abs() < 0.01 && (lines[1].amplitude / 0.5 - 1.0).abs() < 0.02);
        assert!((lines[0].frequency - bpfo).abs() < 0.2 && lines[0].deviation.abs() < 0.2);
        assert!(lines.iter().all(|line| line.label != "f_r"), "no line where nothing turns unbalanced");
        assert!(lines.len() <= 4, "noise makes hardly any line: {lines:?}");
        assert!(lines.windows(2).all(|pair| pair[0].amplitude >= pair[1].amplitude));
    }

    #[test]
    fn leakage_of_a_pure_tone_makes_no_second_line() {
        let lines = find_lines(&spectrum_of(&[(2293.44, 1.0)], 0.0), &without_whirl(seven_balls()), 20_000.0);
        assert_eq!(lines.len(), 1);
    }

    #[test]
    fn lines_above_the_highest_frequency_are_not_listed() {
        let spectrum = spectrum_of(&[(2293.44, 1.0), (25_000.0, 5.0)], 0.0);
        let lines = find_lines(&spectrum, &without_whirl(seven_balls()), 20_000.0);
        assert!(lines.iter().all(|line| line.frequency < 20_000.0));
        assert_eq!(lines[0].label, "BPFO");
    }

    #[test]
    fn many_tones_give_at_most_twenty_lines() {
        let tones: Vec<(f64, f64)> = (1..50).map(|i| (397.0 * f64::from(i), 1.0 / f64::from(i))).collect();
        assert_eq!(find_lines(&spectrum_of(&tones, 0.0), &without_whirl(seven_balls()), 20_000.0).len(), MAX_LINES);
    }

    #[test]
    fn silent_and_short_spectra_have_no_lines() {
        for entries in [0, 1, 2, 3, 5, 100] {
            let spectrum = Spectrum { resolution: 10.0, amplitude: vec![0.0; entries], window: "hann", averages: 1 };
            assert!(find_lines(&spectrum, &without_whirl(seven_balls()), 20_000.0).is_empty());
        }
    }
}
