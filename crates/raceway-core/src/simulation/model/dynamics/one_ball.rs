//! Constants and formulas of one ball between its raceways and in its pocket.

use super::border::{CagePose, OuterRing};
use super::contact_frame::{ContactFrame, TiltedFrame};
use super::forces::Wrench;
use crate::numerics::lanes::{LANES, Lanes, SideBySide};
use crate::physics::ball::{BallAcceleration, BallBody, BallMotion, Bodies};
use crate::physics::cage::CageMotion;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, scale, subtract};
use crate::physics::pocket::{PocketLoad, PocketMotion};
use crate::physics::raceway::{RacewayLoad, RelativeMotion};
use crate::simulation::model::mechanism::Rotations;
use crate::simulation::model::state::{BallState, SpindleState};

/// Constants of one ball, and its formulas. Each loop over balls has its own copy, so that the compiler knows that no store in the
/// loop changes it.
#[derive(Debug, Clone, Copy)]
pub(super) struct OneBall {
    pub pitch_radius: f64,
    pub gravity: f64,
    /// A nominal ball.
    pub body: BallBody,
    /// Axial displacement at which the spindle is held [m].
    pub axial_offset: f64,
    /// Centre of the first pocket, in the orbit frame of the cage.
    pub pocket_centre: Vector,
}

impl OneBall {
    #[inline(always)]
    pub(super) fn motion(&self, start: f64, state: &BallState, rotations: &Rotations) -> BallMotion {
        let per_radius = 1.0 / self.pitch_radius;
        let azimuth = start + rotations.orbit.angle + state.arc * per_radius;
        let radius = self.pitch_radius + state.radial;
        let orbit_speed = rotations.orbit.speed + state.arc_velocity * per_radius;
        BallMotion {
            azimuth_angle: azimuth,
            azimuth: Azimuth::new(azimuth),
            axial: state.axial,
            radius,
            orbit_speed,
            velocity: [state.axial_velocity, state.radial_velocity, radius * orbit_speed],
            spin: [state.spin[0] + rotations.spin.speed, state.spin[1], state.spin[2]],
        }
    }

    /// Motion relative to the outer raceway.
    #[inline(always)]
    pub(crate) fn over_outer(&self, motion: &BallMotion, rotations: &Rotations) -> RelativeMotion {
        RelativeMotion {
            axial: motion.axial,
            radius: motion.radius,
            velocity: motion.velocity,
            spin: motion.spin,
            raceway_speed: rotations.outer.speed,
            orbit_speed: motion.orbit_speed,
            azimuth: motion.azimuth_angle - rotations.outer.angle,
        }
    }

    /// Motion relative to the raceway of an outer ring that moves, and the frame of its components.
    #[inline(always)]
    pub(crate) fn over_moving_outer(
        &self,
        motion: &BallMotion,
        ring: &OuterRing,
        rotations: &Rotations,
    ) -> (RelativeMotion, TiltedFrame) {
        let fixed = Self { axial_offset: 0.0, ..*self };
        let as_inner = Rotations { inner: rotations.outer, ..*rotations };
        fixed.over_inner::<TiltedFrame>(motion, &ring.state, &as_inner, &ring.axis)
    }

    /// Motion relative to the inner raceway, and the frame of its components.
    #[inline(always)]
    pub(crate) fn over_inner<F: ContactFrame>(
        &self,
        motion: &BallMotion,
        spindle: &SpindleState,
        rotations: &Rotations,
        axis: &F::Axis,
    ) -> (RelativeMotion, F) {
        let [x, y, z] = spindle.position;
        let centre = motion.azimuth.to_orbit([x + self.axial_offset, y, z]);
        let velocity = motion.azimuth.to_orbit(spindle.velocity);
        let from_centre = [motion.axial - centre[0], motion.radius - centre[1], -centre[2]];
        let frame = F::new(axis, motion.azimuth, from_centre);
        let (axial, radius) = frame.place();
        let (carried, tilting) = F::carried(axis, motion.azimuth, from_centre);
        let relative = RelativeMotion {
            axial,
            radius,
            velocity: frame.components(subtract(subtract(motion.velocity, velocity), carried)),
            spin: frame.components(subtract(motion.spin, tilting)),
            raceway_speed: rotations.inner.speed,
            orbit_speed: motion.orbit_speed,
            azimuth: motion.azimuth_angle - rotations.inner.angle,
        };
        (relative, frame)
    }

    /// Motion relative to the pocket that starts at an azimuth, and the ball's place from the cage's centre of mass in the cage's
    /// tilted frame.
    #[inline(always)]
    pub(crate) fn in_pocket(&self, motion: &BallMotion, cage: &CagePose, start: Azimuth) -> (PocketMotion, Vector) {
        let CageMotion { centre, velocity, tilt, spin } = cage.motion;
        let azimuth = motion.azimuth;
        let place = tilt.to_tilted(subtract(azimuth.to_inertial([motion.axial, motion.radius, 0.0]), centre));
        let pocket = cage.azimuth.turned(start).to_inertial(self.pocket_centre);
        let relative = tilt.to_tilted(subtract(azimuth.to_inertial(motion.velocity), velocity));
        let motion = PocketMotion {
            displacement: subtract(place, pocket),
            velocity: subtract(relative, cross(spin, place)),
            spin: subtract(tilt.to_tilted(azimuth.to_inertial(motion.spin)), spin),
            oversize: 0.0,
        };
        (motion, place)
    }

    /// Rates of the ball's state under a wrench and its weight.
    #[inline(always)]
    pub(super) fn rates(
        &self,
        state: &BallState,
        motion: &BallMotion,
        body: &BallBody,
        wrench: Wrench,
        rotations: &Rotations,
    ) -> BallState {
        let Azimuth { cosine, sine } = motion.azimuth;
        let weight = body.mass * self.gravity;
        let force = add(wrench.force, [0.0, weight * cosine, -weight * sine]);
        let BallAcceleration { axial, radial, azimuthal, spin } = motion.acceleration(force, wrench.moment, body);
        BallState {
            axial: state.axial_velocity,
            radial: state.radial_velocity,
            arc: state.arc_velocity,
            axial_velocity: axial,
            radial_velocity: radial,
            arc_velocity: self.pitch_radius * (azimuthal - rotations.orbit.acceleration),
            spin: [spin[0] - rotations.spin.acceleration, spin[1], spin[2]],
        }
    }

    /// Rates of balls side by side caused by forces and moments alone.
    #[inline(always)]
    pub(super) fn responses(
        self,
        motion: &BallMotion<Lanes>,
        bodies: impl Bodies,
        wrench: &Wrench<Lanes>,
    ) -> BallState<Lanes> {
        let mut responses = BallState::<Lanes>::default();
        for lane in 0..LANES {
            responses.put(lane, self.response(&motion.at(lane), &bodies.of(lane), wrench.at(lane)));
        }
        responses
    }

    /// Rates of one ball caused by force and moment alone.
    #[inline(always)]
    pub(super) fn response(&self, motion: &BallMotion, body: &BallBody, wrench: Wrench) -> BallState {
        let still = BallMotion { orbit_speed: 0.0, ..*motion };
        let BallAcceleration { axial, radial, azimuthal, spin } = still.acceleration(wrench.force, wrench.moment, body);
        BallState {
            axial_velocity: axial,
            radial_velocity: radial,
            arc_velocity: self.pitch_radius * azimuthal,
            spin,
            ..BallState::default()
        }
    }
}

/// Load of a raceway on a ball, in its orbit frame, and of the ball on the ring, in the inertial frame.
#[inline(always)]
pub(super) fn on_inner(azimuth: Azimuth, frame: &impl ContactFrame, load: &RacewayLoad) -> (Wrench, Vector) {
    let force = frame.vector(load.force);
    (Wrench { force, moment: frame.vector(load.moment) }, scale(-1.0, azimuth.to_inertial(force)))
}

/// Moment of a ball on a ring about the ring's centre, in the inertial frame.
#[inline(always)]
pub(super) fn moment_on_ring(azimuth: Azimuth, frame: &impl ContactFrame, load: &RacewayLoad) -> Vector {
    let (axial, radius) = frame.place();
    let on_ball = add(cross([axial, radius, 0.0], load.force), load.moment);
    scale(-1.0, azimuth.to_inertial(frame.vector(on_ball)))
}

/// Load of a pocket on its ball, in the ball's orbit frame, and of the ball on the cage, in the cage's tilted frame about its centre
/// of mass.
#[inline(always)]
pub(super) fn on_pocket(azimuth: Azimuth, tilt: &Tilt, place: Vector, load: &PocketLoad) -> (Wrench, [Vector; 2]) {
    let to_orbit = |v| azimuth.to_orbit(tilt.to_inertial(v));
    let moment = cross(add(place, load.lever), load.force);
    let wrench = Wrench { force: to_orbit(load.force), moment: to_orbit(load.moment) };
    (wrench, [scale(-1.0, load.force), scale(-1.0, moment)])
}
