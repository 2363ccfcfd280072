//! Metrics against one varied quantity, with their errors.

use super::axis::{Scale, range_of, ticks};
use super::svg::{Anchor, Drawing};
use super::varied_axis::{Positions, VariedAxis};

/// One metric, with a value for each value of the axis.
pub struct TrendCurve<'a> {
    pub name: &'a str,
    /// Value and error; `None` where the point has none.
    pub values: Vec<Option<(f64, Option<f64>)>>,
}

/// Metrics of one quantity.
pub struct TrendPanel<'a> {
    /// Quantity with its unit.
    pub quantity: &'a str,
    pub curves: Vec<TrendCurve<'a>>,
    /// The best value of the first curve.
    pub best: Option<usize>,
    /// Interval of the axis that contains the optimum.
    pub band: Option<[f64; 2]>,
}

const WIDTH: f64 = 640.0;
const LEFT: f64 = 94.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 100.0;
const PANEL: f64 = 150.0;
const PITCH: f64 = PANEL + 56.0;
const BOTTOM: f64 = 52.0;
const LETTER: f64 = 7.8;

/// Stacked panels on one axis.
pub fn trend_svg(title: &str, subtitle: &str, axis: &VariedAxis<'_>, panels: &[TrendPanel<'_>]) -> String {
    let height = TOP + panels.len().max(1) as f64 * PITCH - 56.0 + BOTTOM;
    let shown: Vec<&str> = panels.iter().map(|panel| panel.quantity).collect();
    let shown = if shown.is_empty() { "Nothing yet".to_owned() } else { shown.join(", ") };
    let description = format!("{subtitle}. {shown} over {}.", axis.name);
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    let positions = axis.values.positions((LEFT, WIDTH - RIGHT));
    let mut bottom = TOP + PANEL;
    for (number, panel) in panels.iter().enumerate() {
        let top = TOP + number as f64 * PITCH;
        bottom = top + PANEL;
        draw_panel(&mut drawing, panel, &positions, (bottom, top));
    }
    let logarithmic = positions.is_logarithmic();
    let name = if logarithmic { format!("{}, logarithmic", axis.name) } else { axis.name.to_owned() };
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), bottom + 40.0, &name);
    drawing.finish()
}

fn draw_panel(drawing: &mut Drawing, panel: &TrendPanel<'_>, positions: &Positions, (bottom, top): (f64, f64)) {
    let known = || panel.curves.iter().flat_map(|curve| &curve.values).flatten();
    let ends: Vec<f64> =
        known().flat_map(|(value, error)| [value - error.unwrap_or(0.0), value + error.unwrap_or(0.0)]).collect();
    let y = Scale { values: range_of(&ends), positions: (bottom, top) };
    let (left, right) = (LEFT, WIDTH - RIGHT);
    drawing.rectangle("panel", left, top, right - left, bottom - top);
    if let Some([a, b]) = panel.band.and_then(|[a, b]| Some([positions.of(a)?, positions.of(b)?])) {
        // At least as wide as a hairline.
        drawing.rectangle("band", a.min(b), top, (b - a).abs().max(1.0), bottom - top);
    }
    for (at, text) in &positions.ticks {
        drawing.line("grid", (*at, top), (*at, bottom));
        drawing.text("", Anchor::Middle, *at, bottom + 17.0, text);
    }
    for (value, text) in ticks(y.values, 5) {
        let at = y.at(value);
        drawing.line("grid", (left, at), (right, at));
        drawing.text("", Anchor::End, left - 7.0, at + 4.5, &text);
    }
    // The unit stands below its quantity: both in one line would be longer than the panel.
    let (quantity, unit) = panel.quantity.rsplit_once(" in ").unwrap_or((panel.quantity, ""));
    drawing.upright_text("", 18.0, 0.5 * (top + bottom), quantity.trim_end_matches(','));
    if !unit.is_empty() {
        drawing.upright_text("", 34.0, 0.5 * (top + bottom), unit);
    }
    let mut legend = left;
    for (colour, curve) in panel.curves.iter().enumerate() {
        drawing.dot(colour, legend + 4.0, top - 12.0);
        drawing.text("", Anchor::Start, legend + 12.0, top - 8.0, curve.name);
        legend += 30.0 + LETTER * curve.name.chars().count() as f64;
        let points =
            || curve.values.iter().zip(&positions.at).filter_map(|(value, at)| value.map(|value| (*at, value)));
        drawing.curve(colour, points().map(|(at, (value, _))| (at, y.at(value))));
        for (at, (value, error)) in points() {
            let (low, high) = (y.at(value - error.unwrap_or(0.0)), y.at(value + error.unwrap_or(0.0)));
            // The dot hides shorter error bars.
            if (low - high).abs() > 6.0 {
                drawing.curve(colour, [(at, low), (at, high)]);
                drawing.curve(colour, [(at - 3.0, low), (at + 3.0, low)]);
                drawing.curve(colour, [(at - 3.0, high), (at + 3.0, high)]);
            }
            drawing.dot(colour, at, y.at(value));
        }
    }
    let value = |place: usize| panel.curves.first()?.values.get(place).copied().flatten();
    if let Some((place, (value, _))) = panel.best.and_then(|place| Some((place, value(place)?)))
        && let Some(at) = positions.at.get(place)
    {
        drawing.mark(*at, y.at(value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;
    use crate::plots::varied_axis::AxisValues;

    fn panel(values: Vec<Option<(f64, Option<f64>)>>) -> [TrendPanel<'static>; 1] {
        [TrendPanel {
            quantity: "level in dB",
            curves: vec![TrendCurve { name: "y <&>", values }],
            best: None,
            band: Some([1.5, 2.5]),
        }]
    }

    #[test]
    fn picture_has_axis_units_errors_and_gaps() {
        let values = vec![Some((60.0, Some(1.0))), None, Some((62.0, None)), Some((64.0, Some(1e-6)))];
        let axis = VariedAxis { name: "/operation/speed_rpm", values: AxisValues::Numbers(vec![1.0, 2.0, 3.0, 4.0]) };
        let svg = trend_svg("Trend", "one bearing", &axis, &panel(values));
        assert_well_formed(&svg);
        for text in [">level<", ">dB<", "/operation/speed_rpm", "y &lt;&amp;&gt;", ">60<", "class=\"band\""] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!((svg.matches("<circle").count(), svg.matches("<path").count()), (4, 4));
    }

    #[test]
    fn words_ratios_nothing_and_a_single_point_are_drawn_too() {
        let words = AxisValues::Names(vec!["grease".into(), "oil".into()]);
        let svg = trend_svg(
            "t",
            "s",
            &VariedAxis { name: "lubricant", values: words },
            &panel(vec![Some((1.0, None)), None]),
        );
        assert_well_formed(&svg);
        assert!(svg.contains(">grease<") && svg.contains(">oil<"));
        for values in [vec![], vec![5.0], vec![0.01, 0.1, 1.0, 10.0]] {
            let count = values.len();
            let axis = VariedAxis { name: "a", values: AxisValues::Numbers(values) };
            assert_well_formed(&trend_svg("t", "s", &axis, &panel(vec![Some((2.0, None)); count])));
        }
        assert_well_formed(&trend_svg("t", "s", &VariedAxis { name: "a", values: AxisValues::Numbers(vec![]) }, &[]));
    }
}
