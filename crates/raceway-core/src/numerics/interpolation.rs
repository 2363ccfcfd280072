//! Samples between samples: signals at other times of an even grid.

use super::lanes::{InstructionSet, Task};

/// Samples that a value is taken from.
const POINTS: usize = 8;

/// Takes frames of `N` signals at even times and gives `values` frames, evenly spaced, to every `steps` of them, by the polynomial
/// through the four samples on either side (Lagrange). Halfway between two samples, where it is worst, a tone comes out lower by
/// 6·10⁻⁴ of itself at eight samples a period, by 2·10⁻⁵ at twelve.
#[derive(Debug, Clone)]
pub(crate) struct Interpolator<const N: usize> {
    steps: usize,
    values: usize,
    /// Weights of the values at 0 … `values` − 1 parts of the sample interval after a sample.
    weights: Vec<[f64; POINTS]>,
    /// The last frames, from the first one that a value still needs.
    frames: Vec<[f64; N]>,
    /// Parts of a sample from the fourth of them to the next value.
    next: usize,
    /// Values that the frames of the last call have made known.
    known: Vec<[f64; N]>,
}

impl<const N: usize> Interpolator<N> {
    /// Frames that follow a value before it is known, and frames before the one that the first value belongs to.
    pub(crate) const DELAY: usize = POINTS / 2;

    pub(crate) fn new(steps: usize, values: usize) -> Self {
        let weights = (0..values).map(|part| between(part as f64 / values as f64)).collect();
        // Starts as if a frame earlier, with a value that is not returned.
        Self { steps, values, weights, frames: Vec::new(), next: values, known: Vec::new() }
    }

    /// Takes `frame` as having stood still until now: the first value then belongs to the first frame pushed from here.
    pub(crate) fn prime(&mut self, frame: &[f64; N]) {
        self.frames = vec![*frame; POINTS / 2];
    }

    /// Takes frames; the values that they make known, by these instructions.
    pub(crate) fn push(&mut self, frames: &[[f64; N]], instructions: InstructionSet) -> &[[f64; N]] {
        self.frames.extend_from_slice(frames);
        self.known.clear();
        instructions.run(Between(self));
        &self.known
    }
}

/// Every value that frames are there for.
struct Between<'a, const N: usize>(&'a mut Interpolator<N>);

impl<const N: usize> Task for Between<'_, N> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        let Interpolator { steps, values, weights, frames, next, known } = self.0;
        let mut passed = 0;
        for around in frames.windows(POINTS) {
            while *next < *values {
                known.push(if *next == 0 { around[POINTS / 2 - 1] } else { weighed(&weights[*next], around) });
                *next += *steps;
            }
            *next -= *values;
            passed += 1;
        }
        frames.drain(..passed);
    }
}

#[inline(always)]
fn weighed<const N: usize>(weights: &[f64; POINTS], frames: &[[f64; N]]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (weight, frame) in weights.iter().zip(frames) {
        for (sum, sample) in sums.iter_mut().zip(frame) {
            *sum += weight * sample;
        }
    }
    sums
}

/// Weights of samples −3 … 4 for a value at 0 ≤ x < 1.
fn between(x: f64) -> [f64; POINTS] {
    through(POINTS, x + (POINTS / 2 - 1) as f64)
}

/// A motion sampled at even times, with interpolation between the samples.
#[derive(Debug, Clone, Default)]
pub(crate) struct Course {
    /// Numbers of a sample.
    width: usize,
    /// Time of the first and of the last sample.
    begin: f64,
    end: f64,
    samples: usize,
    /// The last samples, one behind the other.
    kept: Vec<f64>,
}

impl Course {
    /// Samples kept for interpolation; at most twice as many are stored.
    const KEPT: usize = 2 * POINTS;

    /// Creates a course whose samples have `width` numbers.
    pub(crate) fn new(width: usize) -> Self {
        Self { width, ..Self::default() }
    }

    /// Forgets all samples.
    pub(crate) fn clear(&mut self) {
        self.samples = 0;
        self.kept.clear();
    }

    /// The time of the last sample; `None` before the first.
    pub(crate) fn end(&self) -> Option<f64> {
        (self.samples > 0).then_some(self.end)
    }

    /// The time up to which four samples follow a value; `None` before four samples exist.
    pub(crate) fn known(&self) -> Option<f64> {
        let ahead = POINTS / 2 - 1;
        (self.samples > ahead).then(|| self.end - ahead as f64 * self.step())
    }

    fn step(&self) -> f64 {
        (self.end - self.begin) / (self.samples.max(2) - 1) as f64
    }

    /// The next sample.
    pub(crate) fn push(&mut self, time: f64, sample: impl Iterator<Item = f64>) {
        if self.samples == 0 {
            self.begin = time;
        }
        if self.kept.len() >= 2 * Self::KEPT * self.width {
            self.kept.drain(..self.kept.len() - Self::KEPT * self.width);
        }
        self.kept.extend(sample);
        self.samples += 1;
        self.end = time;
        debug_assert!(self.kept.len().is_multiple_of(self.width));
    }

    /// Writes the interpolated numbers at a time. The first `smooth` numbers follow the polynomial through the eight
    /// nearest samples, four on either side where available. The others are linear between two samples.
    ///
    /// # Panics
    /// When there is no sample, or numbers are missing.
    pub(crate) fn at(&self, time: f64, smooth: usize, values: &mut [f64]) {
        let kept = self.kept.len() / self.width;
        let place = (kept - 1) as f64 - (self.end - time) / self.step().max(f64::MIN_POSITIVE);
        let left = (place.max(0.0) as usize).min(kept.saturating_sub(2));
        let points = kept.min(POINTS);
        let first = left.saturating_sub(POINTS / 2 - 1).min(kept - points);
        let weights = through(points, place - first as f64);
        let sample = |i: usize| &self.kept[i * self.width..(i + 1) * self.width];
        values[..smooth].fill(0.0);
        for (i, weight) in weights[..points].iter().enumerate() {
            for (value, number) in values.iter_mut().zip(&sample(first + i)[..smooth]) {
                *value += weight * number;
            }
        }
        let (a, b) = (sample(left), sample((left + 1).min(kept - 1)));
        let part = place - left as f64;
        for i in smooth..self.width {
            values[i] = a[i] + part * (b[i] - a[i]);
        }
    }
}

/// Weights of samples 0 … `points` − 1 for a value at x (Lagrange).
fn through(points: usize, x: f64) -> [f64; POINTS] {
    let mut weights = [0.0; POINTS];
    // Products of the distances to all samples before, and to all after; over i! (points − 1 − i)!, with alternating sign.
    let mut before = 1.0;
    for (i, weight) in weights[..points].iter_mut().enumerate() {
        *weight = before;
        before *= (x - i as f64) / (i + 1) as f64;
    }
    let mut after = 1.0;
    for (i, weight) in weights[..points].iter_mut().enumerate().rev() {
        *weight *= after;
        after *= (i as f64 - x) / (points - i) as f64;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    const DELAY: i32 = Interpolator::<2>::DELAY as i32;

    fn between(steps: usize, values: usize, from: i32, to: i32, signal: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 2]> {
        let (mut interpolator, mut found) = (Interpolator::new(steps, values), Vec::new());
        for k in from..=to {
            found.extend(interpolator.push(&[signal(f64::from(k))], InstructionSet::best()));
        }
        found
    }

    /// Polynomials of degree 7 come out as they are, at the right times.
    #[test]
    fn polynomials_are_met_on_the_other_grid() {
        let signal = |t: f64| [1.0 + t, (0.1 * t - 1.0).powi(7)];
        for (steps, values) in [(1, 2), (2, 3), (4, 5), (4, 7), (1, 1)] {
            let found = between(steps, values, -DELAY, 20 + DELAY, signal);
            assert!(found.len() > 20 * values / steps);
            for (j, found) in found.iter().enumerate() {
                let exact = signal(j as f64 * steps as f64 / values as f64);
                let off = (0..2).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "{steps} to {values}, value {j}: {off:e}");
            }
        }
    }

    /// A course knows polynomials of degree 7 between its samples, from one-sided neighbours at its ends, straight lines in its other
    /// numbers, and what four samples follow.
    #[test]
    fn a_course_is_known_between_its_samples() {
        let (begin, step) = (0.3, 0.7);
        let signal = |t: f64| [(0.1 * t - 1.0).powi(7), 2.0 - 3.0 * t];
        let mut course = Course::new(2);
        assert_eq!((course.end(), course.known()), (None, None));
        for samples in 1..=100 {
            let last = begin + step * f64::from(samples - 1);
            course.push(last, signal(last).into_iter());
            assert_eq!(course.end(), Some(last));
            assert!(course.known().is_none_or(|known| (known - (last - 3.0 * step)).abs() < 1e-9));
            assert_eq!(course.known().is_some(), samples > 3);
            let points = f64::from(samples.min(8));
            for back in [0.0, 0.25, 1.0, 2.6, 3.9].into_iter().filter(|back| *back <= points - 1.0) {
                let (time, mut found) = (last - back * step, [0.0; 2]);
                course.at(time, 1, &mut found);
                let [smooth, straight] = signal(time);
                assert!((found[1] - straight).abs() < 1e-9, "{samples} {back}");
                assert!(samples < 8 || (found[0] - smooth).abs() < 1e-8 * smooth.abs().max(1.0), "{samples} {back}");
            }
        }
        course.clear();
        assert_eq!((course.end(), course.known()), (None, None));
    }

    #[test]
    fn tones_keep_their_height() {
        for (samples_a_period, most) in [(8.0, 7e-4), (12.0, 3e-5)] {
            let phase = |t: f64| std::f64::consts::TAU * t / samples_a_period;
            let found = between(1, 2, -DELAY, 200, |t| [phase(t).cos(), phase(t).sin()]);
            let worst = found.iter().map(|[c, s]| (c.hypot(*s) - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < most, "{samples_a_period}: {worst:e}");
        }
    }

    /// The first frame also stands for the time before it.
    #[test]
    fn a_signal_without_a_past_begins_with_its_first_frame() {
        let (mut interpolator, mut found) = (Interpolator::new(2, 3), Vec::new());
        interpolator.prime(&[5.0]);
        for _ in 0..=Interpolator::<1>::DELAY {
            found.extend(interpolator.push(&[[5.0]], InstructionSet::best()).iter().map(|value| value[0]));
        }
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|value: &f64| (value - 5.0).abs() < 1e-14));
    }
}
