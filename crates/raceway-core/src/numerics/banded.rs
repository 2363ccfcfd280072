//! Symmetric matrices with three diagonals below the main one: those of chains of two-node elements with two unknowns a node.

/// Number of diagonals below the main one.
const BELOW: usize = 3;

/// A symmetric band matrix: row i holds columns i − 3 … i.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricBand {
    rows: Vec<[f64; BELOW + 1]>,
}

impl SymmetricBand {
    /// The zero matrix of this size.
    pub fn zeros(size: usize) -> Self {
        Self { rows: vec![[0.0; BELOW + 1]; size] }
    }

    /// Adds to an element of the lower triangle; both triangles have it.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows[row][BELOW + column - row] += value;
    }

    /// Adds a multiple of a matrix of the same size.
    pub fn plus(mut self, factor: f64, other: &Self) -> Self {
        for (row, of_other) in self.rows.iter_mut().zip(&other.rows) {
            for (value, more) in row.iter_mut().zip(of_other) {
                *value += factor * more;
            }
        }
        self
    }

    /// The product with a vector.
    pub fn times(&self, vector: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; vector.len()];
        for (i, row) in self.rows.iter().enumerate() {
            product[i] += row[BELOW] * vector[i];
            for j in i.saturating_sub(BELOW)..i {
                let value = row[BELOW + j - i];
                product[i] += value * vector[j];
                product[j] += value * vector[i];
            }
        }
        product
    }

    /// The factor of Cholesky; `None` where the matrix is not positive definite.
    pub fn cholesky(mut self) -> Option<BandFactor> {
        for i in 0..self.rows.len() {
            let first = i.saturating_sub(BELOW);
            for j in first..=i {
                let shared = first.max(j.saturating_sub(BELOW))..j;
                let dot: f64 = shared.map(|k| self.rows[i][BELOW + k - i] * self.rows[j][BELOW + k - j]).sum();
                let rest = self.rows[i][BELOW + j - i] - dot;
                self.rows[i][BELOW + j - i] = match i == j {
                    true if rest > 0.0 => rest.sqrt(),
                    true => return None,
                    false => rest / self.rows[j][BELOW],
                };
            }
        }
        Some(BandFactor { rows: self.rows })
    }
}

/// Lower triangular factor of a band matrix.
#[derive(Debug, Clone)]
pub struct BandFactor {
    rows: Vec<[f64; BELOW + 1]>,
}

impl BandFactor {
    /// The solution for a right-hand side.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = right.to_vec();
        for i in 0..x.len() {
            let dot: f64 = (i.saturating_sub(BELOW)..i).map(|j| self.rows[i][BELOW + j - i] * x[j]).sum();
            x[i] = (x[i] - dot) / self.rows[i][BELOW];
        }
        for i in (0..x.len()).rev() {
            x[i] /= self.rows[i][BELOW];
            for j in i.saturating_sub(BELOW)..i {
                x[j] -= self.rows[i][BELOW + j - i] * x[i];
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A x = b for the second difference squared with a shift, by substitution.
    #[test]
    fn solves_what_it_multiplies() {
        let mut matrix = SymmetricBand::zeros(9);
        for i in 0..9 {
            matrix.add(i, i, 7.0 + i as f64);
            for (distance, value) in [(1, -2.0), (2, 0.5), (3, -0.25)] {
                if i >= distance {
                    matrix.add(i, i - distance, value);
                }
            }
        }
        let x: Vec<f64> = (0..9).map(|i| (i as f64 - 3.3).sin()).collect();
        let solved = matrix.clone().cholesky().unwrap().solve(&matrix.times(&x));
        assert!(solved.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-14));
        assert!(
            matrix
                .plus(-20.0, &{
                    let mut one = SymmetricBand::zeros(9);
                    one.add(4, 4, 1.0);
                    one
                })
                .cholesky()
                .is_none()
        );
    }
}
