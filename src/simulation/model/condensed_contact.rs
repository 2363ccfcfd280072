//! A ball between both raceways in radial equilibrium, as one contact: load over the total approach of the raceways at
//! a fixed centrifugal force. The ball's radial motion (some 160 kHz) follows the spindle's at once; what its inertia
//! adds is of second order and stands in `outer_share`.

use std::f64::consts::PI;

use crate::numerics::lanes::larger;
use crate::numerics::roots::bracketed_root;
use crate::physics::bearing::PerRaceway;
use crate::physics::raceway::RacewayContact;

/// Terms of the polynomial of the load, and of those of what only corrects it.
const LOAD_TERMS: usize = 15;
const SHARE_TERMS: usize = 8;
/// Outer penetration under the least centrifugal force that is told from none [m]: a nanonewton.
const LEAST_TOUCH: f64 = 1e-13;

/// The fit: u = √(approach − δ_e0), t = u/(u + u_c), Q = u³ P(2t − 1), δ_e0 the outer penetration under the centrifugal
/// force alone. Everything is smooth in t over the whole range 0 … 1 (approach from touch to infinity).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CondensedContact {
    /// δ_e0: approach at which the inner raceway touches [m].
    touch: f64,
    /// u_c [√m].
    scale: f64,
    /// P [N/m^1.5], by rising powers of 2t − 1.
    load: [f64; LOAD_TERMS],
    /// Outer share of an approach over t [-].
    share: [f64; SHARE_TERMS],
    /// a_i² Q_i + a_e² Q_e over u² (u + u_c) [N/m^1.5].
    damped: [f64; SHARE_TERMS],
}

/// What the pair of contacts does at an approach; all 0 where the inner raceway is free, but for its share, which is 1 then.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CondensedLoad {
    /// Approach beyond that at which the inner raceway touches [m].
    pub pressed: f64,
    /// Load of the inner raceway Q_i [N].
    pub load: f64,
    /// dQ_i/d(approach) = k_i k_e/(k_i + k_e) [N/m].
    pub stiffness: f64,
    /// Share of an approach that the inner contact takes, a_i = k_e/(k_i + k_e) [-].
    pub inner_share: f64,
    /// Share that the outer contact takes, a_e = 1 − a_i: how far the ball goes with the inner raceway [-].
    pub outer_share: f64,
    /// ½ d(a_e²)/d(approach) [1/m].
    pub outer_share_slope: f64,
    /// a_i² Q_i + a_e² Q_e [N]: times χ and the rate of approach it is the damping force of two contacts Q (1 + χ δ̇) in
    /// series, whose power is that of both.
    pub damped_load: f64,
}

/// The exact solution at one approach.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Exact {
    load: PerRaceway<f64>,
    stiffness: PerRaceway<f64>,
}

impl Exact {
    fn outer_share(&self) -> f64 {
        let PerRaceway { inner, outer } = self.stiffness;
        inner / (inner + outer)
    }
}

/// Both contacts, and the centrifugal force over the outer penetration [N, N/m].
struct Pair<'a> {
    raceway: &'a PerRaceway<RacewayContact>,
    centrifugal: f64,
    slope: f64,
}

impl Pair<'_> {
    /// δ_e0 [m].
    fn touch(&self) -> f64 {
        let stiffness = self.raceway.outer.hertz().stiffness;
        // Further turns take in that the orbit grows with the penetration, some 1e-4 to 1e-3 of it, to rounding.
        (0..8).fold(0.0, |touch: f64, _| ((self.centrifugal + self.slope * touch) / stiffness).powf(2.0 / 3.0))
    }

    /// `beyond`: approach − δ_e0 [m], positive.
    fn exact(&self, touch: f64, beyond: f64) -> Exact {
        let excess = |inner: f64| {
            let outer = touch + (beyond - inner);
            let force = self.raceway.outer.elastic_load(outer).0 - self.raceway.inner.elastic_load(inner).0;
            force - self.centrifugal - self.slope * outer
        };
        let inner = bracketed_root(excess, 0.0, beyond);
        let at = PerRaceway {
            inner: self.raceway.inner.elastic_load(inner),
            outer: self.raceway.outer.elastic_load(touch + (beyond - inner)),
        };
        Exact { load: at.map(|at| at.0), stiffness: at.map(|at| at.1) }
    }
}

impl CondensedContact {
    /// Fits the contacts of a ball [kg] that orbits at a speed [rad/s] on a radius [m] (that of a ball which touches the
    /// outer raceway without load).
    pub fn new(raceway: &PerRaceway<RacewayContact>, ball_mass: f64, orbit_radius: f64, orbit_speed: f64) -> Self {
        let slope = ball_mass * orbit_speed * orbit_speed;
        let least = raceway.outer.elastic_load(LEAST_TOUCH).0;
        let pair = Pair { raceway, centrifugal: (slope * orbit_radius).max(least), slope };
        let touch = pair.touch();
        let scale = touch.sqrt();
        let at = |x: f64| {
            let t = 0.5 * (1.0 + x);
            let u = scale * t / (1.0 - t);
            (t, u, pair.exact(touch, u * u))
        };
        let share = |x: f64| {
            let (t, _, exact) = at(x);
            exact.outer_share() / t
        };
        let damped = |x: f64| {
            let (_, u, exact) = at(x);
            let outer = exact.outer_share();
            let sum = (1.0 - outer).powi(2) * exact.load.inner + outer * outer * exact.load.outer;
            sum / (u * u * (u + scale))
        };
        let load = |x: f64| {
            let (_, u, exact) = at(x);
            exact.load.inner / (u * u * u)
        };
        Self { touch, scale, load: fit(load), share: fit(share), damped: fit(damped) }
    }

    /// The pair of contacts at an approach [m] (inner and outer penetration together; negative where there is play). No
    /// branch, so that a loop over balls has none.
    #[inline(always)]
    pub fn load(&self, approach: f64) -> CondensedLoad {
        let pressed = larger(approach - self.touch, 0.0);
        let u = pressed.sqrt();
        let per_sum = 1.0 / (u + self.scale);
        let t = u * per_sum;
        let x = t + t - 1.0;
        let (p, p_slope) = polynomial(&self.load, x);
        let (a, a_slope) = polynomial(&self.share, x);
        let (d, _) = polynomial(&self.damped, x);
        let touching = if pressed > 0.0 { 1.0 } else { 0.0 };
        let outer_share = t * a;
        let turning = self.scale * per_sum;
        CondensedLoad {
            pressed,
            load: u * u * u * p,
            // d/d(approach) = 1/(2u) d/du,  dt/du = u_c/(u + u_c)².
            stiffness: u * (1.5 * p + p_slope * t * turning),
            inner_share: 1.0 - outer_share,
            outer_share,
            outer_share_slope: touching * 0.5 * a * per_sum * per_sum * turning * (a + 2.0 * t * a_slope),
            damped_load: u * u * (u + self.scale) * d,
        }
    }

    /// Approach at which the inner raceway touches the ball [m].
    pub fn touch(&self) -> f64 {
        self.touch
    }
}

/// Value and slope, coefficients by rising powers. Four chains in powers of x⁴: Horner's one would have every term wait
/// for the last.
#[inline(always)]
pub(super) fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> (f64, f64) {
    let (square, chains) = (x * x, 4);
    let fourth = square * square;
    let (mut value, mut slope) = ([0.0; 4], [0.0; 4]);
    for k in (0..N.div_ceil(chains)).rev() {
        for (chain, (value, slope)) in value.iter_mut().zip(&mut slope).enumerate() {
            if k * chains + chain < N {
                *slope = *slope * fourth + *value;
                *value = *value * fourth + coefficients[k * chains + chain];
            }
        }
    }
    let [a, b, c, d] = value;
    let [da, db, dc, dd] = slope;
    let sum = (a + b * x) + (c + d * x) * square;
    let in_fourth = (da + db * x) + (dc + dd * x) * square;
    (sum, in_fourth * (4.0 * square * x) + (b + c * (x + x)) + 3.0 * d * square)
}

/// Polynomial through the Chebyshev nodes of −1 … 1, by rising powers.
fn fit<const N: usize>(f: impl Fn(f64) -> f64) -> [f64; N] {
    let angle = |k: usize| PI * (k as f64 + 0.5) / N as f64;
    let values: [f64; N] = std::array::from_fn(|k| f(angle(k).cos()));
    let mut powers = [0.0; N];
    // T_m by rising powers, from T_(m+1) = 2x T_m − T_(m−1).
    let (mut before, mut now) = ([0.0; N], [0.0; N]);
    now[0] = 1.0;
    for m in 0..N {
        let sum: f64 = values.iter().enumerate().map(|(k, value)| value * (m as f64 * angle(k)).cos()).sum();
        let coefficient = if m == 0 { sum / N as f64 } else { 2.0 * sum / N as f64 };
        for (power, t) in powers.iter_mut().zip(&now) {
            *power += coefficient * t;
        }
        let factor = if m == 0 { 1.0 } else { 2.0 };
        let next = std::array::from_fn(|i| if i == 0 { 0.0 } else { factor * now[i - 1] } - before[i]);
        (before, now) = (now, next);
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::damping::DampingFactor;
    use crate::physics::examples::{article_bearing, article_lubricant};
    use crate::physics::raceway::RacewayTerms;

    fn raceways() -> PerRaceway<RacewayContact> {
        let terms = RacewayTerms { strips: 9, conformity: true, spin: false, hydrodynamics: false };
        RacewayContact::pair(&article_bearing(), &article_lubricant(), DampingFactor::default(), terms)
    }

    const ORBIT: f64 = 6.5e-3;

    /// Load to 1e-6, what only corrects to 1e-3 (stiffness without the
    /// centrifugal force's own), from touch to a hundred times the usual approach, at every
    /// orbit speed.
    #[test]
    fn the_fit_repeats_the_exact_solution_over_the_whole_range() {
        let raceway = raceways();
        let mass = article_bearing().ball_mass;
        for speed in [0.0, 1.0, 100.0, 411.0, 2058.0, 6000.0, 20_000.0] {
            let contact = CondensedContact::new(&raceway, mass, ORBIT, speed);
            let slope = mass * speed * speed;
            let least = raceway.outer.elastic_load(LEAST_TOUCH).0;
            let pair = Pair { raceway: &raceway, centrifugal: (slope * ORBIT).max(least), slope };
            let (mut worst, mut worst_slope, mut worst_rest) = (0.0_f64, 0.0_f64, 0.0_f64);
            for k in 0..4000 {
                let beyond = 1e-11 * 1e8_f64.powf(f64::from(k) / 3999.0);
                let exact = pair.exact(contact.touch, beyond);
                let found = contact.load(contact.touch + beyond);
                let PerRaceway { inner, outer } = exact.stiffness;
                let share = exact.outer_share();
                let damped = (1.0 - share).powi(2) * exact.load.inner + share * share * exact.load.outer;
                worst = worst.max((found.load / exact.load.inner - 1.0).abs());
                let stiffness = inner * outer / (inner + outer);
                worst_slope = worst_slope.max((found.stiffness / stiffness - 1.0).abs());
                for (found, exact) in
                    [(found.inner_share, 1.0 - share), (found.outer_share, share), (found.damped_load, damped)]
                {
                    worst_rest = worst_rest.max((found / exact - 1.0).abs());
                }
            }
            assert!(
                worst < 1e-6 && worst_slope < 1e-3 && worst_rest < 1e-3,
                "{speed}: {worst:e} {worst_slope:e} {worst_rest:e}"
            );
        }
    }

    #[test]
    fn slopes_are_those_of_the_values_and_a_free_ball_carries_nothing() {
        let contact = CondensedContact::new(&raceways(), article_bearing().ball_mass, ORBIT, 2058.0);
        for beyond in [1e-8, 1e-7, 1e-6, 1e-5] {
            let at = |off: f64| contact.load(contact.touch + beyond * (1.0 + off));
            let slope = |value: fn(&CondensedLoad) -> f64| (value(&at(1e-5)) - value(&at(-1e-5))) / (2e-5 * beyond);
            assert!((slope(|l| l.load) / at(0.0).stiffness - 1.0).abs() < 1e-7);
            let half_square = slope(|l| 0.5 * l.outer_share * l.outer_share);
            assert!((half_square / at(0.0).outer_share_slope - 1.0).abs() < 1e-6);
        }
        for approach in [-1e-5, 0.0, contact.touch] {
            let free = contact.load(approach);
            assert_eq!((free.load, free.stiffness, free.outer_share, free.damped_load), (0.0, 0.0, 0.0, 0.0));
            assert_eq!((free.inner_share, free.outer_share_slope), (1.0, 0.0));
        }
    }
}
