//! Equivalent load and basic rating life, ISO 281.

use super::factors::{AxialFactors, axial_factors};
use super::ratings::Ratings;

/// Dynamic equivalent load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquivalentLoad {
    /// P [N].
    pub load: f64,
    pub factors: AxialFactors,
    /// True if the axial load counts: F_a/F_r is beyond e.
    pub counts_axial: bool,
}

/// P = F_r up to F_a/F_r = e, else X F_r + Y F_a, at a free contact angle [rad] under magnitudes of the radial and the axial load [N].
pub fn equivalent_load(ratings: &Ratings, contact_angle: f64, radial: f64, axial: f64) -> EquivalentLoad {
    let factors = axial_factors(contact_angle, ratings.static_factor * axial / ratings.statical);
    let counts_axial = axial > factors.limit * radial;
    let load = if counts_axial { factors.radial * radial + factors.axial * axial } else { radial };
    EquivalentLoad { load, factors, counts_axial }
}

/// L₁₀ = (C/P)³ [10⁶ turns].
pub fn basic_life(dynamic_rating: f64, equivalent_load: f64) -> f64 {
    (dynamic_rating / equivalent_load).powi(3)
}

/// Hours of a life [10⁶ turns] at a speed of one ring relative to the other [rad/s].
pub fn hours(million_turns: f64, speed: f64) -> f64 {
    million_turns * 1e6 * std::f64::consts::TAU / (3600.0 * speed.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One revolution per minute [rad/s].
    const RPM: f64 = std::f64::consts::TAU / 60.0;
    const OF_6205: Ratings = Ratings { dynamic: 14e3, statical: 7850.0, static_factor: 13.9 };

    fn assert_rounds(value: f64, expected: f64, half_digit: f64) {
        assert!((value - expected).abs() <= half_digit, "{value} instead of {expected}");
    }

    /// 6205 with the printed ratings under 500 N and 200 N at 3000 r/min.
    #[test]
    fn life_of_the_6205() {
        let of = equivalent_load(&OF_6205, 0.0, 500.0, 200.0);
        assert_rounds(of.factors.limit, 0.2211, 5e-5);
        assert_rounds(of.factors.axial, 1.983, 5e-4);
        assert_rounds(of.load, 676.5, 0.05);
        assert_rounds(hours(basic_life(14e3, of.load), 3000.0 * RPM), 49_236.0, 0.5);
    }

    /// A calculator report prints 24 500 h of the 6309 at 4 kN and 1800 r/min.
    #[test]
    fn life_of_the_6309() {
        assert_rounds(hours(basic_life(55.3e3, 4e3), 1800.0 * RPM), 24_466.0, 0.5);
    }

    #[test]
    fn the_radial_load_alone_counts_up_to_e() {
        let of = equivalent_load(&OF_6205, 0.0, 1000.0, 100.0);
        assert!(!of.counts_axial && of.load == 1000.0);
        let of = equivalent_load(&OF_6205, 0.0, 0.0, 100.0);
        assert!(of.counts_axial && of.load == of.factors.axial * 100.0);
        assert_eq!(equivalent_load(&OF_6205, 0.0, 0.0, 0.0).load, 0.0);
    }
}
