//! Order tracks: amplitude of an order over speed, block by block.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::blocks::{Middle, Middles};
use super::rotations::{Combination, Rotations};
use super::settings::OrderSettings;

/// Amplitudes of the tracked orders in one block.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackPoint {
    pub middle: Middle,
    /// Amplitude of each order.
    pub amplitudes: Vec<f64>,
}

/// Sums over a block that is not complete.
#[derive(Debug, Clone)]
struct Block {
    /// Turns at its start.
    start: f64,
    weight: f64,
    sums: Vec<Complex64>,
}

/// Tracker of several orders. The amplitude in a block is the sum of signal · Hann window · e^(−2πi·turns of the order) over the angle,
/// divided by half the sum of the window.
#[derive(Debug, Clone)]
pub struct OrderTracker {
    settings: OrderSettings,
    orders: Vec<Combination>,
    /// Turns from one block to the next, and of a block.
    hop: f64,
    length: f64,
    next: f64,
    active: VecDeque<Block>,
    middles: Middles,
}

impl OrderTracker {
    pub fn new(settings: OrderSettings, orders: Vec<Combination>) -> Self {
        Self {
            hop: settings.samples_per_hop() as f64 / settings.samples_per_turn() as f64,
            length: settings.turns_per_block as f64,
            middles: Middles::new(&settings),
            settings,
            orders,
            next: 0.0,
            active: VecDeque::new(),
        }
    }

    /// Passes the next value, `step` [s] after the last; `emit` receives the blocks that are complete.
    pub fn push(&mut self, at: &Rotations, step: f64, value: f64, mut emit: impl FnMut(TrackPoint)) {
        self.middles.pass(at);
        let reference = at.of(self.settings.reference);
        while reference.turns >= self.next {
            self.active.push_back(Block {
                start: self.next,
                weight: 0.0,
                sums: vec![Complex64::ZERO; self.orders.len()],
            });
            self.next += self.hop;
        }
        while let Some(block) = self.active.front()
            && reference.turns >= block.start + self.length
            && let (Some(middle), Some(block)) = (self.middles.take(), self.active.pop_front())
        {
            let amplitude = |sum: &Complex64| 2.0 * sum.norm_sqr().sqrt() / block.weight;
            emit(TrackPoint { middle, amplitudes: block.sums.iter().map(amplitude).collect() });
        }
        let turned = reference.speed * step;
        for (number, order) in self.orders.iter().enumerate() {
            let turns = order.turns(at);
            let wave = turned * value * Complex64::cis(-TAU * turns.fract());
            for block in &mut self.active {
                block.sums[number] += hann((reference.turns - block.start) / self.length) * wave;
            }
        }
        for block in &mut self.active {
            block.weight += turned * hann((reference.turns - block.start) / self.length);
        }
    }
}

/// Hann window at a share of its length.
fn hann(share: f64) -> f64 {
    if (0.0..=1.0).contains(&share) { 0.5 - 0.5 * (TAU * share).cos() } else { 0.0 }
}

/// Pairs of orders that lie closer than 2 over the turns of a block, so that their tracks beat.
pub fn beating(orders: &[f64], turns_per_block: usize) -> Vec<(usize, usize)> {
    let closest = 2.0 / turns_per_block as f64;
    let pairs = (0..orders.len()).flat_map(|one| (one + 1..orders.len()).map(move |other| (one, other)));
    pairs.filter(|&(one, other)| (orders[one] - orders[other]).abs() < closest).collect()
}
