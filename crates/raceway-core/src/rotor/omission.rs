//! Terms of the system around the bearings that a model may leave out.

use super::input::Rotor;
use crate::physics::frame::housing::Housing;
use crate::physics::frame::shaft::ShaftMotion;

/// A term of the system around the bearings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SystemTerm {
    /// Bending of the shaft, and its strain along X. Left out: it moves as a rigid body.
    ShaftBending,
    /// Tilt of the rings and moments of the balls against it. Left out: each bearing is a hinge.
    Tilt,
    /// Gyroscopic moments of shaft and discs; balls keep theirs.
    Gyroscopic,
    /// Motion of the housing. Left out: outer rings and supports stand on the ground, each on its seat.
    Housing,
}

impl SystemTerm {
    pub const ALL: [Self; 4] = [Self::ShaftBending, Self::Tilt, Self::Gyroscopic, Self::Housing];

    pub fn name(self) -> &'static str {
        match self {
            Self::ShaftBending => "shaft_bending",
            Self::Tilt => "tilt",
            Self::Gyroscopic => "gyroscopic",
            Self::Housing => "housing",
        }
    }
}

impl Rotor {
    /// The rotor with a term left out.
    pub fn without(mut self, term: SystemTerm) -> Self {
        match term {
            SystemTerm::ShaftBending => {
                if self.shaft.motion == ShaftMotion::Bends {
                    self.shaft.motion = ShaftMotion::Rigid;
                }
            }
            SystemTerm::Tilt => self.bearings.iter_mut().for_each(|bearing| bearing.has_moments = false),
            SystemTerm::Gyroscopic => self.shaft.has_gyroscopic_moments = false,
            SystemTerm::Housing => {
                self.housing = Housing::default();
                self.bearings.iter_mut().for_each(|bearing| bearing.on = None);
                self.supports.iter_mut().for_each(|support| support.on = None);
            }
        }
        self
    }

    /// True if it has a term.
    pub fn has(&self, term: SystemTerm) -> bool {
        match term {
            SystemTerm::ShaftBending => self.shaft.motion == ShaftMotion::Bends,
            SystemTerm::Tilt => {
                self.shaft.motion != ShaftMotion::Upright && self.bearings.iter().any(|bearing| bearing.has_moments)
            }
            SystemTerm::Gyroscopic => self.shaft.motion != ShaftMotion::Upright && self.shaft.has_gyroscopic_moments,
            SystemTerm::Housing => self.housing.moves(),
        }
    }
}
