//! Fixed steps of a machine, one evaluation of each bearing a step.
//!
//! Balls and cages take their linearly implicit steps at a predicted motion of their rings. Shaft and housing are a linear system, advanced
//! exactly under inputs that follow the parabola through three nodes. The bearings' forces at the new node are extrapolated first. After the
//! evaluation f̂ there, with the compliances H of the new node and the resistances K, C of the balls, (1 + K H_q + C H_v) Δf = f̂ − f
//! corrects them implicitly.
//!
//! A step ends at each kink of a load or of the speed. Short steps build the past of the steps after it.

use nalgebra::DMatrix;

use super::bearing_stepper::BearingStepper;
use super::equations::MachineDynamics;
use super::frame::Frame;
use super::port::{PortLoad, Predicted, Resistance};
use super::propagator::{ExactStep, NODES, Propagator};
use super::resolution::Resolution;
use super::speed_steps::SpeedSteps;
use crate::numerics::dense::solve;
use crate::numerics::lanes::{InstructionSet, LANES, Task};
use crate::numerics::ode::adams::ahead;
use crate::numerics::ode::adams_moulton::Shares;
use crate::physics::statics::Matrix;
use crate::rotor::operating::in_nalgebra;

/// Number of entries of a port.
const PORT: usize = 5;
/// Short steps to one of full length at the start.
const START: usize = 16;
/// Nodes that the bearings keep, the newest included.
const BEARING_NODES: usize = 4;

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
    /// `Some` in the first steps of a stretch: inputs at full distance while short steps build the past, oldest first.
    start: Option<Vec<Vec<f64>>>,
    /// Full step of the stretch, and the present one.
    full_step: f64,
    step: f64,
    time: f64,
    /// Places and velocities of the coordinates.
    motion: Vec<f64>,
    /// Inputs of shaft and housing at the last nodes, newest first, one behind the other.
    past: Vec<f64>,
    /// Number of valid nodes.
    known: usize,
    steps_at: SpeedSteps,
    formulas: Formulas,
    scratch: Scratch,
    evaluations: u64,
    resolution: Resolution,
    instructions: InstructionSet,
}

/// Work space of a step.
struct Scratch {
    /// 1 + K H_q + C H_v over the ports, row by row, and the right side and solution of its equations [N, N m].
    matrix: Vec<f64>,
    change: Vec<f64>,
    /// The motion at the end of the step.
    next: Vec<f64>,
}

/// Constants of steps of one length through a number of known nodes.
struct Formulas {
    /// With their shares, at the speeds around the present one.
    propagators: Vec<(f64, Propagator)>,
    ahead: [f64; NODES],
    of_ports: OfPorts,
}

/// Motions of the ports in a step by forces at the new node.
struct OfPorts {
    places: Compliances,
    velocities: Compliances,
    /// Accelerations of the ports by the same forces, and the shares of each port's own radial ones in its place and velocity; of bearings whose load
    /// depends on accelerations.
    accelerations: Option<Compliances>,
    shares: Vec<Shares>,
}

impl OfPorts {
    fn new(dynamics: &MachineDynamics, step: &ExactStep, speed: f64, known: usize) -> Self {
        let (frame, size) = (&dynamics.frame, PORT * dynamics.frame.ports.len());
        let [by_force, ..] = step.of_inputs(known);
        let [of_place, of_velocity] =
            [0, frame.len()].map(|first| by_force.view((first, 0), (frame.len(), size)).into_owned());
        let [places, velocities] = [&of_place, &of_velocity].map(|motions| Compliances::of(frame, motions));
        let (mut accelerations, mut shares) = (None, Vec::new());
        if dynamics.needs_accelerations() {
            let [stiffness, damping] = frame.matrices(speed);
            let motions = frame.inputs.columns(0, size) - damping * of_velocity - stiffness * of_place;
            let by_force = Compliances::of(frame, &motions);
            // Over Y and Z together.
            let radial = |of: &Compliances, port: usize| of.block(port, port)[1][1] + of.block(port, port)[2][2];
            let share = |port: usize| {
                let own = radial(&by_force, port);
                Shares { place: radial(&places, port) / own, velocity: radial(&velocities, port) / own }
            };
            shares = (0..dynamics.bearings.len()).map(share).collect();
            accelerations = Some(by_force);
        }
        Self { places, velocities, accelerations, shares }
    }
}

/// Motion of every port by forces at every port: a block for each pair of them, its rows padded.
struct Compliances {
    ports: usize,
    blocks: Vec<[[f64; LANES]; PORT]>,
}

impl Compliances {
    /// The compliances of all ports. `motions`: of the coordinates, by the forces and moments at each port.
    fn of(frame: &Frame, motions: &DMatrix<f64>) -> Self {
        let ports = frame.ports.len();
        let block = |pair: usize| {
            let (port, by) = (&frame.ports[pair / ports], PORT * (pair % ports));
            let moved: [_; PORT] = std::array::from_fn(|column| port.of_place(motions.column(by + column).as_slice()));
            let row = |row: usize| std::array::from_fn(|lane| if lane < PORT { moved[lane][row] } else { 0.0 });
            std::array::from_fn(row)
        };
        Self { ports, blocks: (0..ports * ports).map(block).collect() }
    }

    /// Of all ports by forces at all of them.
    fn matrix(&self) -> DMatrix<f64> {
        let size = PORT * self.ports;
        let entry = |row: usize, column: usize| self.block(row / PORT, column / PORT)[row % PORT][column % PORT];
        DMatrix::from_fn(size, size, entry)
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
    let speed = dynamics.speed.at(0.0).1;
    let exact = ExactStep::of(&dynamics.frame, speed, step);
    let places = between_rings(dynamics, &OfPorts::new(dynamics, &exact, speed, NODES).places);
    let Some(point) = dynamics.frame.system.operating.first() else { return 0.0 };
    let mut stiffness = DMatrix::zeros(size, size);
    for (index, (bearing, ring)) in dynamics.bearings.iter().zip(&point.rings).enumerate() {
        let own = in_nalgebra(&bearing.mounted.along_shaft(&ring.stiffness.mean));
        stiffness.view_mut((PORT * index, PORT * index), (PORT, PORT)).copy_from(&own);
    }
    // K^½ H K^½ has the eigenvalues of K H and is symmetric: their iteration always ends.
    let symmetric = |matrix: DMatrix<f64>| (&matrix + matrix.transpose()).scale(0.5).symmetric_eigen();
    let mut root = symmetric(stiffness);
    root.eigenvalues.apply(|value| *value = value.max(0.0).sqrt());
    let root = root.recompose();
    symmetric(&root * places.matrix() * &root).eigenvalues.amax()
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
        let (frame, ports) = (&dynamics.frame, PORT * dynamics.frame.ports.len());
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
        let loads = dynamics.evaluate(time, state, &mut vec![0.0; state.len()], |_| None);
        let of_rings = || dynamics.bearings.iter().zip(&loads.rings);
        let on_shaft = of_rings()
            .zip(first)
            .flat_map(|((bearing, load), first)| first.unwrap_or_else(|| bearing.on_shaft(&load.inner)));
        let moving = of_rings().zip(&frame.outer).filter(|(_, outer)| outer.is_some());
        let on_housing = moving.flat_map(|((bearing, load), _)| bearing.on_shaft(&load.outer));
        let mut inputs: Vec<f64> = on_shaft.chain(on_housing).collect();
        inputs.resize(frame.inputs.ncols(), 0.0);
        let mut steps_at = SpeedSteps::new(&dynamics.speed, frame.depends_on_speed());
        let mut stepper = Self {
            bearings,
            length,
            kinks: dynamics.kinks(),
            stretch: Stretch { end: time, left: 0 },
            start: None,
            full_step: length.longest,
            step: length.longest,
            time,
            motion: [place, velocity].concat(),
            past: inputs.repeat(NODES),
            known: 1,
            formulas: Formulas::new(dynamics, &mut steps_at, time, length.longest, 1),
            steps_at,
            scratch: Scratch {
                matrix: vec![0.0; ports * ports],
                change: vec![0.0; ports],
                next: vec![0.0; 2 * frame.len()],
            },
            evaluations: 1,
            resolution: Resolution::default(),
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
        // The loads after the kink, not those before it.
        let after = from.next_up();
        self.dynamics.frame.write_loads(after, self.dynamics.speed.at(after), newest(&mut self.past));
        self.known = 1;
        self.step = self.full_step / START as f64;
        self.renew_formulas();
        self.bearings.iter_mut().for_each(BearingStepper::begin);
        self.start = Some(Vec::new());
    }

    fn renew_formulas(&mut self) {
        self.formulas = Formulas::new(self.dynamics, &mut self.steps_at, self.time, self.step, self.known);
    }

    /// One step, the first of a stretch in short steps of rising order, compiled for the processor's instructions.
    pub(crate) fn advance(&mut self) {
        match self.start.take() {
            None => self.advance_once(),
            Some(past) => self.advance_start(past),
        }
        self.stretch.left -= 1;
        if self.stretch.left == 0 {
            self.time = self.stretch.end;
            self.begin_stretch();
        }
    }

    fn advance_start(&mut self, mut past: Vec<Vec<f64>>) {
        self.bearings.iter_mut().for_each(BearingStepper::keep);
        past.push(self.inputs().to_vec());
        for _ in 0..START {
            self.advance_once();
            if self.known < NODES {
                self.known += 1;
                self.renew_formulas();
            }
        }
        if past.len() < BEARING_NODES - 1 {
            self.start = Some(past);
            return;
        }
        self.bearings.iter_mut().for_each(BearingStepper::recall);
        let size = self.inputs().len();
        for (node, old) in self.past[size..].chunks_exact_mut(size).zip(past.iter().rev()) {
            node.copy_from_slice(old);
        }
        self.step = self.full_step;
        self.renew_formulas();
    }

    fn advance_once(&mut self) {
        let middle = self.dynamics.speed.at(self.time + 0.5 * self.step).1;
        match self.steps_at.shares(middle) {
            Some(shares) => self.formulas.propagators.iter_mut().zip(shares).for_each(|(of, share)| of.0 = share),
            None => self.renew_formulas(),
        }
        self.instructions.run(Step(self));
    }

    #[inline(always)]
    fn advance_by(&mut self) {
        let end = self.time + self.step;
        let Self { dynamics, formulas, past, scratch, motion, resolution, .. } = self;
        let Scratch { matrix, change, next } = scratch;
        let (frame, of_ports, turning) = (&dynamics.frame, &formulas.of_ports, dynamics.speed.at(end));
        let size = PORT * frame.ports.len();
        extrapolate(&formulas.ahead, past);
        frame.write_loads(end, turning, newest(past));
        next.fill(0.0);
        for (share, propagator) in &formulas.propagators {
            propagator.add_step(*share, motion, past, next);
        }
        let new = newest(past);

        // Bearings at the predicted motion of their rings.
        let (place, velocity) = next.split_at(frame.len());
        matrix.fill(0.0);
        (0..size).for_each(|k| matrix[k * size + k] = 1.0);
        for (index, stepper) in self.bearings.iter_mut().enumerate() {
            let mut predicted = Predicted {
                rings: dynamics.rings(index, place, velocity),
                acceleration: [0.0; 2],
                shares: Shares::default(),
            };
            if of_ports.accelerations.is_some() {
                let [_, y, z, _, _] = frame.accelerations.ports[index].at(turning.1, (place, velocity), new);
                (predicted.acceleration, predicted.shares) = ([y, z], of_ports.shares[index]);
            }
            let [inner, outer] = stepper.advance(end, self.step, &predicted);
            let of_outer = frame.outer[index].as_ref().map(|port| (port.port, outer));
            for (port, load) in [(index, inner)].into_iter().chain(of_outer) {
                let Some(PortLoad { wrench, resistance }) = load else { continue };
                let rows = PORT * port;
                for (k, force) in wrench.into_iter().enumerate() {
                    change[rows + k] = force - new[rows + k];
                }
                let Resistance { stiffness, damping, slope } = resistance;
                of_ports.places.add_product(matrix, port, &stiffness);
                of_ports.velocities.add_product(matrix, port, &damping);
                if let Some((slope, by_force)) = slope.zip(of_ports.accelerations.as_ref()) {
                    by_force.add_product(matrix, port, &slope);
                }
            }
        }
        solve(matrix, change);
        new.iter_mut().zip(&*change).for_each(|(force, change)| *force += change);
        let (new, others) = past.split_at(past.len() / NODES);
        resolution.add(change, new, others);
        for (share, propagator) in &formulas.propagators {
            propagator.add_change(*share, change, next);
        }
        std::mem::swap(motion, next);
        let (place, velocity) = motion.split_at(frame.len());
        for (index, stepper) in self.bearings.iter_mut().enumerate() {
            stepper.finish(|| dynamics.rings(index, place, velocity));
        }
        self.time = end;
        self.evaluations += 1;
    }

    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    pub(crate) fn resolution(&self) -> &Resolution {
        &self.resolution
    }

    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    pub(crate) fn bearings(&self) -> &[BearingStepper<'m>] {
        &self.bearings
    }

    /// Places and velocities of the coordinates.
    pub(crate) fn coordinates(&self) -> (&[f64], &[f64]) {
        self.motion.split_at(self.dynamics.frame.len())
    }

    /// The newest inputs of shaft and housing.
    pub(crate) fn inputs(&self) -> &[f64] {
        &self.past[..self.past.len() / NODES]
    }

    /// Forces and moments of a bearing on the shaft.
    pub(crate) fn wrench(&self, bearing: usize) -> &[f64] {
        &self.past[PORT * bearing..PORT * (bearing + 1)]
    }
}

impl Formulas {
    fn new(dynamics: &MachineDynamics, steps_at: &mut SpeedSteps, time: f64, step: f64, known: usize) -> Self {
        let speed = dynamics.speed.at(time + 0.5 * step).1;
        let around = steps_at.around(&dynamics.frame, speed, step);
        let of_ports = OfPorts::new(dynamics, around[0].1, speed, known);
        let propagators = around.into_iter().map(|(share, exact)| (share, exact.propagator(known))).collect();
        Self { propagators, ahead: ahead(known), of_ports }
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

/// The inputs at the newest node.
#[inline(always)]
fn newest(past: &mut [f64]) -> &mut [f64] {
    let size = past.len() / NODES;
    &mut past[..size]
}

/// Moves the nodes by one; the inputs at the new one are those on the polynomial through the others.
#[inline(always)]
fn extrapolate(weights: &[f64; NODES], past: &mut [f64]) {
    let (new, others) = past.split_at_mut(past.len() / NODES);
    let (before, oldest) = others.split_at_mut(new.len());
    for ((new, before), oldest) in new.iter_mut().zip(before).zip(oldest) {
        (*oldest, *before, *new) = (*before, *new, weights[0] * *new + weights[1] * *before + weights[2] * *oldest);
    }
}
