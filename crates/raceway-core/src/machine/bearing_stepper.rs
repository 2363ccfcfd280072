//! Fixed steps of a bearing between shaft and housing, on its level of the model.

use super::bearing::{BearingOnShaft, ReducedBearing};
use super::port::{PortLoad, Predicted, Resistance, ball_of};
use super::reduced_stepper::ReducedStepper;
use crate::physics::frames::Vector;
use crate::simulation::model::dynamics::on_ring::{RingStepper, Rings};
use crate::simulation::model::ring_motion::BallSeen;

/// Balls and cage of a bearing, driven by the motion of its rings.
pub(crate) enum BearingStepper<'m> {
    Full(Box<FullStepper<'m>>),
    Reduced(Box<ReducedStepper<'m>>),
}

/// On the level `full`.
pub(crate) struct FullStepper<'m> {
    bearing: &'m BearingOnShaft,
    steps: RingStepper<'m, false>,
}

impl<'m> BearingStepper<'m> {
    /// A bearing at a motion of its rings; `state`: of balls and cage on `full`.
    pub(crate) fn new(bearing: &'m BearingOnShaft, time: f64, state: &[f64], rings: Rings) -> Self {
        match &bearing.reduced {
            None => {
                let steps = RingStepper::new(&bearing.dynamics, time, state, rings.inner);
                Self::Full(Box::new(FullStepper { bearing, steps }))
            }
            Some(ReducedBearing { model, tilt }) => {
                Self::Reduced(Box::new(ReducedStepper::new(bearing, (model, tilt), time, state, &rings.inner)))
            }
        }
    }

    /// Load on the inner ring at the start along the shaft's axes, where it is not that of `full`.
    pub(crate) fn first_load(&self, rings: &Rings) -> Option<[f64; 5]> {
        match self {
            Self::Full(_) => None,
            Self::Reduced(of) => of.first_load(&rings.inner),
        }
    }

    /// Starts again at the newest state, at a low order.
    pub(crate) fn begin(&mut self) {
        match self {
            Self::Full(of) => of.steps.begin(),
            Self::Reduced(of) => of.begin(),
        }
    }

    /// Keeps the newest state for `recall`.
    pub(crate) fn keep(&mut self) {
        match self {
            Self::Full(of) => of.steps.keep(),
            Self::Reduced(of) => of.keep(),
        }
    }

    /// Replaces all states but the newest by the kept ones.
    pub(crate) fn recall(&mut self) {
        match self {
            Self::Full(of) => of.steps.recall(),
            Self::Reduced(of) => of.recall(),
        }
    }

    /// Advances balls and cage by a step to a time. Returns their load on the inner ring, and on the outer one, which counts where that moves.
    pub(crate) fn advance(&mut self, end: f64, step: f64, predicted: &Predicted) -> [Option<PortLoad>; 2] {
        match self {
            Self::Full(of) => of.steps.advance(end, step, predicted.rings).map(|(load, resistance)| {
                let mounted = &of.bearing.mounted;
                let [stiffness, damping] =
                    [resistance.stiffness, resistance.damping].map(|matrix| mounted.along_shaft(&matrix));
                let resistance = Resistance { stiffness, damping, slope: None };
                Some(PortLoad { wrench: of.bearing.on_shaft(&load), resistance })
            }),
            Self::Reduced(of) => [Some(of.advance(end, step, predicted)), None],
        }
    }

    /// Ends the step at the corrected motion of the rings.
    pub(crate) fn finish(&mut self, rings: impl FnOnce() -> Rings) {
        match self {
            Self::Full(of) => of.steps.finish(),
            Self::Reduced(of) => of.finish(|| rings().inner),
        }
    }

    /// Loads and slip of a ball in the last step.
    pub(crate) fn seen(&self, ball: usize) -> BallSeen {
        match self {
            Self::Full(of) => ball_of(of.steps.step_loads(), ball),
            Self::Reduced(of) => of.seen(ball),
        }
    }

    /// Speed of the cage; without a cage, mean orbit speed of the balls [rad/s].
    pub(crate) fn cage_speed(&self, time: f64) -> f64 {
        let m = self.bearing().dynamics.mechanism();
        let arc_velocity = match self {
            Self::Full(of) => of.steps.arc_velocity(),
            Self::Reduced(of) => of.arc_velocity(),
        };
        m.orbit_speed(&m.rotations(time), arc_velocity)
    }

    /// Spin of a ball in the orbit frame [rad/s].
    pub(crate) fn spin(&self, ball: usize, time: f64) -> Vector {
        let m = self.bearing().dynamics.mechanism();
        let (arc_velocity, [x, y, z]) = match self {
            Self::Full(of) => of.steps.ball_turns(ball),
            Self::Reduced(of) => of.ball_turns(ball),
        };
        [m.rotations(time).turn_speed + x - arc_velocity / m.pitch_radius, y, z]
    }

    /// A ball that touches its neighbour, where there is no cage.
    pub(crate) fn touching(&self) -> Option<usize> {
        match self {
            Self::Full(of) => of.steps.touching(),
            Self::Reduced(of) => of.touching(),
        }
    }

    fn bearing(&self) -> &'m BearingOnShaft {
        match self {
            Self::Full(of) => of.bearing,
            Self::Reduced(of) => of.bearing(),
        }
    }
}
