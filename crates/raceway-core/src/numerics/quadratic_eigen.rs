//! Damped oscillations q̈ + C q̇ + K q = 0: all of one pair of matrices, and one followed while the matrices change.
//!
//! Neither matrix has to be symmetric. q ~ u e^(λt) gives T(λ) u = 0 with T(λ) = λ² + λ C + K.

use nalgebra::{Complex, DMatrix, DVector, Schur};

use super::random::SplitMix64;

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
/// Distance of two eigenvalues over them, below which they are equal but for rounding [-].
const EQUAL: f64 = 1e-8;
/// Distance from an eigenvalue, over it, at which its matrix is far from singular against rounding [-], and inverse iterations there. What is left by
/// a vector whose eigenvalue is further off than `EQUAL` falls by 1e-4 in each.
const BESIDE: f64 = 1e-12;
const INVERSE_ITERATIONS: usize = 3;
/// Largest remainder of a null vector over the matrix [-].
const NULL: f64 = 1e-10;
/// Iterations before the shift is renewed, and shifts before an oscillation counts as lost.
const MOST_ITERATIONS: usize = 6;
const MOST_SHIFTS: usize = 6;

/// All eigenvalues of one pair of matrices.
pub struct FreeMotion<'a> {
    stiffness: &'a DMatrix<f64>,
    damping: &'a DMatrix<f64>,
    /// L
    factor: DMatrix<f64>,
    values: Vec<Complex<f64>>,
}

impl<'a> FreeMotion<'a> {
    /// `None` where the symmetric part of the stiffness is not positive definite, so that some motion is not restrained, and where the
    /// eigenvalues do not converge.
    ///
    /// With K + Kᵀ = 2 L Lᵀ the state (Lᵀq, q̇) makes the matrix antisymmetric where nothing damps, so that it needs no balancing.
    pub fn of(stiffness: &'a DMatrix<f64>, damping: &'a DMatrix<f64>) -> Option<Self> {
        let size = stiffness.nrows();
        let factor = (0.5 * (stiffness + stiffness.transpose())).cholesky()?.l();
        let against = factor.solve_lower_triangular(&stiffness.transpose())?.transpose();
        let mut state = DMatrix::zeros(2 * size, 2 * size);
        state.view_mut((0, size), (size, size)).copy_from(&factor.transpose());
        state.view_mut((size, 0), (size, size)).copy_from(&-against);
        state.view_mut((size, size), (size, size)).copy_from(&-damping);
        let most_sweeps = 60 * state.nrows();
        let values = Schur::try_new(state, f64::EPSILON, most_sweeps)?.complex_eigenvalues();
        Some(Self { stiffness, damping, factor, values: values.iter().copied().collect() })
    }

    /// Largest growth rate of any motion, also of one that does not oscillate [1/s].
    pub fn growth_rate(&self) -> f64 {
        self.values.iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max)
    }

    /// λ of every oscillation by its natural frequency |λ|, lowest first. An oscillation near its critical damping has a slow imaginary part and
    /// decays as fast as its |λ|.
    pub fn oscillating(&self) -> Vec<Complex<f64>> {
        let oscillates = |value: &&Complex<f64>| value.im > OSCILLATES * value.norm();
        let mut values: Vec<_> = self.values.iter().filter(oscillates).copied().collect();
        values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        values
    }

    /// The lowest oscillations: null vectors of T(λ), for equal eigenvalues orthogonal ones. They are sought as L⁻ᵀ p with
    /// L⁻¹ T(λ) L⁻ᵀ p = 0, whose entries are of one size however stiff the stiffest motion is.
    pub fn oscillations(&self, count: usize) -> Option<Vec<Oscillation>> {
        let (factor, size) = (&self.factor, self.factor.nrows());
        let scaled = |matrix: &DMatrix<f64>| {
            let half = factor.solve_lower_triangular(matrix)?.transpose();
            factor.solve_lower_triangular(&half).map(|both| both.transpose())
        };
        let inertia = scaled(&DMatrix::identity(size, size))?;
        let (stiffness, damping) = (scaled(self.stiffness)?, scaled(self.damping)?);
        let back = factor.map(Complex::from);
        let (mut found, mut of_scaled): (Vec<Oscillation>, Vec<DVector<Complex<f64>>>) = Default::default();
        for value in self.oscillating().into_iter().take(count) {
            let is_equal = |other: &&Oscillation| (other.value - value).norm() < EQUAL * value.norm();
            let equal = found.iter().rev().take_while(is_equal).count();
            let matrix = |value: Complex<f64>| {
                DMatrix::from_fn(size, size, |row, column| {
                    let at = (row, column);
                    value * value * inertia[at] + value * damping[at] + stiffness[at]
                })
            };
            let of_value = null_vector(matrix, value, &of_scaled[of_scaled.len() - equal..])?;
            let vector = back.ad_solve_lower_triangular(&of_value)?;
            found.push(Oscillation { value, vector: vector.unscale(vector.norm()) });
            of_scaled.push(of_value);
        }
        Some(found)
    }
}

/// Vector of length 1 that the matrix at an eigenvalue takes to zero, orthogonal to `others`, which it takes to zero, too.
fn null_vector(
    matrix: impl Fn(Complex<f64>) -> DMatrix<Complex<f64>>,
    value: Complex<f64>,
    others: &[DVector<Complex<f64>>],
) -> Option<DVector<Complex<f64>>> {
    let at = matrix(value * (1.0 + BESIDE));
    by_inverse_iteration(&at, others).or_else(|| {
        let svd = at.svd(false, true);
        let right = svd.v_t?;
        let mut order: Vec<usize> = (0..right.nrows()).collect();
        order.sort_by(|a, b| svd.singular_values[*a].total_cmp(&svd.singular_values[*b]));
        Some(right.row(*order.get(others.len()).or(order.last())?).adjoint())
    })
}

/// `None` where it does not converge, as for eigenvalues that are equal but for rounding and share their vector.
fn by_inverse_iteration(
    matrix: &DMatrix<Complex<f64>>,
    others: &[DVector<Complex<f64>>],
) -> Option<DVector<Complex<f64>>> {
    let factors = matrix.clone().lu();
    // A start without symmetry has a share of every vector.
    let mut random = SplitMix64::new(others.len() as u64);
    let mut vector = DVector::from_fn(matrix.nrows(), |_, _| Complex::new(random.uniform(), random.uniform()));
    for _ in 0..INVERSE_ITERATIONS {
        vector = factors.solve(&vector)?;
        for other in others {
            let share = other.dotc(&vector);
            vector.axpy(-share, other, Complex::from(1.0));
        }
        vector.unscale_mut(vector.norm());
    }
    ((matrix * &vector).norm() < NULL * matrix.norm()).then_some(vector)
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

    fn oscillations(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Vec<Oscillation> {
        FreeMotion::of(stiffness, damping).unwrap().oscillations(usize::MAX).unwrap()
    }

    /// Jeffcott rotor on two equal planes with a gyroscopic coupling g: λ² ± i g λ + ω² = 0, so ω± = √(ω² + g²/4) ± g/2.
    #[test]
    fn gyroscopic_coupling_splits_a_double_frequency() {
        let stiffness = DMatrix::from_diagonal_element(2, 2, 100.0);
        let at_rest = oscillations(&stiffness, &DMatrix::zeros(2, 2));
        assert!(at_rest.len() == 2 && at_rest[0].likeness(&at_rest[1]) < 1e-12);
        let coupling = DMatrix::from_row_slice(2, 2, &[0.0, 3.0, -3.0, 0.0]);
        let found = oscillations(&stiffness, &coupling);
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
        let found = oscillations(&stiffness, &damping);
        assert!(found.len() == 1 && (found[0].value - Complex::new(-0.2, 3.96_f64.sqrt())).norm() < 1e-12);
        assert!(FreeMotion::of(&DMatrix::zeros(2, 2), &damping).is_none());
    }

    /// The vectors of damped, coupled motions with single, double and critically damped values solve their equations.
    #[test]
    fn vectors_solve_their_equations() {
        let mut random = SplitMix64::new(3);
        let spread = DMatrix::from_fn(6, 6, |_, _| random.uniform() - 0.5);
        let single = &spread * spread.transpose() * 1e6 + DMatrix::identity(6, 6) * 1e3;
        let double = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0, 4.0, 4.0, 4.0, 1e8]));
        let critical = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 0.1, 0.1, 3.9999999, 0.2, 0.0]));
        for (stiffness, damping) in
            [(single, spread.map(|entry| 20.0 * entry)), (double.clone(), &double * 1e-2), (double, critical)]
        {
            let found = oscillations(&stiffness, &damping);
            assert!(found.len() >= 5, "{}", found.len());
            for (index, Oscillation { value, vector }) in found.iter().enumerate() {
                let matrix = dynamic_stiffness(*value, &stiffness, &damping);
                assert!((&matrix * vector).norm() < 1e-9 * matrix.norm(), "{value}");
                let same = found[..index].iter().filter(|other| (other.value - value).norm() < EQUAL * value.norm());
                assert!(same.into_iter().all(|other| other.likeness(&found[index]) < 1e-9), "{value}");
            }
        }
    }
}
