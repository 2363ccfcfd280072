//! The equations of motion of a scene: full or planar dynamics.

use crate::numerics::lanes::InstructionSet;
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::numerics::ode::{Integrator, OdeSystem};
use crate::simulation::input::model_level::ModelLevel;
use crate::simulation::input::scene::Scene;
use crate::simulation::model::dynamics::{Full, Planar, Watch};
use crate::simulation::model::fading_damping::FadingDamping;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::surfaces;
use crate::simulation::model::terms::ActiveTerms;

/// The equations of motion of a scene, full or planar.
#[derive(Debug, Clone)]
pub enum Model {
    Full(Full),
    Planar(Planar),
}

impl Model {
    /// The model of a scene, at the level of its active terms.
    pub fn new(scene: &Scene, needs: &ActiveTerms) -> Self {
        let mechanism = surfaces::with_surfaces(Mechanism::new(scene, needs), scene);
        match needs.rung {
            ModelLevel::Full => Self::Full(Full::new(mechanism)),
            // Reduced levels have their own models. If such a level also needs the dynamics, the planar ones are used.
            _ => Self::Planar(Planar::new(mechanism)),
        }
    }

    pub fn mechanism(&self) -> &Mechanism {
        match self {
            Self::Full(model) => model.mechanism(),
            Self::Planar(model) => model.mechanism(),
        }
    }

    /// The model with additional damping that fades.
    pub(crate) fn damped(&self, damping: FadingDamping) -> Self {
        self.of(Mechanism { damping: Some(damping), ..self.mechanism().clone() })
    }

    /// The same equations with other constants.
    fn of(&self, mechanism: Mechanism) -> Self {
        match self {
            Self::Full(_) => Self::Full(Full::new(mechanism)),
            Self::Planar(_) => Self::Planar(Planar::new(mechanism)),
        }
    }

    /// The model without contacts between balls, to tell their effect.
    pub fn without_neighbours(&self) -> Self {
        self.of(Mechanism { neighbours: None, ..self.mechanism().clone() })
    }

    /// Writes `dy/dt` as `OdeSystem::derivative` does, and passes each load to `watch`.
    pub fn derivative_watched(&self, time: f64, state: &[f64], derivative: &mut [f64], watch: &mut impl Watch) {
        match self {
            Self::Full(model) => model.evaluate(time, state, derivative, Some(watch)),
            Self::Planar(model) => model.evaluate(time, state, derivative, Some(watch)),
        }
    }

    /// The model with other vector instructions of the same processor; its rates have the same bits.
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        match self {
            Self::Full(model) => Self::Full(model.with_instructions(instructions)),
            Self::Planar(model) => Self::Planar(model.with_instructions(instructions)),
        }
    }
}

impl OdeSystem for Model {
    fn dimension(&self) -> usize {
        self.mechanism().layout.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        match self {
            Self::Full(model) => model.derivative(time, state, derivative),
            Self::Planar(model) => model.derivative(time, state, derivative),
        }
    }

    fn structure(&self) -> Structure {
        match self {
            Self::Full(model) => model.structure(),
            Self::Planar(model) => model.structure(),
        }
    }

    fn own_method<'a>(&'a self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 'a>> {
        match self {
            Self::Full(model) => model.own_method(time, state, step),
            Self::Planar(model) => model.own_method(time, state, step),
        }
    }

    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        match self {
            Self::Full(model) => model.jacobian(time, state, rate, displacement, jacobian),
            Self::Planar(model) => model.jacobian(time, state, rate, displacement, jacobian),
        }
    }
}
