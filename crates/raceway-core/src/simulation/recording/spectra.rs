//! Spectra of one recorded channel.

use crate::numerics::spectrum::{EnvelopeAnalysis, Spectrum, amplitude_and_envelope};
use crate::simulation::input::channel::Channel;
use crate::simulation::recording::sampling::RATE;

/// Spectra of one channel, in the channel's unit; of a squared envelope, in its square.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSpectra {
    pub channel: Channel,
    pub amplitude: Spectrum,
    pub envelope: Spectrum,
}

impl ChannelSpectra {
    /// Spectra of a signal [SI], and of its envelope.
    pub fn of(channel: Channel, signal: &[f64], analysis: EnvelopeAnalysis) -> Self {
        let signal: Vec<f64> = signal.iter().map(|value| channel.scale() * value).collect();
        let (amplitude, envelope) = amplitude_and_envelope(&signal, RATE, analysis);
        Self { channel, amplitude, envelope }
    }

    /// Averages these spectra with those of a further window.
    pub fn join(&mut self, other: &Self) {
        self.amplitude.join(&other.amplitude);
        self.envelope.join(&other.envelope);
    }
}
