//! Traction of a lubricated contact with slip, spin and conformity.

use crate::physics::{InvalidParameter, above, within};

/// Traction coefficient μ as a function of slip speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TractionLaw {
    /// μ = (A + B|u|) e^(−C|u|) + D from μ at rest, its maximum, the slip speed [m/s] where it is
    /// reached, and its limit at high slip.
    FourParameter { at_rest: f64, maximum: f64, at_slip: f64, limit: f64 },
    /// The same form over the slide/roll ratio s = u / max(ū, 0.1 m/s), coefficients given.
    SlideRoll { a: f64, b: f64, c: f64, d: f64 },
    /// τ = min(τ_E asinh(η(p) u / (h τ_E)), Λ p), Eyring stress τ_E [Pa], limit Λ.
    Eyring { stress: f64, limit: f64 },
    /// μ tanh(u / u_r), regularisation speed u_r [m/s].
    Coulomb { coefficient: f64, regularisation: f64 },
}

impl TractionLaw {
    /// Refuses coefficients that no contact has.
    pub fn check(&self) -> Result<(), InvalidParameter> {
        match *self {
            Self::FourParameter { at_rest, maximum, at_slip, limit } => {
                within("lubricant.traction.at_rest", at_rest, 0.0, 2.0)?;
                within("lubricant.traction.maximum", maximum, 0.0, 2.0)?;
                within("lubricant.traction.at_slip", at_slip, 1e-5, 1000.0)?;
                within("lubricant.traction.limit", limit, 0.0, 2.0)?;
                if maximum < at_rest || maximum < limit {
                    return Err(InvalidParameter::Inconsistent {
                        parameter: "lubricant.traction.maximum",
                        reason: format!(
                            "{maximum} must be at least the value at rest ({at_rest}) and the limit ({limit})"
                        ),
                    });
                }
                Ok(())
            }
            Self::SlideRoll { a, b, c, d } => {
                for (parameter, value) in
                    [("lubricant.traction.a", a), ("lubricant.traction.b", b), ("lubricant.traction.d", d)]
                {
                    within(parameter, value, -1e4, 1e4)?;
                }
                within("lubricant.traction.c", c, 0.0, 1e6)
            }
            Self::Eyring { stress, limit } => {
                above("lubricant.traction.stress", stress, 0.0, 1e9)?;
                within("lubricant.traction.limit", limit, 0.0, 2.0)
            }
            Self::Coulomb { coefficient, regularisation } => {
                within("lubricant.traction.coefficient", coefficient, 0.0, 2.0)?;
                within("lubricant.traction.regularisation", regularisation, 1e-5, 100.0)
            }
        }
    }
}

/// Slip speed below which a law that does not vanish at rest is made to [m/s].
const REST_SPEED: f64 = 1e-3;
/// Least rolling speed of the slide/roll ratio [m/s].
const LEAST_ROLLING: f64 = 0.1;
/// Largest growth of viscosity under pressure, as an exponent.
const LARGEST_PRESSURE_EXPONENT: f64 = 25.0;
/// Least film thickness of the Eyring law [m]: below it the surfaces' roughness carries.
const LEAST_FILM: f64 = 1e-9;

/// A traction law ready for use.
#[derive(Debug, Clone, Copy)]
pub struct Traction {
    law: TractionLaw,
    /// (A, B, C, D) of the exponential laws.
    exponential: [f64; 4],
    /// Squared speed of the regularisation at rest; 0 where the law vanishes there [m²/s²].
    rest: f64,
    viscosity: f64,
    pressure_viscosity: f64,
}

/// What a contact shares with all its strips. Laws that need none of it get zeros.
#[derive(Debug, Clone, Copy, Default)]
pub struct TractionContext {
    /// ū [m/s]
    pub rolling_speed: f64,
    /// p₀ [Pa]
    pub max_pressure: f64,
    /// [m]
    pub film_thickness: f64,
}

impl Traction {
    /// The law with the lubricant's viscosity [Pa s] and pressure–viscosity coefficient [1/Pa].
    pub fn new(law: &TractionLaw, viscosity: f64, pressure_viscosity: f64) -> Self {
        let exponential = match *law {
            TractionLaw::FourParameter { at_rest, maximum, at_slip, limit } => {
                four_parameters(at_rest, maximum, at_slip, limit)
            }
            TractionLaw::SlideRoll { a, b, c, d } => [a, b, c, d],
            TractionLaw::Eyring { .. } | TractionLaw::Coulomb { .. } => [0.0; 4],
        };
        let at_rest = exponential[0] + exponential[3];
        let rest = if at_rest.abs() > 1e-12 { REST_SPEED * REST_SPEED } else { 0.0 };
        Self { law: *law, exponential, rest, viscosity, pressure_viscosity }
    }

    /// Whether the law looks at rolling speed, pressure or film.
    #[inline(always)]
    pub fn needs_context(&self) -> bool {
        matches!(self.law, TractionLaw::SlideRoll { .. } | TractionLaw::Eyring { .. })
    }

    /// μ/|u| [s/m] at a squared slip speed u² [m²/s²], so that traction is this times the slip vector: no
    /// division and no direction at rest.
    #[inline(always)]
    pub fn over_speed(&self, squared_slip: f64, strip: &Strip, context: &TractionContext) -> f64 {
        let [a, b, c, d] = self.exponential;
        match self.law {
            TractionLaw::FourParameter { .. } => {
                let speed = squared_slip.sqrt();
                self.exponential_over_speed(speed, (a + b * speed) * (-c * speed).exp() + d)
            }
            TractionLaw::SlideRoll { .. } => {
                let speed = squared_slip.sqrt();
                let ratio = speed / context.rolling_speed.max(LEAST_ROLLING);
                self.exponential_over_speed(speed, (a + b * ratio) * (-c * ratio).exp() + d)
            }
            TractionLaw::Coulomb { coefficient, regularisation } => {
                let speed = squared_slip.sqrt();
                let x = speed / regularisation;
                coefficient / regularisation * if x < 1e-4 { 1.0 - x * x / 3.0 } else { x.tanh() / x }
            }
            TractionLaw::Eyring { stress, limit } => {
                let speed = squared_slip.sqrt();
                let pressure = strip.mean_pressure * context.max_pressure;
                let exponent = (self.pressure_viscosity * pressure).min(LARGEST_PRESSURE_EXPONENT);
                let rate = self.viscosity * exponent.exp() / (context.film_thickness.max(LEAST_FILM) * stress);
                let x = rate * speed;
                let shear = stress * if x < 1e-4 { rate } else { x.asinh() / speed };
                shear.min(limit * pressure / speed.max(1e-300)) / pressure.max(1.0)
            }
        }
    }

    #[inline(always)]
    fn exponential_over_speed(&self, speed: f64, coefficient: f64) -> f64 {
        if self.rest > 0.0 {
            return coefficient / (speed * speed + self.rest).sqrt();
        }
        // The law vanishes linearly at rest: μ → (B − A C) |u|, its slope scaled for the ratio law.
        if speed > 1e-9 { coefficient / speed } else { self.slope_at_rest() }
    }

    /// dμ/d|u| at rest [s/m] of the exponential laws; for the slide/roll law at the least rolling speed.
    fn slope_at_rest(&self) -> f64 {
        let [a, b, c, _] = self.exponential;
        let scale = if matches!(self.law, TractionLaw::SlideRoll { .. }) { 1.0 / LEAST_ROLLING } else { 1.0 };
        (b - a * c) * scale
    }

    /// Largest dμ/d|u| [s/m] near rest: what makes a scene stiff. 0 where it depends on the contact.
    pub fn steepness(&self) -> f64 {
        match self.law {
            TractionLaw::Coulomb { coefficient, regularisation } => coefficient / regularisation,
            TractionLaw::Eyring { .. } => 0.0,
            _ if self.rest > 0.0 => (self.exponential[0] + self.exponential[3]).abs() / REST_SPEED,
            _ => self.slope_at_rest().abs(),
        }
    }
}

/// A, B, C, D of μ = (A + B|u|) e^(−C|u|) + D from μ at rest, its maximum at a slip speed, and its limit:
/// A = μ₀ − μ_∞, D = μ_∞, dμ/du = 0 at u_m (B = C (A + B u_m)) and μ(u_m) = μ_max.
fn four_parameters(at_rest: f64, maximum: f64, at_slip: f64, limit: f64) -> [f64; 4] {
    let a = at_rest - limit;
    // With x = C u_m < 1: (A + B u_m) = A/(1 − x), so μ_max − μ_∞ = A e^(−x)/(1 − x) where A > 0. In general let
    // y = A + B u_m; then B u_m = x y, y = A + x y, and y e^(−x) = μ_max − μ_∞ is solved for x ≠ 1.
    let rise = maximum - limit;
    if rise <= 0.0 {
        // No maximum above the limit: a plain exponential approach to it, 99 % at u_m.
        return [a, 0.0, 100f64.ln() / at_slip, limit];
    }
    // f(x) = A − (1 − x) rise e^x rises from A − rise (≤ 0) at 0 without bound.
    let f = |x: f64| a - (1.0 - x) * rise * x.exp();
    let (mut low, mut high) = (0.0, 50.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    let x = 0.5 * (low + high);
    let peak = rise * x.exp();
    [a, (peak - a) / at_slip, x / at_slip, limit]
}

/// A strip of the contact ellipse along rolling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Strip {
    /// Centre of its load over the semi-major axis [-].
    pub place: f64,
    /// Share of the load [-].
    pub weight: f64,
    /// Mean pressure over the largest one [-].
    pub mean_pressure: f64,
}

/// Most strips of a contact.
pub const MAX_STRIPS: usize = 33;

/// Strips of equal width across the ellipse, and half of them (the middle one and one of each pair with
/// doubled weight) for contacts that are symmetric.
#[derive(Debug, Clone, Copy)]
pub struct Strips {
    all: [Strip; MAX_STRIPS],
    half: [Strip; MAX_STRIPS],
    count: usize,
}

impl Strips {
    /// `count` strips, odd and at most `MAX_STRIPS` (else rounded to that).
    pub fn new(count: usize) -> Self {
        let count = count.clamp(1, MAX_STRIPS) | 1;
        let mut strips = Self { all: [Strip::default(); MAX_STRIPS], half: [Strip::default(); MAX_STRIPS], count };
        for (k, strip) in strips.all[..count].iter_mut().enumerate() {
            let edge = |k: usize| 2.0 * k as f64 / count as f64 - 1.0;
            *strip = Strip::between(edge(k), edge(k + 1));
        }
        strips.half = strips.all;
        strips.half[..count / 2].iter_mut().for_each(|strip| strip.weight *= 2.0);
        strips.half[count / 2].place = 0.0;
        strips
    }

    #[inline(always)]
    pub fn all(&self) -> &[Strip] {
        &self.all[..self.count]
    }

    #[inline(always)]
    pub fn half(&self) -> &[Strip] {
        &self.half[..self.count / 2 + 1]
    }
}

impl Strip {
    /// The strip between two places t = η/a: the pressure of the semi-ellipsoid, integrated along rolling, is
    /// ¾ (1 − t²), so its load is ¾ (t − t³/3) and its moment ¾ (t²/2 − t⁴/4) between the edges.
    fn between(low: f64, high: f64) -> Self {
        let load = |t: f64| 0.75 * (t - t * t * t / 3.0);
        let moment = |t: f64| 0.75 * (0.5 * t * t - 0.25 * t.powi(4));
        let weight = load(high) - load(low);
        let place = (moment(high) - moment(low)) / weight;
        // Mean over the strip's chord: p₀ √(1−t²) · π/4.
        let mean_pressure = std::f64::consts::FRAC_PI_4 * (1.0 - place * place).max(0.0).sqrt();
        Self { place, weight, mean_pressure }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEFAULT: TractionLaw = TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.05, at_slip: 1.0, limit: 0.036 };

    /// The default law's constants: A −0.036, B 0.101781 s/m, C 1.547272 s/m, D 0.036, maximum 0.05 at 1 m/s.
    #[test]
    fn four_parameters_of_the_default_law() {
        let [a, b, c, d] = four_parameters(0.0, 0.05, 1.0, 0.036);
        assert!((a + 0.036).abs() < 1e-12 && (d - 0.036).abs() < 1e-12);
        assert!((b - 0.101_781).abs() < 1e-6 && (c - 1.547_272).abs() < 1e-6, "{b} {c}");
        let law = Traction::new(&DEFAULT, 0.0, 0.0);
        let at = |u: f64| law.over_speed(u * u, &Strip::default(), &TractionContext::default()) * u;
        assert!((at(1.0) - 0.05).abs() < 1e-12 && at(0.99) < at(1.0) && at(1.01) < at(1.0));
        assert!((at(50.0) - 0.036).abs() < 1e-12);
        assert!((at(1e-6) / 1e-6 - law.steepness()).abs() < 1e-6);
    }

    /// Without a maximum above the limit the law rises to it; with one at rest it is regularised there.
    #[test]
    fn degenerate_laws_stay_finite() {
        let flat = TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.05, at_slip: 0.001, limit: 0.05 };
        let law = Traction::new(&flat, 0.0, 0.0);
        let at = |law: &Traction, u: f64| law.over_speed(u * u, &Strip::default(), &TractionContext::default()) * u;
        assert!((at(&law, 0.001) / 0.05 - 0.99).abs() < 1e-9);
        let dry = TractionLaw::FourParameter { at_rest: 0.1, maximum: 0.1, at_slip: 1.0, limit: 0.05 };
        let law = Traction::new(&dry, 0.0, 0.0);
        assert_eq!(at(&law, 0.0), 0.0);
        assert!((at(&law, 0.1) - 0.1).abs() < 0.01);
    }

    #[test]
    fn every_law_is_smooth_at_rest() {
        let context = TractionContext { rolling_speed: 10.0, max_pressure: 2e9, film_thickness: 0.5e-6 };
        let strip = Strip::between(-0.1, 0.1);
        for law in [
            DEFAULT,
            TractionLaw::SlideRoll { a: -0.03, b: 5.0, c: 60.0, d: 0.03 },
            TractionLaw::Eyring { stress: 5e6, limit: 0.08 },
            TractionLaw::Coulomb { coefficient: 0.08, regularisation: 1e-3 },
        ] {
            let law = Traction::new(&law, 0.02, 2e-8);
            let at = |u: f64| law.over_speed(u * u, &strip, &context);
            assert!(at(0.0).is_finite());
            assert!((at(2e-9) / at(4e-9) - 1.0).abs() < 1e-3, "{law:?}: {} {}", at(2e-9), at(4e-9));
            assert!(at(100.0) * 100.0 < 0.2);
        }
    }

    #[test]
    fn weights_sum_to_one_and_pure_slip_gives_mu_q() {
        for count in [1, 9, 17, 33] {
            let strips = Strips::new(count);
            for some in [strips.all(), strips.half()] {
                assert!((some.iter().map(|strip| strip.weight).sum::<f64>() - 1.0).abs() < 1e-14);
            }
        }
    }

    /// Pure spin under Coulomb friction: moment 3/8 μ Q a, less what the middle strip cannot see.
    #[test]
    fn pure_spin_gives_three_eighths() {
        let moment = |count| Strips::new(count).all().iter().map(|s| s.weight * s.place.abs()).sum::<f64>();
        assert!((moment(9) - 0.375).abs() < 0.01 && (moment(33) - 0.375).abs() < 1e-3, "{}", moment(9));
    }

    /// Pure conformity: forward slip inside and backward slip outside ±0.3473 a carry the same load.
    #[test]
    fn no_slip_lines_of_pure_conformity() {
        let inside = Strip::between(-0.3473, 0.3473).weight;
        assert!((inside - 0.5).abs() < 1e-4, "{inside}");
    }
}
