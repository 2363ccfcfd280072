//! What a rotor analysis is asked for.

use crate::physics::frame::disc::UnbalancePlane;
use crate::physics::frame::shaft::Shaft;
use crate::physics::frame::support::Support;

/// A shaft on linear supports.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotor {
    pub shaft: Shaft,
    pub unbalances: Vec<UnbalancePlane>,
    pub supports: Vec<Support>,
    /// Operating speed [rad/s].
    pub speed: f64,
    /// Acceleration along +Y [m/s²].
    pub gravity: f64,
    /// Force on the mass centre along X, Y, Z [N].
    pub load: [f64; 3],
}

/// Elements of the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elements {
    /// Refined until the kept frequencies have converged.
    Auto,
    /// One for each section, divided only where something acts on the shaft.
    Sections,
}

/// What is computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    pub elements: Elements,
    /// Speeds, rising, none negative [rad/s].
    pub speeds: Vec<f64>,
    /// Number of natural frequencies.
    pub modes: usize,
}

/// Reason why there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RotorError {
    /// The supports leave a motion of the shaft free, or push it away.
    #[error("the supports do not restrain every motion of the shaft")]
    Unrestrained,
    /// A shaft without mass, or with lengths too far apart for double precision.
    #[error("the shaft has no free modes")]
    Singular,
}
