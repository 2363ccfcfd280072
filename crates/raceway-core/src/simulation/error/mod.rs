//! Comparison of two runs of a scene, and the resulting error of each number. Independent of plans and candidates.

pub mod codes;
pub mod comparison;
pub mod errors;
pub mod lyapunov;
pub mod report;
pub mod stationarity;
pub mod thresholds;
pub mod twin_system;
