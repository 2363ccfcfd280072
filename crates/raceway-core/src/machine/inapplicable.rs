//! Reasons why a reduced model does not apply to a machine.

use crate::simulation::model::inapplicable::Inapplicable;
use crate::simulation::model::terms::UnsupportedChoice;

/// Reason why a reduced model cannot represent a machine. Bearings have their names.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MachineInapplicable {
    #[error("bearings of this model carry no force along X, and the shaft moves along X (`axial` is free)")]
    AxiallyFree,
    #[error("the speed changes")]
    SpeedChanges,
    #[error("there is no ball bearing")]
    NoBearing,
    #[error(
        "the outer ring of bearing {bearing} moves (`on`, `seat`), and this model has equations for one that is held"
    )]
    OuterRingMoves { bearing: String },
    #[error("the outer ring of bearing {bearing} is set off along X or tilted (`preloads`, `outer_ring`)")]
    OuterRingOff { bearing: String },
    #[error("the load of a single ball is asked for (`outputs.series`), and this model does not tell balls apart")]
    SingleBalls,
    #[error("bearing {bearing}: {reason}")]
    Bearing { bearing: String, reason: BearingInapplicable },
}

/// Reason why a reduced model cannot represent the scene of a bearing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BearingInapplicable {
    #[error(transparent)]
    Scene(#[from] Inapplicable),
    #[error("{0}")]
    Choice(UnsupportedChoice),
}

impl From<UnsupportedChoice> for BearingInapplicable {
    fn from(choice: UnsupportedChoice) -> Self {
        match choice {
            UnsupportedChoice::ModelLevel { reason, .. } => Self::Scene(reason),
            choice @ UnsupportedChoice::Term { .. } => Self::Choice(choice),
        }
    }
}
