//! Contact of neighbouring balls where no cage keeps them apart. Equal and opposite forces act on both, which is added to
//! rates that know each ball alone.

use super::equations::Dynamics;
use super::forces::Wrench;
use crate::numerics::ode::structure::Jacobian;
use crate::physics::ball::BallMotion;
use crate::physics::frames::{add, subtract};
use crate::physics::neighbour::{NeighbourContact, NeighbourLoad, NeighbourMotion};
use crate::simulation::model::mechanism::Rotations;
use crate::simulation::model::state::BallState;

/// Load of the second ball on the first; `oversize`: sum of their radii less twice the nominal one [m].
#[inline(always)]
fn load(contact: &NeighbourContact, first: &BallMotion, second: &BallMotion, oversize: f64) -> NeighbourLoad {
    let place = |ball: &BallMotion| ball.azimuth.to_inertial([ball.axial, ball.radius, 0.0]);
    let velocity = |ball: &BallMotion| ball.azimuth.to_inertial(ball.velocity);
    let spin = |ball: &BallMotion| ball.azimuth.to_inertial(ball.spin);
    contact.load(&NeighbourMotion {
        displacement: subtract(place(first), place(second)),
        velocity: subtract(velocity(first), velocity(second)),
        spin: add(spin(first), spin(second)),
        oversize,
    })
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    #[inline(always)]
    fn ball_motion(&self, y: &[f64], ball: usize, rotations: &Rotations) -> BallMotion {
        self.one().motion(self.mechanism().start.angle[ball], &self.layout().ball(y, ball), rotations)
    }

    /// Adds the contacts of neighbouring balls to the rates of all balls, and passes the load of each ball's next one to `seen`. A pair of
    /// balls has one contact.
    #[inline(always)]
    pub(super) fn add_neighbours(
        &self,
        contact: &NeighbourContact,
        (y, dy): (&[f64], &mut [f64]),
        rotations: &Rotations,
        mut seen: impl FnMut(usize, &NeighbourLoad),
    ) {
        let (one, layout) = (*self.one(), self.layout());
        let last = layout.balls - 1;
        let first = self.ball_motion(y, 0, rotations);
        let mut ball = first;
        for index in 0..if last == 1 { 1 } else { layout.balls } {
            let next_index = if index == last { 0 } else { index + 1 };
            let next = if index == last { first } else { self.ball_motion(y, next_index, rotations) };
            let load = load(contact, &ball, &next, self.mechanism().sum_of_oversizes(index, next_index));
            if load.normal > 0.0 {
                for (index, motion, side) in [(index, &ball, 1.0), (next_index, &next, -1.0)] {
                    let force = motion.azimuth.to_orbit(load.force).map(|force| side * force);
                    let moment = motion.azimuth.to_orbit(load.moment);
                    let response = one.response(motion, &self.mechanism().body(index), Wrench { force, moment });
                    let rates = layout.ball(dy, index).combined(1.0, &response, 1.0);
                    layout.set_ball(dy, index, &rates);
                }
            }
            seen(index, &load);
            ball = next;
        }
    }

    /// Adds the effect of each ball on itself to a Jacobian. Its effect on its neighbours stands outside the blocks: methods
    /// that iterate with this Jacobian take it from the rates.
    #[inline(always)]
    pub(super) fn add_neighbour_blocks(
        &self,
        contact: &NeighbourContact,
        y: &[f64],
        rotations: &Rotations,
        jacobian: &mut Jacobian,
    ) {
        let (one, layout) = (*self.one(), self.layout());
        let (balls, motion) = (layout.balls, layout.motion_size());
        let motions: Vec<BallMotion> = (0..balls).map(|ball| self.ball_motion(y, ball, rotations)).collect();
        for ball in 0..balls {
            let body = self.mechanism().body(ball);
            let (before, after) = ((ball + balls - 1) % balls, (ball + 1) % balls);
            let sides = if before == after { &[after][..] } else { &[before, after] };
            let loads = |motion: &BallMotion| {
                let mut wrench = Wrench::default();
                for &side in sides {
                    let NeighbourLoad { force, moment, .. } =
                        load(contact, motion, &motions[side], self.mechanism().sum_of_oversizes(ball, side));
                    let [force, moment] = [force, moment].map(|v| motion.azimuth.to_orbit(v));
                    wrench = wrench.and(Wrench { force, moment });
                }
                one.response(motion, &body, wrench).entries(PLANAR)
            };
            let undisplaced = loads(&motions[ball]);
            let own = layout.ball(y, ball).entries(PLANAR);
            for column in 0..motion {
                let by = self.displacements()[column];
                let mut entries = own;
                entries[column] += by;
                let state = BallState::from_entries(entries, PLANAR);
                let displaced = loads(&one.motion(self.mechanism().start.angle[ball], &state, rotations));
                for row in 0..motion {
                    *jacobian.blocks.entry_mut(ball, row, column) += (displaced[row] - undisplaced[row]) / by;
                }
            }
        }
    }
}
