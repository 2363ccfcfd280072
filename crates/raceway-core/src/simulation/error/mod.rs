//! How two runs of a scene are compared, and what that says of the error of each number.

pub mod comparison;
pub mod estimate;
pub mod lyapunov;
pub mod report;
pub mod stationarity;
pub mod twin_system;
