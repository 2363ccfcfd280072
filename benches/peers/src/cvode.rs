//! CVODE of SUNDIALS 6 (Lawrence Livermore National Laboratory) by hand-written declarations: serial vectors, dense
//! matrices, the dense solver that comes with it. The only file with `unsafe` code.
//!
//! All settings are the defaults of CVODE: orders up to 5 and 12, Newton's iteration for BDF, difference quotients. Two settings
//! differ: the number of steps has no limit, and the stop time is the end of the task.

use std::ffi::{CStr, c_char, c_int, c_long, c_void};
use std::ptr;

use raceway::numerics::ode::structure::Jacobian;
use raceway::numerics::ode::{OdeSystem, Tolerances};

use crate::dense;
use crate::solver::{Counted, Failure, Solution, Solver, Stepper, Task, Work, drive};

/// Major version of the declarations below. Other versions have other signatures.
const MAJOR: c_int = 6;

type Handle = *mut c_void;
/// `sunindextype` of Debian's build.
type Index = i64;

mod code {
    use super::c_int;

    pub const ADAMS: c_int = 1;
    pub const BDF: c_int = 2;
    pub const ONE_STEP: c_int = 2;
}

type Rhs = unsafe extern "C" fn(f64, Handle, Handle, Handle) -> c_int;
type Weights = unsafe extern "C" fn(Handle, Handle, Handle) -> c_int;
type DenseJacobian = unsafe extern "C" fn(f64, Handle, Handle, Handle, Handle, Handle, Handle, Handle) -> c_int;
type OnError = unsafe extern "C" fn(c_int, *const c_char, *const c_char, *mut c_char, Handle);

// SAFETY: names and signatures as in the headers of SUNDIALS 6.4.1 with double precision and 64-bit indices;
// `version` refuses other major versions at run time. `N_Vector`, `SUNMatrix`, … are pointers to opaque structures.
unsafe extern "C" {
    fn SUNDIALSGetVersionNumber(
        major: *mut c_int,
        minor: *mut c_int,
        patch: *mut c_int,
        label: *mut c_char,
        length: c_int,
    ) -> c_int;
    fn SUNContext_Create(communicator: Handle, context: *mut Handle) -> c_int;
    fn SUNContext_Free(context: *mut Handle) -> c_int;
    fn N_VNew_Serial(length: Index, context: Handle) -> Handle;
    fn N_VGetArrayPointer_Serial(vector: Handle) -> *mut f64;
    fn N_VDestroy_Serial(vector: Handle);
    fn SUNDenseMatrix(rows: Index, columns: Index, context: Handle) -> Handle;
    fn SUNDenseMatrix_Data(matrix: Handle) -> *mut f64;
    fn SUNMatDestroy_Dense(matrix: Handle);
    fn SUNLinSol_Dense(vector: Handle, matrix: Handle, context: Handle) -> Handle;
    fn SUNLinSolFree_Dense(solver: Handle) -> c_int;
    fn SUNNonlinSol_FixedPoint(vector: Handle, accelerations: c_int, context: Handle) -> Handle;
    fn SUNNonlinSolFree_FixedPoint(solver: Handle) -> c_int;
    fn CVodeCreate(multistep: c_int, context: Handle) -> Handle;
    fn CVodeInit(memory: Handle, rhs: Rhs, time: f64, start: Handle) -> c_int;
    fn CVodeWFtolerances(memory: Handle, weights: Weights) -> c_int;
    fn CVodeSetUserData(memory: Handle, data: Handle) -> c_int;
    fn CVodeSetErrHandlerFn(memory: Handle, handler: OnError, data: Handle) -> c_int;
    fn CVodeSetMaxNumSteps(memory: Handle, steps: c_long) -> c_int;
    fn CVodeSetStopTime(memory: Handle, time: f64) -> c_int;
    fn CVodeSetNonlinearSolver(memory: Handle, solver: Handle) -> c_int;
    fn CVodeSetLinearSolver(memory: Handle, solver: Handle, matrix: Handle) -> c_int;
    fn CVodeSetJacFn(memory: Handle, jacobian: DenseJacobian) -> c_int;
    fn CVode(memory: Handle, until: f64, state: Handle, time: *mut f64, task: c_int) -> c_int;
    fn CVodeGetDky(memory: Handle, time: f64, derivative: c_int, state: Handle) -> c_int;
    fn CVodeGetNumSteps(memory: Handle, steps: *mut c_long) -> c_int;
    fn CVodeGetNumErrTestFails(memory: Handle, fails: *mut c_long) -> c_int;
    fn CVodeGetNumStepSolveFails(memory: Handle, fails: *mut c_long) -> c_int;
    fn CVodeGetNumLinSolvSetups(memory: Handle, setups: *mut c_long) -> c_int;
    fn CVodeGetNumJacEvals(memory: Handle, evaluations: *mut c_long) -> c_int;
    fn CVodeFree(memory: *mut Handle);
}

/// Family of formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    Adams,
    Bdf,
}

/// Solution of the implicit equation of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Iteration {
    FixedPoint,
    /// Newton's iteration with the Jacobian from difference quotients of CVODE, one evaluation a column.
    Newton,
    /// Newton's iteration with the Jacobian of the system, which knows its structure.
    NewtonOwnJacobian,
}

pub struct Cvode {
    pub family: Family,
    pub iteration: Iteration,
}

pub fn all() -> Vec<Box<dyn Solver>> {
    [
        (Family::Bdf, Iteration::Newton),
        (Family::Bdf, Iteration::NewtonOwnJacobian),
        (Family::Adams, Iteration::FixedPoint),
        (Family::Adams, Iteration::NewtonOwnJacobian),
    ]
    .map(|(family, iteration)| Box::new(Cvode { family, iteration }) as Box<dyn Solver>)
    .into()
}

/// Version of the linked library.
pub fn version() -> Result<String, String> {
    let (mut major, mut minor, mut patch, mut label) = (0, 0, 0, [0; 32]);
    // SAFETY: all pointers are to live locals, and the length is that of the label.
    unsafe {
        SUNDIALSGetVersionNumber(&mut major, &mut minor, &mut patch, label.as_mut_ptr(), label.len() as c_int);
    }
    let found = format!("{major}.{minor}.{patch}");
    if major == MAJOR { Ok(found) } else { Err(format!("SUNDIALS {found} found, {MAJOR} is needed")) }
}

impl Solver for Cvode {
    fn name(&self) -> String {
        let family = match self.family {
            Family::Adams => "cvode_adams",
            Family::Bdf => "cvode_bdf",
        };
        match (self.family, self.iteration) {
            (Family::Adams, Iteration::FixedPoint) | (Family::Bdf, Iteration::Newton) => family.into(),
            (_, Iteration::FixedPoint) => format!("{family}_fixed_point"),
            (_, Iteration::Newton) => format!("{family}_newton"),
            (Family::Adams, Iteration::NewtonOwnJacobian) => format!("{family}_newton_j"),
            (Family::Bdf, Iteration::NewtonOwnJacobian) => format!("{family}_j"),
        }
    }

    fn run(&self, task: &Task<'_>, system: &Counted<'_>) -> Result<Solution, Failure> {
        version()?;
        let mut problem = Problem {
            system,
            tolerances: &task.tolerances,
            scratch: Jacobian::new(&system.structure()),
            sizes: task.sizes(),
            displacement: vec![0.0; task.start.len()],
            said: String::new(),
        };
        drive(task, &mut Session::new(self, task, &mut problem)?)
    }
}

/// Data of the callbacks.
struct Problem<'a> {
    system: &'a Counted<'a>,
    tolerances: &'a Tolerances,
    scratch: Jacobian,
    /// Displacements for `OdeSystem::jacobian`, which may use them.
    sizes: Vec<f64>,
    displacement: Vec<f64>,
    /// The last error message.
    said: String,
}

/// The entries of a serial vector.
///
/// SAFETY: `vector` must be a serial vector of at least `length` entries that nothing else refers to during `'v`.
unsafe fn entries<'v>(vector: Handle, length: usize) -> &'v mut [f64] {
    unsafe { std::slice::from_raw_parts_mut(N_VGetArrayPointer_Serial(vector), length) }
}

unsafe extern "C" fn rhs(time: f64, state: Handle, rate: Handle, data: Handle) -> c_int {
    // SAFETY: CVODE passes back the data of `CVodeSetUserData` and two distinct vectors of the system's dimension; the
    // problem is only read here.
    let (problem, state, rate) = unsafe {
        let problem = &*data.cast::<Problem<'_>>();
        let n = problem.system.dimension();
        (problem, entries(state, n), entries(rate, n))
    };
    problem.system.derivative(time, state, rate);
    // Above 0: CVODE may try again with a shorter step.
    c_int::from(!rate.iter().all(|x| x.is_finite()))
}

/// Reciprocal error tolerance of each component, from the tolerances of the library.
unsafe extern "C" fn weights(state: Handle, weight: Handle, data: Handle) -> c_int {
    // SAFETY: as in `rhs`.
    let (problem, state, weight) = unsafe {
        let problem = &*data.cast::<Problem<'_>>();
        let n = problem.system.dimension();
        (problem, entries(state, n), entries(weight, n))
    };
    let Tolerances { relative, absolute } = problem.tolerances;
    for i in 0..weight.len() {
        weight[i] = 1.0 / (absolute[i] + relative[i] * state[i].abs());
    }
    0
}

unsafe extern "C" fn own_jacobian(
    time: f64,
    state: Handle,
    rate: Handle,
    matrix: Handle,
    data: Handle,
    _: Handle,
    _: Handle,
    _: Handle,
) -> c_int {
    // SAFETY: CVODE passes back the data of `CVodeSetUserData`, to which nothing else refers during the call. The vectors are
    // distinct and of the dimension n of the system. The matrix is the dense n × n one of `CVodeSetLinearSolver`, by columns.
    let (problem, state, rate, matrix) = unsafe {
        let problem = &mut *data.cast::<Problem<'_>>();
        let n = problem.system.dimension();
        let matrix = std::slice::from_raw_parts_mut(SUNDenseMatrix_Data(matrix), n * n);
        (problem, entries(state, n), entries(rate, n), matrix)
    };
    let Problem { system, scratch, sizes, displacement, .. } = problem;
    dense::displacements(state, sizes, displacement);
    system.jacobian(time, state, rate, displacement, scratch);
    dense::by_columns(scratch, matrix);
    0
}

unsafe extern "C" fn on_error(_: c_int, _: *const c_char, _: *const c_char, message: *mut c_char, data: Handle) {
    // SAFETY: `data` is what `CVodeSetErrHandlerFn` was given, to which nothing else refers while CVODE reports, and
    // `message` ends with 0.
    unsafe {
        data.cast::<Problem<'_>>().as_mut().expect("never null").said = CStr::from_ptr(message).to_string_lossy().into()
    };
}

/// Memory of CVODE and all objects that it refers to.
struct Session<'p, 'a> {
    context: Handle,
    state: Handle,
    interpolated: Handle,
    matrix: Handle,
    linear: Handle,
    fixed_point: Handle,
    memory: Handle,
    problem: *mut Problem<'a>,
    /// The problem stays borrowed as long as CVODE holds a pointer to it.
    borrow: std::marker::PhantomData<&'p mut Problem<'a>>,
    n: usize,
    time: f64,
    end: f64,
}

impl<'p, 'a> Session<'p, 'a> {
    fn new(settings: &Cvode, task: &Task<'_>, problem: &'p mut Problem<'a>) -> Result<Self, String> {
        let null = ptr::null_mut;
        let n = task.start.len();
        let mut session = Self {
            context: null(),
            state: null(),
            interpolated: null(),
            matrix: null(),
            linear: null(),
            fixed_point: null(),
            memory: null(),
            problem,
            borrow: std::marker::PhantomData,
            n,
            time: 0.0,
            end: task.end,
        };
        let family = match settings.family {
            Family::Adams => code::ADAMS,
            Family::Bdf => code::BDF,
        };
        // SAFETY: each object comes from its constructor, is checked, and belongs to the session until `drop`. All belong to the
        // context of the session. The problem is borrowed as long as the session lives, and the callbacks match.
        unsafe {
            check("SUNContext_Create", SUNContext_Create(null(), &mut session.context))?;
            session.state = made("N_VNew_Serial", N_VNew_Serial(n as Index, session.context))?;
            session.interpolated = made("N_VNew_Serial", N_VNew_Serial(n as Index, session.context))?;
            entries(session.state, n).copy_from_slice(task.start);
            let memory = made("CVodeCreate", CVodeCreate(family, session.context))?;
            session.memory = memory;
            let data = session.problem.cast::<c_void>();
            check("CVodeSetErrHandlerFn", CVodeSetErrHandlerFn(memory, on_error, data))?;
            check("CVodeInit", CVodeInit(memory, rhs, 0.0, session.state))?;
            check("CVodeWFtolerances", CVodeWFtolerances(memory, weights))?;
            check("CVodeSetUserData", CVodeSetUserData(memory, data))?;
            check("CVodeSetMaxNumSteps", CVodeSetMaxNumSteps(memory, -1))?;
            check("CVodeSetStopTime", CVodeSetStopTime(memory, task.end))?;
            if settings.iteration == Iteration::FixedPoint {
                let solver = SUNNonlinSol_FixedPoint(session.state, 0, session.context);
                session.fixed_point = made("SUNNonlinSol_FixedPoint", solver)?;
                check("CVodeSetNonlinearSolver", CVodeSetNonlinearSolver(memory, solver))?;
            } else {
                // Newton's iteration is the default of CVODE.
                session.matrix = made("SUNDenseMatrix", SUNDenseMatrix(n as Index, n as Index, session.context))?;
                let solver = SUNLinSol_Dense(session.state, session.matrix, session.context);
                session.linear = made("SUNLinSol_Dense", solver)?;
                check("CVodeSetLinearSolver", CVodeSetLinearSolver(memory, solver, session.matrix))?;
            }
            if settings.iteration == Iteration::NewtonOwnJacobian {
                check("CVodeSetJacFn", CVodeSetJacFn(memory, own_jacobian))?;
            }
        }
        Ok(session)
    }

    fn count(&self, of: unsafe extern "C" fn(Handle, *mut c_long) -> c_int) -> u64 {
        let mut count = 0;
        // SAFETY: the memory is alive; where a counter does not apply, CVODE leaves it as it was.
        unsafe { of(self.memory, &mut count) };
        count as u64
    }

    fn failed(&self, function: &str, flag: c_int) -> String {
        // SAFETY: CVODE is not running, so that nothing else refers to the problem.
        let said = unsafe { &(*self.problem).said };
        format!("{function}: {flag}, {said}")
    }
}

fn check(function: &str, flag: c_int) -> Result<(), String> {
    if flag == 0 { Ok(()) } else { Err(format!("{function}: {flag}")) }
}

fn made(function: &str, object: Handle) -> Result<Handle, String> {
    if object.is_null() { Err(format!("{function} failed")) } else { Ok(object) }
}

impl Stepper for Session<'_, '_> {
    fn step(&mut self) -> Result<(), String> {
        // SAFETY: all arguments are alive.
        let flag = unsafe { CVode(self.memory, self.end, self.state, &mut self.time, code::ONE_STEP) };
        if flag < 0 { Err(self.failed("CVode", flag)) } else { Ok(()) }
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn interpolate(&mut self, time: f64, state: &mut [f64]) -> Result<(), String> {
        // SAFETY: all arguments are alive, and the vector has n entries.
        unsafe {
            let flag = CVodeGetDky(self.memory, time, 0, self.interpolated);
            if flag != 0 {
                return Err(self.failed("CVodeGetDky", flag));
            }
            state.copy_from_slice(entries(self.interpolated, self.n));
        }
        Ok(())
    }

    fn work(&self) -> Work {
        let newton = !self.linear.is_null();
        Work {
            steps: self.count(CVodeGetNumSteps),
            rejected: Some(self.count(CVodeGetNumErrTestFails) + self.count(CVodeGetNumStepSolveFails)),
            jacobians: Some(if newton { self.count(CVodeGetNumJacEvals) } else { 0 }),
            factorizations: Some(if newton { self.count(CVodeGetNumLinSolvSetups) } else { 0 }),
        }
    }
}

impl Drop for Session<'_, '_> {
    fn drop(&mut self) {
        // SAFETY: each object was made by the constructor of its kind, is freed once, and the context last.
        unsafe {
            if !self.memory.is_null() {
                CVodeFree(&mut self.memory);
            }
            if !self.fixed_point.is_null() {
                SUNNonlinSolFree_FixedPoint(self.fixed_point);
            }
            if !self.linear.is_null() {
                SUNLinSolFree_Dense(self.linear);
            }
            if !self.matrix.is_null() {
                SUNMatDestroy_Dense(self.matrix);
            }
            for vector in [self.state, self.interpolated] {
                if !vector.is_null() {
                    N_VDestroy_Serial(vector);
                }
            }
            if !self.context.is_null() {
                SUNContext_Free(&mut self.context);
            }
        }
    }
}
