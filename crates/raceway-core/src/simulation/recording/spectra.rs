//! Spectra of one recorded channel.

use crate::numerics::spectrum::{Spectrum, amplitude_spectrum, envelope_spectrum};
use crate::simulation::input::channel::Channel;
use crate::simulation::recording::sampling::{ENVELOPE_BAND, RATE};

/// Spectra of one channel, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSpectra {
    pub channel: Channel,
    pub amplitude: Spectrum,
    pub envelope: Spectrum,
}

impl ChannelSpectra {
    /// Of a signal [SI].
    pub fn of(channel: Channel, signal: &[f64]) -> Self {
        let signal: Vec<f64> = signal.iter().map(|value| channel.scale() * value).collect();
        Self {
            channel,
            amplitude: amplitude_spectrum(&signal, RATE),
            envelope: envelope_spectrum(&signal, RATE, ENVELOPE_BAND),
        }
    }

    pub fn join(&mut self, other: &Self) {
        self.amplitude.join(&other.amplitude);
        self.envelope.join(&other.envelope);
    }
}
