//! A shaft on its supports and its housing, linear about its operating point: natural frequencies and damping over speed, critical speeds, response
//! to unbalance, static deflection. No time is stepped; a result takes milliseconds. Knows no JSON.
//!
//! The shaft's free modes and residual vectors are the coordinates: mass 1, stiffness diagonal, gyroscopic terms proportional to
//! speed. Rigid motions of housing bodies and of outer rings stand beside them. Springs act on all through the displacements of their places.

pub mod input;
pub mod omission;
pub mod result;
pub mod sensor;

pub mod analysis;
pub mod restraint;

pub(crate) mod coordinates;
pub(crate) mod housing;
pub(crate) mod operating;
pub(crate) mod springs;
pub(crate) mod system;
mod turning_seats;

mod campbell;
mod critical;
pub(crate) mod deflection;
pub(crate) mod level_change;
mod potential;
pub(crate) mod response;
mod shape;

#[cfg(test)]
mod tests;
