//! Statistics of sampled signals.

use super::lanes::{LANES, Lanes, larger};

/// Arithmetic mean; 0 of an empty slice.
pub(crate) fn mean(signal: &[f64]) -> f64 {
    if signal.is_empty() { 0.0 } else { signal.iter().sum::<f64>() / signal.len() as f64 }
}

/// Middle value, of an even number the mean of the two in the middle; `None` of an empty slice.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len() % 2 == 1 { upper } else { 0.5 * (sorted[middle - 1] + upper) })
}

/// Root mean square about the mean; 0 of an empty slice.
pub fn rms(signal: &[f64]) -> f64 {
    CentralMoments::of(signal).rms()
}

/// Largest distance from the mean; 0 of an empty slice.
pub fn peak(signal: &[f64]) -> f64 {
    let mean = mean(signal);
    signal.iter().fold(0.0, |largest, x| f64::max(largest, (x - mean).abs()))
}

/// Mean, central moments and extremes of a sample. Those of two samples give those of both together.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CentralMoments {
    count: f64,
    mean: f64,
    second: f64,
    third: f64,
    fourth: f64,
    /// Largest distances from the mean, up and down.
    above: f64,
    below: f64,
}

impl CentralMoments {
    /// Values seen.
    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }

    pub(crate) fn of(signal: &[f64]) -> Self {
        // Eight sums side by side: one would wait for itself with each value.
        let mean = mean(signal);
        let [mut second, mut third, mut fourth, mut above, mut below] = [Lanes::<LANES>::default(); 5];
        for values in signal.chunks(LANES) {
            let off = match <[f64; LANES]>::try_from(values) {
                Ok(values) => values.map(|x| x - mean),
                Err(_) => std::array::from_fn(|lane| values.get(lane).map_or(0.0, |x| x - mean)),
            };
            for lane in 0..LANES {
                let (d, square) = (off[lane], off[lane] * off[lane]);
                second[lane] += square;
                third[lane] += square * d;
                fourth[lane] += square * square;
                above[lane] = larger(d, above[lane]);
                below[lane] = larger(-d, below[lane]);
            }
        }
        let count = signal.len() as f64;
        let mean_of = |sums: Lanes| if count > 0.0 { sums.0.iter().sum::<f64>() / count } else { 0.0 };
        let largest = |lanes: Lanes| lanes.0.into_iter().fold(0.0, f64::max);
        Self {
            count,
            mean,
            second: mean_of(second),
            third: mean_of(third),
            fourth: mean_of(fourth),
            above: largest(above),
            below: largest(below),
        }
    }

    /// Moments of the same values plus `offset`.
    pub(crate) fn shifted(self, offset: f64) -> Self {
        Self { mean: self.mean + offset, ..self }
    }

    /// Moments of both samples together (Pébay 2008, SAND2008-6212, for moments per value).
    pub(crate) fn joined(self, other: Self) -> Self {
        if self.count == 0.0 || other.count == 0.0 {
            return if self.count == 0.0 { other } else { self };
        }
        let count = self.count + other.count;
        let (p, q, d) = (self.count / count, other.count / count, other.mean - self.mean);
        let mean = self.mean + q * d;
        Self {
            count,
            mean,
            second: p * self.second + q * other.second + p * q * d.powi(2),
            third: p * self.third
                + q * other.third
                + p * q * d * (3.0 * (other.second - self.second) + (p - q) * d.powi(2)),
            fourth: p * self.fourth
                + q * other.fourth
                + p * q
                    * d
                    * (4.0 * (other.third - self.third)
                        + 6.0 * d * (p * other.second + q * self.second)
                        + (p * p - p * q + q * q) * d.powi(3)),
            above: f64::max(self.above + (self.mean - mean), other.above + (other.mean - mean)),
            below: f64::max(self.below + (mean - self.mean), other.below + (mean - other.mean)),
        }
    }

    /// Root mean square about the mean.
    pub fn rms(&self) -> f64 {
        self.second.sqrt()
    }

    /// Largest distance from the mean.
    pub(crate) fn peak(&self) -> f64 {
        self.above.max(self.below)
    }

    /// peak / rms (√2 for a sine); `None` for a signal that stands still.
    pub(crate) fn crest_factor(&self) -> Option<f64> {
        let rms = self.rms();
        (rms > 0.0).then(|| self.peak() / rms)
    }

    /// Fourth central moment over squared variance (1.5 for a sine, 3 for Gaussian noise); `None` for a signal that
    /// stands still.
    pub(crate) fn kurtosis(&self) -> Option<f64> {
        let square = self.second * self.second;
        (square > 0.0).then(|| self.fourth / square)
    }
}

/// Mean squares about the common mean of `batches` contiguous batches of equal length; a remainder at the end is left
/// out. Empty where there are fewer values than batches.
pub(crate) fn mean_squares(signal: &[f64], batches: usize) -> Vec<f64> {
    if batches == 0 || signal.len() < batches {
        return Vec::new();
    }
    let mean_of_all = mean(signal);
    signal
        .chunks_exact(signal.len() / batches)
        .take(batches)
        .map(|batch| batch.iter().map(|x| (x - mean_of_all).powi(2)).sum::<f64>() / batch.len() as f64)
        .collect()
}

/// Standard error of the level 20 lg rms [dB] by batch means: the scatter of the batches' mean squares gives the error of the
/// whole, first order in that scatter.
///
/// Holds when a batch is longer than the signal's memory. `None` with fewer than two batches, or of a signal that stands still.
pub(crate) fn level_standard_error_db(mean_squares: &[f64]) -> Option<f64> {
    if mean_squares.len() < 2 {
        return None;
    }
    let power = mean(mean_squares);
    let n = mean_squares.len() as f64;
    let standard_error = rms(mean_squares) / (n - 1.0).sqrt();
    (power > 0.0).then(|| 10.0 / std::f64::consts::LN_10 * standard_error / power)
}

/// Standard deviation of the level over intervals of this length [dB]: the largest standard error by batch means over
/// single batches and blocks of two and five. Motion slower than a batch shows in longer blocks (blocking, Flyvbjerg &
/// Petersen 1989). Motion slower than the whole interval does not show.
///
/// `None` with fewer than `BLOCKED` batches, or of a signal that stands still.
pub fn level_scatter_db(mean_squares: &[f64]) -> Option<f64> {
    let blocks = BLOCKS.map(|size| mean_squares.chunks_exact(size).map(mean).collect::<Vec<_>>());
    let errors = blocks.iter().filter_map(|blocks| level_standard_error_db(blocks));
    errors.reduce(f64::max).filter(|_| mean_squares.len() >= BLOCKED)
}

/// Batches of a block.
const BLOCKS: [usize; 3] = [1, 2, 5];
/// Two of the longest blocks.
const BLOCKED: usize = 10;

/// Slope of the straight line that fits the points (x, y) with least squares; `None` with fewer than two different x.
pub fn slope(x: &[f64], y: &[f64]) -> Option<f64> {
    let n = x.len().min(y.len());
    let (x, y) = (&x[..n], &y[..n]);
    let (mean_x, mean_y) = (mean(x), mean(y));
    let spread: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    let product: f64 = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    (spread > 0.0).then(|| product / spread)
}

/// Positions of at most `max_points` values, ascending, that draw the same picture: first and last value, and least
/// and largest value of equal stretches between them, so that peaks survive. All positions when they are few enough.
pub fn thin(values: &[f64], max_points: usize) -> Vec<usize> {
    let n = values.len();
    if n <= max_points {
        return (0..n).collect();
    }
    if max_points < 4 {
        // No room for a stretch: the ends alone.
        return [0, n - 1][..max_points.min(2)].to_vec();
    }
    let stretches = (max_points - 2) / 2;
    let inner = n - 2;
    let mut kept = Vec::with_capacity(max_points);
    kept.push(0);
    for stretch in 0..stretches {
        let range = 1 + stretch * inner / stretches..1 + (stretch + 1) * inner / stretches;
        let (mut least, mut largest) = (range.start, range.start);
        for i in range {
            if values[i] < values[least] {
                least = i;
            }
            if values[i] > values[largest] {
                largest = i;
            }
        }
        kept.push(least.min(largest));
        if least != largest {
            kept.push(least.max(largest));
        }
    }
    kept.push(n - 1);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform in −0.5 … 0.5, the same on every run.
    fn noise(n: usize) -> Vec<f64> {
        let mut seed = 0x2545_f491_4f6c_dd1d_u64;
        let mut next = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        (0..n).map(|_| next()).collect()
    }

    fn sine(n: usize, periods: f64) -> Vec<f64> {
        (0..n).map(|i| (std::f64::consts::TAU * periods * i as f64 / n as f64).sin()).collect()
    }

    /// Independent batches tell the same by blocks of any size; a slow rise shows in the longest alone.
    #[test]
    fn scatter_of_a_level_sees_what_is_slower_than_a_batch() {
        let quick = [1.1, 0.9, 0.9, 1.1, 1.1, 0.9, 0.9, 1.1, 1.1, 0.9];
        let own = level_standard_error_db(&quick).unwrap();
        assert_eq!(level_scatter_db(&quick), Some(own));
        let slow = [0.9, 0.9, 0.9, 0.9, 0.9, 1.1, 1.1, 1.1, 1.1, 1.1];
        let halves = level_standard_error_db(&[0.9, 1.1]).unwrap();
        assert!((level_scatter_db(&slow).unwrap() - halves).abs() < 1e-12 && halves > 2.5 * own);
        assert_eq!(level_scatter_db(&quick[..9]), None);
        assert_eq!(level_scatter_db(&[0.0; 10]), None);
    }

    #[test]
    fn sine_on_a_constant_has_the_statistics_of_a_sine() {
        let signal: Vec<f64> = sine(4000, 10.0).iter().map(|x| 7.0 + 2.0 * x).collect();
        assert!((mean(&signal) - 7.0).abs() < 1e-12);
        assert!((rms(&signal) - 2f64.sqrt()).abs() < 1e-12);
        assert!((peak(&signal) - 2.0).abs() < 1e-12);
        let moments = CentralMoments::of(&signal);
        assert_eq!((moments.mean, moments.rms(), moments.peak()), (mean(&signal), rms(&signal), peak(&signal)));
        assert!((moments.crest_factor().unwrap() - 2f64.sqrt()).abs() < 1e-12);
        assert!((moments.kurtosis().unwrap() - 1.5).abs() < 1e-12);
    }

    #[test]
    fn the_median_is_the_middle_value() {
        assert_eq!((median(&[]), median(&[3.0])), (None, Some(3.0)));
        assert_eq!((median(&[5.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 9.0])), (Some(2.0), Some(3.0)));
    }

    #[test]
    fn uniform_noise_has_kurtosis_nine_fifths() {
        assert!((CentralMoments::of(&noise(100_000)).kurtosis().unwrap() - 1.8).abs() < 0.02);
    }

    #[test]
    fn moments_of_parts_joined_are_those_of_the_whole() {
        // Lopsided, drifting, and in parts of different lengths and means.
        let signal: Vec<f64> =
            noise(9000).iter().enumerate().map(|(i, x)| (1.0 + x).powi(3) + 2e-4 * i as f64).collect();
        let whole = CentralMoments::of(&signal);
        let parts = [&signal[..1000], &[], &signal[1000..1001], &signal[1001..6000], &signal[6000..]];
        let joined = parts.iter().fold(CentralMoments::default(), |all, part| all.joined(CentralMoments::of(part)));
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} against {b}");
        near(joined.mean, whole.mean);
        near(joined.rms(), whole.rms());
        near(joined.third, whole.third);
        near(joined.peak(), whole.peak());
        near(joined.kurtosis().unwrap(), whole.kurtosis().unwrap());
        assert_eq!(joined.count, 9000.0);
        assert_eq!(CentralMoments::default().joined(whole), whole);
    }

    #[test]
    fn still_and_empty_signals_have_no_ratios() {
        for signal in [&[][..], &[3.0], &[3.0, 3.0]] {
            assert_eq!((rms(signal), peak(signal)), (0.0, 0.0));
            let moments = CentralMoments::of(signal);
            assert_eq!((moments.crest_factor(), moments.kurtosis()), (None, None));
            assert_eq!(level_standard_error_db(&mean_squares(signal, 2)), None);
        }
    }

    #[test]
    fn standard_error_is_zero_for_a_steady_tone_and_matches_theory_for_noise() {
        assert!(level_standard_error_db(&mean_squares(&sine(4000, 40.0), 10)).unwrap() < 1e-12);
        // Mean square of n uniform values: relative standard error √((1.8 − 1)/n).
        let n = 100_000;
        let expected = 10.0 / std::f64::consts::LN_10 * (0.8 / n as f64).sqrt();
        let found = level_standard_error_db(&mean_squares(&noise(n), 50)).unwrap();
        assert!((found / expected - 1.0).abs() < 0.3, "{found} against {expected}");
    }

    #[test]
    fn slope_of_a_line_is_found_exactly_and_needs_two_places() {
        let x = [0.0, 1.0, 2.0, 5.0];
        let y = x.map(|x| 3.0 - 4.0 * x);
        assert!((slope(&x, &y).unwrap() + 4.0).abs() < 1e-14);
        assert_eq!(slope(&[1.0, 1.0], &[0.0, 2.0]), None);
        assert_eq!(slope(&[], &[]), None);
    }

    #[test]
    fn thinning_keeps_ends_and_extremes_within_the_limit() {
        let mut signal = sine(10_000, 30.0);
        signal[1234] = 50.0;
        signal[8765] = -60.0;
        for limit in [4, 5, 7, 100, 9_999] {
            let kept = thin(&signal, limit);
            assert!(kept.len() <= limit);
            assert!(kept.contains(&0) && kept.contains(&9_999));
            assert!(kept.contains(&1234) && kept.contains(&8765), "limit {limit}");
            assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
        }
        assert_eq!(thin(&signal, 10_000).len(), 10_000);
        for limit in 0..4 {
            assert!(thin(&signal, limit).len() <= limit);
        }
        assert!(thin(&[], 10).is_empty());
    }
}
