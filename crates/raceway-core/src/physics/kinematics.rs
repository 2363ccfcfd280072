//! Characteristic frequencies of a bearing whose inner raceway turns and whose outer one stands.

use super::bearing::{Bearing, PerRaceway};

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

/// Place and contact angles of a ball that both raceways load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LoadedBall {
    /// Distance of the ball's centre from the bearing axis [m].
    pub orbit_radius: f64,
    /// [m]
    pub ball_radius: f64,
    /// Sine and cosine of the contact angles, positive where the outer contact lies towards +X.
    pub angle: PerRaceway<(f64, f64)>,
}

/// Axial and radial component of a ball's spin in its orbit frame. Ratios of rolling depend on the direction alone, the pitch angle β with
/// tan β = −ω_r/ω_x.
pub(crate) type SpinAxis = (f64, f64);

impl LoadedBall {
    /// Spin axis of a ball that does not turn about the normal of the outer contact: tan β = sin α_e/(cos α_e + d/2R).
    pub(crate) fn outer_control(&self) -> SpinAxis {
        let (sine, cosine) = self.angle.outer;
        (-(cosine + self.ball_radius / self.orbit_radius), sine)
    }

    /// Spin axis of a ball that does not turn about the normal of the inner contact: tan β = sin α_i/(cos α_i − d/2R).
    pub(crate) fn inner_control(&self) -> SpinAxis {
        let (sine, cosine) = self.angle.inner;
        (-(cosine - self.ball_radius / self.orbit_radius), sine)
    }

    /// Ratio of the orbit speed to the spindle speed for rolling at both contact centres,
    /// 1/(1 + r_e cos(α_i − β)/(r_i cos(α_e − β))) with r_i = R − ½d cos α_i and r_e = R + ½d cos α_e [-]; `None` for a spin axis about
    /// which a ball cannot roll on both raceways.
    #[inline]
    pub(crate) fn orbit_ratio(&self, spin: SpinAxis) -> Option<f64> {
        let PerRaceway { inner, outer } = self.angle;
        // Surface speeds of the ball at both contacts, cos(α − β) but for a common factor.
        let at_inner = (self.orbit_radius - self.ball_radius * inner.1) * along_groove(spin, outer);
        let at_outer = (self.orbit_radius + self.ball_radius * outer.1) * along_groove(spin, inner);
        (at_inner * at_outer > 0.0).then(|| at_inner / (at_inner + at_outer))
    }

    /// Ratio of the ball's spin in the orbit frame to the spindle speed for rolling at both contact centres, a magnitude [-].
    pub(crate) fn spin_ratio(&self, spin: SpinAxis) -> Option<f64> {
        let outer = self.angle.outer;
        let radius = self.orbit_radius + self.ball_radius * outer.1;
        let turned = spin.0.hypot(spin.1) / along_groove(spin, outer).abs();
        Some(self.orbit_ratio(spin)? * turned * radius / self.ball_radius)
    }
}

/// Velocity of a ball's surface along the groove at a contact, over the ball's radius [rad/s].
#[inline]
fn along_groove((axial, radial): SpinAxis, (sine, cosine): (f64, f64)) -> f64 {
    radial * sine - axial * cosine
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

    fn ball(inner: f64, outer: f64) -> LoadedBall {
        let angle = |degrees: f64| degrees.to_radians().sin_cos();
        LoadedBall {
            orbit_radius: 1.0,
            ball_radius: 0.2,
            angle: PerRaceway { inner: angle(inner), outer: angle(outer) },
        }
    }

    /// Equal angles: ½ (1 − (d/2R) cos α) whatever the spin axis. 30° and 10°, d/2R 0.2: 0.4263 at outer and 0.3829 at inner control.
    #[test]
    fn orbit_ratio_at_loaded_angles_lies_between_the_controls() {
        let equal = ball(25.0, 25.0);
        for spin in [equal.outer_control(), equal.inner_control(), (-1.0, 0.0), (1.0, -0.3)] {
            let expected = 0.5 * (1.0 - 0.2 * 25_f64.to_radians().cos());
            assert!((equal.orbit_ratio(spin).unwrap() - expected).abs() < 1e-15);
        }
        let unequal = ball(30.0, 10.0);
        let controls =
            [unequal.outer_control(), unequal.inner_control()].map(|spin| unequal.orbit_ratio(spin).unwrap());
        assert!((controls[0] - 0.4263).abs() < 5e-5 && (controls[1] - 0.3829).abs() < 5e-5, "{controls:?}");
        assert_eq!(unequal.orbit_ratio((0.0, 0.0)), None, "a ball without spin does not roll");
    }

    /// At zero angle the spin is that of ideal rolling, and control means no spin about the contact's normal.
    #[test]
    fn controlled_spin_has_no_part_about_the_normal() {
        let flat = ball(0.0, 0.0);
        let ideal = 0.5 / 0.2 * (1.0 - 0.04);
        assert!((flat.spin_ratio(flat.outer_control()).unwrap() - ideal).abs() < 1e-14);
        let ball = ball(30.0, 10.0);
        let (orbit, spin) = (ball.orbit_ratio(ball.outer_control()), ball.spin_ratio(ball.outer_control()));
        let (axial, radial) = ball.outer_control();
        let scale = spin.unwrap() / axial.hypot(radial);
        // Spin in space: the orbit speed is added about X. The normal of the outer contact is (sin α, cos α).
        let (sine, cosine) = ball.angle.outer;
        let about_normal = (axial * scale + orbit.unwrap()) * sine + radial * scale * cosine;
        assert!(about_normal.abs() < 1e-14, "{about_normal}");
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
