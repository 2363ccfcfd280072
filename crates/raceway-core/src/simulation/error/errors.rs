//! Estimated errors of the numbers of a run.

use crate::simulation::input::channel::Channel;
use crate::simulation::recording::sampling::ACCELERATIONS;

/// Errors of the levels of the spindle accelerations x, y, z [dB]; `None`: unknown, or no level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LevelErrors(pub(crate) [Option<f64>; 3]);

impl LevelErrors {
    pub fn of(&self, channel: Channel) -> Option<f64> {
        self.0[ACCELERATIONS.iter().position(|one| *one == channel)?]
    }

    /// The largest level error [dB]; `None` if nothing moves.
    pub fn worst(&self) -> Option<f64> {
        self.0.into_iter().flatten().reduce(f64::max)
    }

    /// The channel with the largest level error.
    pub fn worst_channel(&self) -> Option<Channel> {
        let known = ACCELERATIONS.into_iter().zip(self.0).filter_map(|(channel, error)| Some((channel, error?)));
        known.max_by(|(_, one), (_, other)| one.total_cmp(other)).map(|(channel, _)| channel)
    }

    /// From the error of each channel.
    pub(crate) fn each(error: impl Fn(Channel) -> Option<f64>) -> Self {
        Self(ACCELERATIONS.map(error))
    }

    /// Combines the errors of each channel for which both are known.
    pub(crate) fn zip(&self, other: &Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| Some(of(self.0[i]?, other.0[i]?))))
    }

    /// The larger error of each channel.
    pub(crate) fn larger(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].into_iter().chain(other.0[i]).reduce(f64::max)))
    }

    /// Each known error, at least `least`.
    pub(crate) fn raised_to(self, least: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].map(|error| error.max(least.0[i].unwrap_or(0.0)))))
    }

    /// The channels whose error is larger than the other one.
    pub(crate) fn larger_than(&self, other: &Self) -> Vec<Channel> {
        ACCELERATIONS.into_iter().filter(|channel| self.of(*channel) > other.of(*channel)).collect()
    }

    /// Applies a function to each known error.
    pub(crate) fn map(self, change: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(|error| error.map(&change)))
    }
}

/// Estimated errors of single numbers, as shares of them [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantityErrors {
    pub max_load: f64,
    pub cage_speed: f64,
    pub max_pocket_load: f64,
    /// The larger one of both raceways.
    pub max_slip: f64,
    /// Error of the orbit of the cage centre about its mean position.
    pub orbit_radius: f64,
    /// Error of the slip of the cage itself, which is a share already.
    pub cage_slip: f64,
}

impl QuantityErrors {
    /// The larger error of each number.
    pub(crate) fn larger(&self, other: &Self) -> Self {
        Self {
            max_load: self.max_load.max(other.max_load),
            cage_speed: self.cage_speed.max(other.cage_speed),
            max_pocket_load: self.max_pocket_load.max(other.max_pocket_load),
            max_slip: self.max_slip.max(other.max_slip),
            orbit_radius: self.orbit_radius.max(other.orbit_radius),
            cage_slip: self.cage_slip.max(other.cage_slip),
        }
    }

    /// Each error times a factor.
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self {
            max_load: factor * self.max_load,
            cage_speed: factor * self.cage_speed,
            max_pocket_load: factor * self.max_pocket_load,
            max_slip: factor * self.max_slip,
            orbit_radius: factor * self.orbit_radius,
            cage_slip: factor * self.cage_slip,
        }
    }
}
