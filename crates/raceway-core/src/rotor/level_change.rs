//! Change of levels by leaving out a term, as the linear analysis bounds it.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::input::Rotor;
use super::sensor::Sensor;
use super::system::System;
use crate::numerics::transfer::TransferFunction;
use crate::physics::frame::mesh::Mesh;

/// Bands from 20 Hz to a thousand times as much, ten a decade: thirds of an octave. In each, this many frequencies: a resonance of damping ratio
/// 0.5 % is wider than the distance of two.
const LOWEST: f64 = 20.0;
const BANDS: u32 = 30;
const BANDS_PER_DECADE: f64 = 10.0;
const IN_BAND: u32 = 32;

/// Levels of the accelerations of a rotor under equal forces of any frequency, in thirds of an octave.
#[derive(Debug, Clone)]
pub struct BandLevels {
    /// Of each band, the power of each acceleration.
    powers: Vec<Vec<f64>>,
}

impl BandLevels {
    /// Accelerations of the inner rings and of sensors, under forces between the rings of every bearing and on every other place where something
    /// acts; linear bearings at a speed [rad/s]. `None` without an equilibrium.
    pub fn of(rotor: &Rotor, sensors: &[Sensor], mesh: Mesh, count: usize, speed: f64) -> Option<Self> {
        let system = System::of(rotor, mesh, count, &[speed]).ok()?;
        let coordinates = &system.coordinates;
        let first = if rotor.shaft.is_axially_free { 0 } else { 1 };
        let radial = |rows: DMatrix<f64>| rows.rows(first, 3 - first).into_owned();
        let of_shaft = |at: f64| radial(coordinates.port(coordinates.mesh.node(at)));
        let loads = rotor.loads.iter().map(|load| load.at);
        let loaded = rotor.unbalances.iter().map(|plane| plane.at).chain(loads);
        let inputs = system.bearings.iter().map(|port| radial(port.rows.clone())).chain(loaded.map(of_shaft));
        let rings = rotor.bearings.iter().map(|bearing| of_shaft(bearing.at));
        let read = sensors.iter().map(|sensor| coordinates.reading(sensor).transpose());
        let outputs = rings.chain(read.map(|row| DMatrix::from_rows(&[row])));
        let (inputs, outputs) = (stacked(inputs)?.transpose(), stacked(outputs)?);
        let (stiffness, damping) = system.matrices(speed);
        let transfer = TransferFunction::of([&stiffness, &damping], &inputs, &outputs);
        Some(Self { powers: (0..BANDS).map(|band| powers(&transfer, band)).collect() })
    }

    /// The largest change of a level in any band [dB].
    pub fn change(&self, other: &Self) -> f64 {
        let pairs = self.powers.iter().flatten().zip(other.powers.iter().flatten());
        pairs.map(|(one, other)| 10.0 * (one / other).log10().abs()).fold(0.0, f64::max)
    }
}

fn stacked(parts: impl Iterator<Item = DMatrix<f64>>) -> Option<DMatrix<f64>> {
    let parts: Vec<_> = parts.collect();
    let rows: Vec<_> = parts.iter().flat_map(DMatrix::row_iter).collect();
    (!rows.is_empty()).then(|| DMatrix::from_rows(&rows))
}

/// Power of each acceleration in a band, but for a factor that all have.
fn powers(transfer: &TransferFunction, band: u32) -> Vec<f64> {
    let frequency = |place: u32| {
        let share = (f64::from(place) + 0.5) / f64::from(IN_BAND);
        TAU * LOWEST * 10_f64.powf((f64::from(band) + share) / BANDS_PER_DECADE)
    };
    let mut sums = Vec::new();
    for frequency in (0..IN_BAND).map(frequency) {
        let values = transfer.at(frequency);
        sums.resize(values.nrows(), 0.0);
        for (sum, row) in sums.iter_mut().zip(values.row_iter()) {
            // The frequencies stand for bands that widen with them.
            *sum += frequency.powi(5) * row.iter().map(|value| value.norm_sqr()).sum::<f64>();
        }
    }
    sums
}
