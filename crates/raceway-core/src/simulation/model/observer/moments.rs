//! Running means and variances of observed values.

use crate::simulation::recording::loaded_rolling::LoadedRolling;

/// Mean and variance of a growing sample, summed about its first value.
#[derive(Clone, Copy, Default)]
pub(super) struct Moments {
    count: f64,
    origin: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    pub(super) fn add(&mut self, value: f64) {
        if self.count == 0.0 {
            self.origin = value;
        }
        self.count += 1.0;
        let off = value - self.origin;
        self.sum += off;
        self.squares += off * off;
    }

    pub(super) fn mean(&self) -> f64 {
        self.origin + self.sum / self.count.max(1.0)
    }

    pub(super) fn variance(&self) -> f64 {
        let count = self.count.max(1.0);
        ((self.squares - self.sum * self.sum / count) / count).max(0.0)
    }
}

/// Moments of speed [rad/s] and place [m] of the cage over a part of a run, and its references.
#[derive(Clone, Copy, Default)]
pub(super) struct CageMoments {
    pub speed: Moments,
    /// Speed of the shaft [rad/s].
    pub shaft: Moments,
    pub outer_ring: Moments,
    pub rolling: LoadedRolling,
    pub y: Moments,
    pub z: Moments,
}
