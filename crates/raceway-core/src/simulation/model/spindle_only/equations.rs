//! Equations of the spindle alone: four states. Balls orbit equally spaced at the cage's speed, each in radial equilibrium between its
//! raceways. Corrections of first order include the inertia and the rolling of the balls.

use std::f64::consts::{PI, TAU};

use crate::numerics::angle::sin_cos;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Task, larger};
use crate::numerics::ode::adams_moulton::{Defect, EquationsOfMotion, Motion, Shares};
use crate::physics::bearing::PerRaceway;
use crate::physics::loads::VaryingLoads;
use crate::physics::operation::SpeedProfile;
use crate::physics::raceway::RacewayContact;
use crate::physics::spindle::unbalance_force;
use crate::simulation::model::condensed_contact::{CondensedContact, Unloaded};
use crate::simulation::model::heights::{Heights, Lift, Waves};
use crate::simulation::model::mechanism::Mechanism;

/// Load at which half of a ball's traction follows the spindle [N]; at a smaller load the ball slips.
const ROLLING_LOAD: f64 = 1.0;
/// Share of a ball's mass that moves with a tangential shift of the spindle [-]: a rolling ball moves half as far (½ · ½ m) and turns
/// (0.4 m · ½ · ½ of its inertia 0.1 m d²).
const ROLLING_MASS: f64 = 0.35;
/// Place of the spindle y, z [m] and its velocity [m/s].
pub(crate) type SpindleMotion = Motion<2>;

/// Smallest stiffness in the search for the rest position [N/m].
const MIN_STIFFNESS: f64 = 1e4;
/// Longest step of that search [m].
const MAX_SEARCH_STEP: f64 = 2e-6;

/// Corrections of first order, each of which can be omitted to measure its effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Corrections {
    /// Approach −s_t²/(2r) and the force's direction.
    pub tilt: bool,
    /// Dissipation of both contacts.
    pub damping: bool,
    /// Radial inertia of the balls.
    pub inertia: bool,
    /// Tangential inertia and direction of rolling balls.
    pub rolling: bool,
}

impl Corrections {
    pub(crate) const ALL: Self = Self { tilt: true, damping: true, inertia: true, rolling: true };
}

/// The equations of motion.
#[derive(Debug, Clone)]
pub(crate) struct SpindleOnly {
    speed: SpeedProfile,
    /// Constant speed [rad/s]; `None` where the speed changes.
    constant: Option<f64>,
    /// Orbit speed of cage and balls over spindle speed [-].
    orbit_ratio: f64,
    /// Angle after which the balls are where others were [rad], and its reciprocal: that from one ball to the next where all are alike and
    /// equally spaced, else a turn.
    repeats: (f64, f64),
    /// True if raceways are ideal circles and all balls are alike.
    is_even: bool,
    balls: usize,
    first: Group,
    others: Vec<Group>,
    contact: CondensedContact,
    unloaded: Unloaded,
    mass_of_ball: f64,
    orbit_radius: f64,
    /// Approach of the centred bearing [m]: −P_d/2.
    centred: f64,
    /// Reciprocal of the orbit radius under load [1/m].
    curvature: f64,
    /// Damping coefficient χ of the raceways [s/m].
    damping: f64,
    mass: f64,
    ball_mass: f64,
    rolling_mass: f64,
    rolling: f64,
    /// Approach beyond touch at which half of a ball's traction follows [m].
    rolling_approach: f64,
    unbalance: f64,
    /// Load at the start and weight [N].
    force: [f64; 2],
    /// Changes of the load since the start, and the largest force; `None`: the load is constant.
    loads: Option<VaryingLoads>,
    largest_force: Option<[f64; 2]>,
    /// `None`: both raceways are ideal circles.
    waves: Option<Waves>,
    /// Spin of ideal balls in the orbit frame over spindle speed.
    turn_ratio: f64,
    /// Longest step that resolves waves and loads [s].
    longest_step: f64,
}

/// Directions of balls side by side; (0, 0) for lanes beyond the last ball.
#[derive(Debug, Clone)]
struct Group {
    cosine: Lanes,
    sine: Lanes,
    /// Azimuths in front of the first ball [rad].
    azimuth: Lanes,
    /// Number of the first of them.
    first: usize,
    /// Diameters less the nominal one [m].
    oversize: Lanes,
}

/// Prescribed motion at one time: orbit speed [rad/s], direction of the first pocket, and applied force [N]. Only wavy raceways ask for
/// the angles.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Driven {
    orbit: f64,
    cosine: f64,
    sine: f64,
    force: [f64; 2],
    /// Azimuth of the first pocket [rad].
    first: f64,
    /// Angle [rad] and speed [rad/s] of the shaft.
    shaft: (f64, f64),
}

impl Driven {
    /// Adds the changes of the load up to a time [s].
    fn add(&mut self, loads: &VaryingLoads, time: f64) {
        let [_, y, z, ..] = loads.at(time, self.shaft.0);
        self.force = [self.force[0] + y, self.force[1] + z];
    }
}

impl SpindleOnly {
    /// Equations from the mechanism of the full dynamics. `damping`: χ of the raceways [s/m]; `orbit_ratio`: cage speed over spindle speed.
    /// The centrifugal force is that of the largest speed.
    pub(crate) fn new(mechanism: &Mechanism, damping: f64, orbit_ratio: f64, corrections: Corrections) -> Self {
        let m = mechanism;
        let balls = m.layout.balls;
        let touching = |contact: &RacewayContact| contact.penetration::<true>(0.0, m.pitch_radius).0;
        let centred = m.raceway.map(touching);
        let orbit_radius = m.pitch_radius - centred.outer;
        let speed = m.rotation.inner.largest();
        let force = |m: &Mechanism| [m.load[1] + m.spindle_mass * m.gravity, m.load[2]];
        let contact = CondensedContact::new(m.raceway.map(|contact| contact.hertz().stiffness));
        let mut groups: Vec<Group> = (0..balls.div_ceil(LANES))
            .map(|group| {
                let of = |value: &dyn Fn(usize) -> f64| {
                    Lanes(std::array::from_fn(|lane| {
                        let ball = group * LANES + lane;
                        if ball < balls { value(ball) } else { 0.0 }
                    }))
                };
                Group {
                    cosine: of(&|ball| m.start_azimuth(ball).cos()),
                    sine: of(&|ball| m.start_azimuth(ball).sin()),
                    azimuth: of(&|ball| m.start_azimuth(ball)),
                    first: group * LANES,
                    oversize: of(&|ball| 2.0 * m.body(ball).oversize),
                }
            })
            .collect();
        let on = |on: bool, value: f64| if on { value } else { 0.0 };
        let waves = Waves::of(m);
        let are_alike = !waves.as_ref().is_some_and(Waves::are_of_balls) && m.has_equal_balls();
        let is_alike = are_alike && m.start.are_even();
        Self {
            constant: m.rotation.inner.is_constant().then(|| m.rotation.inner.at(0.0).1),
            speed: m.rotation.inner.clone(),
            balls,
            first: groups.remove(0),
            others: groups,
            unloaded: contact.unloaded(m.ball_mass, orbit_radius, orbit_ratio * speed, 0.0),
            contact,
            mass_of_ball: m.ball_mass,
            orbit_radius,
            orbit_ratio,
            repeats: if is_alike { (TAU / balls as f64, balls as f64 / TAU) } else { (TAU, 1.0 / TAU) },
            is_even: waves.is_none() && m.has_equal_balls(),
            centred: centred.inner + centred.outer,
            curvature: on(corrections.tilt, 1.0 / orbit_radius),
            damping: on(corrections.damping, damping),
            mass: m.spindle_mass,
            ball_mass: on(corrections.inertia, m.ball_mass),
            rolling_mass: on(corrections.rolling, ROLLING_MASS * m.ball_mass),
            rolling: on(corrections.rolling, 0.5),
            rolling_approach: (ROLLING_LOAD / m.raceway.inner.hertz().stiffness).powf(2.0 / 3.0),
            unbalance: m.unbalance,
            force: force(m),
            largest_force: m.under_largest_loads().as_ref().map(force),
            waves,
            turn_ratio: m.spin_ratio - m.orbit_ratio,
            loads: m.varying_loads.clone(),
            longest_step: m.longest_excited_step(),
        }
    }

    /// Longest step that resolves the waves of the raceways, and the loads [s].
    pub(crate) fn longest_step(&self) -> f64 {
        self.longest_step
    }

    /// Sets the centrifugal force to that at another spindle speed [rad/s].
    pub(crate) fn refit(&mut self, speed: f64) {
        self.unloaded = self.contact.unloaded(self.mass_of_ball, self.orbit_radius, self.orbit_ratio * speed, 0.0);
    }

    /// Angular speed of the spindle at a time [rad/s], and whether it is constant.
    pub(crate) fn speed(&self, time: f64) -> (f64, bool) {
        (self.speed.at(time).1, self.constant.is_some())
    }

    /// Orbit speed over spindle speed [-].
    pub(crate) fn orbit_ratio(&self) -> f64 {
        self.orbit_ratio
    }

    /// Rest position of the spindle with balls at their start azimuths [m], and the frequency of its stiffest direction there or under the largest
    /// load [rad/s].
    pub(crate) fn rest(&self) -> ([f64; 2], f64) {
        let (place, frequency) = self.rest_under(self.force);
        (place, self.largest_force.map_or(frequency, |largest| self.rest_under(largest).1.max(frequency)))
    }

    /// Rest position under a force [N], and the frequency of the stiffest direction there.
    /// Newton's method takes steps that are small against clearances. The rest position need not be exact, because it only starts a run.
    fn rest_under(&self, applied: [f64; 2]) -> ([f64; 2], f64) {
        let mut place = [0.0, 0.0];
        let mut stiffest = 0.0;
        for _ in 0..200 {
            let mut force = applied;
            let mut stiffness = [0.0; 3];
            for group in std::iter::once(&self.first).chain(&self.others) {
                for lane in 0..LANES {
                    let (c, s) = (group.cosine[lane], group.sine[lane]);
                    let centred = self.centred + group.oversize[lane];
                    let load = self.contact.load(centred + place[0] * c + place[1] * s, &self.unloaded);
                    let (load, k) = (load.load, load.stiffness);
                    force = [force[0] - load * c, force[1] - load * s];
                    stiffness = [stiffness[0] + k * c * c, stiffness[1] + k * c * s, stiffness[2] + k * s * s];
                }
            }
            let [a, b, c] = stiffness;
            stiffest = 0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt();
            let held = 1e-2 * stiffest + MIN_STIFFNESS;
            let [a, c] = [a + held, c + held];
            let determinant = a * c - b * b;
            let step = [(c * force[0] - b * force[1]) / determinant, (a * force[1] - b * force[0]) / determinant];
            let length = step[0].hypot(step[1]);
            let share = (MAX_SEARCH_STEP / length).min(1.0);
            place = [place[0] + share * step[0], place[1] + share * step[1]];
            if length < 1e-10 {
                break;
            }
        }
        (place, (stiffest / self.mass).sqrt())
    }

    pub(crate) fn balls(&self) -> usize {
        self.balls
    }

    /// Prescribed motion at the times of consecutive steps.
    #[inline(always)]
    pub(crate) fn drives(&self, time: impl Fn(usize) -> f64, drives: &mut [Driven]) {
        for (eight, drives) in drives.chunks_exact_mut(LANES).enumerate() {
            let (mut turnings, mut azimuths) = ([(0.0, 0.0, 0.0); LANES], Lanes::<LANES>::default());
            for lane in 0..LANES {
                turnings[lane] = self.turning(time(eight * LANES + lane));
                azimuths[lane] = self.first_ball(&turnings[lane]);
            }
            let (mut sines, mut cosines) = (Lanes::<LANES>::default(), Lanes::<LANES>::default());
            if self.repeats.0 < TAU {
                for lane in 0..LANES {
                    (sines[lane], cosines[lane]) = sine_cosine(azimuths[lane]);
                }
            } else {
                for lane in 0..LANES {
                    (sines[lane], cosines[lane]) = sin_cos(azimuths[lane]);
                }
            }
            for (lane, drive) in drives.iter_mut().enumerate() {
                *drive = self.driven(&turnings[lane], azimuths[lane], (sines[lane], cosines[lane]));
            }
            if let Some(loads) = &self.loads {
                for (lane, drive) in drives.iter_mut().enumerate() {
                    drive.add(loads, time(eight * LANES + lane));
                }
            }
        }
    }

    /// Angle, speed and acceleration of the spindle's rotation.
    #[inline(always)]
    fn turning(&self, time: f64) -> (f64, f64, f64) {
        match self.constant {
            Some(speed) => (speed * time, speed, 0.0),
            None => self.speed.at(time),
        }
    }

    /// Azimuth of the first ball, or of the one nearest to azimuth 0 that can replace it because all balls are alike.
    #[inline(always)]
    fn first_ball(&self, (angle, _, _): &(f64, f64, f64)) -> f64 {
        let turned = self.orbit_ratio * angle;
        turned - (turned * self.repeats.1).round_ties_even() * self.repeats.0
    }

    /// Sine and cosine of the azimuth of the first ball.
    #[inline(always)]
    fn direction(&self, first: f64) -> (f64, f64) {
        if self.repeats.0 < TAU { sine_cosine(first) } else { sin_cos(first) }
    }

    #[inline(always)]
    fn driven(
        &self,
        &(angle, speed, acceleration): &(f64, f64, f64),
        first: f64,
        (sine, cosine): (f64, f64),
    ) -> Driven {
        let mut force = self.force;
        if self.unbalance != 0.0 {
            let unbalance = unbalance_force(self.unbalance, angle, speed, acceleration);
            force = [force[0] + unbalance[1], force[1] + unbalance[2]];
        }
        Driven { orbit: self.orbit_ratio * speed, cosine, sine, force, first, shaft: (angle, speed) }
    }

    /// Contribution of a group of balls to the residual. `WAVY`: raceways have heights, or balls differ.
    #[inline(always)]
    // The loop is over lane numbers, because five results and two columns have no common iterator.
    #[allow(clippy::needless_range_loop)]
    fn group<const WAVY: bool>(
        &self,
        group: &Group,
        driven: &Driven,
        ([y, z], [vy, vz]): &SpindleMotion,
        [ay, az]: [f64; 2],
        shares: Shares,
        heights: &Heights<Lanes>,
    ) -> Defect {
        let mut of = [Lanes::<LANES>::default(); 5];
        // Local copies, because a store might change values behind a reference.
        let (contact, unloaded, speed) = (self.contact, self.unloaded, driven.orbit);
        let half_curvature = 0.5 * self.curvature;
        for lane in 0..LANES {
            let c = group.cosine[lane] * driven.cosine - group.sine[lane] * driven.sine;
            let s = group.sine[lane] * driven.cosine + group.cosine[lane] * driven.sine;
            let (radial, tangential) = (y * c + z * s, z * c - y * s);
            let (radial_velocity, tangential_velocity) = (vy * c + vz * s, vz * c - vy * s);
            let tilt = self.curvature * tangential;
            let mut approach = (self.centred + radial) - half_curvature * (tangential * tangential);
            let mut rate = radial_velocity + speed * tangential - tilt * (tangential_velocity - speed * radial);
            let mut raised = PerRaceway::<Lift>::default();
            if WAVY {
                let turning = self.curvature * (speed * radial - tangential_velocity);
                let speeds = PerRaceway { inner: speed + turning - driven.shaft.1, outer: speed };
                let contacts = PerRaceway { inner: speed + turning, outer: speed };
                raised = heights.at(lane).lifts(speeds, contacts, speed + self.turn_ratio * driven.shaft.1);
                approach += raised.inner.height + raised.outer.height + group.oversize[lane];
                rate += raised.inner.rate + raised.outer.rate;
            }
            let load = contact.load(approach, &unloaded);
            // χ (a_i² Q_i + a_e² Q_e) with Q_e = Q_i + F: the factors that do not depend on the load come first.
            let (inner, outer) = (load.inner_share * load.inner_share, load.outer_share * load.outer_share);
            let damping = self.damping * rate;
            let normal =
                larger(load.load * (1.0 + damping * (inner + outer)) + damping * (outer * unloaded.force), 0.0);
            // The ball follows by its outer share: m a_e² D̈. The term with half the slope of a_e² times Ḋ² is omitted: it is below a
            // thousandth of the load.
            let turning = speed * (2.0 * tangential_velocity - speed * radial);
            let moved = self.ball_mass * outer;
            // Q/(Q + 1 N) by the approach, which is known before the load Q.
            let rolls = load.pressed / (load.pressed + self.rolling_approach);
            let along = self.rolling_mass * rolls;
            let lean = tilt * (1.0 - self.rolling * rolls);
            let (normal_y, normal_z) = (c + s * lean, s - c * lean);
            let mut inertia = moved * (turning + (ay * c + az * s));
            let mut dragged = along * (speed * radial_velocity - (az * c - ay * s));
            if WAVY {
                let PerRaceway { inner: on_inner, outer: on_outer } = &raised;
                inertia += moved * (on_inner.acceleration + on_outer.acceleration)
                    - self.ball_mass * load.outer_share * on_outer.acceleration;
                // Heights push along the orbit. A rolling ball passes half of the push of either raceway on to the other.
                let (passed, slopes) = (self.rolling * rolls, heights.at(lane).slopes());
                let push = normal * slopes.inner * (1.0 - passed) - (normal + unloaded.force) * slopes.outer * passed;
                dragged += self.curvature * push;
            }
            let slope = moved + (shares.place * load.stiffness + (shares.velocity * self.damping) * load.damped_load);
            of[0][lane] = -(normal * normal_y) - (inertia * c + dragged * s);
            of[1][lane] = -(normal * normal_z) - (inertia * s - dragged * c);
            of[2][lane] = slope * (c * c) + along * (s * s);
            of[3][lane] = (slope - along) * (c * s);
            of[4][lane] = slope * (s * s) + along * (c * c);
        }
        let [fy, fz, yy, yz, zz] = of.map(|lanes| sum(&lanes));
        Defect { force: [fy, fz], slope: [yy, yz, zz] }
    }
}

/// The equations on wavy raceways, compiled for each instruction set.
struct OnWaves<'a> {
    model: &'a SpindleOnly,
    waves: Option<&'a Waves>,
    driven: Driven,
    motion: SpindleMotion,
    acceleration: [f64; 2],
    shares: Shares,
}

impl OnWaves<'_> {
    /// Heights under a group of balls. Azimuths are those on the rings, about each ring's axis: an inner one turns with the spindle.
    #[inline(always)]
    fn heights(&self, group: &Group) -> Heights<Lanes> {
        let Some(waves) = self.waves else { return Heights::default() };
        let (driven, ([y, z], _)) = (&self.driven, self.motion);
        let (mut azimuth, mut longitude) = (PerRaceway::<Lanes>::default(), PerRaceway::<Lanes>::default());
        let turned = -self.model.turn_ratio * driven.shaft.0;
        for lane in 0..LANES {
            let c = group.cosine[lane] * driven.cosine - group.sine[lane] * driven.sine;
            let s = group.sine[lane] * driven.cosine + group.cosine[lane] * driven.sine;
            let (tilt, on_outer) = (self.model.curvature * (z * c - y * s), driven.first + group.azimuth[lane]);
            azimuth.put(lane, PerRaceway { inner: on_outer - tilt - driven.shaft.0, outer: on_outer });
            longitude.put(lane, PerRaceway { inner: PI + turned - tilt, outer: turned });
        }
        let mut heights = waves.at(&azimuth);
        if waves.are_of_balls() {
            heights.ball = waves.of_balls(group.first, &longitude);
        }
        heights
    }
}

impl Task for OnWaves<'_> {
    type Answer = Defect;

    #[inline(always)]
    fn run(self) -> Defect {
        let Self { model, driven, motion, acceleration, shares, .. } = &self;
        let mut all =
            model.group::<true>(&model.first, driven, motion, *acceleration, *shares, &self.heights(&model.first));
        for group in &model.others {
            all = all.and(&model.group::<true>(group, driven, motion, *acceleration, *shares, &self.heights(group)));
        }
        all
    }
}

impl SpindleOnly {
    /// The sum of a residual and that of the balls.
    #[inline(always)]
    fn with_balls(
        &self,
        of_spindle: Defect,
        driven: &Driven,
        motion: &SpindleMotion,
        acceleration: [f64; 2],
        shares: Shares,
    ) -> Defect {
        if !self.is_even {
            let waves = self.waves.as_ref();
            let on = OnWaves { model: self, waves, driven: *driven, motion: *motion, acceleration, shares };
            return of_spindle.and(&self.on_waves(on));
        }
        let ideal = Heights::default();
        // The first group stands outside the loop, where the compiler keeps the common constants in registers.
        let first = self.group::<false>(&self.first, driven, motion, acceleration, shares, &ideal);
        let mut all = of_spindle.and(&first);
        for group in &self.others {
            all = all.and(&self.group::<false>(group, driven, motion, acceleration, shares, &ideal));
        }
        all
    }

    /// Residual of the balls alone at a time [s], for a ring that a shaft moves.
    #[inline(always)]
    pub(crate) fn of_balls(&self, time: f64, motion: &SpindleMotion, acceleration: [f64; 2], shares: Shares) -> Defect {
        let nothing = Defect { force: [0.0; 2], slope: [0.0; 3] };
        self.with_balls(nothing, &self.drive(time), motion, acceleration, shares)
    }

    /// Elastic loads of a ball on its raceways [N] at a time [s] and a place of the ring [m].
    pub(crate) fn loads_of_ball(&self, ball: usize, time: f64, place: [f64; 2]) -> PerRaceway<f64> {
        let driven = self.drive(time);
        let (at, lane) = (ball / LANES, ball % LANES);
        let group = if at == 0 { &self.first } else { &self.others[at - 1] };
        let c = group.cosine[lane] * driven.cosine - group.sine[lane] * driven.sine;
        let s = group.sine[lane] * driven.cosine + group.cosine[lane] * driven.sine;
        let [y, z] = place;
        let (radial, tangential) = (y * c + z * s, z * c - y * s);
        let on = OnWaves {
            model: self,
            waves: self.waves.as_ref(),
            driven,
            motion: (place, [0.0; 2]),
            acceleration: [0.0; 2],
            shares: Shares::default(),
        };
        let still = PerRaceway { inner: 0.0, outer: 0.0 };
        let raised = on.heights(group).at(lane).lifts(still, still, 0.0);
        let approach = self.centred + radial - 0.5 * self.curvature * tangential * tangential
            + group.oversize[lane]
            + raised.inner.height
            + raised.outer.height;
        let inner = self.contact.load(approach, &self.unloaded).load;
        PerRaceway { inner, outer: inner + self.unloaded.force }
    }

    /// Load of balls on wavy raceways. A call of its own: scenes with ideal circles keep their loops as they are.
    #[cold]
    #[inline(never)]
    fn on_waves(&self, on: OnWaves<'_>) -> Defect {
        InstructionSet::best().run(on)
    }
}

impl EquationsOfMotion for SpindleOnly {
    type Drive = Driven;

    #[inline(always)]
    fn drive(&self, time: f64) -> Driven {
        let turning = self.turning(time);
        let first = self.first_ball(&turning);
        let mut driven = self.driven(&turning, first, self.direction(first));
        if let Some(loads) = &self.loads {
            driven.add(loads, time);
        }
        driven
    }

    /// Residual of the spindle's equations. Its slope includes that of elastic loads over the approach and of damping over its rate.
    #[inline(always)]
    fn defect(&self, driven: &Driven, motion: &SpindleMotion, acceleration: [f64; 2], shares: Shares) -> Defect {
        let [ay, az] = acceleration;
        let force = [driven.force[0] - self.mass * ay, driven.force[1] - self.mass * az];
        let slope = [self.mass, 0.0, self.mass];
        self.with_balls(Defect { force, slope }, driven, motion, acceleration, shares)
    }
}

/// Sum in pairs: eight lanes need three dependent additions instead of seven.
#[inline(always)]
fn sum(Lanes(l): &Lanes) -> f64 {
    ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
}

/// Sine and cosine of an angle up to ±π/2, with an error of 1e-12 there and of rounding below 1. Taylor series give the same bits on every
/// platform, without a call into its mathematics.
#[inline(always)]
fn sine_cosine(angle: f64) -> (f64, f64) {
    let square = angle * angle;
    let [sine, cosine] = TAYLOR
        .iter()
        .rev()
        .fold([0.0; 2], |[sine, cosine], [in_sine, in_cosine]| [sine * square + in_sine, cosine * square + in_cosine]);
    (angle * sine, cosine)
}

/// (−1)ᵏ/(2k + 1)! and (−1)ᵏ/(2k)!
const TAYLOR: [[f64; 2]; 9] = {
    let mut terms = [[1.0; 2]; 9];
    let mut k = 1;
    while k < 9 {
        let n = 2.0 * k as f64;
        terms[k] = [-terms[k - 1][0] / (n * (n + 1.0)), -terms[k - 1][1] / (n * (n - 1.0))];
        k += 1;
    }
    terms
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_equal_those_of_the_platform() {
        for k in -100..=100 {
            let angle = f64::from(k) / 100.0 * std::f64::consts::FRAC_PI_2;
            let (sine, cosine) = sine_cosine(angle);
            assert!((sine - angle.sin()).abs() < 2e-12 && (cosine - angle.cos()).abs() < 2e-12, "{angle}");
        }
    }
}
