//! Static deflection under weight and loads.

use nalgebra::DVector;

use super::input::{Rotor, RotorError};
use super::system::System;

/// The coordinates at rest under weight and loads at the operating speed.
///
/// Bearings are in equilibrium at the operating speed: it is the only speed of `system`, if there are any.
pub fn deflection(system: &System, rotor: &Rotor) -> Result<DVector<f64>, RotorError> {
    if let Some(point) = system.operating.first() {
        return Ok(point.coordinates.clone());
    }
    let (stiffness, _) = system.matrices(rotor.speed);
    stiffness.lu().solve(&system.load(rotor)).ok_or(RotorError::Unrestrained)
}
