//! Loads of the first ball along its way.

use crate::simulation::recording::sampling::RATE;

/// Places of a ball at which its loads are kept, and turns of it that they can show.
const MOST_PLACES: usize = 600;
const BALL_TURNS: f64 = 3.0;

/// Loads of the first ball along its way.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadsAlong {
    /// From Y towards Z, 0 to 2π [rad].
    pub azimuth: Vec<f64>,
    /// [N]
    pub inner: Vec<f64>,
    /// [N]
    pub outer: Vec<f64>,
}

/// Takes the loads of the first ball ever so many kept values.
#[derive(Debug, Clone)]
pub struct LoadsTaken {
    every: usize,
    seen: usize,
    loads: LoadsAlong,
}

impl LoadsTaken {
    /// Of a run that keeps so many values, ours among them as far as one window goes; of a steady one, whose balls go round at `orbit_speed`
    /// [rad/s], the first turns.
    pub fn new(values: usize, orbit_speed: Option<f64>) -> Self {
        let window = stretch(values.min(RATE as usize), BALL_TURNS, orbit_speed);
        Self { every: window.div_ceil(MOST_PLACES).max(1), seen: 0, loads: LoadsAlong::default() }
    }

    /// Shows a kept value: azimuth [rad], inner and outer load [N].
    pub fn look(&mut self, at: impl FnOnce() -> (f64, f64, f64)) {
        if self.seen.is_multiple_of(self.every) && self.loads.azimuth.len() < MOST_PLACES {
            let (azimuth, inner, outer) = at();
            self.loads.azimuth.push(azimuth.rem_euclid(std::f64::consts::TAU));
            self.loads.inner.push(inner);
            self.loads.outer.push(outer);
        }
        self.seen += 1;
    }

    pub fn finish(self) -> LoadsAlong {
        self.loads
    }
}

/// Values that so many turns at a speed [rad/s] take, of those that there are; without a speed, and at rest, all.
pub(crate) fn stretch(values: usize, turns: f64, speed: Option<f64>) -> usize {
    let of_turns = |speed: f64| turns * std::f64::consts::TAU * RATE / speed.abs().max(f64::MIN_POSITIVE);
    speed.map_or(values, |speed| of_turns(speed).min(values as f64) as usize)
}
