//! Decimation of sampled signals.

use std::f64::consts::TAU;

use super::special::{kaiser, kaiser_beta, kaiser_length, sinc};

/// Keeps every `factor`-th frame of several signals side by side, behind a low-pass filter.
///
/// The filter is a symmetric FIR (Kaiser window): the delay is constant and no phase is bent. Its edges depend on the
/// output rate f. Up to 0.1953 f the gain is 1 within 1e-4. From 0.8047 f, which would fold into that band, it is below
/// −80 dB. Example from 409.6 kHz to 102.4 kHz, a factor of 4: flat to 20 kHz and −80 dB from 82.4 kHz; between 20 and
/// 51.2 kHz the gain falls to ½.
///
/// Time: the first output comes from a full filter, so there is no transient. The output frame `j` belongs to the input
/// frame `delay() + j·factor`, counted from 0. Push `delay()` frames ahead of the first one wanted (or `prime`) and as
/// many after the last.
#[derive(Debug, Clone)]
pub(crate) struct Decimator {
    factor: usize,
    channels: usize,
    taps: Vec<f64>,
    /// The last `taps.len()` frames, written twice so that they always lie in a row.
    history: Vec<f64>,
    /// Place of the next frame, which is that of the oldest one.
    next: usize,
    /// Frames to wait for until the next output.
    wait: usize,
    output: Vec<f64>,
}

impl Decimator {
    /// Highest frequency passed unchanged, as a share of the output rate.
    const PASS: f64 = 20.0 / 102.4;
    /// Attenuation the filter is designed for [dB]: the promised 80 with a margin.
    const ATTENUATION: f64 = 86.0;

    /// For frames of `channels` signals. A factor of 0 or 1 passes every frame as it is.
    pub(crate) fn new(factor: usize, channels: usize) -> Self {
        let factor = factor.max(1);
        let taps = low_pass(factor, Self::PASS, Self::ATTENUATION);
        Self {
            factor,
            channels,
            history: vec![0.0; 2 * taps.len() * channels],
            next: 0,
            wait: taps.len(),
            output: vec![0.0; channels],
            taps,
        }
    }

    /// Delay of the output: input frames from the middle of the filter to its end.
    pub(crate) fn delay(&self) -> usize {
        self.taps.len() / 2
    }

    /// Treats `frame` as constant until now. The output frame `j` then belongs to the `j·factor`-th frame pushed from
    /// here.
    pub(crate) fn prime(&mut self, frame: &[f64]) {
        self.wait = self.taps.len();
        for _ in 0..self.delay() {
            self.push(frame);
        }
    }

    /// Takes one frame; gives one out after every `factor`-th, once the filter is full.
    ///
    /// # Panics
    /// When the frame does not have one value a channel.
    pub(crate) fn push(&mut self, frame: &[f64]) -> Option<&[f64]> {
        let length = self.taps.len();
        for copy in [self.next, self.next + length] {
            self.history[copy * self.channels..(copy + 1) * self.channels].copy_from_slice(frame);
        }
        self.next = (self.next + 1) % length;
        self.wait -= 1;
        if self.wait > 0 {
            return None;
        }
        self.wait = self.factor;
        let frames = &self.history[self.next * self.channels..];
        if self.channels == 6 {
            // A spindle in a plane: the same sums, in registers.
            self.output.copy_from_slice(&weighed::<6>(&self.taps, frames));
            return Some(&self.output);
        }
        self.output.fill(0.0);
        if self.channels > 0 {
            let frames = frames.chunks_exact(self.channels);
            for (tap, frame) in self.taps.iter().zip(frames) {
                for (sum, value) in self.output.iter_mut().zip(frame) {
                    *sum += tap * value;
                }
            }
        }
        Some(&self.output)
    }
}

/// Sum of frames of `N` values, each times its tap.
fn weighed<const N: usize>(taps: &[f64], frames: &[f64]) -> [f64; N] {
    let mut sums = [0.0; N];
    let (frames, _) = frames.as_chunks::<N>();
    for (tap, frame) in taps.iter().zip(frames) {
        for (sum, value) in sums.iter_mut().zip(frame) {
            *sum += tap * value;
        }
    }
    sums
}

/// Symmetric low-pass of gain 1 under a Kaiser window that passes `pass` and stops 1 − `pass`, both as shares of the output rate.
fn low_pass(factor: usize, pass: f64, attenuation: f64) -> Vec<f64> {
    if factor == 1 {
        return vec![1.0];
    }
    let transition = TAU * (1.0 - 2.0 * pass) / factor as f64;
    let half = (kaiser_length(attenuation, transition) / 2.0).ceil() as i64;
    let beta = kaiser_beta(attenuation);
    let mut taps: Vec<f64> = (-half..=half)
        .map(|i| {
            let x = i as f64 / half as f64;
            // The middle of the transition is half the output rate.
            kaiser(beta, x) * sinc(i as f64 / factor as f64)
        })
        .collect();
    let gain: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|tap| *tap /= gain);
    taps
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 102_400.0;

    /// Gain of a decimator's filter at a frequency given as a share of the output rate.
    fn gain(decimator: &Decimator, share: f64) -> f64 {
        let middle = decimator.delay() as f64;
        let phase = |i: usize| TAU * share * (i as f64 - middle) / decimator.factor as f64;
        decimator.taps.iter().enumerate().map(|(i, tap)| tap * phase(i).cos()).sum()
    }

    #[test]
    fn decimator_is_flat_in_its_band_and_stops_what_would_fold_into_it() {
        for factor in [2, 3, 4, 8] {
            let decimator = Decimator::new(factor, 1);
            for step in 0..=1000 {
                let share = step as f64 / 1000.0;
                assert!(
                    (gain(&decimator, share * Decimator::PASS) - 1.0).abs() < 1e-4,
                    "factor {factor}, pass {share}"
                );
                let stopped = 1.0 - Decimator::PASS;
                let above = stopped + share * (0.5 * factor as f64 - stopped);
                assert!(
                    gain(&decimator, above).abs() < 1e-4,
                    "factor {factor}, stop at {above}: {}",
                    gain(&decimator, above)
                );
            }
        }
    }

    #[test]
    fn decimated_frames_belong_to_the_stated_input_frames() {
        let mut decimator = Decimator::new(4, 2);
        let (delay, rate) = (decimator.delay(), 4.0 * RATE);
        let value = |i: usize| [(TAU * 2293.0 * i as f64 / rate).sin(), 3.0 + (TAU * 19_900.0 * i as f64 / rate).cos()];
        let mut frames = 0;
        for i in 0..4000 {
            if let Some(frame) = decimator.push(&value(i)) {
                let expected = value(delay + 4 * frames);
                assert!((frame[0] - expected[0]).abs() < 1e-4 && (frame[1] - expected[1]).abs() < 4e-4);
                assert_eq!(i, 2 * delay + 4 * frames, "every fourth input frame gives one out");
                frames += 1;
            }
        }
        assert_eq!(frames, (4000 - 2 * delay).div_ceil(4));
    }

    #[test]
    fn primed_decimator_starts_at_the_first_frame() {
        let mut decimator = Decimator::new(4, 1);
        decimator.prime(&[2.0]);
        let delay = decimator.delay();
        for i in 0..200 {
            if let Some(frame) = decimator.push(&[2.0]) {
                assert!((frame[0] - 2.0).abs() < 1e-14);
                assert!((i - delay).is_multiple_of(4));
            } else {
                assert!(i < delay || !(i - delay).is_multiple_of(4));
            }
        }
    }

    #[test]
    fn factor_one_passes_every_frame() {
        let mut decimator = Decimator::new(1, 2);
        assert_eq!(decimator.delay(), 0);
        assert_eq!(decimator.push(&[1.0, 2.0]), Some(&[1.0, 2.0][..]));
        assert_eq!(decimator.push(&[3.0, 4.0]), Some(&[3.0, 4.0][..]));
    }
}
