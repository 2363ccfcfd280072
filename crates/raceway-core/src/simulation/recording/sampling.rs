//! Rates, bands and channels of what is kept.

use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::input::settings::Outputs;

/// Rate at which signals are kept [Hz].
pub const RATE: f64 = 102_400.0;
/// Upper end of the band in which vibration is judged [Hz].
pub const BAND: f64 = 20_000.0;
/// Band whose envelope is analysed [Hz]: above the shaft and ball-pass lines, where impacts ring.
pub(crate) const ENVELOPE_BAND: (f64, f64) = (2_000.0, 20_000.0);
/// Batches of a run, by which its level scatters and settles.
pub(crate) const BATCHES: usize = 10;
/// Stretch that is repeated at a tighter tolerance [s], where disturbances die out and nothing else than at its beginning
/// is to come; else all of the run.
pub(crate) const REPEATED: f64 = 0.01;
/// What levels are made of; along X where the spindle moves there.
pub(crate) const ACCELERATIONS: [Channel; 3] = [
    Channel::Spindle(Axis::X, Motion::Acceleration),
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
];

/// Number of values kept of a channel over a duration [s]; at least one.
pub fn kept_values(duration: f64) -> usize {
    ((duration * RATE).round() as usize).max(1)
}

/// Channels besides the spindle's that the outputs need, kept as they stand; `cage`: whether there is one.
pub fn picked_channels(outputs: &Outputs, cage: bool) -> Vec<Channel> {
    let orbit = [Channel::CageDisplacement(Axis::Y), Channel::CageDisplacement(Axis::Z)];
    let mut picked: Vec<Channel> = if outputs.cage && cage { orbit.to_vec() } else { Vec::new() };
    for &channel in outputs.spectra.iter().chain(&outputs.series) {
        if !matches!(channel, Channel::Spindle(..)) && !picked.contains(&channel) {
            picked.push(channel);
        }
    }
    picked
}
