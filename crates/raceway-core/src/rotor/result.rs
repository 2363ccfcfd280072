//! Numbers of a rotor analysis, in SI and radians.

pub use nalgebra::Complex;

use crate::physics::frame::support::{PORT, PortMatrix};

/// Everything that a rotor analysis returns.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorResult {
    /// Mass of shaft and discs [kg].
    pub mass: f64,
    /// Place of the mass centre [m].
    pub mass_centre: f64,
    /// Places of the nodes along the shaft [m].
    pub nodes: Vec<f64>,
    /// Number of coordinates after the reduction.
    pub coordinates: usize,
    pub modes: Vec<ModeCourse>,
    /// Shapes of these modes at the operating speed.
    pub operating_modes: Vec<Mode>,
    /// Largest growth rate of any motion at the operating speed [1/s]; negative: all decay.
    pub growth_rate: f64,
    pub criticals: Vec<Critical>,
    pub stations: Vec<StationResponse>,
    /// Forces of the linear supports, then of the bearings.
    pub supports: Vec<SupportForces>,
    /// Forces of the bodies on their mounts.
    pub mounts: Vec<SupportForces>,
    pub bodies: Vec<BodyResult>,
    pub sensors: Vec<SensorResult>,
    pub bearings: Vec<BearingResult>,
    /// Static displacement x, y, z of each node at the operating speed [m].
    pub deflection: Vec<[f64; 3]>,
}

/// One natural frequency over the requested speeds.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeCourse {
    /// `None` where the motion has stopped to oscillate.
    pub points: Vec<Option<ModePoint>>,
}

/// A damped oscillation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModePoint {
    /// Damped angular frequency [rad/s].
    pub frequency: f64,
    /// −Re λ / |λ| [-]; negative: it grows.
    pub damping_ratio: f64,
    pub direction: Direction,
    /// Share of the kinetic energy that whirls forward, of the lateral motion, 0 … 1 [-].
    pub forward_share: f64,
}

/// Direction of a natural motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// With the rotation.
    Forward,
    /// Against the rotation.
    Backward,
    /// To and fro in a plane: at rest.
    Planar,
    /// More than half of the kinetic energy is along X.
    Axial,
}

/// A natural motion with its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    pub point: ModePoint,
    /// Displacements x, y, z of each node, real part times e^(λt); the largest has magnitude 1 and phase 0.
    pub shape: Vec<[Complex<f64>; 3]>,
    /// Displacements x, y, z, β_y, β_z of each part of the housing by the same motion [-, rad/m]: of the mass centre of a body, or of a port.
    pub bodies: Vec<[Complex<f64>; PORT]>,
}

/// A speed that equals a damped natural frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Critical {
    /// [rad/s]
    pub speed: f64,
    pub mode: Mode,
    /// Displacement by unbalance along Y and Z at each of the stations [m].
    pub displacement: Vec<[Complex<f64>; 2]>,
}

/// Response to unbalance at a place of the shaft, for each requested speed.
#[derive(Debug, Clone, PartialEq)]
pub struct StationResponse {
    /// [m]
    pub at: f64,
    /// Displacements y and z: real part times e^(iΩt) [m].
    pub displacement: Vec<[Complex<f64>; 2]>,
}

/// A part of the housing: the mass centre of a body, or a port.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyResult {
    /// Static displacement x, y, z [m] and tilt about y and z [rad] at the operating speed.
    pub at_rest: [f64; PORT],
    /// Displacements x, y and z by unbalance for each requested speed: real part times e^(iΩt) [m].
    pub response: Vec<[Complex<f64>; 3]>,
}

/// A sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorResult {
    /// Static displacement at the operating speed [m].
    pub at_rest: f64,
    /// Displacement by unbalance for each requested speed: real part times e^(iΩt) [m].
    pub response: Vec<Complex<f64>>,
}

/// Forces of the shaft on a support.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportForces {
    /// [m]
    pub at: f64,
    /// Static forces x, y, z [N] and moments about y and z [N m] at the operating speed.
    pub at_rest: [f64; 5],
    /// Forces y and z of the unbalance for each requested speed: real part times e^(iΩt) [N].
    pub dynamic: Vec<[Complex<f64>; 2]>,
}

/// A ball bearing at the operating point, along the shaft's axes and about its own centre.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingResult {
    /// [m]
    pub at: f64,
    /// Displacement of the inner ring from the outer one in the bearing's own axes [m, rad].
    pub pose: [f64; PORT],
    /// Mean, least and most over a ball spacing [N/m, N, N m/rad].
    pub stiffness: PortMatrix,
    pub least_stiffness: PortMatrix,
    pub most_stiffness: PortMatrix,
    /// Damping of the contacts for slow motions [N s/m, …].
    pub damping: PortMatrix,
    /// Largest load of a ball on the inner and on the outer raceway [N].
    pub largest_loads: [f64; 2],
    /// Share of the balls that the inner raceway presses [-].
    pub loaded: f64,
    /// Largest pressure of a ball on a raceway [Pa], with its load [N].
    pub largest_pressure: (f64, f64),
    /// Thrust over the open side of an angular-contact bearing [N].
    pub thrust_over_open_side: Option<f64>,
    /// Mean stiffness and damping at each requested speed.
    pub over_speed: Vec<(PortMatrix, PortMatrix)>,
}
