//! Sine and cosine in the form that hot loops need: inlined, without branches, the same bits on every machine.

use super::exponential::ROUND;

/// π/2 in three parts (Cody & Waite; parts of fdlibm's e_rem_pio2.c). The first two have at least 20 trailing zero
/// bits, so that their products with up to 10⁶ quarter turns are exact.
const QUARTER: (f64, f64, f64) = (1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21);

/// Minimax polynomials on |r| ≤ π/4 (fdlibm, k_sin.c and k_cos.c): sin r = r + r³ S(r²), cos r = 1 − r²/2 + r⁴ C(r²).
const S: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const C: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sine and cosine of an angle [rad] below 10⁹, to about 2 units in the last place of 1; exactly odd and even.
#[inline(always)]
pub(crate) fn sin_cos(angle: f64) -> (f64, f64) {
    let shifted = angle * std::f64::consts::FRAC_2_PI + ROUND;
    let turns = shifted - ROUND;
    let r = ((angle - turns * QUARTER.0) - turns * QUARTER.1) - turns * QUARTER.2;
    let z = r * r;
    let z2 = z * z;
    let s = (S[0] + S[1] * z) + z2 * ((S[2] + S[3] * z) + z2 * (S[4] + S[5] * z));
    let c = (C[0] + C[1] * z) + z2 * ((C[2] + C[3] * z) + z2 * (C[4] + C[5] * z));
    let sine = r + r * z * s;
    let cosine = (1.0 - 0.5 * z) + z2 * c;
    // Odd quarter turns exchange both; two more turn the sign, which is the top bit.
    let quarters = shifted.to_bits();
    let odd = quarters & 1 == 1;
    let sign = |value: f64, quarters: u64| f64::from_bits(value.to_bits() ^ ((quarters & 2) << 62));
    (sign(if odd { cosine } else { sine }, quarters), sign(if odd { sine } else { cosine }, quarters.wrapping_add(1)))
}

/// The angle of a direction near the first axis [rad], from its components along and across that axis: 2 arctan u with
/// u = across/(length + along), by the series of arctan to u¹⁹. Exact to rounding below 0.3 rad, and to 1e-7 at 1 rad.
#[inline(always)]
pub(crate) fn small_angle(along: f64, across: f64) -> f64 {
    let u = across / ((along * along + across * across).sqrt() + along);
    let z = -u * u;
    let series = [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0].iter().fold(0.0, |sum, n| z * (sum + 1.0 / n));
    2.0 * (u + u * series)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the platform's functions, over a thousand turns, and far out to the accuracy of the angle itself.
    #[test]
    fn agrees_with_the_library_to_rounding() {
        let mut angle = -6000.0;
        while angle < 6000.0 {
            let (sine, cosine) = sin_cos(angle);
            let error = (sine - f64::sin(angle)).abs().max((cosine - f64::cos(angle)).abs());
            assert!(error < 3e-16, "{angle}: {error:e}");
            angle += 0.037_31;
        }
        for angle in [1e6, 12_345_678.9, 1e9] {
            assert!((sin_cos(angle).0 - f64::sin(angle)).abs() < 1e-16 * angle);
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }

    /// Exactly odd and even, so that a mirrored bearing gives mirrored loads.
    #[test]
    fn sine_is_odd_and_cosine_even() {
        let mut angle = 0.0;
        while angle < 100.0 {
            let ((sine, cosine), (back, ahead)) = (sin_cos(angle), sin_cos(-angle));
            assert_eq!((sine, cosine), (-back, ahead), "{angle}");
            angle += 0.101;
        }
        for quarter in -8..8 {
            let (sine, cosine) = sin_cos(f64::from(quarter) * std::f64::consts::FRAC_PI_4);
            assert!((sine * sine + cosine * cosine - 1.0).abs() < 3e-16);
        }
    }

    #[test]
    fn small_angles_are_those_of_the_library() {
        for (angle, error) in [(0.0, 0.0), (1e-9, 1e-24), (-0.01, 1e-17), (0.3, 1e-16), (1.0, 1e-6)] {
            let (sine, cosine) = f64::sin_cos(angle);
            assert!((small_angle(3.0 * cosine, 3.0 * sine) - angle).abs() <= error, "{angle}");
        }
    }
}
