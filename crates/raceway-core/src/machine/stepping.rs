//! Fixed steps of a machine, one evaluation of each bearing a step.
//!
//! Balls and cages take their linearly implicit steps at a predicted motion of their rings. The coordinates of the shaft are advanced exactly
//! under forces that follow the parabola through three nodes. The new node is extrapolated first. After the evaluation f̂ there, with
//! the compliances H of the new node and the resistances K, C of the balls, (1 + K H_q + C H_v) Δf = f̂ − f corrects it implicitly.
//! The past is kept as forces at the ports: increments of the coordinates' forces would let rounding grow.
//!
//! A step ends at each kink of a load or of the speed. Short steps build the past of the steps after it.

use nalgebra::DMatrix;

use super::bearing_stepper::BearingStepper;
use super::equations::MachineDynamics;
use super::frame::Frame;
use super::padded::Rows;
use super::port::{PortLoad, Predicted, Resistance};
use super::propagator::{NODES, Propagator};
use crate::numerics::dense::solve;
use crate::numerics::lanes::{InstructionSet, LANES, Task};
use crate::numerics::ode::adams::ahead;
use crate::numerics::ode::adams_moulton::Shares;
use crate::physics::statics::Matrix;

/// Number of entries of a port.
const PORT: usize = 5;
/// Short steps to one of full length at the start.
const START: usize = 16;
/// Nodes that the bearings keep, the newest included.
const BEARING_NODES: usize = 4;

/// Forces on shaft and housing at one time.
#[derive(Debug, Clone, Default)]
struct Forces {
    /// Of each bearing at its ports, one behind the other.
    ports: Vec<f64>,
    /// All others, over the coordinates.
    rest: Vec<f64>,
    /// Their sum over the coordinates.
    sum: Vec<f64>,
}

/// Length of steps: a share of the one that bearings and loads allow, so that half of the share halves every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepLength {
    /// Longest step of the bearings [s].
    pub longest: f64,
    /// [-]
    pub share: f64,
}

impl StepLength {
    /// Half of every step.
    pub(crate) fn halved(self) -> Self {
        Self { share: 0.5 * self.share, ..self }
    }

    /// Step where the loads need no shorter one [s].
    pub(crate) fn full(self) -> f64 {
        self.share * self.longest
    }
}

/// Steps of one length, up to the next kink.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    end: f64,
    /// Steps that are left.
    left: u64,
}

/// A machine between two steps.
pub(crate) struct MachineStepper<'m> {
    dynamics: &'m MachineDynamics,
    bearings: Vec<BearingStepper<'m>>,
    length: StepLength,
    kinks: Vec<f64>,
    stretch: Stretch,
    /// `Some` in the first steps of a stretch: forces at full distance while short steps build the past, oldest first.
    start: Option<Vec<Forces>>,
    /// Full step of the stretch, and the present one.
    full_step: f64,
    step: f64,
    time: f64,
    place: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    /// At the last nodes, newest first.
    past: [Forces; NODES],
    /// Number of valid nodes.
    known: usize,
    formulas: Formulas,
    scratch: Scratch,
    evaluations: u64,
    instructions: InstructionSet,
}

/// Work space of a step.
struct Scratch {
    /// 1 + K H_q + C H_v over the ports, row by row, and the right side and solution of its equations [N, N m].
    matrix: Vec<f64>,
    change: Vec<f64>,
    /// Over the coordinates: additional forces, and those without forces at ports that were extrapolated.
    forces: Vec<f64>,
    foreseen: Vec<f64>,
}

/// Constants of steps of one length through a number of known nodes.
struct Formulas {
    propagator: Propagator,
    ahead: [f64; NODES],
    /// Displacements and velocities of the ports in the step by forces at the new node.
    places: Compliances,
    velocities: Compliances,
    /// Accelerations of the ports by the same forces, and the shares of each port's own radial ones in its place and velocity; of bearings whose load
    /// depends on accelerations.
    accelerations: Option<Compliances>,
    shares: Vec<Shares>,
}

impl Formulas {
    fn new(dynamics: &MachineDynamics, step: f64, known: usize) -> Self {
        let frame = &dynamics.frame;
        let propagator = Propagator::new(&frame.squares, &frame.damping, step, (known + 1).min(NODES));
        let compliances = |weights: &[f64]| Compliances::of(frame, weights);
        let (places, velocities) = (compliances(&propagator.place[0]), compliances(&propagator.velocity[0]));
        let (mut accelerations, mut shares) = (None, Vec::new());
        if dynamics.needs_accelerations() {
            let of_mode = |k: usize| {
                1.0 - frame.damping[k] * propagator.velocity[0][k] - frame.squares[k] * propagator.place[0][k]
            };
            let by_force = compliances(&(0..frame.len()).map(of_mode).collect::<Vec<f64>>());
            // Over Y and Z together.
            let radial = |of: &Compliances, port: usize| of.block(port, port)[1][1] + of.block(port, port)[2][2];
            let share = |port: usize| {
                let own = radial(&by_force, port);
                Shares { place: radial(&places, port) / own, velocity: radial(&velocities, port) / own }
            };
            shares = (0..dynamics.bearings.len()).map(share).collect();
            accelerations = Some(by_force);
        }
        Self { propagator, ahead: ahead(known), places, velocities, accelerations, shares }
    }
}

/// Motion of every port by forces at every port: a block for each pair of them, its rows padded.
struct Compliances {
    ports: usize,
    blocks: Vec<[[f64; LANES]; PORT]>,
}

impl Compliances {
    /// The compliances of all ports. `weights`: motion of each coordinate by a unit force on it.
    fn of(frame: &Frame, weights: &[f64]) -> Self {
        let of_port = |port: &Rows| frame.ports.iter().map(|by| port.compliance(by, weights)).collect::<Vec<_>>();
        Self { ports: frame.ports.len(), blocks: frame.ports.iter().flat_map(of_port).collect() }
    }

    /// Motion of a port by forces at another.
    fn block(&self, port: usize, by: usize) -> &[[f64; LANES]; PORT] {
        &self.blocks[port * self.ports + by]
    }

    /// Adds the product of a matrix of a port with this to the rows of the port in a square matrix.
    #[inline(always)]
    fn add_product(&self, sum: &mut [f64], port: usize, matrix: &Matrix) {
        let size = PORT * self.ports;
        let rows = sum[PORT * port * size..][..PORT * size].chunks_exact_mut(size);
        for (row, entries) in rows.zip(matrix) {
            for (sums, block) in row.as_chunks_mut::<PORT>().0.iter_mut().zip(&self.blocks[port * self.ports..]) {
                let mut products = [0.0; LANES];
                for (entry, by) in entries.iter().zip(block) {
                    for lane in 0..LANES {
                        products[lane] += entry * by[lane];
                    }
                }
                for k in 0..PORT {
                    sums[k] += products[k];
                }
            }
        }
    }
}

/// Largest eigenvalue of K H [-] in steps of a length [s]: what a correction of the ports' forces changes the force of the balls by, over itself.
/// K is the stiffness of the bearings at the operating point, H the compliance of the coordinates at the new node.
pub(super) fn stiffness_of_step(dynamics: &MachineDynamics, step: f64) -> f64 {
    let size = PORT * dynamics.bearings.len();
    let places = between_rings(dynamics, &Formulas::new(dynamics, step, NODES).places);
    let mut product = vec![0.0; size * size];
    let Some(point) = dynamics.frame.system.operating.first() else { return 0.0 };
    for (index, (bearing, ring)) in dynamics.bearings.iter().zip(&point.rings).enumerate() {
        places.add_product(&mut product, index, &bearing.mounted.along_shaft(&ring.stiffness.mean));
    }
    let eigenvalues = DMatrix::from_row_slice(size, size, &product).complex_eigenvalues();
    eigenvalues.iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// Compliances of the ports of the rings as those of the inner rings from the outer ones.
fn between_rings(dynamics: &MachineDynamics, of_ports: &Compliances) -> Compliances {
    let bearings = dynamics.bearings.len();
    let signs = |bearing: usize| {
        let outer = dynamics.frame.outer[bearing].as_ref().map(|outer| (outer.port, -1.0));
        [(bearing, 1.0)].into_iter().chain(outer)
    };
    let block = |pair: usize| {
        let mut between = [[0.0; LANES]; PORT];
        for (port, sign) in signs(pair / bearings) {
            for (by, other_sign) in signs(pair % bearings) {
                let entries = of_ports.block(port, by).as_flattened();
                let sums = between.as_flattened_mut().iter_mut();
                sums.zip(entries).for_each(|(sum, entry)| *sum += sign * other_sign * entry);
            }
        }
        between
    };
    Compliances { ports: bearings, blocks: (0..bearings * bearings).map(block).collect() }
}

impl<'m> MachineStepper<'m> {
    /// Starts at a state.
    pub(crate) fn new(dynamics: &'m MachineDynamics, time: f64, state: &[f64], length: StepLength) -> Self {
        let (size, ports) = (dynamics.frame.len(), PORT * dynamics.frame.ports.len());
        let (place, velocity) = dynamics.coordinates(state);
        let stepper = |(index, part): (usize, &[f64])| {
            BearingStepper::new(&dynamics.bearings[index], time, part, dynamics.rings(index, place, velocity))
        };
        let bearings: Vec<_> = dynamics.parts(state).into_iter().enumerate().map(stepper).collect();
        let first: Vec<_> = bearings
            .iter()
            .enumerate()
            .map(|(index, stepper)| stepper.first_load(&dynamics.rings(index, place, velocity)))
            .collect();
        let mut rates = vec![0.0; state.len()];
        let loads = dynamics.evaluate(time, state, &mut rates, |_| None);
        let of_rings = || dynamics.bearings.iter().zip(&loads.rings);
        let on_shaft = of_rings()
            .zip(first)
            .flat_map(|((bearing, load), first)| first.unwrap_or_else(|| bearing.on_shaft(&load.inner)));
        let moving = of_rings().zip(&dynamics.frame.outer).filter(|(_, outer)| outer.is_some());
        let on_housing = moving.flat_map(|((bearing, load), _)| bearing.on_shaft(&load.outer));
        let mut forces = Forces { ports: on_shaft.chain(on_housing).collect(), rest: vec![0.0; size], sum: Vec::new() };
        dynamics.frame.forces(time, dynamics.speed.at(time), place, velocity, &mut forces.rest);
        forces.add_up(dynamics);
        let mut stepper = Self {
            bearings,
            length,
            kinks: dynamics.kinks(),
            stretch: Stretch { end: time, left: 0 },
            start: None,
            full_step: length.longest,
            step: length.longest,
            time,
            place: place.to_vec(),
            velocity: velocity.to_vec(),
            acceleration: rates[rates.len() - size..].to_vec(),
            past: std::array::from_fn(|_| forces.clone()),
            known: 1,
            formulas: Formulas::new(dynamics, length.longest, 1),
            scratch: Scratch {
                matrix: vec![0.0; ports * ports],
                change: vec![0.0; ports],
                forces: vec![0.0; size],
                foreseen: vec![0.0; size],
            },
            evaluations: 1,
            instructions: InstructionSet::best(),
            dynamics,
        };
        stepper.begin_stretch();
        stepper
    }

    /// Begins again at the newest state, with steps that end at the next kink.
    fn begin_stretch(&mut self) {
        let from = self.time;
        let limit = self.length.longest.min(self.dynamics.frame.longest_step_from(from));
        let longest = self.length.share * limit;
        (self.stretch, self.full_step) = match self.kinks.iter().find(|kink| **kink > from) {
            None => (Stretch { end: f64::INFINITY, left: u64::MAX }, longest),
            Some(&end) => {
                let count = ((end - from) / longest).ceil().max(BEARING_NODES as f64);
                (Stretch { end, left: count as u64 }, (end - from) / count)
            }
        };
        // What follows the kink, not what leads to it.
        let dynamics = self.dynamics;
        let after = from.next_up();
        let now = &mut self.past[0];
        dynamics.frame.forces(after, dynamics.speed.at(after), &self.place, &self.velocity, &mut now.rest);
        now.add_up(dynamics);
        self.known = 1;
        self.step = self.full_step / START as f64;
        self.formulas = Formulas::new(dynamics, self.step, self.known);
        self.bearings.iter_mut().for_each(BearingStepper::begin);
        self.start = Some(Vec::new());
    }

    /// One step, the first of a stretch in short steps of rising order, compiled for the processor's instructions.
    pub(crate) fn advance(&mut self) {
        match self.start.take() {
            None => self.instructions.run(Step(self)),
            Some(past) => self.advance_start(past),
        }
        self.stretch.left -= 1;
        if self.stretch.left == 0 {
            self.time = self.stretch.end;
            self.begin_stretch();
        }
    }

    fn advance_start(&mut self, mut past: Vec<Forces>) {
        self.bearings.iter_mut().for_each(BearingStepper::keep);
        past.push(self.past[0].clone());
        for _ in 0..START {
            self.instructions.run(Step(self));
        }
        if past.len() < BEARING_NODES - 1 {
            self.start = Some(past);
            return;
        }
        self.bearings.iter_mut().for_each(BearingStepper::recall);
        for (node, old) in self.past[1..].iter_mut().zip(past.into_iter().rev()) {
            *node = old;
        }
        self.step = self.full_step;
        self.formulas = Formulas::new(self.dynamics, self.step, NODES);
    }

    #[inline(always)]
    fn advance_by(&mut self) {
        let end = self.time + self.step;
        // The new node takes the place of the oldest one.
        self.past.rotate_right(1);
        let Self { dynamics, formulas, past: [new, now, before], scratch, place, velocity, .. } = self;
        let Scratch { matrix, change, forces, foreseen } = scratch;
        let frame = &dynamics.frame;
        let propagator = &formulas.propagator;
        new.extrapolate(&formulas.ahead, now, before);
        propagator.advance(place, velocity, [&new.sum, &now.sum, &before.sum]);

        // Bearings at the predicted motion of their rings.
        let size = PORT * frame.ports.len();
        matrix.fill(0.0);
        (0..size).for_each(|k| matrix[k * size + k] = 1.0);
        if formulas.accelerations.is_some() {
            accelerations(frame, &new.sum, place, velocity, foreseen);
        }
        for (index, stepper) in self.bearings.iter_mut().enumerate() {
            let mut predicted = Predicted {
                rings: dynamics.rings(index, place, velocity),
                acceleration: [0.0; 2],
                shares: Shares::default(),
            };
            if formulas.accelerations.is_some() {
                let [_, y, z, _, _] = frame.ports[index].of_place(foreseen);
                (predicted.acceleration, predicted.shares) = ([y, z], formulas.shares[index]);
            }
            let [inner, outer] = stepper.advance(end, self.step, &predicted);
            let of_outer = frame.outer[index].as_ref().map(|port| (port.port, outer));
            for (port, load) in [(index, inner)].into_iter().chain(of_outer) {
                let Some(PortLoad { wrench, resistance }) = load else { continue };
                let rows = PORT * port;
                for (k, force) in wrench.into_iter().enumerate() {
                    change[rows + k] = force - new.ports[rows + k];
                }
                let Resistance { stiffness, damping, slope } = resistance;
                formulas.places.add_product(matrix, port, &stiffness);
                formulas.velocities.add_product(matrix, port, &damping);
                if let Some((slope, by_force)) = slope.zip(formulas.accelerations.as_ref()) {
                    by_force.add_product(matrix, port, &slope);
                }
            }
        }
        solve(matrix, change);
        new.ports.iter_mut().zip(&*change).for_each(|(force, change)| *force += change);
        forces.fill(0.0);
        add_port_forces(dynamics, change, forces);
        propagator.add(place, velocity, forces);

        // What couples coordinates, at the corrected motion.
        foreseen.copy_from_slice(&new.rest);
        frame.forces(end, dynamics.speed.at(end), place, velocity, &mut new.rest);
        for ((force, rest), foreseen) in forces.iter_mut().zip(&new.rest).zip(foreseen) {
            *force = rest - *foreseen;
        }
        propagator.add(place, velocity, forces);

        new.add_up(dynamics);
        accelerations(frame, &new.sum, place, velocity, &mut self.acceleration);
        for (index, stepper) in self.bearings.iter_mut().enumerate() {
            stepper.finish(|| dynamics.rings(index, place, velocity));
        }
        self.time = end;
        self.evaluations += 1;
        if self.known < NODES {
            self.known += 1;
            self.formulas = Formulas::new(self.dynamics, self.step, self.known);
        }
    }

    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    pub(crate) fn bearings(&self) -> &[BearingStepper<'m>] {
        &self.bearings
    }

    /// Places, velocities and accelerations of the coordinates.
    pub(crate) fn coordinates(&self) -> [&[f64]; 3] {
        [&self.place, &self.velocity, &self.acceleration]
    }

    /// Forces and moments of a bearing on the shaft.
    pub(crate) fn wrench(&self, bearing: usize) -> &[f64] {
        &self.past[0].ports[PORT * bearing..PORT * (bearing + 1)]
    }
}

/// One step, compiled for each instruction set.
struct Step<'a, 'm>(&'a mut MachineStepper<'m>);

impl Task for Step<'_, '_> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.0.advance_by();
    }
}

impl Forces {
    /// Replaces the forces of the oldest node by those at the next one, on the polynomial through all.
    #[inline(always)]
    fn extrapolate(&mut self, weights: &[f64; NODES], now: &Self, before: &Self) {
        let combine = |oldest: &mut [f64], now: &[f64], before: &[f64]| {
            for ((oldest, now), before) in oldest.iter_mut().zip(now).zip(before) {
                *oldest = weights[0] * now + weights[1] * before + weights[2] * *oldest;
            }
        };
        combine(&mut self.ports, &now.ports, &before.ports);
        combine(&mut self.rest, &now.rest, &before.rest);
        combine(&mut self.sum, &now.sum, &before.sum);
    }

    /// Forms the sum. It is formed anew from the forces at the ports in each step, so that its rounding does not grow.
    #[inline(always)]
    fn add_up(&mut self, dynamics: &MachineDynamics) {
        self.sum.clone_from(&self.rest);
        add_port_forces(dynamics, &self.ports, &mut self.sum);
    }
}

/// Writes the accelerations of the coordinates under forces.
#[inline(always)]
fn accelerations(frame: &Frame, forces: &[f64], place: &[f64], velocity: &[f64], accelerations: &mut [f64]) {
    // Slices of one known length need no check in the loop.
    let size = accelerations.len();
    let (forces, place, velocity) = (&forces[..size], &place[..size], &velocity[..size]);
    let (damping, squares) = (&frame.damping[..size], &frame.squares[..size]);
    for k in 0..size {
        accelerations[k] = forces[k] - (damping[k] * velocity[k] + squares[k] * place[k]);
    }
}

#[inline(always)]
fn add_port_forces(dynamics: &MachineDynamics, ports: &[f64], forces: &mut [f64]) {
    for (rows, wrench) in dynamics.frame.ports.iter().zip(ports.as_chunks::<PORT>().0) {
        rows.add_forces(wrench, forces);
    }
}
