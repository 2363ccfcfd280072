//! Cage, spindle and outer ring at one time, in the form in which the balls need them.

use super::contact_frame::TiltedAxis;
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
    /// `None`: the outer ring is at the origin.
    pub outer: Option<OuterRing>,
    pub rotations: Rotations,
    /// [s]
    pub time: f64,
    /// Rate of the fading start-up damping [1/s]; else 0.
    pub damping: f64,
}

/// An outer ring that moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct OuterRing {
    pub state: SpindleState,
    pub axis: TiltedAxis,
}

impl OuterRing {
    pub(super) fn new(state: SpindleState) -> Self {
        Self { state, axis: TiltedAxis::new(state.tilt, state.tilt_rate) }
    }
}

/// Position and motion of the cage, for its pockets.
#[derive(Debug, Clone, Copy)]
pub(super) struct CagePose {
    pub motion: CageMotion,
    /// Azimuth of the first pocket about the cage axis.
    pub azimuth: Azimuth,
}
