//! Transfer functions y = R q of q̈ + C q̇ + K q = B u, at many frequencies.

use nalgebra::{Complex, DMatrix};

/// y over u. The first-order system is a Hessenberg matrix, so that each frequency takes an elimination below its diagonal alone.
#[derive(Debug, Clone)]
pub struct TransferFunction {
    /// H of A = Q H Qᵀ for the state (ω₀ q, q̇), in rows.
    hessenberg: Vec<Vec<f64>>,
    /// Qᵀ (0, B), in rows.
    inputs: Vec<Vec<f64>>,
    /// (R/ω₀, 0) Q
    outputs: DMatrix<f64>,
}

impl TransferFunction {
    pub fn of([stiffness, damping]: [&DMatrix<f64>; 2], inputs: &DMatrix<f64>, outputs: &DMatrix<f64>) -> Self {
        let size = stiffness.nrows();
        // Places times this are of the size of velocities, which keeps rounding small against slow motions.
        let scale = stiffness.amax().sqrt();
        let mut state = DMatrix::zeros(2 * size, 2 * size);
        state.view_mut((0, size), (size, size)).fill_diagonal(scale);
        state.view_mut((size, 0), (size, size)).copy_from(&(-stiffness / scale));
        state.view_mut((size, size), (size, size)).copy_from(&-damping);
        let (basis, hessenberg) = state.hessenberg().unpack();
        let [of_places, of_velocities] = [0, size].map(|first| basis.rows(first, size));
        Self {
            hessenberg: rows(&hessenberg),
            inputs: rows(&(of_velocities.transpose() * inputs)),
            outputs: outputs / scale * of_places,
        }
    }

    /// Values at an angular frequency [rad/s]: a row for each of y, a column for each of u.
    pub fn at(&self, frequency: f64) -> DMatrix<Complex<f64>> {
        let size = self.hessenberg.len();
        // Each row of iω − H, and behind it that of the inputs.
        let row = |(index, (left, right)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let mut row: Vec<Complex<f64>> = left.iter().map(|value| Complex::from(-value)).collect();
            row[index] += Complex::new(0.0, frequency);
            row.extend(right.iter().copied().map(Complex::from));
            row
        };
        let mut rows: Vec<_> = self.hessenberg.iter().zip(&self.inputs).enumerate().map(row).collect();
        for pivot in 0..size - 1 {
            if rows[pivot + 1][pivot].norm_sqr() > rows[pivot][pivot].norm_sqr() {
                rows.swap(pivot, pivot + 1);
            }
            let (above, below) = rows.split_at_mut(pivot + 1);
            subtract(&mut below[0], &above[pivot], pivot);
        }
        for pivot in (0..size).rev() {
            let diagonal = rows[pivot][pivot];
            rows[pivot][size..].iter_mut().for_each(|value| *value /= diagonal);
            let (above, below) = rows.split_at_mut(pivot);
            for row in above {
                let factor = row[pivot];
                row[size..].iter_mut().zip(&below[0][size..]).for_each(|(value, by)| *value -= factor * by);
            }
        }
        let solved = DMatrix::from_fn(size, self.inputs[0].len(), |state, input| rows[state][size + input]);
        self.outputs.map(Complex::from) * solved
    }
}

/// Subtracts the multiple of a row that makes the entry of its pivot zero.
fn subtract(row: &mut [Complex<f64>], of: &[Complex<f64>], pivot: usize) {
    let factor = row[pivot] / of[pivot];
    row[pivot..].iter_mut().zip(&of[pivot..]).for_each(|(value, by)| *value -= factor * by);
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::quadratic_eigen::dynamic_stiffness;

    #[test]
    fn values_are_those_of_the_dynamic_stiffness() {
        let size = 6;
        let entry = |row: usize, column: usize| ((7 * row + 3 * column) as f64).sin();
        let stiffness = DMatrix::from_fn(size, size, |row, column| {
            let far = if row == column { 1e4 * 40_f64.powi(row as i32) } else { 0.0 };
            far + 1e3 * entry(row, column)
        });
        let damping = DMatrix::from_fn(size, size, |row, column| 5.0 * entry(column, row + 1));
        let inputs = DMatrix::from_fn(size, 2, entry);
        let outputs = DMatrix::from_fn(3, size, |row, column| entry(column + 2, row));
        let transfer = TransferFunction::of([&stiffness, &damping], &inputs, &outputs);
        for frequency in [0.0, 3.0, 130.0, 4e3, 2e5] {
            let solved = dynamic_stiffness(Complex::new(0.0, frequency), &stiffness, &damping)
                .lu()
                .solve(&inputs.map(Complex::from))
                .unwrap();
            let expected = outputs.map(Complex::from) * solved;
            let apart = (transfer.at(frequency) - &expected).map(|value| value.norm()).amax();
            assert!(apart < 1e-8 * expected.map(|value| value.norm()).amax(), "{frequency}: {apart}");
        }
    }
}
