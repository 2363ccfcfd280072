//! Error against run time: a curve a method, a panel for the error of the level and one for that of the trajectory,
//! both axes logarithmic.

use super::axis::{Scale, decade};
use super::svg::{Anchor, Drawing};

/// One method over its tolerances.
pub struct WorkPrecisionCurve<'a> {
    pub name: &'a str,
    /// Loosest tolerance first.
    pub points: Vec<WorkPoint>,
    pub failures: Vec<FailedRun>,
}

/// A run that has ended well.
#[derive(Debug, Clone, Copy)]
pub struct WorkPoint {
    pub relative_tolerance: f64,
    pub time_s: f64,
    /// In the order of the panels: value, and whether it stands clear of the reference's own error.
    pub errors: [Option<(f64, bool)>; 2],
}

/// A run that has not; without a time it was not tried.
#[derive(Debug, Clone, Copy)]
pub struct FailedRun {
    pub relative_tolerance: f64,
    pub time_s: Option<f64>,
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 116.0;
const PANEL: f64 = 250.0;
const PITCH: f64 = PANEL + 62.0;
const BOTTOM: f64 = 56.0;
/// Height of a line of text below the panels.
const LINE: f64 = 18.0;
/// Height of the strip at a panel's top where failures are marked.
const STRIP: f64 = 20.0;
/// Room of a point's label.
const LABEL: (f64, f64) = (34.0, 11.0);
const LEGEND_PITCH: f64 = 140.0;
/// Most decades of error that are shown.
const MOST_DECADES: i32 = 12;
const PANELS: [(&str, &str); 2] =
    [("Error of the level, worst of y and z", "dB"), ("Error of the trajectory", "rms, in standard deviations")];

/// Two panels above each other; `floors` are the errors below which the reference says nothing, in the order of the
/// panels.
pub fn work_precision_svg(
    title: &str,
    subtitle: &str,
    curves: &[WorkPrecisionCurve<'_>],
    floors: [Option<f64>; 2],
) -> String {
    let failed: Vec<_> = curves.iter().enumerate().filter(|(_, curve)| !curve.failures.is_empty()).collect();
    let height = TOP + PITCH + PANEL + BOTTOM + LINE * failed.len() as f64;
    let names: Vec<&str> = curves.iter().map(|curve| curve.name).collect();
    let description = format!("{subtitle}. Error of {} against their run time.", names.join(", "));
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    legend(&mut drawing, curves);
    let x = Scale { values: time_range(curves), positions: (LEFT, WIDTH - RIGHT) };
    for (index, (name, unit)) in PANELS.into_iter().enumerate() {
        let top = TOP + index as f64 * PITCH;
        let y = Scale { values: error_range(curves, index, floors[index]), positions: (top + PANEL, top + STRIP) };
        drawing.text("name", Anchor::Start, LEFT, top - 8.0, name);
        frame(&mut drawing, top, &x, &y, unit);
        if let Some(floor) = floors[index].filter(|floor| *floor > 0.0) {
            let at = y.at(within(floor.log10(), y.values));
            drawing.line("floor", (LEFT, at), (WIDTH - RIGHT, at));
            drawing.text("note", Anchor::End, WIDTH - RIGHT - 4.0, at - 4.0, "errors below this say nothing");
        }
        let mut labels = Vec::new();
        for (number, curve) in curves.iter().enumerate() {
            draw_curve(&mut drawing, number, curve, index, (&x, &y), &mut labels);
            for time in curve.failures.iter().filter_map(|failure| failure.time_s) {
                drawing.cross(number, x.at(within(logarithm(time), x.values)), top + 0.5 * STRIP);
            }
        }
    }
    let bottom = TOP + PITCH + PANEL;
    let caption = "run time in s; hollow: not clear of the reference's own error; ×: failed after that time";
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), bottom + 40.0, caption);
    for (line, (number, curve)) in failed.into_iter().enumerate() {
        let at = bottom + BOTTOM + 4.0 + LINE * line as f64;
        drawing.cross(number, LEFT - 10.0, at - 4.0);
        let told = curve.failures.iter().map(|failure| {
            let untried = if failure.time_s.is_none() { " (not tried)" } else { "" };
            format!("{:e}{untried}", failure.relative_tolerance)
        });
        let text = format!("{} failed at {}", curve.name, told.collect::<Vec<_>>().join(", "));
        drawing.text("note", Anchor::Start, LEFT, at, &text);
    }
    drawing.finish()
}

fn legend(drawing: &mut Drawing, curves: &[WorkPrecisionCurve<'_>]) {
    for (number, curve) in curves.iter().enumerate() {
        let at = 22.0 + LEGEND_PITCH * number as f64;
        drawing.dot(number, at, 74.0);
        drawing.text("", Anchor::Start, at + 9.0, 78.5, curve.name);
    }
}

/// Points from tolerance to tolerance; hollow where the error says nothing; the first and the last named where no
/// other of the `labels` stands.
fn draw_curve(
    drawing: &mut Drawing,
    number: usize,
    curve: &WorkPrecisionCurve<'_>,
    panel: usize,
    (x, y): (&Scale, &Scale),
    labels: &mut Vec<(f64, f64)>,
) {
    let place = |point: &WorkPoint| {
        let (error, clear) = point.errors[panel]?;
        let at = (x.at(within(logarithm(point.time_s), x.values)), y.at(within(logarithm(error), y.values)));
        Some((at, clear, point.relative_tolerance))
    };
    let places: Vec<_> = curve.points.iter().filter_map(place).collect();
    drawing.curve(number, places.iter().map(|place| place.0));
    for (index, ((at_x, at_y), clear, tolerance)) in places.iter().enumerate() {
        if *clear {
            drawing.dot(number, *at_x, *at_y);
        } else {
            drawing.ring(number, *at_x, *at_y);
        }
        let free = labels.iter().all(|(x, y)| (x - at_x).abs() > LABEL.0 || (y - at_y).abs() > LABEL.1);
        if free && (index == 0 || index + 1 == places.len()) {
            labels.push((*at_x, *at_y));
            let text = format!("{tolerance:e}").replace('-', "−");
            drawing.text("small", Anchor::Start, at_x + 5.0, at_y - 4.0, &text);
        }
    }
}

/// Panel, grid and the numbers at its edges.
fn frame(drawing: &mut Drawing, top: f64, x: &Scale, y: &Scale, unit: &str) {
    let bottom = top + PANEL;
    let (left, right) = x.positions;
    drawing.rectangle("panel", left, top, right - left, PANEL);
    for (value, text) in time_ticks(x.values) {
        let at = x.at(value);
        drawing.line("grid", (at, top), (at, bottom));
        drawing.text("", Anchor::Middle, at, bottom + 17.0, &text);
    }
    for exponent in y.values.0.ceil() as i32..=y.values.1.floor() as i32 {
        let at = y.at(f64::from(exponent));
        drawing.line("grid", (left, at), (right, at));
        drawing.text("", Anchor::End, left - 7.0, at + 4.5, &decade(exponent));
    }
    drawing.upright_text("", 18.0, 0.5 * (top + bottom), unit);
}

/// Logarithms of 1, 2 and 5 times the powers of ten in the range, of the powers alone where it is long.
fn time_ticks((from, to): (f64, f64)) -> Vec<(f64, String)> {
    let multiples: &[i32] = if to - from > 2.5 { &[1] } else { &[1, 2, 5] };
    let mut ticks = Vec::new();
    for exponent in from.floor() as i32..=to.ceil() as i32 {
        for &multiple in multiples {
            let value = f64::from(multiple).log10() + f64::from(exponent);
            let text = match (multiple, exponent) {
                (1, _) => decade(exponent),
                (_, 0..) => format!("{:.0}", f64::from(multiple) * 10f64.powi(exponent)),
                _ => format!("{:.*}", exponent.unsigned_abs() as usize, f64::from(multiple) * 10f64.powi(exponent)),
            };
            if (from..=to).contains(&value) {
                ticks.push((value, text));
            }
        }
    }
    ticks
}

/// Logarithms of the shortest and the longest time, a little wider.
fn time_range(curves: &[WorkPrecisionCurve<'_>]) -> (f64, f64) {
    let ended = curves.iter().flat_map(|curve| &curve.points).map(|point| point.time_s);
    let failed = curves.iter().flat_map(|curve| &curve.failures).filter_map(|failure| failure.time_s);
    let (least, most) = extremes(ended.chain(failed));
    if least > most { (-2.0, 1.0) } else { (least - 0.15, most.max(least + 0.5) + 0.25) }
}

/// Whole decades that hold the errors and the floor.
fn error_range(curves: &[WorkPrecisionCurve<'_>], panel: usize, floor: Option<f64>) -> (f64, f64) {
    let errors = curves.iter().flat_map(|curve| &curve.points).filter_map(|point| Some(point.errors[panel]?.0));
    let (least, most) = extremes(errors.chain(floor));
    if least > most {
        return (-8.0, 0.0);
    }
    let (from, to) = (least.floor() as i32, (most + 0.1).ceil() as i32);
    let from = from.min(to - 2).max(to - MOST_DECADES);
    (f64::from(from), f64::from(to))
}

/// Least and largest logarithm; infinite and crossed where there is none.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logarithms = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
    logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
}

fn logarithm(value: f64) -> f64 {
    value.max(f64::MIN_POSITIVE).log10()
}

fn within(value: f64, (from, to): (f64, f64)) -> f64 {
    value.clamp(from, to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    fn curve(name: &str, slope: f64) -> WorkPrecisionCurve<'_> {
        let point = |k: i32| WorkPoint {
            relative_tolerance: 10f64.powi(-k),
            time_s: 0.1 * slope.powi(k),
            errors: [Some((10f64.powi(-k), k < 6)), (k > 3).then(|| (10f64.powi(1 - k), true))],
        };
        WorkPrecisionCurve { name, points: (3..8).map(point).collect(), failures: Vec::new() }
    }

    #[test]
    fn picture_has_methods_tolerances_floor_and_failures() {
        let mut failing = curve("radau", 1.2);
        failing.failures = vec![
            FailedRun { relative_tolerance: 1e-3, time_s: Some(7.0) },
            FailedRun { relative_tolerance: 1e-4, time_s: None },
        ];
        let svg = work_precision_svg("t", "s", &[curve("gear", 1.5), failing], [Some(1e-6), None]);
        assert_well_formed(&svg);
        for text in ["gear", "radau failed at 1e-3, 1e-4 (not tried)", "1e−3", "own error", "dB", "class=\"ring"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg.matches("class=\"floor\"").count(), 1);
    }

    #[test]
    fn nothing_zeros_and_a_single_point_are_drawn_too() {
        assert_well_formed(&work_precision_svg("t", "s", &[], [None, None]));
        let still = WorkPoint { relative_tolerance: 1e-3, time_s: 0.0, errors: [Some((0.0, false)), None] };
        let curve = WorkPrecisionCurve { name: "gear", points: vec![still], failures: Vec::new() };
        assert_well_formed(&work_precision_svg("t", "s", &[curve], [Some(0.0), Some(1e-300)]));
    }

    #[test]
    fn short_time_axes_have_finer_ticks() {
        let texts = |range| time_ticks(range).into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        assert_eq!(texts((-1.1, 1.1)), ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(texts((-2.0, 2.0)), ["0.01", "0.1", "1", "10", "100"]);
    }
}
