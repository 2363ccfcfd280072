//! Equations (1)–(14) in vector form: each contact gives one force and one moment, applied with
//! opposite sign to the two bodies it joins.

use super::Mechanism;
use super::jacobian::DISPLACEMENT;
use super::semi_implicit::SemiImplicit;
use super::step_loads::Seen;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Task, side_by_side};
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::numerics::ode::{Integrator, OdeSystem};
use crate::physics::ball::{BallAcceleration, BallMotion};
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::CageMotion;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, length, scale, subtract};
use crate::physics::pocket::{PocketLoad, PocketMotion, PocketSlopes};
use crate::physics::raceway::{ContactSlopes, RacewayContact, RacewayLoad, RelativeMotion};
use crate::physics::spindle::unbalance_force;
use crate::simulation::input::channel::BallContact;
use crate::simulation::model::state::{BallState, CageState, Layout, SpindleState};

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
}

/// The equations of motion with (`PLANAR = false`) or without motion along X.
#[derive(Debug, Clone)]
pub struct Dynamics<const PLANAR: bool> {
    mechanism: Mechanism,
    one: OneBall,
    /// The spindle's axis in the inertial frame; `None`: along X.
    tilted_axis: Option<Vector>,
    /// What the processor offers for balls side by side.
    instructions: InstructionSet,
    /// By which the Jacobian displaces the entries of a ball, of cage and spindle.
    displacements: Vec<f64>,
}

/// Force and moment on a ball, in its orbit frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wrench<T = f64> {
    pub force: Vector<T>,
    pub moment: Vector<T>,
}
side_by_side!(Wrench { force, moment });

impl Wrench {
    /// Both together.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { force: add(self.force, other.force), moment: add(self.moment, other.moment) }
    }

    /// The difference.
    #[inline(always)]
    pub fn less(self, other: &Self) -> Self {
        Self { force: subtract(self.force, other.force), moment: subtract(self.moment, other.moment) }
    }
}

/// Forces that balls exert, one or all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reaction<T = f64> {
    /// On the spindle, inertial frame.
    pub spindle: Vector<T>,
    /// On the cage, in its tilted frame.
    pub cage_force: Vector<T>,
    /// On the cage about its centre of mass, in its tilted frame.
    pub cage_moment: Vector<T>,
}
side_by_side!(Reaction { spindle, cage_force, cage_moment });

impl Reaction {
    /// The difference.
    #[inline(always)]
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

impl Reaction<Lanes> {
    /// Adds those of the first `balls` lanes to `sum`, one ball after the other.
    #[inline(always)]
    pub(super) fn sum_into(&self, sum: &mut Reaction, balls: usize) {
        for lane in 0..LANES.min(balls) {
            sum.add(&self.at(lane));
        }
    }
}

/// Angle [rad], speed [rad/s] and acceleration [rad/s²] of the shaft.
pub(super) type Shaft = (f64, f64, f64);

/// Cage and spindle at a time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    pub cage: CageState,
    pub pose: CagePose,
    pub spindle: SpindleState,
    pub shaft: Shaft,
    /// Of a start that settles [1/s]; else 0.
    pub damping: f64,
}

/// Balls side by side: how they move, how that changes, and what they pass on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Balls {
    pub motion: BallMotion<Lanes>,
    pub rates: BallState<Lanes>,
    pub reaction: Reaction<Lanes>,
}

/// How what acts on balls side by side answers to their own motion, in their orbit frames.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slopes<T = f64> {
    pub raceway: PerRaceway<ContactSlopes<T>>,
    pub pocket: PocketSlopes<T>,
    /// From the cage's centre of mass to the contact, inertial frame [m].
    pub arm: Vector<T>,
    /// Slip of the raceways over the ball, along the groove and across it [m/s].
    pub slip: PerRaceway<(T, T)>,
    /// What answers, but for the squares of the slip.
    pub seen: Seen<T>,
}

/// The cage in the form in which pockets need it.
#[derive(Debug, Clone, Copy)]
pub(super) struct CagePose {
    motion: CageMotion,
    /// Azimuth of the first pocket about the cage axis.
    azimuth: Azimuth,
}

/// Constants of one ball, and its formulas. Small: a copy of it stands before each loop over balls, so that the compiler sees
/// that nothing stored in the loop changes it.
#[derive(Debug, Clone, Copy)]
struct OneBall {
    pitch_radius: f64,
    orbit_ratio: f64,
    spin_ratio: f64,
    mass: f64,
    inertia: f64,
    weight: f64,
    /// Axial displacement at which the spindle is held [m].
    axial_offset: f64,
    /// Centre of the first pocket, in the orbit frame of the cage.
    pocket_centre: Vector,
}

impl OneBall {
    #[inline(always)]
    fn motion(&self, start: f64, state: &BallState, (angle, speed, _): Shaft) -> BallMotion {
        let per_radius = 1.0 / self.pitch_radius;
        let azimuth = start + self.orbit_ratio * angle + state.arc * per_radius;
        let radius = self.pitch_radius + state.radial;
        let orbit_speed = self.orbit_ratio * speed + state.arc_velocity * per_radius;
        BallMotion {
            azimuth_angle: azimuth,
            azimuth: Azimuth::new(azimuth),
            axial: state.axial,
            radius,
            orbit_speed,
            velocity: [state.axial_velocity, state.radial_velocity, radius * orbit_speed],
            spin: [state.spin[0] + self.spin_ratio * speed, state.spin[1], state.spin[2]],
        }
    }

    /// Relative to the outer raceway.
    #[inline(always)]
    fn over_outer(&self, motion: &BallMotion) -> RelativeMotion {
        RelativeMotion {
            axial: motion.axial,
            radius: motion.radius,
            velocity: motion.velocity,
            spin: motion.spin,
            raceway_speed: 0.0,
            orbit_speed: motion.orbit_speed,
            azimuth: motion.azimuth_angle,
        }
    }

    /// Relative to the inner raceway, with the frame that is in.
    #[inline(always)]
    fn over_inner<F: ContactFrame>(
        &self,
        motion: &BallMotion,
        spindle: &SpindleState,
        (angle, speed, _): Shaft,
        axis: &F::Axis,
    ) -> (RelativeMotion, F) {
        let [x, y, z] = spindle.position;
        let centre = motion.azimuth.to_orbit([x + self.axial_offset, y, z]);
        let velocity = motion.azimuth.to_orbit(spindle.velocity);
        let from_centre = [motion.axial - centre[0], motion.radius - centre[1], -centre[2]];
        let frame = F::new(axis, motion.azimuth, from_centre);
        let (axial, radius) = frame.place();
        let relative = RelativeMotion {
            axial,
            radius,
            velocity: frame.components(subtract(motion.velocity, velocity)),
            spin: frame.components(motion.spin),
            raceway_speed: speed,
            orbit_speed: motion.orbit_speed,
            azimuth: motion.azimuth_angle - angle,
        };
        (relative, frame)
    }

    /// Relative to its pocket, which starts at an azimuth, and the ball's place in the cage's tilted frame, from its centre
    /// of mass.
    #[inline(always)]
    fn in_pocket(&self, motion: &BallMotion, cage: &CagePose, start: Azimuth) -> (PocketMotion, Vector) {
        let CageMotion { centre, velocity, tilt, spin } = cage.motion;
        let azimuth = motion.azimuth;
        let place = tilt.to_tilted(subtract(azimuth.to_inertial([motion.axial, motion.radius, 0.0]), centre));
        let pocket = cage.azimuth.turned(start).to_inertial(self.pocket_centre);
        let relative = tilt.to_tilted(subtract(azimuth.to_inertial(motion.velocity), velocity));
        let motion = PocketMotion {
            displacement: subtract(place, pocket),
            velocity: subtract(relative, cross(spin, place)),
            spin: subtract(tilt.to_tilted(azimuth.to_inertial(motion.spin)), spin),
        };
        (motion, place)
    }

    /// Rates of its state under all that acts on it but its weight.
    #[inline(always)]
    fn rates(&self, state: &BallState, motion: &BallMotion, wrench: Wrench, (_, _, acceleration): Shaft) -> BallState {
        let Azimuth { cosine, sine } = motion.azimuth;
        let force = add(wrench.force, [0.0, self.weight * cosine, -self.weight * sine]);
        let BallAcceleration { axial, radial, azimuthal, spin } =
            motion.acceleration(force, wrench.moment, self.mass, self.inertia);
        BallState {
            axial: state.axial_velocity,
            radial: state.radial_velocity,
            arc: state.arc_velocity,
            axial_velocity: axial,
            radial_velocity: radial,
            arc_velocity: self.pitch_radius * (azimuthal - self.orbit_ratio * acceleration),
            spin: [spin[0] - self.spin_ratio * acceleration, spin[1], spin[2]],
        }
    }

    /// What force and moment add to them.
    #[inline(always)]
    fn response(&self, motion: &BallMotion, wrench: Wrench) -> BallState {
        let still = BallMotion { orbit_speed: 0.0, ..*motion };
        let BallAcceleration { axial, radial, azimuthal, spin } =
            still.acceleration(wrench.force, wrench.moment, self.mass, self.inertia);
        BallState {
            axial_velocity: axial,
            radial_velocity: radial,
            arc_velocity: self.pitch_radius * azimuthal,
            spin,
            ..BallState::default()
        }
    }
}

/// The inner raceway on a ball, in its orbit frame, and the ball on the spindle, in the inertial frame.
#[inline(always)]
fn on_inner(azimuth: Azimuth, frame: &impl ContactFrame, load: &RacewayLoad) -> (Wrench, Vector) {
    let force = frame.vector(load.force);
    (Wrench { force, moment: frame.vector(load.moment) }, scale(-1.0, azimuth.to_inertial(force)))
}

/// A pocket on its ball, in the ball's orbit frame, and the ball on the cage, in its tilted frame about its centre of mass.
#[inline(always)]
fn on_pocket(azimuth: Azimuth, tilt: &Tilt, place: Vector, load: &PocketLoad) -> (Wrench, [Vector; 2]) {
    let to_orbit = |v| azimuth.to_orbit(tilt.to_inertial(v));
    let moment = cross(add(place, load.lever), load.force);
    let wrench = Wrench { force: to_orbit(load.force), moment: to_orbit(load.moment) };
    (wrench, [scale(-1.0, load.force), scale(-1.0, moment)])
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    pub fn new(mechanism: Mechanism) -> Self {
        let [about_y, about_z] = mechanism.misalignment;
        let tilted_axis =
            (!PLANAR && mechanism.misalignment != [0.0; 2]).then(|| Tilt::new(about_y, about_z).columns[0]);
        let one_ball = Layout { balls: 1, ..mechanism.layout };
        let displacements = one_ball.sizes().iter().map(|size| DISPLACEMENT * size).collect();
        let one = OneBall {
            pitch_radius: mechanism.pitch_radius,
            orbit_ratio: mechanism.orbit_ratio,
            spin_ratio: mechanism.spin_ratio,
            mass: mechanism.ball_mass,
            inertia: mechanism.ball_inertia,
            weight: mechanism.ball_mass * mechanism.gravity,
            axial_offset: mechanism.axial_offset,
            pocket_centre: [mechanism.cage.offset, mechanism.pitch_radius, 0.0],
        };
        Self { mechanism, one, tilted_axis, instructions: InstructionSet::best(), displacements }
    }

    /// The same equations with other instructions of the same processor.
    pub(super) fn with_instructions(mut self, instructions: InstructionSet) -> Self {
        self.instructions = instructions;
        self
    }

    pub(super) fn displacements(&self) -> &[f64] {
        &self.displacements
    }

    pub(super) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Writes `dy/dt`, showing each load to `watch`.
    pub fn evaluate(&self, time: f64, y: &[f64], dy: &mut [f64], watch: Option<&mut (dyn Watch + '_)>) {
        self.instructions.run(Evaluation { dynamics: self, time, y, dy, watch });
    }

    /// `evaluate`, `LANES` balls side by side.
    #[inline(always)]
    fn evaluate_by(&self, time: f64, y: &[f64], dy: &mut [f64], mut watch: Option<&mut (dyn Watch + '_)>) {
        let layout = self.mechanism.layout;
        // Before the border: what is written one by one has reached the cache when it is read side by side.
        let mut state = layout.side_by_side::<PLANAR>(y, 0);
        let border = self.border(layout.cage(y), layout.spindle(y), time);
        let mut sum = Reaction::default();
        let mut balls = Balls::default();
        for first in (0..layout.balls).step_by(LANES) {
            if first > 0 {
                state = layout.side_by_side::<PLANAR>(y, first);
            }
            self.balls(first, &state, &border, &mut balls, watch.as_deref_mut(), None);
            balls.reaction.sum_into(&mut sum, layout.balls - first);
            layout.set_side_by_side::<PLANAR>(dy, first, &balls.rates);
        }
        layout.set_cage(dy, &self.cage_rates(&border, &sum));
        layout.set_spindle(dy, &self.spindle_rates(&border, sum.spindle));
    }

    /// What the balls from `first` on do in a state.
    #[inline(always)]
    pub(super) fn balls(
        &self,
        first: usize,
        state: &BallState<Lanes>,
        border: &Border,
        balls: &mut Balls,
        watch: Option<&mut (dyn Watch + '_)>,
        slopes: Option<&mut Slopes<Lanes>>,
    ) {
        let asked = (watch, slopes);
        match self.tilted_axis {
            Some(axis) if !PLANAR => self.balls_in::<TiltedFrame>(first, state, border, &axis, balls, asked),
            _ => self.balls_in::<StraightFrame>(first, state, border, &(), balls, asked),
        }
    }

    #[inline(always)]
    fn balls_in<F: ContactFrame>(
        &self,
        first: usize,
        state: &BallState<Lanes>,
        border: &Border,
        axis: &F::Axis,
        balls: &mut Balls,
        (watch, mut slopes): (Option<&mut (dyn Watch + '_)>, Option<&mut Slopes<Lanes>>),
    ) {
        let m = &self.mechanism;
        let (one, axis, Border { pose, spindle, shaft, .. }) = (self.one, *axis, *border);
        let start: Lanes = Lanes::of(&m.start.angle, first);
        let mut relative: PerRaceway<RelativeMotion<Lanes>> = PerRaceway::default();
        let mut frames = F::Several::default();
        for lane in 0..LANES {
            let motion = one.motion(start[lane], &state.at(lane), shaft);
            let (inner, frame) = one.over_inner::<F>(&motion, &spindle, shaft, &axis);
            relative.outer.put(lane, one.over_outer(&motion));
            relative.inner.put(lane, inner);
            frames.put(lane, frame);
            balls.motion.put(lane, motion);
        }
        // Before the raceways: what waits for itself has something else beside it.
        let (mut drag_force, mut churning_factor) = (<Lanes>::default(), <Lanes>::default());
        if let Some(drag) = m.drag {
            for lane in 0..LANES {
                drag_force[lane] = drag.force(one.pitch_radius * balls.motion.orbit_speed[lane]);
            }
        }
        if let Some(churning) = m.churning {
            for lane in 0..LANES {
                churning_factor[lane] = churning.churning_factor(length(balls.motion.spin.at(lane)));
            }
        }
        let (mut in_pocket, mut places) = (PocketLoad::<Lanes>::default(), <Vector<Lanes>>::default());
        let of_pocket = slopes.as_deref_mut().map(|slopes| &mut slopes.pocket);
        self.pockets(first, &balls.motion, &pose, &mut in_pocket, &mut places, of_pocket);
        let mut load: PerRaceway<RacewayLoad<Lanes>> = PerRaceway::default();
        RacewayContact::pair_of_loads::<PLANAR>(&m.raceway, &relative, &mut load, self.instructions);
        if let Some(slopes) = slopes {
            m.raceway.outer.slopes::<PLANAR>(&relative.outer, &load.outer, &mut slopes.raceway.outer);
            m.raceway.inner.slopes::<PLANAR>(&relative.inner, &load.inner, &mut slopes.raceway.inner);
            m.raceway.outer.rolling_speeds(
                &relative.outer,
                &slopes.raceway.outer,
                &mut slopes.seen.rolling_speed.outer,
            );
            m.raceway.inner.rolling_speeds(
                &relative.inner,
                &slopes.raceway.inner,
                &mut slopes.seen.rolling_speed.inner,
            );
            slopes.seen.load = PerRaceway { inner: load.inner.normal, outer: load.outer.normal };
            slopes.seen.angle = PerRaceway { inner: load.inner.angle, outer: load.outer.angle };
            slopes.slip = PerRaceway { inner: load.inner.slip, outer: load.outer.slip };
            slopes.seen.pocket = in_pocket.normal;
            let tilt = pose.motion.tilt;
            for lane in 0..LANES {
                let (azimuth, pocket) = (balls.motion.azimuth.at(lane), slopes.pocket.at(lane));
                let normal = azimuth.to_orbit(tilt.to_inertial(pocket.normal));
                slopes.pocket.put(lane, PocketSlopes { normal, ..pocket });
                slopes.arm.put(lane, tilt.to_inertial(add(places.at(lane), in_pocket.lever.at(lane))));
            }
        }
        for lane in 0..LANES {
            let motion = balls.motion.at(lane);
            let (force, moment) = (load.outer.force.at(lane), load.outer.moment.at(lane));
            let (inner, spindle) = on_inner(motion.azimuth, &frames.at(lane), &load.inner.at(lane));
            let (pocket, [cage_force, cage_moment]) =
                on_pocket(motion.azimuth, &pose.motion.tilt, places.at(lane), &in_pocket.at(lane));
            let surroundings =
                Wrench { force: [0.0, 0.0, drag_force[lane]], moment: scale(-churning_factor[lane], motion.spin) };
            let wrench = inner.and(Wrench { force, moment }).and(pocket).and(surroundings);
            balls.reaction.put(lane, Reaction { spindle, cage_force, cage_moment });
            balls.rates.put(lane, one.rates(&state.at(lane), &motion, wrench, shaft));
        }
        if let Some(watch) = watch {
            for lane in 0..LANES.min(m.layout.balls - first) {
                let (ball, outer, inner) = (first + lane, load.outer.at(lane), load.inner.at(lane));
                watch.raceway(ball, BallContact::Outer, &relative.outer.at(lane), &outer);
                let (Wrench { force, moment }, _) = on_inner(balls.motion.azimuth.at(lane), &frames.at(lane), &inner);
                watch.raceway(
                    ball,
                    BallContact::Inner,
                    &relative.inner.at(lane),
                    &RacewayLoad { force, moment, ..inner },
                );
                if m.layout.cage {
                    watch.pocket(ball, &in_pocket.at(lane));
                }
            }
        }
    }

    /// Writes loads in the pockets of the balls from `first` on, the balls' places in the cage, and how the loads answer to
    /// the balls' own motion where that is asked for, in the cage's tilted frame; nothing without a cage.
    #[inline(always)]
    fn pockets(
        &self,
        first: usize,
        motion: &BallMotion<Lanes>,
        pose: &CagePose,
        load: &mut PocketLoad<Lanes>,
        places: &mut Vector<Lanes>,
        slopes: Option<&mut PocketSlopes<Lanes>>,
    ) {
        let m = &self.mechanism;
        if !m.layout.cage {
            return;
        }
        let (one, pose) = (self.one, *pose);
        let start: Azimuth<Lanes> =
            Azimuth { cosine: Lanes::of(&m.start.cosine, first), sine: Lanes::of(&m.start.sine, first) };
        let mut relative = PocketMotion::<Lanes>::default();
        for lane in 0..LANES {
            let (motion, place) = one.in_pocket(&motion.at(lane), &pose, start.at(lane));
            relative.put(lane, motion);
            places.put(lane, place);
        }
        match slopes {
            None => m.pocket.loads(&relative, load),
            Some(slopes) => m.pocket.loads_and_slopes(&relative, load, slopes),
        }
    }

    /// The inner raceway alone on the balls, and the balls on the spindle.
    #[inline(always)]
    pub(super) fn inner_part(&self, motion: &BallMotion<Lanes>, border: &Border) -> (Wrench<Lanes>, Vector<Lanes>) {
        match self.tilted_axis {
            Some(axis) if !PLANAR => self.inner_part_in::<TiltedFrame>(motion, border, &axis),
            _ => self.inner_part_in::<StraightFrame>(motion, border, &()),
        }
    }

    #[inline(always)]
    fn inner_part_in<F: ContactFrame>(
        &self,
        motion: &BallMotion<Lanes>,
        border: &Border,
        axis: &F::Axis,
    ) -> (Wrench<Lanes>, Vector<Lanes>) {
        let (one, axis, Border { spindle, shaft, .. }) = (self.one, *axis, *border);
        let mut relative = RelativeMotion::<Lanes>::default();
        let mut frames = F::Several::default();
        for lane in 0..LANES {
            let (inner, frame) = one.over_inner::<F>(&motion.at(lane), &spindle, shaft, &axis);
            relative.put(lane, inner);
            frames.put(lane, frame);
        }
        let mut load = RacewayLoad::<Lanes>::default();
        self.mechanism.raceway.inner.loads::<PLANAR>(&relative, &mut load, self.instructions);
        let mut parts = <(Wrench<Lanes>, Vector<Lanes>)>::default();
        for lane in 0..LANES {
            let (wrench, reaction) = on_inner(motion.azimuth.at(lane), &frames.at(lane), &load.at(lane));
            parts.0.put(lane, wrench);
            parts.1.put(lane, reaction);
        }
        parts
    }

    /// The pockets alone on their balls, and the balls on the cage: force and moment.
    #[inline(always)]
    pub(super) fn pocket_part(
        &self,
        first: usize,
        motion: &BallMotion<Lanes>,
        pose: &CagePose,
    ) -> (Wrench<Lanes>, Vector<Lanes>, Vector<Lanes>) {
        let tilt = pose.motion.tilt;
        let (mut load, mut places) = (PocketLoad::<Lanes>::default(), <Vector<Lanes>>::default());
        self.pockets(first, motion, pose, &mut load, &mut places, None);
        let mut parts = <(Wrench<Lanes>, Vector<Lanes>, Vector<Lanes>)>::default();
        for lane in 0..LANES {
            let azimuth = motion.azimuth.at(lane);
            let (wrench, [force, moment]) = on_pocket(azimuth, &tilt, places.at(lane), &load.at(lane));
            parts.0.put(lane, wrench);
            parts.1.put(lane, force);
            parts.2.put(lane, moment);
        }
        parts
    }

    /// What a further wrench adds to the rates of the balls.
    #[inline(always)]
    pub(super) fn ball_response(&self, motion: &BallMotion<Lanes>, wrench: &Wrench<Lanes>) -> BallState<Lanes> {
        let one = self.one;
        let mut response = BallState::<Lanes>::default();
        for lane in 0..LANES {
            response.put(lane, one.response(&motion.at(lane), wrench.at(lane)));
        }
        response
    }

    #[inline(always)]
    pub(super) fn border(&self, cage: CageState, spindle: SpindleState, time: f64) -> Border {
        let shaft = self.mechanism.speed.at(time);
        let damping = self.mechanism.damping.map_or(0.0, |damping| damping.at(time));
        Border { pose: self.cage_pose(&cage, shaft), cage, spindle, shaft, damping }
    }

    #[inline(always)]
    pub(super) fn cage_pose(&self, state: &CageState, (angle, speed, _): Shaft) -> CagePose {
        let m = &self.mechanism;
        let [x, y, z] = state.centre;
        let [about_y, about_z] = state.tilt_rate;
        CagePose {
            motion: CageMotion {
                // The pocket plane lies in the plane of the balls when the cage is in its place.
                centre: [x - m.cage.offset, y, z],
                velocity: state.velocity,
                tilt: if PLANAR { Tilt::NONE } else { Tilt::new(state.tilt[0], state.tilt[1]) },
                spin: [m.orbit_ratio * speed + state.arc_velocity / m.pitch_radius, about_y, about_z],
            },
            azimuth: Azimuth::new(m.orbit_ratio * angle + state.arc / m.pitch_radius),
        }
    }

    #[inline(always)]
    pub(super) fn cage_rates(&self, border: &Border, reaction: &Reaction) -> CageState {
        let Border { cage: state, pose, shaft: (_, _, acceleration), damping, .. } = border;
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
        let mut rates = m.cage.acceleration(&pose.motion, force, moment, m.gravity);
        // Along the axis and in tilt: in the plane, films in the pockets damp it, and it has to come to its orbit.
        rates.linear[0] -= damping * state.velocity[0];
        for (rate, turning) in rates.angular[1..].iter_mut().zip(state.tilt_rate) {
            *rate -= damping * turning;
        }
        let [about_y, about_z] = state.tilt_rate;
        let tilt = &pose.motion.tilt;
        CageState {
            centre: state.velocity,
            arc: state.arc_velocity - m.pitch_radius * about_y * tilt.tangent_about_z(),
            tilt: [about_y / tilt.cosine_about_z(), about_z],
            velocity: rates.linear,
            arc_velocity: m.pitch_radius * (rates.angular[0] - m.orbit_ratio * acceleration),
            tilt_rate: [rates.angular[1], rates.angular[2]],
        }
    }

    /// What a reaction adds to the rates of the cage.
    #[inline(always)]
    pub(super) fn cage_response(&self, pose: &CagePose, reaction: &Reaction) -> CageState {
        let m = &self.mechanism;
        let force = pose.motion.tilt.to_inertial(reaction.cage_force);
        let rates = m.cage.response(force, reaction.cage_moment);
        CageState {
            velocity: rates.linear,
            arc_velocity: m.pitch_radius * rates.angular[0],
            tilt_rate: [rates.angular[1], rates.angular[2]],
            ..CageState::default()
        }
    }

    /// What a reaction adds to the rates of the spindle.
    #[inline(always)]
    pub(super) fn spindle_response(&self, reaction: Vector) -> SpindleState {
        SpindleState { velocity: scale(1.0 / self.mechanism.spindle_mass, reaction), ..SpindleState::default() }
    }

    /// Equations (13), (14), and X where the spindle is free.
    #[inline(always)]
    pub(super) fn spindle_rates(&self, border: &Border, reaction: Vector) -> SpindleState {
        let &Border { spindle: state, shaft: (angle, speed, acceleration), damping, .. } = border;
        let m = &self.mechanism;
        let mut force = add(m.load, reaction);
        force[1] += m.spindle_mass * m.gravity;
        if m.unbalance != 0.0 {
            force = add(force, unbalance_force(m.unbalance, angle, speed, acceleration));
        }
        force = add(force, scale(-damping * m.spindle_mass, state.velocity));
        SpindleState { position: state.velocity, ..self.spindle_response(force) }
    }
}

/// Where a ball sits on the inner raceway: place and axes of the contact's frame, in the orbit frame.
trait ContactFrame: Copy {
    type Several: SideBySide<One = Self> + Default;
    /// What it needs to know of the raceway's axis.
    type Axis: Copy;
    /// Of a ball at an azimuth, `from_centre` of the raceway in its orbit frame.
    fn new(axis: &Self::Axis, azimuth: Azimuth, from_centre: Vector) -> Self;
    /// Along the raceway's axis and from it.
    fn place(&self) -> (f64, f64);
    /// A vector of the orbit frame, in the contact's.
    fn components(&self, v: Vector) -> Vector;
    /// A vector of the contact's frame, in the orbit frame.
    fn vector(&self, c: Vector) -> Vector;
}

/// On a raceway whose axis is parallel to X: the contact's frame is the orbit frame turned about X.
#[derive(Debug, Clone, Copy, Default)]
struct StraightFrame<T = f64> {
    axial: T,
    radius: T,
    turn: Azimuth<T>,
}
side_by_side!(StraightFrame { axial, radius, turn });

impl ContactFrame for StraightFrame {
    type Several = StraightFrame<Lanes>;
    type Axis = ();

    #[inline(always)]
    fn new(_: &(), _: Azimuth, [axial, r, t]: Vector) -> Self {
        let radius = (r * r + t * t).sqrt();
        let per_radius = 1.0 / radius;
        Self { axial, radius, turn: Azimuth { cosine: per_radius * r, sine: per_radius * t } }
    }

    #[inline(always)]
    fn place(&self) -> (f64, f64) {
        (self.axial, self.radius)
    }

    #[inline(always)]
    fn components(&self, v: Vector) -> Vector {
        self.turn.to_orbit(v)
    }

    #[inline(always)]
    fn vector(&self, c: Vector) -> Vector {
        self.turn.to_inertial(c)
    }
}

/// On a raceway whose axis is tilted.
#[derive(Debug, Clone, Copy, Default)]
struct TiltedFrame<T = f64> {
    axial: T,
    radius: T,
    axis: Vector<T>,
    radial: Vector<T>,
    tangential: Vector<T>,
}
side_by_side!(TiltedFrame { axial, radius, axis, radial, tangential });

impl ContactFrame for TiltedFrame {
    type Several = TiltedFrame<Lanes>;
    type Axis = Vector;

    #[inline(always)]
    fn new(axis: &Vector, azimuth: Azimuth, from_centre: Vector) -> Self {
        let axis = azimuth.to_orbit(*axis);
        let axial = dot(from_centre, axis);
        let across = subtract(from_centre, scale(axial, axis));
        let radius = dot(across, across).sqrt();
        let radial = scale(1.0 / radius, across);
        Self { axial, radius, axis, radial, tangential: cross(axis, radial) }
    }

    #[inline(always)]
    fn place(&self) -> (f64, f64) {
        (self.axial, self.radius)
    }

    #[inline(always)]
    fn components(&self, v: Vector) -> Vector {
        [dot(self.axis, v), dot(self.radial, v), dot(self.tangential, v)]
    }

    #[inline(always)]
    fn vector(&self, c: Vector) -> Vector {
        add(scale(c[0], self.axis), add(scale(c[1], self.radial), scale(c[2], self.tangential)))
    }
}

/// One evaluation, to be compiled for each instruction set.
struct Evaluation<'a, 'w, const PLANAR: bool> {
    dynamics: &'a Dynamics<PLANAR>,
    time: f64,
    y: &'a [f64],
    dy: &'a mut [f64],
    watch: Option<&'a mut (dyn Watch + 'w)>,
}

impl<const PLANAR: bool> Task for Evaluation<'_, '_, PLANAR> {
    type Answer = ();

    #[inline(always)]
    fn run(self) {
        self.dynamics.evaluate_by(self.time, self.y, self.dy, self.watch);
    }
}

impl<const PLANAR: bool> OdeSystem for Dynamics<PLANAR> {
    fn dimension(&self) -> usize {
        self.mechanism.layout.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        self.evaluate(time, state, derivative, None);
    }

    fn structure(&self) -> Structure {
        self.mechanism.layout.structure()
    }

    fn own_method<'a>(&'a self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 'a>> {
        Some(Box::new(SemiImplicit::new(self, time, state, step)))
    }

    fn jacobian(&self, time: f64, state: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        self.differences(time, state, jacobian)
    }
}
