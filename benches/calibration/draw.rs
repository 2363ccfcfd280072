//! Random numbers for scenes, the same on every machine.

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// A sequence of draws.
pub struct Draw(SplitMix64);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::seed_from_u64(seed))
    }

    /// A number in 0 … 1.
    pub fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    pub fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.share() * all.len() as f64) as usize]
    }

    /// A number of three digits, uniform between two ends.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        three_digits(from + (to - from) * self.share())
    }

    /// A number of three digits whose logarithm is uniform between those of two ends.
    pub fn between_decades(&mut self, from: f64, to: f64) -> f64 {
        three_digits(from * (to / from).powf(self.share()))
    }
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().expect("a number")
}

/// The numbers among the words of a command: seed and count of the scenes.
pub fn seed_and_count(words: &[String], count: usize) -> (u64, usize) {
    let numbers: Vec<u64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    (numbers.first().copied().unwrap_or(1), numbers.get(1).map_or(count, |count| *count as usize))
}

/// True where a word is among those of a command.
pub fn has(words: &[String], option: &str) -> bool {
    words.iter().any(|word| word == option)
}
