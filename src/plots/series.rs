//! Signals against time, one panel for each channel.

use super::axis::{Scale, range_of, ticks};
use super::svg::{Anchor, Drawing};
use raceway_core::numerics::statistics::thin;

/// One channel; times and values have the same length.
pub struct SeriesCurve<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    pub time_s: &'a [f64],
    pub value: &'a [f64],
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 88.0;
const PANEL: f64 = 170.0;
const PITCH: f64 = PANEL + 46.0;
const BOTTOM: f64 = 48.0;
/// Time span below which labels are in milliseconds [s].
const MILLISECONDS_BELOW: f64 = 2.0;

/// A time span that is shaded in every panel.
pub struct TimeSpan {
    pub from_s: f64,
    pub to_s: f64,
}

/// Stacked signals on one time axis, signals of one unit on one scale; thinned so that peaks are kept.
pub fn series_svg(title: &str, subtitle: &str, curves: &[SeriesCurve<'_>], spans: &[TimeSpan]) -> String {
    let height = TOP + curves.len().max(1) as f64 * PITCH - 46.0 + BOTTOM;
    let names: Vec<&str> = curves.iter().map(|curve| curve.name).collect();
    let mut description = format!("{subtitle}. Time series of {}.", names.join(", "));
    for span in spans {
        description += &format!(" Shaded from {:.6} s to {:.6} s.", span.from_s, span.to_s);
    }
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    let times = curves.iter().flat_map(|curve| curve.time_s).copied().filter(|time| time.is_finite());
    let (mut from, mut to) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    if from >= to || from > to {
        (from, to) = if from.is_finite() { (from - 0.5, from + 0.5) } else { (0.0, 1.0) };
    }
    let (time_unit, per_second) = if to - from < MILLISECONDS_BELOW { ("ms", 1e3) } else { ("s", 1.0) };
    let x = Scale { values: (from * per_second, to * per_second), positions: (LEFT, WIDTH - RIGHT) };
    let mut bottom = TOP;
    for (number, curve) in curves.iter().enumerate() {
        let top = TOP + number as f64 * PITCH;
        bottom = top + PANEL;
        let alike = curves.iter().filter(|other| other.unit == curve.unit).flat_map(|other| other.value);
        let y = Scale { values: range_of(alike), positions: (bottom, top) };
        drawing.text("name", Anchor::Start, LEFT, top - 8.0, curve.name);
        frame(&mut drawing, &x, &y, curve.unit);
        for span in spans {
            let at = |time_s: f64| x.at(time_s * per_second).clamp(x.positions.0, x.positions.1);
            let (from, to) = (at(span.from_s), at(span.to_s));
            drawing.rectangle("band", from, top, to - from, PANEL);
        }
        let points = thin(curve.value, 2 * (WIDTH - LEFT - RIGHT) as usize);
        drawing.curve(
            number,
            points
                .into_iter()
                .filter_map(|i| Some((x.at(curve.time_s.get(i)? * per_second), y.at(curve.value[i]))))
                .filter(|(x, y)| x.is_finite() && y.is_finite()),
        );
    }
    let caption = format!("time in {time_unit}");
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), bottom + 40.0, &caption);
    drawing.finish()
}

/// Panel, grid and axis labels.
fn frame(drawing: &mut Drawing, x: &Scale, y: &Scale, unit: &str) {
    let ((left, right), (bottom, top)) = (x.positions, y.positions);
    drawing.rectangle("panel", left, top, right - left, bottom - top);
    for (value, text) in ticks(x.values, 10) {
        let at = x.at(value);
        drawing.line("grid", (at, top), (at, bottom));
        drawing.text("", Anchor::Middle, at, bottom + 17.0, &text);
    }
    for (value, text) in ticks(y.values, 5) {
        let at = y.at(value);
        drawing.line("grid", (left, at), (right, at));
        drawing.text("", Anchor::End, left - 7.0, at + 4.5, &text);
    }
    drawing.upright_text("", 18.0, 0.5 * (top + bottom), unit);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn picture_has_units_names_and_a_time_axis() {
        let time: Vec<f64> = (0..4000).map(|i| 0.02 + f64::from(i) * 2.5e-5).collect();
        let y: Vec<f64> = time.iter().map(|t| 0.8 * (14_410.0 * t).sin() + 0.3 * (5236.0 * t).sin()).collect();
        let z: Vec<f64> = time.iter().map(|t| 0.2 * (14_410.0 * t).cos() * (300.0 * t).sin()).collect();
        let svg = series_svg(
            "Velocity of the spindle",
            "50 000 r/min, 200 N & <more>",
            &[
                SeriesCurve { name: "spindle.y.velocity", unit: "mm/s", time_s: &time, value: &y },
                SeriesCurve { name: "spindle.z.velocity", unit: "mm/s", time_s: &time, value: &z },
            ],
            &[TimeSpan { from_s: 0.05, to_s: 0.06 }],
        );
        assert_well_formed(&svg);
        for text in [
            "mm/s",
            "time in ms",
            "spindle.y.velocity",
            "spindle.z.velocity",
            "&amp; &lt;more&gt;",
            ">100<",
            "0.050000 s",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.len() < 60_000, "thinned: {} bytes", svg.len());
    }

    #[test]
    fn still_empty_and_single_values_are_drawn_too() {
        for (time, value) in
            [(&[][..], &[][..]), (&[1.0], &[2.0]), (&[0.0, 1.0], &[0.0, 0.0]), (&[0.0, 1.0], &[f64::NAN, 5.0])]
        {
            assert_well_formed(&series_svg(
                "t",
                "s",
                &[SeriesCurve { name: "y", unit: "N", time_s: time, value }],
                &[],
            ));
        }
        assert_well_formed(&series_svg("t", "s", &[], &[]));
    }
}
