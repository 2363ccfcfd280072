//! Factors of `shift · I − J` for an arrowhead Jacobian, real or complex.
//!
//! The positions of pairs `ẋ = v` are eliminated first, `x = (r_x + v)/shift`, which leaves half the
//! unknowns; then block after block, `W = A⁻¹B`, and the border's Schur complement `D − Σ C W`
//! (Å. Björck, *Numerical Methods in Matrix Computations*, §1.5). Linear in the number of blocks.

mod group;

use self::group::{Group, add_dot, gather, invert, invert_group, product, scatter};
pub use self::group::{Number, Singular};
use super::structure::{Jacobian, Structure};
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, Task};

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

/// Rows of a block that stay after the elimination of positions: those of a ball in the plane, of a ball, and of a ball with its attitude.
/// Elimination is compiled for these, so that its loops are straight code; fewer rows are filled up with those of the identity.
const FEW: usize = 3;
const MANY: usize = 6;
const MOST: usize = 10;

/// Number of rows computed for `stay` remaining rows.
fn rows(stay: usize) -> usize {
    [FEW, MANY].into_iter().find(|&rows| stay <= rows).unwrap_or(MOST)
}

/// The factors, with room for right-hand sides; allocates only on construction.
///
/// Stored as the small matrices that a solution needs, because one factor is used for many right-hand sides. With the
/// rows `v` that stay and the positions `x = (r_x + v)/s` that go, `R` and `C` what border and block do to each other:
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
    instructions: InstructionSet,
    inverse_shift: T,
    /// Of each group of blocks: E and U in rows of `block + border`, then F in rows of `block`.
    own: Vec<Group<T>>,
    to_border: Vec<Group<T>>,
    /// G, and S beside the identity, then the identity beside S⁻¹; row by row.
    border_positions: Vec<T>,
    corner: Vec<T>,
    work: Work<T>,
}

/// Room for factors and right-hand sides.
#[derive(Debug, Clone)]
struct Work<T> {
    /// Of a group of blocks: (∂v'/∂x / s | R), and a row of a product.
    right: Vec<Group<T>>,
    through: Vec<Group<T>>,
    /// Right-hand side and solution of a group of blocks, and the border's.
    group: Vec<Group<T>>,
    solved: Vec<Group<T>>,
    sums: Vec<Group<T>>,
    border: Vec<T>,
    border_solution: Vec<T>,
}

/// Factors, to be made with the processor's instructions; `M`: as many rows stay, or more.
struct Factor<'a, T, const M: usize> {
    factors: &'a mut ArrowheadFactors<T>,
    jacobian: &'a Jacobian,
    shift: T,
}

impl<T: Number, const M: usize> Task for Factor<'_, T, M> {
    type Answer = Result<(), Singular>;

    #[inline(always)]
    fn run(self) -> Self::Answer {
        self.factors.factor_by::<M>(self.jacobian, self.shift)
    }
}

/// A solution, to be found with them.
struct Solve<'a, T> {
    factors: &'a mut ArrowheadFactors<T>,
    right_side: &'a mut [T],
}

impl<T: Number> Task for Solve<'_, T> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.factors.solve_by(self.right_side);
    }
}

impl<T: Number> ArrowheadFactors<T> {
    /// # Panics
    ///
    /// If more than 10 entries of a block stay after the elimination of positions.
    pub fn new(structure: &Structure) -> Self {
        let in_block = Kept::new(structure.block, &structure.block_pairs);
        assert!(in_block.entries.len() <= MOST, "at most {MOST} entries of a block stay");
        let in_border = Kept::new(structure.border, &structure.border_pairs);
        let (m, p) = (in_block.entries.len(), in_border.entries.len());
        let (block, border, px) = (structure.block, structure.border, in_border.positions.len());
        let groups = structure.blocks.div_ceil(LANES);
        let rows = rows(m);
        let zeros = |count: usize| vec![T::zero(); count];
        let lanes = |count: usize| vec![Group::zero(); count];
        Self {
            structure: structure.clone(),
            instructions: InstructionSet::best(),
            inverse_shift: T::one(),
            own: lanes(groups * rows * (block + border)),
            to_border: lanes(groups * p * block),
            border_positions: zeros(p * px),
            corner: zeros(2 * p * p),
            work: Work {
                right: lanes(rows * (in_block.positions.len() + border)),
                through: lanes(block + border),
                group: lanes(block),
                solved: lanes(block),
                sums: lanes(p),
                border: zeros(p),
                border_solution: zeros(border),
            },
            in_block,
            in_border,
        }
    }

    /// The same factors, computed with another instruction set of this processor.
    pub fn with_instructions(mut self, instructions: InstructionSet) -> Self {
        self.instructions = instructions;
        self
    }

    /// Factors `shift · I − J`.
    pub fn factor(&mut self, jacobian: &Jacobian, shift: T) -> Result<(), Singular> {
        let instructions = self.instructions;
        match rows(self.in_block.entries.len()) {
            FEW => instructions.run(Factor::<T, FEW> { factors: self, jacobian, shift }),
            MANY => instructions.run(Factor::<T, MANY> { factors: self, jacobian, shift }),
            _ => instructions.run(Factor::<T, MOST> { factors: self, jacobian, shift }),
        }
    }

    /// Replaces the right-hand side by the solution.
    pub fn solve(&mut self, right_side: &mut [T]) {
        self.instructions.run(Solve { factors: self, right_side });
    }

    #[inline(always)]
    fn factor_by<const M: usize>(&mut self, jacobian: &Jacobian, shift: T) -> Result<(), Singular> {
        let Structure { blocks, block, border, .. } = self.structure;
        let (inner, outer) = (&self.in_block, &self.in_border);
        let (m, p, px) = (inner.entries.len(), outer.entries.len(), outer.positions.len());
        let inverse = T::one() / shift;
        self.inverse_shift = inverse;
        let work = &mut self.work;
        for (row, &entry) in outer.entries.iter().enumerate() {
            let source = &jacobian.corner()[entry * border..(entry + 1) * border];
            let target = &mut self.corner[row * 2 * p..(row + 1) * 2 * p];
            target[p..].fill(T::zero());
            target[p + row] = T::one();
            for (value, &column) in target.iter_mut().zip(&outer.entries) {
                *value = T::from_real(-source[column]);
            }
            target[row] += shift;
            for (k, &(position, velocity)) in outer.positions.iter().enumerate() {
                let folded = inverse * T::from_real(source[position]);
                target[velocity] -= folded;
                self.border_positions[row * px + k] = folded;
            }
        }
        let (width, positions) = (block + border, inner.positions.len());
        let columns = positions + border;
        for first in (0..blocks).step_by(LANES) {
            let group = first / LANES;
            let own = &mut self.own[group * M * width..(group + 1) * M * width];
            let to_border = &mut self.to_border[group * p * block..(group + 1) * p * block];
            let (of_block, of_right) = (jacobian.blocks.group(group), jacobian.right.group(group));
            let mut matrix = [[Group::zero(); M]; M];
            for (row, &entry) in inner.entries.iter().enumerate() {
                let source = &of_block[entry * block..(entry + 1) * block];
                reduce(source, inner, inverse, &mut matrix[row][..m]);
                matrix[row][row].add(Group([T::one(); LANES]), Group([shift; LANES]));
                let (by_position, by_border) = work.right[row * columns..(row + 1) * columns].split_at_mut(positions);
                for (value, &(position, _)) in by_position.iter_mut().zip(&inner.positions) {
                    *value = Group::of(source[position]);
                    value.scale(Group([inverse; LANES]));
                }
                for (value, &right) in by_border.iter_mut().zip(&of_right[entry * border..(entry + 1) * border]) {
                    *value = Group::of(right);
                }
            }
            for (k, row) in matrix.iter_mut().enumerate().skip(m) {
                row[k] = Group([T::one(); LANES]);
            }
            invert_group(&mut matrix)?;
            for (row, inverse_row) in matrix.iter().enumerate() {
                product(inverse_row, &work.right, &mut work.through[..columns]);
                let (by_block, by_border) = own[row * width..(row + 1) * width].split_at_mut(block);
                for (&value, &entry) in inverse_row.iter().zip(&inner.entries) {
                    by_block[entry] = value;
                }
                for (&value, &(position, _)) in work.through.iter().zip(&inner.positions) {
                    by_block[position] = value;
                }
                by_border.copy_from_slice(&work.through[positions..columns]);
            }

            let of_below = jacobian.below.group(group);
            for (row, &entry) in outer.entries.iter().enumerate() {
                let source = &of_below[entry * block..(entry + 1) * block];
                let mut below = [Group::zero(); M];
                reduce(source, inner, inverse, &mut below[..m]);
                below.iter_mut().for_each(|weight| weight.scale(Group([-T::one(); LANES])));
                product(&below, own, &mut work.through[..width]);
                let (through_block, through_border) = work.through[..width].split_at(block);
                let target = &mut to_border[row * block..(row + 1) * block];
                target.copy_from_slice(through_block);
                for &(position, _) in &inner.positions {
                    target[position].add(Group([inverse; LANES]), Group::of(source[position]));
                }
                let of_row = &mut self.corner[row * 2 * p..(row * 2 + 1) * p];
                for (value, &entry) in of_row.iter_mut().zip(&outer.entries) {
                    *value -= through_border[entry].sum();
                }
                for (k, &(position, velocity)) in outer.positions.iter().enumerate() {
                    let folded = inverse * through_border[position].sum();
                    self.border_positions[row * px + k] += folded;
                    of_row[velocity] -= folded;
                }
            }
        }
        invert(&mut self.corner, p)
    }

    #[inline(always)]
    fn solve_by(&mut self, right_side: &mut [T]) {
        let Structure { blocks, block, border, .. } = self.structure;
        let (inner, outer) = (&self.in_block, &self.in_border);
        let (m, p, px) = (inner.entries.len(), outer.entries.len(), outer.positions.len());
        let width = block + border;
        let Work { group: gathered, solved, sums, border: reduced, border_solution: solution, .. } = &mut self.work;
        let (of_blocks, of_border) = right_side.split_at_mut(blocks * block);
        sums.fill(Group::zero());
        for (group, of_group) in of_blocks.chunks(LANES * block.max(1)).enumerate() {
            gather(of_group, block, gathered);
            let to_border = &self.to_border[group * p * block..(group + 1) * p * block];
            for (sum, row) in sums.iter_mut().zip(to_border.chunks_exact(block)) {
                let mut lanes = *sum;
                add_dot(&mut lanes, row, gathered);
                *sum = lanes;
            }
        }
        for (row, ((value, &sum), &entry)) in reduced.iter_mut().zip(&*sums).zip(&outer.entries).enumerate() {
            *value = of_border[entry] + sum.sum();
            for (weight, &(position, _)) in self.border_positions[row * px..].iter().zip(&outer.positions) {
                *value += *weight * of_border[position];
            }
        }
        for (row, &entry) in outer.entries.iter().enumerate() {
            let mut value = T::zero();
            for (&weight, &sum) in self.corner[row * 2 * p + p..].iter().zip(reduced.iter()) {
                value += weight * sum;
            }
            solution[entry] = value;
        }
        for &(position, velocity) in &outer.positions {
            solution[position] = (of_border[position] + solution[outer.entries[velocity]]) * self.inverse_shift;
        }
        of_border.copy_from_slice(solution);
        for (group, of_group) in of_blocks.chunks_mut(LANES * block.max(1)).enumerate() {
            if blocks > LANES {
                gather(of_group, block, gathered);
            }
            let own = &self.own[group * rows(m) * width..(group + 1) * rows(m) * width];
            for (row, &entry) in inner.entries.iter().enumerate() {
                let (by_own, by_border) = own[row * width..(row + 1) * width].split_at(block);
                let mut sum = Group::zero();
                add_dot(&mut sum, by_own, gathered);
                for (&weights, &value) in by_border.iter().zip(solution.iter()) {
                    sum.add(weights, Group([value; LANES]));
                }
                solved[entry] = sum;
            }
            for &(position, velocity) in &inner.positions {
                let mut sum = gathered[position];
                sum.add(Group([T::one(); LANES]), solved[inner.entries[velocity]]);
                sum.scale(Group([self.inverse_shift; LANES]));
                solved[position] = sum;
            }
            scatter(solved, block, of_group);
        }
    }
}

/// Writes a row of −J over the kept entries, positions folded into their velocities.
#[inline(always)]
fn reduce<T: Number>(source: &[Lanes], kept: &Kept, inverse: T, target: &mut [Group<T>]) {
    for (value, &column) in target.iter_mut().zip(&kept.entries) {
        *value = Group::zero();
        value.subtract(Group([T::one(); LANES]), Group::of(source[column]));
    }
    for &(position, velocity) in &kept.positions {
        target[velocity].subtract(Group([inverse; LANES]), Group::of(source[position]));
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
                    *jacobian.blocks.entry_mut(index, row, column) = value;
                    dense[(index * 5 + row, index * 5 + column)] = value;
                }
                for column in 0..4 {
                    let value = if pair.is_some() { 0.0 } else { noise(&mut seed) };
                    *jacobian.right.entry_mut(index, row, column) = value;
                    dense[(index * 5 + row, 15 + column)] = value;
                }
            }
            for row in 0..4 {
                for column in 0..5 {
                    let pair = is_position(&structure.border_pairs, row);
                    let value = if pair.is_some() { 0.0 } else { noise(&mut seed) };
                    *jacobian.below.entry_mut(index, row, column) = value;
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
    fn a_singular_matrix_is_reported() {
        let jacobian = Jacobian::new(&Structure::dense(3));
        let mut factors = ArrowheadFactors::<f64>::new(jacobian.structure());
        assert_eq!(factors.factor(&jacobian, 0.0), Err(Singular));
        assert_eq!(factors.factor(&jacobian, f64::NAN), Err(Singular));
        assert_eq!(factors.factor(&jacobian, 1.0), Ok(()));
    }
}
