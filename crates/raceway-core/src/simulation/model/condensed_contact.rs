//! A ball between both raceways in radial equilibrium, as one contact. The ball's radial motion (some 160 kHz) follows the
//! approach of the raceways at once. The effect of its inertia is of second order, and `outer_share` gives it.
//!
//! The penetrations add up to the approach D: δ_i + δ_e = D. Under a centrifugal force F the loads obey K_e δ_e^1.5 = K_i δ_i^1.5 + F.
//! Without inner contact δ_e is δ₀ = (F/K_e)^⅔; inner contact begins at D = δ₀. Let u = √(D − δ₀) and t = u/(u + c √δ₀). Then √δ_i/u
//! and the outer contact's share of the approach over t are smooth functions of t alone on 0 … 1, from touch to plain Hertz contacts
//! in series. They depend on K_i/K_e only, not on F. Polynomials approximate them, once a scene.

use std::f64::consts::PI;

use crate::numerics::lanes::{Real, larger, side_by_side};
use crate::numerics::roots::bracketed_root;
use crate::physics::bearing::PerRaceway;

/// Terms of the polynomial of √δ_i.
const ROOT_TERMS: usize = 15;
/// Terms of the polynomial of the share, which enters small corrections only.
const SHARE_TERMS: usize = 8;
/// Largest relative error of the load from the polynomials [-]; tested.
pub(crate) const LOAD_ERROR: f64 = 2e-6;
/// The constant c of t: where the two ends of the law meet.
const MIDDLE: f64 = 1.1;
/// Smallest outer penetration under a centrifugal force [m], that of a nanonewton; keeps quotients finite.
const MIN_TOUCH: f64 = 1e-13;

/// The polynomials.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct CondensedContact<T = f64> {
    /// K [N/m^1.5], and 1/K of the outer contact.
    stiffness: PerRaceway<T>,
    per_outer: T,
    /// √δ_i/u, by rising powers of 2t − 1.
    root: [T; ROOT_TERMS],
    /// Outer share of an approach over t.
    share: [T; SHARE_TERMS],
}
side_by_side!(CondensedContact { stiffness, per_outer, root, share });

/// The outer contact under the centrifugal force alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unloaded<T = f64> {
    /// F [N].
    pub force: T,
    /// δ₀ [m], the approach at which the inner raceway touches, and its root.
    pub penetration: T,
    pub root: T,
}

/// State of the pair of contacts at an approach. Without inner contact all entries are 0, except the outer penetration and the inner
/// share of 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CondensedLoad<T = f64> {
    /// Approach beyond that at which the inner raceway touches [m].
    pub pressed: T,
    /// Penetrations [m].
    pub inner: T,
    pub outer: T,
    /// Load of the inner raceway Q_i [N].
    pub load: T,
    /// dQ_i/d(approach) = k_i k_e/(k_i + k_e) [N/m].
    pub stiffness: T,
    /// Share of the inner contact in an approach, a_i = k_e/(k_i + k_e) [-].
    pub inner_share: T,
    /// Share of the outer contact, a_e = 1 − a_i, and thus of the ball's motion in that of the inner raceway [-].
    pub outer_share: T,
    /// ½ d(a_e²)/d(approach) [1/m].
    pub outer_share_slope: T,
    /// a_i² Q_i + a_e² Q_e [N]. Times χ and the rate of approach it is the damping force of two contacts Q (1 + χ δ̇) in series; its
    /// power equals that of both.
    pub damped_load: T,
}

/// √(δ_i/δ₀) at w = √(D/δ₀ − 1): solves w² = γ² + (1 + K_i/K_e γ³)^⅔ − 1.
fn exact_root(ratio: f64, w: f64) -> f64 {
    // (1 + q)^⅔ − 1 = c² − 1 with c³ = 1 + q, without cancellation.
    let outer = |gamma: f64| {
        let q = ratio * gamma * gamma * gamma;
        let c = (1.0 + q).cbrt();
        q * (c + 1.0) / (c * c + c + 1.0)
    };
    bracketed_root(|gamma| gamma * gamma + outer(gamma) - w * w, 0.0, w)
}

/// a_e at √(δ_i/δ₀).
fn exact_share(ratio: f64, gamma: f64) -> f64 {
    let (inner, outer) = (ratio * gamma, (1.0 + ratio * gamma * gamma * gamma).cbrt());
    inner / (inner + outer)
}

impl CondensedContact {
    /// Contact pair of Hertz contacts of stiffness K [N/m^1.5].
    pub(crate) fn new(stiffness: PerRaceway<f64>) -> Self {
        let ratio = stiffness.inner / stiffness.outer;
        let w = |t: f64| MIDDLE * t / (1.0 - t);
        Self {
            stiffness,
            per_outer: 1.0 / stiffness.outer,
            root: chebyshev(|t| exact_root(ratio, w(t)) / w(t)),
            share: chebyshev(|t| exact_share(ratio, exact_root(ratio, w(t))) / t),
        }
    }

    /// The outer contact of a ball [kg] that orbits at a speed [rad/s] on a radius [m], that of a ball which touches the outer
    /// raceway without load. `weight`: further outward force [N].
    pub(crate) fn unloaded(&self, mass: f64, radius: f64, orbit_speed: f64, weight: f64) -> Unloaded {
        let outer = self.stiffness.outer;
        let force = |penetration: f64| mass * orbit_speed * orbit_speed * (radius + penetration) + weight;
        // Iterations include the growth of the orbit with the penetration, some 1e-4 to 1e-3 of it, to rounding.
        let penetration = (0..8).fold(0.0, |touch: f64, _| (force(touch) / outer).cbrt().powi(2)).max(MIN_TOUCH);
        let root = penetration.sqrt();
        Unloaded { force: outer * penetration * root, penetration, root }
    }

    /// The contact pair in single precision.
    pub(crate) fn single(&self) -> CondensedContact<f32> {
        CondensedContact {
            stiffness: self.stiffness.map(|stiffness| *stiffness as f32),
            per_outer: 1.0 / (self.stiffness.outer as f32),
            root: self.root.map(|coefficient| coefficient as f32),
            share: self.share.map(|coefficient| coefficient as f32),
        }
    }
}

impl<T: Real> CondensedContact<T> {
    /// The outer contact under a force [N] near that of a known root: ∛ by one step of Halley's method. Its relative error is 5e-4 where
    /// the forces agree within a third, and 1e-6 within a thirtieth.
    #[inline(always)]
    pub(crate) fn unloaded_near(&self, root: T, force: T) -> Unloaded<T> {
        let (cube, known) = (force * self.per_outer, root * root * root);
        let root = root * (known + cube + cube) / (known + known + cube);
        Unloaded { force, penetration: root * root, root }
    }

    /// The pair of contacts at an approach [m], the sum of both penetrations, negative with clearance. The code has no branch, so that
    /// a loop over balls has none.
    #[inline(always)]
    pub(crate) fn load(&self, approach: T, free: &Unloaded<T>) -> CondensedLoad<T> {
        let pressed = larger(approach - free.penetration, T::of(0.0));
        let u = pressed.sqrt();
        let (one, half) = (T::of(1.0), T::of(0.5));
        let middle = T::of(MIDDLE) * free.root;
        let per_sum = one / (u + middle);
        let t = u * per_sum;
        // 2t − 1.
        let x = (u - middle) * per_sum;
        let inner_root = u * in_pairs(&self.root, x);
        let (a, a_slope) = polynomial(&self.share, x);
        let inner = inner_root * inner_root;
        let stiffness = self.stiffness.inner * inner_root;
        let load = stiffness * inner;
        let outer_share = t * a;
        let inner_share = one - outer_share;
        // dt/d(approach) = c √δ₀/(u + c √δ₀)²/(2u): with a_e/u = a/(u + c √δ₀) finite at touch.
        let turning = half * middle * (per_sum * per_sum * per_sum);
        let slope = turning * a * (a + (t + t) * a_slope);
        CondensedLoad {
            pressed,
            inner,
            outer: free.penetration + (pressed - inner),
            load,
            stiffness: T::of(1.5) * stiffness * inner_share,
            inner_share,
            outer_share,
            outer_share_slope: if pressed > T::of(0.0) { slope } else { T::of(0.0) },
            damped_load: inner_share * inner_share * load + outer_share * outer_share * (load + free.force),
        }
    }
}

/// Value of a polynomial, coefficients by rising powers, by Estrin's scheme of pairs, because the step waits for it.
#[inline(always)]
fn in_pairs<T: Real>(coefficients: &[T; ROOT_TERMS], x: T) -> T {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = *coefficients;
    let square = x * x;
    let fourth = square * square;
    let low = ((a + b * x) + (c + d * x) * square) + ((e + f * x) + (g + h * x) * square) * fourth;
    let high = ((i + j * x) + (k + l * x) * square) + ((m + n * x) + o * square) * fourth;
    low + high * (fourth * fourth)
}

/// Value and slope, coefficients by rising powers. Four chains in powers of x⁴ shorten the dependency chain of Horner's scheme.
#[inline(always)]
fn polynomial<T: Real, const N: usize>(coefficients: &[T; N], x: T) -> (T, T) {
    let (square, chains) = (x * x, 4);
    let fourth = square * square;
    let (mut value, mut slope) = ([T::of(0.0); 4], [T::of(0.0); 4]);
    for k in (0..N.div_ceil(chains)).rev() {
        for (chain, (value, slope)) in value.iter_mut().zip(&mut slope).enumerate() {
            let at = k * chains + chain;
            if at + chains < N {
                *slope = *slope * fourth + *value;
                *value = *value * fourth + coefficients[at];
            } else if at < N {
                *value = coefficients[at];
            }
        }
    }
    let [a, b, c, d] = value;
    let [da, db, dc, dd] = slope;
    let sum = (a + b * x) + (c + d * x) * square;
    let in_fourth = (da + db * x) + (dc + dd * x) * square;
    (sum, in_fourth * (T::of(4.0) * square * x) + (b + c * (x + x)) + T::of(3.0) * d * square)
}

/// Polynomial through the Chebyshev nodes of 0 < t < 1, by rising powers of 2t − 1.
pub(super) fn chebyshev<const N: usize>(f: impl Fn(f64) -> f64) -> [f64; N] {
    let angle = |k: usize| PI * (k as f64 + 0.5) / N as f64;
    let values: [f64; N] = std::array::from_fn(|k| f(0.5 + 0.5 * angle(k).cos()));
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

    const OUTER: f64 = 1.49e10;
    const BALL: f64 = 8.8e-5;
    const ORBIT: f64 = 6.5e-3;

    fn contact(ratio: f64) -> CondensedContact {
        CondensedContact::new(PerRaceway { inner: ratio * OUTER, outer: OUTER })
    }

    /// Errors: load to `LOAD_ERROR`, corrections to 2e-3. Range: from touch to a hundred times the usual approach, at every orbit speed,
    /// for raceways of equal and of different stiffness.
    #[test]
    fn the_fit_repeats_the_exact_solution_over_the_whole_range() {
        for ratio in [0.3, 0.8, 0.94, 1.0, 1.2, 3.0] {
            let contact = contact(ratio);
            let (mut worst, mut worst_rest) = (0.0_f64, 0.0_f64);
            for speed in [0.0, 1.0, 100.0, 411.0, 2058.0, 6000.0, 20_000.0] {
                let free = contact.unloaded(BALL, ORBIT, speed, 0.0);
                for k in 0..2000 {
                    let beyond = 1e-11 * 1e8_f64.powf(f64::from(k) / 1999.0);
                    let found = contact.load(free.penetration + beyond, &free);
                    let gamma = exact_root(ratio, (found.pressed / free.penetration).sqrt());
                    let load = ratio * OUTER * (free.root * gamma).powi(3);
                    let outer_share = exact_share(ratio, gamma);
                    let inner_share = 1.0 - outer_share;
                    let stiffness = 1.5 * ratio * OUTER * free.root * gamma * inner_share;
                    let damped = inner_share.powi(2) * load + outer_share.powi(2) * (load + free.force);
                    worst = worst.max((found.load / load - 1.0).abs());
                    for (found, exact) in [
                        (found.inner_share, inner_share),
                        (found.outer_share, outer_share),
                        (found.stiffness, stiffness),
                        (found.damped_load, damped),
                    ] {
                        worst_rest = worst_rest.max((found / exact - 1.0).abs());
                    }
                }
            }
            println!("K_i/K_e {ratio}: {worst:.1e} {worst_rest:.1e}");
            assert!(worst < LOAD_ERROR && worst_rest < 2e-3, "{ratio}: {worst:e} {worst_rest:e}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_values_and_a_free_ball_carries_nothing() {
        let contact = contact(0.94);
        let free = contact.unloaded(BALL, ORBIT, 2058.0, 0.0);
        for beyond in [1e-8, 1e-7, 1e-6, 1e-5] {
            let at = |off: f64| contact.load(free.penetration + beyond * (1.0 + off), &free);
            let slope = |value: fn(&CondensedLoad) -> f64| (value(&at(1e-5)) - value(&at(-1e-5))) / (2e-5 * beyond);
            assert!((slope(|l| l.load) / at(0.0).stiffness - 1.0).abs() < 2e-3);
            assert!((slope(|l| l.outer) / at(0.0).outer_share - 1.0).abs() < 2e-3);
            let half_square = slope(|l| 0.5 * l.outer_share * l.outer_share);
            assert!((half_square / at(0.0).outer_share_slope - 1.0).abs() < 1e-6);
        }
        for approach in [-1e-5, 0.0, free.penetration] {
            let load = contact.load(approach, &free);
            assert_eq!((load.load, load.stiffness, load.outer_share, load.damped_load), (0.0, 0.0, 0.0, 0.0));
            assert_eq!((load.inner_share, load.outer_share_slope, load.outer), (1.0, 0.0, free.penetration));
        }
    }

    /// Without centrifugal force the contacts are plain Hertz contacts in series.
    #[test]
    fn contacts_at_rest_are_in_series() {
        let contact = contact(0.94);
        let found = contact.load(4e-6, &contact.unloaded(BALL, ORBIT, 0.0, 0.0)).load;
        let series = crate::physics::contact::hertz::series_stiffness(0.94 * OUTER, OUTER) * 4e-6_f64.powf(1.5);
        assert!((found / series - 1.0).abs() < 1e-6, "{found} {series}");
    }

    /// Halley's step from a known root gives the cube root of a nearby force.
    #[test]
    fn nearby_forces_have_nearby_roots() {
        let contact = contact(0.94);
        let known = contact.unloaded(BALL, ORBIT, 2058.0, 0.0);
        for (factor, tolerance) in [(1.0 / 1.3, 5e-4), (0.97, 1e-6), (1.0, 1e-15), (1.03, 1e-6), (1.3, 5e-4)] {
            let exact = (factor * known.force / OUTER).cbrt();
            let found = contact.unloaded_near(known.root, factor * known.force).root;
            assert!((found / exact - 1.0).abs() < tolerance, "{factor}: {:e}", found / exact - 1.0);
        }
    }
}
