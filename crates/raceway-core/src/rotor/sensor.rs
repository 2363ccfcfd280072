//! Sensors on the shaft and on parts of the housing.

/// A sensor, which measures along one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    pub name: String,
    pub on: Part,
    /// Reference of its displacement at the same place; `None`: the ground.
    pub relative_to: Option<Part>,
    /// Place along the shaft [m].
    pub at: f64,
    /// Direction along X, Y, Z, of length 1.
    pub along: [f64; 3],
}

/// A part on which a sensor sits, or from which it measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Shaft,
    /// A part of the housing, by its number.
    Housing(usize),
}

impl Sensor {
    /// Its reading of a motion of its place: along X, Y, Z, and about Y and Z, which it does not measure.
    pub fn reading(&self, [x, y, z, ..]: [f64; 5]) -> f64 {
        let [along_x, along_y, along_z] = self.along;
        along_x * x + along_y * y + along_z * z
    }

    /// True if it measures a part of the housing, or from one.
    pub fn concerns_housing(&self) -> bool {
        [Some(self.on), self.relative_to].into_iter().flatten().any(|part| part != Part::Shaft)
    }

    /// True if it measures the shaft, or from it.
    pub fn concerns_shaft(&self) -> bool {
        self.on == Part::Shaft || self.relative_to == Some(Part::Shaft)
    }
}
