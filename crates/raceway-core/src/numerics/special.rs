//! Special functions of filters and windows.

use std::f64::consts::PI;

/// Modified Bessel function of the first kind, order 0: Σ ((x/2)^k / k!)².
pub(super) fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (0.5 * x / k).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}

/// sin πx / (πx).
pub(super) fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}
