//! Signals of a shaft whose speed varies: order spectra, order tracks and waterfalls. The shaft angle is known exactly and never
//! estimated. Signals pass through value by value, so that memory does not grow with their length. Knows no model and no JSON.
//!
//! An *order* counts periods in a turn of the reference, which is the shaft or the simulated cage.

pub mod settings;

pub mod angle;

pub mod rotations;

mod resample;

pub mod blocks;

pub mod track;

pub mod waterfall;

pub mod analysis;

#[cfg(test)]
mod tests;
