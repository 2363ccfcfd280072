//! Linear supports: a spring and a dashpot between the shaft and the ground or a body, over five displacements.

/// Number of displacements of a port: x, y, z, β_y, β_z.
pub const PORT: usize = 5;

/// Matrix over the displacements of a port [N/m, N, N m/rad].
pub type PortMatrix = [[f64; PORT]; PORT];

/// Stiffness and damping at one place of the shaft. Neither has to be symmetric: a plain bearing's are not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// Place along the shaft [m].
    pub at: f64,
    /// Number of the housing's part that holds it; `None`: the ground.
    pub on: Option<usize>,
    pub stiffness: PortMatrix,
    pub damping: PortMatrix,
}

/// The matrix with this diagonal.
pub fn diagonal(values: [f64; PORT]) -> PortMatrix {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { values[row] } else { 0.0 }))
}
