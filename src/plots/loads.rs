//! Raceway loads of a ball against its azimuth.

use super::axis::{Scale, range_of, ticks};
use super::svg::{Anchor, Drawing};

/// Load over azimuth, in the order of time.
pub struct LoadCurve<'a> {
    pub name: &'a str,
    /// Azimuth [°], 0 to 360; drawn from −180 to 180, with the loaded zone in the middle.
    pub azimuth: &'a [f64],
    /// Load [N].
    pub load: &'a [f64],
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 88.0;
const PANEL: f64 = 190.0;
const PITCH: f64 = PANEL + 46.0;
const BOTTOM: f64 = 48.0;
/// Interval of the labels, and half range of the axis [°].
const LABELS: usize = 45;
const HALF: i32 = 180;

/// One panel for each contact, one curve for each turn of the ball.
pub fn loads_svg(title: &str, subtitle: &str, curves: &[LoadCurve<'_>]) -> String {
    let height = TOP + curves.len().max(1) as f64 * PITCH - 46.0 + BOTTOM;
    let names: Vec<&str> = curves.iter().map(|curve| curve.name).collect();
    let description = format!("{subtitle}. Load over azimuth of {}.", names.join(", "));
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    let x = Scale { values: (f64::from(-HALF), f64::from(HALF)), positions: (LEFT, WIDTH - RIGHT) };
    let mut bottom = TOP;
    for (number, curve) in curves.iter().enumerate() {
        let top = TOP + number as f64 * PITCH;
        bottom = top + PANEL;
        let y = Scale { values: range_of(curve.load.iter().chain(&[0.0])), positions: (bottom, top) };
        drawing.text("name", Anchor::Start, LEFT, top - 8.0, curve.name);
        drawing.rectangle("panel", LEFT, top, WIDTH - LEFT - RIGHT, PANEL);
        for degrees in (-HALF..=HALF).step_by(LABELS) {
            let at = x.at(f64::from(degrees));
            drawing.line("grid", (at, top), (at, bottom));
            drawing.text("", Anchor::Middle, at, bottom + 17.0, &degrees.to_string().replace('-', "−"));
        }
        for (value, text) in ticks(y.values, 5) {
            drawing.line("grid", (LEFT, y.at(value)), (WIDTH - RIGHT, y.at(value)));
            drawing.text("", Anchor::End, LEFT - 7.0, y.at(value) + 4.5, &text);
        }
        drawing.upright_text("", 18.0, 0.5 * (top + bottom), "load in N");
        for turn in turns(curve) {
            let points = turn.iter().map(|(azimuth, load)| (x.at(*azimuth), y.at(*load)));
            drawing.curve(number, points.filter(|(x, y)| x.is_finite() && y.is_finite()));
        }
    }
    let caption = "azimuth of the ball in °, from the direction of the load Y";
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), bottom + 40.0, caption);
    drawing.finish()
}

/// The curve of the ball, cut where it passes ±180°.
fn turns(curve: &LoadCurve<'_>) -> Vec<Vec<(f64, f64)>> {
    let mut turns: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
    for (azimuth, load) in curve.azimuth.iter().zip(curve.load) {
        let azimuth = (azimuth + 180.0).rem_euclid(360.0) - 180.0;
        let passes = turns.last().and_then(|turn| turn.last()).is_some_and(|last| (azimuth - last.0).abs() > 180.0);
        if passes {
            turns.push(Vec::new());
        }
        if let Some(turn) = turns.last_mut() {
            turn.push((azimuth, *load));
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn every_turn_is_a_curve() {
        let azimuth = [120.0, 170.0, 200.0, 350.0, 10.0, 90.0];
        let curve = LoadCurve { name: "inner <raceway>", azimuth: &azimuth, load: &[1.0, 2.0, 3.0, 2.0, 1.0, 0.0] };
        let svg = loads_svg("Loads", "ball 1", &[curve]);
        assert_well_formed(&svg);
        assert_eq!(svg.matches("<path").count(), 2);
        assert!(svg.contains("load in N") && svg.contains(">−135<"));
        assert_well_formed(&loads_svg("t", "s", &[]));
    }
}
