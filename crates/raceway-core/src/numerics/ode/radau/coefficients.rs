//! The stages of Radau IIA of order 5, and the transformation that parts their equations into one real system and one
//! complex (Hairer & Wanner II, §IV.5 and §IV.8).

use nalgebra::Complex;

/// √6
const ROOT: f64 = 2.449_489_742_783_178;
/// Places of the stages as shares of the step.
pub(super) const C: [f64; 3] = [(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0];
/// Eigenvalues of A⁻¹, the roots of μ³ − 9μ² + 36μ − 60: one real, one of the conjugate pair.
pub(super) const REAL: f64 = 3.637_834_252_744_496;
pub(super) const PAIR: Complex<f64> = Complex::new(2.681_082_873_627_752, 3.050_430_199_247_410_6);
/// Columns: eigenvector of A⁻¹ to `REAL`, real part and negative imaginary part of that to `PAIR`.
pub(super) const T: [[f64; 3]; 3] = [
    [0.094_438_762_488_975_24, -0.141_255_295_020_954_2, -0.030_029_194_105_147_424],
    [0.250_213_122_965_333_3, 0.204_129_352_293_799_93, 0.382_942_112_757_261_9],
    [1.0, 1.0, 0.0],
];
/// T⁻¹
pub(super) const T_INVERSE: [[f64; 3]; 3] = [
    [4.178_718_591_551_905, 0.327_682_820_761_062_4, 0.523_376_445_499_449_5],
    [-4.178_718_591_551_905, -0.327_682_820_761_062_4, 0.476_623_554_500_550_45],
    [-0.502_872_634_945_786_9, 2.571_926_949_855_605, -0.596_039_204_828_224_9],
];

/// Values at `theta` (0 at the start of the step, 1 at its end) of the polynomials of degree 3 that vanish at 0 and
/// at all stages but one.
#[inline]
pub(super) fn basis(theta: f64) -> [f64; 3] {
    let [a, b, c] = C;
    [
        theta * (theta - b) * (theta - c) / (a * (a - b) * (a - c)),
        theta * (theta - a) * (theta - c) / (b * (b - a) * (b - c)),
        theta * (theta - a) * (theta - b) / (c * (c - a) * (c - b)),
    ]
}

/// Slopes of these polynomials at 0.
pub(super) const SLOPE_AT_START: [f64; 3] = [(13.0 + 7.0 * ROOT) / 3.0, (13.0 - 7.0 * ROOT) / 3.0, 1.0 / 3.0];

/// `matrix · column i of vectors`
#[inline]
pub(super) fn transform(matrix: &[[f64; 3]; 3], vectors: &[Vec<f64>; 3], i: usize) -> [f64; 3] {
    std::array::from_fn(|row| (0..3).map(|k| matrix[row][k] * vectors[k][i]).sum())
}
