//! Height and slopes of a raceway.

use crate::numerics::lanes::side_by_side;

/// Height of a raceway under a ball, and its slopes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Height<T = f64> {
    /// Added to the penetration of the contact [m], positive out of the material.
    pub height: T,
    /// Change with the azimuth on the ring [m/rad].
    pub along: T,
    /// Change with the place of the contact across the groove, towards +X [m/m].
    pub across: T,
}
side_by_side!(Height { height, along, across });

/// Height under a ball [m], with its first and second derivative by the azimuth on the ring [m/rad, m/rad²].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Rise<T = f64> {
    pub height: T,
    pub slope: T,
    pub curvature: T,
}
side_by_side!(Rise { height, slope, curvature });
