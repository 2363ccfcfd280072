//! Waterfalls: spectra over speed. One by frequency has windows of equal time, one by order blocks of equal angle.

use super::blocks::{BlockSpectra, Middle, Middles};
use super::resample::AngleResampler;
use super::rotations::Rotations;
use super::settings::{OrderSettings, hop, rows};
use crate::numerics::spectrum::Spectrum;

/// A row of a waterfall.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub middle: Middle,
    pub spectrum: Spectrum,
}

/// Rows by order.
#[derive(Debug, Clone)]
pub struct OrderRows {
    settings: OrderSettings,
    resampler: AngleResampler,
    spectra: BlockSpectra,
    middles: Middles,
    turns: f64,
}

impl OrderRows {
    pub fn new(settings: OrderSettings) -> Self {
        let per_turn = settings.samples_per_turn();
        Self {
            resampler: AngleResampler::new(per_turn),
            spectra: BlockSpectra::new(settings.samples_per_block(), settings.overlap, per_turn as f64),
            middles: Middles::new(&settings),
            turns: 0.0,
            settings,
        }
    }

    /// Passes the next value, `step` [s] after the last; `emit` receives the rows that are complete.
    pub fn push(&mut self, at: &Rotations, step: f64, value: f64, mut emit: impl FnMut(Row)) {
        self.middles.pass(at);
        let reference = at.of(self.settings.reference);
        self.turns = reference.turns;
        let (spectra, middles) = (&mut self.spectra, &mut self.middles);
        let bins = self.settings.bins();
        self.resampler
            .push(reference, step, value, |sample| row(spectra, middles, bins, sample).into_iter().for_each(&mut emit));
    }

    /// The rows that the last values complete.
    pub fn finish(self, mut emit: impl FnMut(Row)) {
        let (mut spectra, mut middles, bins) = (self.spectra, self.middles, self.settings.bins());
        let pass = |sample| row(&mut spectra, &mut middles, bins, sample).into_iter().for_each(&mut emit);
        self.resampler.finish(self.turns, pass);
    }
}

/// The row that a sample completes, up to the highest order.
fn row(spectra: &mut BlockSpectra, middles: &mut Middles, bins: usize, sample: f64) -> Option<Row> {
    let mut spectrum = spectra.push(sample)?;
    spectrum.amplitude.truncate(bins);
    Some(Row { middle: middles.take()?, spectrum })
}

/// Windows of a waterfall by frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeWindows {
    /// Values in a window.
    pub length: usize,
    /// Share of a window that the next one repeats [-].
    pub overlap: f64,
    /// Time between values [s].
    pub step: f64,
    /// Highest frequency [Hz].
    pub max_frequency: f64,
}

impl TimeWindows {
    /// Bins of a window, from 0 Hz to the highest frequency.
    pub fn bins(&self) -> usize {
        ((self.max_frequency * self.window() + 1e-9).floor() as usize).min(self.length / 2) + 1
    }

    /// Length of a window [s].
    pub fn window(&self) -> f64 {
        self.length as f64 * self.step
    }

    /// Whole windows within a number of values.
    pub fn rows(&self, values: usize) -> usize {
        rows(values, self.length, hop(self.length, self.overlap))
    }
}

/// Length of a window [s] in which the reference order moves by one bin while the speed changes by `slope` [Hz/s]: a longer one smears its
/// line, a shorter one widens it. Infinite at a constant speed.
pub fn sharpest_window(order: f64, slope: f64) -> f64 {
    (order * slope).sqrt().recip()
}

/// Bins by which an order moves within a window [s] while the speed changes by `slope` [Hz/s].
pub fn smear_bins(order: f64, slope: f64, window: f64) -> f64 {
    order * slope * window * window
}

/// Rows by frequency.
#[derive(Debug, Clone)]
pub struct TimeRows {
    windows: TimeWindows,
    spectra: BlockSpectra,
    /// Numbers of the next value and of the middle of the next row.
    passed: usize,
    next: usize,
    middles: std::collections::VecDeque<Middle>,
}

impl TimeRows {
    pub fn new(windows: TimeWindows) -> Self {
        let spectra = BlockSpectra::new(windows.length, windows.overlap, windows.step.recip());
        Self { spectra, passed: 0, next: windows.length / 2, middles: Default::default(), windows }
    }

    /// Passes the next value; the row that it completes.
    pub fn push(&mut self, at: &Rotations, value: f64) -> Option<Row> {
        if self.passed == self.next {
            self.middles.push_back(Middle { time: at.time, speed: at.shaft.speed });
            self.next += hop(self.windows.length, self.windows.overlap);
        }
        self.passed += 1;
        let mut spectrum = self.spectra.push(value)?;
        spectrum.amplitude.truncate(self.windows.bins());
        Some(Row { middle: self.middles.pop_front()?, spectrum })
    }
}
