//! Equations (1)–(14) in vector form: each contact gives one force and one moment, applied with
//! opposite sign to the two bodies it joins.

use super::Mechanism;
use super::jacobian::DISPLACEMENT;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Task, side_by_side};
use crate::numerics::ode::OdeSystem;
use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::physics::ball::{BallAcceleration, BallMotion};
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::CageMotion;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, scale, subtract};
use crate::physics::pocket::{PocketLoad, PocketMotion};
use crate::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use crate::physics::spindle::unbalance_force;
use crate::simulation::channel::BallContact;
use crate::simulation::state::{BallState, CageState, Layout, SpindleState};

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

/// Both raceways and their balls.
struct OnRaceways<T> {
    relative: PerRaceway<RelativeMotion<T>>,
    /// In the contacts' frames.
    load: PerRaceway<RacewayLoad<T>>,
    outer: Wrench<T>,
    inner: Wrench<T>,
    /// On the spindle, inertial frame.
    reaction: Vector<T>,
}

/// The cage and its balls.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OnCage<T> {
    load: PocketLoad<T>,
    pub wrench: Wrench<T>,
    /// On the cage, in its tilted frame, about its centre of mass.
    pub reaction_force: Vector<T>,
    pub reaction_moment: Vector<T>,
}

/// What acts on balls, and what they pass on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Contacts<T> {
    pub inner: Wrench<T>,
    pub pocket: Wrench<T>,
    /// These, the outer raceway and the surroundings.
    pub wrench: Wrench<T>,
    pub reaction: Reaction<T>,
}

/// The cage in the form in which pockets need it.
#[derive(Debug, Clone, Copy)]
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
        let one_ball = Layout { balls: 1, ..mechanism.layout };
        let displacements = one_ball.sizes().iter().map(|size| DISPLACEMENT * size).collect();
        Self { mechanism, tilted_axis, instructions: InstructionSet::best(), displacements }
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
        let m = &self.mechanism;
        let shaft = m.speed.at(time);
        let (spindle, cage) = (m.layout.spindle(y), m.layout.cage(y));
        let pose = self.cage_pose(&cage, shaft);
        let mut sum = Reaction::default();
        for first in (0..m.layout.balls).step_by(LANES) {
            let state = m.layout.side_by_side::<PLANAR, LANES>(y, first);
            let motion = self.ball_motions(first, &state, shaft);
            let contacts = self.contacts(first, &motion, &spindle, &pose, shaft, watch.as_deref_mut());
            contacts.reaction.sum_into(&mut sum, m.layout.balls - first);
            let rates = self.ball_rates(&state, &motion, &contacts.wrench, shaft);
            m.layout.set_side_by_side::<PLANAR, LANES>(dy, first, &rates);
        }
        m.layout.set_cage(dy, &self.cage_rates(&cage, &pose, &sum, shaft));
        m.layout.set_spindle(dy, &self.spindle_rates(&spindle, sum.spindle, shaft));
    }

    /// All that acts on the balls from `first` on.
    #[inline(always)]
    pub(super) fn contacts(
        &self,
        first: usize,
        motion: &BallMotion<Lanes>,
        spindle: &SpindleState,
        pose: &CagePose,
        shaft: Shaft,
        mut watch: Option<&mut (dyn Watch + '_)>,
    ) -> Contacts<Lanes> {
        let layout = &self.mechanism.layout;
        let watched = LANES.min(layout.balls - first);
        // In this order, so that what waits for itself has something else beside it.
        let mut all = Contacts { wrench: self.surroundings(motion), ..Contacts::default() };
        if layout.cage {
            let pocket = self.pockets(first, motion, pose);
            all.pocket = pocket.wrench;
            (all.reaction.cage_force, all.reaction.cage_moment) = (pocket.reaction_force, pocket.reaction_moment);
            if let Some(watch) = watch.as_deref_mut() {
                (0..watched).for_each(|lane| watch.pocket(first + lane, &pocket.load.at(lane)));
            }
        }
        let on = self.raceways(motion, spindle, shaft);
        all.inner = on.inner;
        all.reaction.spindle = on.reaction;
        for lane in 0..LANES {
            let contacts = on.inner.at(lane).and(on.outer.at(lane)).and(all.pocket.at(lane));
            all.wrench.put(lane, contacts.and(all.wrench.at(lane)));
        }
        if let Some(watch) = watch {
            for lane in 0..watched {
                watch.raceway(first + lane, BallContact::Outer, &on.relative.outer.at(lane), &on.load.outer.at(lane));
                let Wrench { force, moment } = on.inner.at(lane);
                let load = RacewayLoad { force, moment, ..on.load.inner.at(lane) };
                watch.raceway(first + lane, BallContact::Inner, &on.relative.inner.at(lane), &load);
            }
        }
        all
    }

    #[inline(always)]
    pub(super) fn ball_motions(
        &self,
        first: usize,
        state: &BallState<Lanes>,
        (angle, speed, _): Shaft,
    ) -> BallMotion<Lanes> {
        let m = &self.mechanism;
        let start: Lanes = Lanes::of(&m.start.angle, first);
        let (pitch_radius, ideal_spin) = (m.pitch_radius, m.spin_ratio * speed);
        let (per_radius, orbit_angle, orbit_speed) = (1.0 / pitch_radius, m.orbit_ratio * angle, m.orbit_ratio * speed);
        let mut motion = BallMotion::default();
        for lane in 0..LANES {
            let state = state.at(lane);
            let azimuth = start[lane] + orbit_angle + state.arc * per_radius;
            let radius = pitch_radius + state.radial;
            let orbit_speed = orbit_speed + state.arc_velocity * per_radius;
            motion.put(
                lane,
                BallMotion {
                    azimuth_angle: azimuth,
                    azimuth: Azimuth::new(azimuth),
                    axial: state.axial,
                    radius,
                    orbit_speed,
                    velocity: [state.axial_velocity, state.radial_velocity, radius * orbit_speed],
                    spin: [state.spin[0] + ideal_spin, state.spin[1], state.spin[2]],
                },
            );
        }
        motion
    }

    /// Both raceways on the balls, and the balls on the spindle.
    #[inline(always)]
    fn raceways(&self, motion: &BallMotion<Lanes>, spindle: &SpindleState, shaft: Shaft) -> OnRaceways<Lanes> {
        match self.tilted_axis {
            None => self.raceways_in(motion, spindle, shaft, StraightFrame::new),
            Some(axis) => self.raceways_in(motion, spindle, shaft, |azimuth: Azimuth, from_centre| {
                TiltedFrame::new(azimuth.to_orbit(axis), from_centre)
            }),
        }
    }

    #[inline(always)]
    fn raceways_in<F: ContactFrame>(
        &self,
        motion: &BallMotion<Lanes>,
        spindle: &SpindleState,
        shaft: Shaft,
        frame: impl Fn(Azimuth, Vector) -> F,
    ) -> OnRaceways<Lanes> {
        let mut outer = RelativeMotion::<Lanes>::default();
        for lane in 0..LANES {
            let motion = motion.at(lane);
            outer.put(
                lane,
                RelativeMotion {
                    axial: motion.axial,
                    radius: motion.radius,
                    velocity: motion.velocity,
                    spin: motion.spin,
                    raceway_speed: 0.0,
                    orbit_speed: motion.orbit_speed,
                    azimuth: motion.azimuth_angle,
                },
            );
        }
        let (inner, frames) = self.inner_motions(motion, spindle, shaft, frame);
        let relative = PerRaceway { inner, outer };
        let load = RacewayContact::pair_of_loads::<PLANAR>(&self.mechanism.raceway, &relative, self.instructions);
        let (inner, reaction) = on_inner(motion, &frames, &load.inner);
        let outer = Wrench { force: load.outer.force, moment: load.outer.moment };
        OnRaceways { relative, load, outer, inner, reaction }
    }

    /// The inner raceway alone, and the balls on the spindle.
    #[inline(always)]
    pub(super) fn inner(
        &self,
        motion: &BallMotion<Lanes>,
        spindle: &SpindleState,
        shaft: Shaft,
    ) -> (Wrench<Lanes>, Vector<Lanes>) {
        match self.tilted_axis {
            None => self.inner_in(motion, spindle, shaft, StraightFrame::new),
            Some(axis) => self.inner_in(motion, spindle, shaft, |azimuth: Azimuth, from_centre| {
                TiltedFrame::new(azimuth.to_orbit(axis), from_centre)
            }),
        }
    }

    #[inline(always)]
    fn inner_in<F: ContactFrame>(
        &self,
        motion: &BallMotion<Lanes>,
        spindle: &SpindleState,
        shaft: Shaft,
        frame: impl Fn(Azimuth, Vector) -> F,
    ) -> (Wrench<Lanes>, Vector<Lanes>) {
        let (relative, frames) = self.inner_motions(motion, spindle, shaft, frame);
        let load = self.mechanism.raceway.inner.loads::<PLANAR>(&relative, self.instructions);
        on_inner(motion, &frames, &load)
    }

    /// Motions of the balls relative to the inner raceway, and the frames they are in.
    #[inline(always)]
    fn inner_motions<F: ContactFrame>(
        &self,
        motion: &BallMotion<Lanes>,
        spindle: &SpindleState,
        (angle, speed, _): Shaft,
        frame: impl Fn(Azimuth, Vector) -> F,
    ) -> (RelativeMotion<Lanes>, F::Several) {
        let [x, y, z] = spindle.position;
        let (position, spindle_velocity) = ([x + self.mechanism.axial_offset, y, z], spindle.velocity);
        let mut relative = RelativeMotion::<Lanes>::default();
        let mut frames = F::Several::default();
        for lane in 0..LANES {
            let motion = motion.at(lane);
            let centre = motion.azimuth.to_orbit(position);
            let velocity = motion.azimuth.to_orbit(spindle_velocity);
            let frame = frame(motion.azimuth, [motion.axial - centre[0], motion.radius - centre[1], -centre[2]]);
            let (axial, radius) = frame.place();
            relative.put(
                lane,
                RelativeMotion {
                    axial,
                    radius,
                    velocity: frame.components(subtract(motion.velocity, velocity)),
                    spin: frame.components(motion.spin),
                    raceway_speed: speed,
                    orbit_speed: motion.orbit_speed,
                    azimuth: motion.azimuth_angle - angle,
                },
            );
            frames.put(lane, frame);
        }
        (relative, frames)
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

    /// The pockets on their balls, and the balls on the cage.
    #[inline(always)]
    pub(super) fn pockets(&self, first: usize, motion: &BallMotion<Lanes>, cage: &CagePose) -> OnCage<Lanes> {
        let m = &self.mechanism;
        let start: Azimuth<Lanes> =
            Azimuth { cosine: Lanes::of(&m.start.cosine, first), sine: Lanes::of(&m.start.sine, first) };
        let (CageMotion { centre, velocity: cage_velocity, tilt, spin: cage_spin }, cage_azimuth) =
            (cage.motion, cage.azimuth);
        let pocket_centre = [m.cage.offset, m.pitch_radius, 0.0];
        let mut places = [<Lanes>::default(); 3];
        let mut relative = PocketMotion::<Lanes>::default();
        // All in the cage's tilted frame, from its centre of mass.
        for lane in 0..LANES {
            let motion = motion.at(lane);
            let azimuth = motion.azimuth;
            let place = azimuth.to_inertial([motion.axial, motion.radius, 0.0]);
            let ball_place = tilt.to_tilted(subtract(place, centre));
            let pocket_azimuth = cage_azimuth.turned(start.at(lane));
            let pocket_place = pocket_azimuth.to_inertial(pocket_centre);
            let velocity = tilt.to_tilted(subtract(azimuth.to_inertial(motion.velocity), cage_velocity));
            places.put(lane, ball_place);
            relative.put(
                lane,
                PocketMotion {
                    displacement: subtract(ball_place, pocket_place),
                    velocity: subtract(velocity, cross(cage_spin, ball_place)),
                    spin: subtract(tilt.to_tilted(azimuth.to_inertial(motion.spin)), cage_spin),
                },
            );
        }
        let load = m.pocket.loads(&relative);
        let mut on = OnCage { load, ..OnCage::default() };
        for lane in 0..LANES {
            let (azimuth, load) = (motion.azimuth.at(lane), load.at(lane));
            let to_orbit = |v| azimuth.to_orbit(tilt.to_inertial(v));
            on.wrench.put(lane, Wrench { force: to_orbit(load.force), moment: to_orbit(load.moment) });
            on.reaction_force.put(lane, scale(-1.0, load.force));
            on.reaction_moment.put(lane, scale(-1.0, cross(add(places.at(lane), load.lever), load.force)));
        }
        on
    }

    /// Drag, churning and weight of the balls.
    #[inline(always)]
    fn surroundings(&self, motion: &BallMotion<Lanes>) -> Wrench<Lanes> {
        let m = &self.mechanism;
        let (weight, pitch_radius) = (m.ball_mass * m.gravity, m.pitch_radius);
        let mut wrench = Wrench::<Lanes>::default();
        for lane in 0..LANES {
            let Azimuth { cosine, sine } = motion.azimuth.at(lane);
            wrench.put(lane, Wrench { force: [0.0, weight * cosine, -weight * sine], moment: [0.0; 3] });
        }
        if let Some(drag) = m.drag {
            for lane in 0..LANES {
                wrench.force[2][lane] += drag.force(pitch_radius * motion.orbit_speed[lane]);
            }
        }
        if let Some(churning) = m.churning {
            for lane in 0..LANES {
                wrench.moment.put(lane, churning.churning_moment(motion.spin.at(lane)));
            }
        }
        wrench
    }

    /// Rates of the balls' states under all that acts on them.
    #[inline(always)]
    pub(super) fn ball_rates(
        &self,
        state: &BallState<Lanes>,
        motion: &BallMotion<Lanes>,
        wrench: &Wrench<Lanes>,
        (_, _, acceleration): Shaft,
    ) -> BallState<Lanes> {
        let m = &self.mechanism;
        let (mass, inertia, pitch_radius) = (m.ball_mass, m.ball_inertia, m.pitch_radius);
        let (orbit_acceleration, spin_acceleration) = (m.orbit_ratio * acceleration, m.spin_ratio * acceleration);
        let mut rates = BallState::default();
        for lane in 0..LANES {
            let (state, motion) = (state.at(lane), motion.at(lane));
            let Wrench { force, moment } = wrench.at(lane);
            let BallAcceleration { axial, radial, azimuthal, spin } = motion.acceleration(force, moment, mass, inertia);
            rates.put(
                lane,
                BallState {
                    axial: state.axial_velocity,
                    radial: state.radial_velocity,
                    arc: state.arc_velocity,
                    axial_velocity: axial,
                    radial_velocity: radial,
                    arc_velocity: pitch_radius * (azimuthal - orbit_acceleration),
                    spin: [spin[0] - spin_acceleration, spin[1], spin[2]],
                },
            );
        }
        rates
    }

    #[inline(always)]
    pub(super) fn cage_rates(
        &self,
        state: &CageState,
        pose: &CagePose,
        reaction: &Reaction,
        (_, _, acceleration): Shaft,
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
    pub(super) fn spindle_rates(
        &self,
        state: &SpindleState,
        reaction: Vector,
        (angle, speed, acceleration): Shaft,
    ) -> SpindleState {
        let m = &self.mechanism;
        let mut force = add(m.load, reaction);
        force[1] += m.spindle_mass * m.gravity;
        if m.unbalance != 0.0 {
            force = add(force, unbalance_force(m.unbalance, angle, speed, acceleration));
        }
        SpindleState { position: state.velocity, ..self.spindle_response(force) }
    }
}

/// The inner raceway on the balls, in their orbit frames, and the balls on the spindle, in the inertial frame.
#[inline(always)]
fn on_inner<F: ContactFrame>(
    motion: &BallMotion<Lanes>,
    frames: &impl SideBySide<One = F>,
    load: &RacewayLoad<Lanes>,
) -> (Wrench<Lanes>, Vector<Lanes>) {
    let (mut wrench, mut reaction) = (Wrench::<Lanes>::default(), <[Lanes; 3]>::default());
    for lane in 0..LANES {
        let (frame, force, moment) = (frames.at(lane), load.force.at(lane), load.moment.at(lane));
        let force = frame.vector(force);
        wrench.put(lane, Wrench { force, moment: frame.vector(moment) });
        reaction.put(lane, scale(-1.0, motion.azimuth.at(lane).to_inertial(force)));
    }
    (wrench, reaction)
}

/// Where a ball sits on the inner raceway: place and axes of the contact's frame, in the orbit frame.
trait ContactFrame: Copy {
    type Several: SideBySide<One = Self> + Default;
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

impl StraightFrame {
    #[inline(always)]
    fn new(_: Azimuth, from_centre: Vector) -> Self {
        let [axial, r, t] = from_centre;
        let radius = (r * r + t * t).sqrt();
        let per_radius = 1.0 / radius;
        Self { axial, radius, turn: Azimuth { cosine: per_radius * r, sine: per_radius * t } }
    }
}

impl ContactFrame for StraightFrame {
    type Several = StraightFrame<Lanes>;

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

impl TiltedFrame {
    #[inline(always)]
    fn new(axis: Vector, from_centre: Vector) -> Self {
        let axial = dot(from_centre, axis);
        let across = subtract(from_centre, scale(axial, axis));
        let radius = dot(across, across).sqrt();
        let radial = scale(1.0 / radius, across);
        Self { axial, radius, axis, radial, tangential: cross(axis, radial) }
    }
}

impl ContactFrame for TiltedFrame {
    type Several = TiltedFrame<Lanes>;

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

    fn jacobian(&self, time: f64, state: &[f64], _rate: &[f64], _displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        self.differences(time, state, jacobian)
    }
}
