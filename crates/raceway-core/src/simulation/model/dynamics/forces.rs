//! Forces and moments on one ball, and what balls exert on cage and spindle.

use crate::numerics::lanes::{LANES, Lanes, SideBySide, side_by_side};
use crate::physics::frames::{Vector, add, subtract};

/// Force and moment on a ball, in its orbit frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Wrench<T = f64> {
    pub force: Vector<T>,
    pub moment: Vector<T>,
}
side_by_side!(Wrench { force, moment });

impl Wrench {
    /// The sum.
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self { force: add(self.force, other.force), moment: add(self.moment, other.moment) }
    }

    /// The difference.
    #[inline(always)]
    pub(crate) fn less(self, other: &Self) -> Self {
        Self { force: subtract(self.force, other.force), moment: subtract(self.moment, other.moment) }
    }
}

/// Forces and moments that one ball exerts, or all of them together.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Reaction<T = f64> {
    /// Force on the spindle, inertial frame [N].
    pub spindle: Vector<T>,
    /// Force on the cage, in its tilted frame [N].
    pub cage_force: Vector<T>,
    /// Moment on the cage about its centre of mass, in its tilted frame [N m].
    pub cage_moment: Vector<T>,
}
side_by_side!(Reaction { spindle, cage_force, cage_moment });

impl Reaction {
    /// The difference.
    #[inline(always)]
    pub(crate) fn less(&self, other: &Self) -> Self {
        Self {
            spindle: subtract(self.spindle, other.spindle),
            cage_force: subtract(self.cage_force, other.cage_force),
            cage_moment: subtract(self.cage_moment, other.cage_moment),
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.spindle = add(self.spindle, other.spindle);
        self.cage_force = add(self.cage_force, other.cage_force);
        self.cage_moment = add(self.cage_moment, other.cage_moment);
    }
}

impl Reaction<Lanes> {
    /// Adds the first `balls` lanes to `sum`, one ball after the other.
    #[inline(always)]
    pub(super) fn sum_into(&self, sum: &mut Reaction, balls: usize) {
        for lane in 0..LANES.min(balls) {
            sum.add(&self.at(lane));
        }
    }
}
