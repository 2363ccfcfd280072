//! Blocks of equal length that overlap, of which each gives one spectrum.

use std::collections::VecDeque;

use super::rotations::Rotations;
use super::settings::{OrderSettings, Reference, hop};
use crate::numerics::spectrum::{Spectrum, amplitude_spectrum_of_part};

/// Time and shaft speed of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Middle {
    /// Time since the start of the run [s].
    pub time: f64,
    /// Shaft speed [Hz].
    pub speed: f64,
}

/// Times and shaft speeds at the middles in angle of successive blocks.
#[derive(Debug, Clone)]
pub(super) struct Middles {
    reference: Reference,
    /// Turns from one middle to the next.
    hop: f64,
    /// Turns at the next middle.
    next: f64,
    passed: VecDeque<Middle>,
}

impl Middles {
    pub fn new(settings: &OrderSettings) -> Self {
        let per_turn = settings.samples_per_turn() as f64;
        Self {
            reference: settings.reference,
            hop: settings.samples_per_hop() as f64 / per_turn,
            next: 0.5 * settings.turns_per_block as f64,
            passed: VecDeque::new(),
        }
    }

    pub fn pass(&mut self, at: &Rotations) {
        while at.of(self.reference).turns >= self.next {
            self.passed.push_back(Middle { time: at.time, speed: at.shaft.speed });
            self.next += self.hop;
        }
    }

    /// Middle of the next block in their order.
    pub fn take(&mut self) -> Option<Middle> {
        self.passed.pop_front()
    }
}

/// Spectra of successive blocks of a signal under a Hann window.
#[derive(Debug, Clone)]
pub(super) struct BlockSpectra {
    length: usize,
    hop: usize,
    /// Sampling rate: samples in a second or in a turn.
    rate: f64,
    values: VecDeque<f64>,
}

impl BlockSpectra {
    pub fn new(length: usize, overlap: f64, rate: f64) -> Self {
        Self { length, hop: hop(length, overlap), rate, values: VecDeque::with_capacity(length) }
    }

    /// Passes the next value; the spectrum of a block that it completes.
    pub fn push(&mut self, value: f64) -> Option<Spectrum> {
        self.values.push_back(value);
        if self.values.len() < self.length {
            return None;
        }
        let spectrum = amplitude_spectrum_of_part(self.values.make_contiguous(), self.rate);
        self.values.drain(..self.hop);
        Some(spectrum)
    }
}
