//! Small dense systems of linear equations.

/// Solves A x = b in place by elimination with partial pivoting; `matrix` holds the rows of A and is lost, `values` b and then x. Values that are
/// not finite show a singular matrix.
#[inline(always)]
pub(crate) fn solve(matrix: &mut [f64], values: &mut [f64]) {
    let size = values.len();
    for column in 0..size {
        let size_of = |row: usize| matrix[row * size + column].abs();
        let pivot = (column + 1..size).fold(column, |best, row| if size_of(row) > size_of(best) { row } else { best });
        if pivot != column {
            (0..size).for_each(|k| matrix.swap(pivot * size + k, column * size + k));
            values.swap(pivot, column);
        }
        let per_pivot = 1.0 / matrix[column * size + column];
        let (above, below) = matrix.split_at_mut((column + 1) * size);
        let pivot_row = &above[column * size + column..];
        for (row, entries) in below.chunks_exact_mut(size).enumerate() {
            let factor = entries[column] * per_pivot;
            if factor != 0.0 {
                entries[column..].iter_mut().zip(pivot_row).for_each(|(entry, above)| *entry -= factor * above);
                values[column + 1 + row] -= factor * values[column];
            }
        }
    }
    for row in (0..size).rev() {
        let sum: f64 = (row + 1..size).map(|k| matrix[row * size + k] * values[k]).sum();
        values[row] = (values[row] - sum) / matrix[row * size + row];
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_system_that_needs_pivots_is_solved() {
        let (mut matrix, mut values) = ([0.0, 2.0, 1.0, 1.0, 1.0, 1.0, 4.0, 0.0, -1.0], [7.0, 6.0, 1.0]);
        super::solve(&mut matrix, &mut values);
        for (value, expected) in values.into_iter().zip([1.0, 2.0, 3.0]) {
            assert!((value - expected).abs() < 1e-15, "{values:?}");
        }
    }
}
