//! Loads of the first ball over its azimuth, for a plot.

use crate::simulation::recording::sampling::RATE;

/// Largest number of azimuths at which the loads are kept.
const MAX_PLACES: usize = 600;
/// Turns of the ball that one plot can show.
const BALL_TURNS: f64 = 3.0;

/// Loads of the first ball over its azimuth.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BallLoadCourse {
    /// Azimuth from Y towards Z, 0 to 2π [rad].
    pub azimuth: Vec<f64>,
    /// Load on the inner raceway [N].
    pub inner: Vec<f64>,
    /// Load on the outer raceway [N].
    pub outer: Vec<f64>,
}

/// Recorder that keeps the loads of the first ball at a fixed number of recorded values.
#[derive(Debug, Clone)]
pub(crate) struct BallLoadRecorder {
    every: usize,
    offered: usize,
    loads: BallLoadCourse,
}

impl BallLoadRecorder {
    /// Recorder for the first window of a run with that many recorded values. A steady run, whose balls orbit at `orbit_speed`
    /// [rad/s], keeps the first turns only.
    pub(crate) fn new(values: usize, orbit_speed: Option<f64>) -> Self {
        let window = values_in_turns(values.min(RATE as usize), BALL_TURNS, orbit_speed);
        Self { every: window.div_ceil(MAX_PLACES).max(1), offered: 0, loads: BallLoadCourse::default() }
    }

    /// Offers a recorded value: azimuth [rad], inner and outer load [N].
    pub(crate) fn offer(&mut self, at: impl FnOnce() -> (f64, f64, f64)) {
        if self.offered.is_multiple_of(self.every) && self.loads.azimuth.len() < MAX_PLACES {
            let (azimuth, inner, outer) = at();
            self.loads.azimuth.push(azimuth.rem_euclid(std::f64::consts::TAU));
            self.loads.inner.push(inner);
            self.loads.outer.push(outer);
        }
        self.offered += 1;
    }

    pub(crate) fn finish(self) -> BallLoadCourse {
        self.loads
    }
}

/// Number of recorded values in `turns` turns at a speed [rad/s], at most `values`; `values` at rest or without a speed.
pub(crate) fn values_in_turns(values: usize, turns: f64, speed: Option<f64>) -> usize {
    let of_turns = |speed: f64| turns * std::f64::consts::TAU * RATE / speed.abs().max(f64::MIN_POSITIVE);
    speed.map_or(values, |speed| of_turns(speed).min(values as f64) as usize)
}
