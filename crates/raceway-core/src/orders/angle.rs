//! Angle of the shaft over time. The speed profile is piecewise linear, so the angle is piecewise quadratic and exact.

use std::f64::consts::TAU;

use crate::physics::operation::SpeedProfile;

/// Angle and speed of a shaft that does not reverse, from the first recorded value on.
#[derive(Debug, Clone)]
pub struct ShaftAngle {
    profile: SpeedProfile,
    /// Time of the first value [s].
    from: f64,
    /// Time of the last value [s].
    to: f64,
    /// Angle at the first value [rad].
    first: f64,
    /// Sign of the speed.
    direction: f64,
}

impl ShaftAngle {
    /// The angle between two times [s]; `None` if the shaft reverses between them.
    pub fn new(profile: &SpeedProfile, from: f64, to: f64) -> Option<Self> {
        let corners = || corners(profile, from, to).map(|time| profile.at(time).1);
        let (forward, backward) = (corners().any(|speed| speed > 0.0), corners().any(|speed| speed < 0.0));
        let direction = if backward { -1.0 } else { 1.0 };
        let first = profile.at(from).0;
        (!(forward && backward)).then(|| Self { profile: profile.clone(), from, to, first, direction })
    }

    /// Sign of the speed; 1 at rest.
    pub fn direction(&self) -> f64 {
        self.direction
    }

    /// Turns since the first value.
    pub fn turns(&self, time: f64) -> f64 {
        self.direction * (self.profile.at(time).0 - self.first) / TAU
    }

    /// Magnitude of the speed [Hz].
    pub fn speed(&self, time: f64) -> f64 {
        self.direction * self.profile.at(time).1 / TAU
    }

    /// Turns between the first and the last value.
    pub fn total(&self) -> f64 {
        self.turns(self.to)
    }

    /// Least and greatest speed [Hz].
    pub fn speeds(&self) -> (f64, f64) {
        let speeds = corners(&self.profile, self.from, self.to).map(|time| self.speed(time));
        speeds.fold((f64::INFINITY, 0.0), |(least, most), speed| (least.min(speed), most.max(speed)))
    }

    /// Greatest magnitude of the change of speed [Hz/s].
    pub fn steepest(&self) -> f64 {
        let corners: Vec<f64> = corners(&self.profile, self.from, self.to).collect();
        let slope = |pair: &[f64]| (self.speed(pair[1]) - self.speed(pair[0])).abs() / (pair[1] - pair[0]);
        corners.windows(2).filter(|pair| pair[1] > pair[0]).map(slope).fold(0.0, f64::max)
    }

    /// Time between the first and the last value [s].
    pub fn duration(&self) -> f64 {
        self.to - self.from
    }
}

/// The two times and the corners of the profile between them [s].
fn corners(profile: &SpeedProfile, from: f64, to: f64) -> impl Iterator<Item = f64> {
    let between = profile.kinks().filter(move |time| (from..to).contains(time));
    std::iter::once(from).chain(between).chain(std::iter::once(to))
}
