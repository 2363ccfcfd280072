//! The bearing: materials, geometry, contacts, bodies and the forces between them, in SI and
//! radians. Imports `numerics`; knows no HTTP, JSON, SQL, thread or clock.

pub mod ball;
pub mod bearing;
pub mod cage;
pub mod contact;
pub mod defaults;
pub mod drag;
pub mod frames;
pub mod kinematics;
pub mod land;
pub mod limits;
pub mod lubricant;
pub mod material;
pub mod operation;
pub mod pocket;
pub mod presets;
pub mod raceway;
pub mod rating;
pub mod spindle;
pub mod surface;

/// A parameter that no bearing can have. `parameter` is its path in dots, in SI without unit
/// suffix, such as `bearing.ball_diameter`; `contract` turns it into a JSON pointer and the user's unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvalidParameter {
    /// Outside `lowest ..= highest` (infinite: no limit; `exclusive`: the lowest itself is refused). SI.
    #[error("{parameter} = {value} must lie in {lowest} … {highest}")]
    OutOfRange { parameter: &'static str, value: f64, lowest: f64, highest: f64, exclusive: bool },
    /// Each value is allowed by itself, but together they fit no bearing.
    #[error("{parameter}: {reason}")]
    Inconsistent { parameter: &'static str, reason: String },
}

#[cfg(test)]
pub(crate) mod examples;
