//! Equations (1)–(14) in vector form: each contact gives one force and one moment, applied with
//! opposite sign to the two bodies it joins.

use std::array::from_fn;

use super::ball_group::{BallLoads, Balls, Slopes};
use super::border::{Border, CagePose, OuterRing};
use super::contact_frame::{ContactFrame, StraightFrame, TiltedAxis, TiltedFrame};
use super::forces::{Reaction, Wrench};
use super::one_ball::{OneBall, moment_on_ring, on_inner, on_pocket};
use super::watch::Watch;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Task};
use crate::physics::ball::{BallMotion, Bodies};
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::CageMotion;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, length, scale, subtract};
use crate::physics::operation::Turn;
use crate::physics::pocket::{PocketLoad, PocketMotion, PocketSlopes};
use crate::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use crate::physics::spindle::unbalance_force;
use crate::simulation::input::channel::BallContact;
use crate::simulation::model::mechanism::{Mechanism, Rotations};
use crate::simulation::model::state::{BallAttitude, BallState, CageState, Layout, SpindleState};

/// Displacement over the size of an entry, for difference quotients: small against the indentation of a contact, large
/// against rounding.
const DISPLACEMENT: f64 = 1e-5;

/// Six degrees of freedom of each ball and of the cage: nine states a ball, twelve of the cage, four or six of the spindle.
pub type Full = Dynamics<false>;

/// Without motion along X and without tilt: five states a ball, six of the cage, four of the spindle. Exact where nothing acts
/// along X and the cage is symmetric about its pocket plane.
pub type Planar = Dynamics<true>;

/// The equations of motion with (`PLANAR = false`) or without motion along X.
#[derive(Debug, Clone)]
pub struct Dynamics<const PLANAR: bool> {
    mechanism: Mechanism,
    one: OneBall,
    /// Axis of a spindle that is held at a tilt; `None`: along X.
    held_axis: Option<TiltedAxis>,
    /// Vector instructions of the processor for balls side by side.
    instructions: InstructionSet,
    /// Displacements of the Jacobian: of the entries of a ball, of cage and spindle.
    displacements: Vec<f64>,
}

impl<const PLANAR: bool> Dynamics<PLANAR> {
    pub fn new(mechanism: Mechanism) -> Self {
        let held_axis =
            (!PLANAR && mechanism.misalignment != [0.0; 2]).then(|| TiltedAxis::new(mechanism.misalignment, [0.0; 2]));
        let one_ball = Layout { balls: 1, ..mechanism.layout };
        let displacements = one_ball.sizes().iter().map(|size| DISPLACEMENT * size).collect();
        let one = OneBall {
            pitch_radius: mechanism.pitch_radius,
            gravity: mechanism.gravity,
            axial_offset: mechanism.axial_offset,
            pocket_centre: [mechanism.cage.offset, mechanism.pitch_radius, 0.0],
            body: mechanism.nominal_body,
        };
        Self { mechanism, one, held_axis, instructions: InstructionSet::best(), displacements }
    }

    /// The same equations with other instructions of the same processor.
    pub(crate) fn with_instructions(mut self, instructions: InstructionSet) -> Self {
        self.instructions = instructions;
        self
    }

    pub(super) fn displacements(&self) -> &[f64] {
        &self.displacements
    }

    pub(super) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    pub(super) fn one(&self) -> &OneBall {
        &self.one
    }

    /// Layout of the state, with the level known to the compiler.
    #[inline(always)]
    pub(super) fn layout(&self) -> Layout {
        Layout { planar: PLANAR, ..self.mechanism.layout }
    }

    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Writes `dy/dt` and passes each load to `watch`.
    pub(crate) fn evaluate(&self, time: f64, y: &[f64], dy: &mut [f64], watch: Option<&mut (dyn Watch + '_)>) {
        self.instructions.run(Evaluation { dynamics: self, time, y, dy, watch });
    }

    /// `evaluate`, `LANES` balls side by side.
    #[inline(always)]
    fn evaluate_by(&self, time: f64, y: &[f64], dy: &mut [f64], watch: Option<&mut (dyn Watch + '_)>) {
        let layout = self.mechanism.layout;
        let spindle = layout.spindle(y);
        let rings = Rings { inner: spindle, outer: None };
        let (border, reaction) = self.bearing_by(time, y, rings, dy, watch);
        layout.set_spindle(dy, &self.spindle_rates(&border, reaction.sum.spindle, reaction.on_tilt));
    }

    /// Writes the rates of balls and cage at a motion of the rings. Returns what balls and cage exert.
    #[inline(always)]
    pub(super) fn bearing_by(
        &self,
        time: f64,
        y: &[f64],
        rings: Rings,
        dy: &mut [f64],
        mut watch: Option<&mut (dyn Watch + '_)>,
    ) -> (Border, OnRings) {
        let layout = self.mechanism.layout;
        // The state is gathered before the border: the scalar stores reach the cache before the vector loads.
        let mut state = layout.side_by_side::<PLANAR>(y, 0);
        let mut border = self.border(layout.cage(y), rings.inner, time);
        border.outer = rings.outer.map(OuterRing::new);
        let OnRings { mut sum, mut on_tilt, mut on_outer } = OnRings::default();
        let mut balls = Balls::new(layout.tilting_spindle);
        for first in (0..layout.balls).step_by(LANES) {
            if first > 0 {
                state = layout.side_by_side::<PLANAR>(y, first);
            }
            if layout.attitude {
                balls.attitude = Some([layout.attitudes(y, first), BallAttitude::default()]);
            }
            self.balls(first, &state, &border, &mut balls, watch.as_deref_mut(), None);
            balls.reaction.sum_into(&mut sum, layout.balls - first);
            balls.add_on_tilt(&mut on_tilt, layout.balls - first);
            balls.add_on_outer(&mut on_outer, layout.balls - first);
            layout.set_side_by_side::<PLANAR>(dy, first, &balls.rates);
            if let Some([_, rates]) = &balls.attitude {
                layout.set_attitudes(dy, first, rates);
            }
        }
        if let Some(contact) = &self.mechanism.neighbours {
            self.add_neighbours(contact, (y, dy), &border.rotations, |ball, load| {
                if let Some(watch) = watch.as_deref_mut() {
                    watch.neighbour(ball, load);
                }
            });
        }
        layout.set_cage(dy, &self.cage_rates(&border, &sum));
        self.add_land(&border, &mut on_outer);
        (border, OnRings { sum, on_tilt, on_outer })
    }

    /// Evaluates motion, rates and reactions of the balls from `first` on.
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
        match self.axis(&border.spindle) {
            Some(axis) => self.balls_in::<TiltedFrame>(first, state, border, &axis, balls, asked),
            _ => self.balls_in::<StraightFrame>(first, state, border, &(), balls, asked),
        }
    }

    /// Axis of the spindle; `None`: along X.
    #[inline(always)]
    fn axis(&self, spindle: &SpindleState) -> Option<TiltedAxis> {
        match self.mechanism.layout.tilting_spindle {
            _ if PLANAR => None,
            true => Some(TiltedAxis::new(spindle.tilt, spindle.tilt_rate)),
            false => self.held_axis,
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
        let (one, axis, Border { pose, spindle, rotations, .. }) = (self.one, *axis, *border);
        let start: Lanes = Lanes::of(&m.start.angle, first);
        let mut relative: PerRaceway<RelativeMotion<Lanes>> = PerRaceway::default();
        let mut frames = F::Several::default();
        for lane in 0..LANES {
            let motion = one.motion(start[lane], &state.at(lane), &rotations);
            let (inner, frame) = one.over_inner::<F>(&motion, &spindle, &rotations, &axis);
            relative.outer.put(lane, one.over_outer(&motion, &rotations));
            relative.inner.put(lane, inner);
            frames.put(lane, frame);
            balls.motion.put(lane, motion);
        }
        self.turn_azimuths::<F>(&frames, &mut relative.inner);
        let outer_frames = match &border.outer {
            None => None,
            Some(ring) => Some(self.over_moving_outer(&balls.motion, ring, &rotations, &mut relative.outer)),
        };
        m.raceway.outer.place_in_groove(&mut relative.outer);
        m.raceway.inner.place_in_groove(&mut relative.inner);
        if let Some([attitude, rates]) = &mut balls.attitude {
            *rates = self.attitude_rates(state, attitude, &rotations);
        }
        // Filled in only where balls differ from nominal spheres.
        let of_balls;
        let on_balls = match self.has_nominal_spheres() {
            true => None,
            false => {
                of_balls = self.on_balls::<F>(
                    first,
                    balls.attitude.as_ref(),
                    &relative,
                    (&frames, outer_frames.as_ref()),
                    &rotations,
                );
                Some(&of_balls)
            }
        };
        // Drag stands before the raceways: its long dependency chains overlap with their work.
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
        RacewayContact::pair_of_loads::<PLANAR>(&m.raceway, &relative, on_balls, &mut load, self.instructions);
        if let Some(slopes) = slopes {
            let (on_inner, on_outer) = (on_balls.map(|on| &on.inner), on_balls.map(|on| &on.outer));
            m.raceway.outer.slopes::<PLANAR>(&relative.outer, on_outer, &load.outer, &mut slopes.raceway.outer);
            m.raceway.inner.slopes::<PLANAR>(&relative.inner, on_inner, &load.inner, &mut slopes.raceway.inner);
            m.raceway.outer.rolling_speeds(
                &relative.outer,
                &slopes.raceway.outer,
                &mut slopes.loads.rolling_speed.outer,
            );
            m.raceway.inner.rolling_speeds(
                &relative.inner,
                &slopes.raceway.inner,
                &mut slopes.loads.rolling_speed.inner,
            );
            slopes.loads.load = PerRaceway { inner: load.inner.normal, outer: load.outer.normal };
            slopes.loads.angle = PerRaceway { inner: load.inner.angle, outer: load.outer.angle };
            slopes.slip = PerRaceway { inner: load.inner.slip, outer: load.outer.slip };
            slopes.loads.pocket = in_pocket.normal;
            let tilt = pose.motion.tilt;
            for lane in 0..LANES {
                let (azimuth, pocket) = (balls.motion.azimuth.at(lane), slopes.pocket.at(lane));
                let normal = azimuth.to_orbit(tilt.to_inertial(pocket.normal));
                slopes.pocket.put(lane, PocketSlopes { normal, ..pocket });
                slopes.arm.put(lane, tilt.to_inertial(add(places.at(lane), in_pocket.lever.at(lane))));
            }
        }
        if let Some(frames) = &outer_frames {
            balls.on_outer = Some(on_moving_outer(&balls.motion, frames, &mut load.outer));
        }
        let loads = BallLoads {
            frames: &frames,
            raceway: &load,
            pocket: &in_pocket,
            places: &places,
            drag: &drag_force,
            churning_factor: &churning_factor,
        };
        match m.unequal_bodies(first) {
            None => self.respond::<F>(state, border, &loads, one.body, balls),
            Some(bodies) => self.respond::<F>(state, border, &loads, *bodies, balls),
        }
        if let Some(on_tilt) = &mut balls.on_tilt {
            *on_tilt = moments_on_inner::<F>(&balls.motion, &frames, &load.inner);
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

    /// Writes the motion of balls relative to an outer ring that moves, and returns the frames of its components.
    #[inline(never)]
    fn over_moving_outer(
        &self,
        motion: &BallMotion<Lanes>,
        ring: &OuterRing,
        rotations: &Rotations,
        relative: &mut RelativeMotion<Lanes>,
    ) -> TiltedFrame<Lanes> {
        let mut frames = TiltedFrame::<Lanes>::default();
        for lane in 0..LANES {
            let (mut over, frame) = self.one.over_moving_outer(&motion.at(lane), ring, rotations);
            if !self.mechanism.raceway.outer.is_circle() {
                over.azimuth += frame.turn();
            }
            relative.put(lane, over);
            frames.put(lane, frame);
        }
        frames
    }

    /// Writes the rates of balls of some size and mass under their loads, and their reactions.
    #[inline(always)]
    fn respond<F: ContactFrame>(
        &self,
        state: &BallState<Lanes>,
        border: &Border,
        loads: &BallLoads<F>,
        bodies: impl Bodies,
        balls: &mut Balls,
    ) {
        let (one, Border { pose, rotations, .. }) = (self.one, *border);
        for lane in 0..LANES {
            let motion = balls.motion.at(lane);
            let outer = loads.raceway.outer.at(lane);
            let (inner, spindle) = on_inner(motion.azimuth, &loads.frames.at(lane), &loads.raceway.inner.at(lane));
            let (pocket, [cage_force, cage_moment]) =
                on_pocket(motion.azimuth, &pose.motion.tilt, loads.places.at(lane), &loads.pocket.at(lane));
            let surroundings = Wrench {
                force: [0.0, 0.0, loads.drag[lane]],
                moment: scale(-loads.churning_factor[lane], motion.spin),
            };
            let outer = Wrench { force: outer.force, moment: outer.moment };
            let wrench = inner.and(outer).and(pocket).and(surroundings);
            balls.reaction.put(lane, Reaction { spindle, cage_force, cage_moment });
            balls.rates.put(lane, one.rates(&state.at(lane), &motion, &bodies.of(lane), wrench, &rotations));
        }
    }

    /// Returns true where contacts need nothing of the balls but their motion.
    #[inline(always)]
    fn has_nominal_spheres(&self) -> bool {
        !self.mechanism.layout.attitude && self.mechanism.has_equal_balls()
    }

    /// Refers azimuths on the inner raceway to its own axis, where it is not a circle.
    #[inline(always)]
    fn turn_azimuths<F: ContactFrame>(&self, frames: &F::Several, relative: &mut RelativeMotion<Lanes>) {
        if self.mechanism.raceway.inner.is_circle() {
            return;
        }
        for lane in 0..LANES {
            relative.azimuth[lane] += frames.at(lane).turn();
        }
    }

    /// Writes the pocket loads of the balls from `first` on and the balls' places in the cage, in the cage's tilted frame. On request it
    /// also writes the slopes of the loads over the balls' own motion. Writes nothing without a cage.
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
        if let Some(bodies) = m.unequal_bodies(first) {
            relative.oversize = bodies.oversize;
        }
        match slopes {
            None => m.pocket.loads(&relative, load),
            Some(slopes) => m.pocket.loads_and_slopes(&relative, load, slopes),
        }
    }

    /// Loads of the inner raceway on the balls from `first` on, and of the balls on the spindle.
    #[inline(always)]
    pub(super) fn inner_part(&self, first: usize, balls: &Balls, border: &Border) -> InnerPart {
        match self.axis(&border.spindle) {
            Some(axis) => self.inner_part_in::<TiltedFrame>(first, balls, border, &axis),
            _ => self.inner_part_in::<StraightFrame>(first, balls, border, &()),
        }
    }

    #[inline(always)]
    fn inner_part_in<F: ContactFrame>(
        &self,
        first: usize,
        Balls { motion, attitude, .. }: &Balls,
        border: &Border,
        axis: &F::Axis,
    ) -> InnerPart {
        let (one, axis, Border { spindle, rotations, .. }) = (self.one, *axis, *border);
        let mut relative = RelativeMotion::<Lanes>::default();
        let mut frames = F::Several::default();
        for lane in 0..LANES {
            let (inner, frame) = one.over_inner::<F>(&motion.at(lane), &spindle, &rotations, &axis);
            relative.put(lane, inner);
            frames.put(lane, frame);
        }
        self.turn_azimuths::<F>(&frames, &mut relative);
        self.mechanism.raceway.inner.place_in_groove(&mut relative);
        let mut load = RacewayLoad::<Lanes>::default();
        let of_balls;
        let on_balls = match self.has_nominal_spheres() {
            true => None,
            false => {
                of_balls = self.on_balls_at_inner::<F>(first, attitude.as_ref(), &relative, &frames, &rotations);
                Some(&of_balls)
            }
        };
        self.mechanism.raceway.inner.loads::<PLANAR>(&relative, on_balls, &mut load, self.instructions);
        let mut part = InnerPart { wrench: Wrench::default(), on_spindle: Default::default(), on_tilt: None };
        for lane in 0..LANES {
            let (wrench, reaction) = on_inner(motion.azimuth.at(lane), &frames.at(lane), &load.at(lane));
            part.wrench.put(lane, wrench);
            part.on_spindle.put(lane, reaction);
        }
        if self.mechanism.layout.tilting_spindle {
            part.on_tilt = Some(moments_on_inner::<F>(motion, &frames, &load));
        }
        part
    }

    /// Loads of the pockets on their balls, and force and moment of the balls on the cage.
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

    /// Rates of the balls from `first` on caused by an additional wrench.
    #[inline(always)]
    pub(super) fn ball_response(
        &self,
        first: usize,
        motion: &BallMotion<Lanes>,
        wrench: &Wrench<Lanes>,
    ) -> BallState<Lanes> {
        match self.mechanism.unequal_bodies(first) {
            None => self.one.responses(motion, self.one.body, wrench),
            Some(bodies) => self.one.responses(motion, *bodies, wrench),
        }
    }

    #[inline(always)]
    pub(super) fn border(&self, cage: CageState, spindle: SpindleState, time: f64) -> Border {
        let rotations = self.mechanism.rotations(time);
        let damping = self.mechanism.damping.map_or(0.0, |damping| damping.at(time));
        Border { pose: self.cage_pose(&cage, &rotations), cage, spindle, outer: None, rotations, time, damping }
    }

    #[inline(always)]
    pub(super) fn cage_pose(&self, state: &CageState, rotations: &Rotations) -> CagePose {
        let m = &self.mechanism;
        let [x, y, z] = state.centre;
        let [about_y, about_z] = state.tilt_rate;
        CagePose {
            motion: CageMotion {
                // The pocket plane lies in the plane of the balls when the cage is in its place.
                centre: [x - m.cage.offset, y, z],
                velocity: state.velocity,
                tilt: if PLANAR { Tilt::NONE } else { Tilt::new(state.tilt[0], state.tilt[1]) },
                spin: [m.orbit_speed(rotations, state.arc_velocity), about_y, about_z],
            },
            azimuth: Azimuth::new(rotations.orbit.angle + state.arc / m.pitch_radius),
        }
    }

    #[inline(always)]
    pub(super) fn cage_rates(&self, border: &Border, reaction: &Reaction) -> CageState {
        let Border { cage: state, pose, rotations, damping, .. } = border;
        let m = &self.mechanism;
        if !m.layout.cage {
            return CageState::default();
        }
        let mut force = pose.motion.tilt.to_inertial(reaction.cage_force);
        let mut moment = reaction.cage_moment;
        if let Some((land_force, braking)) = self.land_load(border) {
            force = add(force, land_force);
            moment[0] += braking;
        }
        let mut rates = m.cage.acceleration(&pose.motion, force, moment, m.gravity);
        // Damping acts along the axis and in tilt only. In the plane the pocket films damp the cage, and it has to reach its orbit.
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
            arc_velocity: m.pitch_radius * (rates.angular[0] - rotations.orbit.acceleration),
            tilt_rate: [rates.angular[1], rates.angular[2]],
        }
    }

    /// Force and braking moment of the guiding land of the outer ring on the cage, in the inertial frame; `None` without one.
    #[inline(always)]
    fn land_load(&self, border: &Border) -> Option<(Vector, f64)> {
        let (land, cage) = (self.mechanism.land.as_ref()?, &border.pose.motion);
        let centre = border.outer.as_ref().map_or(cage.centre, |ring| {
            let ([x, y, z], [about_y, about_z]) = (subtract(cage.centre, ring.state.position), ring.state.tilt);
            [x, y - x * about_z, z + x * about_y]
        });
        Some(land.load(centre, cage.spin[0], border.rotations.outer.speed))
    }

    /// Adds the load of the cage on an outer ring that moves and has a guiding land.
    pub(super) fn add_land(&self, border: &Border, [force, moment]: &mut [Vector; 2]) {
        let (Some(ring), Some((on_cage, _))) = (&border.outer, self.land_load(border)) else { return };
        let on_ring = scale(-1.0, on_cage);
        *force = add(*force, on_ring);
        *moment = add(*moment, cross(subtract(border.pose.motion.centre, ring.state.position), on_ring));
    }

    /// Rates of the cage caused by a reaction.
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

    /// Rates of the spindle caused by a reaction and a moment. The moment is taken along the axes that the tilt angles turn about: Y and the
    /// new Z.
    #[inline(always)]
    pub(super) fn spindle_response(&self, reaction: Vector, moment: Vector, tilt: [f64; 2]) -> SpindleState {
        let velocity = scale(1.0 / self.mechanism.spindle_mass, reaction);
        let mut response = SpindleState { velocity, ..SpindleState::default() };
        if let Some(inertia) = self.mechanism.spindle_inertia {
            let [_, _, z] = Tilt::new(tilt[0], tilt[1]).columns;
            response.tilt_rate = [moment[1] / inertia.transverse, dot(moment, z) / inertia.transverse];
        }
        response
    }

    /// Equations (13), (14), and X and tilt where the spindle is free: I_t β̈_y + I_p Ω β̇_z = M_y, I_t β̈_z − I_p Ω β̇_y = M_z. The drive
    /// follows the tilted axis.
    #[inline(always)]
    pub(super) fn spindle_rates(&self, border: &Border, reaction: Vector, moment: Vector) -> SpindleState {
        let &Border { spindle: state, rotations, time, damping, .. } = border;
        let Turn { angle, speed, acceleration } = rotations.inner;
        let m = &self.mechanism;
        let mut force = add(m.load, reaction);
        force[1] += m.spindle_mass * m.gravity;
        if m.unbalance != 0.0 {
            force = add(force, unbalance_force(m.unbalance, angle, speed, acceleration));
        }
        let mut applied_moment = m.moment;
        if let Some([x, y, z, about_y, about_z]) = m.load_change(time, angle) {
            force = add(force, [x, y, z]);
            applied_moment = [applied_moment[0] + about_y, applied_moment[1] + about_z];
        }
        force = add(force, scale(-damping * m.spindle_mass, state.velocity));
        let mut rates = SpindleState { position: state.velocity, ..self.spindle_response(force, moment, state.tilt) };
        if let Some(inertia) = m.spindle_inertia {
            let gyroscopic = inertia.axial * speed / inertia.transverse;
            let [rate_y, rate_z] = state.tilt_rate;
            rates.tilt = state.tilt_rate;
            rates.tilt_rate = from_fn(|axis| rates.tilt_rate[axis] + applied_moment[axis] / inertia.transverse);
            rates.tilt_rate[0] -= gyroscopic * rate_z + damping * rate_y;
            rates.tilt_rate[1] += gyroscopic * rate_y - damping * rate_z;
        }
        rates
    }
}

/// Loads of the inner raceway on balls side by side.
pub(super) struct InnerPart {
    pub wrench: Wrench<Lanes>,
    /// Forces on the spindle, inertial frame [N].
    pub on_spindle: Vector<Lanes>,
    /// Moments on a spindle that tilts, inertial frame [N m].
    pub on_tilt: Option<Vector<Lanes>>,
}

/// Motion of both rings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rings {
    pub inner: SpindleState,
    /// `None`: the outer ring is at the origin.
    pub outer: Option<SpindleState>,
}

/// Forces and moments of balls and cage on the rings.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OnRings {
    pub sum: Reaction,
    /// Moment on an inner ring that tilts, about its centre, inertial frame [N m].
    pub on_tilt: Vector,
    /// Force, and moment about its centre, on an outer ring that moves, inertial frame [N, N m].
    pub on_outer: [Vector; 2],
}

/// Turns the loads of the raceway of an outer ring that moves on balls side by side into their orbit frames. Returns forces and moments on the
/// ring about its centre, inertial frame [N, N m].
#[inline(never)]
fn on_moving_outer(
    motion: &BallMotion<Lanes>,
    frames: &TiltedFrame<Lanes>,
    load: &mut RacewayLoad<Lanes>,
) -> [Vector<Lanes>; 2] {
    let mut on_ring = <[Vector<Lanes>; 2]>::default();
    for lane in 0..LANES {
        let (azimuth, frame, of_ring) = (motion.azimuth.at(lane), frames.at(lane), load.at(lane));
        let (Wrench { force, moment }, on_outer) = on_inner(azimuth, &frame, &of_ring);
        on_ring[0].put(lane, on_outer);
        on_ring[1].put(lane, moment_on_ring(azimuth, &frame, &of_ring));
        load.put(lane, RacewayLoad { force, moment, ..of_ring });
    }
    on_ring
}

/// Moments of balls side by side on the inner ring about its centre, inertial frame [N m].
#[inline(never)]
fn moments_on_inner<F: ContactFrame>(
    motion: &BallMotion<Lanes>,
    frames: &F::Several,
    load: &RacewayLoad<Lanes>,
) -> Vector<Lanes> {
    let mut moments = <Vector<Lanes>>::default();
    for lane in 0..LANES {
        moments.put(lane, moment_on_ring(motion.azimuth.at(lane), &frames.at(lane), &load.at(lane)));
    }
    moments
}

/// One evaluation, compiled for each instruction set.
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
