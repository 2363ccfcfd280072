//! Time series that a request asks for.

use crate::simulation::input::channel::Channel;

/// A signal at a uniform rate.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Number in the order of the request.
    pub number: usize,
    pub channel: Channel,
    /// Time of the first value since the start of the run [s].
    pub start: f64,
    /// Time between values [s].
    pub step: f64,
    /// Number of values.
    pub length: usize,
    /// True if all values are finite.
    pub is_finite: bool,
    /// The values, in the channel's unit; empty if a receiver has taken them.
    pub values: Vec<f64>,
}
