//! The planar rung: nothing moves along X and nothing tilts. Exact where nothing acts along X and the cage is
//! symmetric about its pocket plane.

use super::Dynamics;

/// Five states a ball, six of the cage, four of the spindle.
pub type Planar = Dynamics<true>;
