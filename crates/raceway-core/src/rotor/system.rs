//! Matrices of a rotor on its supports and bearings, as functions of speed.

use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinates;
use super::input::{MOST_SLOPE, NoEquilibrium, Rotor, RotorBearing, RotorError};
use super::operating::{OperatingPoint, in_nalgebra, operating_point};
use super::potential::Frame;
use super::springs::{between_rings, springs};
use super::turning_seats;
use crate::numerics::quadratic_eigen::{FreeMotion, Oscillation};
use crate::physics::frame::mesh::Mesh;

/// q̈ + C(Ω) q̇ + K(Ω) q = f over the coordinates of shaft and housing.
#[derive(Debug, Clone)]
pub struct System {
    pub coordinates: Coordinates,
    /// Supports, mounts and seats, each in the order of the input.
    pub springs: Vec<Port>,
    pub bearings: Vec<Port>,
    /// Stiffness and damping without bearings and without the factors of the speed.
    pub linear: [DMatrix<f64>; 2],
    /// Forces of springs that push.
    push: DVector<f64>,
    /// Equilibrium at each of `speeds`; none without bearings.
    pub operating: Vec<OperatingPoint>,
    /// Speeds of the matrices, rising [rad/s]; one where nothing depends on speed.
    speeds: Vec<f64>,
    stiffness: Vec<DMatrix<f64>>,
    damping: Vec<DMatrix<f64>>,
    /// Factors of the speed: of the velocities (gyroscopic moments), and of the displacements (damping that turns along).
    gyroscopic: DMatrix<f64>,
    rotating: DMatrix<f64>,
}

/// A spring or a bearing, and the displacements of its one place from the other.
#[derive(Debug, Clone)]
pub struct Port {
    pub rows: DMatrix<f64>,
    /// At each speed of the system.
    stiffness: Vec<DMatrix<f64>>,
    damping: Vec<DMatrix<f64>>,
}

impl System {
    /// At most `count` flexible modes in each plane. Bearings are in equilibrium at each of `speeds`; between them their matrices are
    /// interpolated.
    pub fn of(rotor: &Rotor, mesh: Mesh, count: usize, speeds: &[f64]) -> Result<Self, RotorError> {
        let coordinates = Coordinates::of(rotor, mesh, count)?;
        let squares = DVector::from_iterator(coordinates.len(), coordinates.squares());
        // The structure has its own damping.
        let own_damping = DVector::from_fn(squares.len(), |k, _| match k < coordinates.of_shaft() {
            true => 2.0 * rotor.shaft.damping_ratio * squares[k].sqrt(),
            false => 0.0,
        });
        let (size, count) = (coordinates.len(), coordinates.laterals());
        let (y, z) = (coordinates.axials(), coordinates.axials() + count);
        let antisymmetric = |of_plane: &DMatrix<f64>| {
            let mut whole = DMatrix::zeros(size, size);
            whole.view_mut((y, z), (count, count)).copy_from(of_plane);
            whole.view_mut((z, y), (count, count)).copy_from(&-of_plane);
            whole
        };
        let gyroscopic = antisymmetric(&coordinates.polar);
        let turning = own_damping.rows(y, count) * rotor.shaft.rotating_share;
        let rotating = antisymmetric(&DMatrix::from_diagonal(&turning));
        let speeds = if rotor.bearings.is_empty() { vec![0.0] } else { speeds.to_vec() };
        let shaft = |at: f64| coordinates.port(coordinates.mesh.node(at));
        let mut stiffness = DMatrix::from_diagonal(&squares);
        let mut damping = DMatrix::from_diagonal(&own_damping);
        coordinates.housing.add_damping(&mut damping);
        let mut push = DVector::zeros(size);
        let (mut linear, mut pushing) = (Vec::new(), Vec::new());
        for spring in springs(rotor, shaft, &coordinates.housing) {
            let along = spring.rows.row(0).transpose();
            if spring.push != 0.0 {
                push += &along * spring.push;
                pushing.push((along, spring.stiffness[0][0]));
            }
            let port = Port {
                rows: spring.rows,
                stiffness: vec![in_nalgebra(&spring.stiffness)],
                damping: vec![in_nalgebra(&spring.damping)],
            };
            stiffness += port.over_coordinates(&port.stiffness[0]);
            damping += port.over_coordinates(&port.damping[0]);
            linear.push(port);
        }
        turning_seats::add(rotor, &coordinates.housing, [&mut stiffness, &mut damping]);
        let bearings = (0..rotor.bearings.len()).map(|index| Port {
            rows: between_rings(rotor, index, shaft, &coordinates.housing, 0.0),
            stiffness: Vec::new(),
            damping: Vec::new(),
        });
        let mut system = Self {
            springs: linear,
            bearings: bearings.collect(),
            linear: [stiffness, damping],
            push,
            coordinates,
            operating: Vec::new(),
            speeds,
            stiffness: Vec::new(),
            damping: Vec::new(),
            gyroscopic,
            rotating,
        };
        system.preload(rotor, &pushing)?;
        system.add_bearings(rotor)?;
        if rotor.bearings.iter().any(RotorBearing::has_moving_outer_ring) {
            system.follow_inner_rings(rotor)?;
        }
        Ok(system)
    }

    /// Gives springs their force where the rings are at rest under it and the weight. `pushing`: displacements along the axis of the springs that
    /// push, over the coordinates, and their stiffness [N/m].
    fn preload(&mut self, rotor: &Rotor, pushing: &[(DVector<f64>, f64)]) -> Result<(), RotorError> {
        if pushing.iter().all(|(_, stiffness)| *stiffness == 0.0) {
            return Ok(());
        }
        let mut constant = self.linear[0].clone();
        for (along, stiffness) in pushing {
            constant -= along * along.transpose() * *stiffness;
        }
        let rows: Vec<DMatrix<f64>> = self.bearings.iter().map(|port| port.rows.clone()).collect();
        let load = self.weight(rotor) + &self.push;
        let frame = Frame { stiffness: &constant, load: &load, ports: &rows };
        let rest = operating_point(&frame, rotor, 0.0, None)?.coordinates;
        for (along, stiffness) in pushing {
            self.push += along * (stiffness * along.dot(&rest));
        }
        Ok(())
    }

    /// Carries outer rings to the places of their inner rings at the first equilibrium: a preload moves these along the axis, and the lever of a body
    /// that tilts with them.
    fn follow_inner_rings(&mut self, rotor: &Rotor) -> Result<(), RotorError> {
        let rest = &self.operating[0].coordinates;
        let (coordinates, housing) = (&self.coordinates, &self.coordinates.housing);
        let shaft = |at: f64| coordinates.port(coordinates.mesh.node(at));
        let rows = rotor.bearings.iter().enumerate().map(|(index, bearing)| {
            let slipped = housing.slipped(index, &shaft(bearing.at), rest);
            between_rings(rotor, index, shaft, housing, slipped)
        });
        self.bearings = rows.map(|rows| Port { rows, stiffness: Vec::new(), damping: Vec::new() }).collect();
        (self.stiffness, self.damping, self.operating) = (Vec::new(), Vec::new(), Vec::new());
        self.add_bearings(rotor)
    }

    /// Finds the equilibrium at each speed and adds the matrices of the bearings there.
    fn add_bearings(&mut self, rotor: &Rotor) -> Result<(), RotorError> {
        let [stiffness, damping] = self.linear.clone();
        if rotor.bearings.is_empty() {
            (self.stiffness, self.damping) = (vec![stiffness], vec![damping]);
            return Ok(());
        }
        let load = self.load(rotor);
        let rows: Vec<DMatrix<f64>> = self.bearings.iter().map(|port| port.rows.clone()).collect();
        for speed in self.speeds.clone() {
            let held = &stiffness + &self.rotating * speed;
            let frame = Frame { stiffness: &held, load: &load, ports: &rows };
            let point = operating_point(&frame, rotor, speed, self.operating.last())?;
            let (slope, at) = self.coordinates.largest_slope(&point.coordinates);
            if slope > MOST_SLOPE {
                return Err(RotorError::NoEquilibrium { speed, cause: NoEquilibrium::Leans { at, slope } });
            }
            let (mut whole_stiffness, mut whole_damping) = (stiffness.clone(), damping.clone());
            for ((port, bearing), ring) in self.bearings.iter_mut().zip(&rotor.bearings).zip(&point.rings) {
                let (k, c) = (ring.stiffness.mean, ring.damping(&bearing.damping));
                port.stiffness.push(in_nalgebra(&bearing.mounted.along_shaft(&k)));
                port.damping.push(in_nalgebra(&bearing.mounted.along_shaft(&c)));
                whole_stiffness += port.over_coordinates(&port.stiffness[port.stiffness.len() - 1]);
                whole_damping += port.over_coordinates(&port.damping[port.damping.len() - 1]);
            }
            self.stiffness.push(whole_stiffness);
            self.damping.push(whole_damping);
            self.operating.push(point);
        }
        Ok(())
    }

    /// Weight over the coordinates.
    fn weight(&self, rotor: &Rotor) -> DVector<f64> {
        let mut sum = DVector::from_vec(self.coordinates.weight(rotor.shaft.mass() * rotor.gravity));
        for (coordinate, weight) in self.coordinates.housing.weights() {
            sum[coordinate] += weight * rotor.gravity;
        }
        sum
    }

    /// Weight, loads at the start and pushing springs over the coordinates.
    pub fn load(&self, rotor: &Rotor) -> DVector<f64> {
        let load = self.coordinates.force(rotor.shaft.mass_centre(), rotor.load);
        let mut sum = self.weight(rotor) + DVector::from_vec(load);
        for load in &rotor.loads {
            let port = self.coordinates.port(self.coordinates.mesh.node(load.at));
            sum += port.transpose() * DVector::from_row_slice(&load.start_and_largest_change().0);
        }
        if self.push != DVector::zeros(sum.len()) {
            sum += &self.push;
        }
        sum
    }

    /// Stiffness K and damping C at a speed [rad/s].
    ///
    /// I_t β̈_y + I_p Ω β̇_z = M_y and I_t β̈_z − I_p Ω β̇_y = M_z. Damping c of the shaft that turns along acts on the velocity
    /// against the turning shaft: −c (u̇ − Ω J u), J(y, z) = (−z, y).
    pub fn matrices(&self, speed: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let (stiffness, damping) = (self.at(&self.stiffness, speed), self.at(&self.damping, speed));
        (stiffness + &self.rotating * speed, damping + &self.gyroscopic * speed)
    }

    /// Stiffness and damping of a spring or bearing at a speed [rad/s].
    pub fn of_port(&self, port: &Port, speed: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        (self.at(&port.stiffness, speed), self.at(&port.damping, speed))
    }

    /// The value at a speed, on a line between its neighbours, constant beyond the ends.
    fn at(&self, values: &[DMatrix<f64>], speed: f64) -> DMatrix<f64> {
        let next = self.speeds.partition_point(|known| *known < speed);
        if values.len() == 1 || next == 0 {
            return values[0].clone();
        }
        if next == values.len() {
            return values[next - 1].clone();
        }
        let share = (speed - self.speeds[next - 1]) / (self.speeds[next] - self.speeds[next - 1]);
        &values[next - 1] * (1.0 - share) + &values[next] * share
    }

    /// Stiffness of shaft, supports and bearings without rotating damping, with the speeds from and to which it may be used [rad/s].
    pub fn stiffness_courses(&self) -> Vec<(DMatrix<f64>, [f64; 2])> {
        if self.stiffness.len() == 1 {
            return vec![(self.stiffness[0].clone(), [0.0, f64::INFINITY])];
        }
        let pairs = self.stiffness.windows(2).zip(self.speeds.windows(2));
        pairs.map(|(pair, ends)| ((&pair[0] + &pair[1]) * 0.5, [ends[0], ends[1]])).collect()
    }

    /// Factor of the speed in the matrix of the velocities.
    pub fn gyroscopic(&self) -> &DMatrix<f64> {
        &self.gyroscopic
    }

    /// Factor of the speed in the matrix of the displacements: damping that turns along.
    pub fn rotating(&self) -> &DMatrix<f64> {
        &self.rotating
    }

    /// Answer of `ask` from the eigenvalues at a speed [rad/s].
    pub fn free_motion<T>(&self, speed: f64, ask: impl FnOnce(&FreeMotion<'_>) -> Option<T>) -> Result<T, RotorError> {
        let (stiffness, damping) = self.matrices(speed);
        let answer = FreeMotion::of(&stiffness, &damping).and_then(|motion| ask(&motion));
        answer.ok_or_else(|| unsolved(&stiffness))
    }

    /// The lowest oscillations at a speed [rad/s], by their natural frequency |λ|.
    pub fn oscillations(&self, speed: f64, count: usize) -> Result<Vec<Oscillation>, RotorError> {
        self.free_motion(speed, |motion| motion.oscillations(count))
    }

    /// Largest growth rate of any motion at a speed [1/s]; negative: all decay.
    pub fn growth_rate(&self, speed: f64) -> Result<f64, RotorError> {
        self.free_motion(speed, |motion| Some(motion.growth_rate()))
    }
}

/// Reason why a stiffness has no eigenvalues.
fn unsolved(stiffness: &DMatrix<f64>) -> RotorError {
    let is_restrained = (stiffness + stiffness.transpose()).cholesky().is_some();
    if is_restrained { RotorError::Unsolved } else { RotorError::Unrestrained }
}

impl Port {
    /// A matrix of the port over the coordinates.
    fn over_coordinates(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        self.rows.transpose() * matrix * &self.rows
    }
}
