//! Free modes of a chain of elements, and the static answers of the modes that are left out.

use nalgebra::{DMatrix, SymmetricEigen};

use super::mesh::Matrices;
use crate::numerics::banded::{BandFactor, SymmetricBand};
use crate::numerics::random::SplitMix64;

/// Shapes that are orthonormal in the mass and orthogonal in the stiffness: all motions of a chain that matter.
///
/// They are the rigid motions, the lowest flexible modes, and for each loaded unknown the static answer of the rest, made orthogonal
/// to all others (residual vectors; R. R. Craig & A. J. Kurdila, *Fundamentals of Structural Dynamics*, 2006, ch. 17).
#[derive(Debug, Clone)]
pub struct FreeModes {
    /// Squares of the angular frequencies, of the residual vectors, too [1/s²].
    pub squares: Vec<f64>,
    /// Displacements of the unknowns, one shape after another.
    pub shapes: Vec<Vec<f64>>,
    /// Number of rigid motions and true modes; residual vectors follow.
    pub true_modes: usize,
}

/// Largest remainder of an eigenvector, relative to its eigenvalue [-]. The error of the eigenvalue is its square.
const CONVERGED: f64 = 1e-9;
/// Norm of a residual vector below which the other shapes have it already, relative to the whole static answer [-].
const DEPENDENT: f64 = 1e-10;

impl FreeModes {
    /// Rigid motions and at most `count` flexible modes. `None` where the matrices are no chain.
    pub(crate) fn of(chain: &Matrices, count: usize) -> Option<Self> {
        let factor = shifted(chain)?;
        let mut shapes: Vec<Vec<f64>> = Vec::new();
        for motion in &chain.rigid {
            let rest = without(motion.clone(), &shapes, &chain.mass);
            let norm = norm(&rest, &chain.mass);
            shapes.push(scaled(rest, 1.0 / norm));
        }
        let mut squares = vec![0.0; shapes.len()];
        for (square, shape) in flexible_modes(chain, &factor, &shapes, count) {
            squares.push(square);
            shapes.push(shape);
        }
        let true_modes = shapes.len();
        Some(Self { squares, shapes, true_modes })
    }

    /// The first rigid motion alone, a translation.
    pub(crate) fn of_translation(mut self) -> Self {
        self.squares.truncate(1);
        self.shapes.truncate(1);
        self.true_modes = 1;
        self
    }

    /// Free modes with the residual vectors of these loads.
    pub(crate) fn with_residuals(mut self, chain: &Matrices, loads: &[Vec<f64>]) -> Option<Self> {
        let residuals = residual_vectors(chain, &shifted(chain)?, &self.shapes, loads);
        for (square, shape) in uncoupled(&chain.stiffness, residuals) {
            self.squares.push(square);
            self.shapes.push(shape);
        }
        Some(self)
    }

    pub fn len(&self) -> usize {
        self.shapes.len()
    }

    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Values of an unknown in all shapes.
    pub fn row(&self, unknown: usize) -> impl Iterator<Item = f64> + '_ {
        self.shapes.iter().map(move |shape| shape[unknown])
    }

    /// Forces on the shapes of forces on the unknowns.
    pub fn forces(&self, forces: &[f64]) -> Vec<f64> {
        self.shapes.iter().map(|shape| dot(shape, forces)).collect()
    }

    /// A matrix of the chain over the shapes.
    pub(crate) fn projected(&self, matrix: &SymmetricBand) -> DMatrix<f64> {
        let products: Vec<Vec<f64>> = self.shapes.iter().map(|shape| matrix.times(shape)).collect();
        DMatrix::from_fn(self.len(), self.len(), |row, column| dot(&self.shapes[row], &products[column]))
    }
}

/// The factor of K + σ M.
fn shifted(chain: &Matrices) -> Option<BandFactor> {
    chain.stiffness.clone().plus(chain.shift, &chain.mass).cholesky()
}

/// Lowest flexible modes by the method of Lanczos on (K + σ M)⁻¹ M with complete orthogonalization, the rigid motions removed.
fn flexible_modes(chain: &Matrices, factor: &BandFactor, rigid: &[Vec<f64>], count: usize) -> Vec<(f64, Vec<f64>)> {
    let most = rigid[0].len() - rigid.len();
    let count = count.min(most);
    if count == 0 {
        return Vec::new();
    }
    let mut steps = (2 * count + 20).min(most);
    loop {
        let (modes, is_converged) = lanczos(chain, factor, rigid, count, steps);
        if is_converged || steps == most {
            return modes;
        }
        steps = (2 * steps).min(most);
    }
}

/// The modes of a Krylov space of this many dimensions, and whether all have converged.
fn lanczos(
    chain: &Matrices,
    factor: &BandFactor,
    rigid: &[Vec<f64>],
    count: usize,
    steps: usize,
) -> (Vec<(f64, Vec<f64>)>, bool) {
    let mut random = SplitMix64::new(1);
    let start: Vec<f64> = rigid[0].iter().map(|_| random.uniform() - 0.5).collect();
    let mut space: Vec<Vec<f64>> = rigid.to_vec();
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut next = without(factor.solve(&chain.mass.times(&start)), &space, &chain.mass);
    let mut size = norm(&next, &chain.mass);
    let first_size = size;
    // Massless unknowns leave fewer dimensions than steps.
    while diagonal.len() < steps && size > f64::EPSILON * first_size {
        let direction = scaled(next, 1.0 / size);
        let loaded = chain.mass.times(&direction);
        let answer = factor.solve(&loaded);
        diagonal.push(dot(&answer, &loaded));
        space.push(direction);
        next = without(answer, &space, &chain.mass);
        size = norm(&next, &chain.mass);
        beside.push(size);
    }
    let steps = diagonal.len();
    let tridiagonal = DMatrix::from_fn(steps, steps, |row, column| match row.abs_diff(column) {
        0 => diagonal[row],
        1 => beside[row.min(column)],
        _ => 0.0,
    });
    let eigen = SymmetricEigen::new(tridiagonal);
    let mut order: Vec<usize> = (0..steps).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    order.truncate(count);
    let remainder = |k: &usize| size * eigen.eigenvectors[(steps - 1, *k)].abs() / eigen.eigenvalues[*k];
    let is_converged = order.iter().all(|k| remainder(k) < CONVERGED);
    let mode = |k: usize| {
        let combination = eigen.eigenvectors.column(k);
        let mut shape = vec![0.0; start.len()];
        for (share, direction) in combination.iter().zip(&space[rigid.len()..]) {
            for (value, part) in shape.iter_mut().zip(direction) {
                *value += share * part;
            }
        }
        (1.0 / eigen.eigenvalues[k] - chain.shift, shape)
    };
    (order.into_iter().map(mode).collect(), is_converged)
}

/// Static answers to the loads of everything orthogonal to `shapes`, orthonormal in the mass.
fn residual_vectors(chain: &Matrices, factor: &BandFactor, shapes: &[Vec<f64>], loads: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut known = shapes.to_vec();
    for load in loads {
        // The load that the shapes leave over.
        let mut rest = load.clone();
        for shape in shapes {
            let (share, inertia) = (dot(shape, load), chain.mass.times(shape));
            rest.iter_mut().zip(&inertia).for_each(|(value, inertia)| *value -= share * inertia);
        }
        // The shifted factor answers too little by the shift over the squares of the modes left out.
        let mut answer = factor.solve(&rest);
        for _ in 0..2 {
            answer = without(answer, shapes, &chain.mass);
            let held = chain.stiffness.times(&answer);
            let lacking: Vec<f64> = rest.iter().zip(&held).map(|(load, held)| load - held).collect();
            answer.iter_mut().zip(factor.solve(&lacking)).for_each(|(value, more)| *value += more);
        }
        let whole = norm(&factor.solve(load), &chain.mass);
        let vector = without(answer, &known, &chain.mass);
        let size = norm(&vector, &chain.mass);
        if size > DEPENDENT * whole {
            known.push(scaled(vector, 1.0 / size));
        }
    }
    known.split_off(shapes.len())
}

/// Combinations of vectors that the stiffness does not couple, with their squares of angular frequencies.
fn uncoupled(stiffness: &SymmetricBand, vectors: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
    if vectors.is_empty() {
        return Vec::new();
    }
    let forces: Vec<Vec<f64>> = vectors.iter().map(|vector| stiffness.times(vector)).collect();
    let reduced = DMatrix::from_fn(vectors.len(), vectors.len(), |row, column| dot(&vectors[row], &forces[column]));
    let eigen = SymmetricEigen::new(reduced);
    let combined = |k: usize| {
        let shares = eigen.eigenvectors.column(k);
        let value = |i: usize| shares.iter().zip(&vectors).map(|(share, vector)| share * vector[i]).sum();
        (eigen.eigenvalues[k], (0..vectors[0].len()).map(value).collect())
    };
    (0..vectors.len()).map(combined).collect()
}

/// The vector without its parts along orthonormal ones, removed twice against rounding.
fn without(mut vector: Vec<f64>, orthonormal: &[Vec<f64>], mass: &SymmetricBand) -> Vec<f64> {
    for _ in 0..2 {
        let inertia = mass.times(&vector);
        for known in orthonormal {
            let share = dot(known, &inertia);
            vector.iter_mut().zip(known).for_each(|(value, known)| *value -= share * known);
        }
    }
    vector
}

fn norm(vector: &[f64], mass: &SymmetricBand) -> f64 {
    dot(vector, &mass.times(vector)).max(0.0).sqrt()
}

fn scaled(mut vector: Vec<f64>, factor: f64) -> Vec<f64> {
    vector.iter_mut().for_each(|value| *value *= factor);
    vector
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
