//! The shape of a Jacobian: an arrowhead of blocks and a border.
//!
//! ```text
//! block 1                 right 1
//!          block 2        right 2
//!                   …
//! below 1  below 2  …     corner
//! ```
//! Blocks act on each other only through the border (the balls of a bearing through spindle and cage), so that the cost of
//! linear algebra grows with their number and not with its cube. A system without blocks is all corner: dense.

use std::ops::Range;

use super::tolerances::Tolerances;
use crate::numerics::lanes::{LANES, Lanes};

/// Dependence between the entries of a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Structure {
    /// Number of blocks, and entries of each; the blocks come first in the state.
    pub blocks: usize,
    pub block: usize,
    /// Entries after the blocks.
    pub border: usize,
    /// Pairs (position, velocity) within a block: the rate of the first is the second and nothing else.
    /// Linear algebra eliminates the positions.
    pub block_pairs: Vec<(usize, usize)>,
    /// Such pairs within the border.
    pub border_pairs: Vec<(usize, usize)>,
}

impl Structure {
    /// Every entry may depend on every other.
    pub fn dense(dimension: usize) -> Self {
        Self { blocks: 0, block: 0, border: dimension, block_pairs: Vec::new(), border_pairs: Vec::new() }
    }

    /// Entries of a state.
    pub fn dimension(&self) -> usize {
        self.blocks * self.block + self.border
    }
}

/// One part of the Jacobian of every block, `LANES` blocks side by side.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    rows: usize,
    columns: usize,
    groups: Vec<Lanes>,
}

impl Part {
    fn new(blocks: usize, rows: usize, columns: usize) -> Self {
        let groups = vec![Lanes::default(); blocks.div_ceil(LANES) * rows * columns];
        Self { rows, columns, groups }
    }

    fn places(&self, group: usize) -> Range<usize> {
        let size = self.rows * self.columns;
        group * size..(group + 1) * size
    }

    /// Row by row, of the blocks from `group · LANES` on; zeros beyond the last one.
    #[inline(always)]
    pub(crate) fn group(&self, group: usize) -> &[Lanes] {
        &self.groups[self.places(group)]
    }

    #[inline(always)]
    pub(crate) fn group_mut(&mut self, group: usize) -> &mut [Lanes] {
        let places = self.places(group);
        &mut self.groups[places]
    }

    /// Row by row, of one block.
    pub fn of(&self, block: usize) -> impl Iterator<Item = f64> + '_ {
        self.group(block / LANES).iter().map(move |entry| entry[block % LANES])
    }

    /// The entry of a block in a row and a column.
    pub(crate) fn entry_mut(&mut self, block: usize, row: usize, column: usize) -> &mut f64 {
        let columns = self.columns;
        &mut self.group_mut(block / LANES)[row * columns + column][block % LANES]
    }

    /// `sum += of(block) · vector`.
    fn accumulate(&self, block: usize, vector: &[f64], sum: &mut [f64]) {
        for (row, sum) in self.group(block / LANES).chunks_exact(self.columns.max(1)).zip(sum) {
            *sum += row.iter().zip(vector).map(|(entry, x)| entry[block % LANES] * x).sum::<f64>();
        }
    }

    fn is_finite(&self) -> bool {
        self.groups.iter().all(|entry| entry.0.iter().all(|x| x.is_finite()))
    }
}

/// ∂f/∂y, each part row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Jacobian {
    structure: Structure,
    /// How each block acts on itself: `block` × `block`.
    pub blocks: Part,
    /// How the border acts on each block: `block` × `border`.
    pub right: Part,
    /// How each block acts on the border: `border` × `block`.
    pub below: Part,
    corner: Vec<f64>,
}

impl Jacobian {
    /// All zero.
    pub fn new(structure: &Structure) -> Self {
        let Structure { blocks, block, border, .. } = *structure;
        Self {
            structure: structure.clone(),
            blocks: Part::new(blocks, block, block),
            right: Part::new(blocks, block, border),
            below: Part::new(blocks, border, block),
            corner: vec![0.0; border * border],
        }
    }

    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// How the border acts on itself: `border` × `border`.
    pub fn corner(&self) -> &[f64] {
        &self.corner
    }

    pub fn corner_mut(&mut self) -> &mut [f64] {
        &mut self.corner
    }

    /// `product = J · vector`.
    pub fn multiply(&self, vector: &[f64], product: &mut [f64]) {
        let Structure { blocks, block, border, .. } = self.structure;
        let (in_blocks, in_border) = vector.split_at(blocks * block);
        let (of_blocks, of_border) = product.split_at_mut(blocks * block);
        of_border.fill(0.0);
        accumulate(&self.corner, in_border, of_border);
        for index in 0..blocks {
            let own = &in_blocks[index * block..(index + 1) * block];
            let rate = &mut of_blocks[index * block..(index + 1) * block];
            rate.fill(0.0);
            self.blocks.accumulate(index, own, rate);
            self.right.accumulate(index, in_border, rate);
            self.below.accumulate(index, own, of_border);
        }
        debug_assert_eq!(vector.len(), blocks * block + border);
    }

    /// Magnitude of the fastest eigenvalue, by power iteration in weighted entries; the growth is averaged, because a
    /// pair of complex modes makes it beat.
    pub(crate) fn fastest_rate(&self, weights: &[f64]) -> f64 {
        const ITERATIONS: u32 = 24;
        const AVERAGED: u32 = 12;
        let n = self.structure.dimension();
        // Any vector without symmetry will do.
        let mut direction: Vec<f64> = (0..n).map(|i| (1.0 + (i as f64 * 0.7).sin()) / weights[i]).collect();
        let mut image = vec![0.0; n];
        let mut growth = 0.0;
        for iteration in 0..ITERATIONS {
            self.multiply(&direction, &mut image);
            let size = |v: &[f64]| v.iter().zip(weights).map(|(x, w)| (x * w) * (x * w)).sum::<f64>().sqrt();
            let factor = size(&image) / size(&direction);
            if !(factor > 0.0 && factor.is_finite()) {
                return 0.0;
            }
            if iteration >= ITERATIONS - AVERAGED {
                growth += factor.ln() / f64::from(AVERAGED);
            }
            for (direction, image) in direction.iter_mut().zip(&image) {
                *direction = image / factor;
            }
        }
        growth.exp()
    }

    /// Every entry is finite.
    pub fn is_finite(&self) -> bool {
        [&self.blocks, &self.right, &self.below].iter().all(|part| part.is_finite())
            && self.corner.iter().all(|x| x.is_finite())
    }
}

/// `sum += matrix · vector`, the matrix row by row.
fn accumulate(matrix: &[f64], vector: &[f64], sum: &mut [f64]) {
    for (row, sum) in matrix.chunks_exact(vector.len().max(1)).zip(sum) {
        *sum += row.iter().zip(vector).map(|(a, x)| a * x).sum::<f64>();
    }
}

/// Displacements for difference quotients: half the digits of an entry, but enough that a step's change of the
/// state by `step · rate` is resolved (A. C. Hindmarsh et al., CVODE).
pub(crate) fn displacements(state: &[f64], rate: &[f64], tolerances: &Tolerances, step: f64, displacement: &mut [f64]) {
    let n = state.len() as f64;
    let weight = |i: usize| tolerances.allowed(i, state[i]);
    let norm = (0..state.len()).map(|i| (rate[i] / weight(i)).powi(2)).sum::<f64>() / n.max(1.0);
    let floor = 1e3 * f64::EPSILON * n * step.abs() * norm.sqrt();
    let floor = if floor > 0.0 && floor.is_finite() { floor } else { 1.0 };
    for (i, d) in displacement.iter_mut().enumerate() {
        *d = (f64::EPSILON.sqrt() * state[i].abs()).max(floor * weight(i));
    }
}
