//! Ordinary differential equations `dy/dt = f(t, y)`: what an integrator needs to know of a system,
//! what it reports, and how it fails. One method a file; none knows what a bearing is.

mod integrator;
mod method;
pub mod stability;
pub mod structure;
mod system;
mod tolerances;

pub mod phi;
pub mod step_size;

pub mod adams;
pub mod adams_moulton;
pub mod arrowhead;
pub mod automatic;
pub mod dormand_prince;
pub mod fine_abm;
pub mod gear;
pub mod radau;
mod start;
#[cfg(test)]
mod test_problems;

pub use integrator::{Choice, IntegrationError, Integrator, Statistics};
pub use method::Method;
pub use system::{OdeSystem, dense_differences};
pub use tolerances::Tolerances;
