//! Lines of a measured spectrum, and their partners among predicted lines.

use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::simulation::result::lines::{floor, line_bins, peak_bins};

/// Largest shift of a line against its prediction [-]. Slip of the cage, an unknown contact angle and an error of the stated speed move lines by
/// up to 1 % (docs/how-to/compare-a-measurement.md).
pub const MOST_SHIFT: f64 = 0.02;
/// Shift within which a line may always lie, in bins: a line between two bins is found to a fraction of one.
pub const SHIFT_BINS: f64 = 1.5;

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
pub struct PredictedLine {
    pub order: f64,
    pub amplitude: f64,
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

/// Number of the measured line that belongs to each predicted one. It is the strongest one within 2 % of its order and within half the distance
/// to the next predicted line, but always within 1.5 bins. A measured line has one partner; stronger predicted lines choose first.
///
/// `measured`: strongest first. `speed`: of the measured shaft [Hz]. `resolution` [Hz].
pub fn partners(
    predicted: &[PredictedLine],
    measured: &[MeasuredLine],
    speed: f64,
    resolution: f64,
) -> Vec<Option<usize>> {
    let mut sequence: Vec<usize> = (0..predicted.len()).collect();
    sequence.sort_by(|a, b| predicted[*b].amplitude.total_cmp(&predicted[*a].amplitude));
    let (mut found, mut is_taken) = (vec![None; predicted.len()], vec![false; measured.len()]);
    for own in sequence {
        let order = predicted[own].order;
        let others = predicted.iter().enumerate().filter(|(other, _)| *other != own);
        let nearest = others.map(|(_, other)| (other.order - order).abs()).fold(f64::INFINITY, f64::min);
        let reach = (MOST_SHIFT * order).min(0.5 * nearest).max(SHIFT_BINS * resolution / speed);
        let is_near = |line: &MeasuredLine| (line.frequency / speed - order).abs() <= reach;
        found[own] = (0..measured.len()).find(|k| !is_taken[*k] && is_near(&measured[*k]));
        if let Some(partner) = found[own] {
            is_taken[partner] = true;
        }
    }
    found
}
