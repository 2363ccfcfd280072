//! ∂(rates)/∂(state) of a bearing by difference quotients, all balls displaced at once.
//!
//! Balls act on each other through cage and spindle, and without a cage on their neighbours (`neighbours`). So one evaluation gives the effect of one entry of *every* ball: on the
//! ball itself and, through the reaction of each ball, on cage and spindle. An entry of the spindle changes only the inner
//! contacts, one of the cage only the pockets, and only those are evaluated.

use super::ball_group::Balls;
use super::border::Border;
use super::equations::Dynamics;
use super::forces::{Reaction, Wrench};
use crate::numerics::lanes::{LANES, Lanes, SideBySide, Task};
use crate::numerics::ode::structure::Jacobian;
use crate::physics::frames::{Vector, subtract};
use crate::simulation::model::state::{BallAttitude, BallState, MAX_BORDER};

/// One Jacobian, compiled for each instruction set.
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
        // Entries of a ball's motion, before those of its attitude.
        let motion = layout.motion_size();
        let (of_ball, of_border) = self.displacements().split_at(block);
        let mut entries = [0.0; MAX_BORDER];
        entries[..border].copy_from_slice(&state[layout.balls * block..]);
        let alone = layout.without_balls();
        let at_rest = self.border(alone.cage(&entries), alone.spindle(&entries), time);
        let mut displaced = [at_rest; MAX_BORDER];
        for column in 0..border {
            let entry = entries[column];
            entries[column] += of_border[column];
            displaced[column] = self.border(alone.cage(&entries), alone.spindle(&entries), time);
            entries[column] = entry;
        }
        let displaced = &displaced[..border];
        // Reactions of all balls, at rest and with each entry of the border displaced.
        let mut sum = (Reaction::default(), [0.0; 3]);
        let mut sums = [sum; MAX_BORDER];

        for first in (0..layout.balls).step_by(LANES) {
            let (count, group) = (LANES.min(layout.balls - first), first / LANES);
            // Lanes beyond the last ball repeat it and do not enter the Jacobian.
            let mut share: Lanes = Lanes::default();
            share.0[..count].fill(1.0);
            let own = layout.side_by_side::<PLANAR>(state, first);
            let attitude = layout.attitude.then(|| [layout.attitudes(state, first), BallAttitude::default()]);
            let mut balls = Balls::new(layout.tilting_spindle);
            let mut moved = balls;
            // Undisplaced first, then by one entry after the other.
            for displaced in std::iter::once(None).chain((0..block).map(Some)) {
                let mut entries = own.entries(PLANAR);
                moved.attitude = attitude;
                if let Some(column) = displaced {
                    let entry = match &mut moved.attitude {
                        Some([attitude, _]) if column >= motion => &mut attitude.0[column - motion],
                        _ => &mut entries[column],
                    };
                    entry.0.iter_mut().for_each(|entry| *entry += of_ball[column]);
                }
                self.balls(first, &BallState::from_entries(entries, PLANAR), &at_rest, &mut moved, None, None);
                let Some(column) = displaced else {
                    balls = moved;
                    balls.reaction.sum_into(&mut sum.0, count);
                    balls.add_on_tilt(&mut sum.1, count);
                    continue;
                };
                let per = 1.0 / of_ball[column];
                let (before, after) = (balls.rates.entries(PLANAR), moved.rates.entries(PLANAR));
                let part = jacobian.blocks.group_mut(group);
                for row in 0..motion {
                    for lane in 0..LANES {
                        part[row * block + column][lane] = share[lane] * ((after[row][lane] - before[row][lane]) * per);
                    }
                }
                let [after, before] =
                    [moved.attitude, balls.attitude].map(|of| of.map_or(BallAttitude::default(), |[_, rates]| rates));
                for row in motion..block {
                    let (after, before) = (after.0[row - motion], before.0[row - motion]);
                    for lane in 0..LANES {
                        part[row * block + column][lane] = share[lane] * ((after[lane] - before[lane]) * per);
                    }
                }
                let mut rates = [Lanes::default(); MAX_BORDER];
                for lane in 0..LANES {
                    let passed_on = moved.reaction.at(lane).less(&balls.reaction.at(lane));
                    let on_tilt = match (&moved.on_tilt, &balls.on_tilt) {
                        (Some(moved), Some(before)) => subtract(moved.at(lane), before.at(lane)),
                        _ => [0.0; 3],
                    };
                    let response = self.border_response(&at_rest, &passed_on, on_tilt);
                    for row in 0..border {
                        rates[row][lane] = share[lane] * (response[row] * per);
                    }
                }
                let part = jacobian.below.group_mut(group);
                for row in 0..border {
                    part[row * block + column] = rates[row];
                }
            }
            // Effects of cage and spindle, again with the undisplaced border first.
            let inner = self.inner_part(first, &balls, &at_rest).wrench;
            let pocket = self.pocket_part(first, &balls.motion, &at_rest.pose).0;
            for (column, displaced) in displaced.iter().enumerate() {
                let mut reacting = balls;
                let reaction = &mut reacting.reaction;
                let (was, is) = if column < layout.cage_size() {
                    let (wrench, force, moment) = self.pocket_part(first, &balls.motion, &displaced.pose);
                    (reaction.cage_force, reaction.cage_moment) = (force, moment);
                    (&pocket, wrench)
                } else {
                    let part = self.inner_part(first, &balls, displaced);
                    reaction.spindle = part.on_spindle;
                    reacting.on_tilt = part.on_tilt;
                    (&inner, part.wrench)
                };
                reacting.reaction.sum_into(&mut sums[column].0, count);
                reacting.add_on_tilt(&mut sums[column].1, count);
                let mut change = Wrench::<Lanes>::default();
                for lane in 0..LANES {
                    change.put(lane, is.at(lane).less(&was.at(lane)));
                }
                let response = self.ball_response(first, &balls.motion, &change);
                let per = 1.0 / of_border[column];
                let (response, part) = (response.entries(PLANAR), jacobian.right.group_mut(group));
                for row in 0..motion {
                    for lane in 0..LANES {
                        part[row * border + column][lane] = share[lane] * (response[row][lane] * per);
                    }
                }
            }
        }

        if let Some(contact) = &self.mechanism().neighbours {
            self.add_neighbour_blocks(contact, state, &at_rest.rotations, jacobian);
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

    /// Rates of cage and spindle under a reaction, in their order.
    #[inline(always)]
    fn border_rates(&self, border: &Border, (reaction, on_tilt): &(Reaction, Vector)) -> [f64; MAX_BORDER] {
        let cage = self.cage_rates(border, reaction);
        let spindle = self.spindle_rates(border, reaction.spindle, *on_tilt);
        self.mechanism().layout.border(&cage, &spindle)
    }

    /// Rates of cage and spindle caused by a reaction and a moment on the spindle, in their order.
    #[inline(always)]
    fn border_response(&self, border: &Border, reaction: &Reaction, on_tilt: Vector) -> [f64; MAX_BORDER] {
        let cage = self.cage_response(&border.pose, reaction);
        let spindle = self.spindle_response(reaction.spindle, on_tilt, border.spindle.tilt);
        self.mechanism().layout.border(&cage, &spindle)
    }
}
