//! The recording of a motion: sampled signals, their windows and spectra, extremes, data of plots. Knows no model and no error.

pub mod bands;

pub mod sampling;

pub mod spectra;

pub(crate) mod series;

pub mod windows;

pub(crate) mod load_course;

pub(crate) mod loaded_rolling;

pub mod off_raceway;

pub mod power_balance;

pub mod defect_passages;

pub mod ball_tracks;

pub mod record;

pub mod plot_data;
