//! Sensors on the shaft and on parts of the housing.

/// A sensor, which measures along one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    pub name: String,
    pub on: Part,
    /// What its displacement is measured from at the same place; `None`: the ground.
    pub relative_to: Option<Part>,
    /// Place along the shaft [m].
    pub at: f64,
    /// Direction: 0 along X, 1 along Y, 2 along Z.
    pub axis: usize,
}

/// What a sensor sits on, or measures from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Shaft,
    /// A part of the housing, by its number.
    Housing(usize),
}

impl Sensor {
    /// Whether it measures the shaft, or from it.
    pub fn concerns_shaft(&self) -> bool {
        self.on == Part::Shaft || self.relative_to == Some(Part::Shaft)
    }
}
