//! The lubricant film between ball and raceway: its thickness, and the forces of its inlet.

use std::f64::consts::PI;

use super::hertz::HertzContact;
use crate::numerics::exponential::{logarithm_of_one_plus, power};
use crate::numerics::lanes::{LANES, Singles, larger};

/// Film thickness of one contact as powers of rolling speed and load, made once a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Film {
    /// h_c at ū = 1 m/s, Q = 1 N [m].
    central_coefficient: f64,
    /// h_min at ū = 1 m/s, Q = 1 N [m].
    minimum_coefficient: f64,
}

/// A load below which a film does not grow any further [N].
const MIN_LOAD: f64 = 1e-6;
/// Exponents of the minimum film thickness, which grows with speed and falls with load.
const SPEED_EXPONENT: f64 = 0.68;
const LOAD_EXPONENT: f64 = 0.073;
/// A film thinner than a molecule is none [m].
const MIN_FILM: f64 = 1e-9;

impl Film {
    /// Prepares the film of a contact for viscosity η [Pa s] and pressure–viscosity coefficient α_p [1/Pa].
    pub(crate) fn new(contact: &HertzContact, viscosity: f64, pressure_viscosity: f64) -> Self {
        let unit = FilmConditions::of(contact, viscosity, pressure_viscosity, 1.0, 1.0);
        Self { central_coefficient: central_film_thickness(&unit), minimum_coefficient: minimum_film_thickness(&unit) }
    }

    /// Central film thickness h_c [m] at mean rolling speed ū [m/s] and load [N]; 0 at rest.
    #[inline(always)]
    pub(crate) fn central(&self, rolling_speed: f64, load: f64) -> f64 {
        self.central_coefficient * power(rolling_speed.abs(), 0.67) * power(larger(load, MIN_LOAD), -0.067)
    }

    /// Minimum film thickness h_min [m] at mean rolling speed ū [m/s] and load [N]; 0 at rest.
    #[inline(always)]
    pub(crate) fn minimum(&self, rolling_speed: f64, load: f64) -> f64 {
        self.minimum_coefficient
            * power(rolling_speed.abs(), SPEED_EXPONENT)
            * power(larger(load, MIN_LOAD), -LOAD_EXPONENT)
    }
}

/// The thinnest minimum film of a contact that was met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ThinnestFilm {
    /// [m]; infinite before the first.
    pub thickness: f64,
    /// Mean rolling speed [m/s] and load [N] of that contact.
    rolling_speed: f64,
    load: f64,
}

impl ThinnestFilm {
    pub(crate) const NONE: Self = Self { thickness: f64::INFINITY, rolling_speed: 0.0, load: 0.0 };

    /// Returns whether one of several contacts under load may have a thinner film, by the bound of `meet` without its quotients. The
    /// margin is far above rounding, so that `meet` would accept none of those that this omits.
    #[inline(always)]
    pub(crate) fn may_be_thinner(&self, rolling_speed: &Singles, load: &Singles) -> bool {
        const MARGIN: f32 = 1e-5;
        let (thinnest_speed, per_load) = (self.rolling_speed as f32, (1.0 / self.load) as f32);
        let (by_speed, by_load) = (SPEED_EXPONENT as f32, LOAD_EXPONENT as f32);
        let mut excess = Singles::default();
        for lane in 0..LANES {
            let (speed, load) = (rolling_speed[lane].abs(), load[lane]);
            let bound = by_speed * (speed - thinnest_speed) - by_load * (load * per_load - 1.0) * speed;
            // The negated comparison takes the infinite bound before the first film, too.
            let is_thicker = bound > MARGIN * speed;
            excess[lane] = if load > 0.0 && !is_thicker { 1.0 } else { 0.0 };
        }
        excess.any(|excess| excess > 0.0)
    }

    /// Compares with another contact. Most films are thicker, which a bound shows without computing powers: from 1 −
    /// 1/x ≤ ln x ≤ x − 1 follows a lower bound of the logarithm of the ratio of thicknesses.
    pub(crate) fn meet(&mut self, film: &Film, rolling_speed: f64, load: f64) {
        let (speed, load) = (rolling_speed.abs(), larger(load, MIN_LOAD));
        if SPEED_EXPONENT * (1.0 - self.rolling_speed / speed) - LOAD_EXPONENT * (load / self.load - 1.0) >= 0.0 {
            return;
        }
        let thickness = film.minimum(speed, load);
        if thickness < self.thickness {
            *self = Self { thickness, rolling_speed: speed, load };
        }
    }
}

/// Operating conditions of the film of an elliptical contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmConditions {
    /// η at inlet temperature and ambient pressure [Pa s].
    pub viscosity: f64,
    /// α_p [1/Pa].
    pub pressure_viscosity: f64,
    /// E' = 2 E* [Pa].
    pub effective_modulus: f64,
    /// R_x along rolling [m].
    pub rolling_radius: f64,
    /// k = a/b [-].
    pub ellipticity: f64,
    /// ū, half the sum of the surface velocities in the frame of the contact [m/s].
    pub rolling_speed: f64,
    /// Q [N].
    pub load: f64,
}

impl FilmConditions {
    /// The conditions of a contact at a rolling speed [m/s] and load [N].
    pub fn of(contact: &HertzContact, viscosity: f64, pressure_viscosity: f64, rolling_speed: f64, load: f64) -> Self {
        Self {
            viscosity,
            pressure_viscosity,
            effective_modulus: contact.effective_modulus,
            rolling_radius: contact.rolling_radius,
            ellipticity: contact.ellipse.ellipticity,
            rolling_speed,
            load,
        }
    }

    /// Ū = η ū / (E' R_x), G = α_p E' and W = Q / (E' R_x²) [-].
    fn groups(&self) -> (f64, f64, f64) {
        (
            self.viscosity * self.rolling_speed.abs() / (self.effective_modulus * self.rolling_radius),
            self.pressure_viscosity * self.effective_modulus,
            self.load / (self.effective_modulus * self.rolling_radius * self.rolling_radius),
        )
    }
}

/// Central film thickness `h_c` [m].
///
/// Hamrock & Dowson 1977: H_c = 2.69 Ū^0.67 G^0.53 W^−0.067 (1 − 0.61 e^(−0.73 k)), h = H R_x. Elastic,
/// piezoviscous, fully flooded, isothermal; thinner in truth where the inlet starves or shears warm.
fn central_film_thickness(conditions: &FilmConditions) -> f64 {
    let (speed, material, load) = conditions.groups();
    let side_leakage = 1.0 - 0.61 * (-0.73 * conditions.ellipticity).exp();
    2.69 * speed.powf(0.67) * material.powf(0.53) * load.powf(-0.067) * side_leakage * conditions.rolling_radius
}

/// Minimum film thickness `h_min` [m].
///
/// Hamrock & Dowson 1977: H_min = 3.63 Ū^0.68 G^0.49 W^−0.073 (1 − e^(−0.68 k)), h = H R_x. Same limits as
/// the central thickness.
pub fn minimum_film_thickness(conditions: &FilmConditions) -> f64 {
    let (speed, material, load) = conditions.groups();
    let side_leakage = 1.0 - (-0.68 * conditions.ellipticity).exp();
    3.63 * speed.powf(SPEED_EXPONENT)
        * material.powf(0.49)
        * load.powf(-LOAD_EXPONENT)
        * side_leakage
        * conditions.rolling_radius
}

/// Forces of the inlet on a ball, signed like the rolling speed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct InletForces {
    /// F_R [N], on each surface at the contact point, against rolling.
    pub rolling: f64,
    /// F_H [N], on the ball through its centre.
    pub pressure: f64,
}

/// The hydrodynamic inlet of one contact, made once a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Inlet {
    viscosity: f64,
    rolling_radius: f64,
    transverse_radius: f64,
    ball_radius: f64,
    meniscus: f64,
}

impl Inlet {
    /// Prepares the inlet of a contact of a ball of radius [m], for viscosity η [Pa s] and the distance of
    /// the meniscus from the middle of the contact [m].
    pub(crate) fn new(contact: &HertzContact, viscosity: f64, meniscus: f64, ball_radius: f64) -> Self {
        let HertzContact { rolling_radius, transverse_radius, .. } = *contact;
        Self { viscosity, rolling_radius, transverse_radius, ball_radius, meniscus }
    }

    /// Rolling friction F_R = F_p/2 and pressure force F_H = F_p R_x/(d/2) [N] at mean rolling speed ū [m/s], central
    /// film thickness [m] and semi-axis b [m]. The meniscus lies outside the semi-axis b.
    ///
    /// The shear of both surfaces is F_p/2 each. The pressure on the ball has the lever R_x. The raceway takes the
    /// remainder, so that momentum is conserved.
    #[inline(always)]
    pub(crate) fn forces(&self, rolling_speed: f64, film_thickness: f64, semi_minor: f64) -> InletForces {
        let force = inlet_force(
            self.viscosity,
            2.0 * rolling_speed,
            self.rolling_radius,
            self.transverse_radius,
            film_thickness,
            larger(self.meniscus, semi_minor),
        );
        InletForces { rolling: 0.5 * force, pressure: force * self.rolling_radius / self.ball_radius }
    }
}

/// Force `F_p` of the inlet pressure along rolling [N], signed like the sum `U = u₁ + u₂` of the surface
/// velocities [m/s] (the sum, not the slip).
///
/// Rigid surfaces, constant viscosity, exact for the pressure p = −6ηUx/[(3 + 2R_x/R_y) h²] of the parabolic gap
/// (Kapitza 1955): F_p = C₀ 6π [ln(1 + t²) + 1/(1 + t²) − 1], C₀ = ηU√(R_x R_y)/(3 + 2R_x/R_y), t = r_s/√(2 h₀ R_x),
/// r_s the distance of the inlet meniscus. Differs from the source: the literature's fits 28.59 ln t − 10.10 and 36.57
/// ln t − 22.85 lie 6–20 % below. They turn negative at small t.
#[inline(always)]
fn inlet_force(
    viscosity: f64,
    speed_sum: f64,
    rolling_radius: f64,
    transverse_radius: f64,
    film_thickness: f64,
    meniscus: f64,
) -> f64 {
    let scale = viscosity * speed_sum * (rolling_radius * transverse_radius).sqrt()
        / (3.0 + 2.0 * rolling_radius / transverse_radius);
    let t = meniscus / (2.0 * larger(film_thickness, MIN_FILM) * rolling_radius).sqrt();
    scale * 6.0 * PI * inlet_integral(t)
}

/// `ln(1 + t²) + 1/(1 + t²) − 1` [-], t⁴/2 for small t.
#[inline(always)]
fn inlet_integral(t: f64) -> f64 {
    let square = t * t;
    logarithm_of_one_plus(square) - square / (1.0 + square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::hertz::raceway_contacts;
    use crate::physics::examples::{article_bearing, article_lubricant};
    use crate::physics::kinematics::ideal_orbit_ratio;

    fn assert_close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} against {expected}");
    }

    /// Hamrock & Dowson's central film in the article's bearing at 137 N and 50 000 r/min: 0.47 µm inner, 0.57 µm outer, two figures.
    #[test]
    fn film_of_the_article_bearing() {
        let (bearing, oil) = (article_bearing(), article_lubricant());
        let contacts = raceway_contacts(&bearing);
        let speed = entrainment();
        for (contact, expected) in [(&contacts.inner, 0.47e-6), (&contacts.outer, 0.57e-6)] {
            let film = Film::new(contact, oil.viscosity, oil.pressure_viscosity);
            assert_close(film.central(speed, 137.0), expected, 0.012);
            let conditions = FilmConditions::of(contact, oil.viscosity, oil.pressure_viscosity, speed, 137.0);
            assert_close(film.central(speed, 137.0), central_film_thickness(&conditions), 1e-12);
            assert_close(film.minimum(-speed, 137.0), minimum_film_thickness(&conditions), 1e-12);
            assert_eq!(film.central(0.0, 137.0), 0.0);
            assert!(film.central(speed, 0.0).is_finite());
        }
    }

    /// ū of ideal rolling at 50 000 r/min; the same on both raceways [m/s].
    fn entrainment() -> f64 {
        let p = article_bearing().parameters;
        0.5 * (p.pitch_diameter + p.ball_diameter)
            * ideal_orbit_ratio(&article_bearing())
            * (50_000.0 * std::f64::consts::TAU / 60.0)
    }

    /// F_R about 0.05 N at η = 0.02 Pa s, meniscus d/4, article's bearing (one figure given); F_H = F_p R_x/(d/2).
    #[test]
    fn inlet_of_the_article_bearing() {
        let bearing = article_bearing();
        let d = bearing.parameters.ball_diameter;
        let contacts = raceway_contacts(&bearing);
        for contact in [&contacts.inner, &contacts.outer] {
            let film = Film::new(contact, 0.02, 2e-8).central(entrainment(), 137.0);
            let forces =
                Inlet::new(contact, 0.02, d / 4.0, d / 2.0).forces(entrainment(), film, contact.semi_axes(137.0).1);
            assert!((forces.rolling - 0.05).abs() < 0.01, "{}", forces.rolling);
            assert_close(forces.pressure, 4.0 * forces.rolling * contact.rolling_radius / d, 1e-14);
            let back = Inlet::new(contact, 0.02, d / 4.0, d / 2.0).forces(-entrainment(), film, 0.0);
            assert_eq!(back.rolling, -forces.rolling);
        }
    }

    /// The closed form is the integral of p x/R_x over the half gap inside the meniscus: midpoint rule in
    /// x and y, 0.1 %.
    #[test]
    fn inlet_force_is_the_integral_of_its_pressure() {
        let (viscosity, sum, rx, ry, h0, meniscus) = (0.02, 30.0, 1e-3_f64, 20e-3, 0.5e-6, 0.3e-3);
        let reach_y = meniscus * (ry / rx).sqrt();
        let (nx, ny) = (1200, 600);
        let (dx, dy) = (meniscus / f64::from(nx), reach_y / f64::from(ny));
        let mut force = 0.0;
        for i in 0..nx {
            for j in 0..ny {
                let (x, y) = ((f64::from(i) + 0.5) * dx, (f64::from(j) + 0.5) * dy);
                if (x / meniscus).powi(2) + (y / reach_y).powi(2) < 1.0 {
                    let gap = h0 + x * x / (2.0 * rx) + y * y / (2.0 * ry);
                    let pressure = 6.0 * viscosity * sum * x / ((3.0 + 2.0 * rx / ry) * gap * gap);
                    force += 2.0 * pressure * x / rx * dx * dy;
                }
            }
        }
        assert_close(inlet_force(viscosity, sum, rx, ry, h0, meniscus), force, 1e-3);
    }

    /// Without film or meniscus the inlet stays finite: ln grows, t⁴/2 at small t (series), 1e-6.
    #[test]
    fn inlet_is_finite_at_its_ends() {
        assert!(inlet_force(0.02, 0.0, 1e-3, 1e-2, 0.0, 1e-3) == 0.0);
        assert!(inlet_force(0.02, 1.0, 1e-3, 1e-2, 0.0, 1e-3).is_finite());
        assert_close(inlet_integral(1e-2), 0.5e-8, 1e-3);
        assert_eq!(inlet_integral(0.0), 0.0);
    }

    /// The bound skips no thinner film: the thinnest of many agrees with the minimum over all formulas.
    #[test]
    fn the_thinnest_film_is_found_without_all_powers() {
        let film = Film { central_coefficient: 1.0, minimum_coefficient: 1e-7 };
        let mut thinnest = ThinnestFilm::NONE;
        let mut least = f64::INFINITY;
        for i in 0..10_000 {
            let i = f64::from(i);
            let (speed, load) = (7.0 + 3.0 * (0.7 * i).sin(), 100.0 + 99.0 * (0.31 * i).cos());
            thinnest.meet(&film, -speed, load);
            least = least.min(film.minimum(speed, load));
            assert_eq!(thinnest.thickness, least);
        }
        thinnest.meet(&film, 0.0, 1.0);
        assert_eq!(thinnest.thickness, 0.0);
    }
}
