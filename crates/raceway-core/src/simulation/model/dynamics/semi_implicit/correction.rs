//! Correction of balls and cage from their predicted state by small linear systems, and its reaction on cage and spindle.

use std::array::from_fn;

use crate::numerics::lanes::{LANES, Lanes, SideBySide, larger, side_by_side};
use crate::physics::ball::{BallBody, BallMotion, Bodies};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Vector, add, cross, dot, scale};
use crate::physics::pocket::PocketSlopes;
use crate::physics::raceway::ContactSlopes;
use crate::simulation::model::dynamics::ball_group::{Balls, Slopes};
use crate::simulation::model::dynamics::equations::Dynamics;
use crate::simulation::model::dynamics::forces::Reaction;
use crate::simulation::model::state::{BallState, CageState};
use crate::simulation::model::step_loads::StepLoads;

/// Reaction on cage and spindle per unit of their own motion: stiffness and damping, weighted by the shares of a step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stiff<T = f64> {
    /// Spindle, by direction of the inertial frame, times the step's shares [kg].
    pub spindle: Vector<T>,
    /// Cage, along and about its axes, times the step's share [N s/m, N m s].
    pub cage: Vector<T>,
    pub about: Vector<T>,
}
side_by_side!(Stiff { spindle, cage, about });

impl Stiff<Lanes> {
    /// Adds the first `balls` lanes to `sum`, one ball after the other.
    #[inline(always)]
    pub(crate) fn sum_into(&self, sum: &mut Stiff, balls: usize) {
        for lane in 0..LANES.min(balls) {
            let one = self.at(lane);
            for i in 0..3 {
                sum.spindle[i] += one.spindle[i];
                sum.cage[i] += one.cage[i];
                sum.about[i] += one.about[i];
            }
        }
    }
}

/// Forces and moments of the balls on a ring per unit of its own displacement and velocity, over x, y, z and the tilts about Y and Z.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RingResistance {
    /// [N/m, N, N m]
    pub stiffness: [[f64; 5]; 5],
    /// [N s/m, N s, N m s]
    pub damping: [[f64; 5]; 5],
}

impl RingResistance {
    /// Adds that of a contact of a ball. `lever`: of the contact's point, in the inertial frame.
    fn add(&mut self, motion: &BallMotion, contact: &ContactSlopes, lever: Vector) {
        let (axial, radial) = contact.towards;
        let normal = motion.azimuth.to_inertial([axial, radial, 0.0]);
        let [x, y, z] = normal;
        let [_, about_y, about_z] = cross(lever, normal);
        let along = [x, y, z, about_y, about_z];
        for (row, one) in along.into_iter().enumerate() {
            for (column, other) in along.into_iter().enumerate() {
                self.stiffness[row][column] += contact.stiffness * one * other;
                self.damping[row][column] += contact.damping * one * other;
            }
        }
    }
}

/// The point of a contact of a ball, in the inertial frame [m].
fn lever(motion: &BallMotion, contact: &ContactSlopes, radius: f64) -> Vector {
    let (axial, radial) = contact.towards;
    motion.azimuth.to_inertial([motion.axial + radius * axial, motion.radius + radius * radial, 0.0])
}

/// Balls at the end of a step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corrected {
    pub state: BallState<Lanes>,
    pub rates: BallState<Lanes>,
    /// Reaction of the correction on cage and spindle.
    pub reaction: Reaction<Lanes>,
    /// Loads and slip after the correction.
    pub loads: StepLoads<Lanes>,
}

/// Corrected state and rates of the cage. Places follow from the predicted rates and the corrections of the velocities.
pub(super) fn corrected_cage(
    past: &CageState,
    predicted: &CageState,
    rates: &CageState,
    stiffness: &CageState,
    share: f64,
) -> (CageState, CageState) {
    let change = |past: f64, predicted: f64, rate: f64, stiffness: f64| {
        (past + share * rate - predicted) / (1.0 + share * stiffness)
    };
    let velocity: Vector =
        from_fn(|i| change(past.velocity[i], predicted.velocity[i], rates.velocity[i], stiffness.velocity[i]));
    let arc = change(past.arc_velocity, predicted.arc_velocity, rates.arc_velocity, stiffness.arc_velocity);
    let tilt: [f64; 2] =
        from_fn(|i| change(past.tilt_rate[i], predicted.tilt_rate[i], rates.tilt_rate[i], stiffness.tilt_rate[i]));
    let state = CageState {
        centre: from_fn(|i| past.centre[i] + share * (rates.centre[i] + velocity[i])),
        arc: past.arc + share * (rates.arc + arc),
        tilt: from_fn(|i| past.tilt[i] + share * (rates.tilt[i] + tilt[i])),
        velocity: from_fn(|i| predicted.velocity[i] + velocity[i]),
        arc_velocity: predicted.arc_velocity + arc,
        tilt_rate: from_fn(|i| predicted.tilt_rate[i] + tilt[i]),
    };
    (state, state.combined(1.0 / share, past, -1.0 / share))
}

/// Solution of a symmetric, positive definite system of three equations; the matrix as xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn solve([xx, xy, xz, yy, yz, zz]: [f64; 6], [a, b, c]: Vector) -> Vector {
    let (xx_, xy_, xz_) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let per_determinant = 1.0 / (xx * xx_ + xy * xy_ + xz * xz_);
    let (yy_, yz_, zz_) = (xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy);
    [
        per_determinant * (xx_ * a + xy_ * b + xz_ * c),
        per_determinant * (xy_ * a + yy_ * b + yz_ * c),
        per_determinant * (xz_ * a + yz_ * b + zz_ * c),
    ]
}

/// Adds a contact to the system of a ball: the outer product of a direction with itself, times its strength.
#[inline(always)]
fn add_product(matrix: &mut [f64; 6], strength: f64, [x, y, z]: Vector) {
    let [sx, sy] = [strength * x, strength * y];
    matrix[0] += sx * x;
    matrix[1] += sx * y;
    matrix[2] += sx * z;
    matrix[3] += sy * y;
    matrix[4] += sy * z;
    matrix[5] += strength * z * z;
}

/// Resistance of one contact over a step: directions with their strengths [N s/m]. The components of the first three directions are
/// axial velocity, radial velocity and spin about the orbit; those of the last are orbit velocity, spin about x and spin about the
/// radius.
struct Resistance {
    normal: (f64, Vector),
    turning: (f64, Vector),
    across: (f64, Vector),
    along: (f64, Vector),
}

impl Resistance {
    #[inline(always)]
    fn of(slopes: &ContactSlopes, radius: f64, share: f64) -> Self {
        let (a, r) = slopes.towards;
        Self {
            normal: (share * slopes.stiffness + slopes.damping, [a, r, 0.0]),
            turning: (share * slopes.turning, [-r, a, 0.0]),
            across: (slopes.grip, [-r, a, radius]),
            along: (slopes.grip, [1.0, radius * r, -radius * a]),
        }
    }

    /// Adds the resistance to both systems.
    #[inline(always)]
    fn add_to(&self, meridian: &mut [f64; 6], orbit: &mut [f64; 6]) {
        add_product(meridian, self.normal.0, self.normal.1);
        add_product(meridian, self.turning.0, self.turning.1);
        add_product(meridian, self.across.0, self.across.1);
        add_product(orbit, self.along.0, self.along.1);
    }

    /// Force on the ball caused by a change of its velocities [N].
    #[inline(always)]
    fn force(&self, meridian: Vector, orbit: Vector) -> Vector {
        let pull = |(strength, direction): (f64, Vector), change: Vector| -strength * dot(direction, change);
        let (normal, turning, across) =
            (pull(self.normal, meridian), pull(self.turning, meridian), pull(self.across, meridian));
        let in_plane = |i: usize| normal * self.normal.1[i] + turning * self.turning.1[i] + across * self.across.1[i];
        [in_plane(0), in_plane(1), pull(self.along, orbit)]
    }

    /// Normal load after a change of the ball's velocities, not negative [N].
    #[inline(always)]
    fn load(&self, before: f64, meridian: Vector) -> f64 {
        larger(before + self.normal.0 * dot(self.normal.1, meridian), 0.0)
    }

    /// Square of the slip after such a change [m²/s²].
    #[inline(always)]
    fn slip_square(&self, (along, across): (f64, f64), meridian: Vector, orbit: Vector) -> f64 {
        let (along, across) = (along - dot(self.along.1, orbit), across - dot(self.across.1, meridian));
        along * along + across * across
    }
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    /// Balls from `first` on at the end of a step: one step of Newton from the predicted state.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn correct(
        &self,
        first: usize,
        past: &BallState<Lanes>,
        predicted: &BallState<Lanes>,
        balls: &Balls,
        slopes: &Slopes<Lanes>,
        share: f64,
        corrected: &mut Corrected,
    ) {
        match self.mechanism().unequal_bodies(first) {
            None => self.correct_bodies(self.one().body, past, predicted, balls, slopes, share, corrected),
            Some(bodies) => self.correct_bodies(*bodies, past, predicted, balls, slopes, share, corrected),
        }
    }

    /// Correction of balls of some size and mass.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn correct_bodies(
        &self,
        bodies: impl Bodies,
        past: &BallState<Lanes>,
        predicted: &BallState<Lanes>,
        balls: &Balls,
        slopes: &Slopes<Lanes>,
        share: f64,
        corrected: &mut Corrected,
    ) {
        let nominal = self.mechanism().ball_radius;
        let (mass_over_share, inertia_over_share) = bodies.over(share);
        for lane in 0..LANES {
            let BallBody { oversize, mass, inertia, .. } = bodies.of(lane);
            let radius = nominal + oversize;
            let (old, from, rates) = (past.at(lane), predicted.at(lane), balls.rates.at(lane));
            let PerRaceway { inner, outer } =
                PerRaceway { inner: slopes.raceway.inner.at(lane), outer: slopes.raceway.outer.at(lane) };
            let PocketSlopes { normal, stiffness, damping } = slopes.pocket.at(lane);
            let pocket = share * stiffness + damping;
            let inner = Resistance::of(&inner, radius, share);
            let outer = Resistance::of(&outer, radius, share);

            let (m, i) = (mass_over_share[lane], inertia_over_share[lane]);
            let (mut meridian, mut orbit) = ([m, 0.0, 0.0, m, 0.0, i], [m, 0.0, 0.0, i, 0.0, i]);
            inner.add_to(&mut meridian, &mut orbit);
            outer.add_to(&mut meridian, &mut orbit);
            add_product(&mut meridian, pocket, [normal[0], normal[1], 0.0]);
            orbit[0] += pocket * normal[2] * normal[2];

            let missing = |old: f64, from: f64, rate: f64| (old - from) / share + rate;
            let in_plane = solve(
                meridian,
                [
                    mass * missing(old.axial_velocity, from.axial_velocity, rates.axial_velocity),
                    mass * missing(old.radial_velocity, from.radial_velocity, rates.radial_velocity),
                    inertia * missing(old.spin[2], from.spin[2], rates.spin[2]),
                ],
            );
            let along = solve(
                orbit,
                [
                    mass * missing(old.arc_velocity, from.arc_velocity, rates.arc_velocity),
                    inertia * missing(old.spin[0], from.spin[0], rates.spin[0]),
                    inertia * missing(old.spin[1], from.spin[1], rates.spin[1]),
                ],
            );
            // The planar model drops the axial corrections, which only pockets of a tilted cage would cause.
            let (in_plane, along) = match PLANAR {
                true => ([0.0, in_plane[1], 0.0], [along[0], along[1], 0.0]),
                false => (in_plane, along),
            };
            let state = BallState {
                axial: from.axial + share * in_plane[0],
                radial: from.radial + share * in_plane[1],
                arc: from.arc + share * along[0],
                axial_velocity: from.axial_velocity + in_plane[0],
                radial_velocity: from.radial_velocity + in_plane[1],
                arc_velocity: from.arc_velocity + along[0],
                spin: [from.spin[0] + along[1], from.spin[1] + along[2], from.spin[2] + in_plane[2]],
            };
            corrected.state.put(lane, state);
            corrected.rates.put(lane, state.combined(1.0 / share, &old, -1.0 / share));
            // Reaction of the correction on spindle and cage.
            let azimuth = balls.motion.azimuth.at(lane);
            let spindle = scale(-1.0, azimuth.to_inertial(inner.force(in_plane, along)));
            let pull = pocket * dot(normal, [in_plane[0], in_plane[1], along[0]]);
            let cage_force = scale(pull, azimuth.to_inertial(normal));
            let cage_moment = cross(slopes.arm.at(lane), cage_force);
            corrected.reaction.put(lane, Reaction { spindle, cage_force, cage_moment });
            let before = slopes.loads.at(lane);
            let slip = slopes.slip.at(lane);
            corrected.loads.put(
                lane,
                StepLoads {
                    load: PerRaceway {
                        inner: inner.load(before.load.inner, in_plane),
                        outer: outer.load(before.load.outer, in_plane),
                    },
                    slip_square: PerRaceway {
                        inner: inner.slip_square(slip.inner, in_plane, along),
                        outer: outer.slip_square(slip.outer, in_plane, along),
                    },
                    pocket: larger(before.pocket - pull, 0.0),
                    ..before
                },
            );
        }
    }

    /// Resistance of the balls to motion of spindle and cage. `shares`: of the spindle's place and velocity in a step; `share`: of the
    /// cage's places.
    #[inline(always)]
    pub(super) fn stiffness(
        &self,
        balls: &Balls,
        slopes: &Slopes<Lanes>,
        shares: (f64, f64),
        share: f64,
    ) -> Stiff<Lanes> {
        let mut stiff = Stiff::default();
        for lane in 0..LANES {
            let (azimuth, inner, pocket) =
                (balls.motion.azimuth.at(lane), slopes.raceway.inner.at(lane), slopes.pocket.at(lane));
            let normal = azimuth.to_inertial([inner.towards.0, inner.towards.1, 0.0]);
            let strength = shares.0 * inner.stiffness + shares.1 * inner.damping;
            let of_pocket = share * pocket.stiffness + pocket.damping;
            let push = azimuth.to_inertial(pocket.normal);
            let turn = cross(slopes.arm.at(lane), push);
            stiff.put(
                lane,
                Stiff {
                    spindle: normal.map(|n| strength * n * n),
                    cage: push.map(|n| of_pocket * n * n),
                    about: turn.map(|n| of_pocket * n * n),
                },
            );
        }
        stiff
    }

    /// Adds the moments on the ring that the corrections of the first `count` balls cause, and their resistance to its motion. The force of
    /// a contact acts at its point.
    pub(super) fn add_to_ring(
        &self,
        count: usize,
        (balls, slopes, corrected): (&Balls, &Slopes<Lanes>, &Corrected),
        moment: &mut Vector,
        resistance: &mut RingResistance,
    ) {
        for lane in 0..LANES.min(count) {
            let (motion, inner) = (balls.motion.at(lane), slopes.raceway.inner.at(lane));
            let lever = lever(&motion, &inner, self.mechanism().ball_radius);
            *moment = add(*moment, cross(lever, corrected.reaction.at(lane).spindle));
            resistance.add(&motion, &inner, lever);
        }
    }

    /// Adds forces and moments on an outer ring that moves, caused by the corrections of the first `count` balls, and their resistance to its motion.
    pub(super) fn add_to_outer(
        &self,
        count: usize,
        (balls, slopes, predicted, corrected): (&Balls, &Slopes<Lanes>, &BallState<Lanes>, &Corrected),
        share: f64,
        on_ring: &mut [Vector; 2],
        resistance: &mut RingResistance,
    ) {
        let radius = self.mechanism().ball_radius;
        for lane in 0..LANES.min(count) {
            let (motion, outer) = (balls.motion.at(lane), slopes.raceway.outer.at(lane));
            let change = corrected.state.at(lane).combined(1.0, &predicted.at(lane), -1.0);
            let in_plane = [change.axial_velocity, change.radial_velocity, change.spin[2]];
            let along = [change.arc_velocity, change.spin[0], change.spin[1]];
            let on_ball = Resistance::of(&outer, radius, share).force(in_plane, along);
            let force = scale(-1.0, motion.azimuth.to_inertial(on_ball));
            let lever = lever(&motion, &outer, radius);
            *on_ring = [add(on_ring[0], force), add(on_ring[1], cross(lever, force))];
            resistance.add(&motion, &outer, lever);
        }
    }

    /// Resistance of the balls to the cage's velocities [1/s].
    pub(super) fn cage_stiffness(&self, stiff: &Stiff) -> CageState {
        let cage = &self.mechanism().cage;
        let [x, y, z] = stiff.about;
        CageState {
            velocity: stiff.cage.map(|s| s / cage.mass),
            arc_velocity: x / cage.axial_inertia,
            tilt_rate: [y / cage.transverse_inertia, z / cage.transverse_inertia],
            ..CageState::default()
        }
    }
}
