//! Outer rings that turn with their elastic seats, as in a hub.

use nalgebra::DMatrix;

use super::housing::HousingCoordinates;
use super::input::{Rotor, Seat};
use super::operating::in_nalgebra;
use crate::physics::frame::support::PORT;

/// Adds what rings have because they turn at Ω: gyroscopic moments, and the damping of their seats, which turns along.
///
/// I_t β̈_y + I_p Ω β̇_z = M_y and I_t β̈_z − I_p Ω β̇_y = M_z. The damping acts on the velocity against the turning seat, −c (u̇ − Ω J u),
/// with J(y, z) = (−z, y) and J(β_y, β_z) = (−β_z, β_y). Stiffness across the axis is the same in every direction, so that it does not turn.
pub fn add(rotor: &Rotor, housing: &HousingCoordinates, [stiffness, damping]: [&mut DMatrix<f64>; 2]) {
    for (index, bearing) in rotor.bearings.iter().enumerate() {
        let Seat::Elastic { polar, damping: of_seat, .. } = bearing.seat else { continue };
        let speed = bearing.mounted.bearing.outer_speed();
        if speed == 0.0 {
            continue;
        }
        let rows = housing.outer_ring(index, bearing.outer_ring());
        let mut gyroscopic = DMatrix::zeros(PORT, PORT);
        (gyroscopic[(3, 4)], gyroscopic[(4, 3)]) = (polar * speed, -polar * speed);
        let mut turned = DMatrix::zeros(PORT, PORT);
        for [one, other] in [[1, 2], [3, 4]] {
            (turned[(one, other)], turned[(other, one)]) = (speed, -speed);
        }
        *damping += rows.transpose() * gyroscopic * &rows;
        *stiffness += rows.transpose() * in_nalgebra(&of_seat) * turned * &rows;
    }
}
