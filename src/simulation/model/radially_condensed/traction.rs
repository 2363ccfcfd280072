//! Traction of one raceway in the plane. The law that rises from rest is integrated over the contact by quadrature, every other
//! one by the contact of the full model.

use super::ball::Contact;
use crate::numerics::exponential::exponential;
use crate::numerics::lanes::{LANES, SideBySide, Singles, alike, larger, side_by_side, smaller};
use crate::physics::contact::traction::FourParameters;
use crate::physics::raceway::{RacewayContact, RelativeMotion};
use crate::simulation::model::condensed_contact::chebyshev;

/// Terms of the series of √(1 − x) after the first.
const SERIES: [f64; 4] = [-0.5, -0.125, -0.0625, -5.0 / 128.0];
/// Terms of it for what lies across the contact.
const ACROSS: usize = 3;
/// Largest (a / ball radius)² for which the series is good to 3e-5 of the radius.
pub(super) const WIDEST: f64 = 0.25;
/// Slip up to which μ/u is a polynomial, in units of 1/C of the law.
const REACH: f64 = 2.0;
/// Its terms: good to 4e-5 of its value at rest.
const TERMS: usize = 6;
/// Points of the quadrature on one side of the contact.
const POINTS: usize = 3;
/// Places t = η/a and weights of ∫ ¾ (1 − t²) g(t²) dt over −1 … 1, exact for g up to degree 5 (Gauss–Jacobi; the places are the
/// inner ones of Lobatto's rule with eight points, Abramowitz & Stegun, table 25.6).
const PLACES: [f64; POINTS] = [0.209_299_217_902_479, 0.591_700_181_433_142, 0.871_740_148_509_607];
const LOBATTO: [f64; POINTS] = [0.412_458_794_658_704, 0.341_122_692_483_504, 0.210_704_227_143_506];
/// Change of slip by which the general law is differentiated [m/s].
const SLIP_STEP: f64 = 1e-3;

/// Integrals over one contact, divided by its load.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums<T = f32> {
    /// Force along the groove, raceway on ball.
    pub force: T,
    /// Its moment: force times height over the ball's centre [m].
    pub moment: T,
    /// Slope of the force over slip [s/m], not negative.
    pub slope: T,
    /// Slip at the middle of the contact [m/s].
    pub slip: T,
}
side_by_side!(Sums { force, moment, slope, slip });

/// The traction of one raceway, made ready.
#[derive(Debug, Clone)]
pub(super) enum RacewayTraction {
    /// The four-parameter law that vanishes at rest, no hydrodynamic terms, narrow contacts.
    Rising(Box<RisingTraction>),
    /// Everything else: ball by ball through the contact of the full model.
    General,
}

#[derive(Debug, Clone)]
pub(super) struct RisingTraction {
    law: FourParameters,
    short: ShortForm,
    /// The same of every ball.
    pub all: ShortForm<Singles>,
}

/// The law by its fit, integrated over the contact.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ShortForm<T = f32> {
    /// Slope of the law at rest, B + C D [s/m].
    steepest: T,
    /// μ/u by powers of u, up to u = reach.
    fit: [T; TERMS],
    reach: T,
    weights: [T; POINTS],
    /// Height of the middle of the contact over the ball's centre, less its radius, and rise from there to each point, by
    /// powers of a².
    middle: [T; SERIES.len()],
    rise: [[T; ACROSS]; POINTS],
    ball_radius: T,
}
side_by_side!(ShortForm { steepest, fit, reach, weights, middle, rise, ball_radius });

impl RacewayTraction {
    /// dμ/du at rest [s/m], where it is known.
    pub fn steepest(&self) -> f64 {
        match self {
            Self::Rising(traction) => traction.short.steepest.into(),
            Self::General => 0.0,
        }
    }
}

impl RisingTraction {
    /// `conformity`: whether slip varies across the contact.
    pub fn new(law: FourParameters, conformity: bool, ball_radius: f64, deformed_radius: f64) -> Self {
        let reach = REACH / law.c;
        // h = r_b + Σ c_j s^j [r_b^(1−2j) − R_d^(1−2j) (1 − t^2j)], s = a².
        let shape = |radius: f64, term: usize| SERIES[term] * radius.powi(-1 - 2 * term as i32);
        let across = if conformity { 1.0 } else { 0.0 };
        let scaled: [f64; TERMS] = chebyshev(|t| over_speed(&law, t * REACH, (-t * REACH).exp()));
        let short = ShortForm {
            steepest: (law.d * law.c + law.b) as f32,
            fit: powers_of_the_argument(scaled, reach).map(|power| power as f32),
            reach: reach as f32,
            weights: std::array::from_fn(|k| (1.5 * LOBATTO[k] * (1.0 - PLACES[k] * PLACES[k])) as f32),
            middle: std::array::from_fn(|j| (shape(ball_radius, j) - shape(deformed_radius, j)) as f32),
            rise: PLACES.map(|t| {
                std::array::from_fn(|j| (across * shape(deformed_radius, j) * t.powi(2 * j as i32 + 2)) as f32)
            }),
            ball_radius: ball_radius as f32,
        };
        Self { law, short, all: alike(short) }
    }

    #[inline(always)]
    pub fn sums(&self, contact: &Contact<Singles>) -> Sums<Singles> {
        let mut sums = Sums::<Singles>::default();
        let mut beyond: Singles = Singles::default();
        for lane in 0..LANES {
            let (one, over) = self.all.at(lane).fitted(&contact.at(lane));
            sums.put(lane, one);
            beyond[lane] = over;
        }
        if beyond.any(|over| over > 0.0) {
            for lane in 0..LANES {
                let exact = |speed: f32| {
                    let x = self.law.c * f64::from(speed);
                    over_speed(&self.law, x, exponential(-x)) as f32
                };
                sums.put(lane, self.short.sums_by(&contact.at(lane), exact).0);
            }
        }
        sums
    }
}

impl ShortForm {
    /// The sums by the fit, and by how much the slip goes beyond it under load [m/s].
    #[inline(always)]
    pub fn fitted(&self, contact: &Contact) -> (Sums, f32) {
        let (one, fastest) = self.sums_by(contact, |speed| polynomial(&self.fit, smaller(speed, self.reach)));
        // dμ/du = μ/u + u (μ/u)', the latter a straight line: a few per cent serve.
        let slope = larger(2.0 * one.slope - self.steepest, 0.0);
        (Sums { slope, ..one }, if contact.load > 0.0 { fastest - self.reach } else { 0.0 })
    }

    /// The sums, with the mean of μ/u, never less than the slope, in place of that, and the fastest slip; `over_speed`: μ(u)/u.
    #[inline(always)]
    fn sums_by(&self, contact: &Contact, over_speed: impl Fn(f32) -> f32) -> (Sums, f32) {
        let s = contact.axis_square;
        let [m0, m1, m2, m3] = self.middle;
        let middle = self.ball_radius + s * ((m0 + s * m1) + s * s * (m2 + s * m3));
        let slip = contact.base + middle * contact.per_height;
        let (mut force, mut risen, mut mean, mut fastest) = (0.0, 0.0, 0.0, 0.0);
        for (weight, [r0, r1, r2]) in self.weights.into_iter().zip(self.rise) {
            let rise = s * (r0 + s * (r1 + s * r2));
            let speed = slip + rise * contact.per_height;
            fastest = larger(fastest, speed.abs());
            let over = weight * over_speed(speed.abs());
            let one = over * speed;
            mean += over;
            force += one;
            risen += one * rise;
        }
        (Sums { force, moment: force * middle + risen, slope: mean, slip }, fastest)
    }
}

/// From powers of x = 2u/reach − 1 to powers of u.
fn powers_of_the_argument(scaled: [f64; TERMS], reach: f64) -> [f64; TERMS] {
    let (mut powers, mut of_x) = ([0.0; TERMS], [0.0; TERMS]);
    of_x[0] = 1.0;
    for coefficient in scaled {
        for (power, term) in powers.iter_mut().zip(of_x) {
            *power += coefficient * term;
        }
        of_x = std::array::from_fn(|i| if i == 0 { 0.0 } else { of_x[i - 1] * 2.0 / reach } - of_x[i]);
    }
    powers
}

#[inline(always)]
fn polynomial([a, b, c, d, e, f]: &[f32; TERMS], u: f32) -> f32 {
    let square = u * u;
    (a + b * u) + square * ((c + d * u) + square * (e + f * u))
}

/// μ/u of the four-parameter law with A = −D at x = C u, D C (1 − e^−x)/x + B e^−x.
#[inline(always)]
fn over_speed(law: &FourParameters, x: f64, decay: f64) -> f64 {
    let near = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)));
    let far = (1.0 - decay) / (x + f64::MIN_POSITIVE);
    law.d * law.c * if x < 0.01 { near } else { far } + law.b * decay
}

/// A raceway of the full model, and how it moves.
pub(super) struct General<'a> {
    pub contact: &'a RacewayContact,
    /// 1 for the outer raceway, −1 for the inner one: from the ball towards it.
    pub towards: f64,
    /// Angular speed of the raceway and of the ball that rolls ideally [rad/s].
    pub raceway_speed: f64,
    pub spin: f64,
    /// Orbit radius of a ball that touches without load [m].
    pub touching: f64,
    pub chi: f64,
    pub ball_radius: f64,
}

impl General<'_> {
    /// `spin`: deviations from ideal rolling; `penetration`: of this contact.
    #[inline(never)]
    pub fn sums(
        &self,
        contact: &Contact<Singles>,
        spin: &Singles,
        penetration: &Singles,
        orbit: &Singles,
    ) -> Sums<Singles> {
        let mut sums = Sums::default();
        for lane in 0..LANES {
            let (load, base) = (f64::from(contact.load[lane]), f64::from(contact.base[lane]));
            if load <= 0.0 {
                continue;
            }
            // The contact of the full model measures its own penetration from the radius.
            let radius = self.touching + self.towards * f64::from(penetration[lane]);
            let motion = RelativeMotion {
                axial: 0.0,
                radius,
                velocity: [0.0, 0.0, self.raceway_speed * radius - base],
                spin: [self.spin + f64::from(spin[lane]), 0.0, 0.0],
                raceway_speed: self.raceway_speed,
                orbit_speed: orbit[lane].into(),
                azimuth: 0.0,
            };
            sums.put(lane, self.one(&motion, load));
        }
        sums
    }

    /// Force and moment over the load by the contact of the full model: the rate of penetration is set so that the contact
    /// carries just that load.
    fn one(&self, motion: &RelativeMotion, load: f64) -> Sums {
        let at = |spin: f64| {
            let mut motion = RelativeMotion { spin: [spin, 0.0, 0.0], ..*motion };
            let elastic = self.contact.elastic_load(self.contact.penetration::<true>(0.0, motion.radius).0).0;
            let rate = if self.chi > 0.0 && elastic > 0.0 { (load / elastic - 1.0) / self.chi } else { 0.0 };
            motion.velocity[1] = self.towards * rate;
            let seen = self.contact.load::<true>(&motion);
            let share = if seen.normal > 0.0 { 1.0 / seen.normal } else { 0.0 };
            (seen.force[2] * share, self.towards * seen.moment[0] * share, seen.slip.0)
        };
        let spin = motion.spin[0];
        let (force, moment, slip) = at(spin);
        let (force_there, _, slip_there) = at(spin + SLIP_STEP / self.ball_radius);
        let change = slip_there - slip;
        let slope = if change.abs() > 0.0 { larger((force_there - force) / change, 0.0) } else { 0.0 };
        Sums { force: force as f32, moment: moment as f32, slope: slope as f32, slip: slip as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::traction::four_parameters;

    /// The short form is the law, to 4e-5 of its value at rest, and says where it ends.
    #[test]
    fn the_short_form_is_the_law_up_to_its_reach() {
        for (maximum, at_slip, limit) in [(0.05, 1.0, 0.036), (0.06, 0.2, 0.04), (0.0501, 3.0, 0.05), (0.1, 1.0, 0.0)] {
            let law = four_parameters(0.0, maximum, at_slip, limit);
            let traction = RisingTraction::new(law, true, 1.2e-3, 1.6e-3);
            let slip =
                |base: f32| Contact { load: 1.0, axis_square: 4e-8, base, per_height: 0.01 * at_slip as f32 / 1.2e-3 };
            let mut ends = false;
            for k in -250..=250 {
                let contact = slip(0.01 * k as f32 * traction.short.reach);
                let (found, beyond) = traction.short.fitted(&contact);
                if beyond > 0.0 {
                    ends |= k > 90;
                    continue;
                }
                let exact = |u: f32| over_speed(&law, law.c * f64::from(u), (-law.c * f64::from(u)).exp()) as f32;
                let (sums, fastest) = traction.short.sums_by(&contact, exact);
                assert!(fastest <= traction.short.reach);
                assert!((found.force - sums.force).abs() < 4e-5 * traction.short.steepest * fastest, "{maximum} {k}");
            }
            assert!(ends, "{maximum}");
        }
    }
}
