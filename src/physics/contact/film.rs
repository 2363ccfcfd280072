//! Lubricant film of a rolling contact: thickness, rolling friction F_R and pressure force F_H.

use std::f64::consts::PI;

use super::hertz::{HertzContact, raceway_contacts};
use crate::physics::bearing::Bearing;
use crate::physics::kinematics;
use crate::physics::lubricant::Lubricant;

/// Film thickness of one raceway contact.
#[derive(Debug, Clone, Copy)]
pub struct Film {
    central: f64,
    minimum: f64,
}

impl Film {
    /// Hamrock & Dowson (1977), elliptical contact, fully flooded, isothermal:
    /// H_c = 2.69 Ū^0.67 G^0.53 W^−0.067 (1 − 0.61 e^(−0.73k)), H_min = 3.63 Ū^0.68 G^0.49 W^−0.073 (1 − e^(−0.68k)),
    /// Ū = η ū/(E' R_x), W = Q/(E' R_x²), G = α_p E', h = H R_x.
    pub fn new(contact: &HertzContact, lubricant: &Lubricant) -> Self {
        let (modulus, radius, k) = (contact.effective_modulus, contact.rolling_radius, contact.ellipse.ellipticity);
        let speed = lubricant.viscosity / (modulus * radius);
        let load = 1.0 / (modulus * radius * radius);
        let material = lubricant.pressure_viscosity * modulus;
        Self {
            central: 2.69
                * speed.powf(0.67)
                * material.powf(0.53)
                * load.powf(-0.067)
                * radius
                * (1.0 - 0.61 * (-0.73 * k).exp()),
            minimum: 3.63
                * speed.powf(0.68)
                * material.powf(0.49)
                * load.powf(-0.073)
                * radius
                * (1.0 - (-0.68 * k).exp()),
        }
    }

    /// Central film thickness [m] at a mean surface speed [m/s] and load [N]; 0 at rest.
    pub fn central_thickness(&self, speed: f64, load: f64) -> f64 {
        if load > 0.0 { self.central * speed.abs().powf(0.67) * load.powf(-0.067) } else { 0.0 }
    }

    /// Minimum film thickness [m] at a mean surface speed [m/s] and load [N]; 0 at rest.
    pub fn minimum_thickness(&self, speed: f64, load: f64) -> f64 {
        if load > 0.0 { self.minimum * speed.abs().powf(0.68) * load.powf(-0.073) } else { 0.0 }
    }
}

/// Hydrodynamic forces of the inlet of one raceway contact.
#[derive(Debug, Clone, Copy)]
pub struct Inlet {
    /// η √(R_x R_y) / (3 + 2 R_x/R_y) [N s/m]
    factor: f64,
    rolling_radius: f64,
    ball_radius: f64,
    /// Distance of the meniscus from the contact [m].
    meniscus: f64,
}

/// Hydrodynamic forces along rolling; their sum over ball and raceway vanishes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InletForces {
    /// F_R = F_p/2 against rolling on each surface at the contact point, signed with the rolling velocity [N].
    pub rolling: f64,
    /// F_H = F_p R_x/(d/2) on the ball, through its centre, along rolling [N].
    pub pressure_on_ball: f64,
}

impl Inlet {
    /// The meniscus lies where the lubricant says, a quarter of the ball diameter away by default.
    pub fn new(contact: &HertzContact, lubricant: &Lubricant, ball_diameter: f64) -> Self {
        let (x, y) = (contact.rolling_radius, contact.transverse_radius);
        Self {
            factor: lubricant.viscosity * (x * y).sqrt() / (3.0 + 2.0 * x / y),
            rolling_radius: x,
            ball_radius: 0.5 * ball_diameter,
            meniscus: lubricant.inlet_distance.unwrap_or(0.25 * ball_diameter),
        }
    }

    /// Forces at a sum of surface velocities U = u₁ + u₂ [m/s], a central film thickness [m] and a semi-minor
    /// axis [m] below which the meniscus cannot lie.
    ///
    /// Rigid isoviscous inlet, exact for p = −6ηUx/[(3 + 2R_x/R_y) h²]: F_p = C₀ 6π [ln(1+t²) + 1/(1+t²) − 1],
    /// C₀ = ηU√(R_x R_y)/(3 + 2R_x/R_y), t = r_s/√(2 h₀ R_x). Houpert's line of models.
    pub fn forces(&self, sum_velocity: f64, film: f64, semi_minor: f64) -> InletForces {
        if film <= 0.0 {
            return InletForces::default();
        }
        let reach = self.meniscus.max(semi_minor);
        let squared = reach * reach / (2.0 * film * self.rolling_radius);
        let pressure = self.factor * sum_velocity * 6.0 * PI * (squared.ln_1p() + 1.0 / (1.0 + squared) - 1.0);
        InletForces { rolling: 0.5 * pressure, pressure_on_ball: pressure * self.rolling_radius / self.ball_radius }
    }
}

/// F_R of a ball on the inner raceway under a load [N] in ideal rolling at a spindle speed [rad/s], its inlet flooded [N].
pub fn nominal_rolling_friction(bearing: &Bearing, lubricant: &Lubricant, load: f64, speed: f64) -> f64 {
    if load <= 0.0 {
        return 0.0;
    }
    let contact = raceway_contacts(bearing).inner;
    let gamma = bearing.gamma();
    let rolling = 0.5
        * bearing.parameters.pitch_diameter
        * (1.0 - gamma)
        * (1.0 - kinematics::ideal_orbit_ratio(bearing))
        * speed.abs();
    let film = Film::new(&contact, lubricant).central_thickness(rolling, load);
    let inlet = Inlet::new(&contact, lubricant, bearing.parameters.ball_diameter);
    inlet.forces(2.0 * rolling, film, contact.semi_axes(load).1).rolling
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing;

    /// Harris & Kotzalas' 209 bearing: ū 6.252 m/s, R_x 5.109 mm, R_y 167.6 mm, E' 228 GPa, Ū 2.147e-10, W 8.31e-4,
    /// G 5244 give h_min 0.55 µm. The load follows from W, the viscosity from Ū, α_p from G.
    #[test]
    fn film_of_the_209_bearing() {
        let (modulus, x, y) = (228e9, 5.109e-3, 167.6e-3);
        let ellipse = super::super::hertz::ContactEllipse::new(1.0 / x, 1.0 / y);
        let mut contact = raceway_contacts(&testing::article().bearing).inner;
        contact.ellipse = ellipse;
        (contact.effective_modulus, contact.rolling_radius, contact.transverse_radius) = (modulus, x, y);
        let mut lubricant = testing::article().lubricant;
        lubricant.viscosity = 2.147e-10 * modulus * x / 6.252;
        lubricant.pressure_viscosity = 5244.0 / modulus;
        let film = Film::new(&contact, &lubricant).minimum_thickness(6.252, 8.31e-4 * modulus * x * x);
        assert!((film / 0.55e-6 - 1.0).abs() < 0.02, "{film:e}");
    }

    /// The article's most loaded ball, 137 N: 0.47 µm inside, 0.57 µm outside, F_R about 0.05 N (own calculation).
    #[test]
    fn film_and_rolling_friction_of_the_article_s_case() {
        let parts = testing::article();
        let speed = 50_000.0 * PI / 30.0;
        let pair = raceway_contacts(&parts.bearing);
        let gamma = parts.bearing.gamma();
        let ball = 0.5 * 13e-3 * (1.0 - gamma) * speed * 0.5 * (1.0 + gamma);
        let inner = Film::new(&pair.inner, &parts.lubricant).central_thickness(ball, 137.0);
        let outer = Film::new(&pair.outer, &parts.lubricant).central_thickness(ball, 137.0);
        assert!((inner / 0.47e-6 - 1.0).abs() < 0.05 && (outer / 0.57e-6 - 1.0).abs() < 0.05, "{inner:e} {outer:e}");
        let friction = nominal_rolling_friction(&parts.bearing, &parts.lubricant, 137.0, speed);
        assert!((friction / 0.05 - 1.0).abs() < 0.3, "{friction}");
    }

    /// Pins the logarithm of F_p.
    #[test]
    fn inlet_force_grows_with_the_logarithm_of_the_meniscus() {
        let parts = testing::article();
        let contact = raceway_contacts(&parts.bearing).inner;
        let inlet = Inlet::new(&contact, &parts.lubricant, 2.778e-3);
        let thin = inlet.forces(40.0, 0.1e-6, 0.0).rolling;
        let thick = inlet.forces(40.0, 1e-6, 0.0).rolling;
        // For t ≫ 1 each decade of film takes 6π ln 10 C₀ / 2.
        let expected = 0.5 * inlet.factor * 40.0 * 6.0 * PI * 10f64.ln();
        assert!(((thin - thick) / expected - 1.0).abs() < 1e-2);
        assert_eq!(inlet.forces(40.0, 0.0, 0.0), InletForces::default());
    }
}
