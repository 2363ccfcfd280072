//! Rung 3: four states. Balls go round equally spaced at the cage's speed, each in radial equilibrium between its raceways;
//! only the spindle's place and velocity are integrated. Corrections of first order keep what the balls' inertia and rolling add
//! (`docs/MODEL.md`, rungs).

use std::f64::consts::TAU;

use super::Mechanism;
use super::condensed_contact::{CondensedContact, Unloaded, polynomial};
use crate::numerics::lanes::{LANES, larger};
use crate::numerics::ode::adams_moulton::{EquationsOfMotion, Motion};
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
    /// Cosine and sine of the balls' start azimuths and 1 for each ball.
    groups: Vec<Group>,
    contact: CondensedContact,
    unloaded: Unloaded,
    mass_of_ball: f64,
    orbit_radius: f64,
    /// Approach of the centred bearing [m]: −P_d/2.
    centred: f64,
    /// 1/(2r), r the orbit radius under load [1/m].
    half_curvature: f64,
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

/// Balls of a group at most. Twice what stands side by side: a loop known to turn at most eight times would be unrolled
/// by the compiler before it thinks of laying the balls side by side.
const GROUP: usize = 2 * LANES;

#[derive(Debug, Clone)]
struct Group {
    /// Balls, filled up to a multiple of `LANES`.
    count: usize,
    cosine: [f64; GROUP],
    sine: [f64; GROUP],
    present: [f64; GROUP],
}

/// Sums over the balls: force on the spindle [N] and the masses that move with it [kg].
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    force: [f64; 2],
    mass: [f64; 3],
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
        let groups = (0..balls.div_ceil(GROUP))
            .map(|group| {
                let of = |value: &dyn Fn(usize) -> f64| {
                    std::array::from_fn(|lane| {
                        let ball = group * GROUP + lane;
                        if ball < balls { value(ball) } else { 0.0 }
                    })
                };
                Group {
                    count: (balls - group * GROUP).min(GROUP).next_multiple_of(LANES),
                    cosine: of(&|ball| m.start_azimuth(ball).cos()),
                    sine: of(&|ball| m.start_azimuth(ball).sin()),
                    present: of(&|_| 1.0),
                }
            })
            .collect();
        let on = |on: bool, value: f64| if on { value } else { 0.0 };
        Self {
            constant: m.speed.is_constant().then(|| m.speed.at(0.0).1),
            speed: m.speed.clone(),
            balls,
            groups,
            unloaded: contact.unloaded(m.ball_mass, orbit_radius, orbit_ratio * speed, 0.0),
            contact,
            mass_of_ball: m.ball_mass,
            orbit_radius,
            orbit_ratio,
            spacing: (TAU / balls as f64, balls as f64 / TAU),
            centred: centred.inner + centred.outer,
            half_curvature: on(corrections.tilt, 0.5 / orbit_radius),
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
            for group in &self.groups {
                for lane in 0..group.count {
                    let (c, s) = (group.cosine[lane], group.sine[lane]);
                    let load = self.contact.load(self.centred + place[0] * c + place[1] * s, &self.unloaded);
                    let (load, k) = (group.present[lane] * load.load, group.present[lane] * load.stiffness);
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

    /// `orbit`: orbit speed [rad/s], cosine and sine of the first pocket's azimuth.
    #[inline(always)]
    fn acceleration_at(&self, orbit: (f64, f64, f64), mut force: [f64; 2], motion: &SpindleMotion) -> [f64; 2] {
        let mut mass = [self.mass, 0.0, self.mass];
        for group in &self.groups {
            let sums = self.group(group, orbit, motion);
            force = [force[0] + sums.force[0], force[1] + sums.force[1]];
            mass = [mass[0] + sums.mass[0], mass[1] + sums.mass[1], mass[2] + sums.mass[2]];
        }
        let [yy, yz, zz] = mass;
        let per_determinant = 1.0 / (yy * zz - yz * yz);
        [(zz * force[0] - yz * force[1]) * per_determinant, (yy * force[1] - yz * force[0]) * per_determinant]
    }

    #[inline(always)]
    // Over lanes by number: five results and three columns side by side have no one iterator.
    #[allow(clippy::needless_range_loop)]
    fn group(&self, group: &Group, (speed, cosine, sine): (f64, f64, f64), motion: &SpindleMotion) -> Sums {
        let ([y, z], [vy, vz]) = *motion;
        let mut of = [[0.0; GROUP]; 5];
        // A copy, for a store might change what is behind a reference.
        let (contact, unloaded) = (self.contact, self.unloaded);
        for lane in 0..group.count.min(GROUP) {
            let c = group.cosine[lane] * cosine - group.sine[lane] * sine;
            let s = group.sine[lane] * cosine + group.cosine[lane] * sine;
            let (radial, tangential) = (y * c + z * s, z * c - y * s);
            let (radial_velocity, tangential_velocity) = (vy * c + vz * s, vz * c - vy * s);
            let tilt = 2.0 * self.half_curvature * tangential;
            let approach = self.centred + radial - 0.5 * tilt * tangential;
            let rate = radial_velocity + speed * tangential - tilt * (tangential_velocity - speed * radial);
            let load = contact.load(approach, &unloaded);
            let normal = load.load + self.damping * load.damped_load * rate;
            let normal = larger(normal, 0.0);
            // The ball follows by its outer share: m a_e² D̈, here without the spindle's own acceleration. Half the slope of
            // a_e² times Ḋ² would belong to it: a thousandth of the load and less.
            let turning = speed * (2.0 * tangential_velocity - speed * radial);
            let moved = self.ball_mass * load.outer_share * load.outer_share;
            let inertia = moved * turning;
            // Q/(Q + 1 N) by the approach, Q going with its power 3/2: no need to wait for the load.
            let rolls = group.present[lane] * load.pressed / (load.pressed + self.rolling_approach);
            let along = self.rolling_mass * rolls;
            let inwards = -(normal + inertia) * group.present[lane];
            let sideways =
                normal * group.present[lane] * tilt * (1.0 - self.rolling * rolls) + along * speed * radial_velocity;
            of[0][lane] = inwards * c - sideways * s;
            of[1][lane] = inwards * s + sideways * c;
            let moved = moved * group.present[lane];
            of[2][lane] = moved * c * c + along * s * s;
            of[3][lane] = (moved - along) * c * s;
            of[4][lane] = moved * s * s + along * c * c;
        }
        let [fy, fz, yy, yz, zz] = of.map(|lanes| sum(&lanes));
        Sums { force: [fy, fz], mass: [yy, yz, zz] }
    }
}

impl EquationsOfMotion<2> for SpindleOnly {
    /// Of the spindle [m/s²], time [s].
    #[inline(always)]
    fn acceleration(&self, time: f64, motion: &SpindleMotion) -> [f64; 2] {
        let (angle, speed, acceleration) = match self.constant {
            Some(speed) => (speed * time, speed, 0.0),
            None => self.speed.at(time),
        };
        // Balls are alike: the nearest to azimuth 0 may pass for the first.
        let turned = self.orbit_ratio * angle;
        let nearest = turned - (turned * self.spacing.1).round_ties_even() * self.spacing.0;
        let (sine, cosine) = sine_cosine(nearest);
        let orbit = (self.orbit_ratio * speed, cosine, sine);
        let mut force = self.force;
        if self.unbalance != 0.0 {
            let unbalance = unbalance_force(self.unbalance, angle, speed, acceleration);
            force = [force[0] + unbalance[1], force[1] + unbalance[2]];
        }
        self.acceleration_at(orbit, force, motion)
    }
}

/// In pairs, so that sixteen lanes need four steps and not fifteen.
#[inline(always)]
fn sum(of: &[f64; GROUP]) -> f64 {
    let l: [f64; LANES] = std::array::from_fn(|lane| of[lane] + of[lane + LANES]);
    ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
}

/// Sine and cosine of an angle up to ±π/2, to 1e-12 there and to rounding below 1: without a call into the platform's
/// mathematics, and the same bits everywhere. Taylor's series.
#[inline(always)]
fn sine_cosine(angle: f64) -> (f64, f64) {
    let square = angle * angle;
    (angle * polynomial(&SINE, square).0, polynomial(&COSINE, square).0)
}

const SINE: [f64; 9] = taylor(1.0);
const COSINE: [f64; 9] = taylor(0.0);

/// (−1)ᵏ first!/(2k + first)!
const fn taylor(first: f64) -> [f64; 9] {
    let mut terms = [1.0; 9];
    let mut k = 1;
    while k < 9 {
        let n = 2.0 * k as f64 + first;
        terms[k] = -terms[k - 1] / (n * (n - 1.0));
        k += 1;
    }
    terms
}

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
