//! Paths of body centres in the bearing's plane.

use super::axis::{Scale, range_of, ticks};
use super::svg::{Anchor, Drawing};
use raceway_core::numerics::statistics::thin;

/// The path of one centre; `y` and `z` have the same length.
pub struct OrbitCurve<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    pub y: &'a [f64],
    pub z: &'a [f64],
}

const SIDE: f64 = 292.0;
const LEFT: f64 = 72.0;
const PITCH: f64 = SIDE + LEFT + 10.0;
const TOP: f64 = 88.0;
const MOST_POINTS: usize = 4000;

/// Orbits side by side, with the same scale in both directions, y downwards in the direction of the load.
pub fn orbit_svg(title: &str, subtitle: &str, curves: &[OrbitCurve<'_>]) -> String {
    let width = 20.0 + curves.len().max(2) as f64 * PITCH;
    let height = TOP + SIDE + 50.0;
    let names: Vec<&str> = curves.iter().map(|curve| curve.name).collect();
    let description = format!("{subtitle}. Paths in the y–z plane of {}.", names.join(", "));
    let mut drawing = Drawing::new(width, height, title, subtitle, &description);
    for (number, curve) in curves.iter().enumerate() {
        let left = LEFT + number as f64 * PITCH;
        let (y_range, z_range) = (range_of(curve.y), range_of(curve.z));
        let half = 0.5 * (y_range.1 - y_range.0).max(z_range.1 - z_range.0);
        let around = |(from, to): (f64, f64)| (0.5 * (from + to) - half, 0.5 * (from + to) + half);
        let z = Scale { values: around(z_range), positions: (left, left + SIDE) };
        let y = Scale { values: around(y_range), positions: (TOP, TOP + SIDE) };
        drawing.text("name", Anchor::Start, left, TOP - 8.0, curve.name);
        drawing.rectangle("panel", left, TOP, SIDE, SIDE);
        for (value, text) in ticks(z.values, 5) {
            drawing.line("grid", (z.at(value), TOP), (z.at(value), TOP + SIDE));
            drawing.text("", Anchor::Middle, z.at(value), TOP + SIDE + 17.0, &text);
        }
        for (value, text) in ticks(y.values, 5) {
            drawing.line("grid", (left, y.at(value)), (left + SIDE, y.at(value)));
            drawing.text("", Anchor::End, left - 7.0, y.at(value) + 4.5, &text);
        }
        drawing.text("", Anchor::Middle, left + 0.5 * SIDE, TOP + SIDE + 38.0, &format!("z in {}", curve.unit));
        drawing.upright_text("", left - 54.0, TOP + 0.5 * SIDE, &format!("← y in {}", curve.unit));
        draw_path(&mut drawing, number, curve, &z, &y);
    }
    drawing.finish()
}

fn draw_path(drawing: &mut Drawing, number: usize, curve: &OrbitCurve<'_>, z: &Scale, y: &Scale) {
    let n = curve.y.len().min(curve.z.len());
    // Extremes of both directions are kept.
    let mut kept = thin(&curve.y[..n], MOST_POINTS / 2);
    kept.extend(thin(&curve.z[..n], MOST_POINTS / 2));
    kept.sort_unstable();
    kept.dedup();
    let points = kept.into_iter().map(|i| (z.at(curve.z[i]), y.at(curve.y[i])));
    drawing.curve(number, points.filter(|(z, y)| z.is_finite() && y.is_finite()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn picture_has_names_and_units_and_nothing_to_draw_is_no_failure() {
        let angle: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.02).collect();
        let y: Vec<f64> = angle.iter().map(|a| 12.0 + 2.0 * a.sin() + 0.2 * (7.3 * a).sin()).collect();
        let z: Vec<f64> = angle.iter().map(|a| 1.5 * a.cos()).collect();
        let svg = orbit_svg(
            "Orbits",
            "a < b",
            &[
                OrbitCurve { name: "spindle", unit: "µm", y: &y, z: &z },
                OrbitCurve { name: "cage", unit: "µm", y: &z, z: &y },
            ],
        );
        assert_well_formed(&svg);
        for text in ["z in µm", "y in µm", ">spindle<", ">cage<", "a &lt; b"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_well_formed(&orbit_svg("t", "s", &[]));
        assert_well_formed(&orbit_svg("t", "s", &[OrbitCurve { name: "still", unit: "µm", y: &[], z: &[] }]));
    }
}
