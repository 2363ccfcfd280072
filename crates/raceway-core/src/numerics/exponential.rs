//! Exponential and logarithm in the form that hot loops need: inlined, without branches, the same bits on every machine.

use std::array::from_fn;

use super::lanes::{larger, smaller};

/// 2⁵² + 2⁵¹: adding it rounds a small number to an integer that stands in the low bits.
pub(crate) const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts; the first has 20 trailing zero bits, so that its product with an exponent is exact (Cody & Waite).
const LN_2: (f64, f64) = (6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10);

const C2: f64 = 1.0 / 2.0;
const C3: f64 = 1.0 / 6.0;
const C4: f64 = 1.0 / 24.0;
const C5: f64 = 1.0 / 120.0;
const C6: f64 = 1.0 / 720.0;
const C7: f64 = 1.0 / 5_040.0;
const C8: f64 = 1.0 / 40_320.0;
const C9: f64 = 1.0 / 362_880.0;
const C10: f64 = 1.0 / 3_628_800.0;
const C11: f64 = 1.0 / 39_916_800.0;
const C12: f64 = 1.0 / 479_001_600.0;

/// e^x for −700 ≤ x ≤ 700 (outside, as at the nearer end), to about 2 units in the last place.
///
/// x = n ln 2 + r, |r| ≤ ln 2 / 2; e^r by its Taylor polynomial to r¹², whose next term is below 2e-16.
#[inline(always)]
pub(crate) fn exponential(x: f64) -> f64 {
    let x = smaller(larger(x, -700.0), 700.0);
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    // Estrin's scheme: pairs, then pairs of pairs, so that little waits for little.
    let r2 = r * r;
    let r4 = r2 * r2;
    let r8 = r4 * r4;
    let low = (1.0 + r) + r2 * (C2 + C3 * r) + r4 * ((C4 + C5 * r) + r2 * (C6 + C7 * r));
    let high = (C8 + C9 * r) + r2 * (C10 + C11 * r) + r4 * C12;
    let sum = low + r8 * high;
    let power = f64::from_bits(((shifted.to_bits() as i64) << 52).wrapping_add(1023 << 52) as u64);
    sum * power
}

/// (1 − 2^(−f))/f on |f| ≤ ½: the polynomial of least relative error, 1.8e-17 (Remez).
const RISE: [f64; 11] = [
    std::f64::consts::LN_2,
    -2.402_265_069_591_009_7e-1,
    5.550_410_866_482_123_6e-2,
    -9.618_129_107_607_065e-3,
    1.333_355_814_653_163_3e-3,
    -1.540_353_044_148_068e-4,
    1.525_273_370_121_465_6e-5,
    -1.321_544_272_423_112_7e-6,
    1.017_812_129_916_570_4e-7,
    -7.072_561_701_932_03e-9,
    4.445_537_228_154_442_6e-10,
];

/// 1 − 2^(−x) and 2^(−x) of several x ≥ 0, to about 2 units in the last place, the first near 0, too.
///
/// x = n + f, |f| ≤ ½; 1 − 2^(−n) 2^(−f) = 2^(−n) (1 − 2^(−f)) + (1 − 2^(−n)), whose second part vanishes for small x.
/// Step by step for all of them: while one waits for its last step, the processor does that of another.
#[inline(always)]
pub(crate) fn binary_saturations<const S: usize>(x: [f64; S]) -> ([f64; S], [f64; S]) {
    let z: [f64; S] = from_fn(|k| smaller(x[k], 1000.0));
    let shifted: [f64; S] = from_fn(|k| z[k] + ROUND);
    let f: [f64; S] = from_fn(|k| z[k] - (shifted[k] - ROUND));
    let linear = |i: usize| -> [f64; S] { from_fn(|k| RISE[i] + RISE[i + 1] * f[k]) };
    let [c0, c2, c4, c6, c8] = [linear(0), linear(2), linear(4), linear(6), linear(8)];
    let f2: [f64; S] = from_fn(|k| f[k] * f[k]);
    let low: [f64; S] = from_fn(|k| c0[k] + c2[k] * f2[k]);
    let middle: [f64; S] = from_fn(|k| c4[k] + c6[k] * f2[k]);
    let high: [f64; S] = from_fn(|k| c8[k] + RISE[10] * f2[k]);
    let f4: [f64; S] = from_fn(|k| f2[k] * f2[k]);
    let upper: [f64; S] = from_fn(|k| middle[k] + high[k] * f4[k]);
    let rise: [f64; S] = from_fn(|k| f[k] * (low[k] + upper[k] * f4[k]));
    let power: [f64; S] = from_fn(|k| f64::from_bits((1023 << 52) - (shifted[k].to_bits() << 52)));
    let change: [f64; S] = from_fn(|k| power[k] * rise[k]);
    (from_fn(|k| change[k] + (1.0 - power[k])), from_fn(|k| power[k] - change[k]))
}

/// Saturation at one x in single precision.
#[inline(always)]
pub(crate) fn binary_saturation_single(x: f32) -> (f32, f32) {
    // 2²³ + 2²²
    const ROUND: f32 = 12_582_912.0;
    const RISE: [f32; 7] = [
        self::RISE[0] as f32,
        self::RISE[1] as f32,
        self::RISE[2] as f32,
        self::RISE[3] as f32,
        self::RISE[4] as f32,
        self::RISE[5] as f32,
        self::RISE[6] as f32,
    ];
    let z = smaller(x, 100.0);
    let shifted = z + ROUND;
    let f = z - (shifted - ROUND);
    let square = f * f;
    let low = (RISE[0] + RISE[1] * f) + (RISE[2] + RISE[3] * f) * square;
    let rise = f * (low + ((RISE[4] + RISE[5] * f) + RISE[6] * square) * (square * square));
    let power = f32::from_bits((127_u32 << 23).wrapping_sub(shifted.to_bits() << 23));
    let change = power * rise;
    (change + (1.0 - power), power - change)
}

/// 1 − e^(−x), x ≥ 0.
#[inline(always)]
pub(crate) fn saturation(x: f64) -> f64 {
    binary_saturations([x * std::f64::consts::LOG2_E]).0[0]
}

/// tanh x for x ≥ 0: 1 − e^(−2x) over 1 + e^(−2x).
#[inline(always)]
pub(crate) fn hyperbolic_tangent(x: f64) -> f64 {
    let rise = saturation(2.0 * x);
    rise / (2.0 - rise)
}

/// Bits of √½.
const ROOT_OF_HALF: u64 = 0x3fe6_a09e_667f_3bcd;

/// ln x of a positive, normal x, to about 1 unit in the last place.
///
/// x = 2ᵏ (1 + f), √½ < 1 + f < √2, s = f/(2 + f): ln(1 + f) = f − f²/2 + s (f²/2 + R(s²)) (fdlibm, e_log.c).
#[inline(always)]
pub(crate) fn logarithm(x: f64) -> f64 {
    const R: [f64; 7] = [
        6.666_666_666_666_735e-1,
        3.999_999_999_940_942e-1,
        2.857_142_874_366_239e-1,
        2.222_219_843_214_978_4e-1,
        1.818_357_216_161_805e-1,
        1.531_383_769_920_937_3e-1,
        1.479_819_860_511_658_6e-1,
    ];
    let above = x.to_bits().wrapping_sub(ROOT_OF_HALF) as i64 >> 52;
    let f = f64::from_bits(x.to_bits().wrapping_sub((above as u64) << 52)) - 1.0;
    let k = f64::from_bits((above as u64).wrapping_add(ROUND.to_bits())) - ROUND;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let r = z * (R[0] + w * (R[2] + w * (R[4] + w * R[6]))) + w * (R[1] + w * (R[3] + w * R[5]));
    let half = 0.5 * f * f;
    k * LN_2.0 - ((half - (s * (half + r) + k * LN_2.1)) - f)
}

/// ln(1 + x), x ≥ 0, to about 2 units in the last place.
#[inline(always)]
pub(crate) fn logarithm_of_one_plus(x: f64) -> f64 {
    let sum = 1.0 + x;
    // Rounding error of the sum, to first order.
    logarithm(sum) + (x - (sum - 1.0)) / sum
}

/// x^y of x ≥ 0 and a y whose power stays in the range of `exponential`; 0 at 0.
#[inline(always)]
pub(crate) fn power(x: f64, y: f64) -> f64 {
    let power = exponential(y * logarithm(x));
    if x > 0.0 { power } else { 0.0 }
}

/// arsinh x for x ≥ 0: ln(1 + x + x²/(1 + √(1 + x²))), which loses no digits near 0.
#[inline(always)]
pub(crate) fn inverse_hyperbolic_sine(x: f64) -> f64 {
    let square = x * x;
    logarithm_of_one_plus(x + square / (1.0 + (1.0 + square).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the platform's function, over the whole range.
    #[test]
    fn agrees_with_the_library_to_rounding() {
        let mut x = -699.0;
        while x < 699.0 {
            let error = exponential(x) / f64::exp(x) - 1.0;
            assert!(error.abs() < 7e-16, "{x}: {error:e}");
            x += 0.037_31;
        }
        assert_eq!(exponential(0.0), 1.0);
        assert!(exponential(-1e9) < 1e-300);
    }

    #[test]
    fn single_saturations_agree_with_double_ones() {
        for k in 0..4000 {
            let x = (1.0_f32 + 0.01).powi(k - 3000);
            let (rise, decay) = binary_saturation_single(x);
            let ([of_double], [left]) = binary_saturations([f64::from(x)]);
            assert!((f64::from(rise) / of_double - 1.0).abs() < 3e-7, "{x:e}: {rise:e} for {of_double:e}");
            assert!(x > 100.0 || (f64::from(decay) / left - 1.0).abs() < 3e-7, "{x:e}: {decay:e} for {left:e}");
        }
        assert_eq!(binary_saturation_single(0.0), (0.0, 1.0));
    }

    /// Against the platform's functions, from rounding to the largest arguments, in units of the last place.
    #[test]
    fn saturation_and_logarithm_agree_with_the_library() {
        let mut x = 1e-12;
        while x < 1e9 {
            let close = |found: f64, expected: f64, ulps: f64| {
                assert!((found / expected - 1.0).abs() < ulps * f64::EPSILON, "{x}: {found:e} {expected:e}");
            };
            close(saturation(x), -f64::exp_m1(-x), 3.0);
            let decay = binary_saturations([x * std::f64::consts::LOG2_E]).1[0];
            assert!((decay - f64::exp(-x)).abs() < 1e-13 * f64::exp(-x) + 1e-300, "{x}: {decay:e}");
            close(hyperbolic_tangent(x), f64::tanh(x), 6.0);
            close(logarithm_of_one_plus(x), f64::ln_1p(x), 3.0);
            close(inverse_hyperbolic_sine(x), f64::asinh(x), 6.0);
            close(power(x, 0.67), f64::powf(x, 0.67), 32.0);
            assert!((logarithm(x) - f64::ln(x)).abs() <= f64::EPSILON * f64::ln(x).abs().max(1.0));
            x *= 1.0173;
        }
        assert_eq!((saturation(0.0), hyperbolic_tangent(0.0), power(0.0, 0.67)), (0.0, 0.0, 0.0));
        assert_eq!((logarithm(1.0), logarithm_of_one_plus(0.0), saturation(1e300)), (0.0, 0.0, 1.0));
        assert_eq!(binary_saturations([1.0, 2.0]), ([0.5, 0.75], [0.5, 0.25]));
    }
}
