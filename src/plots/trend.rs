//! Metrics over one varied quantity: a panel a unit, values with what they may be wrong by.

use super::axis::{Scale, decade, range_of, ticks};
use super::svg::{Anchor, Drawing};

/// One metric over the axis, as many values as the axis has.
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
    /// Where on an axis of numbers the best value may lie.
    pub band: Option<[f64; 2]>,
}

/// The varied quantity: its name and its values; words stand at equal distances.
pub struct VariedAxis<'a> {
    pub name: &'a str,
    pub values: AxisPlaces,
}

/// Where the values of an axis stand.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisPlaces {
    Numbers(Vec<f64>),
    Words(Vec<String>),
}

const WIDTH: f64 = 640.0;
const LEFT: f64 = 94.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 100.0;
const PANEL: f64 = 150.0;
const PITCH: f64 = PANEL + 56.0;
const BOTTOM: f64 = 52.0;
const LETTER: f64 = 7.8;
/// Largest over least value from which on an evenly spaced logarithmic axis is drawn as one.
const LOGARITHMIC: f64 = 8.0;

/// Where values stand on an axis of a picture, and its ticks.
pub(super) struct Places {
    at: Vec<f64>,
    ticks: Vec<(f64, String)>,
    /// Of numbers; whether their logarithms are what it takes.
    scale: Option<(Scale, bool)>,
}

impl Places {
    /// Where a number stands; `None` among words.
    fn of(&self, value: f64) -> Option<f64> {
        let (scale, logarithmic) = self.scale?;
        Some(scale.at(if logarithmic { value.log10() } else { value }))
    }
}

impl AxisPlaces {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Words(words) => words.len(),
        }
    }

    /// The value at a place, as short as it can be told.
    pub(super) fn text(&self, place: usize) -> String {
        match self {
            Self::Numbers(values) => values.get(place).map_or(String::new(), |value| {
                // Four digits tell neighbours apart.
                let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(*value);
                let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs());
                let text = if plain { rounded.to_string() } else { format!("{rounded:e}") };
                text.replace('-', "−")
            }),
            Self::Words(words) => words.get(place).map_or(String::new(), |word| word.chars().take(10).collect()),
        }
    }

    /// Between two positions.
    pub(super) fn laid_out(&self, positions: (f64, f64)) -> Places {
        match self {
            Self::Words(words) => {
                let scale = Scale { values: (-0.5, words.len() as f64 - 0.5), positions };
                let at: Vec<f64> = (0..words.len()).map(|i| scale.at(i as f64)).collect();
                let shown = words.iter().map(|word| word.chars().take(16).collect());
                Places { ticks: at.iter().copied().zip(shown).collect(), at, scale: None }
            }
            Self::Numbers(values) => {
                let logarithmic = is_logarithmic(values);
                let mapped: Vec<f64> = values.iter().map(|v| if logarithmic { v.log10() } else { *v }).collect();
                let scale = Scale { values: range_of(&mapped), positions };
                let ticks = if logarithmic { log_ticks(scale.values) } else { ticks(scale.values, 8) };
                Places {
                    at: mapped.iter().map(|value| scale.at(*value)).collect(),
                    ticks: ticks.into_iter().map(|(value, text)| (scale.at(value), text)).collect(),
                    scale: Some((scale, logarithmic)),
                }
            }
        }
    }
}

/// Whether ratios, not differences, of the values are alike, over a wide enough range.
fn is_logarithmic(values: &[f64]) -> bool {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    if values.len() < 3 || least <= 0.0 || most / least < LOGARITHMIC {
        return false;
    }
    let spread = |mapped: &[f64]| {
        let steps: Vec<f64> = mapped.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let (least, most) = steps.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(*s), b.max(*s)));
        most / least.max(f64::MIN_POSITIVE)
    };
    spread(&values.iter().map(|value| value.ln()).collect::<Vec<_>>()) < spread(values)
}

fn log_ticks((from, to): (f64, f64)) -> Vec<(f64, String)> {
    let multiples: &[i32] = if to - from < 2.5 { &[1, 2, 5] } else { &[1] };
    let mut ticks = Vec::new();
    for exponent in from.floor() as i32..=to.ceil() as i32 {
        for &multiple in multiples {
            let at = f64::from(multiple).log10() + f64::from(exponent);
            if (from..=to).contains(&at) {
                let plain = f64::from(multiple) * 10_f64.powi(exponent);
                let text = if multiple == 1 { decade(exponent) } else { format!("{plain}") };
                ticks.push((at, text));
            }
        }
    }
    ticks
}

/// Panels above each other over one axis.
pub fn trend_svg(title: &str, subtitle: &str, axis: &VariedAxis<'_>, panels: &[TrendPanel<'_>]) -> String {
    let height = TOP + panels.len().max(1) as f64 * PITCH - 56.0 + BOTTOM;
    let shown: Vec<&str> = panels.iter().map(|panel| panel.quantity).collect();
    let shown = if shown.is_empty() { "Nothing yet".to_owned() } else { shown.join(", ") };
    let description = format!("{subtitle}. {shown} over {}.", axis.name);
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    let places = axis.values.laid_out((LEFT, WIDTH - RIGHT));
    let mut bottom = TOP + PANEL;
    for (number, panel) in panels.iter().enumerate() {
        let top = TOP + number as f64 * PITCH;
        bottom = top + PANEL;
        draw_panel(&mut drawing, panel, &places, (bottom, top));
    }
    let logarithmic = places.scale.as_ref().is_some_and(|(_, logarithmic)| *logarithmic);
    let name = if logarithmic { format!("{}, logarithmic", axis.name) } else { axis.name.to_owned() };
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), bottom + 40.0, &name);
    drawing.finish()
}

fn draw_panel(drawing: &mut Drawing, panel: &TrendPanel<'_>, places: &Places, (bottom, top): (f64, f64)) {
    let known = || panel.curves.iter().flat_map(|curve| &curve.values).flatten();
    let ends: Vec<f64> =
        known().flat_map(|(value, error)| [value - error.unwrap_or(0.0), value + error.unwrap_or(0.0)]).collect();
    let y = Scale { values: range_of(&ends), positions: (bottom, top) };
    let (left, right) = (LEFT, WIDTH - RIGHT);
    drawing.rectangle("panel", left, top, right - left, bottom - top);
    if let Some([a, b]) = panel.band.and_then(|[a, b]| Some([places.of(a)?, places.of(b)?])) {
        // At least a hairline.
        drawing.rectangle("band", a.min(b), top, (b - a).abs().max(1.0), bottom - top);
    }
    for (at, text) in &places.ticks {
        drawing.line("grid", (*at, top), (*at, bottom));
        drawing.text("", Anchor::Middle, *at, bottom + 17.0, text);
    }
    for (value, text) in ticks(y.values, 5) {
        let at = y.at(value);
        drawing.line("grid", (left, at), (right, at));
        drawing.text("", Anchor::End, left - 7.0, at + 4.5, &text);
    }
    // The unit below its quantity: both in one line would be longer than their panel.
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
        let points = || curve.values.iter().zip(&places.at).filter_map(|(value, at)| value.map(|value| (*at, value)));
        drawing.curve(colour, points().map(|(at, (value, _))| (at, y.at(value))));
        for (at, (value, error)) in points() {
            let (low, high) = (y.at(value - error.unwrap_or(0.0)), y.at(value + error.unwrap_or(0.0)));
            // Shorter ones are hidden by the dot.
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
        && let Some(at) = places.at.get(place)
    {
        drawing.mark(*at, y.at(value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

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
        let axis = VariedAxis { name: "/operation/speed_rpm", values: AxisPlaces::Numbers(vec![1.0, 2.0, 3.0, 4.0]) };
        let svg = trend_svg("Trend", "one bearing", &axis, &panel(values));
        assert_well_formed(&svg);
        for text in [">level<", ">dB<", "/operation/speed_rpm", "y &lt;&amp;&gt;", ">60<", "class=\"band\""] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!((svg.matches("<circle").count(), svg.matches("<path").count()), (4, 4));
    }

    #[test]
    fn words_ratios_nothing_and_a_single_point_are_drawn_too() {
        let words = AxisPlaces::Words(vec!["grease".into(), "oil".into()]);
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
            let axis = VariedAxis { name: "a", values: AxisPlaces::Numbers(values) };
            assert_well_formed(&trend_svg("t", "s", &axis, &panel(vec![Some((2.0, None)); count])));
        }
        assert_well_formed(&trend_svg("t", "s", &VariedAxis { name: "a", values: AxisPlaces::Numbers(vec![]) }, &[]));
        assert!(
            is_logarithmic(&[0.01, 0.1, 1.0])
                && !is_logarithmic(&[1.0, 10.0, 19.0])
                && !is_logarithmic(&[0.0, 9.0, 99.0])
        );
    }
}
