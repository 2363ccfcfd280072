//! Exchange between a bearing and the shaft in a step: predicted motion of the rings, and load with its resistance.

use crate::numerics::ode::adams_moulton::Shares;
use crate::physics::statics::Matrix;
use crate::simulation::model::dynamics::on_ring::Rings;
use crate::simulation::model::ring_motion::BallSeen;
use crate::simulation::model::step_loads::PackedStepLoads;

/// Predicted motion of the rings of a bearing at the end of a step, in its own axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Predicted {
    pub rings: Rings,
    /// Acceleration of the inner ring along Y and Z [m/s²]; not used on `full`.
    pub acceleration: [f64; 2],
    /// Shares of a change of that acceleration in place and velocity.
    pub shares: Shares,
}

/// Load of balls and cage on a ring along the shaft's axes [N, N m], and its decrease by the ring's further motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PortLoad {
    pub wrench: [f64; 5],
    pub resistance: Resistance,
}

/// Decrease of a load by the motion of its ring.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resistance {
    pub stiffness: Matrix,
    pub damping: Matrix,
    /// Over accelerations, with the displacements and velocities that follow them.
    pub slope: Option<Matrix>,
}

/// Loads and slip of a ball in packed ones.
pub(super) fn ball_of(step_loads: &[f64], ball: usize) -> BallSeen {
    let now = PackedStepLoads(step_loads).of(ball);
    BallSeen { load: now.load, slip: now.slip_square.map(|square| square.sqrt()), pocket: now.pocket }
}
