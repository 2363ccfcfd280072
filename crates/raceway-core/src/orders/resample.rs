//! Resampling from equal times to equal angles behind a low-pass filter in angle.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::rotations::Rotation;
use super::settings::SAMPLES_PER_PERIOD;
use crate::numerics::special::{kaiser, kaiser_beta, kaiser_length, sinc};

/// Attenuation of orders that would fold into the analysed ones [dB]: the promised 80 with a margin.
const ATTENUATION: f64 = 86.0;
/// Entries of the filter's table in a sample of the output; the linear interpolation between them is exact to 10⁻⁵ of the peak.
const ENTRIES: usize = 512;

/// A signal at equal angles. The value at an angle is the integral of the signal times the filter over all angles, as a sum over the values
/// at equal times. The filter passes orders up to the highest and stops, by 80 dB, those that would fold into them.
///
/// The sum has the accuracy of the integral: the images of the signal about the sampling rate, as orders, are beyond the edge of the filter
/// wherever `max_order` is at most [`highest_order`](super::settings::highest_order).
#[derive(Debug, Clone)]
pub struct AngleResampler {
    /// Output samples in a turn.
    per_turn: f64,
    /// Half the length of the filter in output samples.
    half: f64,
    /// Filter from its middle to its end, and a zero.
    filter: Vec<f64>,
    /// Number of the first output sample that is not complete.
    first: usize,
    pending: VecDeque<f64>,
}

impl AngleResampler {
    pub fn new(samples_per_turn: usize) -> Self {
        // From 1/2.56 of the output rate to 1 − 1/2.56; the middle is half the rate.
        let transition = TAU * (1.0 - 2.0 / SAMPLES_PER_PERIOD);
        let half = 0.5 * kaiser_length(ATTENUATION, transition).ceil();
        let beta = kaiser_beta(ATTENUATION);
        let entries = (half * ENTRIES as f64) as usize;
        let entry = |k: usize| kaiser(beta, k as f64 / entries as f64) * sinc(k as f64 / ENTRIES as f64);
        let filter = (0..=entries).map(entry).chain([0.0]).collect();
        Self { per_turn: samples_per_turn as f64, half, filter, first: 0, pending: VecDeque::new() }
    }

    /// Passes the next value, `step` [s] after the last; `emit` receives the output samples that are complete.
    pub fn push(&mut self, at: Rotation, step: f64, value: f64, mut emit: impl FnMut(f64)) {
        let place = at.turns * self.per_turn;
        let weighted = value * at.speed * step * self.per_turn;
        let begin = ((place - self.half).ceil() as usize).max(self.first);
        let end = (place + self.half).floor();
        while ((self.first + self.pending.len()) as f64) <= end {
            self.pending.push_back(0.0);
        }
        for (sample, sum) in (begin..).zip(self.pending.range_mut(begin - self.first..)) {
            let entry = (sample as f64 - place).abs() * ENTRIES as f64;
            let (below, share) = (entry as usize, entry.fract());
            if let [low, high] = self.filter[below.min(self.filter.len() - 2)..][..2] {
                *sum += weighted * (low + share * (high - low));
            }
        }
        while place - self.half > self.first as f64
            && let Some(sample) = self.pending.pop_front()
        {
            self.first += 1;
            emit(sample);
        }
    }

    /// The output samples up to the last angle, whose filters are cut there.
    pub fn finish(self, turns: f64, emit: impl FnMut(f64)) {
        let left = (turns * self.per_turn + 1e-6).floor() - self.first as f64;
        self.pending.into_iter().take(left.max(0.0) as usize).for_each(emit);
    }
}
