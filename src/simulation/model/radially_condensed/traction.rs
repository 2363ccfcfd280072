//! Traction of one raceway on eight balls side by side: the strip sum of `physics/raceway.rs` in the plane, with what
//! depends on a ball's load alone made ready as polynomials.

use super::contact_law::{chebyshev_fit, polynomial};
use super::{Lane, WIDTH, positive, total};
use crate::numerics::exponential::exponential;
use crate::physics::contact::traction::{FourParameters, MAX_STRIPS, Strips};
use crate::physics::raceway::{RacewayContact, RelativeMotion};

/// Terms of the series of √(1 − x) after the first.
const SERIES: [f64; 4] = [-0.5, -0.125, -0.0625, -5.0 / 128.0];
/// Largest (a / ball radius)² for which the series is good to 3e-5 of the radius.
pub const WIDEST: f64 = 0.25;
/// Slip up to which μ/u is a polynomial, in units of 1/C of the law.
const REACH: f64 = 1.0;
const DEGREE: usize = 6;
/// Change of slip by which the general law is differentiated [m/s].
const SLIP_STEP: f64 = 1e-3;

/// Sums over the strips of one contact, divided by its load.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    /// Force along the groove, raceway on ball.
    pub force: Lane,
    /// Its moment: force times height over the ball's centre [m].
    pub moment: Lane,
    /// Slope of the force over slip [s/m].
    pub slope: Lane,
    /// Slip at the middle of the contact [m/s].
    pub slip: Lane,
}

/// Slip over a contact is base + height · per_height.
#[derive(Debug, Clone, Copy, Default)]
pub struct Slip {
    pub base: Lane,
    pub per_height: Lane,
}

/// The traction of one raceway, made ready.
#[derive(Debug, Clone)]
pub enum RacewayTraction {
    /// The four-parameter law that vanishes at rest, no hydrodynamic terms, narrow contacts.
    Rising(Box<RisingTraction>),
    /// Everything else: ball by ball through the contact of the full model.
    General,
}

#[derive(Debug, Clone)]
pub struct RisingTraction {
    law: FourParameters,
    /// μ/u over u in 0 … reach, in powers of 2u/reach − 1.
    fit: [f64; DEGREE + 1],
    reach: f64,
    strips: usize,
    weight: [f64; MAX_STRIPS],
    /// Height of each strip over the ball's centre in powers of a².
    height: [[f64; SERIES.len()]; MAX_STRIPS],
    /// That of the middle of the contact.
    apex: [f64; SERIES.len()],
    ball_radius: f64,
}

impl RisingTraction {
    pub fn new(law: FourParameters, strips: usize, conformity: bool, ball_radius: f64, deformed_radius: f64) -> Self {
        let reach = REACH / law.c;
        // h = r_b + Σ c_j s^j [r_b^(1−2j) − R_d^(1−2j) (1 − t^2j)], s = a².
        let height_at = |position: f64| -> [f64; SERIES.len()] {
            std::array::from_fn(|i| {
                let power = i as i32 + 1;
                let shape = |radius: f64| radius.powi(1 - 2 * power);
                let at_place = if conformity { position.powi(2 * power) } else { 0.0 };
                SERIES[i] * (shape(ball_radius) - shape(deformed_radius) * (1.0 - at_place))
            })
        };
        let strips = Strips::new(strips);
        // Both sides of the groove slip alike: one side with twice the weight, and the middle.
        let all = strips.as_slice();
        let mut half = all[..all.len().div_ceil(2)].to_vec();
        half[..all.len() / 2].iter_mut().for_each(|strip| strip.weight *= 2.0);
        Self {
            law,
            fit: chebyshev_fit(|t| over_speed(&law, t * REACH, (-t * REACH).exp())),
            reach,
            strips: half.len(),
            weight: std::array::from_fn(|k| half.get(k).map_or(0.0, |strip| strip.weight)),
            height: std::array::from_fn(|k| half.get(k).map_or([0.0; SERIES.len()], |strip| height_at(strip.position))),
            apex: height_at(0.0),
            ball_radius,
        }
    }

    /// The sums for squares of the semi-major axes [m²]; `loaded`: 0 for contacts that do not count.
    #[inline(always)]
    pub fn sums(&self, slip: &Slip, square: &Lane, loaded: &Lane) -> Sums {
        let mut sums = Sums::default();
        let mut slides = Lane::default();
        for k in 0..WIDTH {
            let s = square.0[k];
            let height = self.ball_radius + s * horner(&self.apex, s);
            let edge = self.ball_radius + s * horner(&self.height[0], s);
            sums.slip.0[k] = slip.base.0[k] + height * slip.per_height.0[k];
            let at_edge = slip.base.0[k] + edge * slip.per_height.0[k];
            let beyond = positive(sums.slip.0[k].abs() - self.reach) + positive(at_edge.abs() - self.reach);
            slides.0[k] = beyond * loaded.0[k];
        }
        let beyond = total(&slides) > 0.0;
        if beyond {
            self.add_strips(slip, square, &mut sums, |speed| {
                let x = self.law.c * speed;
                let decay = exponential(-x);
                (over_speed(&self.law, x, decay), decay * (self.law.d * self.law.c + self.law.b * (1.0 - x)))
            });
        } else {
            let scale = 2.0 / self.reach;
            let steepest = self.law.d * self.law.c + self.law.b;
            self.add_strips(slip, square, &mut sums, |speed| {
                let speed = self.reach - positive(self.reach - speed);
                let over = polynomial(&self.fit, scale.mul_add(speed, -1.0));
                // The matrix of the implicit part needs the slope to a few per cent only: dμ/du = μ/u + u (μ/u)'.
                (over, over.mul_add(2.0, -steepest))
            });
        }
        sums
    }

    #[inline(always)]
    fn add_strips(&self, slip: &Slip, square: &Lane, sums: &mut Sums, law: impl Fn(f64) -> (f64, f64)) {
        for strip in 0..self.strips {
            let (weight, coefficients) = (self.weight[strip], &self.height[strip]);
            for k in 0..WIDTH {
                let s = square.0[k];
                let height = s.mul_add(horner(coefficients, s), self.ball_radius);
                let speed = height.mul_add(slip.per_height.0[k], slip.base.0[k]);
                let (over, slope) = law(speed.abs());
                let force = weight * over * speed;
                let slope = positive(slope);
                sums.force.0[k] += force;
                sums.moment.0[k] = force.mul_add(height, sums.moment.0[k]);
                sums.slope.0[k] = weight.mul_add(slope, sums.slope.0[k]);
            }
        }
    }
}

/// μ/u of the four-parameter law with A = −D at x = C u, D C (1 − e^−x)/x + B e^−x.
#[inline(always)]
fn over_speed(law: &FourParameters, x: f64, decay: f64) -> f64 {
    let near = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)));
    let far = (1.0 - decay) / (x + f64::MIN_POSITIVE);
    law.d * law.c * if x < 0.01 { near } else { far } + law.b * decay
}

#[inline(always)]
fn horner(c: &[f64; SERIES.len()], x: f64) -> f64 {
    x.mul_add(x.mul_add(x.mul_add(c[3], c[2]), c[1]), c[0])
}

/// Force and moment over the load by the contact of the full model, at a given normal load: the rate of penetration is set so
/// that the contact carries just that. `towards`: 1 for the outer raceway, −1 for the inner one.
pub fn general_sums(
    contact: &RacewayContact,
    motion: &RelativeMotion,
    towards: f64,
    load: f64,
    chi: f64,
    ball_radius: f64,
) -> [f64; 4] {
    let at = |spin: f64| {
        let mut motion = RelativeMotion { spin: [spin, 0.0, 0.0], ..*motion };
        let elastic = contact.elastic_load(contact.penetration::<true>(0.0, motion.radius).0).0;
        let rate = if chi > 0.0 && elastic > 0.0 { (load / elastic - 1.0) / chi } else { 0.0 };
        motion.velocity[1] = towards * rate;
        let seen = contact.load::<true>(&motion);
        let share = if seen.normal > 0.0 { 1.0 / seen.normal } else { 0.0 };
        (seen.force[2] * share, towards * seen.moment[0] * share, seen.slip.0)
    };
    let spin = motion.spin[0];
    let (force, moment, slip) = at(spin);
    let step = SLIP_STEP / ball_radius;
    let (force_there, _, slip_there) = at(spin + step);
    let change = slip_there - slip;
    let slope = if change.abs() > 0.0 { ((force_there - force) / change).max(0.0) } else { 0.0 };
    [force, moment, slope, slip]
}
