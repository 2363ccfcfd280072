//! Spindle and cage of the radially condensed model, in the plane.

/// Places [m] and velocities [m/s] of spindle and cage, (y, z).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Border<T = f64> {
    pub spindle: [T; 2],
    pub spindle_velocity: [T; 2],
    pub cage: [T; 2],
    pub cage_arc: T,
    /// Velocity of the cage: y, z, along the arc [m/s].
    pub cage_velocity: [T; 3],
}

impl Border {
    /// The border in single precision, for the balls.
    #[inline(always)]
    pub(super) fn single(&self) -> Border<f32> {
        Border {
            spindle: self.spindle.map(|x| x as f32),
            spindle_velocity: self.spindle_velocity.map(|x| x as f32),
            cage: self.cage.map(|x| x as f32),
            cage_arc: self.cage_arc as f32,
            cage_velocity: self.cage_velocity.map(|x| x as f32),
        }
    }
}
