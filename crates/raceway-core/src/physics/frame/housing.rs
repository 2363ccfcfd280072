//! The housing: rigid bodies on linear springs, in the five displacements of a port. Their mass centres lie on the axis of the shaft, and
//! their roll is held.

use super::support::PortMatrix;

/// A rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Place of its mass centre along the shaft [m].
    pub at: f64,
    /// [kg]
    pub mass: f64,
    /// Moments of inertia about Y and Z [kg m²].
    pub inertia: [f64; 2],
}

/// A spring and a dashpot between a body and the ground, or another body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Number of the body.
    pub body: usize,
    /// Number of the other body; `None`: the ground.
    pub to: Option<usize>,
    /// Place along the shaft [m].
    pub at: f64,
    pub stiffness: PortMatrix,
    pub damping: PortMatrix,
}

/// Bodies with their mounts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Housing {
    pub bodies: Vec<Body>,
    pub mounts: Vec<Mount>,
}
