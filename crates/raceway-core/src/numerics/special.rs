//! Special functions of filters and windows.

use std::f64::consts::PI;

/// Modified Bessel function of the first kind, order 0: Σ ((x/2)^k / k!)².
pub(crate) fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (0.5 * x / k).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}

/// sin πx / (πx).
pub(crate) fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// Kaiser window of parameter β at `x` from −1 to 1, 1 in the middle.
pub(crate) fn kaiser(beta: f64, x: f64) -> f64 {
    bessel_i0(beta * (1.0 - x * x).sqrt()) / bessel_i0(beta)
}

/// Parameter β of the Kaiser window for an attenuation above 50 dB. Oppenheim & Schafer, Discrete-Time Signal Processing, eq. (7.75).
pub(crate) fn kaiser_beta(attenuation: f64) -> f64 {
    0.1102 * (attenuation - 8.7)
}

/// Intervals between the taps of a Kaiser filter of an attenuation [dB] and a transition band [rad]; eq. (7.76).
pub(crate) fn kaiser_length(attenuation: f64, transition: f64) -> f64 {
    (attenuation - 8.0) / (2.285 * transition)
}
