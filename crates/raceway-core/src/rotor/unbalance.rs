//! Stationary response to unbalance.

use nalgebra::{Complex, DVector};

use super::system::System;
use crate::numerics::quadratic_eigen::dynamic_stiffness;
use crate::physics::frame::disc::UnbalancePlane;

/// Amplitudes of the coordinates at a speed [rad/s]: the real part times e^(iΩt) is the motion. Zero where the dynamic stiffness is
/// singular: an undamped rotor exactly at a critical speed has no stationary response.
///
/// A plane pulls with U Ω² (cos(Ωt + φ), sin(Ωt + φ)) along Y and Z.
pub fn response(system: &System, planes: &[UnbalancePlane], speed: f64) -> DVector<Complex<f64>> {
    let size = system.coordinates.len();
    let mut force = DVector::zeros(size);
    for plane in planes {
        let pull = Complex::from_polar(plane.product * speed * speed, plane.phase);
        let along_y = system.coordinates.force(plane.at, [0.0, 1.0, 0.0]);
        let along_z = system.coordinates.force(plane.at, [0.0, 0.0, 1.0]);
        for (index, (y, z)) in along_y.iter().zip(&along_z).enumerate() {
            force[index] += pull * (Complex::from(*y) - Complex::i() * *z);
        }
    }
    let (stiffness, damping) = system.matrices(speed);
    let matrix = dynamic_stiffness(Complex::new(0.0, speed), &stiffness, &damping);
    matrix.lu().solve(&force).unwrap_or_else(|| DVector::zeros(size))
}
