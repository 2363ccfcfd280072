//! Step lengths of the reduced models: whole fractions and multiples of the interval between kept values.

use crate::numerics::decimation::Decimator;
use crate::numerics::interpolation::Interpolator;
use crate::simulation::recording::sampling::{RATE, SPINDLE_IN_PLANE};

/// Largest number of steps per recorded value: with more, the full dynamics are no slower.
pub(crate) const MAX_STEPS_PER_VALUE: usize = 64;

/// Length of a step as a ratio: `steps` steps take as long as `values` intervals of recorded values, 1/102 400 s each. Either there is
/// one interval, or there are fewer steps than intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepRatio {
    pub steps: usize,
    pub values: usize,
}

impl StepRatio {
    /// Steps longer than an interval: 24.4, 22.0, 19.5, 17.1, 14.6 and 12.2 µs.
    pub const LONG: [Self; 6] =
        [Self::over(2, 5), Self::over(4, 9), Self::over(1, 2), Self::over(4, 7), Self::over(2, 3), Self::over(4, 5)];

    /// A number of steps per recorded value: 9.8 µs, 4.9 µs, …
    pub const fn of_steps(steps: usize) -> Self {
        Self::over(steps, 1)
    }

    const fn over(steps: usize, values: usize) -> Self {
        Self { steps, values }
    }

    /// The longest step not longer than this [s].
    pub fn of(longest: f64) -> Self {
        // The margin covers rounding, so that the step of a ratio gives that ratio.
        let longest = longest * (1.0 + 1e-9);
        let finer = || Self::of_steps((1.0 / (RATE * longest)).ceil().max(1.0) as usize);
        Self::LONG.into_iter().find(|ratio| ratio.step() <= longest).unwrap_or_else(finer)
    }

    /// Length of a step [s].
    pub fn step(self) -> f64 {
        self.values as f64 / (RATE * self.steps as f64)
    }

    /// Returns whether a step is longer than the interval of recorded values, so that values lie between steps.
    pub(crate) fn is_long(self) -> bool {
        self.values > 1
    }

    /// Delay of the spindle's signals by filter or interpolation, in steps.
    pub(crate) fn delay(self) -> usize {
        if self.is_long() {
            Interpolator::<{ SPINDLE_IN_PLANE.len() }>::DELAY
        } else {
            Decimator::new(self.steps, 1).delay()
        }
    }
}
