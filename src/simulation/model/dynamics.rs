//! Equations (1)–(14) in vector form: each contact gives one force and one moment, applied with
//! opposite sign to the two bodies it joins.

use super::Mechanism;
use crate::numerics::ode::OdeSystem;
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::physics::ball::{BallAcceleration, BallMotion};
use crate::physics::cage::CageMotion;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, scale, subtract};
use crate::physics::pocket::{PocketLoad, PocketMotion};
use crate::physics::raceway::{RacewayLoad, RelativeMotion};
use crate::physics::spindle::unbalance_force;
use crate::simulation::channel::BallContact;
use crate::simulation::state::{BallState, CageState, SpindleState};

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
    /// All that acts on a ball, and what it passes on to spindle and cage.
    fn ball(&mut self, ball: usize, wrench: &Wrench, reaction: &Reaction) {
        let _ = (ball, wrench, reaction);
    }
}

/// Nobody watches: costs nothing.
impl Watch for () {}

/// The equations of motion with (`PLANAR = false`) or without motion along X.
#[derive(Debug, Clone)]
pub struct Dynamics<const PLANAR: bool> {
    mechanism: Mechanism,
    /// The spindle's axis in the inertial frame; `None`: along X.
    tilted_axis: Option<Vector>,
}

/// Force and moment on a ball, in its orbit frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wrench {
    pub force: Vector,
    pub moment: Vector,
}

impl Wrench {
    /// Both together.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { force: add(self.force, other.force), moment: add(self.moment, other.moment) }
    }

    /// The difference.
    pub fn less(self, other: &Self) -> Self {
        Self { force: subtract(self.force, other.force), moment: subtract(self.moment, other.moment) }
    }
}

/// Forces that balls exert, one or all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reaction {
    /// On the spindle, inertial frame.
    pub spindle: Vector,
    /// On the cage, in its tilted frame.
    pub cage_force: Vector,
    /// On the cage about its centre of mass, in its tilted frame.
    pub cage_moment: Vector,
}

impl Reaction {
    /// The difference.
    pub fn less(&self, other: &Self) -> Self {
        Self {
            spindle: subtract(self.spindle, other.spindle),
            cage_force: subtract(self.cage_force, other.cage_force),
            cage_moment: subtract(self.cage_moment, other.cage_moment),
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.spindle = add(self.spindle, other.spindle);
        self.cage_force = add(self.cage_force, other.cage_force);
        self.cage_moment = add(self.cage_moment, other.cage_moment);
    }
}

/// The cage in the form in which pockets need it.
pub(super) struct CagePose {
    motion: CageMotion,
    /// Azimuth of the first pocket about the cage axis.
    azimuth: Azimuth,
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    pub fn new(mechanism: Mechanism) -> Self {
        let [about_y, about_z] = mechanism.misalignment;
        let tilted_axis =
            (!PLANAR && mechanism.misalignment != [0.0; 2]).then(|| Tilt::new(about_y, about_z).columns[0]);
        Self { mechanism, tilted_axis }
    }

    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Writes `dy/dt`, showing each load to `watch`.
    pub fn evaluate(&self, time: f64, y: &[f64], dy: &mut [f64], watch: &mut impl Watch) {
        let m = &self.mechanism;
        let motion = m.speed.at(time);
        let (angle, speed, acceleration) = motion;
        let spindle = m.layout.spindle(y);
        let cage_state = m.layout.cage(y);
        let cage = self.cage_pose(&cage_state, angle, speed);
        let mut sum = Reaction::default();
        for ball in 0..m.layout.balls {
            let state = m.layout.ball(y, ball);
            let motion = self.ball_motion(ball, &state, angle, speed);
            let mut reaction = Reaction::default();
            let outer = self.outer(ball, &motion, watch);
            let mut wrench = self.inner(ball, &motion, &spindle, (angle, speed), &mut reaction, watch).and(outer);
            if m.layout.cage {
                wrench = wrench.and(self.pocket(ball, &motion, &cage, &mut reaction, watch));
            }
            watch.ball(ball, &wrench, &reaction);
            sum.add(&reaction);
            let rates = self.ball_rates(&state, &motion, wrench, acceleration);
            m.layout.set_ball(dy, ball, &rates);
        }
        m.layout.set_cage(dy, &self.cage_rates(&cage_state, &cage, &sum, acceleration));
        m.layout.set_spindle(dy, &self.spindle_rates(&spindle, sum.spindle, motion));
    }

    #[inline(always)]
    pub(super) fn ball_motion(&self, ball: usize, state: &BallState, angle: f64, speed: f64) -> BallMotion {
        let m = &self.mechanism;
        let azimuth = m.start_azimuth(ball) + m.orbit_ratio * angle + state.arc / m.pitch_radius;
        let radius = m.pitch_radius + state.radial;
        let orbit_speed = m.orbit_ratio * speed + state.arc_velocity / m.pitch_radius;
        BallMotion {
            azimuth_angle: azimuth,
            azimuth: Azimuth::new(azimuth),
            axial: state.axial,
            radius,
            orbit_speed,
            velocity: [state.axial_velocity, state.radial_velocity, radius * orbit_speed],
            spin: [state.spin[0] + m.spin_ratio * speed, state.spin[1], state.spin[2]],
        }
    }

    /// Force and moment of the outer raceway on a ball, in its orbit frame.
    #[inline(always)]
    fn outer(&self, ball: usize, motion: &BallMotion, watch: &mut impl Watch) -> Wrench {
        let relative = RelativeMotion {
            axial: motion.axial,
            radius: motion.radius,
            velocity: motion.velocity,
            spin: motion.spin,
            raceway_speed: 0.0,
            orbit_speed: motion.orbit_speed,
            azimuth: motion.azimuth_angle,
        };
        let load = self.mechanism.raceway.outer.load::<PLANAR>(&relative);
        watch.raceway(ball, BallContact::Outer, &relative, &load);
        Wrench { force: load.force, moment: load.moment }
    }

    /// Force and moment of the inner raceway on a ball, in its orbit frame; the spindle's share goes into `reaction`.
    #[inline(always)]
    pub(super) fn inner(
        &self,
        ball: usize,
        motion: &BallMotion,
        spindle: &SpindleState,
        (angle, speed): (f64, f64),
        reaction: &mut Reaction,
        watch: &mut impl Watch,
    ) -> Wrench {
        let m = &self.mechanism;
        let position = [spindle.position[0] + m.axial_offset, spindle.position[1], spindle.position[2]];
        let centre = motion.azimuth.to_orbit(position);
        let velocity = motion.azimuth.to_orbit(spindle.velocity);
        let frame = self.inner_frame(motion, centre);
        let relative = RelativeMotion {
            axial: frame.axial,
            radius: frame.radius,
            velocity: frame.components(subtract(motion.velocity, velocity)),
            spin: frame.components(motion.spin),
            raceway_speed: speed,
            orbit_speed: motion.orbit_speed,
            azimuth: motion.azimuth_angle - angle,
        };
        let local = m.raceway.inner.load::<PLANAR>(&relative);
        let load = RacewayLoad { force: frame.vector(local.force), moment: frame.vector(local.moment), ..local };
        watch.raceway(ball, BallContact::Inner, &relative, &load);
        if load.penetration > 0.0 {
            reaction.spindle = subtract(reaction.spindle, motion.azimuth.to_inertial(load.force));
        }
        Wrench { force: load.force, moment: load.moment }
    }

    /// The contact frame of the inner raceway, whose axis may be displaced and tilted.
    #[inline(always)]
    fn inner_frame(&self, motion: &BallMotion, centre: Vector) -> ContactFrame {
        let from_centre = [motion.axial - centre[0], motion.radius - centre[1], -centre[2]];
        let axis = match self.tilted_axis {
            None => [1.0, 0.0, 0.0],
            Some(axis) => motion.azimuth.to_orbit(axis),
        };
        let axial = dot(from_centre, axis);
        let across = subtract(from_centre, scale(axial, axis));
        let radius = dot(across, across).sqrt();
        let radial = scale(1.0 / radius, across);
        ContactFrame { axial, radius, axis, radial, tangential: cross(axis, radial) }
    }

    pub(super) fn cage_pose(&self, state: &CageState, angle: f64, speed: f64) -> CagePose {
        let m = &self.mechanism;
        let [x, y, z] = state.centre;
        let [about_y, about_z] = state.tilt_rate;
        CagePose {
            motion: CageMotion {
                // The pocket plane lies in the plane of the balls when the cage is in its place.
                centre: [x - m.cage.offset, y, z],
                velocity: state.velocity,
                tilt: if PLANAR { Tilt::NONE } else { Tilt::new(state.tilt[0], state.tilt[1]) },
                tilt_about_z: state.tilt[1],
                spin: [m.orbit_ratio * speed + state.arc_velocity / m.pitch_radius, about_y, about_z],
            },
            azimuth: Azimuth::new(m.orbit_ratio * angle + state.arc / m.pitch_radius),
        }
    }

    /// Force and moment of its pocket on a ball, in the ball's orbit frame; the cage's share goes into `reaction`.
    #[inline(always)]
    pub(super) fn pocket(
        &self,
        ball: usize,
        motion: &BallMotion,
        cage: &CagePose,
        reaction: &mut Reaction,
        watch: &mut impl Watch,
    ) -> Wrench {
        let m = &self.mechanism;
        let tilt = &cage.motion.tilt;
        let azimuth = motion.azimuth;
        // All in the cage's tilted frame, from its centre of mass.
        let place = azimuth.to_inertial([motion.axial, motion.radius, 0.0]);
        let ball_place = tilt.to_tilted(subtract(place, cage.motion.centre));
        let pocket_azimuth = cage.azimuth.turned(m.start[ball]);
        let pocket_place = pocket_azimuth.to_inertial([m.cage.offset, m.pitch_radius, 0.0]);
        let velocity = tilt.to_tilted(subtract(azimuth.to_inertial(motion.velocity), cage.motion.velocity));
        let relative = PocketMotion {
            displacement: subtract(ball_place, pocket_place),
            velocity: subtract(velocity, cross(cage.motion.spin, ball_place)),
            spin: subtract(tilt.to_tilted(azimuth.to_inertial(motion.spin)), cage.motion.spin),
        };
        let load = m.pocket.load(&relative);
        watch.pocket(ball, &load);
        reaction.cage_force = subtract(reaction.cage_force, load.force);
        reaction.cage_moment = subtract(reaction.cage_moment, cross(add(ball_place, load.lever), load.force));
        let to_orbit = |v| azimuth.to_orbit(tilt.to_inertial(v));
        Wrench { force: to_orbit(load.force), moment: to_orbit(load.moment) }
    }

    /// Rates of a ball's state under the force and moment of its contacts, with drag and gravity added.
    #[inline(always)]
    pub(super) fn ball_rates(
        &self,
        state: &BallState,
        motion: &BallMotion,
        Wrench { mut force, mut moment }: Wrench,
        acceleration: f64,
    ) -> BallState {
        let m = &self.mechanism;
        if let Some(drag) = &m.drag {
            force[2] += drag.force(m.pitch_radius * motion.orbit_speed);
        }
        if let Some(churning) = &m.churning {
            moment = add(moment, churning.churning_moment(motion.spin));
        }
        let weight = m.ball_mass * m.gravity;
        force[1] += weight * motion.azimuth.cosine;
        force[2] -= weight * motion.azimuth.sine;
        let BallAcceleration { axial, radial, azimuthal, spin } =
            motion.acceleration(force, moment, m.ball_mass, m.ball_inertia);
        BallState {
            axial: state.axial_velocity,
            radial: state.radial_velocity,
            arc: state.arc_velocity,
            axial_velocity: axial,
            radial_velocity: radial,
            arc_velocity: m.pitch_radius * (azimuthal - m.orbit_ratio * acceleration),
            spin: [spin[0] - m.spin_ratio * acceleration, spin[1], spin[2]],
        }
    }

    pub(super) fn cage_rates(
        &self,
        state: &CageState,
        pose: &CagePose,
        reaction: &Reaction,
        acceleration: f64,
    ) -> CageState {
        let m = &self.mechanism;
        if !m.layout.cage {
            return CageState::default();
        }
        let mut force = pose.motion.tilt.to_inertial(reaction.cage_force);
        let mut moment = reaction.cage_moment;
        if let Some(land) = &m.land {
            let (land_force, braking) = land.load(pose.motion.centre, pose.motion.spin[0]);
            force = add(force, land_force);
            moment[0] += braking;
        }
        let rates = m.cage.acceleration(&pose.motion, force, moment, m.gravity);
        let [about_y, about_z] = state.tilt_rate;
        let [_, tilt_z] = state.tilt;
        CageState {
            centre: state.velocity,
            arc: state.arc_velocity - m.pitch_radius * about_y * tilt_z.tan(),
            tilt: [about_y / tilt_z.cos(), about_z],
            velocity: rates.linear,
            arc_velocity: m.pitch_radius * (rates.angular[0] - m.orbit_ratio * acceleration),
            tilt_rate: [rates.angular[1], rates.angular[2]],
        }
    }

    /// Equations (13), (14), and X where the spindle is free.
    pub(super) fn spindle_rates(
        &self,
        state: &SpindleState,
        reaction: Vector,
        (angle, speed, acceleration): (f64, f64, f64),
    ) -> SpindleState {
        let m = &self.mechanism;
        let mut force = add(m.load, reaction);
        force[1] += m.spindle_mass * m.gravity;
        if m.unbalance != 0.0 {
            force = add(force, unbalance_force(m.unbalance, angle, speed, acceleration));
        }
        SpindleState { position: state.velocity, velocity: scale(1.0 / m.spindle_mass, force) }
    }
}

/// Where a ball sits on a raceway: place and axes of the contact's frame, in the orbit frame.
struct ContactFrame {
    axial: f64,
    radius: f64,
    axis: Vector,
    radial: Vector,
    tangential: Vector,
}

impl ContactFrame {
    #[inline(always)]
    fn components(&self, v: Vector) -> Vector {
        [dot(self.axis, v), dot(self.radial, v), dot(self.tangential, v)]
    }

    #[inline(always)]
    fn vector(&self, c: Vector) -> Vector {
        add(scale(c[0], self.axis), add(scale(c[1], self.radial), scale(c[2], self.tangential)))
    }
}

impl<const PLANAR: bool> OdeSystem for Dynamics<PLANAR> {
    fn dimension(&self) -> usize {
        self.mechanism.layout.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.evaluate(time, state, derivative, &mut ());
    }

    fn structure(&self) -> Structure {
        self.mechanism.layout.structure()
    }

    fn jacobian(&self, time: f64, state: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        self.differences(time, state, jacobian)
    }
}
