//! Factors of ISO 76 and ISO 281, from `data/rating-factors.csv`, linear between its lines.

use std::sync::LazyLock;

const FILE: &str = include_str!("../../../data/rating-factors.csv");

/// Factors of the equivalent load of a single-row bearing [-].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxialFactors {
    /// Axial over radial load up to which the radial load alone counts.
    pub limit: f64,
    /// X
    pub radial: f64,
    /// Y
    pub axial: f64,
}

/// Lines of one contact angle: over f₀ F_a/C₀r, or a single one.
struct OfAngle {
    /// [°]
    angle: f64,
    lines: Vec<(f64, [f64; 3])>,
}

struct Tables {
    /// f₀ over γ.
    of_static_rating: Vec<(f64, [f64; 1])>,
    of_equivalent_load: Vec<OfAngle>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let mut tables = Tables { of_static_rating: Vec::new(), of_equivalent_load: Vec::new() };
    for line in FILE.lines().skip(1) {
        let cells: Vec<Option<f64>> = line.split(',').skip(1).map(|cell| cell.parse().ok()).collect();
        match cells[..] {
            [None, Some(gamma), Some(factor), ..] => tables.of_static_rating.push((gamma, [factor])),
            [Some(angle), argument, None, Some(e), Some(x), Some(y)] => {
                let line = (argument.unwrap_or_default(), [e, x, y]);
                match tables.of_equivalent_load.last_mut().filter(|last| last.angle == angle) {
                    Some(last) => last.lines.push(line),
                    None => tables.of_equivalent_load.push(OfAngle { angle, lines: vec![line] }),
                }
            }
            _ => {}
        }
    }
    tables
});

/// Values at a place, linear between lines that rise, the end values beyond.
fn between<const N: usize>(lines: &[(f64, [f64; N])], place: f64) -> [f64; N] {
    let after = lines.partition_point(|line| line.0 < place);
    let (Some(low), Some(high)) = (lines.get(after.saturating_sub(1)), lines.get(after).or(lines.last())) else {
        return [f64::NAN; N];
    };
    let width = high.0 - low.0;
    let share = if width > 0.0 { ((place - low.0) / width).clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|k| low.1[k] + share * (high.1[k] - low.1[k]))
}

/// Factor f₀ of the static load rating [-] (ISO 76) of γ = d cos α/D_m.
pub fn static_factor(gamma: f64) -> f64 {
    let [factor] = between(&TABLES.of_static_rating, gamma);
    factor
}

/// e, X and Y (ISO 281) at a free contact angle [rad] and a relative axial load f₀ F_a/C₀r.
///
/// Differs from the source: the file has no tables for 5° and 10°. Values between 0° and 15° are linear in the angle, and Y is up to 7 % low there.
pub fn axial_factors(contact_angle: f64, relative_load: f64) -> AxialFactors {
    let of_angles: Vec<(f64, [f64; 3])> =
        TABLES.of_equivalent_load.iter().map(|of| (of.angle, between(&of.lines, relative_load))).collect();
    let [limit, radial, axial] = between(&of_angles, contact_angle.to_degrees());
    AxialFactors { limit, radial, axial }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_read() {
        assert_eq!(TABLES.of_static_rating.len(), 36);
        let lines = TABLES.of_equivalent_load.iter().map(|of| of.lines.len());
        assert_eq!(lines.collect::<Vec<_>>(), [9, 9, 1, 1, 1, 1, 1, 1]);
        assert_eq!(TABLES.of_static_rating.len() + 24 + 1, FILE.lines().count());
    }

    #[test]
    fn lines_and_ends_are_those_of_the_file() {
        assert_eq!(static_factor(0.2), 14.0);
        assert!((static_factor(0.205) - 13.85).abs() < 1e-12);
        assert_eq!([static_factor(-1.0), static_factor(0.9)], [14.7, 10.5]);
        let all = |angle: f64, load| {
            let AxialFactors { limit, radial, axial } = axial_factors(angle.to_radians(), load);
            [limit, radial, axial]
        };
        assert_eq!(all(0.0, 1.03), [0.28, 0.56, 1.55]);
        assert_eq!([all(0.0, 0.0), all(0.0, 99.0)], [[0.19, 0.56, 2.30], [0.44, 0.56, 1.00]]);
        assert_eq!(all(60.0, 1.0), [1.34, 0.33, 0.50]);
        for (angle, expected) in [(40.0, [1.14, 0.35, 0.57]), (17.5, [0.5, 0.435, 1.115]), (7.5, [0.3, 0.5, 1.875])] {
            let ours = all(angle, if angle > 15.0 { 1.07 } else { 0.17 });
            assert!(ours.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{angle}°: {ours:?}");
        }
    }
}
