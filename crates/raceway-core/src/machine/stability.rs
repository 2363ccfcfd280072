//! Stability of steps: bearings that are stiff against the inertia of the parts that they join need short ones.

use std::f64::consts::TAU;

use super::equations::MachineDynamics;
use super::input::{FastestPart, Machine};
use super::stepping::stiffness_of_step;
use crate::rotor::restraint::Owner;

/// Largest eigenvalue of K H [-] up to which the correction of the ports' forces is stable.
const MOST_STIFFNESS: f64 = 0.1;

/// True if the correction of the ports' forces is stable in steps of a length [s].
pub(super) fn is_stable(dynamics: &MachineDynamics, step: f64) -> bool {
    stiffness_of_step(dynamics, step) <= MOST_STIFFNESS
}

/// The part that the bearings move fastest: on which they are stiffest against its inertia.
pub(super) fn fastest_part(machine: &Machine, dynamics: &MachineDynamics) -> FastestPart {
    let system = &dynamics.frame.system;
    let speed = dynamics.speed.at(0.0).1;
    // Coordinates have mass 1.
    let by_bearings = system.matrices(speed).0 - &dynamics.frame.matrices(speed)[0];
    let (fastest, square) = by_bearings.diagonal().argmax();
    let housing = &system.coordinates.housing;
    let (name, inertia, field) = match housing.owner(fastest) {
        Some((Owner::Part(body), 0..3)) => {
            (machine.bodies[body].clone(), "mass", format!("housing.bodies[{body}].mass_kg"))
        }
        Some((Owner::Part(body), _)) => {
            (machine.bodies[body].clone(), "moment of inertia", format!("housing.bodies[{body}].inertia_kg_m2"))
        }
        Some((Owner::OuterRing(bearing), _)) => {
            let name = format!("the outer ring of {}", machine.bearings[bearing].name);
            (name, "mass", format!("bearings[{bearing}].outer_ring.mass_kg"))
        }
        None if housing.is_of_structure(fastest) => ("the imported structure".to_owned(), "mass", "housing".to_owned()),
        None => ("the shaft".to_owned(), "inertia", "shaft` or `spindle".to_owned()),
    };
    FastestPart { name, inertia, field, frequency: square.max(0.0).sqrt() / TAU }
}
