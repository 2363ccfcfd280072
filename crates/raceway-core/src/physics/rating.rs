//! Basic dynamic load rating.

use super::bearing::Bearing;

/// Largest groove curvature of inner and outer raceway for which the table of f_c is meant [-].
const TABLE_CURVATURE: [f64; 2] = [0.52, 0.53];

/// f_c over γ, ISO 281:2007, table 2 (single-row radial and angular-contact ball bearings).
const TABLE: [(f64, f64); 25] = [
    (0.01, 29.1),
    (0.02, 35.8),
    (0.03, 40.3),
    (0.04, 43.8),
    (0.05, 46.7),
    (0.06, 49.1),
    (0.07, 51.1),
    (0.08, 52.8),
    (0.09, 54.3),
    (0.10, 55.5),
    (0.12, 57.5),
    (0.14, 58.8),
    (0.16, 59.6),
    (0.18, 59.9),
    (0.20, 59.9),
    (0.22, 59.6),
    (0.24, 59.0),
    (0.26, 58.2),
    (0.28, 57.1),
    (0.30, 56.0),
    (0.32, 54.6),
    (0.34, 53.2),
    (0.36, 51.7),
    (0.38, 50.0),
    (0.40, 48.4),
];

/// Rating factor of contemporary, good material and manufacture for radial and angular-contact ball
/// bearings, b_m, ISO 281:2007, table 1 [-].
const MATERIAL_FACTOR: f64 = 1.3;

/// Basic dynamic radial load rating `C` [N] with f_c from the table: the reference.
///
/// ISO 281:2007, eqs. (1), (2): C = 1.3 f_c (cos α)^0.7 Z^(2/3) d^1.8, d in mm; above 25.4 mm 3.647 d^1.4. It
/// overestimates C for grooves wider than `TABLE_CURVATURE`, see `table_applies`.
pub fn dynamic_load_rating(bearing: &Bearing) -> f64 {
    rating(bearing, table_factor(bearing.gamma()))
}

/// Basic dynamic radial load rating `C` [N] with f_c from the formula behind the table, for any groove.
pub fn dynamic_load_rating_full_formula(bearing: &Bearing) -> f64 {
    let f = bearing.parameters.groove_curvature;
    rating(bearing, full_factor(bearing.gamma(), f.inner, f.outer))
}

/// Returns true where groove curvatures and γ lie within the table of f_c.
pub fn table_applies(bearing: &Bearing) -> bool {
    let (f, gamma) = (bearing.parameters.groove_curvature, bearing.gamma());
    f.inner <= TABLE_CURVATURE[0]
        && f.outer <= TABLE_CURVATURE[1]
        && (TABLE[0].0..=TABLE[TABLE.len() - 1].0).contains(&gamma)
}

/// f_c from the table, linear between its lines [N, mm]; outside, the formula behind it.
fn table_factor(gamma: f64) -> f64 {
    TABLE.windows(2).find(|pair| (pair[0].0..=pair[1].0).contains(&gamma)).map_or_else(
        || full_factor(gamma, TABLE_CURVATURE[0], TABLE_CURVATURE[0]),
        |pair| {
            let share = (gamma - pair[0].0) / (pair[1].0 - pair[0].0);
            pair[0].1 + share * (pair[1].1 - pair[0].1)
        },
    )
}

/// f_c of any pair of groove curvatures [N, mm].
///
/// Lundberg & Palmgren 1947 (Harris & Kotzalas, ch. 11): f_c = 38.2 {1 + [1.04 ((1−γ)/(1+γ))^1.72
/// ((f_i/f_e)(2f_e−1)/(2f_i−1))^0.41]^(10/3)}^(−0.3) · γ^0.3 (1−γ)^1.39 (1+γ)^(−1/3) (2f_i/(2f_i−1))^0.41. Differs from
/// the source: Harris has 39.9 before a reduction factor for the accuracy of the raceways. With f = 0.52 the whole
/// table of ISO 281 is 38.2 times the rest to 0.2 %, and 38.2 is 0.95 · 0.41 · 98.0665.
fn full_factor(gamma: f64, inner_curvature: f64, outer_curvature: f64) -> f64 {
    let (fi, fe) = (inner_curvature, outer_curvature);
    let conformity = ((fi / fe) * (2.0 * fe - 1.0) / (2.0 * fi - 1.0)).powf(0.41);
    let rings = 1.04 * ((1.0 - gamma) / (1.0 + gamma)).powf(1.72) * conformity;
    let shape = gamma.powf(0.3) * (1.0 - gamma).powf(1.39) / (1.0 + gamma).cbrt();
    38.2 * (1.0 + rings.powf(10.0 / 3.0)).powf(-0.3) * shape * (2.0 * fi / (2.0 * fi - 1.0)).powf(0.41)
}

/// C of a factor f_c [N].
fn rating(bearing: &Bearing, factor: f64) -> f64 {
    let p = &bearing.parameters;
    let diameter = p.ball_diameter * 1e3;
    let size = if diameter <= 25.4 { diameter.powf(1.8) } else { 3.647 * diameter.powf(1.4) };
    let balls = (p.ball_count as f64).powf(2.0 / 3.0);
    MATERIAL_FACTOR * factor * bearing.kinematic_contact_angle().cos().powf(0.7) * balls * size
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::examples::{article_bearing, deep_groove};

    /// The formula with f = 0.52 is the table, line by line, to its rounding (0.2 %).
    #[test]
    fn table_is_the_formula_of_its_curvature() {
        for (gamma, factor) in TABLE {
            assert!((full_factor(gamma, 0.52, 0.52) / factor - 1.0).abs() < 2e-3, "γ = {gamma}");
            assert!((table_factor(gamma) - factor).abs() < 1e-12);
        }
        assert!((table_factor(0.13) - 58.15).abs() < 1e-9);
        assert!(table_factor(0.005) < 29.1 && table_factor(0.45) < 48.4);
    }

    /// Article's bearing: C is 1786 N from the table. With its own grooves f_c is about 51.3 and C 1.53 kN, with a
    /// constant of 0.95 · 39.9 (1.5 %).
    #[test]
    fn article_bearing_has_two_ratings() {
        let bearing = article_bearing();
        assert!(!table_applies(&bearing));
        assert!((dynamic_load_rating(&bearing) - 1786.0).abs() < 2.0);
        assert!((full_factor(bearing.gamma(), 0.529, 0.529) / 51.3 - 1.0).abs() < 0.015);
        assert!((dynamic_load_rating_full_formula(&bearing) / 1530.0 - 1.0).abs() < 0.015);
    }

    /// Large balls count less, without a step at 25.4 mm (ISO 281 chose 3.647 so), 0.1 %.
    #[test]
    fn rating_is_continuous_at_one_inch() {
        let at = |d: f64| dynamic_load_rating(&deep_groove(8, d, 120.0, [0.52, 0.53], 5e-6, 206e9));
        assert!((at(25.4001) / at(25.4) - 1.0).abs() < 1e-3);
    }
}
