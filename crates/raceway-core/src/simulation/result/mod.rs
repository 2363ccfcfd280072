//! What a run leaves behind: metrics, spectral lines, series, reports.

pub mod lines;
pub mod metrics;
pub mod run_result;
