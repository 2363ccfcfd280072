//! Exact steps of shaft and housing at the present speed.
//!
//! While the speed changes, a step is the mean of those at the two nearest speeds of a grid, each with its share. Gyroscopic moments do no work:
//! steps at all speeds leave or reduce the same energy, and so does their mean. A grid that is too coarse adds damping, never growth.

use super::frame::Frame;
use super::propagator::ExactStep;
use crate::physics::operation::SpeedProfile;

/// Parts of the range of a speed. In the middle of one a step of length h damps by (g ΔΩ/2)² h/2, g: polar over transverse inertia. That is 0.03/s
/// for a thin disc run up to 30 000 r/min in steps of 5.5 µs.
const PARTS: f64 = 32.0;
/// Steps that are kept: short and full ones at two speeds.
const KEPT: usize = 4;
/// Change of a step that is rounding of the times at its ends [-].
const ROUNDING: f64 = 1e-11;

/// Exact steps at the speeds around the present one, of the last lengths.
pub(super) struct SpeedSteps {
    /// Lowest speed and distance of the grid [rad/s]; no distance: one speed only.
    lowest: f64,
    distance: f64,
    /// Part of the grid in which the speed was last.
    part: f64,
    known: Vec<Known>,
}

struct Known {
    speed: f64,
    length: f64,
    step: ExactStep,
}

impl SpeedSteps {
    /// `depends`: whether steps depend on the speed.
    pub(super) fn new(speed: &SpeedProfile, depends: bool) -> Self {
        let speeds = || speed.points().iter().map(|point| point.1);
        let lowest = speeds().fold(f64::INFINITY, f64::min);
        let range = if depends { speeds().fold(0.0, |range, speed| f64::max(range, speed - lowest)) } else { 0.0 };
        Self { lowest, distance: range / PARTS, part: 0.0, known: Vec::new() }
    }

    /// Shares of the steps around a speed [rad/s]; `None` where others are needed than for the speed before.
    pub(super) fn shares(&self, speed: f64) -> Option<[f64; 2]> {
        if self.distance == 0.0 {
            return Some([1.0, 0.0]);
        }
        let share = (speed - self.lowest) / self.distance - self.part;
        // At the ends of the grid a speed may lie beyond by rounding.
        let is_inside = (0.0..=1.0).contains(&share) || self.part == part(share + self.part);
        is_inside.then_some([1.0 - share, share])
    }

    /// Steps around a speed [rad/s], with their shares.
    pub(super) fn around(&mut self, frame: &Frame, speed: f64, length: f64) -> Vec<(f64, &ExactStep)> {
        let mut speeds = vec![(1.0, self.lowest)];
        if self.distance > 0.0 {
            self.part = part((speed - self.lowest) / self.distance);
            let at = |part: f64| self.lowest + part * self.distance;
            let share = (speed - at(self.part)) / self.distance;
            speeds = vec![(1.0 - share, at(self.part)), (share, at(self.part + 1.0))];
        }
        // The one that is used moves to the front.
        for (_, speed) in &speeds {
            let known = self.known.iter().position(|known| known.is(*speed, length)).map(|at| self.known.remove(at));
            let new = || Known { speed: *speed, length, step: ExactStep::of(frame, *speed, length) };
            self.known.insert(0, known.unwrap_or_else(new));
        }
        self.known.truncate(KEPT);
        speeds.iter().rev().zip(&self.known).map(|((share, _), known)| (*share, &known.step)).rev().collect()
    }
}

/// Part of the grid at a place in it.
fn part(place: f64) -> f64 {
    place.floor().clamp(0.0, PARTS - 1.0)
}

impl Known {
    fn is(&self, speed: f64, length: f64) -> bool {
        self.speed == speed && (self.length - length).abs() <= ROUNDING * length
    }
}
