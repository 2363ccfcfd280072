//! How two runs of a scene are compared, and what that says of the error of each number. Knows no plan and no candidate.

pub mod codes;
pub mod thresholds;

pub mod errors;

pub mod comparison;

pub(crate) mod convergence;

pub mod stationarity;

pub mod lyapunov;
pub mod twin_system;

pub mod report;
