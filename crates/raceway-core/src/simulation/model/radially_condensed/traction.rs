//! Traction of one raceway in the plane. A four-parameter law that vanishes at rest is integrated by quadrature over a narrow contact and
//! in strips over a wide one. Every other law uses the contact of the full model.

use super::contact::Contact;
use crate::numerics::exponential::binary_saturation_single;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Singles, alike, larger, side_by_side, smaller};
use crate::physics::contact::strips::Strips;
use crate::physics::contact::traction::FourParameters;
use crate::physics::raceway::{LARGEST_CONTACT, RacewayContact, RacewayLoad, RacewayTerms, RelativeMotion};
use crate::simulation::model::condensed_contact::chebyshev;

/// Terms of the series of √(1 − x) after the first.
const SERIES: [f64; 4] = [-0.5, -0.125, -0.0625, -5.0 / 128.0];
/// Terms of that series for heights across the contact.
const ACROSS: usize = 3;
/// Largest (a / ball radius)² for which the error of the series is below 3e-5 of the radius.
pub(super) const WIDEST: f64 = 0.25;
/// Slip up to which μ/u is a polynomial, in units of 1/C of the law.
const REACH: f64 = 2.0;
/// Terms of that polynomial: its error is 4e-5 of the value at rest.
const TERMS: usize = 6;
/// Smallest slip [m/s], which keeps a quotient finite.
const TINY: f32 = 1e-30;
/// Points of the quadrature on one side of the contact.
const POINTS: usize = 3;
/// Places t = η/a and weights of ∫ ¾ (1 − t²) g(t²) dt over −1 … 1, exact for g up to degree 5. It is a Gauss–Jacobi rule: its places are
/// the inner ones of Lobatto's rule with eight points (Abramowitz & Stegun, table 25.6).
const PLACES: [f64; POINTS] = [0.209_299_217_902_479, 0.591_700_181_433_142, 0.871_740_148_509_607];
const LOBATTO: [f64; POINTS] = [0.412_458_794_658_704, 0.341_122_692_483_504, 0.210_704_227_143_506];
/// Strips of the full model on one side of a contact, the middle one included.
const WIDE_POINTS: usize = 9;

/// Integrals over one contact, divided by its load.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums<T = f32> {
    /// Force of the raceway on the ball along the groove.
    pub force: T,
    /// Moment of that force: force times height over the ball's centre [m].
    pub moment: T,
    /// Slope of the force over slip [s/m], not negative.
    pub slope: T,
    /// Slip at the middle of the contact [m/s].
    pub slip: T,
}
side_by_side!(Sums { force, moment, slope, slip });

/// Traction of one raceway with its constants.
#[derive(Debug, Clone)]
pub(super) enum RacewayTraction {
    /// The four-parameter law that vanishes at rest, no hydrodynamic terms, narrow contacts.
    Rising(Box<RisingTraction>),
    /// The same law in wide contacts.
    Wide(Box<WideTraction>),
    /// Every other law or contact, by the contact of the full model.
    General,
}

#[derive(Debug, Clone)]
pub(super) struct RisingTraction {
    law: SingleLaw,
    short: ShortForm,
    /// Copies for eight balls side by side.
    pub all: ShortForm<Singles>,
}

/// The law itself in the strips of the full model. Slip reverses within a wide contact, where quadratures of few points differ from each
/// other.
#[derive(Debug, Clone, Copy)]
pub(super) struct WideTraction {
    law: SingleLaw,
    /// Slope of the law at rest [s/m].
    steepest: f64,
    /// Weight of a strip with its mirror image, and t² at its height on the surface.
    strips: [(f32, f32); WIDE_POINTS],
    ball_radius: f32,
    deformed_radius: f32,
}

/// The fitted law, integrated over the contact.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ShortForm<T = f32> {
    /// Slope of the law at rest, B + C D [s/m].
    steepest: T,
    /// μ/u by powers of u, up to u = reach.
    fit: [T; TERMS],
    reach: T,
    weights: [T; POINTS],
    /// Height of the middle of the contact over the ball's centre, less its radius, by powers of a².
    middle: [T; SERIES.len()],
    /// Height of each point over the middle, by powers of a².
    rise: [[T; ACROSS]; POINTS],
    ball_radius: T,
}
side_by_side!(ShortForm { steepest, fit, reach, weights, middle, rise, ball_radius });

impl RacewayTraction {
    /// dμ/du at rest [s/m]; 0 for the general law, where it is unknown.
    pub(crate) fn steepest(&self) -> f64 {
        match self {
            Self::Rising(traction) => traction.short.steepest.into(),
            Self::Wide(traction) => traction.steepest,
            Self::General => 0.0,
        }
    }
}

impl RisingTraction {
    /// Traction of a narrow contact; `conformity`: whether slip varies across it.
    pub(super) fn new(law: FourParameters, conformity: bool, ball_radius: f64, deformed_radius: f64) -> Self {
        let reach = REACH / law.c;
        // h = r_b + Σ c_j s^j [r_b^(1−2j) − R_d^(1−2j) (1 − t^2j)], s = a².
        let shape = |radius: f64, term: usize| SERIES[term] * radius.powi(-1 - 2 * term as i32);
        let across = if conformity { 1.0 } else { 0.0 };
        let scaled: [f64; TERMS] = chebyshev(|t| over_speed(&law, t * REACH, (-t * REACH).exp()));
        let short = ShortForm {
            steepest: steepest(&law) as f32,
            fit: powers_of_the_argument(scaled, reach).map(|power| power as f32),
            reach: reach as f32,
            weights: std::array::from_fn(|k| (1.5 * LOBATTO[k] * (1.0 - PLACES[k] * PLACES[k])) as f32),
            middle: std::array::from_fn(|j| (shape(ball_radius, j) - shape(deformed_radius, j)) as f32),
            rise: PLACES.map(|t| {
                std::array::from_fn(|j| (across * shape(deformed_radius, j) * t.powi(2 * j as i32 + 2)) as f32)
            }),
            ball_radius: ball_radius as f32,
        };
        Self { law: SingleLaw::new(&law), short, all: alike(short) }
    }

    #[inline(always)]
    pub(super) fn sums(&self, contact: &Contact<Singles>) -> Sums<Singles> {
        let mut sums = Sums::<Singles>::default();
        let mut beyond: Singles = Singles::default();
        for lane in 0..LANES {
            let (one, over) = self.all.at(lane).fitted(&contact.at(lane));
            sums.put(lane, one);
            beyond[lane] = over;
        }
        if beyond.any(|over| over > 0.0) {
            let (short, law) = (self.short, self.law);
            for lane in 0..LANES {
                sums.put(lane, short.sums_by(&contact.at(lane), |speed| law.over_speed(speed)).0);
            }
        }
        sums
    }
}

impl WideTraction {
    /// Traction of a wide contact; `None` where neither conformity nor spin acts.
    pub(super) fn new(
        law: FourParameters,
        needs: &RacewayTerms,
        ball_radius: f64,
        deformed_radius: f64,
    ) -> Option<Self> {
        let strips = Strips::new(2 * WIDE_POINTS - 1);
        let half = strips.as_slice().get(..WIDE_POINTS).filter(|_| needs.strips > 1)?;
        let conformity = if needs.conformity { 1.0 } else { 0.0 };
        let folded = std::array::from_fn(|k| {
            let (strip, images) = (half[k], if k + 1 == WIDE_POINTS { 1.0 } else { 2.0 });
            ((images * strip.weight) as f32, (conformity * strip.position * strip.position) as f32)
        });
        Some(Self {
            law: SingleLaw::new(&law),
            steepest: steepest(&law),
            strips: folded,
            ball_radius: ball_radius as f32,
            deformed_radius: deformed_radius as f32,
        })
    }

    #[inline(always)]
    pub(super) fn sums(&self, contact: &Contact<Singles>) -> Sums<Singles> {
        let wide = *self;
        let mut sums = Sums::<Singles>::default();
        for lane in 0..LANES {
            sums.put(lane, wide.sums_of(&contact.at(lane)));
        }
        sums
    }

    #[inline(always)]
    fn sums_of(&self, contact: &Contact) -> Sums {
        let (ball, deformed) = (self.ball_radius, self.deformed_radius);
        let largest = LARGEST_CONTACT as f32 * ball;
        let square = smaller(contact.axis_square, largest * largest);
        // Drop of a circle from its top.
        let fall = |radius: f32, square: f32| square / (radius + (radius * radius - square).sqrt());
        let middle = ball + fall(deformed, square) - fall(ball, square);
        let points = self.strips.map(|(weight, place)| (weight, -fall(deformed, place * square)));
        sums_over(contact, middle, points, |speed| self.law.over_speed(speed)).0
    }
}

impl ShortForm {
    /// The sums by the fit, and the excess of the slip over its range under load [m/s].
    #[inline(always)]
    pub(super) fn fitted(&self, contact: &Contact) -> (Sums, f32) {
        let (one, fastest) = self.sums_by(contact, |speed| polynomial(&self.fit, smaller(speed, self.reach)));
        // dμ/du = μ/u + u (μ/u)', the latter as a straight line: an error of a few per cent is small enough for the slope.
        let slope = larger(2.0 * one.slope - self.steepest, 0.0);
        (Sums { slope, ..one }, if contact.load > 0.0 { fastest - self.reach } else { 0.0 })
    }

    /// The sums of [`sums_over`].
    #[inline(always)]
    fn sums_by(&self, contact: &Contact, over_speed: impl Fn(f32) -> f32) -> (Sums, f32) {
        let s = contact.axis_square;
        let [m0, m1, m2, m3] = self.middle;
        let middle = self.ball_radius + s * ((m0 + s * m1) + s * s * (m2 + s * m3));
        let at = |k: usize| {
            let [r0, r1, r2] = self.rise[k];
            (self.weights[k], s * (r0 + s * (r1 + s * r2)))
        };
        sums_over::<POINTS>(contact, middle, std::array::from_fn(at), over_speed)
    }
}

/// The sums and the fastest slip. The mean of μ/u, never less than the slope, replaces the slope. `middle`: height of the contact's middle
/// over the ball's centre; `points`: weights, and heights over the middle; `over_speed`: μ(u)/u.
#[inline(always)]
fn sums_over<const P: usize>(
    contact: &Contact,
    middle: f32,
    points: [(f32, f32); P],
    over_speed: impl Fn(f32) -> f32,
) -> (Sums, f32) {
    let slip = contact.base + middle * contact.per_height;
    let (mut force, mut risen, mut mean, mut fastest) = (0.0, 0.0, 0.0, 0.0);
    for (weight, rise) in points {
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

/// Coefficients by powers of u, from those by powers of x = 2u/reach − 1.
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

/// dμ/du at rest [s/m].
fn steepest(law: &FourParameters) -> f64 {
    law.d * law.c + law.b
}

/// The four-parameter law with A = −D, in single precision.
#[derive(Debug, Clone, Copy)]
struct SingleLaw {
    b: f32,
    d: f32,
    /// C over ln 2.
    binary: f32,
}

impl SingleLaw {
    fn new(law: &FourParameters) -> Self {
        Self { b: law.b as f32, d: law.d as f32, binary: (law.c * std::f64::consts::LOG2_E) as f32 }
    }

    /// μ/u = D (1 − e^(−C u))/u + B e^(−C u).
    #[inline(always)]
    fn over_speed(&self, speed: f32) -> f32 {
        // The smallest slip replaces a slip of 0.
        let speed = speed + TINY;
        let (saturation, decay) = binary_saturation_single(self.binary * speed);
        self.d * (saturation / speed) + self.b * decay
    }
}

/// μ/u of the four-parameter law with A = −D at x = C u, D C (1 − e^−x)/x + B e^−x.
#[inline(always)]
fn over_speed(law: &FourParameters, x: f64, decay: f64) -> f64 {
    let near = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)));
    let far = (1.0 - decay) / (x + f64::MIN_POSITIVE);
    law.d * law.c * if x < 0.01 { near } else { far } + law.b * decay
}

/// A raceway of the full model with its motion.
pub(super) struct General<'a> {
    pub contact: &'a RacewayContact,
    /// Radial direction from the ball towards the raceway: 1 for the outer, −1 for the inner one.
    pub towards: f64,
    /// Angular speed of the raceway [rad/s].
    pub raceway_speed: f64,
    /// Spin of an ideally rolling ball [rad/s].
    pub spin: f64,
    /// Orbit radius of a ball that touches without load [m].
    pub touching: f64,
    pub chi: f64,
    pub instructions: InstructionSet,
}

impl General<'_> {
    /// Force and moment over the loads, by the contact of the full model. Rates of penetration are chosen so that contacts carry exactly
    /// these loads. `spin`: deviations from ideal rolling; `penetration`: of this contact.
    #[inline(never)]
    pub(super) fn sums(
        &self,
        contact: &Contact<Singles>,
        spin: &Singles,
        penetration: &Singles,
        orbit: &Singles,
    ) -> Sums<Singles> {
        let mut motion = RelativeMotion::<Lanes>::default();
        for lane in 0..LANES {
            // The contact of the full model measures its own penetration from the radius.
            let radius = self.touching + self.towards * f64::from(penetration[lane]);
            let elastic = self.contact.elastic_load(self.contact.penetration::<true>(0.0, radius).0).0;
            let load = f64::from(contact.load[lane]);
            let rate = if self.chi > 0.0 && elastic > 0.0 { (load / elastic - 1.0) / self.chi } else { 0.0 };
            let along = self.raceway_speed * radius - f64::from(contact.base[lane]);
            let one = RelativeMotion {
                axial: 0.0,
                radius,
                velocity: [0.0, self.towards * rate, along],
                spin: [self.spin + f64::from(spin[lane]), 0.0, 0.0],
                raceway_speed: self.raceway_speed,
                orbit_speed: orbit[lane].into(),
                azimuth: 0.0,
                // The slip of `contact` contains the size of the ball.
            };
            motion.put(lane, one);
        }
        let mut load = RacewayLoad::<Lanes>::default();
        self.contact.loads::<true>(&motion, None, &mut load, self.instructions);
        let towards = self.towards;
        let mut sums = Sums::<Singles>::default();
        for lane in 0..LANES {
            let load = load.at(lane);
            let share = if load.normal > 0.0 { 1.0 / load.normal } else { 0.0 };
            let one = Sums {
                force: (share * load.force[2]) as f32,
                moment: (share * towards * load.moment[0]) as f32,
                // The mean of μ/u, never less than the slope.
                slope: (share * load.grip) as f32,
                slip: load.slip.0 as f32,
            };
            sums.put(lane, one);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::traction::four_parameters;

    /// The short form equals the law to 4e-5 of its value at rest, and indicates the end of its range.
    #[test]
    fn the_short_form_equals_the_law_up_to_its_reach() {
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
