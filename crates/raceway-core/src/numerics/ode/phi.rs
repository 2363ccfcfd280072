//! The matrix functions φ₁…φ₄ of exponential integrators by precise integration.
//!
//! φₖ(Z) = ∫₀¹ e^{(1−θ)Z} θᵏ⁻¹/(k−1)! dθ, so that Zφₖ₊₁ = φₖ − I/k! with φ₀ = e^Z. As in W. X. Zhong's precise time
//! integration (J. Comput. Appl. Math. 163 (2004) 59–78) a series at Z/2ᴺ is doubled N times, and e^Z − I is carried, not e^Z:
//! added to I at the small argument it would lose as many digits as I is larger.

use nalgebra::DMatrix;

/// φ₁, φ₂, φ₃, φ₄ of one matrix, each laid out as that matrix.
pub(crate) type Phi = [Vec<f64>; 4];

/// Largest 1-norm at which the series is used: 13 terms of φ₄ then leave 4!/17! · 2⁻¹³ ≈ 1e-17.
const MAX_NORM: f64 = 0.5;
const TERMS: usize = 13;
/// Beyond 2^this a matrix has no business in a step.
const MAX_DOUBLINGS: i32 = 60;
/// 1/k!
const INVERSE_FACTORIAL: [f64; 5] = [1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0];

/// φ₁…φ₄ of an n × n matrix, row by row or column by column; entries that are not finite give NaN.
pub(crate) fn phi(matrix: &[f64], n: usize) -> Phi {
    let scales = balance(matrix, n);
    let scaled = |row: usize, column: usize| matrix[row * n + column] * scales[column] / scales[row];
    let mut balanced: Vec<f64> = (0..n * n).map(|i| scaled(i / n, i % n)).collect();
    let norm = norm(&balanced, n);
    let doublings = if norm.is_finite() { (norm / MAX_NORM).log2().ceil().max(0.0) as i32 } else { MAX_DOUBLINGS };
    let doublings = doublings.min(MAX_DOUBLINGS);
    balanced.iter_mut().for_each(|x| *x *= 0.5_f64.powi(doublings));
    let mut functions = series(&balanced, n);
    double(&mut functions, &balanced, n, doublings);
    for function in &mut functions {
        for (i, x) in function.iter_mut().enumerate() {
            *x *= scales[i / n] / scales[i % n];
        }
    }
    functions
}

/// e^Z of a matrix, balanced first.
pub(crate) fn exponential(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    // Column by column: the balance of the transposed matrix divides where that of the matrix multiplies.
    let scales = balance(matrix.as_slice(), n);
    let factor = |row: usize, column: usize| scales[row] / scales[column];
    for column in 0..n {
        (0..n).for_each(|row| matrix[(row, column)] *= factor(row, column));
    }
    let mut whole = matrix.exp();
    for column in 0..n {
        (0..n).for_each(|row| whole[(row, column)] /= factor(row, column));
    }
    whole
}

/// From φ₁…φ₄ of a matrix those of 2ᴺ times the matrix:
/// φₖ(2Z) = 2⁻ᵏ (φₖ + (e^Z − I) φₖ + Σⱼ φⱼ/(k−j)!), e^{2Z} − I = 2 (e^Z − I) + (e^Z − I)².
pub(crate) fn double(functions: &mut Phi, matrix: &[f64], n: usize, doublings: i32) {
    let mut product = vec![0.0; n * n];
    let mut increment = vec![0.0; n * n];
    multiply(matrix, &functions[0], n, &mut increment);
    for _ in 0..doublings {
        // From φ₄ down: each needs the old ones below it.
        for k in (1..=4).rev() {
            multiply(&increment, &functions[k - 1], n, &mut product);
            let (below, own) = functions.split_at_mut(k - 1);
            let half = 0.5_f64.powi(k as i32);
            for (i, value) in own[0].iter_mut().enumerate() {
                let sum: f64 = (1..k).map(|j| INVERSE_FACTORIAL[k - j] * below[j - 1][i]).sum();
                *value = half * (2.0 * *value + product[i] + sum);
            }
        }
        multiply(&increment, &increment, n, &mut product);
        for (value, square) in increment.iter_mut().zip(&product) {
            *value = 2.0 * *value + square;
        }
    }
}

/// φ₄ = Σ Zⁱ/(i+4)! by Horner's rule, the others by φₖ = I/k! + Z φₖ₊₁.
fn series(matrix: &[f64], n: usize) -> Phi {
    let mut functions: Phi = std::array::from_fn(|_| vec![0.0; n * n]);
    let mut product = vec![0.0; n * n];
    for i in (4..TERMS + 4).rev() {
        multiply(matrix, &functions[3], n, &mut product);
        std::mem::swap(&mut functions[3], &mut product);
        add_diagonal(&mut functions[3], n, 1.0 / (2..=i).map(|j| j as f64).product::<f64>());
    }
    for k in (1..4).rev() {
        let (low, high) = functions.split_at_mut(k);
        multiply(matrix, &high[0], n, &mut low[k - 1]);
        add_diagonal(&mut low[k - 1], n, INVERSE_FACTORIAL[k]);
    }
    functions
}

/// Powers of two that bring rows and columns to the same size when column i is multiplied and row i divided by them
/// (E. E. Osborne, J. ACM 7 (1960) 338–345): positions and velocities differ by a million in their units.
fn balance(matrix: &[f64], n: usize) -> Vec<f64> {
    const SWEEPS: usize = 10;
    let mut scales = vec![1.0; n];
    for _ in 0..SWEEPS {
        let mut settled = true;
        for i in 0..n {
            let others = |size: &dyn Fn(usize) -> f64| (0..n).filter(|&j| j != i).map(size).sum::<f64>();
            let column = others(&|j| (matrix[j * n + i] * scales[i] / scales[j]).abs());
            let row = others(&|j| (matrix[i * n + j] * scales[j] / scales[i]).abs());
            if column > 0.0 && row > 0.0 && (row / column).is_finite() {
                let factor = (0.5 * (row / column).log2()).round().exp2();
                settled &= factor == 1.0;
                scales[i] *= factor;
            }
        }
        if settled {
            break;
        }
    }
    scales
}

/// Largest sum of a line's absolute entries.
fn norm(matrix: &[f64], n: usize) -> f64 {
    let sum = |line: &[f64]| line.iter().map(|x| x.abs()).sum::<f64>();
    matrix.chunks_exact(n.max(1)).map(sum).fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) })
}

fn add_diagonal(matrix: &mut [f64], n: usize, value: f64) {
    matrix.iter_mut().step_by(n + 1).for_each(|x| *x += value);
}

/// `product = a · b`; all commute, so that it does not matter whether lines are rows or columns.
fn multiply(a: &[f64], b: &[f64], n: usize, product: &mut [f64]) {
    match n {
        5 => multiply_lines::<5>(a, b, product),
        9 => multiply_lines::<9>(a, b, product),
        10 => multiply_lines::<10>(a, b, product),
        16 => multiply_lines::<16>(a, b, product),
        _ => {
            product.fill(0.0);
            for (line, target) in a.chunks_exact(n.max(1)).zip(product.chunks_exact_mut(n.max(1))) {
                for (&weight, line) in line.iter().zip(b.chunks_exact(n)) {
                    target.iter_mut().zip(line).for_each(|(value, x)| *value += weight * x);
                }
            }
        }
    }
}

/// Variant for sizes known at compile time: balls, and cage with spindle.
fn multiply_lines<const N: usize>(a: &[f64], b: &[f64], product: &mut [f64]) {
    let (a, b, product) = (a.as_chunks::<N>().0, b.as_chunks::<N>().0, product.as_chunks_mut::<N>().0);
    for (line, target) in a.iter().zip(product) {
        let mut sum = [0.0; N];
        for (&weight, line) in line.iter().zip(b) {
            for i in 0..N {
                sum[i] += weight * line[i];
            }
        }
        *target = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// φₖ of a number by its recursion, upwards where that is stable.
    fn exact(z: f64) -> [f64; 4] {
        let one = z.exp_m1() / z;
        let two = (one - 1.0) / z;
        let three = (two - 0.5) / z;
        [one, two, three, (three - 1.0 / 6.0) / z]
    }

    #[test]
    fn of_a_number_they_are_the_closed_forms() {
        for z in [-400.0, -30.0, -3.0, 2.0] {
            for (computed, exact) in phi(&[z], 1).iter().zip(exact(z)) {
                assert!((computed[0] / exact - 1.0).abs() < 1e-13, "{z}: {} {exact}", computed[0]);
            }
        }
        for (k, computed) in phi(&[0.0], 1).iter().enumerate() {
            assert_eq!(computed[0], INVERSE_FACTORIAL[k + 1]);
        }
        assert!(phi(&[f64::NAN], 1)[0][0].is_nan());
    }

    /// An oscillator in units that differ by 1e12: Z φ₁ + I is a rotation.
    #[test]
    fn an_oscillator_in_ill_matched_units_turns() {
        let (frequency, step) = (1e6, 7e-6);
        let z = [0.0, step, -frequency * frequency * step, 0.0];
        let one = &phi(&z, 2)[0];
        let turned = [1.0 + z[1] * one[2], z[1] * one[3], z[2] * one[0], 1.0 + z[2] * one[1]];
        let (sine, cosine) = (frequency * step).sin_cos();
        let expected = [cosine, sine / frequency, -sine * frequency, cosine];
        for (value, expected) in turned.iter().zip(expected) {
            assert!((value / expected - 1.0).abs() < 1e-13, "{turned:?}");
        }
    }

    /// Zhong's point: with N = 20 the increment kept apart gives full accuracy, e^Z itself loses 2^20 roundings.
    #[test]
    fn the_increment_is_kept_apart() {
        let (z, doublings) = (-0.7_f64, 20);
        let small = z * 0.5_f64.powi(doublings);
        let four = small + small * small * (1.0 + small / 3.0 + small * small / 12.0) / 2.0;
        let (mut apart, mut together) = (four, 1.0 + four);
        for _ in 0..doublings {
            apart = 2.0 * apart + apart * apart;
            together *= together;
        }
        assert!((1.0 + apart - z.exp()).abs() < 3e-16);
        assert!((together - z.exp()).abs() > 1e-12, "{:e}", together - z.exp());
        // The functions themselves, by many doublings or by few.
        let mut many = series(&[small], 1);
        double(&mut many, &[small], 1, doublings);
        for (many, few) in many.iter().zip(phi(&[z], 1)) {
            assert!((many[0] / few[0] - 1.0).abs() < 2e-15, "{} {}", many[0], few[0]);
        }
    }
}
