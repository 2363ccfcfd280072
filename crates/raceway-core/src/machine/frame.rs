//! Shaft and housing as a linear system: their free modes and residual vectors, on supports, mounts and seats.

use nalgebra::{DMatrix, DVector};

use super::input::{Machine, MachineError, Part, Sensor};
use super::padded::{BySpeed, Padded, Rows};
use crate::numerics::angle::sin_cos;
use crate::physics::frame::disc::UnbalancePlane;
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

/// q̈ + C(Ω) q̇ + K(Ω) q = B u over coordinates of mass 1. Port rows R give displacements x, y, z, β_y, β_z.
///
/// The inputs u are the forces and moments at the ports, then what turns with the unbalance, the loads that vary, and 1 for the constant loads.
#[derive(Debug, Clone)]
pub struct Frame {
    /// K and C, without and with the factor of the speed.
    place: BySpeed,
    velocity: BySpeed,
    /// B
    pub inputs: DMatrix<f64>,
    by_input: Padded,
    /// Ports of the inner rings of the bearings, in their order, then of the outer rings that move.
    pub ports: Vec<Rows>,
    /// Outer rings of the bearings; `None`: it does not move.
    pub outer: Vec<Option<OuterPort>>,
    /// Ports of the sensors, in their order, each from what it measures from.
    pub sensors: Vec<Rows>,
    /// Ports of the mass centres of the bodies, in their order, then of an imported structure.
    pub bodies: Vec<Rows>,
    /// Accelerations of all of them.
    pub accelerations: Accelerations,
    is_unbalanced: bool,
    /// Changes of the loads since the start, at each place of the shaft that has any.
    varying: Vec<VaryingLoads>,
    /// Linear analysis about the operating point.
    pub system: System,
}

/// Accelerations of the places of a frame, in their order.
#[derive(Debug, Clone)]
pub struct Accelerations {
    pub ports: Vec<AccelerationRows>,
    pub sensors: Vec<AccelerationRows>,
    pub bodies: Vec<AccelerationRows>,
}

/// Accelerations of a place, R (B u − C q̇ − K q).
#[derive(Debug, Clone)]
pub struct AccelerationRows {
    by_place: Rows,
    by_velocity: Rows,
    by_input: Rows,
    /// Parts by place and by velocity with the factor of a speed that varies.
    by_speed: Option<[Rows; 2]>,
}

impl AccelerationRows {
    /// At any speed, or at the constant one of a machine [rad/s].
    fn of(rows: &DMatrix<f64>, system: &System, inputs: &DMatrix<f64>, constant_speed: Option<f64>) -> Self {
        let [stiffness, damping] = matrices(system, constant_speed.unwrap_or(0.0));
        let by_speed = || [system.rotating(), system.gyroscopic()].map(|matrix| Rows::of(&-(rows * matrix)));
        Self {
            by_place: Rows::of(&-(rows * stiffness)),
            by_velocity: Rows::of(&-(rows * damping)),
            by_input: Rows::of(&(rows * inputs)),
            by_speed: if constant_speed.is_none() { Some(by_speed()) } else { None },
        }
    }

    /// Accelerations at a speed [rad/s].
    #[inline(always)]
    pub fn at(&self, speed: f64, (place, velocity): (&[f64], &[f64]), inputs: &[f64]) -> [f64; PORT] {
        let mut sums = self.by_input.of_place(inputs);
        let mut add = |factor: f64, rows: &Rows, motion: &[f64]| {
            let sum = rows.of_place(motion);
            (0..PORT).for_each(|k| sums[k] += factor * sum[k]);
        };
        add(1.0, &self.by_place, place);
        add(1.0, &self.by_velocity, velocity);
        if let Some([by_place, by_velocity]) = &self.by_speed {
            add(speed, by_place, place);
            add(speed, by_velocity, velocity);
        }
        sums
    }
}

/// K and C of shaft and housing at a speed [rad/s], without the bearings.
fn matrices(system: &System, speed: f64) -> [DMatrix<f64>; 2] {
    let [stiffness, damping] = &system.linear;
    [stiffness + system.rotating() * speed, damping + system.gyroscopic() * speed]
}

/// An outer ring that moves.
#[derive(Debug, Clone, Copy)]
pub struct OuterPort {
    /// Number of its port.
    pub port: usize,
    /// Its displacements at rest.
    pub rest: [f64; PORT],
}

impl Frame {
    /// Free modes up to `range` times the band of levels.
    ///
    /// `stop` is polled for each mesh; true ends the analysis.
    pub fn of(machine: &Machine, range: f64, stop: &dyn Fn() -> bool) -> Result<Self, MachineError> {
        let rotor = &machine.rotor;
        let (mesh, count) = mesh(rotor, &machine.sensors, range, stop)?;
        let system = System::of(rotor, mesh, count, &[rotor.speed])?;
        let coordinates = &system.coordinates;
        let of_shaft = |at: f64| coordinates.port(coordinates.mesh.node(at));
        let (outer_ports, outer) = outer_rings(rotor, &system);
        let inner_ports = rotor.bearings.iter().map(|bearing| bearing.seen(of_shaft(bearing.at)));
        let ports: Vec<_> = inner_ports.chain(outer_ports).collect();
        let (varying, loaded): (Vec<_>, Vec<_>) = varying_loads(rotor, machine.speed.largest()).into_iter().unzip();
        let mut inputs: Vec<DMatrix<f64>> = ports.iter().map(DMatrix::transpose).collect();
        inputs.extend(by_unbalance(rotor, &system));
        inputs.extend(loaded.into_iter().map(|at| of_shaft(at).transpose()));
        let load = system.load(rotor);
        inputs.push(DMatrix::from_column_slice(load.len(), 1, load.as_slice()));
        let columns: Vec<_> = inputs.iter().flat_map(DMatrix::column_iter).collect();
        let inputs = DMatrix::from_columns(&columns);
        let sensors: Vec<_> = machine.sensors.iter().map(|sensor| sensor_rows(sensor, &system)).collect();
        let bodies: Vec<_> = coordinates.housing.parts().collect();
        let constant_speed = machine.speed.is_constant().then(|| machine.speed.at(0.0).1);
        let accelerations = |of: &[DMatrix<f64>]| {
            of.iter().map(|rows| AccelerationRows::of(rows, &system, &inputs, constant_speed)).collect()
        };
        let by_speed = |constant: &DMatrix<f64>, by_speed: &DMatrix<f64>| BySpeed {
            constant: Padded::of(constant),
            by_speed: Padded::of(by_speed),
        };
        Ok(Self {
            place: by_speed(&system.linear[0], system.rotating()),
            velocity: by_speed(&system.linear[1], system.gyroscopic()),
            by_input: Padded::of(&inputs),
            ports: ports.iter().map(Rows::of).collect(),
            outer,
            sensors: sensors.iter().map(Rows::of).collect(),
            bodies: bodies.iter().map(Rows::of).collect(),
            accelerations: Accelerations {
                ports: accelerations(&ports),
                sensors: accelerations(&sensors),
                bodies: accelerations(&bodies),
            },
            inputs,
            is_unbalanced: !rotor.unbalances.is_empty(),
            varying,
            system,
        })
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.inputs.nrows()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// K and C at a speed [rad/s], without the bearings.
    pub fn matrices(&self, speed: f64) -> [DMatrix<f64>; 2] {
        matrices(&self.system, speed)
    }

    /// True if the matrices depend on the speed.
    pub fn depends_on_speed(&self) -> bool {
        [self.system.rotating(), self.system.gyroscopic()].iter().any(|matrix| matrix.iter().any(|entry| *entry != 0.0))
    }

    /// Writes the inputs but those of the ports, at a time and an angle, speed and acceleration of the shaft.
    #[inline(always)]
    pub fn write_loads(&self, time: f64, (angle, speed, acceleration): (f64, f64, f64), inputs: &mut [f64]) {
        let mut rest = &mut inputs[PORT * self.ports.len()..];
        if self.is_unbalanced {
            let [_, y, z] = unbalance_force(1.0, angle, speed, acceleration);
            (rest[0], rest[1]) = (y, z);
            rest = &mut rest[2..];
        }
        let (of_places, constant) = rest.split_at_mut(PORT * self.varying.len());
        for (place, varying) in of_places.as_chunks_mut::<PORT>().0.iter_mut().zip(&self.varying) {
            *place = varying.at(time, angle);
        }
        constant[0] = 1.0;
    }

    /// Writes q̈ at a speed [rad/s] under inputs.
    #[inline(always)]
    pub fn write_accelerations(
        &self,
        speed: f64,
        (place, velocity): (&[f64], &[f64]),
        inputs: &[f64],
        accelerations: &mut [f64],
    ) {
        accelerations.fill(0.0);
        self.by_input.add_product(1.0, inputs, accelerations);
        self.velocity.add_product(-1.0, speed, velocity, accelerations);
        self.place.add_product(-1.0, speed, place, accelerations);
    }

    /// Times at which the slope of a load jumps [s], in no order.
    pub fn kinks(&self) -> impl Iterator<Item = f64> + '_ {
        self.varying.iter().flat_map(VaryingLoads::kinks)
    }

    /// Longest step that resolves the loads from a time on [s].
    pub fn longest_step_from(&self, time: f64) -> f64 {
        self.varying.iter().map(|loads| loads.longest_step_from(time)).fold(f64::INFINITY, f64::min)
    }
}

/// Ports of the outer rings that move, at their places along what carries them, and for each bearing whether it has one.
fn outer_rings(rotor: &Rotor, system: &System) -> (Vec<DMatrix<f64>>, Vec<Option<OuterPort>>) {
    let housing = &system.coordinates.housing;
    let mut ports = Vec::new();
    let mut of = |(index, bearing): (usize, &RotorBearing)| {
        let rest = &system.operating.first()?.coordinates;
        let at = bearing.outer_ring();
        let slipped = housing.slipped(index, &housing.outer_ring(index, at), rest);
        let rows = bearing.seen(housing.outer_ring(index, at + slipped));
        let displacements = &rows * rest;
        ports.push(rows);
        let port = rotor.bearings.len() + ports.len() - 1;
        Some(OuterPort { port, rest: std::array::from_fn(|row| displacements[row]) })
    };
    let outer = rotor.bearings.iter().enumerate();
    let outer = outer.map(|(index, bearing)| if bearing.has_moving_outer_ring() { of((index, bearing)) } else { None });
    let outer = outer.collect();
    (ports, outer)
}

/// Forces on the coordinates of all unbalances together: by the force of one of 1 kg m at the angle of the shaft along Y, and along Z.
fn by_unbalance(rotor: &Rotor, system: &System) -> Option<DMatrix<f64>> {
    let of = |plane: &UnbalancePlane| {
        let along = |force| DVector::from_vec(system.coordinates.force(plane.at, force));
        let (sine, cosine) = sin_cos(plane.phase);
        DMatrix::from_columns(&[along([0.0, cosine, sine]), along([0.0, -sine, cosine])]) * plane.product
    };
    rotor.unbalances.iter().map(of).reduce(|sum, of_plane| sum + of_plane)
}

/// The loads that vary, and their places.
fn varying_loads(rotor: &Rotor, largest_speed: f64) -> Vec<(VaryingLoads, f64)> {
    let of_place = |at: f64| {
        let here = rotor.loads.iter().filter(|load| load.at == at).map(|load| load.load.clone());
        Some((VaryingLoads::of(&here.collect::<Vec<Load>>(), largest_speed)?, at))
    };
    rising(rotor.loads.iter().map(|load| load.at).collect()).into_iter().filter_map(of_place).collect()
}

/// A mesh on which the free modes up to `range` times the band of levels have converged, and their number in each plane.
pub(super) fn mesh(
    rotor: &Rotor,
    sensors: &[Sensor],
    range: f64,
    stop: &dyn Fn() -> bool,
) -> Result<(Mesh, usize), MachineError> {
    let highest = range * std::f64::consts::TAU * BAND;
    let mut longest = rotor.shaft.length() / FIRST_ELEMENTS;
    let mut coarse: Option<Vec<f64>> = None;
    loop {
        let mesh = Mesh::new(&rotor.shaft, &stations(rotor, sensors), longest);
        let (frequencies, count) = free_modes(rotor, &mesh, highest, stop)?;
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
fn stations(rotor: &Rotor, sensors: &[Sensor]) -> Vec<f64> {
    let measured = sensors.iter().filter(|sensor| sensor.concerns_shaft()).map(|sensor| sensor.at);
    rising(rotor.places().into_iter().chain(measured).collect())
}
