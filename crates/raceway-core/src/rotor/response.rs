//! Stationary responses to unbalance and to harmonic loads: amplitudes of the coordinates, of which the real part times e^(iωt) is the
//! motion.

use std::f64::consts::TAU;

use nalgebra::{Complex, DVector};

use super::input::PlacedLoad;
use super::system::System;
use crate::numerics::quadratic_eigen::dynamic_stiffness;
use crate::physics::frame::disc::UnbalancePlane;
use crate::physics::loads::{Load, LoadRate};

/// Response at the frequency of the speed [rad/s].
///
/// A plane pulls with U Ω² (cos(Ωt + φ), sin(Ωt + φ)) along Y and Z.
pub fn of_unbalance(system: &System, planes: &[UnbalancePlane], speed: f64) -> DVector<Complex<f64>> {
    let mut force = DVector::zeros(system.coordinates.len());
    for plane in planes {
        let pull = Complex::from_polar(plane.product * speed * speed, plane.phase);
        let along_y = system.coordinates.force(plane.at, [0.0, 1.0, 0.0]);
        let along_z = system.coordinates.force(plane.at, [0.0, 0.0, 1.0]);
        for (index, (y, z)) in along_y.iter().zip(&along_z).enumerate() {
            force[index] += pull * (Complex::from(*y) - Complex::i() * *z);
        }
    }
    response(system, &force, speed, speed)
}

/// Response to a harmonic load at a speed of the shaft, and its angular frequency, negative where it turns backward [rad/s]; `None` for other
/// loads.
pub fn of_load(
    system: &System,
    PlacedLoad { at, load }: &PlacedLoad,
    speed: f64,
) -> Option<(DVector<Complex<f64>>, f64)> {
    let harmonic = load.harmonic()?;
    let frequency = match harmonic.rate {
        LoadRate::Frequency(frequency) => TAU * frequency,
        LoadRate::Order(order) => order * speed,
    };
    let port = system.coordinates.port(system.coordinates.mesh.node(*at)).map(Complex::from);
    let mut wrench = DVector::zeros(port.nrows());
    match load {
        Load::Along(direction, _) => wrench[*direction as usize] = Complex::from(1.0),
        Load::Rotating(_) => (wrench[1], wrench[2]) = (Complex::from(1.0), -Complex::i()),
    }
    let force = port.transpose() * wrench * Complex::from_polar(harmonic.amplitude, harmonic.phase);
    Some((response(system, &force, frequency, speed), frequency))
}

/// Zero where the dynamic stiffness is singular: an undamped rotor exactly at a critical speed has no stationary response.
fn response(system: &System, force: &DVector<Complex<f64>>, frequency: f64, speed: f64) -> DVector<Complex<f64>> {
    let (stiffness, damping) = system.matrices(speed);
    let matrix = dynamic_stiffness(Complex::new(0.0, frequency), &stiffness, &damping);
    matrix.lu().solve(force).unwrap_or_else(|| DVector::zeros(force.len()))
}
