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

/// Blocks are worked on side by side in groups of so many.
const LANES: usize = 8;

/// The factors, with room for right-hand sides; allocates only on construction.
///
/// Kept as the small matrices that a solution needs, since one factor serves many right-hand sides. With the rows `v` that
/// stay and the positions `x = (r_x + v)/s` that go, `R` and `C` what border and block do to each other:
/// ```text
/// border    b_v = S⁻¹ (r_v + G r_x + Σ F r_block)
/// blocks    v   = E r_block + U b
/// ```
/// where `E = A⁻¹ (I | ∂v'/∂x / s)`, `U = A⁻¹ R`, and `F` and `G` carry blocks' and border's positions to the border.
#[derive(Debug, Clone)]
pub struct ArrowheadFactors<T> {
    structure: Structure,
    in_block: Kept,
    in_border: Kept,
    inverse_shift: T,
    /// E, U and F of all blocks: entry by entry, the blocks of a group side by side.
    own: Vec<[T; LANES]>,
    by_border: Vec<[T; LANES]>,
    to_border: Vec<[T; LANES]>,
    /// G and S⁻¹, row by row.
    border_positions: Vec<T>,
    border_inverse: Vec<T>,
    work: Work<T>,
}

/// Room for factors and right-hand sides.
#[derive(Debug, Clone)]
struct Work<T> {
    /// A and the right-hand sides (I | ∂v'/∂x / s | R) that it is solved for.
    block: Vec<T>,
    wide: Vec<T>,
    /// C.
    below: Vec<T>,
    /// S, and the identity.
    corner: Vec<T>,
    exchanges: Vec<usize>,
    /// Right-hand side of a group of blocks, the border's, and the border's solution.
    group: Vec<[T; LANES]>,
    border: Vec<T>,
    border_solution: Vec<T>,
}

impl<T: Number> ArrowheadFactors<T> {
    pub fn new(structure: &Structure) -> Self {
        let in_block = Kept::new(structure.block, &structure.block_pairs);
        let in_border = Kept::new(structure.border, &structure.border_pairs);
        let (m, p) = (in_block.entries.len(), in_border.entries.len());
        let (block, border, px) = (structure.block, structure.border, in_border.positions.len());
        let groups = structure.blocks.div_ceil(LANES);
        let zeros = |count: usize| vec![T::zero(); count];
        let lanes = |count: usize| vec![[T::zero(); LANES]; groups * count];
        Self {
            structure: structure.clone(),
            inverse_shift: T::one(),
            own: lanes(m * block),
            by_border: lanes(m * border),
            to_border: lanes(p * block),
            border_positions: zeros(p * px),
            border_inverse: zeros(p * p),
            work: Work {
                block: zeros(m * m),
                wide: zeros(m * (block + border)),
                below: zeros(p * m),
                corner: zeros(p * p),
                exchanges: vec![0; m.max(p)],
                group: vec![[T::zero(); LANES]; block],
                border: zeros(p),
                border_solution: zeros(border),
            },
            in_block,
            in_border,
        }
    }

    /// Factors `shift · I − J`.
    pub fn factor(&mut self, jacobian: &Jacobian, shift: T) -> Result<(), Singular> {
        let (block, border) = (self.structure.block, self.structure.border);
        let (inner, outer) = (&self.in_block, &self.in_border);
        let (m, p, px) = (inner.entries.len(), outer.entries.len(), outer.positions.len());
        let inverse = T::one() / shift;
        self.inverse_shift = inverse;
        let work = &mut self.work;
        reduce(jacobian.corner(), border, (outer, outer), inverse, &mut work.corner);
        add_diagonal(&mut work.corner, p, shift);
        for (row, &entry) in outer.entries.iter().enumerate() {
            for (k, &(position, _)) in outer.positions.iter().enumerate() {
                self.border_positions[row * px + k] =
                    inverse * T::from_real(jacobian.corner()[entry * border + position]);
            }
        }
        let width = block + border;
        for index in 0..self.structure.blocks {
            reduce(jacobian.block(index), block, (inner, inner), inverse, &mut work.block);
            add_diagonal(&mut work.block, m, shift);
            factor(&mut work.block, m, &mut work.exchanges)?;
            work.wide.fill(T::zero());
            for (row, &entry) in inner.entries.iter().enumerate() {
                let target = &mut work.wide[row * width..(row + 1) * width];
                target[entry] = T::one();
                for &(position, _) in &inner.positions {
                    target[position] = inverse * T::from_real(jacobian.block(index)[entry * block + position]);
                }
                let right = &jacobian.right(index)[entry * border..(entry + 1) * border];
                for (value, &right) in target[block..].iter_mut().zip(right) {
                    *value = T::from_real(right);
                }
            }
            substitute(&work.block, m, &work.exchanges, &mut work.wide, width);
            reduce(jacobian.below(index), block, (outer, inner), inverse, &mut work.below);

            let (group, lane) = (index / LANES, index % LANES);
            let own = &mut self.own[group * m * block..];
            let by_border = &mut self.by_border[group * m * border..];
            let to_border = &mut self.to_border[group * p * block..];
            for (row, solved) in work.wide.chunks_exact(width).enumerate() {
                for column in 0..block {
                    own[row * block + column][lane] = solved[column];
                }
                for column in 0..border {
                    by_border[row * border + column][lane] = solved[block + column];
                }
            }
            for (row, &entry) in outer.entries.iter().enumerate() {
                let below = &work.below[row * m..(row + 1) * m];
                let through = |column: usize| {
                    let mut sum = T::zero();
                    for (k, &weight) in below.iter().enumerate() {
                        sum -= weight * work.wide[k * width + column];
                    }
                    sum
                };
                for column in 0..block {
                    to_border[row * block + column][lane] = through(column);
                }
                for &(position, _) in &inner.positions {
                    let direct = inverse * T::from_real(jacobian.below(index)[entry * block + position]);
                    to_border[row * block + position][lane] += direct;
                }
                for (column, &entry) in outer.entries.iter().enumerate() {
                    work.corner[row * p + column] -= through(block + entry);
                }
                for (k, &(position, velocity)) in outer.positions.iter().enumerate() {
                    let folded = inverse * through(block + position);
                    self.border_positions[row * px + k] += folded;
                    work.corner[row * p + velocity] -= folded;
                }
            }
        }
        factor(&mut work.corner, p, &mut work.exchanges)?;
        self.border_inverse.fill(T::zero());
        add_diagonal(&mut self.border_inverse, p, T::one());
        substitute(&work.corner, p, &work.exchanges[..p], &mut self.border_inverse, p);
        Ok(())
    }

    /// Replaces the right-hand side by the solution.
    pub fn solve(&mut self, right_side: &mut [T]) {
        let (block, border) = (self.structure.block, self.structure.border);
        let (inner, outer) = (&self.in_block, &self.in_border);
        let (m, p, px) = (inner.entries.len(), outer.entries.len(), outer.positions.len());
        let Work { group: gathered, border: sums, border_solution: solution, .. } = &mut self.work;
        let (of_blocks, of_border) = right_side.split_at_mut(self.structure.blocks * block);
        for (row, (sum, &entry)) in sums.iter_mut().zip(&outer.entries).enumerate() {
            *sum = of_border[entry];
            for (weight, &(position, _)) in self.border_positions[row * px..].iter().zip(&outer.positions) {
                *sum += *weight * of_border[position];
            }
        }
        for (group, blocks) in of_blocks.chunks(LANES * block.max(1)).enumerate() {
            gather(blocks, block, gathered);
            let to_border = &self.to_border[group * p * block..(group + 1) * p * block];
            for (sum, row) in sums.iter_mut().zip(to_border.chunks_exact(block)) {
                for lane in dot(row, gathered) {
                    *sum += lane;
                }
            }
        }
        for (row, &entry) in outer.entries.iter().enumerate() {
            let mut value = T::zero();
            for (&weight, &sum) in self.border_inverse[row * p..].iter().zip(sums.iter()) {
                value += weight * sum;
            }
            solution[entry] = value;
        }
        for &(position, velocity) in &outer.positions {
            solution[position] = (of_border[position] + solution[outer.entries[velocity]]) * self.inverse_shift;
        }
        of_border.copy_from_slice(solution);
        for (group, blocks) in of_blocks.chunks_mut(LANES * block.max(1)).enumerate() {
            gather(blocks, block, gathered);
            let own = &self.own[group * m * block..(group + 1) * m * block];
            let by_border = &self.by_border[group * m * border..(group + 1) * m * border];
            for (row, &entry) in inner.entries.iter().enumerate() {
                let mut sum = dot(&own[row * block..(row + 1) * block], gathered);
                for (weights, &value) in by_border[row * border..(row + 1) * border].iter().zip(solution.iter()) {
                    for (sum, &weight) in sum.iter_mut().zip(weights) {
                        *sum += weight * value;
                    }
                }
                for (target, value) in blocks.chunks_exact_mut(block).zip(sum) {
                    target[entry] = value;
                }
            }
            for target in blocks.chunks_exact_mut(block) {
                for &(position, velocity) in &inner.positions {
                    target[position] = (target[position] + target[inner.entries[velocity]]) * self.inverse_shift;
                }
            }
        }
    }
}

/// Entries of a group's blocks side by side; lanes without a block hold what is left there, which nobody reads.
fn gather<T: Number>(blocks: &[T], block: usize, gathered: &mut [[T; LANES]]) {
    for (lane, entries) in blocks.chunks_exact(block).enumerate() {
        for (row, &entry) in gathered.iter_mut().zip(entries) {
            row[lane] = entry;
        }
    }
}

/// Σ row · column in every lane.
#[inline(always)]
fn dot<T: Number>(row: &[[T; LANES]], column: &[[T; LANES]]) -> [T; LANES] {
    let mut sum = [T::zero(); LANES];
    for (a, b) in row.iter().zip(column) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    sum
}

/// Writes −J over the kept entries, positions folded into their velocities.
fn reduce<T: Number>(jacobian: &[f64], width: usize, (rows, columns): (&Kept, &Kept), inverse: T, matrix: &mut [T]) {
    let n = columns.entries.len();
    for (row, &entry) in rows.entries.iter().enumerate() {
        let source = &jacobian[entry * width..(entry + 1) * width];
        let target = &mut matrix[row * n..(row + 1) * n];
        for (value, &column) in target.iter_mut().zip(&columns.entries) {
            *value = T::from_real(-source[column]);
        }
        for &(position, velocity) in &columns.positions {
            target[velocity] -= inverse * T::from_real(source[position]);
        }
    }
}

fn add_diagonal<T: Number>(matrix: &mut [T], n: usize, shift: T) {
    for i in 0..n {
        matrix[i * n + i] += shift;
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
    for (k, &pivot) in exchanges[..n].iter().enumerate() {
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
        let structure =
            Structure { blocks: 3, block: 5, border: 4, block_pairs: vec![(0, 2), (1, 3)], border_pairs: vec![(0, 2)] };
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

    /// A dense solve of the same matrix, real and complex.
    #[test]
    fn solves_what_a_dense_solver_solves() {
        let (jacobian, dense) = arrowhead();
        let mut seed = 11;
        let right: Vec<f64> = (0..19).map(|_| noise(&mut seed)).collect();
        let mut real = ArrowheadFactors::<f64>::new(jacobian.structure());
        real.factor(&jacobian, 0.37).unwrap();
        let mut solution = right.clone();
        real.solve(&mut solution);
        let matrix = DMatrix::identity(19, 19) * 0.37 - &dense;
        let residual = &matrix * DVector::from_column_slice(&solution) - DVector::from_column_slice(&right);
        assert!(residual.amax() < 1e-12, "{residual}");

        let shift = Complex::new(0.3, 0.8);
        let mut factors = ArrowheadFactors::<Complex<f64>>::new(jacobian.structure());
        factors.factor(&jacobian, shift).unwrap();
        let right: Vec<Complex<f64>> = right.iter().map(|&x| Complex::new(x, -0.4 * x + 0.1)).collect();
        let mut solution = right.clone();
        factors.solve(&mut solution);
        let matrix = DMatrix::identity(19, 19) * shift - dense.map(|x| Complex::new(x, 0.0));
        let residual = &matrix * DVector::from_column_slice(&solution) - DVector::from_column_slice(&right);
        assert!(residual.iter().all(|x| x.norm() < 1e-12), "{residual}");
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
