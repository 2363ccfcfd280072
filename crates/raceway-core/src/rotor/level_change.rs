//! Change of the vibration by leaving out a term, by the linear analysis.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{Complex, DMatrix};

use super::input::{Rotor, RotorError};
use super::sensor::Sensor;
use super::system::System;
use crate::numerics::transfer::TransferFunction;
use crate::physics::frame::mesh::Mesh;

/// Bands from 20 Hz to a thousand times as much, ten a decade: thirds of an octave. In each, this many frequencies: a resonance of damping ratio
/// 0.5 % is wider than the distance of two.
const LOWEST: f64 = 20.0;
const BANDS: i32 = 30;
const BANDS_PER_DECADE: f64 = 10.0;
const IN_BAND: i32 = 32;
/// Power at a place over that at the liveliest one, under the same force, below which it does not count [-]: 60 dB.
const FAINT: f64 = 1e-6;
/// Directions of a force, and of the motion of a place: X, Y, Z.
const DIRECTIONS: usize = 3;

/// Displacements at one frequency: a row for each direction of a place, and three columns for each force.
type Response = DMatrix<Complex<f64>>;

/// Displacements under forces of 1 N, on linear bearings at one speed.
#[derive(Debug, Clone)]
pub struct Responses {
    /// Rows of each place: three of an inner ring and of a part of the housing, one of a sensor. Parts of the housing come last.
    places: Vec<Range<usize>>,
    /// At each frequency.
    displacements: Vec<Response>,
}

impl Responses {
    /// Forces act between the rings of each bearing, and on every other place of the shaft where something acts. `None` without an equilibrium at
    /// the speed [rad/s], and without forces or places. `stop` is polled at each frequency; the error is that it ended the analysis.
    pub fn of(
        rotor: &Rotor,
        sensors: &[Sensor],
        (mesh, count): (Mesh, usize),
        speed: f64,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, RotorError> {
        let Ok(system) = System::of(rotor, mesh, count, &[speed]) else { return Ok(None) };
        let coordinates = &system.coordinates;
        let along = |rows: &DMatrix<f64>| rows.rows(0, DIRECTIONS).into_owned();
        let of_shaft = |at: f64| along(&coordinates.port(coordinates.mesh.node(at)));
        let loaded = rotor.unbalances.iter().map(|plane| plane.at).chain(rotor.loads.iter().map(|load| load.at));
        let inputs: Vec<_> = system.bearings.iter().map(|port| along(&port.rows)).chain(loaded.map(of_shaft)).collect();
        let rings = rotor.bearings.iter().map(|bearing| of_shaft(bearing.at));
        let read = sensors.iter().map(|sensor| DMatrix::from_rows(&[coordinates.reading(sensor).transpose()]));
        let parts = coordinates.housing.parts().map(|rows| along(&rows));
        let outputs: Vec<_> = rings.chain(read).chain(parts).collect();
        let mut end = 0;
        let places = outputs.iter().map(|rows| {
            end += rows.nrows();
            end - rows.nrows()..end
        });
        let places = places.collect();
        let (stiffness, damping) = system.matrices(speed);
        let (Some(inputs), Some(outputs)) = (stacked(&inputs), stacked(&outputs)) else { return Ok(None) };
        let transfer = TransferFunction::of([&stiffness, &damping], &inputs.transpose(), &outputs);
        let at = |frequency| if stop() { Err(RotorError::Stopped) } else { Ok(transfer.at(frequency)) };
        let displacements = (0..BANDS).flat_map(frequencies).map(at).collect::<Result<_, _>>()?;
        Ok(Some(Self { places, displacements }))
    }

    /// The largest change of the vibration of a place, all directions together, under a force of any direction, in any third of an octave [dB].
    /// Places that only one of both has do not count.
    ///
    /// A difference of a share ρ of the motion changes its level by at most 20 lg(1 + ρ).
    pub fn change(&self, lean: &Self) -> f64 {
        let bands = self.displacements.chunks(IN_BAND as usize).zip(lean.displacements.chunks(IN_BAND as usize));
        let of_band = |(full, lean): (&[Response], &[Response])| {
            let forces = (0..full[0].ncols()).step_by(DIRECTIONS);
            forces.map(|first| self.share(full, lean, first)).fold(0.0, f64::max)
        };
        20.0 * (1.0 + bands.map(of_band).fold(0.0, f64::max)).log10()
    }

    /// The largest difference at a place over its motion, in a band under the force with this first column.
    fn share(&self, full: &[Response], lean: &[Response], first: usize) -> f64 {
        let shared = lean[0].nrows();
        let powers = self.places.iter().filter(|place| place.end <= shared).map(|place| {
            let mut sums = [0.0; 2];
            for (weight, (full, lean)) in weights().zip(full.iter().zip(lean)) {
                let of = |all: &Response| all.view((place.start, first), (place.len(), DIRECTIONS)).into_owned();
                let (full, lean) = (of(full), of(lean));
                sums[0] += weight * full.norm_squared();
                sums[1] += weight * (full - lean).norm_squared();
            }
            sums
        });
        let powers: Vec<[f64; 2]> = powers.collect();
        let liveliest = powers.iter().map(|[power, _]| *power).fold(0.0, f64::max);
        let heard = powers.iter().filter(|[power, _]| *power > FAINT * liveliest);
        heard.map(|[power, difference]| (difference / power).sqrt()).fold(0.0, f64::max)
    }
}

fn stacked(parts: &[DMatrix<f64>]) -> Option<DMatrix<f64>> {
    let rows: Vec<_> = parts.iter().flat_map(DMatrix::row_iter).collect();
    (!rows.is_empty()).then(|| DMatrix::from_rows(&rows))
}

/// Places of the frequencies in a band, on its logarithmic scale from 0 to 1.
fn places() -> impl Iterator<Item = f64> {
    (0..IN_BAND).map(|place| (f64::from(place) + 0.5) / f64::from(IN_BAND))
}

/// Angular frequencies in a band [rad/s].
fn frequencies(band: i32) -> impl Iterator<Item = f64> {
    places().map(move |place| TAU * LOWEST * 10_f64.powf((f64::from(band) + place) / BANDS_PER_DECADE))
}

/// Shares of the frequencies of a band in the power of the acceleration, but for a factor: each stands for a part of the band that is as wide as it is
/// high.
fn weights() -> impl Iterator<Item = f64> {
    places().map(|place| 10_f64.powf(5.0 * place / BANDS_PER_DECADE))
}
