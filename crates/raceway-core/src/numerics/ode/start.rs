//! Integrators from their names.

use super::automatic::Automatic;
use super::dormand_prince::DormandPrince;
use super::fine_abm::{FineAbm, LinearPart};
use super::gear::Gear;
use super::integrator::Integrator;
use super::method::Method;
use super::radau::Radau;
use super::system::OdeSystem;
use super::tolerances::Tolerances;

impl Method {
    /// The integrator at its start. `fixed_step` [s]: only for methods that take fixed steps.
    pub fn start<'a, S: OdeSystem + ?Sized>(
        self,
        system: &'a S,
        time: f64,
        state: &[f64],
        tolerances: Tolerances,
        fixed_step: Option<f64>,
    ) -> Box<dyn Integrator + 'a> {
        match self {
            Self::Gear => Box::new(Gear::new(system, time, state, tolerances)),
            Self::Radau => Box::new(Radau::new(system, time, state, tolerances)),
            Self::FineAbm => Box::new(FineAbm::new(system, time, state, tolerances, fixed_step, LinearPart::Blocks)),
            Self::DormandPrince => Box::new(DormandPrince::new(system, time, state, tolerances, fixed_step)),
            Self::SemiImplicit => match fixed_step.and_then(|step| system.own_method(time, state, step)) {
                Some(own) => own,
                None => Self::Gear.start(system, time, state, tolerances, None),
            },
            Self::Auto => Box::new(Automatic::new(system, time, state, tolerances)),
        }
    }
}
