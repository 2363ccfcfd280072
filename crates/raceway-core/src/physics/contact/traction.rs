//! Traction of a lubricated contact with slip, spin and conformity.

use std::array::from_fn;

use crate::numerics::exponential::{binary_saturations, exponential, hyperbolic_tangent, inverse_hyperbolic_sine};
use crate::numerics::lanes::{larger, side_by_side, smaller};
use crate::numerics::roots::bracketed_root;
use crate::physics::limits::Faults;

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
    /// Records coefficients outside the limits.
    pub(crate) fn check(&self, faults: &mut Faults) {
        match *self {
            Self::FourParameter { at_rest, maximum, at_slip, limit } => {
                let coefficients = [
                    ("lubricant.traction.at_rest", at_rest),
                    ("lubricant.traction.maximum", maximum),
                    ("lubricant.traction.limit", limit),
                ];
                let are_inside = coefficients.map(|(parameter, value)| faults.check(parameter, value));
                faults.check("lubricant.traction.at_slip", at_slip);
                if are_inside == [true; 3] && (maximum < at_rest || maximum < limit) {
                    faults.inconsistent(
                        "lubricant.traction.maximum",
                        format!("{maximum} must be at least the value at rest ({at_rest}) and the limit ({limit})"),
                    );
                }
            }
            Self::SlideRoll { a, b, c, d } => {
                faults.check("lubricant.traction.a", a);
                faults.check("lubricant.traction.b", b);
                faults.check("lubricant.traction.c", c);
                faults.check("lubricant.traction.d", d);
            }
            Self::Eyring { stress, limit } => {
                faults.check("lubricant.traction.stress", stress);
                faults.check("lubricant.traction.limit", limit);
            }
            Self::Coulomb { coefficient, regularisation } => {
                faults.check("lubricant.traction.coefficient", coefficient);
                faults.check("lubricant.traction.regularisation", regularisation);
            }
        }
    }
}

/// Constants of μ(u) = (A + B u) e^(−C u) + D [-, s/m, s/m, -].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourParameters {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
}

/// Constants of the four-parameter law from μ at rest, its maximum, the slip where it is reached, and
/// its limit: A = μ₀ − μ_∞, D = μ_∞, and B, C from μ(u_m) = μ_max and μ'(u_m) = 0, C = B/(A + B u_m).
///
/// With x = C u_m both conditions become A = (μ_max − μ_∞) e^x (1 − x). A law whose maximum is its limit
/// reaches that only at infinity: it comes within a thousandth of A at u_m instead. A law whose maximum
/// is its value at rest falls from there as e^(−u/u_m).
pub(crate) fn four_parameters(at_rest: f64, maximum: f64, at_slip: f64, limit: f64) -> FourParameters {
    let (a, d) = (at_rest - limit, limit);
    let rise = (maximum - limit).max(1e-3 * a.abs());
    if a > 0.0 && rise <= a * (1.0 + 1e-9) {
        return FourParameters { a, b: 0.0, c: 1.0 / at_slip, d };
    }
    let x = if a == 0.0 {
        1.0
    } else {
        // x < 1 where μ falls from rest to its limit, x > 1 where it rises; the bracket holds the root.
        let (low, high) = if a > 0.0 { (0.0, 1.0) } else { (1.0, 1.0 - a / rise) };
        bracketed_root(|x| a * (-x).exp() - rise * (1.0 - x), low, high)
    };
    FourParameters { a, b: x * rise * x.exp() / at_slip, c: x / at_slip, d }
}

/// Inputs of a traction law besides slip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TractionContext<T = f64> {
    /// Mean rolling speed ū, a magnitude [m/s].
    pub rolling_speed: T,
    /// Mean pressure where the slip acts [Pa].
    pub pressure: T,
    /// Film thickness [m].
    pub film_thickness: T,
}
side_by_side!(TractionContext { rolling_speed, pressure, film_thickness });

/// A traction law prepared for the time step.
///
/// The force on a surface is `load · traction_over_speed(u², …) · slip vector`: no division, no branch on
/// rest and no jump there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Traction {
    /// (A + B u) e^(−C u) + D with A + D = 0.
    RisingFromZero(FourParameters),
    /// (A + B u) e^(−C u) + D with μ at rest.
    StickingAtRest(FourParameters),
    /// As `RisingFromZero`, over s = u / max(ū, 0.1 m/s).
    SlideRollFromZero(FourParameters),
    /// As `StickingAtRest`, over s = u / max(ū, 0.1 m/s).
    SlideRollAtRest(FourParameters),
    /// min(τ_E asinh(η(p) u / (h τ_E)), Λ p) / p, its slope at rest held below Λ/u_r.
    Eyring(Eyring),
    /// μ tanh(u / u_r).
    Coulomb(Coulomb),
}

/// Constants of the law of Eyring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eyring {
    /// [Pa]
    stress: f64,
    /// Largest τ/p [-].
    limit: f64,
    /// η₀ [Pa s].
    viscosity: f64,
    /// α_p [1/Pa].
    pressure_viscosity: f64,
    /// Largest α_p p, where the oil is a glass [-].
    largest_exponent: f64,
}

/// Constants of regularised dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb {
    coefficient: f64,
    /// 1 / u_r [s/m].
    per_regularisation: f64,
}

/// Slip speed u_r over which a law that does not vanish at rest turns its direction [m/s].
const DIRECTION_SPEED: f64 = 1e-3;
/// Smallest rolling speed to which slip is related by the slide/roll law [m/s].
const MIN_ROLLING_SPEED: f64 = 0.1;
/// Viscosity at which a liquid counts as a glass, the usual definition of the glass transition [Pa s].
const GLASS_VISCOSITY: f64 = 1e12;
/// A film thinner than a molecule is none [m].
const MIN_FILM: f64 = 1e-9;
/// Stands in for a slip of 0, or its square, where a quotient with a limit is formed.
pub(crate) const TINY: f64 = 1e-150;

impl Traction {
    /// Prepares a law for a lubricant of viscosity η₀ [Pa s] and pressure–viscosity coefficient α_p [1/Pa].
    pub fn new(law: &TractionLaw, viscosity: f64, pressure_viscosity: f64) -> Self {
        match *law {
            TractionLaw::FourParameter { at_rest, maximum, at_slip, limit } => {
                let parameters = four_parameters(at_rest, maximum, at_slip, limit);
                if at_rest == 0.0 { Self::RisingFromZero(parameters) } else { Self::StickingAtRest(parameters) }
            }
            TractionLaw::SlideRoll { a, b, c, d } => {
                let parameters = FourParameters { a, b, c, d };
                if a + d == 0.0 { Self::SlideRollFromZero(parameters) } else { Self::SlideRollAtRest(parameters) }
            }
            TractionLaw::Eyring { stress, limit } => Self::Eyring(Eyring {
                stress,
                limit,
                viscosity,
                pressure_viscosity,
                largest_exponent: (GLASS_VISCOSITY / viscosity.max(1e-9)).ln(),
            }),
            TractionLaw::Coulomb { coefficient, regularisation } => {
                Self::Coulomb(Coulomb { coefficient, per_regularisation: 1.0 / regularisation })
            }
        }
    }

    /// True where `coefficient` reads rolling speed, pressure or film thickness.
    pub(crate) fn needs_context(&self) -> bool {
        match self {
            Self::RisingFromZero(_) | Self::StickingAtRest(_) | Self::Coulomb(_) => false,
            Self::SlideRollFromZero(_) | Self::SlideRollAtRest(_) | Self::Eyring(_) => true,
        }
    }

    /// μ(|u|)/|u| [s/m] from the square of the slip speed [m²/s²]; finite at rest.
    pub fn traction_over_speed(&self, slip_squared: f64, context: &TractionContext) -> f64 {
        match self {
            Self::RisingFromZero(law) => rising(law, [slip_squared + TINY])[0],
            Self::StickingAtRest(law) => sticking(law, slip_squared.sqrt(), slip_squared),
            Self::SlideRollFromZero(law) => rolling(law, slip_squared, context),
            Self::SlideRollAtRest(law) => rolling_at_rest(law, slip_squared, context),
            Self::Eyring(law) => eyring(law, slip_squared, context),
            Self::Coulomb(law) => coulomb(law, slip_squared),
        }
    }

    /// Traction coefficient μ(u) with the sign of the slip speed [-].
    #[cfg(test)]
    fn coefficient(&self, slip_speed: f64, context: &TractionContext) -> f64 {
        self.traction_over_speed(slip_speed * slip_speed, context) * slip_speed
    }
}

/// μ/s of the four-parameter law with A = −D, from s² > 0, at several places: D (1 − e^(−C s))/s + B e^(−C s), which keeps its
/// digits down to s = 0.
#[inline(always)]
pub(crate) fn rising<const S: usize>(law: &FourParameters, squares: [f64; S]) -> [f64; S] {
    let s: [f64; S] = from_fn(|k| squares[k].sqrt());
    let per_s: [f64; S] = from_fn(|k| 1.0 / s[k]);
    let binary = law.c * std::f64::consts::LOG2_E;
    let x: [f64; S] = from_fn(|k| binary * s[k]);
    let (saturation, decay) = binary_saturations(x);
    from_fn(|k| law.d * per_s[k] * saturation[k] + law.b * decay[k])
}

/// μ/√(u² + u_r²) of the four-parameter law that does not vanish at rest, s its argument.
#[inline(always)]
pub(crate) fn sticking(law: &FourParameters, s: f64, slip_squared: f64) -> f64 {
    let mu = (law.a + law.b * s) * exponential(-law.c * s) + law.d;
    mu / (slip_squared + DIRECTION_SPEED * DIRECTION_SPEED).sqrt()
}

/// μ/|u| of `rising` over the slide/roll ratio.
#[inline(always)]
pub(crate) fn rolling(law: &FourParameters, slip_squared: f64, context: &TractionContext) -> f64 {
    let per_rolling = 1.0 / larger(context.rolling_speed, MIN_ROLLING_SPEED);
    per_rolling * rising(law, [per_rolling * per_rolling * slip_squared + TINY])[0]
}

/// μ/|u| of `sticking` over the slide/roll ratio.
#[inline(always)]
pub(crate) fn rolling_at_rest(law: &FourParameters, slip_squared: f64, context: &TractionContext) -> f64 {
    let per_rolling = 1.0 / larger(context.rolling_speed, MIN_ROLLING_SPEED);
    sticking(law, per_rolling * slip_squared.sqrt(), slip_squared)
}

/// μ/|u| of the law of Eyring. 1 GPa makes oil so stiff that τ would turn within 1e-10 m/s: no steeper than Λ/u_r.
#[inline(always)]
pub(crate) fn eyring(law: &Eyring, slip_squared: f64, context: &TractionContext) -> f64 {
    let slip = larger(slip_squared.sqrt(), TINY);
    let pressure = larger(context.pressure, 1.0);
    let viscosity = law.viscosity * exponential(smaller(law.pressure_viscosity * pressure, law.largest_exponent));
    let rate = viscosity / (larger(context.film_thickness, MIN_FILM) * law.stress);
    let coefficient = smaller((law.stress / pressure) * inverse_hyperbolic_sine(rate * slip), law.limit);
    let (softness, softest) = (slip / coefficient, DIRECTION_SPEED / law.limit);
    1.0 / (softness * softness + softest * softest).sqrt()
}

/// μ/|u| of regularised dry friction.
#[inline(always)]
pub fn coulomb(law: &Coulomb, slip_squared: f64) -> f64 {
    let slip = larger(slip_squared.sqrt(), TINY);
    law.coefficient * hyperbolic_tangent(slip * law.per_regularisation) / slip
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::strips::{Strips, load_share_below};

    const CONTEXT: TractionContext = TractionContext { rolling_speed: 14.0, pressure: 1.5e9, film_thickness: 0.5e-6 };
    const ARTICLE_LAW: TractionLaw =
        TractionLaw::FourParameter { at_rest: 0.0, maximum: 0.05, at_slip: 1.0, limit: 0.036 };

    fn every_law() -> [Traction; 7] {
        [
            ARTICLE_LAW,
            TractionLaw::FourParameter { at_rest: 0.1, maximum: 0.12, at_slip: 0.5, limit: 0.04 },
            TractionLaw::FourParameter { at_rest: 0.02, maximum: 0.06, at_slip: 0.5, limit: 0.04 },
            TractionLaw::SlideRoll { a: -0.036, b: 1.4, c: 20.0, d: 0.036 },
            TractionLaw::SlideRoll { a: 0.01, b: 1.4, c: 20.0, d: 0.036 },
            TractionLaw::Eyring { stress: 5e6, limit: 0.08 },
            TractionLaw::Coulomb { coefficient: 0.08, regularisation: 0.01 },
        ]
        .map(|law| Traction::new(&law, 0.02, 2e-8))
    }

    /// μ₀ 0, μ_max 0.05 at 1 m/s, μ_∞ 0.036 give A −0.036, B 0.101781, C 1.547272 (six decimals).
    #[test]
    fn default_law_has_its_constants() {
        let FourParameters { a, b, c, d } = four_parameters(0.0, 0.05, 1.0, 0.036);
        for (value, expected) in [(a, -0.036), (b, 0.101_781), (c, 1.547_272), (d, 0.036)] {
            assert!((value - expected).abs() < 1e-6, "{value} against {expected}");
        }
    }

    /// Definition of the law: μ at rest, maximum with a horizontal tangent at u_m, limit at high slip; 1e-9.
    #[test]
    fn four_parameters_meet_their_conditions() {
        for (at_rest, maximum, at_slip, limit) in [
            (0.0, 0.05, 1.0, 0.036),
            (0.1, 0.12, 0.5, 0.04),
            (0.02, 0.06, 3.0, 0.04),
            (0.04, 0.06, 0.2, 0.04),
            (0.0, 0.1, 1.0, 0.0),
            (0.0, 0.0501, 1e-3, 0.05),
        ] {
            let p = four_parameters(at_rest, maximum, at_slip, limit);
            let mu = |u: f64| (p.a + p.b * u) * (-p.c * u).exp() + p.d;
            assert!((mu(0.0) - at_rest).abs() < 1e-9 && (mu(at_slip) - maximum).abs() < 1e-9);
            assert!((p.b - p.c * (p.a + p.b * at_slip)).abs() * at_slip < 1e-9);
            assert!((mu(200.0 * at_slip) - limit).abs() < 1e-9);
            assert!((1..400).all(|i| mu(f64::from(i) * 0.01 * at_slip) <= maximum + 1e-12));
        }
    }

    /// Maxima that no finite slip reaches still give a bounded law.
    #[test]
    fn degenerate_maxima_stay_bounded() {
        for (at_rest, maximum, limit) in [(0.0, 0.05, 0.05), (0.08, 0.08, 0.03), (0.05, 0.05, 0.05), (0.0, 0.0, 0.0)] {
            let p = four_parameters(at_rest, maximum, 1.0, limit);
            let mu = |u: f64| (p.a + p.b * u) * (-p.c * u).exp() + p.d;
            assert!((mu(0.0) - at_rest).abs() < 1e-12 && (mu(500.0) - limit).abs() < 1e-9);
            assert!((0..900).all(|i| mu(f64::from(i) * 0.01) <= maximum * 1.0011 + 1e-12));
        }
    }

    /// Each law is odd, has one slope through u = 0 from both sides, and never divides by it.
    #[test]
    fn laws_are_smooth_and_odd_at_rest() {
        for law in every_law() {
            let at_rest = law.traction_over_speed(0.0, &CONTEXT);
            assert!(at_rest.is_finite() && at_rest > 0.0);
            assert_eq!(law.coefficient(0.0, &CONTEXT), 0.0);
            for u in [1e-9, 1e-6] {
                assert!((law.traction_over_speed(u * u, &CONTEXT) / at_rest - 1.0).abs() < 2e-3);
                assert_eq!(law.coefficient(-u, &CONTEXT), -law.coefficient(u, &CONTEXT));
            }
        }
    }

    /// The quotient μ/u joins its series without a step, 1e-10.
    #[test]
    fn quotient_has_no_step_at_its_series() {
        let law = Traction::new(&ARTICLE_LAW, 0.02, 2e-8);
        let at = 0.01 / 1.547_271_9;
        let (below, above) = (at * (1.0 - 1e-9), at * (1.0 + 1e-9));
        let ratio = law.coefficient(above, &CONTEXT) / law.coefficient(below, &CONTEXT);
        assert!((ratio - 1.0 - 2e-9).abs() < 1e-10);
        assert!((law.coefficient(1.0, &CONTEXT) - 0.05).abs() < 1e-12);
    }

    /// Eyring: Newtonian η(p) u / (h p) at low slip, τ_E asinh above, at most Λ; the exponent stops at the glass.
    #[test]
    fn eyring_law_has_its_limits() {
        let thick = TractionContext { pressure: 0.2e9, film_thickness: 1e-6, rolling_speed: 10.0 };
        let law = Traction::new(&TractionLaw::Eyring { stress: 5e6, limit: 0.08 }, 0.02, 2e-8);
        let newtonian = 0.02 * f64::exp(4.0) / (1e-6 * 0.2e9);
        assert!((law.traction_over_speed(1e-12, &thick) / newtonian - 1.0).abs() < 1e-6);
        let sheared = 5e6 * f64::asinh(newtonian * 0.2e9 * 5.0 / 5e6) / 0.2e9;
        assert!((law.coefficient(5.0, &thick) - sheared).abs() < 1e-8);
        let glassy = 5e6 / 1.5e9 * (0.02 * 30f64.exp() * 50.0 / 2.5).asinh();
        assert!((law.coefficient(50.0, &CONTEXT) - glassy.min(0.08)).abs() < 1e-9);
        assert!((law.traction_over_speed(0.0, &CONTEXT) / (0.08 / DIRECTION_SPEED) - 1.0).abs() < 1e-6);
        let tight = TractionContext { pressure: 1e12, film_thickness: 0.0, rolling_speed: 0.0 };
        assert!(law.coefficient(1.0, &tight).is_finite());
        assert!(law.traction_over_speed(0.0, &TractionContext::default()).is_finite());
        let dry = Traction::new(&TractionLaw::Eyring { stress: 5e6, limit: 0.08 }, 0.0, 2e-8);
        assert_eq!(dry.coefficient(1.0, &tight), 0.0);
    }

    /// Pure slip gives μ Q with any number of strips, to rounding.
    #[test]
    fn pure_slip_gives_coulomb() {
        let law = Traction::new(&TractionLaw::Coulomb { coefficient: 0.08, regularisation: 1e-5 }, 0.0, 0.0);
        for count in [1, 2, 9, 33] {
            let force: f64 =
                Strips::new(count).as_slice().iter().map(|s| s.weight * law.coefficient(1.0, &CONTEXT)).sum();
            assert!((force - 0.08).abs() < 1e-14);
        }
    }

    /// Pure spin with Coulomb friction: ⅜ μ Q a along the major axis (closed integral). Exact for an even
    /// count; an odd one loses its middle strip, ¾/n² of the load times lever.
    #[test]
    fn pure_spin_gives_three_eighths() {
        let law = Traction::new(&TractionLaw::Coulomb { coefficient: 0.08, regularisation: 1e-5 }, 0.0, 0.0);
        let moment = |count| -> f64 {
            let strips = Strips::new(count);
            strips.as_slice().iter().map(|s| s.weight * s.position * law.coefficient(10.0 * s.position, &CONTEXT)).sum()
        };
        for count in [2, 8, 32] {
            assert!((moment(count) / (0.08 * 0.375) - 1.0).abs() < 1e-12);
        }
        for count in [9, 33] {
            let n = count as f64;
            let expected = 0.375 - 0.75 / (n * n) * (1.0 - 0.5 / (n * n));
            assert!((moment(count) / 0.08 - expected).abs() < 1e-12);
        }
    }

    /// Pure conformity: the lines of no slip at ±t₀ divide the load in halves, ¾(t₀ − t₀³/3) = ¼, t₀ = 0.3473 (four
    /// figures). Strips find t₀ within half their width.
    #[test]
    fn conformity_slips_nowhere_at_its_two_lines() {
        let exact = bracketed_root(|t| load_share_below(t) - 0.75, 0.0, 1.0);
        assert!((exact - 0.3473).abs() < 5e-5);
        let law = Traction::new(&TractionLaw::Coulomb { coefficient: 0.08, regularisation: 1e-2 }, 0.0, 0.0);
        for count in [9, 33] {
            let strips = Strips::new(count);
            let force = |line: f64| -> f64 {
                let slip = |t: f64| t * t - line * line;
                strips.as_slice().iter().map(|s| s.weight * law.coefficient(slip(s.position), &CONTEXT)).sum()
            };
            let line = bracketed_root(force, 0.0, 1.0);
            assert!((line - exact).abs() < 1.0 / count as f64, "{line}");
        }
    }
}
