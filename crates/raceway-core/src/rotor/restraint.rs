//! Motions of shaft, housing and outer rings that nothing restrains.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::housing::HousingCoordinates;
pub use super::housing::Owner;
use super::input::Rotor;
use super::springs::{between_rings, springs};
use crate::physics::frame::shaft::ShaftMotion;
use crate::physics::frame::support::PORT;

/// Smallest stiffness of a motion that holds it, relative to those of the single displacements [-]: below it, rounding decides.
const LEAST_STIFFNESS: f64 = 1e-12;
/// Stiffness that stands for a loaded ball bearing [N/m]; only whether it holds a displacement matters.
const OF_BEARING: f64 = 1e8;
/// Displacement of a port that moves, relative to the largest that its coordinates could give it [-]: below it, rounding decides.
const LEAST_MOTION: f64 = 1e-9;
/// Share of the largest displacement from which on a body is named rather than the shaft [-].
const NAMED: f64 = 0.1;

/// A motion that nothing restrains, by what moves most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FreeMotion {
    Shaft,
    /// A part of the housing or an outer ring: displacement x, y, z, β_y or β_z.
    Beside(Owner, usize),
    /// An imported structure moves, but none of its ports.
    InsideStructure,
}

/// A motion without stiffness; `None` where springs and bearings may hold all. A ball bearing counts as if it held every displacement
/// between its rings: whether it does shows at the operating point.
pub fn free_motion(rotor: &Rotor) -> Option<FreeMotion> {
    let (length, centre) = (rotor.shaft.length(), rotor.shaft.mass_centre());
    let housing = HousingCoordinates::of(rotor, PORT);
    // Displacements of a place of the shaft from those of its mass centre; tilts times the length are displacements.
    let shaft = |at: f64| {
        let arm = (at - centre) / length;
        let mut rows = DMatrix::<f64>::zeros(PORT, housing.end());
        rows.view_mut((0, 0), (PORT, PORT)).fill_with_identity();
        (rows[(1, 4)], rows[(2, 3)]) = (arm, -arm);
        (rows[(3, 3)], rows[(4, 4)]) = (1.0 / length, 1.0 / length);
        rows
    };
    let own = std::iter::repeat_n(0.0, PORT).chain(housing.squares(PORT));
    let mut stiffness = DMatrix::<f64>::from_diagonal(&DVector::from_iterator(housing.end(), own));
    for spring in springs(rotor, shaft, &housing) {
        let of_port = DMatrix::from_fn(PORT, PORT, |row, column| spring.stiffness[row][column]);
        stiffness += spring.rows.transpose() * of_port * &spring.rows;
    }
    for (index, bearing) in rotor.bearings.iter().enumerate() {
        let radius = bearing.mounted.bearing.pitch_radius();
        let squares = DVector::from_fn(PORT, |row, _| if row < 3 { 1.0 } else { radius * radius });
        let rows = between_rings(rotor, index, shaft, &housing, 0.0);
        stiffness += rows.transpose() * DMatrix::from_diagonal(&(squares * OF_BEARING)) * &rows;
    }
    if rotor.shaft.motion == ShaftMotion::Upright {
        (stiffness[(3, 3)], stiffness[(4, 4)]) = (OF_BEARING, OF_BEARING);
    }
    let first = if rotor.shaft.is_axially_free { 0 } else { 1 };
    let size = housing.end() - first;
    let held = (0.5 * (&stiffness + stiffness.transpose())).view((first, first), (size, size)).into_owned();
    // Each displacement by its own stiffness: soft mounts stand beside stiff seats.
    let scales = DVector::from_fn(size, |k, _| if held[(k, k)] > 0.0 { held[(k, k)].sqrt().recip() } else { 1.0 });
    let scaled = DMatrix::from_fn(size, size, |row, column| scales[row] * held[(row, column)] * scales[column]);
    let eigen = SymmetricEigen::new(scaled);
    let (least, value) = eigen.eigenvalues.argmin();
    if value > LEAST_STIFFNESS {
        return None;
    }
    let motion = eigen.eigenvectors.column(least);
    let largest = motion.amax();
    let named: Vec<usize> = (0..size).filter(|k| motion[*k].abs() > NAMED * largest).map(|k| k + first).collect();
    let beside = named.iter().filter_map(|k| housing.owner(*k));
    let beside = beside.min_by_key(|(owner, _)| !matches!(owner, Owner::Part(_)));
    if let Some((owner @ Owner::Part(_), displacement)) = beside {
        return Some(FreeMotion::Beside(owner, displacement));
    }
    if named.iter().any(|k| housing.is_of_structure(*k)) {
        let moved = DVector::from_fn(housing.end(), |k, _| match k.checked_sub(first) {
            Some(k) => scales[k] * motion[k],
            None => 0.0,
        });
        let port = moving_port(&housing, &moved, length);
        return Some(port.map_or(FreeMotion::InsideStructure, |(part, displacement)| {
            FreeMotion::Beside(Owner::Part(part), displacement)
        }));
    }
    Some(beside.map_or(FreeMotion::Shaft, |(owner, displacement)| FreeMotion::Beside(owner, displacement)))
}

/// The port that moves most, by its number among the parts, and its displacement; `None` where none moves. Tilts count times a length [m].
fn moving_port(housing: &HousingCoordinates, moved: &DVector<f64>, length: f64) -> Option<(usize, usize)> {
    let of_port = |(part, rows): (usize, DMatrix<f64>)| {
        let (displacements, most) = (&rows * moved, rows.amax() * moved.amax());
        (0..PORT).map(move |row| {
            let of_row = if row < 3 { displacements[row].abs() } else { displacements[row].abs() * length };
            (part, row, if of_row > LEAST_MOTION * most { of_row } else { 0.0 })
        })
    };
    let ports = housing.parts().enumerate().skip(housing.bodies()).flat_map(of_port);
    let (part, row, most) = ports.max_by(|one, other| one.2.total_cmp(&other.2))?;
    (most > 0.0).then_some((part, row))
}
