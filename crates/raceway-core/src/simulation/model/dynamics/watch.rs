//! View of the loads of one evaluation, for observers and tests.

use crate::physics::neighbour::NeighbourLoad;
use crate::physics::pocket::PocketLoad;
use crate::physics::raceway::{RacewayLoad, RelativeMotion};
use crate::simulation::input::channel::BallContact;

/// Receiver of every load in one evaluation of the equations.
pub trait Watch {
    /// Receives a raceway contact of a ball; forces on the ball in the orbit frame.
    fn raceway(&mut self, ball: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        let _ = (ball, side, motion, load);
    }
    /// Receives a pocket contact; forces on the ball in the cage's tilted frame.
    fn pocket(&mut self, ball: usize, load: &PocketLoad) {
        let _ = (ball, load);
    }
    /// Receives the contact of a ball with the next one, where there is no cage; forces on the ball in the inertial frame.
    fn neighbour(&mut self, ball: usize, load: &NeighbourLoad) {
        let _ = (ball, load);
    }
}
