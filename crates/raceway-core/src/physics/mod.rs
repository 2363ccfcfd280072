//! The bearing: materials, geometry, contacts, bodies and the forces between them, in SI and
//! radians. Imports `numerics`; knows no HTTP, JSON, SQL, thread or clock.

pub(crate) mod ball;
pub mod bearing;
pub mod cage;
pub mod catalogue;
pub mod clearance;
pub mod contact;
pub mod defaults;
pub mod designation;
pub mod drag;
pub mod frame;
pub mod frames;
pub mod friction_reference;
pub mod kinematics;
pub mod land;
pub mod life;
pub mod limits;
pub mod loads;
pub mod lubricant;
pub mod material;
pub mod neighbour;
pub mod oil;
pub mod operation;
pub mod pocket;
pub mod presets;
pub mod raceway;
pub mod rating;
pub mod samples;
pub mod seat;
pub mod spindle;
pub mod statics;
pub mod surface;

pub use limits::InvalidParameter;

#[cfg(test)]
pub(crate) mod examples;
