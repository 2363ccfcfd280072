//! Lines of a measured spectrum, and their partners among predicted lines.

use super::shift::Shifts;
use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::simulation::result::lines::{LEAST_SHARE, floor, peak_bins};

/// A line of a measured spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    /// [Hz]
    pub frequency: f64,
    pub amplitude: f64,
    /// Amplitude over the floor around the line [-]; `None` where the floor is 0.
    pub over_floor: Option<f64>,
}

/// A predicted line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedLine<'a> {
    pub order: f64,
    pub amplitude: f64,
    /// As in a result, such as `2·BPFO − f_r@A`; empty without one.
    pub label: &'a str,
}

/// Lines of a spectrum up to `highest` [Hz], strongest first, interpolated between bins, within 60 dB of the strongest.
pub fn lines_of(spectrum: &Spectrum, highest: f64) -> Vec<MeasuredLine> {
    let mut lines = peaks_of(spectrum, highest);
    let strongest = lines.first().map_or(0.0, |line| line.amplitude);
    lines.retain(|line| line.amplitude > LEAST_SHARE * strongest);
    lines
}

/// Lines of a spectrum and all weaker ones above its floor, however strong the strongest is.
pub fn peaks_of(spectrum: &Spectrum, highest: f64) -> Vec<MeasuredLine> {
    let line = |bin: usize| {
        let (frequency, amplitude) = interpolated_peak(spectrum, bin);
        let floor = floor(&spectrum.amplitude, bin);
        MeasuredLine { frequency, amplitude, over_floor: (floor > 0.0).then(|| amplitude / floor) }
    };
    let mut lines: Vec<MeasuredLine> = peak_bins(spectrum, highest).into_iter().map(line).collect();
    // Interpolation raises a line by at most 18 %, and may change the sequence.
    lines.sort_by(|one, other| other.amplitude.total_cmp(&one.amplitude));
    lines
}

/// Number of the measured line that belongs to each predicted one: the strongest at the shift of its series. A measured line has one partner; stronger
/// predicted lines choose first.
///
/// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`](super::shift::SHIFT_BINS) as orders.
pub fn partners(predicted: &[PredictedLine<'_>], measured: &[f64], shifts: &Shifts, reach: f64) -> Vec<Option<usize>> {
    let mut sequence: Vec<usize> = (0..predicted.len()).collect();
    sequence.sort_by(|a, b| predicted[*b].amplitude.total_cmp(&predicted[*a].amplitude));
    let (mut found, mut is_taken) = (vec![None; predicted.len()], vec![false; measured.len()]);
    for own in sequence {
        found[own] = (0..measured.len()).find(|k| !is_taken[*k] && shifts.joins(&predicted[own], measured[*k], reach));
        if let Some(partner) = found[own] {
            is_taken[partner] = true;
        }
    }
    found
}
