//! The methods of the library.

use raceway::numerics::ode::{Integrator, Method};

use crate::solver::{Counted, Failure, Solution, Solver, Stepper, Task, Work, drive};

/// All methods of the library.
pub fn all() -> Vec<Box<dyn Solver>> {
    let methods = Method::NAMED.into_iter().chain([Method::Auto]);
    methods.map(|method| Box::new(Ours(method)) as Box<dyn Solver>).collect()
}

pub struct Ours(pub Method);

impl Solver for Ours {
    fn name(&self) -> String {
        self.0.name().into()
    }

    fn run(&self, task: &Task<'_>, system: &Counted<'_>) -> Result<Solution, Failure> {
        let integrator = self.0.start(system, 0.0, task.start, task.tolerances.clone(), None);
        drive(task, &mut Steps { integrator, asked: self.0, end: task.end })
    }
}

struct Steps<'a> {
    integrator: Box<dyn Integrator + 'a>,
    asked: Method,
    end: f64,
}

impl Stepper for Steps<'_> {
    fn step(&mut self) -> Result<(), String> {
        self.integrator.step(self.end).map_err(|error| error.to_string())
    }

    fn time(&self) -> f64 {
        self.integrator.time()
    }

    fn interpolate(&mut self, time: f64, state: &mut [f64]) -> Result<(), String> {
        self.integrator.interpolate(time, state);
        Ok(())
    }

    fn work(&self) -> Work {
        let statistics = self.integrator.statistics();
        Work {
            steps: statistics.steps,
            rejected: Some(statistics.rejected_steps),
            jacobians: Some(statistics.jacobian_evaluations),
            factorizations: Some(statistics.factorizations),
        }
    }

    fn ran(&self) -> Option<String> {
        let method = self.integrator.choice().method;
        (method != self.asked).then(|| method.name().into())
    }
}
