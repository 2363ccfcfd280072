//! The motion: a checked scene becomes a model that holds only what it needs, an integrator advances
//! it from equilibrium, and what was asked for is recorded. Plain synchronous Rust; knows no JSON, HTTP or SQL.

pub mod error;
pub mod input;
pub mod model;
pub mod recording;
pub mod result;
pub mod solve;
pub mod work_precision;
