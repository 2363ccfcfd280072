//! Linear springs and dashpots of a rotor: supports, mounts of the housing, seats of outer rings.

use nalgebra::DMatrix;

use super::housing::HousingCoordinates;
use super::input::{Rotor, RotorBearing, Seat};
use crate::physics::frame::support::{PortMatrix, diagonal};
use crate::physics::statics::shaft::Faces;

/// A spring and a dashpot between two places, over all coordinates.
#[derive(Debug, Clone)]
pub struct LinearSpring {
    /// Displacements of the one place from the other.
    pub rows: DMatrix<f64>,
    pub stiffness: PortMatrix,
    pub damping: PortMatrix,
    /// Force along X with which it pushes the one place [N].
    pub push: f64,
}

/// Supports, mounts and seats, each in the order of the input. `shaft`: displacements of a place of the shaft over all coordinates.
pub fn springs(rotor: &Rotor, shaft: impl Fn(f64) -> DMatrix<f64>, housing: &HousingCoordinates) -> Vec<LinearSpring> {
    let supports = rotor.supports.iter().map(|support| {
        let rows = relative(shaft(support.at), support.on.map(|_| housing.part(support.on, support.at)));
        LinearSpring { rows, stiffness: support.stiffness, damping: support.damping, push: 0.0 }
    });
    let mounts = rotor.housing.mounts.iter().map(|mount| {
        let rows = housing.part(Some(mount.body), mount.at) - housing.part(mount.to, mount.at);
        LinearSpring { rows, stiffness: mount.stiffness, damping: mount.damping, push: 0.0 }
    });
    let seats = rotor.bearings.iter().enumerate().filter_map(|(index, bearing)| seat(index, bearing, housing));
    supports.chain(mounts).chain(seats).collect()
}

/// Displacements of the inner ring of a bearing from its outer ring, at the place of the inner one. `slipped`: distance by which the inner ring
/// has moved along what carries the outer one [m].
pub fn between_rings(
    rotor: &Rotor,
    index: usize,
    shaft: impl Fn(f64) -> DMatrix<f64>,
    housing: &HousingCoordinates,
    slipped: f64,
) -> DMatrix<f64> {
    let bearing = &rotor.bearings[index];
    let outer = bearing.has_moving_outer_ring().then(|| housing.outer_ring(index, bearing.at + slipped));
    bearing.seen(relative(shaft(bearing.at), outer))
}

fn relative(rows: DMatrix<f64>, other: Option<DMatrix<f64>>) -> DMatrix<f64> {
    match other {
        Some(other) => rows - other,
        None => rows,
    }
}

/// The spring between an outer ring and what carries it; `None` of a rigid seat.
fn seat(index: usize, bearing: &RotorBearing, housing: &HousingCoordinates) -> Option<LinearSpring> {
    let at = bearing.outer_ring();
    let rows = housing.outer_ring(index, at) - housing.part(bearing.on, at);
    match bearing.seat {
        Seat::Rigid => None,
        Seat::Elastic { stiffness, damping, .. } => Some(LinearSpring { rows, stiffness, damping, push: 0.0 }),
        Seat::Sliding { spring, damping, .. } => Some(LinearSpring {
            rows,
            stiffness: diagonal([spring.stiffness, 0.0, 0.0, 0.0, 0.0]),
            damping: diagonal([damping, 0.0, 0.0, 0.0, 0.0]),
            // Against the thrust of the shaft that the bearing carries.
            push: if bearing.mounted.faces == Faces::PlusX { -spring.force } else { spring.force },
        }),
    }
}
