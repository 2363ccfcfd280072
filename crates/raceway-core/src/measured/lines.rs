//! Lines of a measured spectrum.

use crate::numerics::spectrum::{Spectrum, interpolated_peak};
use crate::simulation::result::peaks::{LEAST_SHARE, floor, peak_bins};

/// A line of a measured spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    /// [Hz]
    pub frequency: f64,
    pub amplitude: f64,
    /// Amplitude over the floor around the line [-]; `None` where the floor is 0.
    pub over_floor: Option<f64>,
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
