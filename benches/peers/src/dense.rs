//! The Jacobian of the library as a dense matrix, for solvers without other matrices.

use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::structure::{Jacobian, Structure};

/// Writes a Jacobian column by column.
pub fn by_columns(jacobian: &Jacobian, columns: &mut [f64]) {
    let &Structure { blocks, block, border, .. } = jacobian.structure();
    let n = blocks * block + border;
    let first = blocks * block;
    columns.fill(0.0);
    let mut put = |at: (usize, usize), width: usize, part: &mut dyn Iterator<Item = f64>| {
        for (i, value) in part.enumerate() {
            columns[(at.1 + i % width) * n + at.0 + i / width] = value;
        }
    };
    for index in 0..blocks {
        let at = index * block;
        put((at, at), block, &mut jacobian.blocks.of(index));
        put((at, first), border, &mut jacobian.right.of(index));
        put((first, at), block, &mut jacobian.below.of(index));
    }
    put((first, first), border, &mut jacobian.corner().iter().copied());
}

/// Displacements for difference quotients: half the digits of an entry or of its size.
pub fn displacements(state: &[f64], sizes: &[f64], displacement: &mut [f64]) {
    for ((d, y), size) in displacement.iter_mut().zip(state).zip(sizes) {
        *d = f64::EPSILON.sqrt() * y.abs().max(*size);
    }
}

/// ∂f/∂y column by column with one evaluation of f each, for solvers without the structure.
pub fn by_differences(
    system: &dyn OdeSystem,
    time: f64,
    state: &[f64],
    rate: &[f64],
    displacement: &[f64],
    columns: &mut [f64],
) {
    let n = state.len();
    let mut moved = state.to_vec();
    for (column, values) in columns.chunks_exact_mut(n).enumerate() {
        moved[column] = state[column] + displacement[column];
        let added = moved[column] - state[column];
        system.derivative(time, &moved, values);
        moved[column] = state[column];
        for (value, unmoved) in values.iter_mut().zip(rate) {
            *value = (*value - unmoved) / added;
        }
    }
}
