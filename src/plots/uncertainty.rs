//! Histograms of metrics with percentiles, and bars of the shares of the inputs.

use super::axis::{Scale, range_of, ticks};
use super::svg::{Anchor, Drawing};

/// A metric.
pub struct SpreadPanel {
    /// Metric with its unit.
    pub quantity: String,
    pub edges: Vec<f64>,
    pub counts: Vec<u64>,
    /// Percentiles with their labels.
    pub marks: Vec<(String, f64)>,
    /// Inputs with their share of the variance and its interval, the largest first.
    pub bars: Vec<(String, f64, [f64; 2])>,
    /// Meaning of the bars, or the reason why there are none.
    pub ranking: String,
}

const WIDTH: f64 = 640.0;
const LEFT: f64 = 60.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 96.0;
const PANEL: f64 = 150.0;
const BAR: f64 = 24.0;
/// Place of the names of inputs beside their bars.
const NAMES: f64 = 250.0;

/// Stacked panels.
pub fn uncertainty_svg(title: &str, subtitle: &str, panels: &[SpreadPanel]) -> String {
    let height_of = |panel: &SpreadPanel| PANEL + 96.0 + BAR * panel.bars.len() as f64;
    let height = TOP + panels.iter().map(height_of).sum::<f64>().max(PANEL);
    let shown: Vec<&str> = panels.iter().map(|panel| &*panel.quantity).collect();
    let shown = if shown.is_empty() { "Nothing yet".to_owned() } else { shown.join(", ") };
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &format!("{subtitle}. {shown}."));
    let mut top = TOP;
    for panel in panels {
        draw_histogram(&mut drawing, panel, top);
        draw_bars(&mut drawing, panel, top + PANEL + 64.0);
        top += height_of(panel);
    }
    drawing.finish()
}

fn draw_histogram(drawing: &mut Drawing, panel: &SpreadPanel, top: f64) {
    let (left, right, bottom) = (LEFT, WIDTH - RIGHT, top + PANEL);
    let marks = panel.marks.iter().map(|(_, value)| value);
    let x = Scale { values: range_of(panel.edges.iter().chain(marks)), positions: (left, right) };
    let most = panel.counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let y = Scale { values: (0.0, 1.1 * most), positions: (bottom, top) };
    drawing.rectangle("panel", left, top, right - left, bottom - top);
    for (value, text) in ticks(x.values, 6) {
        drawing.line("grid", (x.at(value), top), (x.at(value), bottom));
        drawing.text("", Anchor::Middle, x.at(value), bottom + 17.0, &text);
    }
    for (value, text) in ticks(y.values, 4) {
        drawing.line("grid", (left, y.at(value)), (right, y.at(value)));
        drawing.text("", Anchor::End, left - 7.0, y.at(value) + 4.5, &text);
    }
    drawing.upright_text("", 18.0, 0.5 * (top + bottom), "points");
    for (ends, count) in panel.edges.windows(2).zip(&panel.counts) {
        let (from, to) = (x.at(ends[0]), x.at(ends[1]));
        let up = y.at(*count as f64);
        // At least as wide as a hairline where all values are equal.
        drawing.rectangle("f0", from, up, (to - from - 1.0).max(1.0), bottom - up);
    }
    for (label, value) in &panel.marks {
        drawing.dashed_curve(1, "dashed", [(x.at(*value), top), (x.at(*value), bottom)]);
        drawing.text("", Anchor::Middle, x.at(*value), top - 5.0, label);
    }
    drawing.text("", Anchor::Middle, 0.5 * (left + right), bottom + 37.0, &panel.quantity);
}

fn draw_bars(drawing: &mut Drawing, panel: &SpreadPanel, top: f64) {
    drawing.text("note", Anchor::Start, LEFT, top - 6.0, &panel.ranking);
    let x = Scale { values: (0.0, 1.0), positions: (NAMES, WIDTH - RIGHT - 46.0) };
    for (place, (name, share, interval)) in panel.bars.iter().enumerate() {
        let middle = top + BAR * (place as f64 + 0.5);
        let kept = name.chars().count().saturating_sub(30);
        let name: String = name.chars().skip(kept).collect();
        let name = if kept > 0 { format!("…{name}") } else { name };
        drawing.text("", Anchor::End, NAMES - 8.0, middle + 4.5, &name);
        let shown = share.clamp(0.0, 1.0);
        drawing.rectangle("f0", NAMES, middle - 7.0, (x.at(shown) - NAMES).max(0.5), 14.0);
        drawing.curve(4, [(x.at(interval[0]), middle), (x.at(interval[1]), middle)]);
        drawing.text("", Anchor::End, WIDTH - RIGHT, middle + 4.5, &format!("{share:.2}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn panels_have_bars_percentiles_and_names() {
        let panel = SpreadPanel {
            quantity: "level in dB".to_owned(),
            edges: vec![60.0, 61.0, 62.0],
            counts: vec![3, 5],
            marks: vec![("P50".to_owned(), 61.2)],
            bars: vec![("/spindle/mass_kg <&>".to_owned(), 0.7, [0.6, 0.8])],
            ranking: "share of the variance".to_owned(),
        };
        let svg = uncertainty_svg("Uncertainty", "one bearing", &[panel]);
        assert_well_formed(&svg);
        for text in [">P50<", ">level in dB<", "mass_kg &lt;&amp;&gt;", ">0.70<", ">points<"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_well_formed(&uncertainty_svg("t", "s", &[]));
        let equal = SpreadPanel {
            quantity: "q".to_owned(),
            edges: vec![2.0, 2.0],
            counts: vec![8],
            marks: Vec::new(),
            bars: Vec::new(),
            ranking: String::new(),
        };
        assert_well_formed(&uncertainty_svg("t", "s", &[equal]));
    }
}
