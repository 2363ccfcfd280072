//! Block-diagonal matrices, laid out for products with vectors.

use crate::numerics::ode::structure::{Jacobian, Structure};

/// Block-diagonal matrices, each in panels of rows; one block may stand for all.
#[derive(Debug, Clone)]
pub(super) struct Diagonal {
    pub(super) block: usize,
    pub(super) border: usize,
    pub(super) blocks: Vec<Vec<f64>>,
    pub(super) corner: Vec<f64>,
}

impl Diagonal {
    pub(super) fn pairs(structure: &Structure) -> Self {
        let matrix = |n: usize, pairs: &[(usize, usize)]| {
            let mut matrix = vec![0.0; n * n];
            pairs.iter().for_each(|&(position, velocity)| matrix[position * n + velocity] = 1.0);
            in_panels(matrix.into_iter(), n)
        };
        Self {
            block: structure.block,
            border: structure.border,
            blocks: vec![matrix(structure.block, &structure.block_pairs)],
            corner: matrix(structure.border, &structure.border_pairs),
        }
    }

    pub(super) fn of(jacobian: &Jacobian) -> Self {
        let Structure { blocks, block, border, .. } = *jacobian.structure();
        let blocks = (0..blocks).map(|index| in_panels(jacobian.blocks.of(index), block)).collect();
        Self { block, border, blocks, corner: in_panels(jacobian.corner().iter().copied(), border) }
    }

    /// All matrices with their sizes, the corner last.
    pub(super) fn matrices(&self) -> impl Iterator<Item = (&[f64], usize)> {
        let blocks = self.blocks.iter().map(|matrix| (matrix.as_slice(), self.block));
        blocks.chain([(self.corner.as_slice(), self.border)])
    }

    /// `sum += sign · self · vector`.
    pub(super) fn add_product(&self, sign: f64, vector: &[f64], sum: &mut [f64], structure: &Structure) {
        for index in 0..structure.blocks {
            let own = index * self.block..(index + 1) * self.block;
            accumulate(&self.blocks[index % self.blocks.len()], sign, &vector[own.clone()], &mut sum[own]);
        }
        let border = structure.blocks * self.block..;
        accumulate(&self.corner, sign, &vector[border.clone()], &mut sum[border]);
    }
}

/// Rows worked on together.
const PANEL: usize = 4;

/// From row by row: panels of four rows, each column by column, the last one filled up with zeros.
pub(super) fn in_panels(matrix: impl Iterator<Item = f64>, n: usize) -> Vec<f64> {
    let mut panels = vec![0.0; n.div_ceil(PANEL) * PANEL * n];
    for (i, value) in matrix.enumerate() {
        let (row, column) = (i / n, i % n);
        panels[(row / PANEL * n + column) * PANEL + row % PANEL] = value;
    }
    panels
}

pub(super) fn row_by_row(panels: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|i| panels[(i / n / PANEL * n + i % n) * PANEL + i / n % PANEL]).collect()
}

/// `sum += sign · matrix · vector`, the matrix in panels.
fn accumulate(panels: &[f64], sign: f64, vector: &[f64], sum: &mut [f64]) {
    for (panel, sum) in panels.chunks_exact((vector.len() * PANEL).max(1)).zip(sum.chunks_mut(PANEL)) {
        let mut rows = [0.0; PANEL];
        for (column, &x) in panel.chunks_exact(PANEL).zip(vector) {
            for (row, a) in rows.iter_mut().zip(column) {
                *row += a * x;
            }
        }
        for (sum, row) in sum.iter_mut().zip(rows) {
            *sum += sign * row;
        }
    }
}
