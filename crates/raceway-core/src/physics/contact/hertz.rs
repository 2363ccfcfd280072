//! Elastic contact after Hertz: ellipse, stiffness and pressure from curvatures.
//!
//! `a` is the semi-axis across the groove (the long one), `b` the one along rolling.

use std::f64::consts::PI;

use crate::numerics::elliptic::complete_elliptic;
use crate::numerics::exponential::power;
use crate::numerics::lanes::larger;
use crate::numerics::roots::bracketed_root;
use crate::physics::bearing::{Bearing, PerRaceway};
use crate::physics::material::contact_modulus;

/// One ball on one raceway: what the normal load and the ellipse need at every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzContact {
    /// Load–deflection factor `K` in `Q = K δ^1.5` [N/m^1.5].
    pub stiffness: f64,
    /// `c_a` in `a = c_a Q^(1/3)` [m/N^(1/3)].
    pub semi_major_coefficient: f64,
    /// `c_b` in `b = c_b Q^(1/3)` [m/N^(1/3)].
    pub semi_minor_coefficient: f64,
    pub ellipse: ContactEllipse,
    /// Effective modulus `E' = 2 E*` [Pa].
    pub effective_modulus: f64,
    /// Radius of relative curvature along rolling, `R_x = 1/ρ_x` [m].
    pub rolling_radius: f64,
    /// Radius of relative curvature across the groove, `R_y = 1/ρ_y` [m].
    pub transverse_radius: f64,
    /// Radius of the deformed surface across the groove, `R_d = 2 f d / (2 f + 1)` [m].
    pub deformed_radius: f64,
}

impl HertzContact {
    /// Semi-axes (a, b) [m] at a normal load [N].
    #[inline]
    pub fn semi_axes(&self, load: f64) -> (f64, f64) {
        let root = load.max(0.0).cbrt();
        (self.semi_major_coefficient * root, self.semi_minor_coefficient * root)
    }

    /// Largest pressure `p₀ = 3 Q / (2 π a b)` [Pa] at a normal load [N]; 0 without load.
    #[inline(always)]
    pub fn max_pressure(&self, load: f64) -> f64 {
        // a b = c_a c_b Q^(2/3), so p₀ goes with Q^(1/3) and needs no division by the load.
        1.5 / (PI * self.semi_major_coefficient * self.semi_minor_coefficient) * power(larger(load, 0.0), 1.0 / 3.0)
    }
}

/// Pressure of a permanent deformation of 10⁻⁴ of the ball diameter (ISO 76, ball bearings) [Pa].
pub const STATIC_PRESSURE_LIMIT: f64 = 4.2e9;

/// The contacts of a ball with both raceways.
///
/// Curvatures of a ball in a groove of radius `f d`, γ with the contact angle of the kinematics. Inner ρ_x = (2/d)(1 +
/// γ/(1 − γ)), outer ρ_x = (2/d)(1 − γ/(1 + γ)), ρ_y = (2/d)(1 − 1/(2f)). Harris & Kotzalas, Essential Concepts of
/// Bearing Technology, ch. 2, curvature of ball bearings.
pub fn raceway_contacts(bearing: &Bearing) -> PerRaceway<HertzContact> {
    let p = &bearing.parameters;
    let (d, gamma) = (p.ball_diameter, bearing.gamma());
    let contact = |curvature_along: f64, groove_curvature: f64, raceway| {
        // (2/d)(1 − 1/(2f)) with its difference taken where it is exact.
        let curvature_across = (2.0 * groove_curvature - 1.0) / (groove_curvature * d);
        let ellipse = ContactEllipse::new(curvature_along, curvature_across);
        let effective_modulus = 2.0 * contact_modulus(&p.ball_material, raceway);
        let (a, b) = semi_axes(&ellipse, effective_modulus, 1.0);
        HertzContact {
            stiffness: load_deflection_factor(&ellipse, effective_modulus),
            semi_major_coefficient: a,
            semi_minor_coefficient: b,
            ellipse,
            effective_modulus,
            rolling_radius: 1.0 / curvature_along,
            transverse_radius: 1.0 / curvature_across,
            deformed_radius: 2.0 * groove_curvature * d / (2.0 * groove_curvature + 1.0),
        }
    };
    PerRaceway {
        inner: contact(2.0 / (d * (1.0 - gamma)), p.groove_curvature.inner, &p.raceway_material.inner),
        outer: contact(2.0 / (d * (1.0 + gamma)), p.groove_curvature.outer, &p.raceway_material.outer),
    }
}

/// Shape of the ellipse of contact: it depends on curvatures only, not on load or material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEllipse {
    /// `k = a/b ≥ 1` [-].
    pub ellipticity: f64,
    /// Complete elliptic integral of the first kind 𝓕 at m = 1 − 1/k² [-].
    pub elliptic_first: f64,
    /// Complete elliptic integral of the second kind 𝓔 at m = 1 − 1/k² [-].
    pub elliptic_second: f64,
    /// Σρ = ρ_x + ρ_y [1/m].
    pub curvature_sum: f64,
    /// R = 1/Σρ [m].
    pub effective_radius: f64,
}

impl ContactEllipse {
    /// The ellipse between two bodies of relative curvatures ρ_x along rolling and ρ_y across the
    /// groove [1/m], both positive.
    ///
    /// Solves [(k² + 1)𝓔 − 2𝓕] / [(k² − 1)𝓔] = (ρ_x − ρ_y)/Σρ (Harris & Kotzalas, ch. 6) in the
    /// equivalent form ρ_x/ρ_y = k² 𝓑/𝓓 with 𝓑 = (𝓔 − 𝓕/k²)/m and 𝓓 = (𝓕 − 𝓔)/m (Johnson, Contact
    /// Mechanics, eq. 4.28), which stays regular at the circle. Where ρ_y > ρ_x the ellipse is the
    /// same, turned by 90°: k stays above 1, and `a` then lies along rolling.
    pub fn new(curvature_along: f64, curvature_across: f64) -> Self {
        let ratio = curvature_along / curvature_across;
        let target = ratio.ln().abs();
        let excess = |ln_k: f64| {
            let integrals = complete_elliptic((-2.0 * ln_k).exp());
            2.0 * ln_k + (integrals.b / integrals.d).ln() - target
        };
        // 1 ≤ k ≤ ρ_x/ρ_y, with equality on the left for a circle.
        let ln_k = bracketed_root(excess, 0.0, target);
        let integrals = complete_elliptic((-2.0 * ln_k).exp());
        let curvature_sum = curvature_along + curvature_across;
        Self {
            ellipticity: ln_k.exp(),
            elliptic_first: integrals.first,
            elliptic_second: integrals.second,
            curvature_sum,
            effective_radius: 1.0 / curvature_sum,
        }
    }
}

/// Load–deflection factor `K` in `Q = K δ^(3/2)` [N/m^1.5], effective modulus E' = 2 E* [Pa].
///
/// Hamrock & Dowson, Ball Bearing Lubrication (1981), eq. (3.24): K = π k E' √(𝓔 R / (4.5 𝓕³)).
/// Elastic, dry, frictionless, and only while the ellipse is small against the bodies.
pub fn load_deflection_factor(ellipse: &ContactEllipse, effective_modulus: f64) -> f64 {
    let ContactEllipse { ellipticity, elliptic_first, elliptic_second, effective_radius, .. } = *ellipse;
    PI * ellipticity * effective_modulus * (elliptic_second * effective_radius / (4.5 * elliptic_first.powi(3))).sqrt()
}

/// Semi-axes (a, b) [m] at a normal load [N], effective modulus E' = 2 E* [Pa].
///
/// Hamrock & Dowson (1981), ch. 3: a = (6 k² 𝓔 Q R / (π E'))^(1/3), b = a / k.
pub fn semi_axes(ellipse: &ContactEllipse, effective_modulus: f64, load: f64) -> (f64, f64) {
    let ContactEllipse { ellipticity, elliptic_second, effective_radius, .. } = *ellipse;
    let volume = 6.0 * ellipticity * ellipticity * elliptic_second * load * effective_radius / (PI * effective_modulus);
    let a = volume.cbrt();
    (a, a / ellipticity)
}

/// Largest pressure `p₀ = 3 Q / (2 π a b)` [Pa] at a normal load [N], effective modulus E' [Pa].
///
/// Hertz 1881; zero without load.
pub fn max_pressure(ellipse: &ContactEllipse, effective_modulus: f64, load: f64) -> f64 {
    let (a, b) = semi_axes(ellipse, effective_modulus, 1.0);
    1.5 / (PI * a * b) * load.max(0.0).cbrt()
}

/// Stiffness `K` in `Q = K δ^(3/2)` [N/m^1.5] of two spheres of effective radius R [m] and contact modulus E* [Pa]. 1/R
/// = 1/R₁ + 1/R₂, a concave radius negative.
///
/// Johnson, Contact Mechanics, eq. (4.23): K = 4/3 E* √R.
pub(crate) fn sphere_stiffness(contact_modulus: f64, radius: f64) -> f64 {
    4.0 / 3.0 * contact_modulus * radius.sqrt()
}

/// Stiffness of two contacts of factors K₁ and K₂ in series [N/m^1.5], (K₁^(−2/3) + K₂^(−2/3))^(−3/2).
///
/// Harris & Kotzalas, ch. 7: a ball squeezed between inner and outer raceway by the same load.
#[cfg(test)]
pub(crate) fn series_stiffness(first: f64, second: f64) -> f64 {
    let compliance = first.powf(-2.0 / 3.0) + second.powf(-2.0 / 3.0);
    compliance.powf(-1.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::examples::article_bearing;

    fn assert_close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} against {expected}");
    }

    /// The equation as Harris & Kotzalas print it holds for the root found in another form, 1e-9.
    #[test]
    fn ellipticity_solves_the_printed_equation() {
        for ratio in [1.01, 1.5, 3.0, 20.0, 100.0, 1e4] {
            let ellipse = ContactEllipse::new(ratio, 1.0);
            let (k2, first, second) = (ellipse.ellipticity.powi(2), ellipse.elliptic_first, ellipse.elliptic_second);
            let printed = ((k2 + 1.0) * second - 2.0 * first) / ((k2 - 1.0) * second);
            assert_close(printed, (ratio - 1.0) / (ratio + 1.0), 1e-9);
        }
    }

    /// k = 1, 𝓕 = 𝓔 = π/2, R = r/2 give a circle and K = ⅔ E' √r.
    #[test]
    fn sphere_on_plane_recovers_hertz() {
        let (radius, modulus) = (10e-3, 115.385e9);
        let ellipse = ContactEllipse::new(1.0 / radius, 1.0 / radius);
        assert_eq!(ellipse.ellipticity, 1.0);
        assert_close(load_deflection_factor(&ellipse, 2.0 * modulus), sphere_stiffness(modulus, radius), 1e-14);
        let (a, b) = semi_axes(&ellipse, 2.0 * modulus, 50.0);
        assert_eq!(a, b);
    }

    /// Stiffness and ellipse pass through the circle without a step: K over ratio 1 ± ε differs by order ε.
    #[test]
    fn circle_is_no_special_case() {
        let at = |ratio: f64| load_deflection_factor(&ContactEllipse::new(ratio, 1.0 / ratio), 1.0);
        for step in [1e-3, 1e-6, 1e-9, 1e-12] {
            assert_close(at(1.0 + step), at(1.0), 2.0 * step);
            assert_close(ContactEllipse::new(1.0 + step, 1.0).ellipticity, 1.0 + 2.0 / 3.0 * step, step);
        }
    }

    /// K_i 1.399e10, K_e 1.492e10, in series 5.1e9 N/m^1.5: article's bearing, from a separate
    /// calculation given to four and two figures.
    #[test]
    fn article_bearing_has_its_stiffness() {
        let contacts = raceway_contacts(&article_bearing());
        assert_close(contacts.inner.stiffness, 1.399e10, 1e-3);
        assert_close(contacts.outer.stiffness, 1.492e10, 1e-3);
        assert_close(series_stiffness(contacts.inner.stiffness, contacts.outer.stiffness), 5.1e9, 5e-3);
    }

    /// The prepared form and the formulas agree, to rounding.
    #[test]
    fn prepared_contact_repeats_the_formulas() {
        let contact = raceway_contacts(&article_bearing()).inner;
        let (a, b) = semi_axes(&contact.ellipse, contact.effective_modulus, 137.0);
        assert_close(contact.semi_axes(137.0).0, a, 1e-14);
        assert_close(contact.semi_axes(137.0).1, b, 1e-14);
        assert_close(contact.max_pressure(137.0), 1.5 * 137.0 / (PI * a * b), 1e-13);
        assert_eq!(contact.max_pressure(0.0), 0.0);
    }

    /// Every groove that `Bearing` accepts gives a finite ellipse, down to the float next to f = ½.
    #[test]
    fn tightest_groove_stays_finite() {
        let mut previous = f64::INFINITY;
        for f in [0.5 + f64::EPSILON, 0.5 + 1e-12, 0.5 + 1e-9, 0.5001, 0.505, 0.515, 0.53, 0.6, 0.8, 1.0] {
            let mut parameters = article_bearing().parameters;
            parameters.groove_curvature = PerRaceway { inner: f, outer: f };
            parameters.fit = crate::physics::bearing::Fit::RadialClearance(0.0);
            let contact = raceway_contacts(&Bearing::new(parameters).unwrap()).outer;
            assert!(contact.stiffness.is_finite() && contact.stiffness > 0.0 && contact.stiffness < previous);
            assert!(contact.semi_minor_coefficient > 0.0 && contact.semi_major_coefficient.is_finite());
            previous = contact.stiffness;
        }
    }
}
