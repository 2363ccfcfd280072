//! The result of a run: metrics, spectral lines, series and spectra in the units of the answer. Knows no integrator.

pub mod series;

mod line_combinations;
pub(crate) mod line_label;
pub(crate) mod line_sources;
pub mod lines;
pub(crate) mod peaks;

#[cfg(test)]
mod line_examples;

pub mod envelope_harmonics;

pub mod metrics;

pub mod run_result;
