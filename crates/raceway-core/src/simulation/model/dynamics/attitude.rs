//! Attitude of balls whose surfaces are not those of spheres. The state holds the deviation D from ideal rolling, so that
//!
//! ```text
//! ball's axes in the orbit frame = Rₓ(β) D · axes at the start,     D' = ½ u D,   u = Rₓ(−β) (spin in the orbit frame less that of ideal rolling)
//! ```
//!
//! with the turn β of ideal rolling. In the plane D is an angle about X.

use std::f64::consts::PI;

use super::contact_frame::{ContactFrame, TiltedFrame};
use super::equations::Dynamics;
use super::one_ball::OneBall;
use crate::numerics::angle::sin_cos;
use crate::numerics::lanes::{LANES, Lanes, SideBySide, Task};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Vector, add, cross, dot, scale};
use crate::physics::raceway::{OnBall, RelativeMotion};
use crate::physics::surface::sphere::BallPose;
use crate::simulation::model::mechanism::Rotations;
use crate::simulation::model::state::{BallAttitude, BallState};

/// A rotation as a quaternion: scalar and vector.
type Quaternion = (f64, Vector);

#[inline(always)]
fn product((a, u): Quaternion, (b, v): Quaternion) -> Quaternion {
    (a * b - dot(u, v), add(cross(u, v), add(scale(a, v), scale(b, u))))
}

#[inline(always)]
fn about_x(angle: f64) -> Quaternion {
    let (sine, cosine) = sin_cos(0.5 * angle);
    (cosine, [sine, 0.0, 0.0])
}

/// The rotation by a vector [rad].
#[inline(always)]
fn exponential(turn: Vector) -> Quaternion {
    let half = 0.5 * dot(turn, turn).sqrt();
    let (sine, cosine) = sin_cos(half);
    // sin x/x is 1 to rounding below.
    let per_turn = if half > 1e-9 { 0.5 * sine / half } else { 0.5 };
    (cosine, scale(per_turn, turn))
}

/// A vector after a rotation and then one about X. The quaternion may have any length.
#[inline(always)]
fn turned((real, vector): Quaternion, axis: Vector, about_x: Azimuth) -> Vector {
    let twice = 2.0 / (real * real + dot(vector, vector));
    let across = cross(vector, axis);
    about_x.to_inertial(add(axis, scale(twice, add(scale(real, across), cross(vector, across)))))
}

impl BallAttitude {
    #[inline(always)]
    fn quaternion(&self) -> Quaternion {
        let [real, x, y, z] = self.0;
        (1.0 + real, [x, y, z])
    }

    /// Axes in the orbit frame that lay in given directions at the start and roll ideally but for this deviation.
    #[inline(always)]
    pub(crate) fn axes(&self, at_start: &[Vector; 3], ideal: Azimuth, planar: bool) -> [Vector; 3] {
        if planar {
            let turned = ideal.turned(Azimuth::new(self.0[0]));
            return at_start.map(|axis| turned.to_inertial(axis));
        }
        let quaternion = self.quaternion();
        // One by one: the closure of `map` would be a call, and balls would no longer stand side by side.
        let [one, two, three] = *at_start;
        [turned(quaternion, one, ideal), turned(quaternion, two, ideal), turned(quaternion, three, ideal)]
    }
}

impl OneBall {
    /// Spin in the orbit frame less that of ideal rolling [rad/s].
    #[inline(always)]
    fn turning(&self, state: &BallState) -> Vector {
        let [x, r, t] = state.spin;
        [x - state.arc_velocity / self.pitch_radius, r, t]
    }

    /// Rates of an attitude; `ideal`: the turn of ideal rolling.
    #[inline(always)]
    pub(super) fn attitude_rates<const PLANAR: bool>(
        &self,
        state: &BallState,
        attitude: &BallAttitude,
        ideal: Azimuth,
    ) -> BallAttitude {
        let turning = self.turning(state);
        if PLANAR {
            return BallAttitude([turning[0], 0.0, 0.0, 0.0]);
        }
        let (real, [x, y, z]) = product((0.0, scale(0.5, ideal.to_orbit(turning))), attitude.quaternion());
        BallAttitude([real, x, y, z])
    }

    /// Attitude after a time step in which spin and orbit velocity change linearly. `ideal`: turns of ideal rolling before and after it.
    /// Rotations about one axis are exact for steps of any length.
    #[inline(always)]
    pub(super) fn advanced<const PLANAR: bool>(
        &self,
        attitude: &BallAttitude,
        [before, after]: [&BallState; 2],
        ideal: [f64; 2],
        step: f64,
    ) -> BallAttitude {
        let turn = scale(0.5 * step, add(self.turning(before), self.turning(after)));
        if PLANAR {
            return BallAttitude([attitude.0[0] + turn[0], 0.0, 0.0, 0.0]);
        }
        let rolled = exponential([turn[0] + (ideal[1] - ideal[0]), turn[1], turn[2]]);
        let at_start = product(about_x(ideal[0]), attitude.quaternion());
        let (real, [x, y, z]) = product(about_x(-ideal[1]), product(rolled, at_start));
        BallAttitude([real - 1.0, x, y, z])
    }
}

/// Rates of the attitudes of balls side by side.
struct Rates<'a, const PLANAR: bool> {
    one: &'a OneBall,
    state: &'a BallState<Lanes>,
    attitude: &'a BallAttitude<Lanes>,
    ideal: Azimuth,
}

impl<const PLANAR: bool> Task for Rates<'_, PLANAR> {
    type Answer = BallAttitude<Lanes>;

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { one, state, attitude, ideal } = self;
        // A copy, so that the compiler knows that stores in the loop do not change it.
        let one = *one;
        let mut rates = BallAttitude::default();
        for lane in 0..LANES {
            rates.put(lane, one.attitude_rates::<PLANAR>(&state.at(lane), &attitude.at(lane), ideal));
        }
        rates
    }
}

/// Attitudes of balls side by side after a time step.
struct Advanced<'a, const PLANAR: bool> {
    one: &'a OneBall,
    attitude: &'a BallAttitude<Lanes>,
    states: [&'a BallState<Lanes>; 2],
    ideal: [f64; 2],
    step: f64,
}

impl<const PLANAR: bool> Task for Advanced<'_, PLANAR> {
    type Answer = BallAttitude<Lanes>;

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { one, attitude, states: [before, after], ideal, step } = self;
        let one = *one;
        let mut advanced = BallAttitude::default();
        for lane in 0..LANES {
            let states = [&before.at(lane), &after.at(lane)];
            advanced.put(lane, one.advanced::<PLANAR>(&attitude.at(lane), states, ideal, step));
        }
        advanced
    }
}

/// Poses of balls side by side in the frames of their outer contacts. `at_start`: their axes at the start; `turn`: of ideal rolling.
struct Poses<'a, const PLANAR: bool> {
    attitude: &'a BallAttitude<Lanes>,
    at_start: [Vector<Lanes>; 3],
    turn: f64,
}

impl<const PLANAR: bool> Task for Poses<'_, PLANAR> {
    type Answer = BallPose<Lanes>;

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { attitude, at_start, turn } = self;
        let ideal = Azimuth::new(turn);
        let mut poses = BallPose::default();
        for lane in 0..LANES {
            let attitude = attitude.at(lane);
            let pose = match PLANAR {
                true => BallPose { longitude: -(turn + attitude.0[0]), ..BallPose::default() },
                false => BallPose { longitude: 0.0, axes: attitude.axes(&at_start.at(lane), ideal, false) },
            };
            poses.put(lane, pose);
        }
        poses
    }
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    /// Rates of the attitudes of balls side by side.
    #[inline(never)]
    pub(super) fn attitude_rates(
        &self,
        state: &BallState<Lanes>,
        attitude: &BallAttitude<Lanes>,
        rotations: &Rotations,
    ) -> BallAttitude<Lanes> {
        let ideal = Azimuth::new(rotations.turn);
        self.instructions().run(Rates::<PLANAR> { one: self.one(), state, attitude, ideal })
    }

    /// Attitudes of balls side by side after a time step. `states`, `rotations`: before and after it.
    #[inline(never)]
    pub(super) fn advanced_attitudes(
        &self,
        attitude: &BallAttitude<Lanes>,
        states: [&BallState<Lanes>; 2],
        rotations: [&Rotations; 2],
        step: f64,
    ) -> BallAttitude<Lanes> {
        let ideal = rotations.map(|rotations| rotations.turn);
        self.instructions().run(Advanced::<PLANAR> { one: self.one(), attitude, states, ideal, step })
    }

    /// Effects of sizes and surfaces of the balls from `first` on both contacts. Nominal spheres have none, and need no call.
    #[inline(never)]
    pub(super) fn on_balls<F: ContactFrame>(
        &self,
        first: usize,
        attitude: Option<&[BallAttitude<Lanes>; 2]>,
        relative: &PerRaceway<RelativeMotion<Lanes>>,
        (frames, outer_frames): (&F::Several, Option<&TiltedFrame<Lanes>>),
        rotations: &Rotations,
    ) -> PerRaceway<OnBall<Lanes>> {
        let inner = self.on_balls_at_inner::<F>(first, attitude, &relative.inner, frames, rotations);
        let mut outer = OnBall::default();
        if let Some([attitude, _]) = attitude {
            let mut poses = self.poses(first, attitude, rotations);
            if let Some(frames) = outer_frames {
                poses = self.poses_in::<TiltedFrame>(&poses, frames, 0.0);
            }
            let raceway = &self.mechanism().raceway.outer;
            outer = raceway.on_balls::<PLANAR>(first, &relative.outer, &poses, self.instructions());
        }
        PerRaceway { inner, outer: outer.grown(&self.mechanism().bodies[first / LANES].oversize) }
    }

    /// The same on the inner contacts alone.
    #[inline(never)]
    pub(super) fn on_balls_at_inner<F: ContactFrame>(
        &self,
        first: usize,
        attitude: Option<&[BallAttitude<Lanes>; 2]>,
        relative: &RelativeMotion<Lanes>,
        frames: &F::Several,
        rotations: &Rotations,
    ) -> OnBall<Lanes> {
        let mut on_balls = OnBall::default();
        if let Some([attitude, _]) = attitude {
            let poses = self.poses_in::<F>(&self.poses(first, attitude, rotations), frames, PI);
            let raceway = &self.mechanism().raceway.inner;
            on_balls = raceway.on_balls::<PLANAR>(first, relative, &poses, self.instructions());
        }
        on_balls.grown(&self.mechanism().bodies[first / LANES].oversize)
    }

    /// Poses of the balls from `first` on in their orbit frames, which are those of the contacts with an outer ring at the origin.
    fn poses(&self, first: usize, attitude: &BallAttitude<Lanes>, rotations: &Rotations) -> BallPose<Lanes> {
        let mut at_start = <[Vector<Lanes>; 3]>::default();
        for (lane, ball) in self.mechanism().uneven_balls[first..].iter().take(LANES).enumerate() {
            at_start.put(lane, ball.axes);
        }
        self.instructions().run(Poses::<PLANAR> { attitude, at_start, turn: rotations.turn })
    }

    /// Poses in the frames of contacts of balls in some poses in their orbit frames. In the plane the contact lies `across` further on the ball.
    fn poses_in<F: ContactFrame>(&self, orbit: &BallPose<Lanes>, frames: &F::Several, across: f64) -> BallPose<Lanes> {
        let mut poses = BallPose::<Lanes>::default();
        for lane in 0..LANES {
            let (pose, frame) = (orbit.at(lane), frames.at(lane));
            let pose = match PLANAR {
                true => BallPose { longitude: pose.longitude + (across + frame.turn()), ..pose },
                false => BallPose { axes: pose.axes.map(|axis| frame.components(axis)), ..pose },
            };
            poses.put(lane, pose);
        }
        poses
    }
}
