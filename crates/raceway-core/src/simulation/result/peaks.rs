//! Peaks of a spectrum above its local floor.

use crate::numerics::spectrum::Spectrum;

/// A peak is the largest entry within this many bins to both sides: the half width of a Hann window's main lobe.
const LOBE: usize = 2;
/// Bins to both sides whose median is taken for the floor.
const FLOOR_REACH: usize = 25;
/// A peak stands this far above the floor. The noise of a single window does so in one bin of 7000, because the floor is estimated, too; above
/// the true median it would in one of 60 000.
const FLOOR_FACTOR: f64 = 4.0;
/// A line has at least this share of the strongest one's amplitude (−60 dB).
pub(crate) const LEAST_SHARE: f64 = 1e-3;

/// Bins of the lines of a spectrum up to `highest` [Hz], strongest first: local maxima above the local floor and within 60 dB of the strongest.
pub(super) fn line_bins(spectrum: &Spectrum, highest: f64) -> impl Iterator<Item = usize> {
    let amplitude = &spectrum.amplitude;
    let maxima = local_maxima(spectrum, highest);
    let strongest = maxima.iter().find(|&&bin| stands_out(amplitude, bin)).map_or(0.0, |&bin| amplitude[bin]);
    // Most maxima are too weak. Their floors would take longer than all lines.
    let strong = maxima.into_iter().take_while(move |&bin| amplitude[bin] > LEAST_SHARE * strongest);
    strong.filter(|&bin| stands_out(amplitude, bin))
}

/// Bins of all local maxima above the local floor up to `highest` [Hz], strongest first.
pub(crate) fn peak_bins(spectrum: &Spectrum, highest: f64) -> Vec<usize> {
    let mut bins = local_maxima(spectrum, highest);
    bins.retain(|&bin| stands_out(&spectrum.amplitude, bin));
    bins
}

/// Bins of all local maxima up to `highest` [Hz], strongest first.
fn local_maxima(spectrum: &Spectrum, highest: f64) -> Vec<usize> {
    let amplitude = &spectrum.amplitude;
    // The bins at 0 and 1 hold slow drift, and the last ones have no neighbours.
    let end = amplitude.len().saturating_sub(LOBE);
    let mut bins: Vec<usize> = (LOBE..end)
        .take_while(|&bin| bin as f64 * spectrum.resolution <= highest)
        .filter(|&bin| is_local_maximum(amplitude, bin))
        .collect();
    bins.sort_by(|&a, &b| amplitude[b].total_cmp(&amplitude[a]));
    bins
}

/// Returns true for an entry far above the local floor.
fn stands_out(amplitude: &[f64], bin: usize) -> bool {
    amplitude[bin] > FLOOR_FACTOR * floor(amplitude, bin)
}

fn is_local_maximum(amplitude: &[f64], bin: usize) -> bool {
    let at = amplitude[bin];
    // The first of two equal neighbours is the maximum.
    (1..=LOBE).all(|d| at > amplitude[bin - d] && at >= amplitude[bin + d])
}

/// Median of the entries around a bin, without its main lobe and without other lines. In a comb of lines, a median of all entries would
/// be one of the lines.
pub(crate) fn floor(amplitude: &[f64], bin: usize) -> f64 {
    let from = bin.saturating_sub(FLOOR_REACH);
    let to = (bin + FLOOR_REACH + 1).min(amplitude.len());
    let mut around: Vec<f64> = (from..to).filter(|other| other.abs_diff(bin) > LOBE).map(|i| amplitude[i]).collect();
    around.sort_by(f64::total_cmp);
    let mut rest = around.as_slice();
    while let Some(&median) = rest.get(rest.len() / 2) {
        let noise = rest.partition_point(|&entry| entry <= FLOOR_FACTOR * median);
        if noise == rest.len() {
            return median;
        }
        rest = &rest[..noise];
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::super::line_examples::{RATE, spectrum_of};
    use super::*;
    use crate::numerics::random::SplitMix64;
    use crate::numerics::spectrum::amplitude_spectrum;

    /// Lines 8.3 bins apart, whose amplitudes differ by up to 40 dB: skirts of strong ones neither hide weak ones nor make lines.
    #[test]
    fn all_lines_of_a_dense_comb_are_found() {
        let golden = 0.618_034;
        let tones: Vec<(f64, f64)> =
            (1..=200).map(f64::from).map(|n| (83.0 * n, 10_f64.powf(-2.0 * (golden * n).fract()))).collect();
        let spectrum = spectrum_of(&tones, 1e-5);
        let mut bins = peak_bins(&spectrum, 16_650.0);
        bins.sort_unstable();
        let expected: Vec<usize> = tones.iter().map(|(frequency, _)| (frequency / 10.0).round() as usize).collect();
        assert_eq!(bins.len(), expected.len(), "{bins:?}");
        assert!(bins.iter().zip(&expected).all(|(bin, line)| bin.abs_diff(*line) <= 1), "{bins:?}");
    }

    /// 84 of 600 000 bins in another simulation.
    #[test]
    fn noise_makes_a_line_in_one_bin_of_7000() {
        let mut random = SplitMix64::new(3);
        let mut normal = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let noise: Vec<f64> = (0..1 << 20).map(|_| normal()).collect();
        let lines = peak_bins(&amplitude_spectrum(&noise, RATE), RATE).len();
        // 73 expected of 524 288 bins; their scatter is 9.
        assert!((45..=105).contains(&lines), "{lines}");
    }

    /// Lines and their skirts fill more than half of the entries: the median is a skirt, the floor is not.
    #[test]
    fn lines_of_a_comb_are_not_its_floor() {
        let mut amplitude = vec![0.1; 200];
        for (entry, amplitude) in amplitude.iter_mut().enumerate() {
            match entry % 20 {
                0 | 2 | 4 | 6 | 8 | 10 | 12 | 14 | 16 => *amplitude = 5.0,
                1 | 3 | 5 => *amplitude = 1.0,
                _ => (),
            }
        }
        assert_eq!(floor(&amplitude, 100), 0.1);
    }
}
