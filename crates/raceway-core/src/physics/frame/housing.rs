//! The housing: rigid bodies on linear springs, in the five displacements of a port, and a structure that was reduced to ports. Mass centres
//! of bodies lie on the axis of the shaft, and their roll is held.

use super::structure::Structure;
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

/// A spring and a dashpot between a part and the ground, or another part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Number of the part.
    pub body: usize,
    /// Number of the other part; `None`: the ground.
    pub to: Option<usize>,
    /// Place along the shaft [m].
    pub at: f64,
    pub stiffness: PortMatrix,
    pub damping: PortMatrix,
}

/// Bodies with their mounts, and an imported structure. Its parts, by their number, are the bodies and then the ports of the structure.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Housing {
    pub bodies: Vec<Body>,
    pub mounts: Vec<Mount>,
    pub structure: Option<Structure>,
}

impl Housing {
    /// Places of its parts along the shaft [m].
    pub fn places(&self) -> impl Iterator<Item = f64> + '_ {
        let ports = self.structure.iter().flat_map(|structure| &structure.ports);
        self.bodies.iter().map(|body| body.at).chain(ports.map(|port| port.at))
    }

    /// True if it has a part.
    pub fn moves(&self) -> bool {
        !self.bodies.is_empty() || self.structure.is_some()
    }
}
