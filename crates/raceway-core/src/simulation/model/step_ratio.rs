//! Step lengths of the reduced models: whole fractions and multiples of the interval between kept values.

use crate::numerics::interpolation::Interpolator;
use crate::numerics::spectrum::Decimator;
use crate::simulation::recording::sampling::{RATE, SPINDLE_IN_PLANE};

/// Steps to a value beyond which the full dynamics are no slower.
pub const MOST_STEPS: usize = 64;

/// How long a step is: so many steps take as long as so many intervals of the kept values, 1/102 400 s. Either there is one interval,
/// or there are fewer steps than intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepRatio {
    pub steps: usize,
    pub values: usize,
}

impl StepRatio {
    /// Steps longer than an interval: 24.4, 22.0, 19.5, 17.1, 14.6 and 12.2 µs.
    pub const LONG: [Self; 6] =
        [Self::over(2, 5), Self::over(4, 9), Self::over(1, 2), Self::over(4, 7), Self::over(2, 3), Self::over(4, 5)];

    /// That many steps to a value: 9.8 µs, 4.9 µs, …
    pub const fn of_steps(steps: usize) -> Self {
        Self::over(steps, 1)
    }

    const fn over(steps: usize, values: usize) -> Self {
        Self { steps, values }
    }

    /// The longest step not longer than this [s].
    pub fn of(longest: f64) -> Self {
        // A hair's breadth: the step of a ratio, taken for the longest one, is that ratio.
        let longest = longest * (1.0 + 1e-9);
        let finer = || Self::of_steps((1.0 / (RATE * longest)).ceil().max(1.0) as usize);
        Self::LONG.into_iter().find(|ratio| ratio.step() <= longest).unwrap_or_else(finer)
    }

    /// [s]
    pub fn step(self) -> f64 {
        self.values as f64 / (RATE * self.steps as f64)
    }

    /// Whether kept values lie between steps.
    pub fn is_long(self) -> bool {
        self.values > 1
    }

    /// Steps by which the spindle's signals are known later than others.
    pub(crate) fn delay(self) -> usize {
        if self.is_long() {
            Interpolator::<{ SPINDLE_IN_PLANE.len() }>::DELAY
        } else {
            Decimator::new(self.steps, 1).delay()
        }
    }
}
