//! Small matrices of several blocks side by side, and their inverses.

use std::hint::black_box;

use nalgebra::ComplexField;

use crate::numerics::lanes::{LANES, Lanes};

/// The matrix has no inverse, or an entry that is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Singular;

/// Numbers that matrices are made of.
pub trait Number: ComplexField<RealField = f64> + Copy {}
impl<T: ComplexField<RealField = f64> + Copy> Number for T {}

/// An entry of each block of a group, side by side: a group is worked on at once.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Group<T>(pub(super) [T; LANES]);

impl<T: Number> Group<T> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self([T::zero(); LANES])
    }

    #[inline(always)]
    pub(super) fn of(entries: Lanes) -> Self {
        Self(entries.0.map(T::from_real))
    }

    /// `self -= a · b`.
    #[inline(always)]
    pub(super) fn subtract(&mut self, a: Self, b: Self) {
        for lane in 0..LANES {
            self.0[lane] -= a.0[lane] * b.0[lane];
        }
    }

    /// `self += a · b`.
    #[inline(always)]
    pub(super) fn add(&mut self, a: Self, b: Self) {
        for lane in 0..LANES {
            self.0[lane] += a.0[lane] * b.0[lane];
        }
    }

    #[inline(always)]
    pub(super) fn scale(&mut self, factor: Self) {
        for lane in 0..LANES {
            self.0[lane] *= factor.0[lane];
        }
    }

    #[inline(always)]
    pub(super) fn sum(self) -> T {
        // Halves upon halves: eight additions in a row would each wait for the one before.
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// Entries of a group's blocks side by side. Lanes without a block keep old values, which are multiplied by zeros.
///
/// Never inlined, as its counterpart: AVX-512 would scatter and gather, which takes longer than moves one by one.
#[inline(never)]
pub(super) fn gather<T: Number>(blocks: &[T], block: usize, gathered: &mut [Group<T>]) {
    for (lane, entries) in blocks.chunks_exact(block).take(LANES).enumerate() {
        for (row, &entry) in gathered.iter_mut().zip(entries) {
            row.0[lane] = entry;
        }
    }
}

/// Puts entries that stand side by side back into a group's blocks.
#[inline(never)]
pub(super) fn scatter<T: Number>(gathered: &[Group<T>], block: usize, blocks: &mut [T]) {
    for (lane, entries) in blocks.chunks_exact_mut(block).take(LANES).enumerate() {
        for (row, entry) in gathered.iter().zip(entries) {
            *entry = row.0[lane];
        }
    }
}

/// Adds Σ row · column in every lane.
#[inline(always)]
pub(super) fn add_dot<T: Number>(sum: &mut Group<T>, row: &[Group<T>], column: &[Group<T>]) {
    for (&a, &b) in row.iter().zip(column) {
        sum.add(a, b);
    }
}

/// Replaces the small matrices of a group by their inverses: elimination by Gauss and Jordan, each with its own exchanges of
/// rows.
#[inline(always)]
pub(super) fn invert_group<T: Number, const M: usize>(matrix: &mut [[Group<T>; M]; M]) -> Result<(), Singular> {
    let mut inverse = [[Group::zero(); M]; M];
    for (k, row) in inverse.iter_mut().enumerate() {
        row[k] = Group([T::one(); LANES]);
    }
    for k in 0..M {
        for row in k + 1..M {
            let larger = exchanged(matrix[k][k], matrix[row][k]);
            if larger.iter().any(|&larger| larger) {
                for matrix in [&mut *matrix, &mut inverse] {
                    let (upper, lower) = matrix.split_at_mut(row);
                    exchange(&mut upper[k], &mut lower[0], larger);
                }
            }
        }
        let mut scale = matrix[k][k];
        for pivot in &mut scale.0 {
            let size = pivot.norm1();
            if !(size > 0.0 && size.is_finite()) {
                return Err(Singular);
            }
            *pivot = T::one() / *pivot;
        }
        for column in 0..M {
            matrix[k][column].scale(scale);
            inverse[k][column].scale(scale);
        }
        let (pivot, solved) = (matrix[k], inverse[k]);
        for row in (0..M).filter(|&row| row != k) {
            let weight = matrix[row][k];
            for column in 0..M {
                matrix[row][column].subtract(weight, pivot[column]);
                inverse[row][column].subtract(weight, solved[column]);
            }
        }
    }
    *matrix = inverse;
    Ok(())
}

/// The turn of a loop whose lanes are to be side by side, and not its turns: these the compiler would gather and scatter.
#[inline(always)]
pub(super) fn alone(turn: usize) -> usize {
    black_box(turn)
}

/// `product = weights · matrix`, the matrix row by row.
#[inline(always)]
pub(super) fn product<T: Number, const M: usize>(
    weights: &[Group<T>; M],
    matrix: &[Group<T>],
    product: &mut [Group<T>],
) {
    let columns = product.len();
    let mut rows = [matrix; M];
    for k in 0..M {
        rows[k] = &matrix[k * columns..(k + 1) * columns];
    }
    let weights = *weights;
    for (column, value) in product.iter_mut().enumerate() {
        let column = alone(column);
        let mut sum = Group::zero();
        for k in 0..M {
            sum.add(weights[k], rows[k][column]);
        }
        *value = sum;
    }
}

/// In which lanes the second is the larger pivot.
#[inline(always)]
fn exchanged<T: Number>(first: Group<T>, second: Group<T>) -> [bool; LANES] {
    let mut larger = [false; LANES];
    for (larger, (first, second)) in larger.iter_mut().zip(first.0.into_iter().zip(second.0)) {
        *larger = second.norm1() > first.norm1();
    }
    larger
}

/// Exchanges two rows in some lanes.
#[inline(always)]
fn exchange<T: Number>(first: &mut [Group<T>], second: &mut [Group<T>], lanes: [bool; LANES]) {
    for (a, b) in first.iter_mut().zip(second) {
        for ((above, below), here) in a.0.iter_mut().zip(&mut b.0).zip(lanes) {
            let (one, other) = (*above, *below);
            *above = if here { other } else { one };
            *below = if here { one } else { other };
        }
    }
}

/// Replaces a matrix that stands beside the identity, `(A | I)` row by row, by the identity beside its inverse: elimination by
/// Gauss and Jordan.
#[inline(always)]
pub(super) fn invert<T: Number>(matrix: &mut [T], n: usize) -> Result<(), Singular> {
    let width = 2 * n;
    for k in 0..n {
        let size = |row: usize| matrix[row * width + k].norm1();
        let (mut pivot, mut largest) = (k, size(k));
        for row in k + 1..n {
            if size(row) > largest {
                (pivot, largest) = (row, size(row));
            }
        }
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(Singular);
        }
        if pivot != k {
            let (upper, lower) = matrix.split_at_mut(pivot * width);
            upper[k * width..(k + 1) * width].swap_with_slice(&mut lower[..width]);
        }
        let (above, rest) = matrix.split_at_mut(k * width);
        let (row, below) = rest.split_at_mut(width);
        let scale = T::one() / row[k];
        row.iter_mut().for_each(|value| *value *= scale);
        for other in above.chunks_exact_mut(width).chain(below.chunks_exact_mut(width)) {
            let weight = other[k];
            for (value, &pivot) in other.iter_mut().zip(&*row) {
                *value -= weight * pivot;
            }
        }
    }
    Ok(())
}
