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
    /// Direction along X, Y, Z, of length 1.
    pub along: [f64; 3],
}

/// What a sensor sits on, or measures from.
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

    /// Whether it measures a part of the housing, or from one.
    pub fn concerns_housing(&self) -> bool {
        [Some(self.on), self.relative_to].into_iter().flatten().any(|part| part != Part::Shaft)
    }

    /// Whether it measures the shaft, or from it.
    pub fn concerns_shaft(&self) -> bool {
        self.on == Part::Shaft || self.relative_to == Some(Part::Shaft)
    }
}
