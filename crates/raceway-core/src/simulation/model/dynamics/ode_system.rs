//! The dynamics as a system of ordinary differential equations, with its Jacobian and its own integrator.

use super::equations::Dynamics;
use super::semi_implicit::SemiImplicit;
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::numerics::ode::{Integrator, OdeSystem};

impl<const PLANAR: bool> OdeSystem for Dynamics<PLANAR> {
    fn dimension(&self) -> usize {
        self.mechanism().layout.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.evaluate(time, state, derivative, None);
    }

    fn structure(&self) -> Structure {
        self.mechanism().layout.structure()
    }

    fn own_method<'a>(&'a self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 'a>> {
        Some(Box::new(SemiImplicit::new(self, time, state, step)))
    }

    fn jacobian(&self, time: f64, state: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        self.differences(time, state, jacobian)
    }
}
