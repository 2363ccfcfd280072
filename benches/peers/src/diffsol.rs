//! diffsol (M. Robinson et al.): its backward differentiation (quasi-constant step, orders 1–5, as in SciPy and MATLAB), its singly
//! diagonally implicit Runge–Kutta methods and its explicit one, on dense matrices.
//!
//! It has one relative tolerance for all components. The library has 0 for arcs and spins, whose error is relative to their size
//! only. There diffsol gets a looser tolerance. All absolute tolerances are the same.

use std::cell::{Cell, RefCell};

use ::diffsol::matrix::MatrixRef;
use ::diffsol::{
    ConstantOp, DefaultDenseMatrix, DiffsolError, FaerLU, FaerMat, LinearSolver, Matrix, NalgebraLU, NalgebraMat,
    NonLinearOp, NonLinearOpJacobian, OdeBuilder, OdeEquations, OdeEquationsRef, OdeSolverMethod, OdeSolverProblem, Op,
    UnitCallable, Vector, VectorRef,
};
use raceway::numerics::ode::OdeSystem;
use raceway::numerics::ode::structure::Jacobian;

use crate::dense;
use crate::solver::{Counted, Failure, Solution, Solver, Stepper, Task, Work, drive};

/// Version in the lock file.
pub const VERSION: &str = "0.18.0";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Formula {
    Bdf,
    TrBdf2,
    Esdirk34,
    Tsit45,
}

/// Library of the dense matrices and their factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Algebra {
    /// Partial pivoting.
    Nalgebra,
    /// Full pivoting.
    Faer,
}

/// Source of the Jacobians.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Difference quotients, one evaluation a column.
    Differences,
    /// Jacobian of the system, which knows its structure.
    System,
}

pub struct Diffsol {
    pub formula: Formula,
    pub algebra: Algebra,
    pub source: Source,
}

/// Methods of diffsol, with its fastest algebra and Jacobians.
pub fn all() -> Vec<Box<dyn Solver>> {
    [Formula::Bdf, Formula::Esdirk34, Formula::TrBdf2, Formula::Tsit45]
        .map(|formula| Box::new(Diffsol { formula, algebra: Algebra::Nalgebra, source: Source::System }) as _)
        .into()
}

/// Other variants of its backward differentiation, which are slower.
pub fn variants() -> Vec<Box<dyn Solver>> {
    use {Algebra::*, Source::*};
    [(Nalgebra, Differences), (Faer, System), (Faer, Differences)]
        .map(|(algebra, source)| Box::new(Diffsol { formula: Formula::Bdf, algebra, source }) as _)
        .into()
}

impl Solver for Diffsol {
    fn name(&self) -> String {
        let formula = match self.formula {
            Formula::Bdf => "diffsol_bdf",
            Formula::TrBdf2 => "diffsol_tr_bdf2",
            Formula::Esdirk34 => "diffsol_esdirk34",
            Formula::Tsit45 => "diffsol_tsit45",
        };
        let algebra = if self.algebra == Algebra::Faer { "_faer" } else { "" };
        let source = if self.source == Source::Differences { "_dq" } else { "" };
        format!("{formula}{algebra}{source}")
    }

    fn run(&self, task: &Task<'_>, system: &Counted<'_>) -> Result<Solution, Failure> {
        match self.algebra {
            Algebra::Nalgebra => self.with::<NalgebraMat<f64>, NalgebraLU<f64>>(task, system),
            Algebra::Faer => self.with::<FaerMat<f64>, FaerLU<f64>>(task, system),
        }
    }
}

impl Diffsol {
    fn with<M, LS>(&self, task: &Task<'_>, system: &Counted<'_>) -> Result<Solution, Failure>
    where
        M: Matrix<T = f64>,
        M::V: DefaultDenseMatrix<T = f64, C = M::C>,
        for<'b> &'b M::V: VectorRef<M::V>,
        for<'b> &'b M: MatrixRef<M>,
        LS: LinearSolver<M>,
    {
        let problem = self.problem::<M>(task, system).map_err(in_words)?;
        match self.formula {
            Formula::Bdf => follow(task, problem.bdf::<LS>().map_err(in_words)?),
            Formula::TrBdf2 => follow(task, problem.tr_bdf2::<LS>().map_err(in_words)?),
            Formula::Esdirk34 => follow(task, problem.esdirk34::<LS>().map_err(in_words)?),
            Formula::Tsit45 => follow(task, problem.tsit45().map_err(in_words)?),
        }
    }

    fn problem<'a, M: Matrix<T = f64>>(
        &self,
        task: &'a Task<'a>,
        system: &'a Counted<'a>,
    ) -> Result<OdeSolverProblem<Equations<'a, M>>, DiffsolError> {
        let builder = OdeBuilder::<M>::new().rtol(task.relative).atol(task.tolerances.absolute.iter().copied());
        let mut problem = builder.build_from_eqn(Equations::new(task, system, self.source))?;
        // The default, 1e-13 s, may be too long for the first steps of a stiff system.
        problem.ode_options.min_timestep = 1e-18;
        // The limit is for the whole run, while that of CVODE is for a step.
        problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
        Ok(problem)
    }
}

fn in_words(error: DiffsolError) -> String {
    error.to_string()
}

fn follow<'a, E, S>(task: &Task<'_>, mut method: S) -> Result<Solution, Failure>
where
    E: OdeEquations<T = f64> + Counts + 'a,
    S: OdeSolverMethod<'a, E>,
{
    method.set_stop_time(task.end).map_err(in_words)?;
    let state = method.state().y.clone();
    drive(task, &mut Steps { method, state, equations: std::marker::PhantomData })
}

struct Steps<'a, E: OdeEquations + 'a, S: OdeSolverMethod<'a, E>> {
    method: S,
    state: E::V,
    equations: std::marker::PhantomData<&'a E>,
}

impl<'a, E: OdeEquations<T = f64> + Counts + 'a, S: OdeSolverMethod<'a, E>> Stepper for Steps<'a, E, S> {
    fn step(&mut self) -> Result<(), String> {
        self.method.step().map(|_| ()).map_err(in_words)
    }

    fn time(&self) -> f64 {
        self.method.state().t
    }

    fn interpolate(&mut self, time: f64, state: &mut [f64]) -> Result<(), String> {
        self.method.interpolate_inplace(time, &mut self.state).map_err(in_words)?;
        self.state.for_each_batch_host([], |found, [], _| state.copy_from_slice(found));
        Ok(())
    }

    fn work(&self) -> Work {
        let statistics = self.method.get_statistics();
        Work {
            steps: statistics.number_of_steps as u64,
            rejected: Some(
                (statistics.number_of_error_test_failures + statistics.number_of_nonlinear_solver_fails) as u64,
            ),
            jacobians: Some(self.method.problem().eqn.jacobians()),
            factorizations: Some(statistics.number_of_linear_solver_setups as u64),
        }
    }
}

/// Equations that count their Jacobians.
trait Counts {
    fn jacobians(&self) -> u64;
}

/// The system in diffsol's terms.
struct Equations<'a, M: Matrix> {
    system: &'a Counted<'a>,
    start: &'a [f64],
    /// Sizes of the entries of a state, for difference quotients.
    sizes: Vec<f64>,
    source: Source,
    jacobians: Cell<u64>,
    scratch: RefCell<Scratch>,
    context: M::C,
}

struct Scratch {
    jacobian: Jacobian,
    columns: Vec<f64>,
    rate: Vec<f64>,
    displacement: Vec<f64>,
}

impl<'a, M: Matrix<T = f64>> Equations<'a, M> {
    fn new(task: &'a Task<'a>, system: &'a Counted<'a>, source: Source) -> Self {
        let n = task.start.len();
        Self {
            system,
            start: task.start,
            sizes: task.sizes(),
            source,
            jacobians: Cell::new(0),
            scratch: RefCell::new(Scratch {
                jacobian: Jacobian::new(&system.structure()),
                columns: vec![0.0; n * n],
                rate: vec![0.0; n],
                displacement: vec![0.0; n],
            }),
            context: M::C::default(),
        }
    }
}

impl<M: Matrix> Counts for Equations<'_, M> {
    fn jacobians(&self) -> u64 {
        self.jacobians.get()
    }
}

impl<M: Matrix<T = f64>> Op for Equations<'_, M> {
    type T = f64;
    type V = M::V;
    type M = M;
    type C = M::C;

    fn context(&self) -> &M::C {
        &self.context
    }

    fn nstates(&self) -> usize {
        self.start.len()
    }

    fn nout(&self) -> usize {
        self.start.len()
    }

    fn nparams(&self) -> usize {
        0
    }
}

impl<M: Matrix<T = f64>> NonLinearOp for Equations<'_, M> {
    fn call_inplace(&self, state: &M::V, time: f64, rate: &mut M::V) {
        rate.for_each_batch_host([state], |rate, [state], _| self.system.derivative(time, state, rate));
    }
}

impl<M: Matrix<T = f64>> NonLinearOpJacobian for Equations<'_, M> {
    /// A difference quotient along `direction`, which moves no entry by more than half the digits of its size.
    /// Dense matrices never call it. They use `jacobian_inplace`.
    fn jac_mul_inplace(&self, state: &M::V, time: f64, direction: &M::V, product: &mut M::V) {
        product.for_each_batch_host([state, direction], |product, [state, direction], _| {
            let most = direction.iter().zip(&self.sizes).map(|(d, size)| d.abs() / size).fold(0.0, f64::max);
            if most == 0.0 {
                return product.fill(0.0);
            }
            let length = f64::EPSILON.sqrt() / most;
            let moved: Vec<f64> = state.iter().zip(direction).map(|(y, d)| y + length * d).collect();
            let mut rate = vec![0.0; state.len()];
            self.system.derivative(time, state, &mut rate);
            self.system.derivative(time, &moved, product);
            for (moved, unmoved) in product.iter_mut().zip(&rate) {
                *moved = (*moved - unmoved) / length;
            }
        });
    }

    fn jacobian_inplace(&self, state: &M::V, time: f64, matrix: &mut M) {
        self.jacobians.set(self.jacobians.get() + 1);
        let scratch = &mut *self.scratch.borrow_mut();
        let mut column = M::V::zeros(self.start.len(), self.context.clone());
        column.for_each_batch_host([state], |_, [state], _| {
            let Scratch { jacobian, columns, rate, displacement } = &mut *scratch;
            dense::displacements(state, &self.sizes, displacement);
            self.system.derivative(time, state, rate);
            match self.source {
                Source::System => {
                    self.system.jacobian(time, state, rate, displacement, jacobian);
                    dense::by_columns(jacobian, columns);
                }
                Source::Differences => {
                    dense::by_differences(self.system, time, state, rate, displacement, columns);
                }
            }
        });
        for (index, values) in scratch.columns.chunks_exact(self.start.len()).enumerate() {
            column.for_each_batch_host([], |column, [], _| column.copy_from_slice(values));
            matrix.set_column(index, &column);
        }
    }
}

impl<M: Matrix<T = f64>> ConstantOp for Equations<'_, M> {
    fn call_inplace(&self, _: f64, state: &mut M::V) {
        state.for_each_batch_host([], |state, [], _| state.copy_from_slice(self.start));
    }
}

impl<'r, M: Matrix<T = f64>> OdeEquationsRef<'r> for Equations<'_, M> {
    type Mass = UnitCallable<M>;
    type Rhs = &'r Self;
    type Root = UnitCallable<M>;
    type Init = &'r Self;
    type Out = UnitCallable<M>;
    type Reset = UnitCallable<M>;
}

impl<M: Matrix<T = f64>> OdeEquations for Equations<'_, M> {
    fn rhs(&self) -> &Self {
        self
    }

    fn mass(&self) -> Option<UnitCallable<M>> {
        None
    }

    fn init(&self) -> &Self {
        self
    }

    fn set_params(&mut self, _: &M::V) {}

    fn get_params(&self, _: &mut M::V) {}
}
