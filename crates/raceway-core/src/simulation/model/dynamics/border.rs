//! Cage and spindle at one time, in the form in which the balls need them.

use crate::physics::cage::CageMotion;
use crate::physics::frames::Azimuth;
use crate::simulation::model::mechanism::Rotations;
use crate::simulation::model::state::{CageState, SpindleState};

/// State of cage and spindle at one time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    pub cage: CageState,
    pub pose: CagePose,
    pub spindle: SpindleState,
    pub rotations: Rotations,
    /// [s]
    pub time: f64,
    /// Rate of the fading start-up damping [1/s]; else 0.
    pub damping: f64,
}

/// Position and motion of the cage, for its pockets.
#[derive(Debug, Clone, Copy)]
pub(super) struct CagePose {
    pub motion: CageMotion,
    /// Azimuth of the first pocket about the cage axis.
    pub azimuth: Azimuth,
}
