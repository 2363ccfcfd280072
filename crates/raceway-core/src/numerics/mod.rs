//! Mathematics that knows no bearing: special functions, spectra, statistics, integrators.
//! Imports none of the other rooms.

pub(crate) mod angle;
pub(crate) mod banded;
pub(crate) mod bordered;
pub mod build;
pub(crate) mod decimation;
pub(crate) mod dense;
pub mod elliptic;
pub(crate) mod exponential;
pub(crate) mod interpolation;
pub mod lanes;
pub(crate) mod minimum;
pub mod ode;
pub mod parallel;
pub(crate) mod periodic;
pub(crate) mod quadratic_eigen;
pub(crate) mod random;
pub(crate) mod resampling;
pub mod roots;
pub mod rounding;
pub(crate) mod special;
pub mod spectrum;
pub mod statistics;
pub(crate) mod transfer;
