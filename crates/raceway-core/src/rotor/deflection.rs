//! Static deflection under weight and loads.

use nalgebra::DVector;

use super::input::{Rotor, RotorError};
use super::system::System;

/// The coordinates at rest under weight and loads, with the rotating damping of the operating speed.
pub fn deflection(system: &System, rotor: &Rotor) -> Result<DVector<f64>, RotorError> {
    let centre = rotor.shaft.mass_centre();
    let weight = system.coordinates.weight(rotor.shaft.mass() * rotor.gravity);
    let load = system.coordinates.force(centre, rotor.load);
    let force = DVector::from_iterator(weight.len(), weight.iter().zip(&load).map(|(weight, load)| weight + load));
    let (stiffness, _) = system.matrices(rotor.speed);
    stiffness.lu().solve(&force).ok_or(RotorError::Unrestrained)
}
