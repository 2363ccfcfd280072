//! ModelLevel 3: four states. Balls go round equally spaced at the cage's speed, each in radial equilibrium between its raceways;
//! only the spindle's place and velocity are integrated. Corrections of first order keep what the balls' inertia and rolling add
//! (`docs/MODEL.md`, rungs).

use std::f64::consts::TAU;

use super::Mechanism;
use super::condensed_contact::{CondensedContact, Unloaded};
use crate::numerics::lanes::{LANES, Lanes, larger};
use crate::numerics::ode::adams_moulton::{Defect, EquationsOfMotion, Motion, Shares};
use crate::physics::operation::SpeedProfile;
use crate::physics::raceway::RacewayContact;
use crate::physics::spindle::unbalance_force;

/// Load at which half of a ball's traction follows the spindle [N]: below, it slips.
const ROLLING_LOAD: f64 = 1.0;
/// Share of a ball's mass that the spindle moves along when it shifts a rolling ball tangentially: the ball goes half as far
/// (½ · ½ m) and turns (0.4 m · ½ · ½ of its inertia 0.1 m d²) [-].
const ROLLING_MASS: f64 = 0.35;
/// Place of the spindle y, z [m] and its velocity [m/s].
pub type SpindleMotion = Motion<2>;

/// Stiffness that stands in for none while a rest is sought [N/m], and the longest move then [m].
const LOOSE: f64 = 1e4;
const LONGEST_MOVE: f64 = 2e-6;

/// Corrections that can be left out, to see what each is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corrections {
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
    pub const ALL: Self = Self { tilt: true, damping: true, inertia: true, rolling: true };
}

/// The equations of motion.
#[derive(Debug, Clone)]
pub struct SpindleOnly {
    speed: SpeedProfile,
    /// Where it never changes [rad/s].
    constant: Option<f64>,
    /// Orbit speed of cage and balls over spindle speed [-].
    orbit_ratio: f64,
    /// Azimuth from one ball to the next [rad], and its reciprocal.
    spacing: (f64, f64),
    balls: usize,
    first: Group,
    others: Vec<Group>,
    contact: CondensedContact,
    unloaded: Unloaded,
    mass_of_ball: f64,
    orbit_radius: f64,
    /// Approach of the centred bearing [m]: −P_d/2.
    centred: f64,
    /// 1/r, r the orbit radius under load [1/m].
    curvature: f64,
    /// χ [s/m].
    damping: f64,
    mass: f64,
    ball_mass: f64,
    rolling_mass: f64,
    rolling: f64,
    /// Approach beyond touch at which half of it follows [m].
    rolling_approach: f64,
    unbalance: f64,
    /// Load and weight [N].
    force: [f64; 2],
}

/// Balls side by side; those that fill up the last group have no direction.
#[derive(Debug, Clone)]
struct Group {
    cosine: Lanes,
    sine: Lanes,
}

/// The spindle's turning at a time: orbit speed [rad/s], direction of the first pocket, and what acts besides balls [N].
#[derive(Debug, Clone, Copy, Default)]
pub struct Driven {
    orbit: f64,
    cosine: f64,
    sine: f64,
    force: [f64; 2],
}

impl SpindleOnly {
    /// From the mechanism of the full dynamics; `damping`: χ of the raceways [s/m], `orbit_ratio`: cage speed over spindle speed. The centrifugal force is that
    /// of the largest speed.
    pub fn new(mechanism: &Mechanism, damping: f64, orbit_ratio: f64, corrections: Corrections) -> Self {
        let m = mechanism;
        let balls = m.layout.balls;
        let touching = |contact: &RacewayContact| contact.penetration::<true>(0.0, m.pitch_radius).0;
        let centred = m.raceway.map(touching);
        let orbit_radius = m.pitch_radius - centred.outer;
        let speed = m.speed.largest();
        let contact = CondensedContact::new(m.raceway.map(|contact| contact.hertz().stiffness));
        let mut groups: Vec<Group> = (0..balls.div_ceil(LANES))
            .map(|group| {
                let of = |value: &dyn Fn(usize) -> f64| {
                    Lanes(std::array::from_fn(|lane| {
                        let ball = group * LANES + lane;
                        if ball < balls { value(ball) } else { 0.0 }
                    }))
                };
                Group { cosine: of(&|ball| m.start_azimuth(ball).cos()), sine: of(&|ball| m.start_azimuth(ball).sin()) }
            })
            .collect();
        let on = |on: bool, value: f64| if on { value } else { 0.0 };
        Self {
            constant: m.speed.is_constant().then(|| m.speed.at(0.0).1),
            speed: m.speed.clone(),
            balls,
            first: groups.remove(0),
            others: groups,
            unloaded: contact.unloaded(m.ball_mass, orbit_radius, orbit_ratio * speed, 0.0),
            contact,
            mass_of_ball: m.ball_mass,
            orbit_radius,
            orbit_ratio,
            spacing: (TAU / balls as f64, balls as f64 / TAU),
            centred: centred.inner + centred.outer,
            curvature: on(corrections.tilt, 1.0 / orbit_radius),
            damping: on(corrections.damping, damping),
            mass: m.spindle_mass,
            ball_mass: on(corrections.inertia, m.ball_mass),
            rolling_mass: on(corrections.rolling, ROLLING_MASS * m.ball_mass),
            rolling: on(corrections.rolling, 0.5),
            rolling_approach: (ROLLING_LOAD / m.raceway.inner.hertz().stiffness).powf(2.0 / 3.0),
            unbalance: m.unbalance,
            force: [m.load[1] + m.spindle_mass * m.gravity, m.load[2]],
        }
    }

    /// Takes the centrifugal force at another spindle speed [rad/s].
    pub fn refit(&mut self, speed: f64) {
        self.unloaded = self.contact.unloaded(self.mass_of_ball, self.orbit_radius, self.orbit_ratio * speed, 0.0);
    }

    /// Angular speed of the spindle at a time, and whether it never changes.
    pub fn speed(&self, time: f64) -> (f64, bool) {
        (self.speed.at(time).1, self.constant.is_some())
    }

    /// Orbit speed over spindle speed [-].
    pub fn orbit_ratio(&self) -> f64 {
        self.orbit_ratio
    }

    /// Where the spindle rests with balls at their start azimuths [m], and the frequency of its stiffest direction there
    /// [rad/s]. Newton's method in steps that stay small against clearances; a rest is only where a run begins.
    pub fn rest(&self) -> ([f64; 2], f64) {
        let mut place = [0.0, 0.0];
        let mut stiffest = 0.0;
        for _ in 0..200 {
            let mut force = self.force;
            let mut stiffness = [0.0; 3];
            for group in std::iter::once(&self.first).chain(&self.others) {
                for lane in 0..LANES {
                    let (c, s) = (group.cosine[lane], group.sine[lane]);
                    let load = self.contact.load(self.centred + place[0] * c + place[1] * s, &self.unloaded);
                    let (load, k) = (load.load, load.stiffness);
                    force = [force[0] - load * c, force[1] - load * s];
                    stiffness = [stiffness[0] + k * c * c, stiffness[1] + k * c * s, stiffness[2] + k * s * s];
                }
            }
            let [a, b, c] = stiffness;
            stiffest = 0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt();
            let held = 1e-2 * stiffest + LOOSE;
            let [a, c] = [a + held, c + held];
            let determinant = a * c - b * b;
            let step = [(c * force[0] - b * force[1]) / determinant, (a * force[1] - b * force[0]) / determinant];
            let length = step[0].hypot(step[1]);
            let share = (LONGEST_MOVE / length).min(1.0);
            place = [place[0] + share * step[0], place[1] + share * step[1]];
            if length < 1e-10 {
                break;
            }
        }
        (place, (stiffest / self.mass).sqrt())
    }

    pub fn balls(&self) -> usize {
        self.balls
    }

    /// What drives the spindle at the times of a row of steps.
    #[inline(always)]
    pub fn drives(&self, time: impl Fn(usize) -> f64, drives: &mut [Driven]) {
        for (eight, drives) in drives.chunks_exact_mut(LANES).enumerate() {
            let (mut turnings, mut azimuths) = ([(0.0, 0.0, 0.0); LANES], Lanes::<LANES>::default());
            for lane in 0..LANES {
                turnings[lane] = self.turning(time(eight * LANES + lane));
                azimuths[lane] = self.first_ball(&turnings[lane]);
            }
            let (mut sines, mut cosines) = (Lanes::<LANES>::default(), Lanes::<LANES>::default());
            for lane in 0..LANES {
                (sines[lane], cosines[lane]) = sine_cosine(azimuths[lane]);
            }
            for (lane, drive) in drives.iter_mut().enumerate() {
                *drive = self.driven(&turnings[lane], (sines[lane], cosines[lane]));
            }
        }
    }

    /// Angle, speed and acceleration of the spindle.
    #[inline(always)]
    fn turning(&self, time: f64) -> (f64, f64, f64) {
        match self.constant {
            Some(speed) => (speed * time, speed, 0.0),
            None => self.speed.at(time),
        }
    }

    /// Azimuth of a ball: they are alike, and the nearest to azimuth 0 may pass for the first.
    #[inline(always)]
    fn first_ball(&self, (angle, _, _): &(f64, f64, f64)) -> f64 {
        let turned = self.orbit_ratio * angle;
        turned - (turned * self.spacing.1).round_ties_even() * self.spacing.0
    }

    #[inline(always)]
    fn driven(&self, &(angle, speed, acceleration): &(f64, f64, f64), (sine, cosine): (f64, f64)) -> Driven {
        let mut force = self.force;
        if self.unbalance != 0.0 {
            let unbalance = unbalance_force(self.unbalance, angle, speed, acceleration);
            force = [force[0] + unbalance[1], force[1] + unbalance[2]];
        }
        Driven { orbit: self.orbit_ratio * speed, cosine, sine, force }
    }

    /// What the balls of a group add to the defect.
    #[inline(always)]
    // Over lanes by number: five results and two columns side by side have no one iterator.
    #[allow(clippy::needless_range_loop)]
    fn group(
        &self,
        group: &Group,
        driven: &Driven,
        ([y, z], [vy, vz]): &SpindleMotion,
        [ay, az]: [f64; 2],
        shares: Shares,
    ) -> Defect {
        let mut of = [Lanes::<LANES>::default(); 5];
        // Copies, for a store might change what is behind a reference.
        let (contact, unloaded, speed) = (self.contact, self.unloaded, driven.orbit);
        let half_curvature = 0.5 * self.curvature;
        for lane in 0..LANES {
            let c = group.cosine[lane] * driven.cosine - group.sine[lane] * driven.sine;
            let s = group.sine[lane] * driven.cosine + group.cosine[lane] * driven.sine;
            let (radial, tangential) = (y * c + z * s, z * c - y * s);
            let (radial_velocity, tangential_velocity) = (vy * c + vz * s, vz * c - vy * s);
            let tilt = self.curvature * tangential;
            let approach = (self.centred + radial) - half_curvature * (tangential * tangential);
            let rate = radial_velocity + speed * tangential - tilt * (tangential_velocity - speed * radial);
            let load = contact.load(approach, &unloaded);
            // χ (a_i² Q_i + a_e² Q_e) with Q_e = Q_i + F: what does not wait for the load is made ready.
            let (inner, outer) = (load.inner_share * load.inner_share, load.outer_share * load.outer_share);
            let damping = self.damping * rate;
            let normal =
                larger(load.load * (1.0 + damping * (inner + outer)) + damping * (outer * unloaded.force), 0.0);
            // The ball follows by its outer share: m a_e² D̈. Half the slope of a_e² times Ḋ² would belong to it: a thousandth of
            // the load and less.
            let turning = speed * (2.0 * tangential_velocity - speed * radial);
            let moved = self.ball_mass * outer;
            // Q/(Q + 1 N) by the approach, Q going with its power 3/2: no need to wait for the load.
            let rolls = load.pressed / (load.pressed + self.rolling_approach);
            let along = self.rolling_mass * rolls;
            let lean = tilt * (1.0 - self.rolling * rolls);
            let (normal_y, normal_z) = (c + s * lean, s - c * lean);
            let inertia = moved * (turning + (ay * c + az * s));
            let dragged = along * (speed * radial_velocity - (az * c - ay * s));
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

impl EquationsOfMotion for SpindleOnly {
    type Drive = Driven;

    #[inline(always)]
    fn drive(&self, time: f64) -> Driven {
        let turning = self.turning(time);
        self.driven(&turning, sine_cosine(self.first_ball(&turning)))
    }

    /// Of the spindle. The slope is that of elastic loads over the approach and of damping over its rate.
    #[inline(always)]
    fn defect(&self, driven: &Driven, motion: &SpindleMotion, acceleration: [f64; 2], shares: Shares) -> Defect {
        let [ay, az] = acceleration;
        let force = [driven.force[0] - self.mass * ay, driven.force[1] - self.mass * az];
        let slope = [self.mass, 0.0, self.mass];
        // The first group by itself: in a loop the processor would be made to fill its registers anew with what all lanes share.
        let mut all = Defect { force, slope }.and(&self.group(&self.first, driven, motion, acceleration, shares));
        for group in &self.others {
            all = all.and(&self.group(group, driven, motion, acceleration, shares));
        }
        all
    }
}

/// In pairs, so that eight lanes need three steps and not seven.
#[inline(always)]
fn sum(Lanes(l): &Lanes) -> f64 {
    ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
}

/// Sine and cosine of an angle up to ±π/2, to 1e-12 there and to rounding below 1: without a call into the platform's
/// mathematics, and the same bits everywhere. Taylor's series, both side by side.
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
    fn sine_and_cosine_are_those_of_the_platform() {
        for k in -100..=100 {
            let angle = f64::from(k) / 100.0 * std::f64::consts::FRAC_PI_2;
            let (sine, cosine) = sine_cosine(angle);
            assert!((sine - angle.sin()).abs() < 2e-12 && (cosine - angle.cos()).abs() < 2e-12, "{angle}");
        }
    }
}
