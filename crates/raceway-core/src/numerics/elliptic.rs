//! Complete elliptic integrals by the arithmetic–geometric mean.

use std::f64::consts::FRAC_PI_2;

/// The four complete integrals that an ellipse of contact needs, of one parameter `m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompleteElliptic {
    /// First kind, `𝓕(m)`.
    pub first: f64,
    /// Second kind, `𝓔(m)`.
    pub second: f64,
    /// `(𝓔 − (1 − m) 𝓕) / m`; π/4 at m = 0, where the quotient itself would lose every digit.
    pub b: f64,
    /// `(𝓕 − 𝓔) / m`; π/4 at m = 0.
    pub d: f64,
}

/// Complete elliptic integral of the first kind `∫₀^{π/2} (1 − m sin²φ)^(−1/2) dφ`, 0 ≤ m < 1.
///
/// NIST DLMF 19.8.5: π / (2 agm(1, √(1 − m))). Infinite at m = 1.
#[cfg(test)]
fn complete_elliptic_first(m: f64) -> f64 {
    complete_elliptic(1.0 - m).first
}

/// Complete elliptic integral of the second kind `∫₀^{π/2} (1 − m sin²φ)^(1/2) dφ`, 0 ≤ m ≤ 1.
///
/// NIST DLMF 19.8.6: 𝓕 · (1 − Σ 2^(n−1) c_n²).
#[cfg(test)]
fn complete_elliptic_second(m: f64) -> f64 {
    if m == 1.0 { 1.0 } else { complete_elliptic(1.0 - m).second }
}

/// All four integrals from the complementary parameter `1 − m` in (0, 1], which keeps its digits
/// where `m` is next to 1: a long ellipse has `1 − m = (b/a)²`.
///
/// NIST DLMF 19.8.1, 19.8.5, 19.8.6; `c_{n+1} = c_n² / (4 a_{n+1})` avoids the difference of means.
pub fn complete_elliptic(complement: f64) -> CompleteElliptic {
    let m = 1.0 - complement;
    let root = complement.sqrt();
    let (mut mean, mut geometric) = (0.5 * (1.0 + root), root.sqrt());
    // c_1 over √m, and Σ 2^(n−1) c_n² / m without its first term ½.
    let mut c = m / (2.0 * (1.0 + root));
    let mut weight = 1.0;
    let mut sum = 1.0 / (4.0 * (1.0 + root) * (1.0 + root)) * m;
    // Convergence is quadratic: from 1 − m = 1e−300 on, a dozen halvings are enough.
    for _ in 0..24 {
        let next = 0.5 * (mean + geometric);
        geometric = (mean * geometric).sqrt();
        c = c * c / (4.0 * next);
        mean = next;
        weight *= 2.0;
        if c * c * weight <= 1e-18 * m * sum {
            break;
        }
        sum += weight * c * c / m;
    }
    let first = FRAC_PI_2 / mean;
    let d = first * (0.5 + sum);
    CompleteElliptic { first, second: first - m * d, b: first - d, d }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} against {expected}");
    }

    /// Abramowitz & Stegun table 17.1, 15 digits there, 1e-13 asked.
    #[test]
    fn integrals_match_the_tables() {
        for (m, first, second) in [
            (0.0, FRAC_PI_2, FRAC_PI_2),
            (0.1, 1.612_441_348_720_219, 1.530_757_636_897_763),
            (0.5, 1.854_074_677_301_372, 1.350_643_881_047_675),
            (0.9, 2.578_092_113_348_173, 1.104_774_732_704_073),
            (0.99, 3.695_637_362_989_875, 1.015_993_545_025_224),
        ] {
            assert_close(complete_elliptic_first(m), first, 1e-13);
            assert_close(complete_elliptic_second(m), second, 1e-13);
        }
        assert_eq!(complete_elliptic_second(1.0), 1.0);
    }

    /// NIST DLMF 19.12.1: 𝓕 → ln(4/√(1 − m)), 𝓔 → 1 as m → 1; the next term is of order (1 − m) ln.
    #[test]
    fn long_ellipses_follow_the_logarithm() {
        for complement in [1e-8, 1e-14, 1e-30, 1e-200] {
            let integrals = complete_elliptic(complement);
            assert_close(integrals.first, (4.0 / complement.sqrt()).ln(), 1e-7);
            assert_close(integrals.second, 1.0, 1e-7);
        }
    }

    /// Legendre's relation, NIST DLMF 19.7.1: 𝓔𝓕' + 𝓔'𝓕 − 𝓕𝓕' = π/2, to rounding.
    #[test]
    fn legendre_relation_holds() {
        for m in [0.01, 0.2, 0.5, 0.83, 0.999] {
            let (k, e) = (complete_elliptic_first(m), complete_elliptic_second(m));
            let (k1, e1) = (complete_elliptic_first(1.0 - m), complete_elliptic_second(1.0 - m));
            assert_close(e * k1 + e1 * k - k * k1, FRAC_PI_2, 1e-13);
        }
    }

    /// The quotients keep their digits at m → 0: both tend to π/4 with slopes π/32 and 3π/32 (power series).
    #[test]
    fn quotients_are_exact_for_circles() {
        let quarter = FRAC_PI_2 / 2.0;
        let circle = complete_elliptic(1.0);
        assert_eq!((circle.b, circle.d), (quarter, quarter));
        let m = 1e-6;
        let nearly = complete_elliptic(1.0 - m);
        assert_close(nearly.b, quarter * (1.0 + m / 8.0), 1e-12);
        assert_close(nearly.d, quarter * (1.0 + 3.0 * m / 8.0), 1e-12);
    }
}
