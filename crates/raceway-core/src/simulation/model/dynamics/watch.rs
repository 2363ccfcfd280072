//! View of the loads of one evaluation, for observers and tests.

use crate::physics::pocket::PocketLoad;
use crate::physics::raceway::{RacewayLoad, RelativeMotion};
use crate::simulation::input::channel::BallContact;

/// Sees every load of one evaluation of the equations, as they are applied.
pub trait Watch {
    /// A raceway contact of a ball; forces in the orbit frame, on the ball.
    fn raceway(&mut self, ball: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        let _ = (ball, side, motion, load);
    }
    /// A pocket contact; forces in the cage's tilted frame, on the ball.
    fn pocket(&mut self, ball: usize, load: &PocketLoad) {
        let _ = (ball, load);
    }
}
