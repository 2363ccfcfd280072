//! ∂(rates)/∂(state) of a bearing by difference quotients, all balls displaced at once.
//!
//! Balls act on each other only through cage and spindle, so that one evaluation shows the effect of one entry of *every*
//! ball, on the ball itself and, since each ball's reaction is seen apart, on cage and spindle. An entry of the spindle changes
//! nothing but the inner contacts, one of the cage nothing but the pockets, and only those are evaluated.

use super::Dynamics;
use super::dynamics::{CagePose, Contacts, Reaction, Shaft};
use crate::numerics::lanes::{LANES, Lanes, SideBySide, Task};
use crate::numerics::ode::structure::Jacobian;
use crate::physics::ball::BallMotion;
use crate::simulation::state::{BallState, CageState, MAX_BORDER, SpindleState};

/// Displacement over the size of an entry: small against the indentation of a contact, large against rounding.
pub(super) const DISPLACEMENT: f64 = 1e-5;

/// Cage and spindle at a time.
#[derive(Clone, Copy)]
struct Border {
    cage: CageState,
    pose: CagePose,
    spindle: SpindleState,
    shaft: Shaft,
}

/// One Jacobian, to be compiled for each instruction set.
struct Differences<'a, const PLANAR: bool> {
    dynamics: &'a Dynamics<PLANAR>,
    time: f64,
    state: &'a [f64],
    jacobian: &'a mut Jacobian,
}

impl<const PLANAR: bool> Task for Differences<'_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.dynamics.differences_by(self.time, self.state, self.jacobian);
    }
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    /// Fills the Jacobian at a state; returns the evaluations it took, parts counted as parts.
    pub(super) fn differences(&self, time: f64, state: &[f64], jacobian: &mut Jacobian) -> u64 {
        self.instructions().run(Differences { dynamics: self, time, state, jacobian });
        let layout = self.mechanism().layout;
        // An inner contact is about half of an evaluation, a pocket a tenth.
        1 + layout.ball_size() as u64 + layout.border_size().div_ceil(4) as u64
    }

    #[inline(always)]
    fn differences_by(&self, time: f64, state: &[f64], jacobian: &mut Jacobian) {
        let layout = self.mechanism().layout;
        let (block, border) = (layout.ball_size(), layout.border_size());
        let (of_ball, of_border) = self.displacements().split_at(block);
        let shaft = self.mechanism().speed.at(time);
        let mut entries = [0.0; MAX_BORDER];
        entries[..border].copy_from_slice(&state[layout.balls * block..]);
        let at_rest = self.border(&entries, shaft);
        let mut displaced = [at_rest; MAX_BORDER];
        for column in 0..border {
            let entry = entries[column];
            entries[column] += of_border[column];
            displaced[column] = self.border(&entries, shaft);
            entries[column] = entry;
        }
        let displaced = &displaced[..border];
        // Reactions of all balls, at rest and with each entry of the border displaced.
        let mut sum = Reaction::default();
        let mut sums = [Reaction::default(); MAX_BORDER];

        for first in (0..layout.balls).step_by(LANES) {
            let count = LANES.min(layout.balls - first);
            let own = layout.side_by_side::<PLANAR, LANES>(state, first);
            let (mut motion, mut contacts) = (BallMotion::default(), Contacts::default());
            let mut before = [<Lanes>::default(); 9];
            // Undisplaced first, then by one entry after the other.
            for displaced in std::iter::once(None).chain((0..block).map(Some)) {
                let mut entries = own.entries(PLANAR);
                if let Some(column) = displaced {
                    entries[column].0.iter_mut().for_each(|entry| *entry += of_ball[column]);
                }
                let state = BallState::from_entries(entries, PLANAR);
                let moving = self.ball_motions(first, &state, shaft);
                let moved = self.contacts(first, &moving, &at_rest.spindle, &at_rest.pose, shaft, None);
                let after = self.ball_rates(&state, &moving, &moved.wrench, shaft).entries(PLANAR);
                let Some(column) = displaced else {
                    (motion, contacts, before) = (moving, moved, after);
                    contacts.reaction.sum_into(&mut sum, count);
                    continue;
                };
                let by = of_ball[column];
                for lane in 0..count {
                    let part = jacobian.block_mut(first + lane);
                    for row in 0..block {
                        part[row * block + column] = (after[row][lane] - before[row][lane]) / by;
                    }
                    let passed_on = moved.reaction.at(lane).less(&contacts.reaction.at(lane));
                    let rates = self.border_response(&at_rest.pose, &passed_on);
                    let part = jacobian.below_mut(first + lane);
                    for row in 0..border {
                        part[row * block + column] = rates[row] / by;
                    }
                }
            }
            for (column, displaced) in displaced.iter().enumerate() {
                let by = of_border[column];
                let mut reaction = contacts.reaction;
                // What changes, before and after.
                let (was, is) = if column < layout.cage_size() {
                    let pocket = self.pockets(first, &motion, &displaced.pose);
                    (reaction.cage_force, reaction.cage_moment) = (pocket.reaction_force, pocket.reaction_moment);
                    (&contacts.pocket, pocket.wrench)
                } else {
                    let (wrench, on_spindle) = self.inner(&motion, &displaced.spindle, shaft);
                    reaction.spindle = on_spindle;
                    (&contacts.inner, wrench)
                };
                let mut wrench = contacts.wrench;
                for lane in 0..LANES {
                    wrench.put(lane, wrench.at(lane).and(is.at(lane).less(&was.at(lane))));
                }
                reaction.sum_into(&mut sums[column], count);
                let after = self.ball_rates(&own, &motion, &wrench, shaft).entries(PLANAR);
                for lane in 0..count {
                    let part = jacobian.right_mut(first + lane);
                    for row in 0..block {
                        part[row * border + column] = (after[row][lane] - before[row][lane]) / by;
                    }
                }
            }
        }

        let before = self.border_rates(&at_rest, &sum);
        let corner = jacobian.corner_mut();
        for (column, displaced) in displaced.iter().enumerate() {
            let after = self.border_rates(displaced, &sums[column]);
            for row in 0..border {
                corner[row * border + column] = (after[row] - before[row]) / of_border[column];
            }
        }
    }

    #[inline(always)]
    fn border(&self, entries: &[f64], shaft: Shaft) -> Border {
        let alone = self.mechanism().layout.without_balls();
        let cage = alone.cage(entries);
        Border { pose: self.cage_pose(&cage, shaft), cage, spindle: alone.spindle(entries), shaft }
    }

    /// Rates of cage and spindle under a reaction, in their order.
    #[inline(always)]
    fn border_rates(&self, border: &Border, reaction: &Reaction) -> [f64; MAX_BORDER] {
        let cage = self.cage_rates(&border.cage, &border.pose, reaction, border.shaft);
        let spindle = self.spindle_rates(&border.spindle, reaction.spindle, border.shaft);
        self.mechanism().layout.border(&cage, &spindle)
    }

    /// What a reaction adds to them.
    #[inline(always)]
    fn border_response(&self, pose: &CagePose, reaction: &Reaction) -> [f64; MAX_BORDER] {
        let (cage, spindle) = (self.cage_response(pose, reaction), self.spindle_response(reaction.spindle));
        self.mechanism().layout.border(&cage, &spindle)
    }
}
