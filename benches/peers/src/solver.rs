//! The problem that every solver gets, the interface of a solver, and the loop that runs it.

use std::cell::Cell;
use std::time::Instant;

use raceway::numerics::ode::structure::{Jacobian, Structure};
use raceway::numerics::ode::{OdeSystem, Tolerances};
use rustix::time::{ClockId, clock_gettime};

/// A system that counts its evaluations.
pub struct Counted<'a> {
    system: &'a dyn OdeSystem,
    rhs: Cell<u64>,
}

impl<'a> Counted<'a> {
    pub fn new(system: &'a dyn OdeSystem) -> Self {
        Self { system, rhs: Cell::new(0) }
    }

    /// Evaluations of the right-hand side, those for Jacobians included.
    pub fn rhs(&self) -> u64 {
        self.rhs.get()
    }
}

impl OdeSystem for Counted<'_> {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.rhs.set(self.rhs.get() + 1);
        self.system.derivative(time, state, derivative);
    }

    fn structure(&self) -> Structure {
        self.system.structure()
    }

    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        let evaluations = self.system.jacobian(time, state, rate, displacement, jacobian);
        self.rhs.set(self.rhs.get() + evaluations);
        evaluations
    }
}

/// An initial value problem from time 0, with the grid of its solution.
pub struct Task<'a> {
    pub system: &'a dyn OdeSystem,
    pub start: &'a [f64],
    /// The scalar behind `tolerances`, for solvers that take no vector.
    pub relative: f64,
    pub tolerances: Tolerances,
    pub end: f64,
    /// Times of the grid, ascending, none after `end`.
    pub grid: &'a [f64],
    /// Largest processor time of a run before it is aborted [s].
    pub limit: f64,
}

impl Task<'_> {
    /// Sizes of the entries of a state at which errors begin to matter.
    pub fn sizes(&self) -> Vec<f64> {
        self.tolerances.absolute.iter().map(|absolute| absolute / self.relative).collect()
    }
}

/// Counts that a solver reports; `None` where it has none.
#[derive(Debug, Clone, Copy, Default)]
pub struct Work {
    pub steps: u64,
    pub rejected: Option<u64>,
    pub jacobians: Option<u64>,
    pub factorizations: Option<u64>,
}

/// A started solver.
pub trait Stepper {
    /// One step, not beyond the task's end.
    fn step(&mut self) -> Result<(), String>;
    /// End of the last step.
    fn time(&self) -> f64;
    /// The state at a time within the last step.
    fn interpolate(&mut self, time: f64, state: &mut [f64]) -> Result<(), String>;
    fn work(&self) -> Work;
    /// Detail of the method that the name of the solver does not contain.
    fn ran(&self) -> Option<String> {
        None
    }
}

/// A solver with its settings.
pub trait Solver {
    fn name(&self) -> String;
    /// Starts the solver and passes it to `drive`.
    fn run(&self, task: &Task<'_>, system: &Counted<'_>) -> Result<Solution, Failure>;
}

/// Solution of a solver.
pub struct Solution {
    /// The states on the grid, one after the other.
    pub states: Vec<f64>,
    pub work: Work,
    pub ran: Option<String>,
}

/// Reason of a missing solution.
#[derive(Debug, Clone, PartialEq)]
pub enum Failure {
    OverLimit,
    Refused(String),
}

impl From<String> for Failure {
    fn from(reason: String) -> Self {
        Self::Refused(reason)
    }
}

/// Steps between two readings of the clock.
const STEPS_PER_LOOK: u64 = 16;

/// Advances a solver from start to end and samples the grid within each step. Common to all solvers.
pub fn drive(task: &Task<'_>, stepper: &mut dyn Stepper) -> Result<Solution, Failure> {
    let n = task.start.len();
    let begin = processor_time();
    let mut states = vec![0.0; task.grid.len() * n];
    let mut samples = states.chunks_exact_mut(n).zip(task.grid).peekable();
    while let Some((state, _)) = samples.next_if(|(_, time)| **time <= 0.0) {
        state.copy_from_slice(task.start);
    }
    let mut steps = 0_u64;
    while stepper.time() < task.end {
        stepper.step()?;
        while let Some((state, time)) = samples.next_if(|(_, time)| **time <= stepper.time()) {
            stepper.interpolate(*time, state)?;
        }
        steps += 1;
        if steps.is_multiple_of(STEPS_PER_LOOK) && processor_time() - begin > task.limit {
            return Err(Failure::OverLimit);
        }
    }
    drop(samples);
    Ok(Solution { states, work: stepper.work(), ran: stepper.ran() })
}

/// A run with its cost.
pub struct Measured {
    pub solution: Solution,
    /// Wall time [s].
    pub wall: f64,
    /// Processor time of all threads [s], which depends less on other processes of the machine.
    pub processor: f64,
    /// Evaluations of the right-hand side.
    pub rhs: u64,
}

/// Runs and times a solver, its set-up included.
pub fn measure(solver: &dyn Solver, task: &Task<'_>) -> Result<Measured, Failure> {
    let system = Counted::new(task.system);
    let (wall, processor) = (Instant::now(), processor_time());
    let solution = solver.run(task, &system)?;
    let (wall, processor) = (wall.elapsed().as_secs_f64(), processor_time() - processor);
    Ok(Measured { solution, wall, processor, rhs: system.rhs() })
}

/// Processor time of all threads [s].
fn processor_time() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}
