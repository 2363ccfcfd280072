//! ∂(rates)/∂(state) of a bearing by difference quotients, all balls displaced at once.
//!
//! Balls act on each other only through cage and spindle, so that one evaluation shows the effect of one entry of *every*
//! ball, on the ball itself and, since each ball's reaction is seen apart, on cage and spindle: entries of a ball plus entries of
//! the border evaluations, however many balls there are.

use super::Dynamics;
use super::dynamics::{Reaction, Watch};
use crate::numerics::ode::structure::Jacobian;
use crate::simulation::state::Layout;

/// Displacement over the size of an entry: small against the indentation of a contact, large against rounding.
const DISPLACEMENT: f64 = 1e-5;

/// Keeps what each ball passes on.
struct Reactions(Vec<Reaction>);

impl Watch for Reactions {
    fn reaction(&mut self, ball: usize, reaction: &Reaction) {
        self.0[ball] = *reaction;
    }
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    /// Fills the Jacobian at a state; returns the evaluations it took.
    pub(super) fn differences(&self, time: f64, state: &[f64], jacobian: &mut Jacobian) -> u64 {
        let layout = self.mechanism().layout;
        let (balls, block, border) = (layout.balls, layout.ball_size(), layout.border_size());
        let displacements: Vec<f64> = layout.sizes().iter().map(|size| DISPLACEMENT * size).collect();
        let n = state.len();
        let (mut rate, mut moved_rate, mut moved) = (vec![0.0; n], vec![0.0; n], state.to_vec());
        let mut reactions = Reactions(vec![Reaction::default(); balls]);
        let first = balls * block;
        let mut alone = vec![0.0; n];
        self.evaluate(time, state, &mut rate, &mut reactions);
        let unmoved: Vec<Vec<f64>> = reactions
            .0
            .iter()
            .map(|reaction| {
                self.border_rates(time, state, reaction, &layout, &mut alone);
                alone[first..].to_vec()
            })
            .collect();
        for column in 0..block {
            let displacement = displacements[column];
            for ball in 0..balls {
                moved[ball * block + column] = state[ball * block + column] + displacement;
            }
            self.evaluate(time, &moved, &mut moved_rate, &mut reactions);
            for ball in 0..balls {
                let at = ball * block;
                moved[at + column] = state[at + column];
                let own = jacobian.block_mut(ball);
                for row in 0..block {
                    own[row * block + column] = (moved_rate[at + row] - rate[at + row]) / displacement;
                }
                self.border_rates(time, state, &reactions.0[ball], &layout, &mut alone);
                let below = jacobian.below_mut(ball);
                for row in 0..border {
                    below[row * block + column] = (alone[first + row] - unmoved[ball][row]) / displacement;
                }
            }
        }
        for column in 0..border {
            let displacement = displacements[first + column];
            moved[first + column] = state[first + column] + displacement;
            self.evaluate(time, &moved, &mut moved_rate, &mut ());
            moved[first + column] = state[first + column];
            for ball in 0..balls {
                let at = ball * block;
                let right = jacobian.right_mut(ball);
                for row in 0..block {
                    right[row * border + column] = (moved_rate[at + row] - rate[at + row]) / displacement;
                }
            }
            let corner = jacobian.corner_mut();
            for row in 0..border {
                corner[row * border + column] = (moved_rate[first + row] - rate[first + row]) / displacement;
            }
        }
        (1 + block + border) as u64
    }

    /// Rates of cage and spindle under the reaction of one ball alone, in their places of `rate`.
    fn border_rates(&self, time: f64, state: &[f64], reaction: &Reaction, layout: &Layout, rate: &mut [f64]) {
        let motion = self.mechanism().speed.at(time);
        let cage = layout.cage(state);
        let pose = self.cage_pose(&cage, motion.0, motion.1);
        layout.set_cage(rate, &self.cage_rates(&cage, &pose, reaction, motion.2));
        layout.set_spindle(rate, &self.spindle_rates(&layout.spindle(state), reaction.spindle, motion));
    }
}
