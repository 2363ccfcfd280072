//! Ordinary differential equations `dy/dt = f(t, y)`: the interface of systems and integrators, and one method a file.
//! Knows no bearing.

mod integrator;
mod method;
pub mod stability;
pub mod structure;
mod system;
mod tolerances;

pub(crate) mod phi;
pub(crate) mod step_size;

pub(crate) mod adams;
pub(crate) mod adams_moulton;
pub mod arrowhead;
pub(crate) mod automatic;
pub mod dormand_prince;
pub mod fine_abm;
pub(crate) mod gear;
pub(crate) mod radau;
mod start;
#[cfg(test)]
mod test_problems;

pub use integrator::{Choice, ChoiceReason, IntegrationError, Integrator, Statistics};
pub use method::Method;
pub use system::{OdeSystem, dense_differences};
pub use tolerances::Tolerances;
