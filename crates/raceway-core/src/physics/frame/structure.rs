//! A structure that another program has reduced to ports: its modes, or its matrices, in coordinates of mass 1 whose stiffness is diagonal.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::support::PORT;

/// Deviation from symmetry, and from a definite matrix, that numbers of seven digits have, relative to the diagonal [-].
const DIGITS: f64 = 1e-6;
/// Smallest eigenvalue of a mass that is positive definite, of the matrix with ones on its diagonal [-]: below it, rounding decides.
const LEAST_MASS: f64 = 1e-12;
/// Square of a frequency that is that of a rigid motion, relative to the largest [-]: below it, rounding decides.
const RIGID: f64 = 1e-13;
/// Highest natural frequency [Hz]. Rounding beside it moves a motion at 1 Hz by less than 1 %.
pub const HIGHEST_FREQUENCY: f64 = 1e6;

/// q̈ + C q̇ + diag(ω²) q = f over coordinates of mass 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// ω² [1/s²]
    pub squares: Vec<f64>,
    /// C [1/s]
    pub damping: DMatrix<f64>,
    pub ports: Vec<StructurePort>,
}

/// A place of a structure at which something may act.
#[derive(Debug, Clone, PartialEq)]
pub struct StructurePort {
    /// Place along the shaft [m].
    pub at: f64,
    /// Displacements x, y, z, β_y, β_z, a row each, of the coordinates.
    pub rows: DMatrix<f64>,
}

/// A natural mode.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureMode {
    /// [Hz]
    pub frequency: f64,
    pub damping_ratio: f64,
    /// Modal mass in the scale of the shapes [kg].
    pub mass: f64,
    /// Displacements x, y, z [-] and tilts about y and z [rad/m] of each port.
    pub shapes: Vec<[f64; PORT]>,
}

/// Matrices over the same coordinates, of which some are displacements of ports. Rows of finite numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureMatrices {
    pub mass: Vec<Vec<f64>>,
    pub damping: Vec<Vec<f64>>,
    pub stiffness: Vec<Vec<f64>>,
    /// For each port its place [m] and the coordinates that are its displacements x, y, z, β_y, β_z; `None`: it is held.
    pub ports: Vec<(f64, [Option<usize>; PORT])>,
}

/// Name of a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatrixName {
    Mass,
    Damping,
    Stiffness,
}

/// Reason why matrices are those of no structure.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MatrixFault {
    #[error("{count} rows: must be {expected}, one for each coordinate")]
    Rows { count: usize, expected: usize },
    #[error("{count} numbers: must be {expected}, one for each coordinate")]
    Numbers { row: usize, count: usize, expected: usize },
    #[error("{value:e}, but {other:e} in the place mirrored at the diagonal: must be symmetric")]
    Asymmetric { row: usize, column: usize, value: f64, other: f64 },
    #[error("{value:e}: must be {bound} on the diagonal")]
    Diagonal { row: usize, value: f64, bound: &'static str },
    #[error(
        "must be positive {}definite, but its least eigenvalue is {eigenvalue:.1e} after scaling to ones on the diagonal",
        if *.is_strict { "" } else { "semi-" }
    )]
    Indefinite { eigenvalue: f64, is_strict: bool },
    #[error(
        "{frequency:e} Hz is its highest natural frequency: must be at most {HIGHEST_FREQUENCY:e} Hz; leave out stiff coordinates, or coordinates without mass"
    )]
    TooFast { frequency: f64 },
}

impl Structure {
    /// Of natural modes. `ports`: their places [m].
    pub fn of_modes(modes: &[StructureMode], ports: &[f64]) -> Self {
        let frequencies: Vec<f64> = modes.iter().map(|mode| TAU * mode.frequency).collect();
        let rates = modes.iter().zip(&frequencies).map(|(mode, frequency)| 2.0 * mode.damping_ratio * frequency);
        let shape = |port: usize, row: usize, mode: &StructureMode| mode.shapes[port][row] / mode.mass.sqrt();
        let rows = |port: usize| DMatrix::from_fn(PORT, modes.len(), |row, mode| shape(port, row, &modes[mode]));
        Self {
            squares: frequencies.iter().map(|frequency| frequency * frequency).collect(),
            damping: DMatrix::from_diagonal(&DVector::from_iterator(modes.len(), rates)),
            ports: ports.iter().enumerate().map(|(port, at)| StructurePort { at: *at, rows: rows(port) }).collect(),
        }
    }

    /// Of matrices over a number of coordinates; or every matrix that is none of a structure, with its first fault.
    pub fn of_matrices(
        matrices: &StructureMatrices,
        coordinates: usize,
    ) -> Result<Self, Vec<(MatrixName, MatrixFault)>> {
        let StructureMatrices { mass, damping, stiffness, ports } = matrices;
        let named = [(MatrixName::Mass, mass), (MatrixName::Damping, damping), (MatrixName::Stiffness, stiffness)];
        let checked = named
            .map(|(name, rows)| checked(rows, coordinates, name == MatrixName::Mass).map_err(|fault| (name, fault)));
        let [mass, damping, stiffness] = match checked {
            [Ok(mass), Ok(damping), Ok(stiffness)] => [mass, damping, stiffness],
            faulty => return Err(faulty.into_iter().filter_map(Result::err).collect()),
        };
        let lacks_mass = || {
            let fault = MatrixFault::Indefinite { eigenvalue: 0.0, is_strict: true };
            vec![(MatrixName::Mass, fault)]
        };
        // In coordinates with ones on the diagonal of the mass, kilograms stand beside moments of inertia.
        let scales = mass.diagonal().map(|mass| mass.sqrt().recip());
        let factor = scaled(&mass, &scales).cholesky().ok_or_else(lacks_mass)?.l();
        // A over coordinates L ᵀ q: L⁻¹ A L⁻ᵀ.
        let over_factor = |matrix: &DMatrix<f64>| {
            let half = factor.solve_lower_triangular(matrix)?;
            factor.solve_lower_triangular(&half.transpose())
        };
        let held = over_factor(&scaled(&stiffness, &scales)).ok_or_else(lacks_mass)?;
        let modes = SymmetricEigen::new(0.5 * (&held + held.transpose()));
        let highest = modes.eigenvalues.amax();
        let frequency = highest.sqrt() / TAU;
        if frequency > HIGHEST_FREQUENCY {
            return Err(vec![(MatrixName::Stiffness, MatrixFault::TooFast { frequency })]);
        }
        let damped = over_factor(&scaled(&damping, &scales)).ok_or_else(lacks_mass)?;
        let shapes = factor.tr_solve_lower_triangular(&modes.eigenvectors).ok_or_else(lacks_mass)?;
        let rows = |coordinates: &[Option<usize>; PORT]| {
            DMatrix::from_fn(PORT, shapes.ncols(), |row, mode| {
                coordinates[row].map_or(0.0, |coordinate| scales[coordinate] * shapes[(coordinate, mode)])
            })
        };
        let ports = ports.iter().map(|(at, coordinates)| StructurePort { at: *at, rows: rows(coordinates) }).collect();
        let square = |square: &f64| if *square > RIGID * highest { *square } else { 0.0 };
        Ok(Self {
            squares: modes.eigenvalues.iter().map(square).collect(),
            damping: modes.eigenvectors.transpose() * damped * &modes.eigenvectors,
            ports,
        })
    }
}

/// The matrix with factors for each row and column.
fn scaled(matrix: &DMatrix<f64>, scales: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(scales.len(), scales.len(), |row, column| scales[row] * matrix[(row, column)] * scales[column])
}

/// The symmetric part of a matrix, or the first reason why it is not symmetric and positive semi-definite, or definite where it must be.
fn checked(rows: &[Vec<f64>], expected: usize, is_definite: bool) -> Result<DMatrix<f64>, MatrixFault> {
    if rows.len() != expected {
        return Err(MatrixFault::Rows { count: rows.len(), expected });
    }
    if let Some((row, values)) = rows.iter().enumerate().find(|(_, values)| values.len() != expected) {
        return Err(MatrixFault::Numbers { row, count: values.len(), expected });
    }
    let diagonal = DVector::from_fn(expected, |row, _| rows[row][row]);
    let is_wrong = |value: f64| if is_definite { value <= 0.0 } else { value < 0.0 };
    if let Some(row) = (0..diagonal.len()).find(|row| is_wrong(diagonal[*row])) {
        let bound = if is_definite { "above 0" } else { "at least 0" };
        return Err(MatrixFault::Diagonal { row, value: diagonal[row], bound });
    }
    // An entry of a positive semi-definite matrix is at most the geometric mean of its diagonal entries.
    let places = (0..diagonal.len()).flat_map(|row| (0..row).map(move |column| (row, column)));
    for (row, column) in places {
        let (value, other) = (rows[row][column], rows[column][row]);
        if (value - other).abs() > DIGITS * (diagonal[row] * diagonal[column]).sqrt() {
            return Err(MatrixFault::Asymmetric { row, column, value, other });
        }
    }
    let scales = diagonal.map(|value| if value > 0.0 { value.sqrt().recip() } else { 1.0 });
    let symmetric = DMatrix::from_fn(expected, expected, |row, column| 0.5 * (rows[row][column] + rows[column][row]));
    let eigenvalue = SymmetricEigen::new(scaled(&symmetric, &scales)).eigenvalues.min();
    let is_indefinite = if is_definite { eigenvalue <= LEAST_MASS } else { eigenvalue < -DIGITS };
    if is_indefinite {
        return Err(MatrixFault::Indefinite { eigenvalue, is_strict: is_definite });
    }
    Ok(symmetric)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(change: impl Fn(&mut StructureMatrices)) -> Vec<(MatrixName, MatrixFault)> {
        let mut matrices = StructureMatrices {
            mass: vec![vec![2.0, 0.5], vec![0.5, 1.0]],
            damping: vec![vec![10.0, 0.0], vec![0.0, 0.0]],
            stiffness: vec![vec![1e7, -1e7], vec![-1e7, 1e7]],
            ports: vec![(0.1, [None, Some(0), None, None, None])],
        };
        change(&mut matrices);
        Structure::of_matrices(&matrices, 2).err().unwrap_or_default()
    }

    /// A free chain has a rigid motion of frequency zero and the vibration of its closed form.
    #[test]
    fn a_free_chain_has_a_rigid_motion() {
        let matrices = StructureMatrices {
            mass: vec![vec![2.0, 0.0], vec![0.0, 1.0]],
            damping: vec![vec![0.0; 2]; 2],
            stiffness: vec![vec![1e7, -1e7], vec![-1e7, 1e7]],
            ports: vec![(0.1, [None, Some(0), None, None, None])],
        };
        let mut squares = Structure::of_matrices(&matrices, 2).unwrap().squares;
        squares.sort_by(f64::total_cmp);
        assert_eq!(squares[0], 0.0);
        assert!((squares[1] / 1.5e7 - 1.0).abs() < 1e-12, "{squares:?}");
    }

    #[test]
    fn matrices_of_no_structure_are_refused() {
        use MatrixFault::{Asymmetric, Diagonal, Indefinite, Numbers, Rows, TooFast};
        assert_eq!(fault(|_| {}), Vec::new());
        // Seven digits are symmetric, six are not.
        assert_eq!(fault(|m| m.stiffness[0][1] -= 3.0), Vec::new());
        assert!(matches!(
            fault(|m| m.stiffness[0][1] -= 30.0)[..],
            [(MatrixName::Stiffness, Asymmetric { row: 1, column: 0, .. })]
        ));
        assert!(matches!(fault(|m| m.mass[1][1] = 0.0)[..], [(MatrixName::Mass, Diagonal { row: 1, .. })]));
        assert!(matches!(fault(|m| m.damping[1][1] = -1.0)[..], [(MatrixName::Damping, Diagonal { row: 1, .. })]));
        let soft = fault(|m| m.stiffness[0][0] = 9e6);
        assert!(matches!(soft[..], [(MatrixName::Stiffness, Indefinite { is_strict: false, .. })]), "{soft:?}");
        let massless = fault(|m| m.mass[1][1] = 0.125);
        assert!(matches!(massless[..], [(MatrixName::Mass, Indefinite { is_strict: true, .. })]), "{massless:?}");
        assert!(matches!(fault(|m| m.mass.truncate(1))[..], [(MatrixName::Mass, Rows { count: 1, expected: 2 })]));
        let ragged = fault(|m| m.damping[1].push(0.0));
        assert!(matches!(ragged[..], [(MatrixName::Damping, Numbers { row: 1, count: 3, expected: 2 })]));
        let light = |m: &mut StructureMatrices| m.mass = vec![vec![1e-9, 0.0], vec![0.0, 1e-9]];
        assert!(matches!(fault(light)[..], [(MatrixName::Stiffness, TooFast { .. })]));
        let both = fault(|m| (m.mass[0][0], m.stiffness[0][0]) = (-1.0, -1.0));
        assert_eq!(both.len(), 2);
    }
}
