//! Time series that a request asks for.

use crate::simulation::input::channel::Channel;

/// A signal at a uniform rate, in the channel's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub channel: Channel,
    /// Time of the first value since the start of the run [s].
    pub start: f64,
    /// Time between values [s].
    pub step: f64,
    pub values: Vec<f64>,
}
