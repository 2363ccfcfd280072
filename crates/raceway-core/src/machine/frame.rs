//! Shaft and housing in coordinates whose stiffness is diagonal: free modes and residual vectors, supports, mounts and seats included.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::input::{Machine, MachineError, Part, Sensor};
use super::padded::{Coupling, Rows, Square};
use crate::physics::frame::mesh::Mesh;
use crate::physics::frame::support::PORT;
use crate::physics::loads::{Load, VaryingLoads};
use crate::physics::spindle::unbalance_force;
use crate::rotor::coordinates::Coordinates;
use crate::rotor::input::{Rotor, RotorBearing, rising};
use crate::rotor::system::System;
use crate::simulation::recording::sampling::BAND;

/// Elements of the first mesh over the length of the shaft, and the most of any.
const FIRST_ELEMENTS: f64 = 16.0;
const MOST_ELEMENTS: usize = 800;
/// Most flexible modes in a plane: the eigenvalues of their system take seconds.
const MOST_MODES: usize = 128;
/// Change of a kept frequency by halved elements, below which a mesh is fine enough [-].
const CONVERGED: f64 = 1e-4;

/// q̈ + c q̇ + ω² q = g(t, q, q̇) + Σ Rᵀ f over coordinates of mass 1. Port rows R give displacements x, y, z, β_y, β_z.
#[derive(Debug, Clone)]
pub struct Frame {
    /// ω² [1/s²] and c [1/s] of each coordinate.
    pub squares: Vec<f64>,
    pub damping: Vec<f64>,
    /// What couples coordinates, by their velocities and displacements, constant and times the speed.
    velocity: Coupling,
    place: Coupling,
    /// Ports of the inner rings of the bearings, in their order, then of the outer rings that move.
    pub ports: Vec<Rows>,
    /// Outer rings of the bearings; `None`: it does not move.
    pub outer: Vec<Option<OuterPort>>,
    /// Ports of the sensors, in their order, each from what it measures from.
    pub sensors: Vec<Rows>,
    /// Ports of the mass centres of the bodies, in their order, then of an imported structure.
    pub bodies: Vec<Rows>,
    /// Constant loads, weight included.
    load: Vec<f64>,
    planes: Vec<Plane>,
    loaded: Vec<LoadedPlace>,
    /// Linear analysis about the operating point, and its coordinates over those of the frame.
    pub system: System,
    basis: DMatrix<f64>,
}

/// An outer ring that moves.
#[derive(Debug, Clone, Copy)]
pub struct OuterPort {
    /// Number of its port.
    pub port: usize,
    /// Its displacements at rest.
    pub rest: [f64; PORT],
}

/// A place of the shaft, and the changes of its loads since the start.
#[derive(Debug, Clone)]
struct LoadedPlace {
    rows: Rows,
    varying: VaryingLoads,
}

/// Forces of an unbalance along Y and Z over the coordinates, by 1 N.
#[derive(Debug, Clone)]
struct Plane {
    product: f64,
    phase: f64,
    along: [Vec<f64>; 2],
}

impl Frame {
    /// Free modes up to `range` times the band of levels.
    ///
    /// `stop` is polled for each mesh; true ends the analysis.
    pub fn of(machine: &Machine, range: f64, stop: &dyn Fn() -> bool) -> Result<Self, MachineError> {
        let rotor = &machine.rotor;
        let (mesh, count) = mesh(machine, range * std::f64::consts::TAU * BAND, stop)?;
        let system = System::of(rotor, mesh, count, &[rotor.speed])?;
        let size = system.coordinates.len();
        let [stiffness, damping] = &system.linear;
        let symmetric = 0.5 * (stiffness + stiffness.transpose());
        let (squares, basis) = match system.springs.is_empty() {
            true => (system.coordinates.squares().collect(), DMatrix::identity(size, size)),
            false => {
                let eigen = SymmetricEigen::new(symmetric.clone());
                (eigen.eigenvalues.iter().map(|square| square.max(0.0)).collect(), eigen.eigenvectors)
            }
        };
        let turned = |matrix: &DMatrix<f64>| basis.transpose() * matrix * &basis;
        let damping = turned(damping);
        let own_damping: Vec<f64> = damping.diagonal().iter().copied().collect();
        let rows = |at: f64| Rows::of(&(system.coordinates.port(system.coordinates.mesh.node(at)) * &basis));
        let inner = rotor.bearings.iter().map(|bearing| rows(bearing.at));
        let housing = &system.coordinates.housing;
        let (outer_rows, outer) = outer_rings(rotor, &system, &basis);
        let over =
            |force: Vec<f64>| (basis.transpose() * DVector::from_vec(force)).iter().copied().collect::<Vec<f64>>();
        let planes = rotor.unbalances.iter().map(|plane| Plane {
            product: plane.product,
            phase: plane.phase,
            along: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|force| over(system.coordinates.force(plane.at, force))),
        });
        Ok(Self {
            velocity: Coupling {
                constant: Square::of(&(damping.clone() - DMatrix::from_diagonal(&damping.diagonal()))),
                by_speed: Square::of(&turned(system.gyroscopic())),
            },
            place: Coupling {
                constant: Square::of(&turned(&(stiffness - symmetric))),
                by_speed: Square::of(&turned(system.rotating())),
            },
            ports: inner.chain(outer_rows).collect(),
            outer,
            sensors: machine.sensors.iter().map(|sensor| Rows::of(&(sensor_rows(sensor, &system) * &basis))).collect(),
            bodies: housing.parts().map(|rows| Rows::of(&(rows * &basis))).collect(),
            load: over(system.load(rotor).iter().copied().collect()),
            planes: planes.collect(),
            loaded: loaded(rotor, machine.speed.largest(), rows),
            squares,
            damping: own_damping,
            system,
            basis,
        })
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.squares.len()
    }

    pub fn is_empty(&self) -> bool {
        self.squares.is_empty()
    }

    /// Coordinates of the linear analysis over those of the frame.
    pub fn from_analysis(&self, coordinates: &DVector<f64>) -> Vec<f64> {
        (self.basis.transpose() * coordinates).iter().copied().collect()
    }

    /// Writes g: loads, unbalance and what couples coordinates, at a time and an angle, speed and acceleration of the shaft.
    #[inline(always)]
    pub fn forces(
        &self,
        time: f64,
        (angle, speed, acceleration): (f64, f64, f64),
        place: &[f64],
        velocity: &[f64],
        forces: &mut [f64],
    ) {
        forces.copy_from_slice(&self.load);
        for LoadedPlace { rows, varying } in &self.loaded {
            rows.add_forces(&varying.at(time, angle), forces);
        }
        for Plane { product, phase, along: [along_y, along_z] } in &self.planes {
            let [_, y, z] = unbalance_force(*product, angle + phase, speed, acceleration);
            for ((force, by_y), by_z) in forces.iter_mut().zip(along_y).zip(along_z) {
                *force += y * by_y + z * by_z;
            }
        }
        self.velocity.subtract(speed, velocity, forces);
        self.place.subtract(speed, place, forces);
    }

    /// Times at which the slope of a load jumps [s], in no order.
    pub fn kinks(&self) -> impl Iterator<Item = f64> + '_ {
        self.loaded.iter().flat_map(|place| place.varying.kinks())
    }

    /// Longest step that resolves the loads from a time on [s].
    pub fn longest_step_from(&self, time: f64) -> f64 {
        self.loaded.iter().map(|place| place.varying.longest_step_from(time)).fold(f64::INFINITY, f64::min)
    }

    /// Largest rates [1/s] by which velocities of other coordinates change one: by dashpots of supports, and by gyroscopic moments at a speed.
    pub(super) fn coupling_rates(&self, speed: f64) -> [f64; 2] {
        [self.velocity.constant.largest_row(), speed.abs() * self.velocity.by_speed.largest_row()]
    }

    /// Energy of the coordinates [J], loads at the start included; moments of a turning shaft do no work.
    pub fn energy(&self, place: &[f64], velocity: &[f64]) -> f64 {
        let of = |k: usize| {
            0.5 * (velocity[k] * velocity[k] + self.squares[k] * place[k] * place[k]) - self.load[k] * place[k]
        };
        (0..self.len()).map(of).sum()
    }
}

/// Ports of the outer rings that move, at their places along what carries them, and for each bearing whether it has one.
fn outer_rings(rotor: &Rotor, system: &System, basis: &DMatrix<f64>) -> (Vec<Rows>, Vec<Option<OuterPort>>) {
    let housing = &system.coordinates.housing;
    let mut ports = Vec::new();
    let mut of = |(index, bearing): (usize, &RotorBearing)| {
        let rest = &system.operating.first()?.coordinates;
        let at = bearing.outer_ring();
        let slipped = housing.slipped(index, &housing.outer_ring(index, at), rest);
        let rows = housing.outer_ring(index, at + slipped);
        let displacements = &rows * rest;
        ports.push(Rows::of(&(rows * basis)));
        let port = rotor.bearings.len() + ports.len() - 1;
        Some(OuterPort { port, rest: std::array::from_fn(|row| displacements[row]) })
    };
    let outer = rotor.bearings.iter().enumerate();
    let outer = outer.map(|(index, bearing)| if bearing.has_moving_outer_ring() { of((index, bearing)) } else { None });
    let outer = outer.collect();
    (ports, outer)
}

/// The loads that vary, by their place.
fn loaded(rotor: &Rotor, largest_speed: f64, rows: impl Fn(f64) -> Rows) -> Vec<LoadedPlace> {
    let of_place = |at: f64| {
        let here = rotor.loads.iter().filter(|load| load.at == at).map(|load| load.load.clone());
        let varying = VaryingLoads::of(&here.collect::<Vec<Load>>(), largest_speed)?;
        Some(LoadedPlace { rows: rows(at), varying })
    };
    rising(rotor.loads.iter().map(|load| load.at).collect()).into_iter().filter_map(of_place).collect()
}

/// A mesh on which the free modes up to an angular frequency [rad/s] have converged, and their number in each plane.
fn mesh(machine: &Machine, highest: f64, stop: &dyn Fn() -> bool) -> Result<(Mesh, usize), MachineError> {
    let mut longest = machine.rotor.shaft.length() / FIRST_ELEMENTS;
    let mut coarse: Option<Vec<f64>> = None;
    loop {
        let mesh = Mesh::new(&machine.rotor.shaft, &stations(machine), longest);
        let (frequencies, count) = free_modes(&machine.rotor, &mesh, highest, stop)?;
        let is_close = |coarse: &Vec<f64>| {
            let kept = frequencies.iter().zip(coarse).take_while(|(fine, _)| **fine <= highest);
            kept.clone().count() > 0 && kept.clone().all(|(fine, coarse)| (fine - coarse).abs() <= CONVERGED * fine)
        };
        if coarse.as_ref().is_some_and(is_close) || 2 * mesh.elements.len() > MOST_ELEMENTS {
            return Ok((mesh, count));
        }
        coarse = Some(frequencies);
        longest /= 2.0;
    }
}

/// Angular frequencies of the modes of a plane, rigid ones included, up to the first beyond `highest`, and the number of flexible ones.
fn free_modes(
    rotor: &Rotor,
    mesh: &Mesh,
    highest: f64,
    stop: &dyn Fn() -> bool,
) -> Result<(Vec<f64>, usize), MachineError> {
    let mut count = 4;
    loop {
        if stop() {
            return Err(MachineError::Stopped(0.0));
        }
        if count > MOST_MODES {
            return Err(MachineError::TooManyModes(MOST_MODES));
        }
        let coordinates = Coordinates::of(rotor, mesh.clone(), count)?;
        if coordinates.highest() >= highest {
            let frequencies = coordinates.frequencies();
            let kept = frequencies.iter().filter(|frequency| **frequency > 0.0 && **frequency <= highest).count();
            return Ok((frequencies, kept));
        }
        count *= 2;
    }
}

/// Displacements that a sensor sees, of its part from what it measures from.
fn sensor_rows(sensor: &Sensor, system: &System) -> DMatrix<f64> {
    let coordinates = &system.coordinates;
    let of = |part: Part| match part {
        Part::Shaft => coordinates.port(coordinates.mesh.node(sensor.at)),
        Part::Housing(part) => coordinates.housing.part(Some(part), sensor.at),
    };
    match sensor.relative_to {
        None => of(sensor.on),
        Some(other) => of(sensor.on) - of(other),
    }
}

/// Places of the shaft at which something acts or is measured, rising [m].
fn stations(machine: &Machine) -> Vec<f64> {
    let measured = machine.sensors.iter().filter(|sensor| sensor.concerns_shaft()).map(|sensor| sensor.at);
    rising(machine.rotor.places().into_iter().chain(measured).collect())
}
