//! Stability of steps: bearings that are stiff against the inertia of the parts that they join need short ones.

use std::f64::consts::TAU;

use super::equations::MachineDynamics;
use super::input::{Machine, MachineError};
use super::stepping::stiffness_of_step;
use crate::rotor::restraint::Owner;

/// Largest eigenvalue of K H [-] up to which the correction of the ports' forces is stable.
const MOST_STIFFNESS: f64 = 0.1;

/// Whether the correction of the ports' forces is stable in steps of a length [s].
pub(super) fn is_stable(dynamics: &MachineDynamics, step: f64) -> bool {
    stiffness_of_step(dynamics, step) <= MOST_STIFFNESS
}

/// The error of a machine for which not even the shortest steps are stable [s]. It names the part on which the bearings are stiffest against its
/// inertia.
pub(super) fn too_light(machine: &Machine, dynamics: &MachineDynamics, shortest: f64) -> MachineError {
    let system = &dynamics.frame.system;
    let speed = dynamics.speed.at(0.0).1;
    // Coordinates have mass 1.
    let by_bearings = system.matrices(speed).0 - &dynamics.frame.matrices(speed)[0];
    let (fastest, square) = by_bearings.diagonal().argmax();
    let housing = &system.coordinates.housing;
    let (part, field) = match housing.owner(fastest) {
        Some((Owner::Part(body), displacement)) => {
            let (of, field) =
                if displacement < 3 { ("mass", "mass_kg") } else { ("moment of inertia", "inertia_kg_m2") };
            (format!("the {of} of {}", machine.bodies[body]), format!("housing.bodies[{body}].{field}"))
        }
        Some((Owner::OuterRing(bearing), _)) => {
            let name = &machine.bearings[bearing].name;
            (format!("the mass of the outer ring of {name}"), format!("bearings[{bearing}].outer_ring.mass_kg"))
        }
        None if housing.is_of_structure(fastest) => {
            ("the mass of the imported structure".to_owned(), "housing".to_owned())
        }
        None => ("the mass of the shaft".to_owned(), "shaft".to_owned()),
    };
    MachineError::TooLight { part, field, frequency: square.sqrt() / TAU, shortest }
}
