//! The exponential function in the form that hot loops need: inlined, without branches, the same bits on every machine.

/// 2⁵² + 2⁵¹: adding it rounds a small number to an integer that stands in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
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
pub fn exponential(x: f64) -> f64 {
    let x = x.clamp(-700.0, 700.0);
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
}
