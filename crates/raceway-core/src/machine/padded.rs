//! Matrices padded to whole registers, so that their products take no sum across lanes.

use nalgebra::DMatrix;

use crate::numerics::lanes::LANES;
use crate::physics::frame::support::PORT;

/// Displacements of a place by each coordinate.
#[derive(Debug, Clone)]
pub struct Rows(Vec<[f64; LANES]>);

/// A matrix `constant` + Ω `by_speed`.
#[derive(Debug, Clone)]
pub(super) struct BySpeed {
    pub constant: Padded,
    pub by_speed: Padded,
}

/// A matrix in blocks of rows. Each has its first column that is not zero, and the columns from there to its last one.
#[derive(Debug, Clone)]
pub(super) struct Padded(Vec<(usize, Vec<[f64; LANES]>)>);

impl Rows {
    /// `matrix`: a row for each of x, y, z, β_y, β_z.
    pub(super) fn of(matrix: &DMatrix<f64>) -> Self {
        let of = |column: usize| std::array::from_fn(|row| if row < PORT { matrix[(row, column)] } else { 0.0 });
        Self((0..matrix.ncols()).map(of).collect())
    }

    /// Displacements, or velocities, of the place.
    #[inline(always)]
    pub fn of_place(&self, coordinates: &[f64]) -> [f64; PORT] {
        let sums = weighted_sum(&self.0, coordinates);
        std::array::from_fn(|row| sums[row])
    }

    /// Adds the forces on the coordinates of forces at the place.
    #[inline(always)]
    pub fn add_forces(&self, wrench: &[f64; PORT], forces: &mut [f64]) {
        let [x, y, z, about_y, about_z] = wrench;
        for (force, by) in forces.iter_mut().zip(&self.0) {
            *force += (x * by[0] + y * by[1]) + (z * by[2] + (about_y * by[3] + about_z * by[4]));
        }
    }
}

impl BySpeed {
    /// Adds the product of a factor, the matrix at a speed and a vector.
    #[inline(always)]
    pub fn add_product(&self, factor: f64, speed: f64, vector: &[f64], sums: &mut [f64]) {
        self.constant.add_product(factor, vector, sums);
        self.by_speed.add_product(factor * speed, vector, sums);
    }
}

impl Padded {
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let block = |begin: usize| {
            let of_block = begin..rows.min(begin + LANES);
            let holds = |column: &usize| of_block.clone().any(|row| matrix[(row, *column)] != 0.0);
            let Some(first) = (0..columns).find(holds) else { return (0, Vec::new()) };
            let last = (first..columns).rfind(holds).unwrap_or(first);
            let entries = |column: usize| {
                std::array::from_fn(|lane| if begin + lane < rows { matrix[(begin + lane, column)] } else { 0.0 })
            };
            (first, (first..=last).map(entries).collect())
        };
        Self((0..rows).step_by(LANES).map(block).collect())
    }

    /// Adds the product of a factor, the matrix and a vector. Columns without an entry of the vector count as zero.
    #[inline(always)]
    pub fn add_product(&self, factor: f64, vector: &[f64], sums: &mut [f64]) {
        for ((first, columns), sums) in self.0.iter().zip(sums.chunks_mut(LANES)) {
            if columns.is_empty() || *first >= vector.len() {
                continue;
            }
            let products = weighted_sum(columns, &vector[*first..]);
            sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += factor * product);
        }
    }
}

/// Sum of columns, each times its value.
#[inline(always)]
fn weighted_sum(columns: &[[f64; LANES]], values: &[f64]) -> [f64; LANES] {
    let length = columns.len().min(values.len());
    let ((fours, last), (values, last_value)) = (columns[..length].as_chunks::<4>(), values[..length].as_chunks::<4>());
    // Two sums side by side: one would wait for itself with each column.
    let mut sums = [[0.0; LANES]; 2];
    for (four, values) in fours.iter().zip(values) {
        for column in 0..4 {
            for lane in 0..LANES {
                sums[column % 2][lane] += four[column][lane] * values[column];
            }
        }
    }
    for (column, value) in last.iter().zip(last_value) {
        for lane in 0..LANES {
            sums[0][lane] += column[lane] * value;
        }
    }
    std::array::from_fn(|lane| sums[0][lane] + sums[1][lane])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks with zeros at their edges, an empty one and one that is not full.
    #[test]
    fn a_matrix_times_a_vector() {
        let (rows, columns) = (2 * LANES + 3, 2 * LANES + 5);
        let entry = |row: usize, column: usize| match row / LANES {
            0 if (3..9).contains(&column) => (row * 5 + column) as f64,
            2 => row as f64 - 2.0 * column as f64,
            _ => 0.0,
        };
        let matrix = Padded::of(&DMatrix::from_fn(rows, columns, entry));
        for length in [2, 6, columns] {
            let vector: Vec<f64> = (0..length).map(|k| 1.0 + k as f64).collect();
            let mut sums = vec![1.0; rows];
            matrix.add_product(-0.5, &vector, &mut sums);
            for (row, sum) in sums.into_iter().enumerate() {
                let product: f64 = (0..length).map(|column| entry(row, column) * vector[column]).sum();
                assert_eq!(sum, 1.0 - 0.5 * product, "row {row} of {length} columns");
            }
        }
    }
}
