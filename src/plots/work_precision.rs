//! Error against run time: one curve for each method, one panel for the level error and one for the trajectory error, with
//! logarithmic axes.

use super::axis::{Scale, decade};
use super::svg::{Anchor, Drawing};

/// One method at its tolerances, or one part of a machine with several numbers of modes.
pub struct WorkPrecisionCurve<'a> {
    pub name: &'a str,
    /// Points, in the order of their settings.
    pub points: Vec<WorkPoint>,
    pub failures: Vec<FailedRun>,
}

/// A finished run.
#[derive(Debug, Clone)]
pub struct WorkPoint {
    /// Setting of the run, as a label at the ends of a curve; `None` for a curve without settings.
    pub label: Option<String>,
    pub time_s: f64,
    /// Errors in the order of the panels: value, and whether it exceeds the error of the reference.
    pub errors: [Option<(f64, bool)>; 2],
}

/// A failed run; without a time it was not tried.
#[derive(Debug, Clone)]
pub struct FailedRun {
    pub label: String,
    pub time_s: Option<f64>,
}

/// Width that is readable at its own size in a column of 600 px.
const WIDTH: f64 = 640.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 16.0;
/// Position of the first row of the legend, and the distance of rows.
const LEGEND: f64 = 76.0;
const LEGEND_PITCH: f64 = 20.0;
/// Distance from the last row of the legend to the first panel.
const HEADING: f64 = 42.0;
const PANEL: f64 = 250.0;
const PITCH: f64 = PANEL + 66.0;
/// Height of a line of text below the panels, and of the lines that every plot has.
const LINE: f64 = 18.0;
const BOTTOM: f64 = 74.0;
/// Height of the strip at a panel's top where failures are marked.
const STRIP: f64 = 20.0;
/// Width of a letter in legends and in labels of points, of DejaVu, the widest common sans serif.
const LETTER: f64 = 7.8;
const SMALL_LETTER: f64 = 8.0;
const SMALL_HEIGHT: f64 = 9.0;
/// Radius of a mark, and the distance of labels from marks.
const MARK: f64 = 3.5;
/// Smallest range of a panel: decades of error, and decades of time.
const LEAST_DECADES: f64 = 2.0;
const LEAST_TIMES: f64 = 0.6;
/// Largest number of decades of error in a panel.
const MOST_DECADES: f64 = 12.0;
/// Margin around the data [decades]: times, errors.
const MARGIN: (f64, f64) = (0.1, 0.3);
/// Distance of the reference's error below all errors from which on it is not shown [decades].
const FAR_BELOW: f64 = 1.0;
/// A plotted error.
#[derive(Debug, Clone, Copy)]
pub struct ErrorPanel {
    pub name: &'static str,
    pub unit: &'static str,
    /// Error of the reference: smaller errors are not significant.
    pub floor: Option<f64>,
}

/// Two stacked panels, one for each error of the points. `settings`: the meaning of the labels.
pub fn work_precision_svg(
    [title, subtitle, settings]: [&str; 3],
    curves: &[WorkPrecisionCurve<'_>],
    panels: [ErrorPanel; 2],
) -> String {
    let failed: Vec<_> = curves.iter().enumerate().filter(|(_, curve)| !curve.failures.is_empty()).collect();
    let names: Vec<&str> = curves.iter().map(|curve| curve.name).collect();
    let (entries, rows) = legend_places(&names);
    let top = LEGEND + LEGEND_PITCH * (rows - 1) as f64 + HEADING;
    let bottom = top + PITCH + PANEL;
    let height = bottom + BOTTOM + LINE * failed.len() as f64;
    let description = format!("{title}. {subtitle}. Error of {} against their run time.", names.join(", "));
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
    for (number, (name, (x, y))) in names.iter().zip(entries).enumerate() {
        drawing.dot(number, x, y - 4.5);
        drawing.text("", Anchor::Start, x + 9.0, y, name);
    }
    let x = Scale { values: time_range(curves), positions: (LEFT, WIDTH - RIGHT) };
    let mut has_floor = false;
    for (index, ErrorPanel { name, unit, floor }) in panels.into_iter().enumerate() {
        let top = top + index as f64 * PITCH;
        let (range, floor) = error_range(curves, index, floor);
        let y = Scale { values: range, positions: (top + PANEL, top + STRIP) };
        drawing.text("name", Anchor::Start, LEFT, top - 9.0, name);
        frame(&mut drawing, top, &x, &y, unit);
        has_floor |= floor.is_some();
        if let Some(floor) = floor {
            drawing.line("floor", (LEFT, y.at(floor)), (WIDTH - RIGHT, y.at(floor)));
        }
        draw_curves(&mut drawing, top, curves, index, (&x, &y));
    }
    let middle = 0.5 * (LEFT + WIDTH - RIGHT);
    drawing.text("", Anchor::Middle, middle, bottom + 37.0, "run time in s");
    let below = if has_floor { "; dashed line: smaller errors are not significant (hollow marks)" } else { "" };
    let marks = &format!("numbers: {settings}{below}");
    drawing.text("small", Anchor::Middle, 0.5 * WIDTH, bottom + 60.0, marks);
    for (line, (number, curve)) in failed.into_iter().enumerate() {
        let at = bottom + 84.0 + LINE * line as f64;
        drawing.cross(number, 24.0, at - 4.0);
        drawing.text("small", Anchor::Start, 36.0, at, &failures_in_words(curve));
    }
    drawing.finish()
}

/// Positions of the dots and names of the legend, and the number of its rows.
fn legend_places(names: &[&str]) -> (Vec<(f64, f64)>, usize) {
    let (mut x, mut row) = (22.0, 0);
    let mut places = Vec::new();
    for name in names {
        let width = 9.0 + LETTER * name.chars().count() as f64;
        if x > 22.0 && x + width > WIDTH - RIGHT {
            (x, row) = (22.0, row + 1);
        }
        places.push((x, LEGEND + LEGEND_PITCH * f64::from(row)));
        x += width + 18.0;
    }
    (places, row as usize + 1)
}

/// Settings with which a method failed, and those that were not tried afterwards.
fn failures_in_words(curve: &WorkPrecisionCurve<'_>) -> String {
    let listed = |tried: bool| {
        let tolerances = curve.failures.iter().filter(|failure| failure.time_s.is_some() == tried);
        let texts: Vec<String> = tolerances.map(|failure| failure.label.clone()).collect();
        match texts.as_slice() {
            [] => None,
            [first, .., last] if texts.len() > 3 => Some(format!("{first} to {last}")),
            texts => Some(texts.join(", ")),
        }
    };
    match (listed(true), listed(false)) {
        (Some(failed), None) => format!("{} failed at {failed}", curve.name),
        (None, untried) => format!("{} not tried at {}", curve.name, untried.unwrap_or_default()),
        (Some(failed), Some(untried)) => format!("{} failed at {failed}; not tried: {untried}", curve.name),
    }
}

/// A rectangle: left, top, right, bottom.
type Frame = (f64, f64, f64, f64);
/// A straight line from a position to another.
type Segment = ((f64, f64), (f64, f64));

fn overlap(a: Frame, b: Frame) -> bool {
    a.0 < b.2 && b.0 < a.2 && a.1 < b.3 && b.1 < a.3
}

/// Position of a point in a panel, whether its error is significant, and its label; `None` without this error.
fn placed<'a>(
    point: &'a WorkPoint,
    panel: usize,
    (x, y): (&Scale, &Scale),
) -> Option<((f64, f64), bool, Option<&'a str>)> {
    let (error, clear) = point.errors[panel]?;
    let at = (x.at(within(logarithm(point.time_s), x.values)), y.at(within(logarithm(error), y.values)));
    Some((at, clear, point.label.as_deref()))
}

/// Curves with their marks, hollow where the error is not significant, and the tolerances at the ends of each curve where they fit.
fn draw_curves(
    drawing: &mut Drawing,
    top: f64,
    curves: &[WorkPrecisionCurve<'_>],
    panel: usize,
    (x, y): (&Scale, &Scale),
) {
    let places: Vec<Vec<_>> = curves
        .iter()
        .map(|curve| curve.points.iter().filter_map(|point| placed(point, panel, (x, y))).collect())
        .collect();
    let mut taken: Vec<Frame> = Vec::new();
    for (number, (curve, places)) in curves.iter().zip(&places).enumerate() {
        drawing.curve(number, places.iter().map(|place| place.0));
        for &((at_x, at_y), clear, _) in places {
            if clear {
                drawing.dot(number, at_x, at_y);
            } else {
                drawing.ring(number, at_x, at_y);
            }
            taken.push((at_x - MARK, at_y - MARK, at_x + MARK, at_y + MARK));
        }
        for time in curve.failures.iter().filter_map(|failure| failure.time_s) {
            drawing.cross(number, x.at(within(logarithm(time), x.values)), top + 0.5 * STRIP);
        }
    }
    let segments: Vec<_> = places.iter().flat_map(|places| places.windows(2).map(|two| (two[0].0, two[1].0))).collect();
    for places in &places {
        let ends = [places.first(), places.last().filter(|_| places.len() > 1)];
        let labelled = ends.into_iter().flatten().filter_map(|&(at, _, label)| Some((at, label?)));
        for ((at_x, at_y), label) in labelled {
            let text = label.replace('-', "−");
            let width = SMALL_LETTER * text.chars().count() as f64;
            let inside: Frame = (LEFT, top + STRIP - SMALL_HEIGHT, WIDTH - RIGHT, top + PANEL);
            if let Some((left, bottom)) = free_place((at_x, at_y), width, inside, &taken, &segments) {
                taken.push((left, bottom - SMALL_HEIGHT, left + width, bottom));
                drawing.text("small", Anchor::Start, left, bottom, &text);
            }
        }
    }
}

/// Left end and base line of a label at a point, clear of marks, other labels and curves; `None` where there is no such position.
fn free_place(
    (x, y): (f64, f64),
    width: f64,
    inside: Frame,
    taken: &[Frame],
    segments: &[Segment],
) -> Option<(f64, f64)> {
    let (right, left, centre) = (x + 6.0, x - 6.0 - width, x - 0.5 * width);
    let (above, level, below) = (y - 5.0, y + 0.5 * SMALL_HEIGHT, y + 5.0 + SMALL_HEIGHT);
    let places = [
        (right, above),
        (left, above),
        (right, below),
        (left, below),
        (right, level),
        (left, level),
        (centre, above - 2.0),
        (centre, below + 2.0),
    ];
    places.into_iter().find(|&(left, bottom)| {
        let label = (left - 1.0, bottom - SMALL_HEIGHT - 1.0, left + width + 1.0, bottom + 1.0);
        let is_inside = inside.0 < label.0 && inside.1 < label.1 && label.2 < inside.2 && label.3 < inside.3;
        is_inside
            && !taken.iter().any(|&other| overlap(label, other))
            && !segments.iter().any(|&segment| crosses(segment, label))
    })
}

/// True if a straight line crosses a rectangle, by clipping it at each side.
fn crosses(((x, y), to): Segment, frame: Frame) -> bool {
    let (dx, dy) = (to.0 - x, to.1 - y);
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    for (slope, from, low, high) in [(dx, x, frame.0, frame.2), (dy, y, frame.1, frame.3)] {
        if slope == 0.0 {
            if from < low || from > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - from) / slope, (high - from) / slope);
        (begin, end) = (begin.max(a.min(b)), end.min(a.max(b)));
    }
    begin <= end
}

/// Panel, grid and axis labels.
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

/// Logarithms of the tick values: round multiples of the powers of ten in the range, fewer in a long range.
fn time_ticks((from, to): (f64, f64)) -> Vec<(f64, String)> {
    let multiples: &[i32] = match to - from {
        0.0..0.9 => &[1, 2, 3, 5, 7],
        0.9..2.5 => &[1, 2, 5],
        _ => &[1],
    };
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

/// Logarithms of the shortest and the longest time, with a margin.
fn time_range(curves: &[WorkPrecisionCurve<'_>]) -> (f64, f64) {
    let ended = curves.iter().flat_map(|curve| &curve.points).map(|point| point.time_s);
    let failed = curves.iter().flat_map(|curve| &curve.failures).filter_map(|failure| failure.time_s);
    let (least, most) = extremes(ended.chain(failed));
    if least > most { (-2.0, 1.0) } else { at_least(LEAST_TIMES, (least - MARGIN.0, most + MARGIN.0)) }
}

/// Logarithms of the smallest and the largest error, with a margin, and with the error of the reference where it is near.
fn error_range(curves: &[WorkPrecisionCurve<'_>], panel: usize, floor: Option<f64>) -> ((f64, f64), Option<f64>) {
    let errors = curves.iter().flat_map(|curve| &curve.points).filter_map(|point| Some(point.errors[panel]?.0));
    let floor = floor.filter(|floor| *floor > 0.0 && floor.is_finite()).map(f64::log10);
    let (least, most) = extremes(errors);
    if least > most {
        return ((-8.0, 0.0), floor.filter(|floor| (-8.0..=0.0).contains(floor)));
    }
    let floor = floor.filter(|floor| *floor > (least - FAR_BELOW).max(most - MOST_DECADES));
    let (least, most) = floor.map_or((least, most), |floor| (least.min(floor), most.max(floor)));
    let (from, to) = at_least(LEAST_DECADES, (least - MARGIN.1, most + MARGIN.1));
    ((from.max(to - MOST_DECADES), to), floor)
}

/// The range, widened on both sides to a smallest length.
fn at_least(length: f64, (from, to): (f64, f64)) -> (f64, f64) {
    let missing = (length - (to - from)).max(0.0);
    (from - 0.5 * missing, to + 0.5 * missing)
}

/// Smallest and largest logarithm; infinite and in reverse order where there is none.
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

    fn panels(floors: [Option<f64>; 2]) -> [ErrorPanel; 2] {
        [("level", "dB", floors[0]), ("trajectory", "-", floors[1])].map(|(name, unit, floor)| ErrorPanel {
            name,
            unit,
            floor,
        })
    }

    use crate::plots::svg::assert_well_formed;

    fn curve(name: &str, slope: f64) -> WorkPrecisionCurve<'_> {
        let point = |k: i32| WorkPoint {
            label: Some(format!("1e-{k}")),
            time_s: 0.1 * slope.powi(k),
            errors: [Some((10f64.powi(-k), k < 6)), (k > 3).then(|| (10f64.powi(1 - k), true))],
        };
        WorkPrecisionCurve { name, points: (3..8).map(point).collect(), failures: Vec::new() }
    }

    #[test]
    fn picture_has_methods_tolerances_floor_and_failures() {
        let mut failing = curve("radau", 1.2);
        failing.failures = vec![
            FailedRun { label: "1e-3".into(), time_s: Some(7.0) },
            FailedRun { label: "1e-4".into(), time_s: None },
        ];
        let svg = work_precision_svg(
            ["t", "s", "relative tolerances"],
            &[curve("gear", 1.5), failing],
            panels([Some(1e-6), None]),
        );
        assert_well_formed(&svg);
        for text in ["gear", "radau failed at 1e-3; not tried: 1e-4", "1e−3", "not significant", "dB", "class=\"ring"]
        {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg.matches("class=\"floor\"").count(), 1);
    }

    #[test]
    fn nothing_zeros_and_a_single_point_are_drawn_too() {
        assert_well_formed(&work_precision_svg(["t", "s", "relative tolerances"], &[], panels([None, None])));
        let still = WorkPoint { label: Some("1e-3".into()), time_s: 0.0, errors: [Some((0.0, false)), None] };
        let curve = WorkPrecisionCurve { name: "gear", points: vec![still], failures: Vec::new() };
        assert_well_formed(&work_precision_svg(
            ["t", "s", "relative tolerances"],
            &[curve],
            panels([Some(0.0), Some(1e-300)]),
        ));
    }

    #[test]
    fn axes_end_near_the_data() {
        let curves = [curve("gear", 1.5)];
        let (range, floor) = error_range(&curves, 0, Some(1e-12));
        assert_eq!(floor, None);
        assert!((range.0 + 7.3).abs() < 1e-9 && (range.1 + 2.7).abs() < 1e-9, "{range:?}");
        assert_eq!(error_range(&curves, 0, Some(3e-8)).1, Some(3e-8_f64.log10()));
        let single = [WorkPrecisionCurve { points: curve("a", 1.0).points.split_off(4), ..curve("a", 1.0) }];
        let (from, to) = error_range(&single, 0, None).0;
        assert!((to - from - LEAST_DECADES).abs() < 1e-9);
        let (from, to) = time_range(&single);
        assert!((to - from - LEAST_TIMES).abs() < 1e-9 && time_ticks((from, to)).len() > 1);
    }

    #[test]
    fn labels_stand_on_no_mark_no_curve_and_no_other_label() {
        let label = |taken: &[Frame], segments: &[Segment]| {
            free_place((300.0, 200.0), 30.0, (74.0, 100.0, 624.0, 350.0), taken, segments)
        };
        let mark: Frame = (296.0, 196.0, 304.0, 204.0);
        assert_eq!(label(&[mark], &[]), Some((306.0, 195.0)));
        let right: Frame = (305.0, 150.0, 320.0, 250.0);
        assert_eq!(label(&[mark, right], &[]), Some((264.0, 195.0)));
        assert_eq!(label(&[mark, right], &[((300.0, 200.0), (250.0, 150.0))]), Some((264.0, 214.0)));
        assert_eq!(label(&[(200.0, 100.0, 400.0, 300.0)], &[]), None);
        assert!(crosses(((0.0, 0.0), (10.0, 10.0)), (4.0, 4.0, 6.0, 6.0)));
        assert!(!crosses(((0.0, 0.0), (10.0, 10.0)), (4.0, 0.0, 6.0, 2.0)));
        assert!(!crosses(((0.0, 0.0), (3.0, 3.0)), (4.0, 4.0, 6.0, 6.0)));
    }

    #[test]
    fn a_long_legend_goes_on_in_a_second_row() {
        let five = legend_places(&["gear", "fine_abm", "dormand_prince", "radau", "auto"]);
        assert_eq!((five.0.len(), five.1), (5, 1));
        let long = ["dormand_prince"; 7];
        assert_eq!(legend_places(&long).1, 2);
        assert_eq!(legend_places(&[]).1, 1);
    }

    #[test]
    fn short_time_axes_have_finer_ticks() {
        let texts = |range| time_ticks(range).into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        assert_eq!(texts((-1.1, -0.4)), ["0.1", "0.2", "0.3"]);
        assert_eq!(texts((-1.1, 1.1)), ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(texts((-2.0, 2.0)), ["0.01", "0.1", "1", "10", "100"]);
    }
}
