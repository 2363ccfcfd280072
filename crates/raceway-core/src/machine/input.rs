//! Input of a machine: a shaft, its bearings with all that moves in them, and sensors.

use std::f64::consts::TAU;

use crate::physics::operation::SpeedProfile;
use crate::rotor::input::{Rotor, RotorError};
pub use crate::rotor::sensor::{Part, Sensor};
use crate::simulation::input::scene::Scene;
use crate::simulation::model::failure::SimulationError;

/// A shaft on ball bearings, and the points at which its motion is recorded.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Shaft, supports, loads, and the place of each bearing. Its speed is the first of `speed`.
    pub rotor: Rotor,
    /// Balls, cage, lubricant and surfaces of each bearing of the rotor, in their order.
    pub bearings: Vec<MachineBearing>,
    pub speed: SpeedProfile,
    pub sensors: Vec<Sensor>,
    /// Names of the bodies of the rotor's housing, in their order.
    pub bodies: Vec<String>,
}

/// What moves in a bearing.
#[derive(Debug, Clone)]
pub struct MachineBearing {
    /// Name in channels and labels.
    pub name: String,
    /// The bearing alone. Its spindle and its loads do not count: the shaft replaces them.
    pub scene: Scene,
    /// Azimuth at which its first ball starts [rad].
    pub start_azimuth: f64,
}

/// Reason why a run has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MachineError {
    #[error(transparent)]
    Rotor(#[from] RotorError),
    #[error("bearing {bearing}: {source}")]
    Bearing { bearing: usize, source: SimulationError },
    /// The motion has left every physical range.
    #[error("the motion diverges at t = {time:.6} s; {cause}")]
    Diverged { time: f64, cause: &'static str },
    /// A motion grows by itself, so that levels would depend on the recorded time. Speeds [rad/s]: the lowest and the highest at which it does.
    #[error("a motion grows by {rate:.3} 1/s {}: {cause}", at_speeds(.speeds))]
    Grows { rate: f64, speeds: [f64; 2], cause: &'static str },
    /// More modes of the shaft lie in the range than a run can carry.
    #[error("the shaft has more than {0} modes in the range; give a lower mode_range")]
    TooManyModes(usize),
    /// The caller no longer wants the result.
    #[error("stopped at t = {0:.6} s")]
    Stopped(f64),
}

fn at_speeds(speeds: &[f64; 2]) -> String {
    let [from, to] = speeds.map(|speed| 60.0 * speed / TAU);
    if from == to { format!("at {from:.0} r/min") } else { format!("between {from:.0} and {to:.0} r/min") }
}
