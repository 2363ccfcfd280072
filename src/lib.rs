//! raceway predicts the vibration of rolling bearings.
//!
//! A request becomes a checked *scene*; the scene becomes a *model* that holds only what it needs; an integrator advances it; the
//! observed motion becomes the result.

/// The HTTP service.
pub mod api;
/// The figures of the article, reproduced and compared with it.
pub mod article;
/// The commands of the program.
pub mod commands;
/// Settings from command line and environment.
pub mod config;
/// JSON in and out: units in field names, one conversion each way.
pub mod contract;
/// Queue and store of jobs.
pub mod jobs;
/// Plots from numbers.
pub mod plots;

pub use raceway_core::{numerics, physics, simulation, study};
