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

/// Ratio of the ball spin in the orbit frame to the spindle speed for ideal rolling, −(D_m/2d)(1 − γ²) [-]. It is
/// negative because a ball turns against the spindle. Without a contact angle that axis is X.
pub(crate) fn ideal_spin_ratio(bearing: &Bearing) -> f64 {
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
pub(crate) fn with_cage_speed(bearing: &Bearing, shaft: f64, cage: f64, ball_spin: f64) -> CharacteristicFrequencies {
    let balls = bearing.parameters.ball_count as f64;
    CharacteristicFrequencies {
        shaft,
        cage,
        ball_pass_outer: balls * cage,
        ball_pass_inner: balls * (shaft - cage),
        ball_spin,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::examples::article_bearing;

    /// Article's bearing at 50 000 r/min: f_r 833.3, FTF 327.6, BPFO 2293.4, BPFI 3539.9, BSF 1860.8 Hz, hand
    /// calculation to the digit printed.
    #[test]
    fn article_bearing_has_its_frequencies() {
        let lines = ideal_frequencies(&article_bearing(), 50_000.0 * std::f64::consts::TAU / 60.0);
        for (value, expected) in [
            (lines.shaft, 833.3),
            (lines.cage, 327.6),
            (lines.ball_pass_outer, 2293.4),
            (lines.ball_pass_inner, 3539.9),
            (lines.ball_spin, 1860.8),
        ] {
            assert!((value - expected).abs() < 0.051, "{value} against {expected}");
        }
    }

    /// Without slip the surfaces of ball and raceways have one speed at both contacts, to rounding.
    #[test]
    fn ideal_rolling_slips_nowhere() {
        let bearing = article_bearing();
        let p = &bearing.parameters;
        let (orbit, spin) = (ideal_orbit_ratio(&bearing), ideal_spin_ratio(&bearing));
        let (r, ball) = (0.5 * p.pitch_diameter, 0.5 * p.ball_diameter);
        // The ball turns with `spin` against the orbit frame, which itself turns with `orbit`.
        let inner = (r - ball) * (1.0 - orbit) + ball * spin;
        let outer = -(r + ball) * orbit - ball * spin;
        assert!(inner.abs() < 1e-15 && outer.abs() < 1e-15);
    }
}
