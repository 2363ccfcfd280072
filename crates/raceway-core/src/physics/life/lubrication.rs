//! Viscosity ratio, film over roughness, and the life factor of lubrication and contamination.

use std::f64::consts::TAU;

/// Reference viscosity ν₁ [mm²/s] of a pitch diameter [m] and a speed of the rings relative to each other [rad/s].
///
/// ISO 281:2007: 45 000 n^(−0.83) D_pw^(−½) below 1000 r/min, else 4500 n^(−½) D_pw^(−½), D_pw in mm.
pub fn reference_viscosity(pitch_diameter: f64, speed: f64) -> f64 {
    let per_minute = 60.0 * speed.abs() / TAU;
    let of_speed = if per_minute < 1000.0 { 45_000.0 * per_minute.powf(-0.83) } else { 4500.0 / per_minute.sqrt() };
    of_speed / (1e3 * pitch_diameter).sqrt()
}

/// Λ = h_min/√(R_q² + R_q,b²) [-] of a film and of the rms roughness of raceway and ball, in one unit.
pub fn film_ratio(film: f64, raceway_roughness: f64, ball_roughness: f64) -> f64 {
    film / raceway_roughness.hypot(ball_roughness)
}

/// Viscosity ratio below which the life factor is not defined, and the one beyond which it does not grow [-].
pub const VISCOSITY_RATIOS: [f64; 2] = [0.1, 4.0];
/// Largest life factor [-].
const LARGEST_FACTOR: f64 = 50.0;

/// Life factor a_ISO of radial ball bearings [-] (ISO 281:2007, eqs. 31–33) of a viscosity ratio κ and e_C C_u/P; `None` below κ = 0.1.
///
/// a_ISO = 0.1 [1 − (2.5671 − c/κ^q)^0.83 (e_C C_u/P)^(1/3)]^(−9.3), at most 50; c, q: 2.2649, 0.054381 below κ = 0.4, 1.9987, 0.19087 below 1,
/// 1.9987, 0.071739 up to 4.
pub fn life_factor(viscosity_ratio: f64, contaminated_limit_over_load: f64) -> Option<f64> {
    let [lowest, highest] = VISCOSITY_RATIOS;
    if viscosity_ratio.is_nan() || viscosity_ratio < lowest {
        return None;
    }
    let ratio = viscosity_ratio.min(highest);
    let (factor, exponent) = match ratio {
        _ if ratio < 0.4 => (2.2649, 0.054381),
        _ if ratio < 1.0 => (1.9987, 0.19087),
        _ => (1.9987, 0.071739),
    };
    let of_film = (2.5671 - factor / ratio.powf(exponent)).powf(0.83);
    let rest = 1.0 - of_film * contaminated_limit_over_load.cbrt();
    // At the limit of fatigue the power grows beyond all bounds.
    Some(if rest > 0.0 { (0.1 * rest.powf(-9.3)).min(LARGEST_FACTOR) } else { LARGEST_FACTOR })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RPM: f64 = TAU / 60.0;

    fn assert_rounds(value: f64, expected: f64, half_digit: f64) {
        assert!((value - expected).abs() <= half_digit, "{value} instead of {expected}");
    }

    /// 6309, D_pw 72.5 mm, 1800 r/min, 21.6 mm²/s: ISO 12.46 and κ 1.73. A calculator report prints 10.4 and 2.08, near the first formula.
    #[test]
    fn viscosity_ratio_of_the_6309() {
        let reference = reference_viscosity(72.5e-3, 1800.0 * RPM);
        assert_rounds(reference, 12.46, 5e-3);
        assert_rounds(21.6 / reference, 1.73, 5e-3);
        let slow = 45_000.0 * 1800_f64.powf(-0.83) / 72.5_f64.sqrt();
        assert_rounds(slow, 10.50, 1e-2);
        // The formulas differ by 1 % where they meet.
        let [below, above] = [999.999, 1000.0].map(|speed| reference_viscosity(72.5e-3, speed * RPM));
        assert!((below / above - 1.0).abs() < 0.025, "{below} {above}");
    }

    #[test]
    fn roughness_adds_by_squares() {
        assert_rounds(film_ratio(0.5, 0.03, 0.04), 10.0, 1e-12);
    }

    /// The branches meet to 1 %, a clean film lives long and a starved one does not; no ratio below 0.1.
    #[test]
    fn life_factor_grows_with_film_and_cleanliness() {
        for ratio in [0.4, 1.0] {
            let [below, at] = [ratio - 1e-9, ratio].map(|ratio| life_factor(ratio, 0.1).unwrap());
            assert!((below / at - 1.0).abs() < 0.01, "{ratio}: {below} {at}");
        }
        assert_eq!([life_factor(0.09, 1.0), life_factor(f64::NAN, 1.0)], [None, None]);
        assert_eq!(life_factor(9.0, 0.05), life_factor(4.0, 0.05));
        assert_eq!(life_factor(4.0, 5.0), Some(50.0));
        assert_rounds(life_factor(1.0, 0.0).unwrap(), 0.1, 1e-12);
        let rising = [0.1, 0.2, 0.4, 1.0, 2.0, 4.0].map(|ratio| life_factor(ratio, 0.1).unwrap());
        assert!(rising.is_sorted(), "{rising:?}");
    }
}
