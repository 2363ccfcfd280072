//! Lines of a spectrum, found and labelled by combinations of the bearing's frequencies.

use crate::numerics::spectrum::Spectrum;
use crate::physics::kinematics::CharacteristicFrequencies;

/// A line of a spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// [Hz]
    pub frequency: f64,
    /// In the channel's unit, one-sided: a sine of amplitude 1 reads 1.
    pub amplitude: f64,
    /// Nearest small combination, such as `2·BPFO` or `BPFO − f_r`; empty when none is near.
    pub label: String,
    /// Frequency less that of the label [Hz]; 0 without a label.
    pub deviation: f64,
}

/// The strongest lines of a spectrum, strongest first.
pub fn find_lines(spectrum: &Spectrum, frequencies: &CharacteristicFrequencies, highest: f64) -> Vec<Line> {
    let _ = (spectrum, frequencies, highest);
    unimplemented!()
}
