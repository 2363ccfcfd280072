//! The load zone: azimuths at which the inner raceway presses a ball in the static equilibrium on ideal raceways.

use std::f64::consts::TAU;

/// Load zone of a bearing, by azimuth from +Y towards +Z.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LoadZone {
    /// Whether a ball is pressed, at evenly spaced azimuths.
    pressed: Vec<bool>,
}

impl LoadZone {
    pub(crate) fn new(pressed: Vec<bool>) -> Self {
        Self { pressed }
    }

    /// Returns whether the azimuth [rad] lies in the zone.
    pub(crate) fn contains(&self, azimuth: f64) -> bool {
        let places = self.pressed.len();
        let turns = azimuth / TAU;
        let place = (turns - turns.floor()) * places as f64;
        self.pressed[(place.round() as usize) % places]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuths_of_any_turn_lie_in_the_zone_or_not() {
        let zone = LoadZone::new((0..8).map(|place| place <= 1 || place == 7).collect());
        for turn in [-2.0, 0.0, 5.0] {
            let at = |degrees: f64| zone.contains((degrees + 360.0 * turn).to_radians());
            assert!(at(0.0) && at(60.0) && at(-60.0) && at(359.0), "{turn}");
            assert!(!at(70.0) && !at(180.0) && !at(-70.0), "{turn}");
        }
    }
}
