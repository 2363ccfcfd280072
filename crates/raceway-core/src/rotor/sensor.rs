//! Sensors on the shaft and on bodies of the housing.

use nalgebra::DVector;

use super::coordinates::Coordinates;

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
    /// A body, by its number.
    Body(usize),
}

impl Sensor {
    /// Its reading by each coordinate [m].
    pub fn row(&self, coordinates: &Coordinates) -> DVector<f64> {
        let own = self.of_part(self.on, coordinates);
        match self.relative_to {
            None => own,
            Some(other) => own - self.of_part(other, coordinates),
        }
    }

    fn of_part(&self, part: Part, coordinates: &Coordinates) -> DVector<f64> {
        match part {
            // Forces and displacements of a place are the same shares of the coordinates.
            Part::Shaft => {
                let mut unit = [0.0; 3];
                unit[self.axis] = 1.0;
                DVector::from_vec(coordinates.force(self.at, unit))
            }
            Part::Body(body) => coordinates.housing.body(Some(body), self.at).row(self.axis).transpose(),
        }
    }

    /// Whether it measures the shaft, or from it.
    pub fn concerns_shaft(&self) -> bool {
        self.on == Part::Shaft || self.relative_to == Some(Part::Shaft)
    }
}
