//! Factors of `shift · I − J` for an arrowhead Jacobian, real or complex.
//!
//! The positions of pairs `ẋ = v` are eliminated first, `x = (r_x + v)/shift`, which leaves half the
//! unknowns; then block after block, `W = A⁻¹B`, and the border's Schur complement `D − Σ C W`
//! (Å. Björck, *Numerical Methods in Matrix Computations*, §1.5). Linear in the number of blocks.

use nalgebra::ComplexField;

use super::structure::{Jacobian, Structure};

/// The matrix has no inverse, or an entry that is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Singular;

/// Numbers that matrices are made of.
pub trait Number: ComplexField<RealField = f64> + Copy {}
impl<T: ComplexField<RealField = f64> + Copy> Number for T {}

/// Which entries of a block, or of the border, stay after the elimination of positions.
#[derive(Debug, Clone)]
struct Kept {
    /// Entries that stay.
    entries: Vec<usize>,
    /// Positions that go, each with the place in `entries` of its velocity.
    positions: Vec<(usize, usize)>,
}

impl Kept {
    fn new(size: usize, pairs: &[(usize, usize)]) -> Self {
        let gone = |entry: usize| pairs.iter().any(|pair| pair.0 == entry);
        let entries: Vec<usize> = (0..size).filter(|&entry| !gone(entry)).collect();
        let place = |velocity: usize| entries.iter().position(|&entry| entry == velocity).unwrap_or(0);
        let positions = pairs.iter().map(|&(position, velocity)| (position, place(velocity))).collect();
        Self { entries, positions }
    }
}

/// The factors, with room for right-hand sides; allocates only on construction.
#[derive(Debug, Clone)]
pub struct ArrowheadFactors<T> {
    structure: Structure,
    in_block: Kept,
    in_border: Kept,
    shift: T,
    /// Of each block: factors (kept × kept) and their row exchanges.
    blocks: Vec<T>,
    exchanges: Vec<usize>,
    /// Of each block: W = A⁻¹B (kept × border's kept).
    solved_right: Vec<T>,
    /// Of each block: C (border's kept × kept).
    below: Vec<T>,
    corner: Vec<T>,
    corner_exchanges: Vec<usize>,
    /// ∂(kept rates)/∂(positions) over the shift: by their blocks' own positions, by the border's, and those of the border.
    block_by_own: Vec<T>,
    block_by_border: Vec<T>,
    border_by_blocks: Vec<T>,
    border_by_own: Vec<T>,
    reduced: Vec<T>,
    reduced_border: Vec<T>,
}

impl<T: Number> ArrowheadFactors<T> {
    pub fn new(structure: &Structure) -> Self {
        let in_block = Kept::new(structure.block, &structure.block_pairs);
        let in_border = Kept::new(structure.border, &structure.border_pairs);
        let (z, m, p) = (structure.blocks, in_block.entries.len(), in_border.entries.len());
        let (mx, px) = (in_block.positions.len(), in_border.positions.len());
        let zeros = |count: usize| vec![T::zero(); count];
        Self {
            structure: structure.clone(),
            shift: T::one(),
            blocks: zeros(z * m * m),
            exchanges: vec![0; z * m],
            solved_right: zeros(z * m * p),
            below: zeros(z * p * m),
            corner: zeros(p * p),
            corner_exchanges: vec![0; p],
            block_by_own: zeros(z * m * mx),
            block_by_border: zeros(z * m * px),
            border_by_blocks: zeros(z * p * mx),
            border_by_own: zeros(p * px),
            reduced: zeros(z * m),
            reduced_border: zeros(p),
            in_block,
            in_border,
        }
    }

    /// Factors `shift · I − J`.
    pub fn factor(&mut self, jacobian: &Jacobian, shift: T) -> Result<(), Singular> {
        let (z, m, p) = (self.structure.blocks, self.in_block.entries.len(), self.in_border.entries.len());
        let (mx, px) = (self.in_block.positions.len(), self.in_border.positions.len());
        let (wide, border) = (self.structure.block, self.structure.border);
        self.shift = shift;
        let inverse = T::one() / shift;
        reduce(
            jacobian.corner(),
            border,
            (&self.in_border, &self.in_border),
            inverse,
            &mut self.corner,
            &mut self.border_by_own,
        );
        add_diagonal(&mut self.corner, p, shift);
        debug_assert_eq!(self.border_by_own.len(), p * px);
        for index in 0..z {
            let own = &mut self.blocks[index * m * m..(index + 1) * m * m];
            let right = &mut self.solved_right[index * m * p..(index + 1) * m * p];
            let below = &mut self.below[index * p * m..(index + 1) * p * m];
            let exchanges = &mut self.exchanges[index * m..(index + 1) * m];
            let (block, outer) = (&self.in_block, &self.in_border);
            let by_own = &mut self.block_by_own[index * m * mx..(index + 1) * m * mx];
            reduce(jacobian.block(index), wide, (block, block), inverse, own, by_own);
            let by_border = &mut self.block_by_border[index * m * px..(index + 1) * m * px];
            reduce(jacobian.right(index), border, (block, outer), inverse, right, by_border);
            let by_blocks = &mut self.border_by_blocks[index * p * mx..(index + 1) * p * mx];
            reduce(jacobian.below(index), wide, (outer, block), inverse, below, by_blocks);
            add_diagonal(own, m, shift);
            factor(own, m, exchanges)?;
            substitute(own, m, exchanges, right, p);
            subtract_product(&mut self.corner, below, right, (p, m, p));
        }
        factor(&mut self.corner, p, &mut self.corner_exchanges)
    }

    /// Replaces the right-hand side (every copy) by the solution.
    pub fn solve(&mut self, right_side: &mut [T]) {
        for copy in right_side.chunks_exact_mut(self.structure.dimension().max(1)) {
            self.solve_copy(copy);
        }
    }

    fn solve_copy(&mut self, r: &mut [T]) {
        let (z, m, p) = (self.structure.blocks, self.in_block.entries.len(), self.in_border.entries.len());
        let (mx, px) = (self.in_block.positions.len(), self.in_border.positions.len());
        let wide = self.structure.block;
        let (of_blocks, of_border) = r.split_at_mut(z * wide);
        for (row, &entry) in self.in_border.entries.iter().enumerate() {
            let mut sum = of_border[entry];
            for (k, &(position, _)) in self.in_border.positions.iter().enumerate() {
                sum += self.border_by_own[row * px + k] * of_border[position];
            }
            self.reduced_border[row] = sum;
        }
        for index in 0..z {
            let own = &of_blocks[index * wide..(index + 1) * wide];
            let reduced = &mut self.reduced[index * m..(index + 1) * m];
            let by_own = &self.block_by_own[index * m * mx..(index + 1) * m * mx];
            let by_border = &self.block_by_border[index * m * px..(index + 1) * m * px];
            for (row, &entry) in self.in_block.entries.iter().enumerate() {
                let mut sum = own[entry];
                for (k, &(position, _)) in self.in_block.positions.iter().enumerate() {
                    sum += by_own[row * mx + k] * own[position];
                }
                for (k, &(position, _)) in self.in_border.positions.iter().enumerate() {
                    sum += by_border[row * px + k] * of_border[position];
                }
                reduced[row] = sum;
            }
            let exchanges = &self.exchanges[index * m..(index + 1) * m];
            substitute(&self.blocks[index * m * m..(index + 1) * m * m], m, exchanges, reduced, 1);
            let below = &self.below[index * p * m..(index + 1) * p * m];
            let by_blocks = &self.border_by_blocks[index * p * mx..(index + 1) * p * mx];
            for row in 0..p {
                let mut sum = self.reduced_border[row];
                for (k, &(position, _)) in self.in_block.positions.iter().enumerate() {
                    sum += by_blocks[row * mx + k] * own[position];
                }
                for (k, &value) in reduced.iter().enumerate() {
                    sum -= below[row * m + k] * value;
                }
                self.reduced_border[row] = sum;
            }
        }
        substitute(&self.corner, p, &self.corner_exchanges, &mut self.reduced_border, 1);
        let inverse = T::one() / self.shift;
        for index in 0..z {
            let own = &mut of_blocks[index * wide..(index + 1) * wide];
            let reduced = &mut self.reduced[index * m..(index + 1) * m];
            let right = &self.solved_right[index * m * p..(index + 1) * m * p];
            for (row, value) in reduced.iter_mut().enumerate() {
                for (k, &outer) in self.reduced_border.iter().enumerate() {
                    *value -= right[row * p + k] * outer;
                }
            }
            expand(&self.in_block, reduced, inverse, own);
        }
        expand(&self.in_border, &self.reduced_border, inverse, of_border);
    }
}

/// Velocities and the rest into their places, positions from them: `x = (r_x + v)/shift`.
fn expand<T: Number>(kept: &Kept, reduced: &[T], inverse: T, full: &mut [T]) {
    for &(position, velocity) in &kept.positions {
        full[position] = (full[position] + reduced[velocity]) * inverse;
    }
    for (&entry, &value) in kept.entries.iter().zip(reduced) {
        full[entry] = value;
    }
}

/// Writes −J over the kept entries, positions folded into their velocities, and what the positions do, over the shift.
fn reduce<T: Number>(
    jacobian: &[f64],
    width: usize,
    (rows, columns): (&Kept, &Kept),
    inverse: T,
    matrix: &mut [T],
    by_position: &mut [T],
) {
    let (n, nx) = (columns.entries.len(), columns.positions.len());
    for (row, &entry) in rows.entries.iter().enumerate() {
        let source = &jacobian[entry * width..(entry + 1) * width];
        let target = &mut matrix[row * n..(row + 1) * n];
        for (value, &column) in target.iter_mut().zip(&columns.entries) {
            *value = T::from_real(-source[column]);
        }
        for (k, &(position, velocity)) in columns.positions.iter().enumerate() {
            let folded = inverse * T::from_real(source[position]);
            by_position[row * nx + k] = folded;
            target[velocity] -= folded;
        }
    }
}

fn add_diagonal<T: Number>(matrix: &mut [T], n: usize, shift: T) {
    for i in 0..n {
        matrix[i * n + i] += shift;
    }
}

/// `target −= a · b` with sizes (rows, inner, columns), all row by row.
fn subtract_product<T: Number>(target: &mut [T], a: &[T], b: &[T], (rows, inner, columns): (usize, usize, usize)) {
    for row in 0..rows {
        let target = &mut target[row * columns..(row + 1) * columns];
        for k in 0..inner {
            let weight = a[row * inner + k];
            for (value, &right) in target.iter_mut().zip(&b[k * columns..(k + 1) * columns]) {
                *value -= weight * right;
            }
        }
    }
}

/// Replaces a matrix by its triangular factors, with partial pivoting.
fn factor<T: Number>(matrix: &mut [T], n: usize, exchanges: &mut [usize]) -> Result<(), Singular> {
    for k in 0..n {
        let (mut pivot, mut largest) = (k, matrix[k * n + k].norm1());
        for row in k + 1..n {
            let size = matrix[row * n + k].norm1();
            if size > largest {
                (pivot, largest) = (row, size);
            }
        }
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(Singular);
        }
        exchanges[k] = pivot;
        if pivot != k {
            for column in 0..n {
                matrix.swap(k * n + column, pivot * n + column);
            }
        }
        let inverse = T::one() / matrix[k * n + k];
        let (upper, lower) = matrix.split_at_mut((k + 1) * n);
        let pivot_row = &upper[k * n..];
        for row in lower.chunks_exact_mut(n) {
            let weight = row[k] * inverse;
            row[k] = weight;
            for (value, &above) in row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
                *value -= weight * above;
            }
        }
    }
    Ok(())
}

/// Solves for `columns` right-hand sides at once (row by row, in place).
fn substitute<T: Number>(factors: &[T], n: usize, exchanges: &[usize], right: &mut [T], columns: usize) {
    for (k, &pivot) in exchanges.iter().enumerate() {
        if pivot != k {
            for column in 0..columns {
                right.swap(k * columns + column, pivot * columns + column);
            }
        }
    }
    for row in 1..n {
        let (known, rest) = right.split_at_mut(row * columns);
        for k in 0..row {
            let weight = factors[row * n + k];
            for (value, &above) in rest[..columns].iter_mut().zip(&known[k * columns..(k + 1) * columns]) {
                *value -= weight * above;
            }
        }
    }
    for row in (0..n).rev() {
        let (rest, known) = right.split_at_mut((row + 1) * columns);
        let target = &mut rest[row * columns..];
        for k in row + 1..n {
            let weight = factors[row * n + k];
            for (value, &below) in target.iter_mut().zip(&known[(k - row - 1) * columns..(k - row) * columns]) {
                *value -= weight * below;
            }
        }
        let inverse = T::one() / factors[row * n + row];
        for value in target {
            *value *= inverse;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Complex, DMatrix, DVector};

    /// Entries without order or symmetry.
    fn noise(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    fn arrowhead() -> (Jacobian, DMatrix<f64>) {
        let structure = Structure {
            blocks: 3,
            block: 5,
            border: 4,
            block_pairs: vec![(0, 2), (1, 3)],
            border_pairs: vec![(0, 2)],
            copies: 2,
        };
        let mut jacobian = Jacobian::new(&structure);
        let mut seed = 7;
        let is_position = |pairs: &[(usize, usize)], row: usize| pairs.iter().find(|pair| pair.0 == row).copied();
        let mut dense = DMatrix::zeros(19, 19);
        for index in 0..3 {
            for row in 0..5 {
                let pair = is_position(&structure.block_pairs, row);
                for column in 0..5 {
                    let value = match pair {
                        Some((_, velocity)) => f64::from(u8::from(column == velocity)),
                        None => noise(&mut seed),
                    };
                    jacobian.block_mut(index)[row * 5 + column] = value;
                    dense[(index * 5 + row, index * 5 + column)] = value;
                }
                for column in 0..4 {
                    let value = if pair.is_some() { 0.0 } else { noise(&mut seed) };
                    jacobian.right_mut(index)[row * 4 + column] = value;
                    dense[(index * 5 + row, 15 + column)] = value;
                }
            }
            for row in 0..4 {
                for column in 0..5 {
                    let pair = is_position(&structure.border_pairs, row);
                    let value = if pair.is_some() { 0.0 } else { noise(&mut seed) };
                    jacobian.below_mut(index)[row * 5 + column] = value;
                    dense[(15 + row, index * 5 + column)] = value;
                }
            }
        }
        for row in 0..4 {
            for column in 0..4 {
                let value = match is_position(&structure.border_pairs, row) {
                    Some((_, velocity)) => f64::from(u8::from(column == velocity)),
                    None => noise(&mut seed),
                };
                jacobian.corner_mut()[row * 4 + column] = value;
                dense[(15 + row, 15 + column)] = value;
            }
        }
        (jacobian, dense)
    }

    /// A dense solve of the same matrix, real and complex, each of two copies.
    #[test]
    fn solves_what_a_dense_solver_solves() {
        let (jacobian, dense) = arrowhead();
        let mut seed = 11;
        let right: Vec<f64> = (0..38).map(|_| noise(&mut seed)).collect();
        let mut real = ArrowheadFactors::<f64>::new(jacobian.structure());
        real.factor(&jacobian, 0.37).unwrap();
        let mut solution = right.clone();
        real.solve(&mut solution);
        let matrix = DMatrix::identity(19, 19) * 0.37 - &dense;
        for copy in 0..2 {
            let part = 19 * copy..19 * (copy + 1);
            let residual = &matrix * DVector::from_column_slice(&solution[part.clone()])
                - DVector::from_column_slice(&right[part]);
            assert!(residual.amax() < 1e-12, "{residual}");
        }

        let shift = Complex::new(0.3, 0.8);
        let mut factors = ArrowheadFactors::<Complex<f64>>::new(jacobian.structure());
        factors.factor(&jacobian, shift).unwrap();
        let right: Vec<Complex<f64>> = right.iter().map(|&x| Complex::new(x, -0.4 * x + 0.1)).collect();
        let mut solution = right.clone();
        factors.solve(&mut solution);
        let matrix = DMatrix::identity(19, 19) * shift - dense.map(|x| Complex::new(x, 0.0));
        for copy in 0..2 {
            let part = 19 * copy..19 * (copy + 1);
            let residual = &matrix * DVector::from_column_slice(&solution[part.clone()])
                - DVector::from_column_slice(&right[part]);
            assert!(residual.iter().all(|x| x.norm() < 1e-12), "{residual}");
        }
    }

    #[test]
    fn multiplies_like_the_dense_matrix() {
        let (jacobian, dense) = arrowhead();
        let vector: Vec<f64> = (0..19).map(|i| (i as f64).sin()).collect();
        let mut product = vec![0.0; 19];
        jacobian.multiply(&vector, &mut product);
        let expected = dense * DVector::from_column_slice(&vector);
        assert!((DVector::from_column_slice(&product) - expected).amax() < 1e-14);
    }

    #[test]
    fn a_singular_matrix_is_told() {
        let jacobian = Jacobian::new(&Structure::dense(3));
        let mut factors = ArrowheadFactors::<f64>::new(jacobian.structure());
        assert_eq!(factors.factor(&jacobian, 0.0), Err(Singular));
        assert_eq!(factors.factor(&jacobian, f64::NAN), Err(Singular));
        assert_eq!(factors.factor(&jacobian, 1.0), Ok(()));
    }
}
