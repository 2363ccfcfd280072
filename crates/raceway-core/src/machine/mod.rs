//! A flexible shaft on ball bearings in time: the balls and the cage of each bearing with all their forces, the shaft by its modes.
//!
//! A bearing knows the motion of its inner ring and returns its load; it knows no shaft. The shaft knows forces at ports. Knows no JSON and
//! no thread.

pub mod channel;
pub mod codes;
pub mod cost;
pub mod inapplicable;
pub mod input;
pub mod result;
pub mod run;
pub mod simulate;
pub mod terms;

pub mod mode_precision;
pub mod settings;

pub mod bearing;
pub mod equations;
pub mod frame;
pub mod level;
pub mod padded;
pub mod start;

mod confirmation;
mod growth;
mod omission;

pub(crate) mod bearing_stepper;
mod port;
pub(crate) mod propagator;
mod reduced_stepper;
pub(crate) mod resolution;
mod speed_steps;
mod stability;
pub(crate) mod stepping;

pub mod recording;

mod warnings;

#[cfg(test)]
mod tests;
