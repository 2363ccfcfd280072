//! The result of a run: metrics, spectral lines, series and spectra in the units of the answer. Knows no integrator.

pub mod series;

pub mod lines;

pub mod envelope_harmonics;

pub mod metrics;

pub mod run_result;
