//! Spectra of a measured record, as a prediction has them.

use super::tachometer::Tachometer;
use crate::numerics::resampling::{PASS, Resampler};
use crate::numerics::spectrum::{EnvelopeAnalysis, Spectrum, amplitude_and_envelope, amplitude_spectrum};
use crate::simulation::recording::sampling::RATE;

/// Turns of the measured shaft.
#[derive(Debug, Clone, PartialEq)]
pub enum Turning {
    /// At a constant speed [Hz].
    Even(f64),
    Pulses(Tachometer),
}

/// A measured signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Record<'a> {
    pub values: &'a [f64],
    /// Values per second [Hz].
    pub rate: f64,
    pub turning: Turning,
}

/// Division of a prediction into windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division {
    /// Values of a window at the rate of the prediction.
    pub length: usize,
    /// Windows whose power is averaged.
    pub count: usize,
    pub envelope: Option<EnvelopeAnalysis>,
}

impl Division {
    /// The division behind a spectrum of a resolution [Hz].
    pub fn of(resolution: f64, count: usize, envelope: Option<EnvelopeAnalysis>) -> Self {
        Self { length: (RATE / resolution).round() as usize, count: count.max(1), envelope }
    }
}

/// Spectra of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredSpectra {
    pub amplitude: Spectrum,
    pub envelope: Option<Spectrum>,
}

impl Turning {
    /// Mean speed [Hz].
    pub fn speed(&self) -> f64 {
        match self {
            Self::Even(speed) => *speed,
            Self::Pulses(tachometer) => tachometer.mean_speed(),
        }
    }
}

impl Record<'_> {
    /// Highest frequency that is passed unchanged [Hz]: 0.4 times the lower rate of record and prediction. Where the shaft is slower than on
    /// average, resampling by angle stretches the record, whose rate counts as lower there.
    pub fn highest_frequency(&self) -> f64 {
        let stretched = match &self.turning {
            Turning::Even(_) => 1.0,
            Turning::Pulses(tachometer) => (tachometer.lowest_speed() / tachometer.mean_speed()).min(1.0),
        };
        PASS * self.rate.min(RATE) * stretched
    }

    /// Duration that windows may cover [s]; with a tachometer from its first to its last pulse within the record.
    pub fn duration(&self) -> f64 {
        match &self.turning {
            Turning::Even(_) => self.values.len() as f64 / self.rate,
            Turning::Pulses(tachometer) => tachometer.turns() / tachometer.mean_speed(),
        }
    }

    /// Number of windows that the record fills, at most those of the division.
    pub fn windows(&self, division: &Division) -> usize {
        // A record at the rate of the prediction has whole values.
        let values = (self.duration() * RATE + 1e-6).floor() as usize;
        (values / division.length.max(1)).min(division.count)
    }

    /// Spectra of the windows that the record fills; `None` without one, or where `stop` returns true. With a tachometer equal steps of angle
    /// take the place of equal times: a frequency is an order times the mean speed.
    pub fn spectra(&self, division: &Division, stop: &dyn Fn() -> bool) -> Option<MeasuredSpectra> {
        let resampler = Resampler::new(self.values, RATE / self.rate);
        let speed = self.turning.speed();
        let place = |k: usize| {
            let time = k as f64 / RATE;
            self.rate
                * match &self.turning {
                    Turning::Even(_) => time,
                    Turning::Pulses(tachometer) => tachometer.time(time * speed),
                }
        };
        let mut all: Option<MeasuredSpectra> = None;
        for window in 0..self.windows(division) {
            if stop() {
                return None;
            }
            let first = window * division.length;
            let values: Vec<f64> = (first..first + division.length).map(|k| resampler.at(place(k))).collect();
            let found = MeasuredSpectra::of(&values, division.envelope);
            match &mut all {
                None => all = Some(found),
                Some(all) => all.join(&found),
            }
        }
        all
    }
}

impl MeasuredSpectra {
    /// Spectra of one window.
    fn of(values: &[f64], envelope: Option<EnvelopeAnalysis>) -> Self {
        match envelope {
            Some(analysis) => {
                let (amplitude, envelope) = amplitude_and_envelope(values, RATE, analysis);
                Self { amplitude, envelope: Some(envelope) }
            }
            None => Self { amplitude: amplitude_spectrum(values, RATE), envelope: None },
        }
    }

    fn join(&mut self, other: &Self) {
        self.amplitude.join(&other.amplitude);
        if let (Some(own), Some(other)) = (&mut self.envelope, &other.envelope) {
            own.join(other);
        }
    }
}
