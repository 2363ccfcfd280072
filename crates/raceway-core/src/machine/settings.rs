//! Accuracy, times and kept signals of a run.

use super::channel::MachineChannel;
use crate::numerics::spectrum::EnvelopeAnalysis;

/// Accuracy, times and kept signals of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineSettings {
    /// Time before the record [s]; `None`: until the slowest motion of the linear analysis has decayed to a fiftieth, and three turns of the
    /// slowest cage.
    pub settle: Option<f64>,
    /// Recorded time [s].
    pub duration: f64,
    /// Step [s]; `None`: the longest of the bearings.
    pub step: Option<f64>,
    /// Highest frequency of the kept free modes over the band of the levels [-].
    pub range: f64,
    /// Signals whose values are kept.
    pub series: Vec<MachineChannel>,
    pub envelope: EnvelopeAnalysis,
    /// Rising edges of the bands in which accelerations are summed [Hz].
    pub band_edges: Vec<f64>,
}

/// Highest frequency of the kept free modes over the band of the levels [-]. With the static answers of the rest, levels are then within
/// 0.003 dB of those of modes up to five times the band (docs/explanation/machine.md).
pub const RANGE: f64 = 1.5;
