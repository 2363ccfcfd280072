//! Elastic contact of ball and raceway: Hertz, exact, with complete elliptic integrals.
//!
//! The common power-law fits of the ellipticity are 1–6 % off at the curvature ratios of deep grooves.

use std::f64::consts::PI;

use crate::numerics::elliptic::integrals_from_complement;
use crate::physics::bearing::{Bearing, PerRaceway};
use crate::physics::material::contact_modulus;

/// Shape of a contact ellipse; its size follows from the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEllipse {
    /// k = a/b ≥ 1, major over minor semi-axis.
    pub ellipticity: f64,
    /// 𝓕, complete elliptic integral of the first kind at m = 1 − 1/k².
    pub first: f64,
    /// 𝓔, of the second kind.
    pub second: f64,
    /// Σρ, sum of principal curvatures [1/m].
    pub curvature_sum: f64,
}

impl ContactEllipse {
    /// From the curvature sums [1/m] in the plane of rolling (the larger) and across it.
    ///
    /// Solves [(k²+1)𝓔 − 2𝓕] / [(k²−1)𝓔] = F(ρ) = (ρ_x − ρ_y)/Σρ by bisection in ln k; the left side rises
    /// from 0 (circle) to 1. Harris & Kotzalas, *Rolling Bearing Analysis*, eq. (6.28).
    pub fn new(rolling: f64, across: f64) -> Self {
        let difference = (rolling - across) / (rolling + across);
        let (mut low, mut high) = (0.0, 18.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if curvature_difference(f64::exp(middle)) < difference { low = middle } else { high = middle }
        }
        let ellipticity = f64::exp(0.5 * (low + high));
        let (first, second) = integrals_from_complement(ellipticity.powi(-2));
        Self { ellipticity, first, second, curvature_sum: rolling + across }
    }
}

/// F(ρ) of an ellipticity.
fn curvature_difference(k: f64) -> f64 {
    // 1 − F = 2(𝓕 − 𝓔) / ((k² − 1) 𝓔) keeps its digits for slender ellipses; near the circle m/2·… → 0.
    let (first, second) = integrals_from_complement(k.powi(-2));
    let excess = k * k - 1.0;
    if excess < 1e-7 {
        // Expansion: F ≈ 3/8 (k² − 1).
        return 0.375 * excess;
    }
    1.0 - 2.0 * (first - second) / (excess * second)
}

/// Load–deflection factor `K` in `Q = K δ^1.5` [N/m^1.5] for an effective modulus E' = 2E* [Pa].
///
/// Hamrock & Dowson, eq. (3.24): K = π k E' √(𝓔 R / (4.5 𝓕³)), R = 1/Σρ. Elastic, dry, small contact.
pub fn load_deflection_factor(ellipse: &ContactEllipse, effective_modulus: f64) -> f64 {
    let radius = 1.0 / ellipse.curvature_sum;
    PI * ellipse.ellipticity * effective_modulus * (ellipse.second * radius / (4.5 * ellipse.first.powi(3))).sqrt()
}

/// Load–deflection factor of two spheres, K = 4/3 E* √R [N/m^1.5], R the effective radius [m].
pub fn sphere_stiffness(contact_modulus: f64, radius: f64) -> f64 {
    4.0 / 3.0 * contact_modulus * radius.sqrt()
}

/// The elastic contact of a ball with one raceway.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzContact {
    pub ellipse: ContactEllipse,
    /// K [N/m^1.5].
    pub stiffness: f64,
    /// Effective modulus E' = 2E* [Pa].
    pub effective_modulus: f64,
    /// R_x = 1/ρ_x, effective radius along rolling [m].
    pub rolling_radius: f64,
    /// R_y = 1/ρ_y, effective radius across the groove [m].
    pub transverse_radius: f64,
    /// Radius of the deformed surface across the groove, R_d = 2 f d / (2 f + 1) [m].
    pub deformed_radius: f64,
    /// Semi-major axis over Q^⅓ [m/N^⅓].
    major_factor: f64,
}

impl HertzContact {
    /// From effective radii along and across rolling, groove curvature, ball diameter and modulus.
    fn new(rolling: f64, across: f64, curvature: f64, ball_diameter: f64, effective_modulus: f64) -> Self {
        let ellipse = ContactEllipse::new(rolling, across);
        let k = ellipse.ellipticity;
        Self {
            stiffness: load_deflection_factor(&ellipse, effective_modulus),
            effective_modulus,
            rolling_radius: 1.0 / rolling,
            transverse_radius: 1.0 / across,
            deformed_radius: 2.0 * curvature * ball_diameter / (2.0 * curvature + 1.0),
            major_factor: (6.0 * k * k * ellipse.second / (PI * effective_modulus * ellipse.curvature_sum)).cbrt(),
            ellipse,
        }
    }

    /// Semi-axes (a, b) of the contact under a load [N]: a = (6 k² 𝓔 Q R/(π E'))^⅓ across the groove, b = a/k [m].
    pub fn semi_axes(&self, load: f64) -> (f64, f64) {
        let major = self.major_factor * load.max(0.0).cbrt();
        (major, major / self.ellipse.ellipticity)
    }

    /// Largest pressure p₀ = 3Q/(2π a b) under a load [N], in Pa.
    pub fn max_pressure(&self, load: f64) -> f64 {
        if load <= 0.0 {
            return 0.0;
        }
        let (a, b) = self.semi_axes(load);
        1.5 * load / (PI * a * b)
    }
}

/// Both raceway contacts of a bearing: across the groove ρ_y = (2/d)(1 − 1/(2f)); along rolling
/// ρ_x = (2/d)(1 + γ/(1−γ)) inside and (2/d)(1 − γ/(1+γ)) outside.
pub fn raceway_contacts(bearing: &Bearing) -> PerRaceway<HertzContact> {
    let p = &bearing.parameters;
    let (d, gamma) = (p.ball_diameter, bearing.gamma());
    let one = |rolling: f64, curvature: f64, material| {
        let across = 2.0 / d * (1.0 - 0.5 / curvature);
        let modulus = 2.0 * contact_modulus(&p.ball_material, material);
        HertzContact::new(2.0 / d * rolling, across, curvature, d, modulus)
    };
    PerRaceway {
        inner: one(1.0 / (1.0 - gamma), p.groove_curvature.inner, &p.raceway_material.inner),
        outer: one(1.0 / (1.0 + gamma), p.groove_curvature.outer, &p.raceway_material.outer),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing;

    /// Harris & Kotzalas, table 6.1 (a*, b*, δ* over F(ρ)), to the digits printed:
    /// a* = (2k²𝓔/π)^⅓, b* = a*/k, δ* = (2𝓕/π)(π/(2k²𝓔))^⅓.
    #[test]
    fn harris_table_of_ellipses() {
        for (difference, a, b, delta) in [(0.7948, 2.265, 0.5480, 0.7961), (0.95738, 4.395, 0.3830, 0.5551)] {
            let e = ContactEllipse::new(0.5 * (1.0 + difference), 0.5 * (1.0 - difference));
            let k2e = e.ellipticity.powi(2) * e.second;
            let a_star = (2.0 * k2e / PI).cbrt();
            let delta_star = 2.0 * e.first / PI * (PI / (2.0 * k2e)).cbrt();
            assert!((a_star / a - 1.0).abs() < 5e-4, "a* {a_star} {a}");
            assert!((a_star / e.ellipticity / b - 1.0).abs() < 5e-4, "b*");
            assert!((delta_star / delta - 1.0).abs() < 5e-4, "δ* {delta_star} {delta}");
        }
    }

    /// Sphere of 10 mm radius on a flat, E* 115.385 GPa, 50 N: a 148.12 µm, p₀ 1088.1 MPa, δ 2.194 µm (closed form of Hertz).
    #[test]
    fn sphere_on_flat() {
        let modulus = 115.385e9;
        let contact = HertzContact::new(100.0, 100.0 * (1.0 - 1e-9), 0.6, 20e-3, 2.0 * modulus);
        let (a, _) = contact.semi_axes(50.0);
        assert!((a / 148.12e-6 - 1.0).abs() < 1e-4, "{a}");
        assert!((contact.max_pressure(50.0) / 1088.1e6 - 1.0).abs() < 1e-4);
        assert!(((50.0 / contact.stiffness).powf(2.0 / 3.0) / 2.194e-6 - 1.0).abs() < 3e-4);
        // Two forms of the same law: K of the circle is 4/3 E* √R, R the radius of the sphere.
        assert!((contact.stiffness / sphere_stiffness(modulus, 10e-3) - 1.0).abs() < 1e-6);
    }

    /// The article's bearing: K_i 1.399e10, K_e 1.492e10, in series 5.1e9 N/m^1.5 (own calculation, second source: docs/MODEL.md).
    #[test]
    fn stiffness_of_the_article_s_bearing() {
        let pair = raceway_contacts(&testing::article().bearing);
        assert!((pair.inner.stiffness / 1.399e10 - 1.0).abs() < 1e-3, "{:e}", pair.inner.stiffness);
        assert!((pair.outer.stiffness / 1.492e10 - 1.0).abs() < 1e-3, "{:e}", pair.outer.stiffness);
        let compliance = |k: f64| k.powf(-2.0 / 3.0);
        let series = (compliance(pair.inner.stiffness) + compliance(pair.outer.stiffness)).powf(-1.5);
        assert!((series / 5.1e9 - 1.0).abs() < 5e-3, "{series:e}");
    }

    /// Duration of an elastic impact on K δ^1.5: T = 2.9432 (5m/4K)^(2/5) v^(−1/5) (Johnson, *Contact Mechanics*, eq. 11.24).
    #[test]
    fn elastic_impact_lasts_as_long_as_hertz_says() {
        let (k, mass, speed) = (1.4e10, 8.8e-5, 0.1);
        let expected = 2.9432 * (5.0 * mass / (4.0 * k)).powf(0.4) * f64::powf(speed, -0.2);
        let (mut x, mut v, mut time, step) = (0.0_f64, speed, 0.0, expected / 200_000.0);
        while x >= 0.0 {
            v -= step * k * x * x.sqrt() / mass;
            x += step * v;
            time += step;
        }
        assert!((time / expected - 1.0).abs() < 1e-4, "{time:e} {expected:e}");
    }

    /// A groove that hugs the ball gives a slender ellipse, not a failure.
    #[test]
    fn close_grooves_stay_finite() {
        for curvature in [0.500_000_1, 0.5001, 0.6, 1.0] {
            let contact = HertzContact::new(800.0, 720.0 * (1.0 - 0.5 / curvature), curvature, 2.778e-3, 2.4e11);
            assert!(contact.stiffness.is_finite() && contact.ellipse.ellipticity >= 1.0);
        }
    }
}
