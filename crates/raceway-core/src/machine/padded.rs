//! Matrices over the coordinates, padded to whole registers, so that their products take no sum across lanes.

use nalgebra::DMatrix;

use crate::numerics::lanes::LANES;
use crate::physics::frame::support::PORT;

/// Displacements of a place by each coordinate.
#[derive(Debug, Clone)]
pub struct Rows(Vec<[f64; LANES]>);

/// A matrix `constant` + Ω `by_speed` over the coordinates.
#[derive(Debug, Clone)]
pub(super) struct Coupling {
    pub constant: Square,
    pub by_speed: Square,
}

/// A square matrix in blocks of rows. Each has its first column that is not zero, and the columns from there to its last one.
#[derive(Debug, Clone)]
pub(super) struct Square(Vec<(usize, Vec<[f64; LANES]>)>);

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

    /// Displacements of this place by forces at another, each coordinate with its weight, as a row of columns for each of them.
    pub(super) fn compliance(&self, other: &Self, weights: &[f64]) -> [[f64; LANES]; PORT] {
        let sum = |row: usize, column: usize| -> f64 {
            self.0.iter().zip(&other.0).zip(weights).map(|((a, b), weight)| a[row] * b[column] * weight).sum()
        };
        std::array::from_fn(|row| std::array::from_fn(|column| sum(row, column)))
    }
}

impl Coupling {
    /// Subtracts the product of the matrix at a speed with a vector.
    #[inline(always)]
    pub fn subtract(&self, speed: f64, vector: &[f64], forces: &mut [f64]) {
        self.constant.subtract(1.0, vector, forces);
        self.by_speed.subtract(speed, vector, forces);
    }
}

impl Square {
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let size = matrix.nrows();
        let block = |begin: usize| {
            let rows = begin..size.min(begin + LANES);
            let holds = |column: &usize| rows.clone().any(|row| matrix[(row, *column)] != 0.0);
            let Some(first) = (0..size).find(holds) else { return (0, Vec::new()) };
            let last = (first..size).rfind(holds).unwrap_or(first);
            let entries = |column: usize| {
                std::array::from_fn(|lane| if begin + lane < size { matrix[(begin + lane, column)] } else { 0.0 })
            };
            (first, (first..=last).map(entries).collect())
        };
        Self((0..size).step_by(LANES).map(block).collect())
    }

    /// Largest sum of the magnitudes in a row.
    pub fn largest_row(&self) -> f64 {
        let row = |columns: &[[f64; LANES]], lane: usize| columns.iter().map(|column| column[lane].abs()).sum::<f64>();
        self.0.iter().flat_map(|(_, columns)| (0..LANES).map(|lane| row(columns, lane))).fold(0.0, f64::max)
    }

    /// Subtracts the product of a factor, the matrix and a vector.
    #[inline(always)]
    fn subtract(&self, factor: f64, vector: &[f64], forces: &mut [f64]) {
        for ((first, columns), forces) in self.0.iter().zip(forces.chunks_mut(LANES)) {
            if columns.is_empty() {
                continue;
            }
            let sums = weighted_sum(columns, &vector[*first..]);
            forces.iter_mut().zip(sums).for_each(|(force, sum)| *force -= factor * sum);
        }
    }
}

/// Sum of columns, each times its value.
#[inline(always)]
fn weighted_sum(columns: &[[f64; LANES]], values: &[f64]) -> [f64; LANES] {
    let length = columns.len().min(values.len());
    let ((pairs, last), (values, last_value)) = (columns[..length].as_chunks::<2>(), values[..length].as_chunks::<2>());
    // Two sums side by side: one would wait for itself with each column.
    let mut sums = [[0.0; LANES]; 2];
    for (pair, values) in pairs.iter().zip(values) {
        for side in 0..2 {
            for lane in 0..LANES {
                sums[side][lane] += pair[side][lane] * values[side];
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
    fn a_square_matrix_times_a_vector() {
        let size = 2 * LANES + 3;
        let entry = |row: usize, column: usize| match row / LANES {
            0 if (3..9).contains(&column) => (row * 5 + column) as f64,
            2 => row as f64 - 2.0 * column as f64,
            _ => 0.0,
        };
        let square = Square::of(&DMatrix::from_fn(size, size, entry));
        let vector: Vec<f64> = (0..size).map(|k| 1.0 + k as f64).collect();
        let mut forces = vec![1.0; size];
        square.subtract(0.5, &vector, &mut forces);
        for (row, force) in forces.into_iter().enumerate() {
            let product: f64 = (0..size).map(|column| entry(row, column) * vector[column]).sum();
            assert_eq!(force, 1.0 - 0.5 * product, "row {row}");
        }
        let largest = |row: usize| (0..size).map(|column| entry(row, column).abs()).sum::<f64>();
        assert_eq!(square.largest_row(), (0..size).map(largest).fold(0.0, f64::max));
    }
}
