//! Quasi-static bearings: balls in equilibrium between an inner ring of five freedoms and the outer ring, at a speed.
//!
//! Freedoms stand in the order x, y, z, β_y, β_z: the displacement of the inner ring's centre from that of the outer ring [m], and the slopes
//! β_y = −z′, β_z = y′ of its axis [rad]. Forces [N] and moments about the inner ring's centre [N m] stand in the same order. Raceways are ideal and
//! balls alike. Balls bear centrifugal force and gyroscopic moments; their weight is left out, and so are lubricant films and all other friction.

mod balance;
mod ball;
mod groove;
pub mod ring;
mod rolling;
pub mod shaft;
mod stiffness;

pub(crate) use balance::{FIRST_STEP, MAX_RELATIVE_DEPTH, check_residual, search};
pub(crate) use ball::OF_BALL;
pub use ball::{Matrix, Pose, RingBearing, Wrench};

#[cfg(test)]
mod tests;
