//! Sampling rate, frequency bands and channels of a recording.

use crate::simulation::input::channel::{Axis, Channel, Motion};
use crate::simulation::input::settings::Outputs;

/// Sampling rate of recorded signals [Hz].
pub const RATE: f64 = 102_400.0;
/// Upper end of the frequency band of vibration levels [Hz].
pub const BAND: f64 = 20_000.0;
/// Number of batches of a window, for batch means of a level.
pub(crate) const BATCHES: usize = 10;
/// Kept values of a part whose largest load and mean cage speed are noted: eight parts in 10 ms.
pub(crate) const PART: usize = 128;
/// Time that is repeated at a tighter tolerance [s], where disturbances decay and the motion stays the same. Otherwise the whole run
/// is repeated.
pub(crate) const REPEATED: f64 = 0.01;
/// Channels of the vibration levels; X exists where the spindle moves along the axis.
pub(crate) const ACCELERATIONS: [Channel; 3] = [
    Channel::Spindle(Axis::X, Motion::Acceleration),
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
];

/// Signals of the spindle in the plane of the bearing, in the order of the models that know no axial motion.
pub(crate) const SPINDLE_IN_PLANE: [Channel; 6] = [
    Channel::Spindle(Axis::Y, Motion::Displacement),
    Channel::Spindle(Axis::Z, Motion::Displacement),
    Channel::Spindle(Axis::Y, Motion::Velocity),
    Channel::Spindle(Axis::Z, Motion::Velocity),
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
];

/// Number of recorded values of a channel over a duration [s]; at least one.
pub(crate) fn kept_values(duration: f64) -> usize {
    ((duration * RATE).round() as usize).max(1)
}

/// Channels other than the spindle's that the outputs need, recorded without a filter; `cage`: whether the model has a cage.
pub(crate) fn picked_channels(outputs: &Outputs, cage: bool) -> Vec<Channel> {
    let orbit = [Channel::CageDisplacement(Axis::Y), Channel::CageDisplacement(Axis::Z)];
    let mut picked: Vec<Channel> = if outputs.cage && cage { orbit.to_vec() } else { Vec::new() };
    for &channel in outputs.spectra.iter().chain(&outputs.series) {
        if !matches!(channel, Channel::Spindle(..)) && !picked.contains(&channel) {
            picked.push(channel);
        }
    }
    picked
}
