//! Two Hertz contacts in series under a centrifugal load, in closed form: a polynomial in place of a root.
//!
//! A ball between raceways whose penetrations add up to the approach D, δ_i + δ_e = D, is in equilibrium where
//! K_e δ_e^1.5 = K_i δ_i^1.5 + F. Without inner contact δ_e is δ₀ = (F/K_e)^⅔; inner contact begins at D = δ₀. With
//! u = √(D − δ₀) and t = u/(u + c √δ₀) the ratio √δ_i/u is a smooth function of t alone on [0, 1], from 1 at touch to that
//! of plain Hertz contacts in series, whatever F: it depends on K_i/K_e only. It is fitted by a polynomial once a scene.

use crate::numerics::roots::bracketed_root;

/// Degree of the fit.
pub const DEGREE: usize = 15;
/// The constant c of t: where the two ends of the law meet.
const MIDDLE: f64 = 1.1;

/// √δ_i of two contacts in series.
#[derive(Debug, Clone)]
pub struct ContactLaw {
    /// In powers of 2t − 1.
    pub coefficients: [f64; DEGREE + 1],
}

impl ContactLaw {
    /// For K_i/K_e.
    pub fn new(ratio: f64) -> Self {
        let share = |t: f64| {
            let w = MIDDLE * t / (1.0 - t);
            exact_root(ratio, w) / w
        };
        Self { coefficients: chebyshev_fit(share) }
    }

    /// √δ_i from u = √(D − δ₀) and √δ₀.
    #[inline(always)]
    pub fn inner_root(&self, u: f64, unloaded_root: f64) -> f64 {
        let sum = u + MIDDLE * unloaded_root;
        let x = 2.0 * (u / (sum + f64::MIN_POSITIVE)) - 1.0;
        u * polynomial(&self.coefficients, x)
    }
}

/// √(δ_i/δ₀) at w = √(D/δ₀ − 1): solves w² = γ² + (1 + K_i/K_e γ³)^⅔ − 1.
pub fn exact_root(ratio: f64, w: f64) -> f64 {
    let excess = |gamma: f64| {
        let q = ratio * gamma * gamma * gamma;
        // (1 + q)^⅔ − 1 without cancellation.
        gamma * gamma + (2.0 / 3.0 * q.ln_1p()).exp_m1() - w * w
    };
    if w == 0.0 { 0.0 } else { bracketed_root(excess, 0.0, w) }
}

/// Coefficients in powers of x = 2t − 1 of the interpolant of `f(t)` at Chebyshev's points.
pub fn chebyshev_fit<const N: usize>(f: impl Fn(f64) -> f64) -> [f64; N] {
    let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / N as f64;
    let values: [f64; N] = std::array::from_fn(|j| f(0.5 + 0.5 * angle(j).cos()));
    let mut powers = [0.0; N];
    // T_k by its recurrence, in powers.
    let (mut before, mut now) = ([0.0; N], [0.0; N]);
    now[0] = 1.0;
    for k in 0..N {
        let sum: f64 = (0..N).map(|j| values[j] * (k as f64 * angle(j)).cos()).sum();
        let weight = sum * if k == 0 { 1.0 } else { 2.0 } / N as f64;
        for i in 0..N {
            powers[i] += weight * now[i];
        }
        let mut next = [0.0; N];
        for i in 0..N {
            let shifted = if i > 0 { now[i - 1] } else { 0.0 };
            next[i] = if k == 0 { shifted } else { 2.0 * shifted - before[i] };
        }
        (before, now) = (now, next);
    }
    powers
}

/// Σ c_k x^k, even and odd powers apart so that little waits for little.
#[inline(always)]
pub fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    let square = x * x;
    let (mut even, mut odd) = (0.0, 0.0);
    for pair in (0..N.div_ceil(2)).rev() {
        even = f64::mul_add(even, square, c[2 * pair]);
        if 2 * pair + 1 < N {
            odd = f64::mul_add(odd, square, c[2 * pair + 1]);
        }
    }
    odd.mul_add(x, even)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The load is that of the exact root to 1e-6 of itself over fourteen decades of approach, for raceways of like and
    /// of unlike stiffness.
    #[test]
    fn fit_is_the_exact_law() {
        for ratio in [0.3, 0.8, 0.94, 1.0, 1.2, 3.0] {
            let law = ContactLaw::new(ratio);
            let mut worst = 0.0_f64;
            for step in -700..=700 {
                let w = 10f64.powf(f64::from(step) * 0.01);
                let exact = exact_root(ratio, w);
                let load_error = (law.inner_root(w, 1.0) / exact).powi(3) - 1.0;
                worst = worst.max(load_error.abs());
                // Scale of the centrifugal load does not matter.
                let scaled = law.inner_root(1e-3 * w, 1e-3);
                assert!((scaled / (1e-3 * law.inner_root(w, 1.0)) - 1.0).abs() < 1e-12);
            }
            println!("K_i/K_e {ratio}: {worst:.1e}");
            assert!(worst < 1e-6, "{ratio}: {worst:e}");
        }
    }

    /// Without centrifugal load the contacts are plain Hertz contacts in series; without approach there is no load.
    #[test]
    fn ends_of_the_law() {
        let (inner, outer) = (1.399e10_f64, 1.492e10_f64);
        let law = ContactLaw::new(inner / outer);
        let approach = 4e-6_f64;
        let root = law.inner_root(approach.sqrt(), 0.0);
        let series = crate::physics::contact::hertz::series_stiffness(inner, outer) * approach.powf(1.5);
        assert!((inner * root.powi(3) / series - 1.0).abs() < 1e-6);
        assert_eq!(law.inner_root(0.0, 0.0), 0.0);
        assert_eq!(law.inner_root(0.0, 1e-3), 0.0);
    }
}
