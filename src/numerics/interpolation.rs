//! Samples between samples: signals at other times of an even grid.

use super::lanes::{InstructionSet, Task};

/// Samples that a value is taken from.
const POINTS: usize = 8;

/// Takes frames of `N` signals at even times and gives `values` frames, evenly spaced, to every `steps` of them, by the polynomial
/// through the four samples on either side (Lagrange). Halfway between two samples, where it is worst, a tone comes out lower by
/// 6·10⁻⁴ of itself at eight samples a period, by 2·10⁻⁵ at twelve.
#[derive(Debug, Clone)]
pub struct Interpolator<const N: usize> {
    steps: usize,
    values: usize,
    /// Of values 0 … `values` − 1 parts of a sample beyond one.
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
    pub const DELAY: usize = POINTS / 2;

    pub fn new(steps: usize, values: usize) -> Self {
        let weights = (0..values).map(|part| lagrange(part as f64 / values as f64)).collect();
        // As if it had begun a frame earlier, with a value that nobody sees.
        Self { steps, values, weights, frames: Vec::new(), next: values, known: Vec::new() }
    }

    /// Takes `frame` as having stood still until now: the first value then belongs to the first frame pushed from here.
    pub fn prime(&mut self, frame: &[f64; N]) {
        self.frames = vec![*frame; POINTS / 2];
    }

    /// Takes frames; the values that they make known, by these instructions.
    pub fn push(&mut self, frames: &[[f64; N]], instructions: InstructionSet) -> &[[f64; N]] {
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
fn lagrange(x: f64) -> [f64; POINTS] {
    let node = |i: usize| i as f64 - (POINTS / 2 - 1) as f64;
    std::array::from_fn(|i| {
        let others = (0..POINTS).filter(|other| *other != i);
        others.map(|other| (x - node(other)) / (node(i) - node(other))).product()
    })
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

    #[test]
    fn tones_keep_their_height() {
        for (samples_a_period, most) in [(8.0, 7e-4), (12.0, 3e-5)] {
            let phase = |t: f64| std::f64::consts::TAU * t / samples_a_period;
            let found = between(1, 2, -DELAY, 200, |t| [phase(t).cos(), phase(t).sin()]);
            let worst = found.iter().map(|[c, s]| (c.hypot(*s) - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < most, "{samples_a_period}: {worst:e}");
        }
    }

    /// What stood still before the first frame counts as its past.
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
