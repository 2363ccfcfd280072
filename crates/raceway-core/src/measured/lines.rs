//! Lines of a measured spectrum, and their partners among predicted lines.

use super::shift::Shifts;
use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::simulation::result::lines::{floor, line_bins, peak_bins};

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

/// Lines of a spectrum up to `highest` [Hz], strongest first, interpolated between bins.
pub fn lines_of(spectrum: &Spectrum, highest: f64) -> Vec<MeasuredLine> {
    interpolated(spectrum, line_bins(spectrum, highest))
}

/// Lines of a spectrum and all weaker ones above its floor, however strong the strongest is.
pub fn peaks_of(spectrum: &Spectrum, highest: f64) -> Vec<MeasuredLine> {
    interpolated(spectrum, peak_bins(spectrum, highest))
}

fn interpolated(spectrum: &Spectrum, bins: Vec<usize>) -> Vec<MeasuredLine> {
    let line = |bin: usize| {
        let (frequency, amplitude) = interpolated_peak(spectrum, bin);
        let floor = floor(&spectrum.amplitude, bin);
        MeasuredLine { frequency, amplitude, over_floor: (floor > 0.0).then(|| amplitude / floor) }
    };
    bins.into_iter().map(line).collect()
}

/// Number of the measured line that belongs to each predicted one: the strongest within the reach of the shift of its series. A measured line has
/// one partner; stronger predicted lines choose first.
///
/// `measured`: orders, strongest first. `reach`: [`SHIFT_BINS`] as orders.
pub fn partners(predicted: &[PredictedLine<'_>], measured: &[f64], shifts: &Shifts, reach: f64) -> Vec<Option<usize>> {
    let mut sequence: Vec<usize> = (0..predicted.len()).collect();
    sequence.sort_by(|a, b| predicted[*b].amplitude.total_cmp(&predicted[*a].amplitude));
    let (mut found, mut is_taken) = (vec![None; predicted.len()], vec![false; measured.len()]);
    for own in sequence {
        let order = predicted[own].order;
        let others = predicted.iter().enumerate().filter(|(other, _)| *other != own);
        let nearest = others.map(|(_, other)| (other.order - order).abs()).fold(f64::INFINITY, f64::min);
        let (low, high) = shifts.range(&predicted[own], nearest, reach);
        found[own] = (0..measured.len()).find(|k| !is_taken[*k] && (low..=high).contains(&measured[*k]));
        if let Some(partner) = found[own] {
            is_taken[partner] = true;
        }
    }
    found
}
