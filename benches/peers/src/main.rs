//! Error against run time of the library's integrators, of CVODE and of diffsol: the same equations, start, tolerances and
//! output grid.
//!
//! ```sh
//! apt-get install libsundials-dev   # SUNDIALS 6; no other version has been tried
//! cargo run --release --manifest-path benches/peers/Cargo.toml -- --scene a
//! cargo run --release --manifest-path benches/peers/Cargo.toml -- --scene b
//! cargo test --release --manifest-path benches/peers/Cargo.toml   # tests of the wrappers
//! ```
//! `--help` lists the options. The report goes to standard output, progress to standard error.
//!
//! **Common to all solvers.** The right-hand side is that of the library, called through one wrapper that counts. Each solver
//! chooses its steps from 0 to the end, and its dense output gives the state on a grid of 102 400 Hz over the recorded time.
//! Set-up, steps and sampling are timed; errors are computed afterwards. All solvers run once, then all again.
//!
//! **Tolerances** are those of the library, for each component. CVODE gets them as its error weights. diffsol has one relative
//! tolerance for all, see `diffsol.rs`. Solvers differ in the meaning of a tolerance (error per step, norm), so that a comparison
//! is valid at equal *error*, not at equal tolerance.
//!
//! **Errors** are relative to a reference with a stated error; the mark * stands below ten times that error. The level error is
//! the larger one of the spindle accelerations in y and z, `level_db` of the samples without a filter. The trajectory error is the
//! root mean square over components and grid of the deviation over the standard deviation of the component. The latter is at
//! least 1 % of the size to which the tolerances refer.
//!
//! **Limits of the comparison.** CVODE and diffsol use dense matrices, the usual start, while the library has an arrowhead.
//! Steps and evaluations compare the methods alone. The packaged SUNDIALS is built for any x86-64 processor, and so is this program
//! without other `RUSTFLAGS`. `cvode_bdf_j` and diffsol get the Jacobian of the library, which needs a third of the evaluations
//! of a Jacobian by columns.

mod cvode;
mod dense;
mod diffsol;
mod ours;
mod scenes;
mod solver;
mod table;
#[cfg(test)]
mod tests;

use std::fmt::Display;
use std::process::ExitCode;

use clap::Parser;
use raceway::numerics::ode::Method;

use crate::scenes::{Case, Deviation, Reference, Scene};
use crate::solver::{Failure, Solver, Task, measure};
use crate::table::{Clock, Point, Row};

#[derive(Parser)]
#[command(about = "Error against run time of raceway's integrators, CVODE and diffsol on the same equations")]
struct Options {
    #[arg(long, value_enum, default_value = "a")]
    scene: Scene,
    /// Simulated before anything is compared [s]
    #[arg(long, default_value_t = 0.01)]
    settle: f64,
    /// Simulated and compared [s]
    #[arg(long, default_value_t = 0.02)]
    duration: f64,
    /// Relative tolerances, falling
    #[arg(long, value_delimiter = ',', default_values_t = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9])]
    tolerances: Vec<f64>,
    /// Runs of each solver at each tolerance
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// Largest processor time of a run before it is aborted [s]
    #[arg(long, default_value_t = 120.0)]
    limit: f64,
    /// Only these solvers; by default all of --list but the last three
    #[arg(long, value_delimiter = ',')]
    solvers: Vec<String>,
    /// List the solvers
    #[arg(long)]
    list: bool,
    /// Solver and relative tolerance of the reference, such as radau@1e-11; each scene has its own
    #[arg(long)]
    reference: Option<Choice>,
    /// Solver and relative tolerance of the second reference. Its deviation from the first is the stated error
    #[arg(long)]
    check: Option<Choice>,
    /// Largest processor time of each reference before it is aborted [s]
    #[arg(long, default_value_t = 1200.0)]
    reference_limit: f64,
    /// Error that the table "time at equal error" uses
    #[arg(long, value_enum, default_value = "processor")]
    clock: Clock,
}

/// A solver at a tolerance.
#[derive(Debug, Clone, PartialEq)]
struct Choice {
    solver: String,
    relative: f64,
}

impl std::str::FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (solver, relative) = text.split_once('@').ok_or("solver@tolerance, such as radau@1e-11")?;
        let relative = relative.parse().map_err(|_| format!("{relative} is no tolerance"))?;
        Ok(Self { solver: solver.into(), relative })
    }
}

impl Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} at {:e}", self.solver, self.relative)
    }
}

/// Default reference and second reference of a scene.
fn references(scene: Scene) -> (Choice, Choice) {
    let choice = |solver: &str, relative| Choice { solver: solver.into(), relative };
    match scene {
        Scene::A => (choice("dormand_prince", 1e-11), choice("dormand_prince", 1e-10)),
        // Two independent methods.
        Scene::B => (choice("dormand_prince", 1e-10), choice("cvode_bdf_j", 1e-11)),
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    match report(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("peers: {reason}");
            ExitCode::FAILURE
        }
    }
}

/// All solvers. The default ones come first; the second entry is their number.
fn all() -> (Vec<Box<dyn Solver>>, usize) {
    let mut solvers: Vec<_> = ours::all().into_iter().chain(cvode::all()).chain(diffsol::all()).collect();
    let usual = solvers.len();
    solvers.extend(diffsol::variants());
    (solvers, usual)
}

fn named<'a>(solvers: &'a [Box<dyn Solver>], name: &str) -> Result<&'a dyn Solver, String> {
    let found = solvers.iter().find(|solver| solver.name() == name);
    found.map(Box::as_ref).ok_or_else(|| format!("there is no solver {name}: see --list"))
}

fn report(options: &Options) -> Result<(), String> {
    let (solvers, usual) = all();
    if options.list {
        solvers.iter().for_each(|solver| println!("{}", solver.name()));
        return Ok(());
    }
    let chosen: Vec<&dyn Solver> = match options.solvers.as_slice() {
        [] => solvers[..usual].iter().map(Box::as_ref).collect(),
        names => names.iter().map(|name| named(&solvers, name)).collect::<Result<_, _>>()?,
    };
    let case = Case::new(options.scene, options.settle, options.duration)?;
    let sundials = cvode::version()?;
    println!("{}", header(options, &case, &sundials));
    let (reference, own) = reference(options, &solvers, &case)?;
    let rows = measure_all(options, &chosen, &case, &reference);
    println!("{}", table::measured(&rows, own, options.limit));
    let ours: Vec<String> = ours::all().iter().map(|solver| solver.name()).collect();
    let clock = match options.clock {
        Clock::Processor => "processor",
        Clock::Wall => "wall",
    };
    println!("Time ({clock}, median) at equal error:\n");
    println!("{}", table::equal_error(&rows, &ours, Method::Auto.name(), options.clock, options.limit));
    Ok(())
}

fn header(options: &Options, case: &Case, sundials: &str) -> String {
    let processors = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processors.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or("");
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    [
        format!("Scene {:?}: `{}`, {} states.", options.scene, options.scene.json(), case.start.len()),
        format!(
            "{} s to settle, {} s compared at {} points; median of {} runs.",
            options.settle,
            options.duration,
            case.grid.len(),
            options.runs
        ),
        format!(
            "{cores} × {}, load {} at the start; {}, opt-level {}, 16 codegen units, no LTO beyond crates.",
            model.trim_start_matches([' ', '\t', ':']),
            load.split(' ').next().unwrap_or(""),
            env!("PEERS_COMPILER"),
            env!("PEERS_OPT_LEVEL")
        ),
        format!("SUNDIALS {sundials} as packaged, diffsol {}.", diffsol::VERSION),
    ]
    .join("\n")
}

fn task<'a>(case: &'a Case, relative: f64, limit: f64) -> Task<'a> {
    Task {
        system: &case.model,
        start: &case.start,
        relative,
        tolerances: case.layout().tolerances(relative),
        end: case.end(),
        grid: &case.grid,
        limit,
    }
}

/// The reference and its error.
fn reference(options: &Options, solvers: &[Box<dyn Solver>], case: &Case) -> Result<(Reference, Deviation), String> {
    let (first, second) = references(options.scene);
    let first = options.reference.clone().unwrap_or(first);
    let second = options.check.clone().unwrap_or(second);
    let run = |choice: &Choice| {
        eprintln!("reference: {choice}");
        let task = task(case, choice.relative, options.reference_limit);
        measure(named(solvers, &choice.solver)?, &task).map_err(|failure| format!("{choice}: {failure:?}"))
    };
    let main = run(&first)?;
    let check = run(&second)?;
    let (wall, wall_of_check) = (main.wall, check.wall);
    let reference = Reference::new(case, main.solution.states);
    let own = reference.deviation(case, &check.solution.states);
    let [y, z] = reference.levels();
    println!(
        "Reference: {first} ({wall:.1} s), {y:.6} dB in y, {z:.6} dB in z. Distance from {second} ({wall_of_check:.1} s): level {:.1e} dB, trajectory {:.1e}.\n",
        own.level, own.trajectory
    );
    Ok((reference, own))
}

/// All solvers at all tolerances, and all again.
fn measure_all(options: &Options, solvers: &[&dyn Solver], case: &Case, reference: &Reference) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for run in 0..options.runs.max(1) {
        let mut place = 0;
        for solver in solvers {
            for &relative in &options.tolerances {
                if run == 0 {
                    rows.push(first(options, *solver, relative, case, reference));
                } else if let Ok(point) = &mut rows[place].outcome
                    && let Ok(again) = measure(*solver, &task(case, relative, options.limit))
                {
                    point.wall.push(again.wall);
                    point.processor.push(again.processor);
                }
                place += 1;
            }
        }
    }
    rows
}

fn first(options: &Options, solver: &dyn Solver, relative: f64, case: &Case, reference: &Reference) -> Row {
    let outcome = measure(solver, &task(case, relative, options.limit)).and_then(|measured| {
        if !measured.solution.states.iter().all(|y| y.is_finite()) {
            return Err(Failure::Refused("not finite".into()));
        }
        Ok(Point {
            deviation: reference.deviation(case, &measured.solution.states),
            wall: vec![measured.wall],
            processor: vec![measured.processor],
            work: measured.solution.work,
            rhs: measured.rhs,
            ran: measured.solution.ran,
        })
    });
    match &outcome {
        Ok(point) => eprintln!(
            "{} {relative:e}: {:.2} s, {:.1e} dB, {:.1e}",
            solver.name(),
            point.processor[0],
            point.deviation.level,
            point.deviation.trajectory
        ),
        Err(failure) => eprintln!("{} {relative:e}: {failure:?}", solver.name()),
    }
    Row { solver: solver.name(), relative, outcome }
}
