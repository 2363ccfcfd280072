//! Simulation of the motion. A validated scene becomes a model with the required terms only. An integrator advances it from equilibrium, and the
//! requested outputs are recorded. Plain synchronous Rust; independent of JSON, HTTP and SQL.

pub mod error;
pub mod input;
pub mod model;
pub mod recording;
pub mod result;
pub mod solve;
pub mod work_precision;
