//! ∂(rates)/∂(state) of a bearing by difference quotients, all balls displaced at once.
//!
//! Balls act on each other only through cage and spindle, so that one evaluation shows the effect of one entry of *every*
//! ball, on the ball itself and, since each ball's reaction is seen apart, on cage and spindle. An entry of the spindle changes
//! nothing but the inner contacts, one of the cage nothing but the pockets, and only those are evaluated.

use super::Dynamics;
use super::dynamics::{Reaction, Watch, Wrench};
use crate::numerics::ode::structure::Jacobian;
use crate::physics::ball::BallMotion;
use crate::simulation::state::{BallState, CageState, SpindleState};

/// Displacement over the size of an entry: small against the indentation of a contact, large against rounding.
const DISPLACEMENT: f64 = 1e-5;

/// Keeps what acts on each ball, and what it passes on.
#[derive(Clone)]
struct Parts(Vec<(Wrench, Reaction)>);

impl Watch for Parts {
    fn ball(&mut self, ball: usize, wrench: &Wrench, reaction: &Reaction) {
        self.0[ball] = (*wrench, *reaction);
    }
}

/// One ball, undisplaced.
struct Ball {
    state: BallState,
    motion: BallMotion,
    wrench: Wrench,
    /// Rates of the border as if this ball alone acted on it.
    alone: Vec<f64>,
    /// What the part of the border that is displaced does to it, undisplaced.
    inner: (Wrench, Reaction),
    pocket: (Wrench, Reaction),
}

/// Cage and spindle at a time.
struct Border {
    cage: CageState,
    spindle: SpindleState,
    /// Angle, speed and acceleration of the shaft.
    shaft: (f64, f64, f64),
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    /// Fills the Jacobian at a state; returns the evaluations it took, parts counted as parts.
    pub(super) fn differences(&self, time: f64, state: &[f64], jacobian: &mut Jacobian) -> u64 {
        let layout = self.mechanism().layout;
        let (balls, block, border) = (layout.balls, layout.ball_size(), layout.border_size());
        let displacements: Vec<f64> = layout.sizes().iter().map(|size| DISPLACEMENT * size).collect();
        let n = state.len();
        let first = balls * block;
        let shaft = self.mechanism().speed.at(time);
        let at_rest = Border { cage: layout.cage(state), spindle: layout.spindle(state), shaft };

        let (mut rate, mut moved_rate, mut moved) = (vec![0.0; n], vec![0.0; n], state.to_vec());
        let mut parts = Parts(vec![Default::default(); balls]);
        self.evaluate(time, state, &mut rate, &mut parts);
        let undisplaced: Vec<Ball> = (0..balls).map(|ball| self.undisplaced(ball, state, &at_rest, &parts)).collect();
        let mut alone = vec![0.0; n];

        for column in 0..block {
            for ball in 0..balls {
                moved[ball * block + column] = state[ball * block + column] + displacements[column];
            }
            self.evaluate(time, &moved, &mut moved_rate, &mut parts);
            for (ball, before) in undisplaced.iter().enumerate() {
                let at = ball * block;
                moved[at + column] = state[at + column];
                let quotient = |after: f64, before: f64| (after - before) / displacements[column];
                let own = jacobian.block_mut(ball);
                for row in 0..block {
                    own[row * block + column] = quotient(moved_rate[at + row], rate[at + row]);
                }
                self.border_rates(&at_rest, &parts.0[ball].1, &mut alone);
                let below = jacobian.below_mut(ball);
                for row in 0..border {
                    below[row * block + column] = quotient(alone[first + row], before.alone[row]);
                }
            }
        }

        let mut of_ball = vec![0.0; n];
        for column in 0..border {
            let entry = first + column;
            moved[entry] = state[entry] + displacements[entry];
            let displaced = Border { cage: layout.cage(&moved), spindle: layout.spindle(&moved), shaft };
            moved[entry] = state[entry];
            let of_cage = displaced.cage != at_rest.cage;
            let quotient = |after: f64, before: f64| (after - before) / displacements[entry];
            let mut sum = Reaction::default();
            for (ball, before) in undisplaced.iter().enumerate() {
                // What changes, before and after.
                let (was, is) = if of_cage {
                    (before.pocket, self.pocket_part(ball, &before.motion, &displaced))
                } else {
                    (before.inner, self.inner_part(ball, &before.motion, &displaced))
                };
                sum.add(&before.inner.1);
                sum.add(&before.pocket.1);
                sum.add(&is.1.less(&was.1));
                let wrench = before.wrench.and(is.0.less(&was.0));
                let rates = self.ball_rates(&before.state, &before.motion, wrench, shaft.2);
                layout.set_ball(&mut of_ball, ball, &rates);
                let right = jacobian.right_mut(ball);
                for row in 0..block {
                    right[row * border + column] = quotient(of_ball[ball * block + row], rate[ball * block + row]);
                }
            }
            self.border_rates(&displaced, &sum, &mut alone);
            let corner = jacobian.corner_mut();
            for row in 0..border {
                corner[row * border + column] = quotient(alone[first + row], rate[first + row]);
            }
        }
        // An inner contact is about half of an evaluation, a pocket a twentieth.
        1 + block as u64 + border.div_ceil(4) as u64
    }

    fn undisplaced(&self, ball: usize, state: &[f64], border: &Border, parts: &Parts) -> Ball {
        let layout = self.mechanism().layout;
        let own = layout.ball(state, ball);
        let motion = self.ball_motion(ball, &own, border.shaft.0, border.shaft.1);
        let (wrench, reaction) = parts.0[ball];
        let mut alone = vec![0.0; state.len()];
        self.border_rates(border, &reaction, &mut alone);
        Ball {
            state: own,
            wrench,
            alone: alone.split_off(layout.balls * layout.ball_size()),
            inner: self.inner_part(ball, &motion, border),
            pocket: self.pocket_part(ball, &motion, border),
            motion,
        }
    }

    fn inner_part(&self, ball: usize, motion: &BallMotion, border: &Border) -> (Wrench, Reaction) {
        let mut reaction = Reaction::default();
        let (angle, speed, _) = border.shaft;
        let wrench = self.inner(ball, motion, &border.spindle, (angle, speed), &mut reaction, &mut ());
        (wrench, reaction)
    }

    fn pocket_part(&self, ball: usize, motion: &BallMotion, border: &Border) -> (Wrench, Reaction) {
        let mut reaction = Reaction::default();
        if !self.mechanism().layout.cage {
            return (Wrench::default(), reaction);
        }
        let pose = self.cage_pose(&border.cage, border.shaft.0, border.shaft.1);
        let wrench = self.pocket(ball, motion, &pose, &mut reaction, &mut ());
        (wrench, reaction)
    }

    /// Rates of cage and spindle under a reaction, in their places of `rate`.
    fn border_rates(&self, border: &Border, reaction: &Reaction, rate: &mut [f64]) {
        let layout = self.mechanism().layout;
        let (angle, speed, acceleration) = border.shaft;
        let pose = self.cage_pose(&border.cage, angle, speed);
        layout.set_cage(rate, &self.cage_rates(&border.cage, &pose, reaction, acceleration));
        layout.set_spindle(rate, &self.spindle_rates(&border.spindle, reaction.spindle, border.shaft));
    }
}
