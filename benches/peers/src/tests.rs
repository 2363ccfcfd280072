//! The wrappers on Robertson's reaction, whose solution is known.

use raceway::numerics::ode::{OdeSystem, Tolerances};

use crate::cvode::{Cvode, Family, Iteration};
use crate::diffsol::{Algebra, Diffsol, Formula, Source};
use crate::solver::{Failure, Measured, Solver, Task, measure};

/// Three species, rates from 0.04 to 3·10⁷ (H. H. Robertson, 1966).
struct Robertson;

impl OdeSystem for Robertson {
    fn dimension(&self) -> usize {
        3
    }

    fn derivative(&self, _: f64, y: &[f64], rate: &mut [f64]) {
        rate[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
        rate[2] = 3e7 * y[1] * y[1];
        rate[1] = -rate[0] - rate[2];
    }
}

/// At t = 40, from SUNDIALS' example cvRoberts_dns and, in more digits, Hairer and Wanner's test set.
const AT_40: [f64; 3] = [0.715_827_068_71, 9.185_534_764_6e-6, 0.284_163_745_7];

fn solved(solver: &dyn Solver, limit: f64) -> Result<Measured, Failure> {
    let relative = 1e-8;
    let task = Task {
        system: &Robertson,
        start: &[1.0, 0.0, 0.0],
        relative,
        tolerances: Tolerances { relative: vec![relative; 3], absolute: vec![relative, 1e-5 * relative, relative] },
        end: 40.0,
        grid: &[0.0, 20.0, 40.0],
        limit,
    };
    measure(solver, &task)
}

fn assert_right(solver: &dyn Solver) -> Measured {
    let found = solved(solver, 60.0).unwrap_or_else(|failure| panic!("{}: {failure:?}", solver.name()));
    let states = &found.solution.states;
    assert_eq!(states[..3], [1.0, 0.0, 0.0]);
    for (y, exact) in states[6..].iter().zip(AT_40) {
        assert!((y / exact - 1.0).abs() < 2e-6, "{}: {y} is not {exact}", solver.name());
    }
    assert!((states[3..6].iter().sum::<f64>() - 1.0).abs() < 1e-6);
    found
}

#[test]
fn cvode_solves_robertsons_reaction() {
    let mut steps = Vec::new();
    for iteration in [Iteration::Newton, Iteration::NewtonOwnJacobian] {
        let found = assert_right(&Cvode { family: Family::Bdf, iteration });
        let work = found.solution.work;
        assert!(work.jacobians > Some(0) && work.factorizations > Some(work.steps / 100), "{work:?}");
        assert!(work.steps > 100 && work.steps < 3000 && found.rhs > work.steps, "{work:?}");
        steps.push(work.steps);
    }
    assert!(steps[0].abs_diff(steps[1]) < steps[0] / 10, "the Jacobian's source hardly matters: {steps:?}");
    assert_right(&Cvode { family: Family::Adams, iteration: Iteration::NewtonOwnJacobian });
}

#[test]
fn diffsol_solves_robertsons_reaction() {
    for algebra in [Algebra::Nalgebra, Algebra::Faer] {
        for source in [Source::Differences, Source::System] {
            assert_right(&Diffsol { formula: Formula::Bdf, algebra, source });
        }
    }
    for formula in [Formula::TrBdf2, Formula::Esdirk34] {
        assert_right(&Diffsol { formula, algebra: Algebra::Nalgebra, source: Source::System });
    }
}

#[test]
fn a_run_that_takes_too_long_is_given_up() {
    let explicit = Diffsol { formula: Formula::Tsit45, algebra: Algebra::Nalgebra, source: Source::System };
    assert!(matches!(solved(&explicit, 0.0), Err(Failure::OverLimit)));
}
