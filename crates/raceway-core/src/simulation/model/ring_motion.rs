//! Motion of a ring that a shaft moves, and the load of a reduced bearing on it.

use crate::numerics::ode::adams_moulton::Defect;
use crate::physics::bearing::PerRaceway;
use crate::simulation::input::channel::BallContact;

/// Motion of the inner ring along Y and Z: place [m], velocity [m/s], acceleration [m/s²].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RingMotion {
    pub place: [f64; 2],
    pub velocity: [f64; 2],
    pub acceleration: [f64; 2],
}

/// Load of the balls on the inner ring.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LoadOnRing {
    /// Along Y and Z [N].
    pub force: [f64; 2],
    /// Decrease of the force over the ring's acceleration [kg], with the place and the velocity that follow it: yy, yz, zz.
    pub slope: [f64; 3],
}

impl From<Defect> for LoadOnRing {
    fn from(Defect { force, slope }: Defect) -> Self {
        Self { force, slope }
    }
}

/// Loads and slip of a ball.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BallSeen {
    /// [N]
    pub load: PerRaceway<f64>,
    /// [m/s]
    pub slip: PerRaceway<f64>,
    /// [N]
    pub pocket: f64,
}

impl BallSeen {
    /// Load of a contact [N].
    pub(crate) fn load_at(&self, contact: BallContact) -> f64 {
        match contact {
            BallContact::Inner => self.load.inner,
            BallContact::Outer => self.load.outer,
            BallContact::Pocket => self.pocket,
        }
    }
}
