//! The motion of rolling bearings: geometry, contacts, integrators, reduced models and the error of each result.
//! Knows no JSON, no HTTP, no SQL and no thread pool.

/// Mathematics: integrators, spectra, special functions. Knows no bearing.
pub mod numerics;
/// The bearing: contacts, bodies, forces. Knows no clock and no JSON.
pub mod physics;
/// The motion: scene, model, equilibrium, run, recording.
pub mod simulation;
/// Many runs: the points of a grid, and trends and optima over them.
pub mod study;
