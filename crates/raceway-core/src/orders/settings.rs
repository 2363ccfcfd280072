//! Settings of an order analysis, and the sizes that follow from them.

/// Body whose turns an order counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reference {
    #[default]
    Shaft,
    /// The simulated cage: the ball passage over the outer raceway is then exactly order Z, whatever the slip.
    Cage,
}

/// Settings of an order analysis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderSettings {
    pub reference: Reference,
    /// Highest order [-].
    pub max_order: f64,
    /// Turns of the reference in a block; the order resolution is its reciprocal.
    pub turns_per_block: usize,
    /// Share of a block that the next one repeats [-].
    pub overlap: f64,
}

/// Ratio of the sampling rate to the highest frequency that an analysis uses [-]: what a practical filter passes without aliases.
pub const SAMPLES_PER_PERIOD: f64 = 2.56;
/// Largest number of bins of a waterfall; they take 16 MB.
pub const MOST_BINS: usize = 4_000_000;

impl OrderSettings {
    /// Samples in a turn: the next power of two from 2.56 times the highest order on.
    pub fn samples_per_turn(&self) -> usize {
        ((SAMPLES_PER_PERIOD * self.max_order).ceil() as usize).next_power_of_two()
    }

    /// Samples in a block.
    pub fn samples_per_block(&self) -> usize {
        self.turns_per_block.saturating_mul(self.samples_per_turn())
    }

    /// Samples from the start of a block to that of the next one.
    pub(super) fn samples_per_hop(&self) -> usize {
        hop(self.samples_per_block(), self.overlap)
    }

    /// Bins of a block, from order 0 to the highest.
    pub fn bins(&self) -> usize {
        (self.max_order * self.turns_per_block as f64 + 1e-9).floor() as usize + 1
    }

    /// Whole blocks within a number of turns.
    pub fn blocks(&self, turns: f64) -> usize {
        let samples = (turns * self.samples_per_turn() as f64).floor() as usize;
        rows(samples, self.samples_per_block(), self.samples_per_hop())
    }
}

/// Samples from the start of a block of `length` samples to that of the next one; at least one.
pub(super) fn hop(length: usize, overlap: f64) -> usize {
    ((length as f64 * (1.0 - overlap)).round() as usize).max(1)
}

/// Whole blocks within a number of samples.
pub(super) fn rows(samples: usize, length: usize, hop: usize) -> usize {
    if samples < length { 0 } else { (samples - length) / hop + 1 }
}

/// Highest order that a signal holds whose reference turns at most `fastest` [Hz], at a sampling rate [Hz].
pub fn highest_order(rate: f64, fastest: f64) -> f64 {
    rate / (SAMPLES_PER_PERIOD * fastest)
}
