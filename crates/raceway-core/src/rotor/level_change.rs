//! Change of levels by leaving out a term, by the linear analysis.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

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
/// Power of an acceleration over that of the strongest, under the same force, below which it does not count [-]: 60 dB.
const FAINT: f64 = 1e-6;

/// Powers of the accelerations of a rotor under forces of equal size at any frequency, in thirds of an octave.
#[derive(Debug, Clone)]
pub struct BandPowers {
    /// Of each force, a row for each acceleration and a column for each band.
    of_forces: Vec<DMatrix<f64>>,
}

impl BandPowers {
    /// Accelerations of the inner rings, the parts of the housing and sensors, on linear bearings at a speed [rad/s]. Forces act between the rings
    /// of each bearing, and on every other place where something acts: along X where it moves there, and turning forward and backward, because
    /// gyroscopic moments change the one as much as the other with opposite signs. `None` without an equilibrium.
    pub fn of(rotor: &Rotor, sensors: &[Sensor], mesh: Mesh, count: usize, speed: f64) -> Option<Self> {
        let system = System::of(rotor, mesh, count, &[speed]).ok()?;
        let coordinates = &system.coordinates;
        let of_shaft = |at: f64| coordinates.port(coordinates.mesh.node(at));
        let loaded = rotor.unbalances.iter().map(|plane| plane.at).chain(rotor.loads.iter().map(|load| load.at));
        let forces: Vec<_> = system.bearings.iter().map(|port| port.rows.clone()).chain(loaded.map(of_shaft)).collect();
        let along = |rows: DMatrix<f64>| rows.rows(0, 3).into_owned();
        let rings = rotor.bearings.iter().map(|bearing| along(of_shaft(bearing.at)));
        let parts = coordinates.housing.parts().map(along);
        let read = sensors.iter().map(|sensor| DMatrix::from_rows(&[coordinates.reading(sensor).transpose()]));
        let outputs = stacked(rings.chain(parts).chain(read))?;
        let inputs = stacked(forces.into_iter().map(along))?.transpose();
        let (stiffness, damping) = system.matrices(speed);
        let transfer = TransferFunction::of([&stiffness, &damping], &inputs, &outputs);
        let mut of_forces = vec![DMatrix::zeros(outputs.nrows(), BANDS as usize); inputs.ncols()];
        for band in 0..BANDS {
            for frequency in frequencies(band) {
                let values = transfer.at(frequency);
                for (place, of_place) in of_forces.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                    let [x, y, z] = [0, 1, 2].map(|axis| values.column(3 * place + axis));
                    let turned = z * Complex::i();
                    add(&mut of_place[0], band, frequency, &x.into_owned());
                    add(&mut of_place[1], band, frequency, &(y - &turned));
                    add(&mut of_place[2], band, frequency, &(y + &turned));
                }
            }
        }
        Some(Self { of_forces })
    }

    /// The largest change of a level in any band [dB]. The rotor without the term may have no housing: accelerations of its parts, which stand
    /// behind those of the rings, then do not count.
    pub fn change(&self, lean: &Self) -> f64 {
        let pairs = self.of_forces.iter().zip(&lean.of_forces);
        pairs.map(|(full, lean)| change(full, lean)).fold(0.0, f64::max)
    }
}

/// The largest change of an acceleration that is not faint, in any band [dB].
fn change(full: &DMatrix<f64>, lean: &DMatrix<f64>) -> f64 {
    let strongest = full.row_iter().map(|row| row.sum()).fold(0.0, f64::max);
    let heard = full.row_iter().zip(lean.row_iter()).filter(|(row, _)| row.sum() > FAINT * strongest);
    let in_bands = heard.flat_map(|(full, lean)| full.iter().copied().zip(lean.iter().copied()).collect::<Vec<_>>());
    in_bands.map(|(full, lean)| 10.0 * (lean / full).log10().abs()).fold(0.0, f64::max)
}

fn stacked(parts: impl Iterator<Item = DMatrix<f64>>) -> Option<DMatrix<f64>> {
    let parts: Vec<_> = parts.collect();
    let rows: Vec<_> = parts.iter().flat_map(DMatrix::row_iter).collect();
    (!rows.is_empty()).then(|| DMatrix::from_rows(&rows))
}

/// Angular frequencies in a band [rad/s].
fn frequencies(band: u32) -> impl Iterator<Item = f64> {
    let share = |place: u32| (f64::from(place) + 0.5) / f64::from(IN_BAND);
    (0..IN_BAND).map(move |place| TAU * LOWEST * 10_f64.powf((f64::from(band) + share(place)) / BANDS_PER_DECADE))
}

/// Adds the powers of accelerations by displacements at a frequency, which stands for a part of the band that is as wide as the frequency is high.
fn add(powers: &mut DMatrix<f64>, band: u32, frequency: f64, displacements: &DVector<Complex<f64>>) {
    for (sum, value) in powers.column_mut(band as usize).iter_mut().zip(displacements) {
        *sum += frequency.powi(5) * value.norm_sqr();
    }
}
