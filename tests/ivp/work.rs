//! The counts that an integrator reports: evaluations, Jacobians, steps.

use std::cell::Cell;

use raceway::numerics::ode::{Integrator, Method, OdeSystem};

use crate::problems::{Problem, all};

/// A system that counts every evaluation. Its Jacobian comes from difference quotients, the default, and counts, too.
struct Counted<'a> {
    problem: &'a Problem,
    evaluations: Cell<u64>,
}

impl<'a> Counted<'a> {
    fn new(problem: &'a Problem) -> Self {
        Self { problem, evaluations: Cell::new(0) }
    }
}

impl OdeSystem for Counted<'_> {
    fn dimension(&self) -> usize {
        self.problem.dimension()
    }
    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.evaluations.set(self.evaluations.get() + 1);
        self.problem.derivative(time, state, derivative);
    }
}

fn named(name: &str) -> Problem {
    all().into_iter().find(|problem| problem.name == name).expect("one of the problems")
}

/// A run to both limits with a restart at the first. `look` is called after each step.
fn run(integrator: &mut dyn Integrator, limits: [f64; 2], mut look: impl FnMut(&mut dyn Integrator)) {
    for limit in limits {
        while integrator.time() < limit {
            integrator.step(limit).unwrap();
            look(integrator);
        }
        integrator.restart();
    }
}

#[test]
fn every_evaluation_is_counted() {
    for name in ["HIRES", "Pleiades"] {
        let problem = named(name);
        for method in Method::NAMED.into_iter().chain([Method::Auto]) {
            let counted = Counted::new(&problem);
            let mut integrator = method.start(&counted, 0.0, &problem.start, problem.tolerances(1e-6), None);
            run(integrator.as_mut(), [0.4 * problem.end, problem.end], |_| {});
            let work = integrator.statistics();
            println!("{name}, {}: {work:?}", method.name());
            assert_eq!(work.rhs_evaluations, counted.evaluations.get(), "{name}, {}", method.name());
        }
    }
}

/// A fixed step is checked for stability. The check evaluates a Jacobian, which an explicit method does not otherwise need.
#[test]
fn stability_checks_are_counted() {
    let problem = named("Pleiades");
    for method in Method::NAMED.into_iter().filter(|method| method.takes_fixed_steps()) {
        let counted = Counted::new(&problem);
        let step = Some(1e-4 * problem.end);
        let mut integrator = method.start(&counted, 0.0, &problem.start, problem.tolerances(1e-6), step);
        let mut looks = 0;
        run(integrator.as_mut(), [0.1 * problem.end, 0.2 * problem.end], |integrator| {
            looks += u32::from(integrator.stability().is_some());
        });
        let work = integrator.statistics();
        println!("{}: {looks} looks, {work:?}", method.name());
        assert!(looks > 1000);
        assert_eq!(work.rhs_evaluations, counted.evaluations.get(), "{}", method.name());
    }
}
