//! The full dynamics: balls and cage with six degrees of freedom each, spindle with two or three.

use super::Dynamics;

/// Nine states a ball, twelve of the cage, four or six of the spindle.
pub type Full = Dynamics<false>;
