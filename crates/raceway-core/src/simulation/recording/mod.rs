//! What is kept of a motion: sampled signals, windows, extremes, data of plots. Below every model.

pub mod plot_data;
pub mod windows;
