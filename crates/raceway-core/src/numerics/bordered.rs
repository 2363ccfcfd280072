//! Symmetric matrices of 2 × 2 blocks along the diagonal and a border: the blocks meet through the border only.
//!
//! Each block is eliminated onto the border (Å. Björck, *Numerical Methods in Matrix Computations*, §1.5). Time and memory grow with the number of
//! blocks; of a dense matrix they grow with its cube and square. Unknowns stand block after block, then the border.

/// A symmetric matrix with a border of at most `B` unknowns. Only the lower triangle is kept.
#[derive(Debug, Clone)]
pub struct Bordered<const B: usize> {
    pub blocks: Vec<Block<B>>,
    pub border: [[f64; B]; B],
    /// Number of unknowns of the border.
    width: usize,
}

/// Two unknowns with their columns below the diagonal.
#[derive(Debug, Clone, Copy)]
pub struct Block<const B: usize> {
    pub diagonal: [f64; 2],
    /// Second row, first column.
    pub between: f64,
    /// Rows of the border, by column of the block.
    pub border: [[f64; B]; 2],
}

impl<const B: usize> Bordered<B> {
    /// A matrix of zeros.
    pub fn zeros(blocks: usize, width: usize) -> Self {
        let empty = Block { diagonal: [0.0; 2], between: 0.0, border: [[0.0; B]; 2] };
        Self { blocks: vec![empty; blocks], border: [[0.0; B]; B], width }
    }

    /// The matrix with a number added to its diagonal.
    pub fn shifted(self, by: f64) -> Self {
        let mut shifted = self.with_shifted_blocks(by);
        for row in 0..shifted.width {
            shifted.border[row][row] += by;
        }
        shifted
    }

    /// The matrix with a number added to the diagonals of its blocks.
    pub fn with_shifted_blocks(mut self, by: f64) -> Self {
        for block in &mut self.blocks {
            block.diagonal = block.diagonal.map(|entry| entry + by);
        }
        self
    }

    /// The border with the blocks eliminated: their Schur complement. Blocks without coupling may be singular.
    pub fn condensed(&self) -> [[f64; B]; B] {
        let mut condensed = self.border;
        for block in self.blocks.iter().filter(|block| block.border != [[0.0; B]; 2]) {
            let ([first, second], between, of) = (block.diagonal, block.between, block.border);
            let per_determinant = 1.0 / (first * second - between * between);
            for (row, entries) in condensed[..self.width].iter_mut().enumerate() {
                let solved = [
                    per_determinant * (second * of[0][row] - between * of[1][row]),
                    per_determinant * (first * of[1][row] - between * of[0][row]),
                ];
                for (column, entry) in entries[..=row].iter_mut().enumerate() {
                    *entry -= solved[0] * of[0][column] + solved[1] * of[1][column];
                }
            }
        }
        let lower = condensed;
        std::array::from_fn(|row| std::array::from_fn(|column| lower[row.max(column)][row.min(column)]))
    }

    /// The matrix with its blocks factored and eliminated onto the border; `None` unless every block is positive definite.
    pub fn eliminated(mut self) -> Option<Eliminated<B>> {
        for block in &mut self.blocks {
            block.factor(self.width)?;
            block.eliminate(&mut self.border, self.width);
        }
        Some(Eliminated(self))
    }

    /// The Cholesky factor, a matrix of the same shape; `None` unless the matrix is positive definite.
    pub fn factor(self) -> Option<Factor<B>> {
        let Eliminated(mut of) = self.eliminated()?;
        for column in 0..of.width {
            for before in 0..column {
                for row in column..of.width {
                    of.border[row][column] -= of.border[column][before] * of.border[row][before];
                }
            }
            let diagonal = positive_root(of.border[column][column])?;
            of.border[column][column] = diagonal;
            for row in column + 1..of.width {
                of.border[row][column] /= diagonal;
            }
        }
        Some(Factor(Eliminated(of)))
    }
}

impl<const B: usize> Block<B> {
    fn factor(&mut self, width: usize) -> Option<()> {
        let [first, second] = &mut self.border;
        let root = positive_root(self.diagonal[0])?;
        self.between /= root;
        first[..width].iter_mut().for_each(|entry| *entry /= root);
        self.diagonal = [root, positive_root(self.diagonal[1] - self.between * self.between)?];
        for (entry, of_first) in second[..width].iter_mut().zip(first) {
            *entry = (*entry - self.between * *of_first) / self.diagonal[1];
        }
        Some(())
    }

    /// Subtracts from the lower triangle of the border what a factored block contributes.
    fn eliminate(&self, border: &mut [[f64; B]; B], width: usize) {
        for (row, entries) in border[..width].iter_mut().enumerate() {
            for (column, entry) in entries[..=row].iter_mut().enumerate() {
                for of in &self.border {
                    *entry -= of[column] * of[row];
                }
            }
        }
    }
}

fn positive_root(square: f64) -> Option<f64> {
    (square > 0.0).then(|| square.sqrt())
}

/// A matrix with its blocks eliminated onto the border.
#[derive(Debug, Clone)]
pub struct Eliminated<const B: usize>(Bordered<B>);

/// A Cholesky factor.
#[derive(Debug, Clone)]
pub struct Factor<const B: usize>(Eliminated<B>);

impl<const B: usize> Eliminated<B> {
    /// Schur complement of the border, in the lower triangle.
    pub fn border(&self) -> &[[f64; B]; B] {
        &self.0.border
    }

    /// Eliminates the blocks of a right-hand side onto its border.
    pub fn reduce(&self, values: &mut [f64]) {
        let (of_blocks, of_border) = values.split_at_mut(2 * self.0.blocks.len());
        for (block, pair) in self.0.blocks.iter().zip(of_blocks.chunks_exact_mut(2)) {
            pair[0] /= block.diagonal[0];
            pair[1] = (pair[1] - pair[0] * block.between) / block.diagonal[1];
            for (row, value) in of_border.iter_mut().enumerate() {
                *value = *value - pair[0] * block.border[0][row] - pair[1] * block.border[1][row];
            }
        }
    }

    /// Replaces a reduced right-hand side, whose border is solved, by the solution.
    pub fn restore(&self, values: &mut [f64]) {
        let Bordered { blocks, width, .. } = &self.0;
        let (of_blocks, of_border) = values.split_at_mut(2 * blocks.len());
        for (index, (block, pair)) in blocks.iter().zip(of_blocks.chunks_exact_mut(2)).enumerate().rev() {
            // Entries between a column of the block and the border.
            let gap = 2 * (blocks.len() - 1 - index);
            let of = |column: usize| block.border[column].iter().zip(&*of_border).map(|(entry, value)| entry * value);
            let mut second = DenseSum::new(gap + width);
            of(1).enumerate().for_each(|(row, product)| second.add(gap + row, product));
            pair[1] = (pair[1] - second.total()) / block.diagonal[1];
            let mut first = DenseSum::new(1 + gap + width);
            first.add(0, block.between * pair[1]);
            of(0).enumerate().for_each(|(row, product)| first.add(1 + gap + row, product));
            pair[0] = (pair[0] - first.total()) / block.diagonal[0];
        }
    }
}

impl<const B: usize> Factor<B> {
    /// Replaces a right-hand side by the solution.
    pub fn solve(&self, values: &mut [f64]) {
        self.0.reduce(values);
        let Bordered { blocks, border, width } = &self.0.0;
        let of_border = &mut values[2 * blocks.len()..];
        for column in 0..*width {
            of_border[column] /= border[column][column];
            for row in column + 1..*width {
                of_border[row] -= of_border[column] * border[row][column];
            }
        }
        for column in (0..*width).rev() {
            let below = (column + 1..*width).map(|row| border[row][column] * of_border[row]).sum::<f64>();
            of_border[column] = (of_border[column] - below) / border[column][column];
        }
        self.0.restore(values);
    }
}

/// A sum of the products of two vectors that are mostly 0, rounded as the sum over all of them by eights side by side. The solution then has
/// the bits of the dense one.
struct DenseSum {
    lanes: [f64; 8],
    /// Products before this place are added in lanes, those after it one by one.
    whole: usize,
    rest: [f64; 8],
}

impl DenseSum {
    fn new(length: usize) -> Self {
        Self { lanes: [0.0; 8], whole: length - length % 8, rest: [0.0; 8] }
    }

    fn add(&mut self, place: usize, product: f64) {
        if place < self.whole {
            self.lanes[place % 8] += product;
        } else {
            self.rest[place - self.whole] = product;
        }
    }

    fn total(&self) -> f64 {
        let lanes = (0..4).map(|lane| self.lanes[lane] + self.lanes[lane + 4]);
        lanes.chain(self.rest).fold(0.0, |sum, part| sum + part)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::numerics::random::SplitMix64;

    /// Solutions for 1 to 64 blocks with 2, 3 and 5 unknowns in the border have the bits of a dense Cholesky solution.
    #[test]
    fn solutions_have_the_bits_of_the_dense_ones() {
        let mut random = SplitMix64::new(1);
        let mut number = || random.uniform() - 0.5;
        for (blocks, width) in [(1, 2), (3, 3), (7, 2), (8, 3), (17, 5), (64, 3)] {
            let mut matrix = Bordered::<5>::zeros(blocks, width);
            let size = 2 * blocks + width;
            let mut dense = DMatrix::<f64>::zeros(size, size);
            for (index, block) in matrix.blocks.iter_mut().enumerate() {
                let at = 2 * index;
                block.diagonal = [3.0 + number(), 3.0 + number()];
                block.between = number();
                dense[(at, at)] = block.diagonal[0];
                dense[(at + 1, at + 1)] = block.diagonal[1];
                dense[(at + 1, at)] = block.between;
                for column in 0..2 {
                    for row in 0..width {
                        block.border[column][row] = number();
                        dense[(2 * blocks + row, at + column)] = block.border[column][row];
                    }
                }
            }
            for row in 0..width {
                for column in 0..=row {
                    let entry = number() + if row == column { 2.0 * blocks as f64 } else { 0.0 };
                    matrix.border[row][column] = entry;
                    dense[(2 * blocks + row, 2 * blocks + column)] = entry;
                }
            }
            let mut values: Vec<f64> = (0..size).map(|_| number()).collect();
            let expected = dense.cholesky().unwrap().solve(&DVector::from_vec(values.clone()));
            matrix.factor().unwrap().solve(&mut values);
            assert_eq!(values, expected.as_slice(), "{blocks} blocks, {width} in the border");
        }
    }

    #[test]
    fn only_a_positive_definite_matrix_has_a_factor() {
        let unit = |shift: f64| Bordered::<2>::zeros(3, 2).shifted(shift);
        assert!(unit(1.0).factor().is_some());
        assert!(unit(0.0).factor().is_none() && unit(-1.0).factor().is_none() && unit(f64::NAN).factor().is_none());
    }
}
