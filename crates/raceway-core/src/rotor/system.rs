//! Matrices of a rotor on its supports, as functions of speed.

use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinates;
use super::input::{Rotor, RotorError};
use crate::numerics::quadratic_eigen::{Oscillation, oscillations};
use crate::physics::frame::mesh::Mesh;
use crate::physics::frame::support::{PORT, PortMatrix};

/// q̈ + C(Ω) q̇ + K(Ω) q = f over the coordinates of the shaft.
#[derive(Debug, Clone)]
pub struct System {
    pub coordinates: Coordinates,
    pub ports: Vec<Port>,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
    /// Factors of the speed: of the velocities (gyroscopic moments), and of the displacements (damping that turns along).
    gyroscopic: DMatrix<f64>,
    rotating: DMatrix<f64>,
}

/// A support, and the displacements of its place.
#[derive(Debug, Clone)]
pub struct Port {
    pub rows: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub damping: DMatrix<f64>,
}

impl System {
    /// At most `count` flexible modes in each plane.
    pub fn of(rotor: &Rotor, mesh: Mesh, count: usize) -> Result<Self, RotorError> {
        let coordinates = Coordinates::of(rotor, mesh, count)?;
        let squares = DVector::from_iterator(coordinates.len(), coordinates.squares());
        let own_damping = squares.map(|square| 2.0 * rotor.shaft.damping_ratio * square.sqrt());
        let mut stiffness = DMatrix::from_diagonal(&squares);
        let mut damping = DMatrix::from_diagonal(&own_damping);
        let port = |place: f64| coordinates.port(coordinates.mesh.node(place));
        let of_support = |at, k: &PortMatrix, c: &PortMatrix| Port {
            rows: port(at),
            stiffness: in_nalgebra(k),
            damping: in_nalgebra(c),
        };
        let ports: Vec<Port> = rotor.supports.iter().map(|s| of_support(s.at, &s.stiffness, &s.damping)).collect();
        for port in &ports {
            stiffness += port.rows.transpose() * &port.stiffness * &port.rows;
            damping += port.rows.transpose() * &port.damping * &port.rows;
        }
        let (size, count) = (coordinates.len(), coordinates.laterals());
        let (y, z) = (coordinates.axials(), coordinates.axials() + count);
        let antisymmetric = |of_plane: &DMatrix<f64>| {
            let mut whole = DMatrix::zeros(size, size);
            whole.view_mut((y, z), (count, count)).copy_from(of_plane);
            whole.view_mut((z, y), (count, count)).copy_from(&-of_plane);
            whole
        };
        let gyroscopic = antisymmetric(&coordinates.polar);
        let turning = own_damping.rows(y, count) * rotor.shaft.rotating_share;
        let rotating = antisymmetric(&DMatrix::from_diagonal(&turning));
        Ok(Self { coordinates, ports, stiffness, damping, gyroscopic, rotating })
    }

    /// Stiffness K and damping C at a speed [rad/s].
    ///
    /// I_t β̈_y + I_p Ω β̇_z = M_y and I_t β̈_z − I_p Ω β̇_y = M_z. Damping c of the shaft that turns along acts on the velocity
    /// against the turning shaft: −c (u̇ − Ω J u), J(y, z) = (−z, y).
    pub fn matrices(&self, speed: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        (&self.stiffness + &self.rotating * speed, &self.damping + &self.gyroscopic * speed)
    }

    /// Stiffness of shaft and supports at rest.
    pub fn stiffness(&self) -> &DMatrix<f64> {
        &self.stiffness
    }

    /// Factor of the speed in the matrix of the velocities.
    pub fn gyroscopic(&self) -> &DMatrix<f64> {
        &self.gyroscopic
    }

    /// Every oscillation at a speed, slowest first.
    pub fn oscillations(&self, speed: f64) -> Result<Vec<Oscillation>, RotorError> {
        let (stiffness, damping) = self.matrices(speed);
        oscillations(&stiffness, &damping).ok_or(RotorError::Unrestrained)
    }
}

fn in_nalgebra(matrix: &PortMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(PORT, PORT, |row, column| matrix[row][column])
}
