//! What is kept of a motion: sampled signals, windows, extremes, data of plots. Below every model.

pub mod load_course;
pub mod plot_data;
pub mod record;
pub mod sampling;
pub mod spectra;
pub mod windows;
