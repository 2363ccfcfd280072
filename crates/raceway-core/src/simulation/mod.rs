//! The motion: a checked scene becomes a model that holds only what it needs, an integrator advances
//! it from equilibrium, and what was asked for is recorded. Plain synchronous Rust; knows no JSON, HTTP or SQL.

pub mod input;
pub mod recording;
pub mod model;
pub mod error;
pub mod solve;
pub mod result;
pub mod work_precision;
