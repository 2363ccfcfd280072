//! Dissipation in a contact.

use crate::numerics::lanes::{Real, larger, smaller};
use crate::numerics::roots::bracketed_root;
use crate::physics::limits::Faults;

/// Laws for the damping of an elastic contact `Q = K δ^1.5 (1 + χ δ̇)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DampingLaw {
    /// χ solved so that an impact at `at_speed` [m/s] returns exactly with `restitution` times its speed.
    Restitution {
        restitution: f64,
        at_speed: f64,
    },
    /// χ = 3 (1 − e) / (2 v₀), as published by Hunt & Crossley.
    HuntCrossley {
        restitution: f64,
        at_speed: f64,
    },
    /// χ = 3 (1 − e²) / (4 v₀), as published by Lankarani & Nikravesh.
    LankaraniNikravesh {
        restitution: f64,
        at_speed: f64,
    },
    /// χ = 8 (1 − e) / (5 e v₀), as published by Flores et al.
    Flores {
        restitution: f64,
        at_speed: f64,
    },
    /// A damper [N s/m] that fades in over the first 0.1 µm of penetration.
    Viscous {
        coefficient: f64,
    },
    None,
}

impl DampingLaw {
    /// χ and damper of the law, once a scene.
    pub fn resolve(&self) -> DampingFactor {
        let chi = match *self {
            Self::Restitution { restitution: e, at_speed: v } => impact_damping(e) / v,
            Self::HuntCrossley { restitution: e, at_speed: v } => 1.5 * (1.0 - e) / v,
            Self::LankaraniNikravesh { restitution: e, at_speed: v } => 0.75 * (1.0 - e * e) / v,
            Self::Flores { restitution: e, at_speed: v } => 1.6 * (1.0 - e) / (e * v),
            Self::Viscous { .. } | Self::None => 0.0,
        };
        let viscous = if let Self::Viscous { coefficient } = *self { coefficient } else { 0.0 };
        DampingFactor { chi, viscous }
    }

    /// Records values outside the limits; `path` names restitution, speed and coefficient in the faults.
    pub(crate) fn check(&self, path: [&'static str; 3], faults: &mut Faults) {
        match *self {
            Self::Restitution { restitution, at_speed }
            | Self::HuntCrossley { restitution, at_speed }
            | Self::LankaraniNikravesh { restitution, at_speed }
            | Self::Flores { restitution, at_speed } => {
                faults.check(path[0], restitution);
                faults.check(path[1], at_speed);
            }
            Self::Viscous { coefficient } => drop(faults.check(path[2], coefficient)),
            Self::None => {}
        }
    }
}

/// A damping law made ready for the time step: the load is K δ^1.5 (1 + χ δ̇) + c · ramp(δ) · δ̇.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DampingFactor {
    /// χ [s/m].
    pub chi: f64,
    /// Viscous damper `c` [N s/m].
    pub viscous: f64,
}

/// Penetration over which a viscous damper fades in, so that the load does not jump at contact [m].
const VISCOUS_RAMP: f64 = 0.1e-6;

/// Normal load `Q = K δ^1.5 (1 + χ δ̇) + c · ramp(δ/0.1 µm) · δ̇` [N] at penetration δ [m] and its rate [m/s];
/// 0 without penetration and never negative, for surfaces do not pull at each other.
///
/// Hunt & Crossley 1975 for the form; the ramp is 3s² − 2s³.
#[inline(always)]
pub fn normal_load(stiffness: f64, penetration: f64, rate: f64, damping: &DampingFactor) -> f64 {
    let depth = larger(penetration, 0.0);
    let viscous = damping.viscous * viscous_ramp(depth) * rate;
    let elastic = stiffness * depth * depth.sqrt();
    larger(elastic * (1.0 + damping.chi * rate) + viscous, 0.0)
}

/// How `normal_load` grows with the penetration [N/m] and with its rate [N s/m], neither below 0; the ramp of a viscous damper
/// is taken as it stands. Both 0 where there is no load.
#[inline(always)]
pub(crate) fn normal_slopes(stiffness: f64, penetration: f64, rate: f64, damping: &DampingFactor) -> (f64, f64) {
    let depth = larger(penetration, 0.0);
    let root = depth.sqrt();
    let elastic = stiffness * depth * root;
    let viscous = damping.viscous * viscous_ramp(depth);
    let grown = 1.0 + damping.chi * rate;
    let is_loaded = elastic * grown + viscous * rate > 0.0;
    let by_penetration = larger(1.5 * stiffness * root * grown, 0.0);
    let by_rate = elastic * damping.chi + viscous;
    (if is_loaded { by_penetration } else { 0.0 }, if is_loaded { by_rate } else { 0.0 })
}

/// Share of a viscous damper that acts at a depth [m], not negative.
#[inline(always)]
pub(crate) fn viscous_ramp<T: Real>(depth: T) -> T {
    let s = smaller(depth * T::of(1.0 / VISCOUS_RAMP), T::of(1.0));
    s * s * (T::of(3.0) - (s + s))
}

/// `c = χ v₀` with which an impact at v₀ on Q = K δ^1.5 (1 + χ δ̇) returns with e v₀ [-], 0 < e ≤ 1.
///
/// First integral of m v dv/dδ = −Q from (0, v₀) to (0, −e v₀): c (1 + e) = ln[(1 + c)/(1 − e c)]. The root besides c =
/// 0 lies in (0, 1/e). Independent of mass, stiffness and exponent of δ.
pub fn impact_damping(restitution: f64) -> f64 {
    let e = restitution;
    if e >= 1.0 {
        return 0.0;
    }
    // ln(1 + x) = x + x² q(x) turns the equation, divided by c², into q(c) = e² q(−e c).
    bracketed_root(|c| log_remainder(c) - e * e * log_remainder(-e * c), 0.0, 1.0 / e)
}

/// `(ln(1 + x) − x) / x²`, −½ at x = 0.
fn log_remainder(x: f64) -> f64 {
    if x.abs() > 0.02 {
        return (x.ln_1p() - x) / (x * x);
    }
    // −1/2 + x/3 − x²/4 + …, nine terms leave 1e−16 at |x| = 0.02.
    -(2..=10).rev().fold(0.0, |sum, n| f64::from(n).recip() - x * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed after an impact at `speed` of a mass on the contact, over `speed`: RK4 in time.
    fn simulated_restitution(damping: &DampingFactor, speed: f64) -> f64 {
        let (mass, stiffness) = (8.789e-5, 1.399e10);
        let duration = 2.9432 * f64::powf(5.0 * mass / (4.0 * stiffness), 0.4) * f64::powf(speed, -0.2);
        let h = duration / 20_000.0;
        let acceleration = |x: f64, v: f64| -normal_load(stiffness, x, v, damping) / mass;
        let (mut x, mut v) = (0.0_f64, speed);
        while x >= 0.0 {
            let (k1, l1) = (v, acceleration(x, v));
            let (k2, l2) = (v + 0.5 * h * l1, acceleration(x + 0.5 * h * k1, v + 0.5 * h * l1));
            let (k3, l3) = (v + 0.5 * h * l2, acceleration(x + 0.5 * h * k2, v + 0.5 * h * l2));
            let (k4, l4) = (v + h * l3, acceleration(x + h * k3, v + h * l3));
            x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        -v / speed
    }

    /// The definition of the law: an impact at v₀ returns e v₀; 1e-6, the error of the integration.
    #[test]
    fn impact_returns_the_restitution_asked_for() {
        for (restitution, at_speed) in [(0.98, 0.1), (0.9, 0.1), (0.6, 0.1), (0.5, 1.0), (0.2, 0.01), (0.05, 0.1)] {
            let damping = DampingLaw::Restitution { restitution, at_speed }.resolve();
            let returned = simulated_restitution(&damping, at_speed);
            assert!((returned - restitution).abs() < 1e-6, "{returned} instead of {restitution}");
        }
    }

    /// c (1 + e) = ln[(1 + c)/(1 − e c)] holds for the root, 1e-12; near e = 1 the leading term 3 (1 − e)/2.
    #[test]
    fn impact_damping_solves_its_equation() {
        for e in [0.98, 0.9, 0.6, 0.5, 0.2] {
            let c = impact_damping(e);
            assert!(c > 0.0 && (c * (1.0 + e) - ((1.0 + c) / (1.0 - e * c)).ln()).abs() < 1e-12);
        }
        assert_eq!(impact_damping(1.0), 0.0);
        assert!((impact_damping(1.0 - 1e-9) / 1.5e-9 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn only_the_viscous_law_has_a_damper() {
        let (restitution, at_speed) = (0.9, 0.1);
        for law in [
            DampingLaw::HuntCrossley { restitution, at_speed },
            DampingLaw::LankaraniNikravesh { restitution, at_speed },
            DampingLaw::Flores { restitution, at_speed },
            DampingLaw::Restitution { restitution, at_speed },
        ] {
            assert_eq!(law.resolve().viscous, 0.0);
        }
        let viscous = DampingLaw::Viscous { coefficient: 30.0 }.resolve();
        assert_eq!(viscous, DampingFactor { chi: 0.0, viscous: 30.0 });
        assert_eq!(DampingLaw::None.resolve(), DampingFactor::default());
    }

    /// No contact, no load; no pull however fast the bodies part; a viscous damper fades in without a jump.
    #[test]
    fn load_never_pulls_nor_jumps() {
        let damping = DampingFactor { chi: 1.665, viscous: 30.0 };
        assert_eq!(normal_load(1e10, 0.0, 5.0, &damping), 0.0);
        assert_eq!(normal_load(1e10, -1e-6, 5.0, &damping), 0.0);
        assert_eq!(normal_load(1e10, 1e-6, -50.0, &damping), 0.0);
        assert!(normal_load(1e10, 1e-12, 1.0, &damping) < 1e-6);
        let full = normal_load(1e10, VISCOUS_RAMP, 0.1, &damping) - normal_load(1e10, VISCOUS_RAMP, 0.0, &damping);
        let elastic = 1e10 * VISCOUS_RAMP.powf(1.5);
        assert!((full - (elastic * 0.1665 + 3.0)).abs() < 1e-9);
    }
}
