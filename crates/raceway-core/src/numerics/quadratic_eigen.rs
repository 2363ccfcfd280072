//! Damped oscillations q̈ + C q̇ + K q = 0: all of one pair of matrices, and one followed while the matrices change.
//!
//! Neither matrix has to be symmetric. q ~ u e^(λt) gives T(λ) u = 0 with T(λ) = λ² + λ C + K.

use nalgebra::{Complex, DMatrix, DVector, Schur};

/// A decaying or growing oscillation; its conjugate belongs to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Oscillation {
    /// λ [1/s], with a positive imaginary part.
    pub value: Complex<f64>,
    /// u, of length 1.
    pub vector: DVector<Complex<f64>>,
}

/// Imaginary part over magnitude below which two real values are not told apart from an oscillation [-]: rounding of a double
/// eigenvalue.
const OSCILLATES: f64 = 1e-7;
/// Change of an eigenvalue, relative to it, at which a followed oscillation has converged [-].
const CONVERGED: f64 = 1e-11;
/// Iterations before the shift is renewed, and shifts before an oscillation counts as lost.
const MOST_ITERATIONS: usize = 6;
const MOST_SHIFTS: usize = 6;

/// Every oscillation by its natural frequency |λ|, lowest first. An oscillation near its critical damping has a slow imaginary part and decays as
/// fast as its |λ|. `None` where the symmetric part of the stiffness is not positive definite, so that some motion is
/// not restrained, and where the eigenvalues do not converge.
///
/// With K + Kᵀ = 2 L Lᵀ the state (Lᵀq, q̇) makes the matrix antisymmetric where nothing damps, so that it needs no balancing.
pub fn oscillations(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Option<Vec<Oscillation>> {
    let (values, factor) = eigenvalues(stiffness, damping)?;
    let mut values: Vec<_> = values.into_iter().filter(|value| value.im > OSCILLATES * value.norm()).collect();
    values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    with_vectors(&values, &factor, stiffness, damping)
}

/// Largest growth rate of any motion, also of one that does not oscillate [1/s]; `None` as above.
pub fn growth_rate(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Option<f64> {
    let (values, _) = eigenvalues(stiffness, damping)?;
    Some(values.iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max))
}

/// All eigenvalues, and L.
fn eigenvalues(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Option<(Vec<Complex<f64>>, DMatrix<f64>)> {
    let size = stiffness.nrows();
    let factor = (0.5 * (stiffness + stiffness.transpose())).cholesky()?.l();
    let against = factor.solve_lower_triangular(&stiffness.transpose())?.transpose();
    let mut state = DMatrix::zeros(2 * size, 2 * size);
    state.view_mut((0, size), (size, size)).copy_from(&factor.transpose());
    state.view_mut((size, 0), (size, size)).copy_from(&-against);
    state.view_mut((size, size), (size, size)).copy_from(&-damping);
    let most_sweeps = 60 * state.nrows();
    let values = Schur::try_new(state, f64::EPSILON, most_sweeps)?.complex_eigenvalues();
    Some((values.iter().copied().collect(), factor))
}

/// The oscillations of eigenvalues: null vectors of T(λ), for equal eigenvalues orthogonal ones. They are sought as L⁻ᵀ p with
/// L⁻¹ T(λ) L⁻ᵀ p = 0, whose entries are of one size however stiff the stiffest motion is.
fn with_vectors(
    values: &[Complex<f64>],
    factor: &DMatrix<f64>,
    stiffness: &DMatrix<f64>,
    damping: &DMatrix<f64>,
) -> Option<Vec<Oscillation>> {
    let size = factor.nrows();
    let scaled = |matrix: &DMatrix<f64>| {
        factor.solve_lower_triangular(&factor.solve_lower_triangular(matrix)?.transpose()).map(|both| both.transpose())
    };
    let inertia = scaled(&DMatrix::identity(size, size))?;
    let (stiffness, damping) = (scaled(stiffness)?, scaled(damping)?);
    let mut found: Vec<Oscillation> = Vec::with_capacity(values.len());
    for value in values {
        // One of several equal values is the next singular vector.
        let equal = found.iter().rev().take_while(|other| (other.value - value).norm() < 1e-8 * value.norm()).count();
        let matrix = DMatrix::from_fn(size, size, |row, column| {
            value * value * inertia[(row, column)] + value * damping[(row, column)] + stiffness[(row, column)]
        });
        let svd = matrix.svd(false, true);
        let right = svd.v_t?;
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|a, b| svd.singular_values[*a].total_cmp(&svd.singular_values[*b]));
        let of_scaled = right.row(order[equal.min(size - 1)]).adjoint();
        let vector = factor.map(Complex::from).ad_solve_lower_triangular(&of_scaled)?;
        found.push(Oscillation { value: *value, vector: vector.unscale(vector.norm()) });
    }
    Some(found)
}

/// T(λ) = λ² + λ C + K.
pub fn dynamic_stiffness(
    value: Complex<f64>,
    stiffness: &DMatrix<f64>,
    damping: &DMatrix<f64>,
) -> DMatrix<Complex<f64>> {
    let mut matrix = DMatrix::from_fn(stiffness.nrows(), stiffness.ncols(), |row, column| {
        value * damping[(row, column)] + stiffness[(row, column)]
    });
    for place in 0..matrix.nrows() {
        matrix[(place, place)] += value * value;
    }
    matrix
}

impl Oscillation {
    /// The oscillation of changed matrices that this one becomes, by inverse iteration; `None` where it gets lost.
    ///
    /// The state (u, λ u) is iterated with (A − σ)⁻¹, which one factor of T(σ) gives. The shift σ is renewed only where a few
    /// iterations do not suffice.
    pub fn followed(&self, stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Option<Self> {
        let mut at = self.clone();
        for _ in 0..MOST_SHIFTS {
            let shift = at.value;
            let factor = dynamic_stiffness(shift, stiffness, damping).lu();
            let (mut first, mut second) = (at.vector.clone(), &at.vector * shift);
            for _ in 0..MOST_ITERATIONS {
                let damped = DVector::from_fn(first.len(), |row, _| {
                    let damped: Complex<f64> = damping.row(row).iter().zip(first.iter()).map(|(c, u)| u * *c).sum();
                    -(damped + shift * first[row] + second[row])
                });
                // An exactly singular matrix belongs to an eigenvalue.
                let Some(next) = factor.solve(&damped) else { return Some(at) };
                let value = shift + first.norm_squared() / first.dotc(&next);
                let size = next.norm();
                if !(value.re.is_finite() && value.im.is_finite() && size > 0.0) {
                    return None;
                }
                let change = (value - at.value).norm();
                (second, first) = ((&first + &next * shift).unscale(size), next.unscale(size));
                at = Self { value, vector: first.clone() };
                if change < CONVERGED * value.norm() {
                    return (value.im > OSCILLATES * value.norm()).then_some(at);
                }
            }
        }
        None
    }

    /// Likeness of two shapes, 0 … 1.
    pub fn likeness(&self, other: &Self) -> f64 {
        self.vector.dotc(&other.vector).norm_sqr()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Jeffcott rotor on two equal planes with a gyroscopic coupling g: λ² ± i g λ + ω² = 0, so ω± = √(ω² + g²/4) ± g/2.
    #[test]
    fn gyroscopic_coupling_splits_a_double_frequency() {
        let stiffness = DMatrix::from_diagonal_element(2, 2, 100.0);
        let at_rest = oscillations(&stiffness, &DMatrix::zeros(2, 2)).unwrap();
        assert!(at_rest.len() == 2 && at_rest[0].likeness(&at_rest[1]) < 1e-12);
        let coupling = DMatrix::from_row_slice(2, 2, &[0.0, 3.0, -3.0, 0.0]);
        let found = oscillations(&stiffness, &coupling).unwrap();
        let expected = [102.25_f64.sqrt() - 1.5, 102.25_f64.sqrt() + 1.5];
        for (oscillation, expected) in found.iter().zip(expected) {
            assert!((oscillation.value - Complex::new(0.0, expected)).norm() < 1e-12);
            let more = oscillation.followed(&(1.1 * &stiffness), &coupling).unwrap();
            let root = (110.0_f64 + 2.25).sqrt();
            assert!((more.value.im - (root + expected - 102.25_f64.sqrt())).abs() < 1e-10);
        }
    }

    /// A motion that decays without oscillation is none; an unrestrained one has no frequencies.
    #[test]
    fn overdamped_motions_are_left_out() {
        let stiffness = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0]));
        let damping = DMatrix::from_diagonal(&DVector::from_vec(vec![3.0, 0.4]));
        let found = oscillations(&stiffness, &damping).unwrap();
        assert!(found.len() == 1 && (found[0].value - Complex::new(-0.2, 3.96_f64.sqrt())).norm() < 1e-12);
        assert!(oscillations(&DMatrix::zeros(2, 2), &damping).is_none());
    }
}
