//! Mathematics that knows no bearing: special functions, spectra, statistics, integrators.
//! Imports none of the other rooms.

pub mod angle;
pub mod elliptic;
pub mod exponential;
pub mod interpolation;
pub mod lanes;
pub mod ode;
pub mod parallel;
pub mod periodic;
pub mod roots;
pub mod rounding;
pub mod spectrum;
pub mod statistics;
