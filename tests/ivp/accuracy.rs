//! Error at the end against the tolerance asked for.

use raceway::numerics::ode::{Method, Statistics};

use crate::problems::{Problem, all};

/// Implicit methods with step control: each runs every problem.
const IMPLICIT: [Method; 1] = [Method::Radau];
/// Explicit ones run those that are not stiff.
const EXPLICIT: [Method; 1] = [Method::DormandPrince];

const TOLERANCES: [f64; 7] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// Runs to the end; the error there and the work.
fn run(method: Method, problem: &Problem, tolerance: f64) -> (f64, Statistics) {
    let mut integrator = method.start(problem, 0.0, &problem.start, problem.tolerances(tolerance), None);
    while integrator.time() < problem.end {
        if let Err(failure) = integrator.step(problem.end) {
            panic!("{} at {tolerance:e} on {}: {failure}", method.name(), problem.name);
        }
    }
    (problem.error(integrator.state()), integrator.statistics())
}

#[test]
fn table() {
    for problem in all() {
        for method in IMPLICIT {
            for tolerance in TOLERANCES {
                let (error, s) = run(method, &problem, tolerance);
                println!(
                    "{:15} {:24} {tolerance:7.0e} {:10.2e} {:6} {:5} {:4} {:6} {:5} {:5}",
                    method.name(),
                    problem.name,
                    error / tolerance,
                    s.steps,
                    s.rejected_steps,
                    s.newton_failures,
                    s.rhs_evaluations,
                    s.jacobian_evaluations,
                    s.factorizations,
                );
            }
        }
    }
}
