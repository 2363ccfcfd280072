//! Speeds of the rings, and the characteristic frequencies that follow from them.
//!
//! Rolling knows only the speed of the inner ring relative to the outer one. Balls orbit with the outer ring and, relative to it, with a
//! share of that speed.

use std::f64::consts::TAU;

use super::bearing::{Bearing, PerRaceway};

/// Speeds of both rings about the bearing axis, in one unit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RingSpeeds {
    pub inner: f64,
    pub outer: f64,
}

/// The inner ring turns with the shaft, the outer ring stands.
impl From<f64> for RingSpeeds {
    fn from(shaft: f64) -> Self {
        Self { inner: shaft, outer: 0.0 }
    }
}

impl RingSpeeds {
    /// Speed of the inner ring relative to the outer one.
    #[inline(always)]
    pub fn relative(self) -> f64 {
        self.inner - self.outer
    }

    /// Speed of a body that turns with the outer ring and, relative to it, with this ratio of the relative speed.
    #[inline(always)]
    pub fn carried(self, ratio: f64) -> f64 {
        self.outer + ratio * self.relative()
    }

    /// The same rotation seen from the other side, if the inner ring turns backwards, or stands while the outer one does.
    pub fn forward(self) -> Self {
        let is_backward = if self.inner == 0.0 { self.outer < 0.0 } else { self.inner < 0.0 };
        if is_backward { Self { inner: -self.inner, outer: -self.outer } } else { self }
    }
}

/// Frequencies of a running bearing [Hz]. Signed quantities are given as magnitudes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CharacteristicFrequencies {
    /// f_r, turns of the spindle.
    pub shaft: f64,
    /// f_o, turns of the outer ring.
    pub outer_ring: f64,
    /// FTF, turns of the cage.
    pub cage: f64,
    /// Balls passing a direction in space, such as that of the load: the varying-compliance line. It is BPFO where the outer ring stands.
    pub ball_pass: f64,
    /// BPFO, balls passing a point of the outer raceway.
    pub ball_pass_outer: f64,
    /// BPFI, balls passing a point of the inner raceway.
    pub ball_pass_inner: f64,
    /// BSF, turns of a ball; a ball defect strikes at twice this.
    pub ball_spin: f64,
}

/// Ratio of the orbit speed of ideally rolling balls to the speed of the inner ring, both relative to the outer ring, ½ (1 − γ) [-].
pub fn ideal_orbit_ratio(bearing: &Bearing) -> f64 {
    0.5 * (1.0 - bearing.gamma())
}

/// Ratio of the ball spin in the orbit frame to the relative speed of the rings for ideal rolling, −(D_m/2d)(1 − γ²) [-]. It is
/// negative because a ball turns against the spindle. Without a contact angle that axis is X.
pub(crate) fn ideal_spin_ratio(bearing: &Bearing) -> f64 {
    let p = &bearing.parameters;
    let gamma = bearing.gamma();
    -0.5 * p.pitch_diameter / p.ball_diameter * (1.0 - gamma * gamma)
}

/// Frequencies of ideal rolling at speeds of the rings [rad/s].
pub fn ideal_frequencies(bearing: &Bearing, speeds: impl Into<RingSpeeds>) -> CharacteristicFrequencies {
    rolling_frequencies(bearing, speeds.into(), ideal_orbit_ratio(bearing), ideal_spin_ratio(bearing))
}

/// Frequencies of rolling at speeds of the rings [rad/s], with ratios of orbit and spin to their relative speed.
pub(crate) fn rolling_frequencies(
    bearing: &Bearing,
    speeds: RingSpeeds,
    orbit_ratio: f64,
    spin_ratio: f64,
) -> CharacteristicFrequencies {
    let turns = RingSpeeds { inner: speeds.inner / TAU, outer: speeds.outer / TAU };
    let relative = turns.relative().abs();
    let (relative_cage, ball_spin) = (relative * orbit_ratio, relative * spin_ratio.abs());
    BodySpeeds {
        shaft: turns.inner.abs(),
        outer_ring: turns.outer.abs(),
        cage: turns.carried(orbit_ratio).abs(),
        relative,
        relative_cage,
        ball_spin,
    }
    .frequencies(bearing)
}

/// Slip of a cage [-] from speeds of the cage and the other ring relative to one ring, magnitudes in the same unit, and the ratio of both in
/// rolling; `None` where the rings do not turn relative to each other.
pub fn cage_slip(cage_speed: f64, ring_speed: f64, ratio: f64) -> Option<f64> {
    let ideal = ring_speed * ratio;
    (ideal > 0.0).then(|| 1.0 - cage_speed / ideal)
}

/// Speeds of the bodies of a bearing in one unit, magnitudes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BodySpeeds {
    pub shaft: f64,
    pub outer_ring: f64,
    pub cage: f64,
    /// Of the inner ring relative to the outer one.
    pub relative: f64,
    /// Of the cage relative to the outer ring.
    pub relative_cage: f64,
    /// Of a ball about its own axis in the orbit frame.
    pub ball_spin: f64,
}

impl BodySpeeds {
    /// Magnitudes of the speeds of rings and cage, and the spin of a ball.
    pub(crate) fn new(rings: RingSpeeds, cage: f64, ball_spin: f64) -> Self {
        Self {
            shaft: rings.inner.abs(),
            outer_ring: rings.outer.abs(),
            cage: cage.abs(),
            relative: rings.relative().abs(),
            relative_cage: (cage - rings.outer).abs(),
            ball_spin,
        }
    }

    /// Slip of the cage [-] against rolling of an orbit ratio, as seen from the ring that turns more slowly: positive where drag holds the cage
    /// back. `None` where the rings do not turn relative to each other.
    pub fn cage_slip(&self, orbit_ratio: f64) -> Option<f64> {
        if self.outer_ring <= self.shaft {
            cage_slip(self.relative_cage, self.relative, orbit_ratio)
        } else {
            cage_slip(self.relative - self.relative_cage, self.relative, 1.0 - orbit_ratio)
        }
    }

    /// The same in turns a second, from rad/s.
    pub(crate) fn in_turns(self) -> Self {
        let Self { shaft, outer_ring, cage, relative, relative_cage, ball_spin } = self;
        let [shaft, outer_ring, cage] = [shaft, outer_ring, cage].map(|speed| speed / TAU);
        let [relative, relative_cage, ball_spin] = [relative, relative_cage, ball_spin].map(|speed| speed / TAU);
        Self { shaft, outer_ring, cage, relative, relative_cage, ball_spin }
    }

    /// Frequencies from turns a second, slip included.
    pub(crate) fn frequencies(&self, bearing: &Bearing) -> CharacteristicFrequencies {
        let balls = bearing.parameters.ball_count as f64;
        CharacteristicFrequencies {
            shaft: self.shaft,
            outer_ring: self.outer_ring,
            cage: self.cage,
            ball_pass: balls * self.cage,
            ball_pass_outer: balls * self.relative_cage,
            ball_pass_inner: balls * (self.relative - self.relative_cage),
            ball_spin: self.ball_spin,
        }
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

    /// Ratio of the orbit speed to the speed of the inner ring, both relative to the outer one [-]. Balls roll at both contact centres:
    /// 1/(1 + r_e cos(α_i − β)/(r_i cos(α_e − β))). Here r_i = R − ½d cos α_i and r_e = R + ½d cos α_e. `None` for a spin axis about which a
    /// ball cannot roll on both raceways.
    #[inline]
    pub(crate) fn orbit_ratio(&self, spin: SpinAxis) -> Option<f64> {
        let PerRaceway { inner, outer } = self.angle;
        // Surface speeds of the ball at both contacts, cos(α − β) but for a common factor.
        let at_inner = (self.orbit_radius - self.ball_radius * inner.1) * along_groove(spin, outer);
        let at_outer = (self.orbit_radius + self.ball_radius * outer.1) * along_groove(spin, inner);
        (at_inner * at_outer > 0.0).then(|| at_inner / (at_inner + at_outer))
    }

    /// Ratio of the ball's spin in the orbit frame to the relative speed of the rings for rolling at both contact centres, a magnitude [-].
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
    use crate::physics::presets;

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

    /// A cage 1 % slower than its balls roll it has a positive slip, whichever ring turns: of the speed relative to the slower ring.
    #[test]
    fn a_held_cage_lags_whichever_ring_turns() {
        let ratio = ideal_orbit_ratio(&article_bearing());
        for (inner, outer) in [(100.0, 0.0), (0.0, 100.0), (-100.0, 0.0), (100.0, 50.0), (50.0, 100.0)] {
            let rings = RingSpeeds { inner, outer };
            let (ideal, slower) = (rings.carried(ratio), if outer < inner.abs() { outer } else { inner });
            let held = BodySpeeds::new(rings, 0.99 * ideal, 0.0).cage_slip(ratio).unwrap();
            let expected = 0.01 * ideal / (ideal - slower);
            assert!((held - expected).abs() < 1e-12 && held > 0.0, "{inner} {outer}: {held} against {expected}");
        }
        assert_eq!(BodySpeeds::new(RingSpeeds { inner: 3.0, outer: 3.0 }, 3.0, 0.0).cage_slip(ratio), None);
    }

    /// 6205-like rolling by hand, γ of the article's bearing: counter-rotating rings with the cage at rest, and rings that turn together.
    #[test]
    fn a_turning_outer_ring_carries_the_cage() {
        let bearing = article_bearing();
        let (ratio, balls) = (ideal_orbit_ratio(&bearing), bearing.parameters.ball_count as f64);
        let inner = 100.0 * TAU;
        let standing = ideal_frequencies(&bearing, RingSpeeds { inner, outer: -inner * ratio / (1.0 - ratio) });
        assert!(standing.cage < 1e-12 && standing.ball_pass < 1e-11);
        assert!((standing.ball_pass_inner - balls * 100.0).abs() < 1e-10);
        assert!((standing.ball_pass_outer - balls * standing.outer_ring).abs() < 1e-10);
        let together = ideal_frequencies(&bearing, RingSpeeds { inner, outer: inner });
        assert!((together.cage - 100.0).abs() < 1e-12 && together.ball_spin == 0.0);
        assert!(together.ball_pass_outer == 0.0 && together.ball_pass_inner == 0.0);
        // From a frame that turns with the inner ring the passages are the same, and the cage turns with the outer ring.
        let (one, other) = (RingSpeeds::from(inner), RingSpeeds { inner: 0.0, outer: -inner });
        let (one, other) = (ideal_frequencies(&bearing, one), ideal_frequencies(&bearing, other));
        assert!((one.ball_pass_outer - other.ball_pass_outer).abs() < 1e-10);
        assert!((one.ball_spin - other.ball_spin).abs() < 1e-10);
        assert!((one.cage + other.cage - 100.0).abs() < 1e-10);
    }

    /// Turns of a ball in a turn of the spindle, and strikes of a defect on it: 2.35672 and 4.71344 for a 6205.
    #[test]
    fn a_ball_strikes_twice_a_turn() {
        let preset = presets::bearing("6205").unwrap();
        let bearing = Bearing::new(preset.defaults.parameters(&preset.dimensions)).unwrap();
        let spin = ideal_frequencies(&bearing, TAU).ball_spin;
        assert!((spin - 2.35672).abs() < 5e-6 && (2.0 * spin - 4.71344).abs() < 1e-5, "{spin}");
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
        let mean = 0.5 * (1.0 - 0.2 * 20_f64.to_radians().cos());
        assert!((mean - 0.4060).abs() < 5e-5);
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
