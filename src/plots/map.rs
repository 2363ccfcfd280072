//! A metric over two varied quantities: one panel for each metric, one coloured field for each point.

use super::axis::{Scale, range_of, ticks};
use super::shade::shade_name;
use super::svg::{Anchor, Drawing};
use super::varied_axis::VariedAxis;

/// One metric over a grid, the second axis changing fastest.
pub struct MapPanel<'a> {
    /// Metric with its unit.
    pub name: &'a str,
    pub values: Vec<Option<f64>>,
    /// The best point, in fields to the right and up from the middle of the first one.
    pub best: Option<[f64; 2]>,
    /// Further points, in the same coordinates.
    pub runs: Vec<[f64; 2]>,
}

const WIDTH: f64 = 640.0;
const LEFT: f64 = 86.0;
const RIGHT: f64 = 96.0;
const TOP: f64 = 100.0;
const PANEL: f64 = 300.0;
const PITCH: f64 = PANEL + 82.0;
const BOTTOM: f64 = 56.0;
/// The colour bar: distance from the panel, and width.
const BAR: (f64, f64) = (14.0, 16.0);
const SHADES: usize = 32;
/// Intervals between labels on an axis.
const MOST_LABELS: usize = 8;

/// Stacked panels, with the first axis horizontal and the second one vertical.
pub fn map_svg(title: &str, subtitle: &str, axes: [&VariedAxis<'_>; 2], panels: &[MapPanel<'_>]) -> String {
    let height = TOP + panels.len().max(1) as f64 * PITCH - 82.0 + BOTTOM;
    let shown: Vec<&str> = panels.iter().map(|panel| panel.name).collect();
    let description = format!("{subtitle}. {} over {} and {}.", shown.join(", "), axes[0].name, axes[1].name);
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    for (number, panel) in panels.iter().enumerate() {
        draw(&mut drawing, axes, panel, TOP + number as f64 * PITCH);
    }
    drawing.finish()
}

fn draw(drawing: &mut Drawing, axes: [&VariedAxis<'_>; 2], panel: &MapPanel<'_>, top: f64) {
    let [columns, rows] = axes.map(|axis| axis.values.len());
    let (right, bottom) = (WIDTH - RIGHT, top + PANEL);
    drawing.text("name", Anchor::Start, LEFT, top - 10.0, panel.name);
    drawing.rectangle("panel", LEFT, top, right - LEFT, PANEL);
    let known: Vec<f64> = panel.values.iter().copied().flatten().filter(|value| value.is_finite()).collect();
    let (least, most) = known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let (width, height) = ((right - LEFT) / columns.max(1) as f64, PANEL / rows.max(1) as f64);
    let corner = |point: usize| {
        let (column, row) = (point / rows.max(1), point % rows.max(1));
        (LEFT + column as f64 * width, bottom - (row + 1) as f64 * height)
    };
    for (point, value) in panel.values.iter().enumerate() {
        let Some(value) = value.filter(|value| value.is_finite()) else { continue };
        let share = if most > least { (value - least) / (most - least) } else { 0.5 };
        let (x, y) = corner(point);
        // Slightly larger, so that no gap shows between neighbours.
        drawing.filled(&shade_name(share), x, y, width + 0.4, height + 0.4);
    }
    let middle = |[column, row]: [f64; 2]| (LEFT + (column + 0.5) * width, bottom - (row + 0.5) * height);
    for run in &panel.runs {
        let (x, y) = middle(*run);
        drawing.run(x, y);
    }
    if let Some(best) = panel.best {
        let (x, y) = middle(best);
        drawing.mark(x, y);
    }
    for (place, text) in axes[0].values.field_ticks(MOST_LABELS) {
        drawing.text("", Anchor::Middle, LEFT + place * width, bottom + 17.0, &text);
    }
    for (place, text) in axes[1].values.field_ticks(MOST_LABELS) {
        drawing.text("", Anchor::End, LEFT - 6.0, bottom - place * height + 4.5, &text);
    }
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + right), bottom + 38.0, axes[0].name);
    drawing.upright_text("", 16.0, 0.5 * (top + bottom), axes[1].name);
    if known.len() < panel.values.len() {
        // Above the name of the panel, which may be as long as the panel.
        drawing.text("small", Anchor::End, right, top - 26.0, "no colour: no value");
    }
    if !known.is_empty() {
        bar(drawing, range_of(&[least, most]), (least, most), (right + BAR.0, top, bottom));
    }
}

/// The colours with their values.
fn bar(drawing: &mut Drawing, range: (f64, f64), (least, most): (f64, f64), (left, top, bottom): (f64, f64, f64)) {
    let values = if most > least { (least, most) } else { range };
    let height = (bottom - top) / SHADES as f64;
    for k in 0..SHADES {
        let share = (k as f64 + 0.5) / SHADES as f64;
        drawing.filled(&shade_name(share), left, bottom - (k + 1) as f64 * height, BAR.1, height + 0.4);
    }
    let scale = Scale { values, positions: (bottom, top) };
    for (value, text) in ticks(values, 6) {
        drawing.text("", Anchor::Start, left + BAR.1 + 6.0, scale.at(value) + 4.5, &text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;
    use crate::plots::varied_axis::AxisValues;

    #[test]
    fn a_map_has_a_field_a_point_a_bar_and_both_axes() {
        let speed = VariedAxis { name: "speed", values: AxisValues::Numbers(vec![1e4, 2e4, 3e4]) };
        let kind = VariedAxis { name: "kind", values: AxisValues::Names(vec!["a<b".into(), "c".into()]) };
        let values = vec![Some(1.0), Some(2.0), None, Some(3.0), Some(4.0), Some(f64::NAN)];
        let svg = map_svg(
            "Map",
            "s",
            [&speed, &kind],
            &[MapPanel { name: "level in dB", values, best: Some([0.0, 1.0]), runs: vec![[0.5, 0.5]] }],
        );
        assert_well_formed(&svg);
        assert_eq!(svg.matches("fill=\"#").count(), 4 + SHADES);
        for text in ["level in dB", ">speed<", ">kind<", "a&lt;b", ">20000<", "no colour"] {
            assert!(svg.contains(text), "{text}");
        }
        let empty = MapPanel { name: "n", values: vec![None; 6], best: None, runs: Vec::new() };
        let flat = MapPanel { name: "n", values: vec![Some(2.0); 6], best: Some([2.0, 1.0]), runs: Vec::new() };
        assert_well_formed(&map_svg("t", "s", [&speed, &kind], &[empty, flat]));
        assert_eq!((shade_name(0.0), shade_name(-1.0)), ("#440154".into(), "#440154".into()));
    }
}
