//! Characteristic frequencies of a bearing whose inner raceway turns and whose outer one stands.

use super::bearing::Bearing;

/// Frequencies of a running bearing [Hz]. Signed quantities are given as magnitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CharacteristicFrequencies {
    /// f_r, turns of the spindle.
    pub shaft: f64,
    /// FTF, turns of the cage.
    pub cage: f64,
    /// BPFO, balls passing a point of the outer raceway; also the varying-compliance line.
    pub ball_pass_outer: f64,
    /// BPFI, balls passing a point of the inner raceway.
    pub ball_pass_inner: f64,
    /// BSF, turns of a ball; a ball defect strikes at twice this.
    pub ball_spin: f64,
}

/// Ratio of the orbit speed of ideally rolling balls to the spindle speed, ½ (1 − γ) [-].
pub fn ideal_orbit_ratio(bearing: &Bearing) -> f64 {
    0.5 * (1.0 - bearing.gamma())
}

/// Ratio of the spin ω_x of ideally rolling balls to the spindle speed, −(D_m/2d)(1 − γ²) [-], negative
/// because a ball turns against the spindle.
pub fn ideal_spin_ratio(bearing: &Bearing) -> f64 {
    let p = &bearing.parameters;
    let gamma = bearing.gamma();
    -0.5 * p.pitch_diameter / p.ball_diameter * (1.0 - gamma * gamma)
}

/// Frequencies of ideal rolling at a spindle speed [rad/s].
pub fn ideal_frequencies(bearing: &Bearing, speed: f64) -> CharacteristicFrequencies {
    let shaft = speed.abs() / std::f64::consts::TAU;
    with_cage_speed(bearing, shaft, shaft * ideal_orbit_ratio(bearing), shaft * ideal_spin_ratio(bearing).abs())
}

/// Frequencies [Hz] from shaft, cage and ball speeds as they are, slip included.
pub fn with_cage_speed(bearing: &Bearing, shaft: f64, cage: f64, ball_spin: f64) -> CharacteristicFrequencies {
    let balls = bearing.parameters.ball_count as f64;
    CharacteristicFrequencies {
        shaft,
        cage,
        ball_pass_outer: balls * cage,
        ball_pass_inner: balls * (shaft - cage),
        ball_spin,
    }
}
