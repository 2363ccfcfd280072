//! A measured signal beside a prediction: its spectra with the window, resolution and averages of the prediction, and its lines by order.
//! Knows no model and no JSON.
//!
//! An *order* counts periods in a turn of the measured shaft.

pub mod tachometer;

pub mod record;

pub mod partners;

pub mod lines;

#[cfg(test)]
mod tests;
