//! Dissipation in a contact.

use crate::physics::{InvalidParameter, within};

/// Laws for the damping of an elastic contact `Q = K δ^1.5 (1 + χ δ̇)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DampingLaw {
    /// χ solved so that an impact at `at_speed` [m/s] really returns with `restitution` times its speed.
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
    /// Refuses what no contact has; `path` names restitution, speed and coefficient in the error.
    pub fn check(&self, path: [&'static str; 3]) -> Result<(), InvalidParameter> {
        match *self {
            Self::Restitution { restitution, at_speed }
            | Self::HuntCrossley { restitution, at_speed }
            | Self::LankaraniNikravesh { restitution, at_speed }
            | Self::Flores { restitution, at_speed } => {
                within(path[0], restitution, 0.05, 1.0)?;
                within(path[1], at_speed, 1e-6, 100.0)
            }
            Self::Viscous { coefficient } => within(path[2], coefficient, 0.0, 1e9),
            Self::None => Ok(()),
        }
    }
}

impl DampingLaw {
    /// The law with its constant solved.
    pub fn resolve(&self) -> DampingFactor {
        let (chi, viscous) = match *self {
            Self::Restitution { restitution, at_speed } => (restitution_constant(restitution) / at_speed, 0.0),
            Self::HuntCrossley { restitution, at_speed } => (1.5 * (1.0 - restitution) / at_speed, 0.0),
            Self::LankaraniNikravesh { restitution, at_speed } => {
                (0.75 * (1.0 - restitution * restitution) / at_speed, 0.0)
            }
            Self::Flores { restitution, at_speed } => (1.6 * (1.0 - restitution) / (restitution * at_speed), 0.0),
            Self::Viscous { coefficient } => (0.0, coefficient),
            Self::None => (0.0, 0.0),
        };
        DampingFactor { chi, viscous }
    }
}

/// A damping law ready for use.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DampingFactor {
    /// χ [s/m]
    pub chi: f64,
    /// [N s/m]
    pub viscous: f64,
}

/// Penetration over which a constant damper fades in [m]; else the force would jump at contact.
const VISCOUS_ONSET: f64 = 0.1e-6;

/// Normal load Q = K δ^1.5 (1 + χ δ̇) + c ramp(δ) δ̇ [N] of a penetration δ [m] and its rate [m/s]; never below 0.
#[inline(always)]
pub fn normal_load(stiffness: f64, penetration: f64, rate: f64, damping: &DampingFactor) -> f64 {
    let depth = penetration.max(0.0);
    let elastic = stiffness * depth * depth.sqrt();
    let mut load = elastic * (1.0 + damping.chi * rate);
    if damping.viscous > 0.0 {
        let share = (depth / VISCOUS_ONSET).min(1.0);
        load += damping.viscous * share * share * (3.0 - 2.0 * share) * rate;
    }
    load.max(0.0)
}

/// c = χ v₀ with which an impact at v₀ returns with e v₀: solves c (1 + e) = ln[(1 + c)/(1 − e c)] for 0 < c < 1/e.
///
/// From the exact first integral of m δ̈ = −K δ^1.5 (1 + χ δ̇). 0 for e = 1.
fn restitution_constant(restitution: f64) -> f64 {
    let e = restitution;
    // Negative below the root, positive above it; c = 0 is a double root that the lower end avoids.
    let excess = |c: f64| ((1.0 + c) / (1.0 - e * c)).ln() - c * (1.0 + e);
    let (mut low, mut high) = (1e-9, (1.0 - 1e-15) / e);
    if excess(low) >= 0.0 {
        return 0.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed at which a mass leaves after an impact at `speed`, by direct integration.
    fn rebound(stiffness: f64, mass: f64, speed: f64, damping: &DampingFactor) -> f64 {
        let time = 2.9432 * (1.25 * mass / stiffness).powf(0.4) * speed.powf(-0.2);
        let step = time / 400_000.0;
        let (mut x, mut v) = (0.0_f64, speed);
        loop {
            // Midpoint rule.
            let a = -normal_load(stiffness, x, v, damping) / mass;
            let (xm, vm) = (x + 0.5 * step * v, v + 0.5 * step * a);
            v -= step * normal_load(stiffness, xm, vm, damping) / mass;
            x += step * vm;
            if x < 0.0 {
                return -v;
            }
        }
    }

    /// Solved by hand from the impact's first integral: e 0.9 → 0.1665, 0.6 → 0.975, 0.5 → 1.433, 1 → 0.
    #[test]
    fn restitution_constants() {
        for (e, c) in [(0.9, 0.1665), (0.6, 0.975), (0.5, 1.433), (1.0, 0.0)] {
            assert!((restitution_constant(e) - c).abs() < 6e-4, "{e}: {}", restitution_constant(e));
        }
    }

    #[test]
    fn an_impact_returns_with_the_restitution_asked_for() {
        for e in [0.9, 0.6, 0.3] {
            let damping = DampingLaw::Restitution { restitution: e, at_speed: 0.1 }.resolve();
            let returned = rebound(1.4e10, 8.8e-5, 0.1, &damping) / 0.1;
            assert!((returned - e).abs() < 2e-4, "{e}: {returned}");
        }
    }

    /// Published approximations at e 0.9, 0.1 m/s: χ 1.5, 1.425 and 1.778 s/m.
    #[test]
    fn published_laws_by_name() {
        let (restitution, at_speed) = (0.9, 0.1);
        let chi = |law: DampingLaw| law.resolve().chi;
        assert!((chi(DampingLaw::HuntCrossley { restitution, at_speed }) - 1.5).abs() < 1e-12);
        assert!((chi(DampingLaw::LankaraniNikravesh { restitution, at_speed }) - 1.425).abs() < 1e-12);
        assert!((chi(DampingLaw::Flores { restitution, at_speed }) - 1.778).abs() < 1e-3);
    }

    /// No jump at touch, no pull on leaving.
    #[test]
    fn load_starts_at_zero_and_never_pulls() {
        let viscous = DampingLaw::Viscous { coefficient: 1000.0 }.resolve();
        assert!(normal_load(1e10, 1e-12, 1.0, &viscous) < 1e-3);
        assert_eq!(normal_load(1e10, 1e-6, -1e3, &viscous), 0.0);
        assert_eq!(normal_load(1e10, -1e-6, 1.0, &viscous), 0.0);
    }
}
