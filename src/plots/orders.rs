//! Orders of a run: the mean order spectrum, and tracks of orders over the shaft speed.

use super::axis::{Scale, decade, ticks};
use super::svg::{Anchor, COLOURS, Drawing};
use raceway_core::numerics::statistics::thin;

/// Amplitude of one order over the shaft speed.
pub struct TrackCurve<'a> {
    pub name: &'a str,
    /// Mean order.
    pub order: f64,
    pub amplitude: &'a [f64],
}

/// An order analysis.
pub struct OrderPlot<'a> {
    /// Body whose turns an order counts.
    pub reference: &'a str,
    pub unit: &'a str,
    pub resolution: f64,
    /// Entry `k` belongs to order `k · resolution`.
    pub amplitude: &'a [f64],
    /// Shaft speed of each block [r/min].
    pub speed: &'a [f64],
    pub tracks: &'a [TrackCurve<'a>],
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 82.0;
const RIGHT: f64 = 120.0;
const TOP: f64 = 96.0;
const PANEL: f64 = 240.0;
const PITCH: f64 = PANEL + 84.0;
const BOTTOM: f64 = 52.0;
/// Decades of the amplitude axis.
const DECADES: f64 = 4.0;
const MOST_POINTS: usize = 3000;

/// The spectrum above, the tracks below.
pub fn orders_svg(title: &str, subtitle: &str, plot: &OrderPlot<'_>) -> String {
    let names: Vec<&str> = plot.tracks.iter().map(|track| track.name).collect();
    let description = format!("{subtitle}. Order spectrum, and tracks of {} over speed.", names.join(", "));
    let mut drawing = Drawing::new(WIDTH, TOP + PITCH + PANEL + BOTTOM, title, subtitle, &description);
    draw_spectrum(&mut drawing, plot);
    draw_tracks(&mut drawing, plot, TOP + PITCH);
    drawing.finish()
}

fn draw_spectrum(drawing: &mut Drawing, plot: &OrderPlot<'_>) {
    let (right, bottom) = (WIDTH - RIGHT, TOP + PANEL);
    let highest = (plot.amplitude.len().max(2) - 1) as f64 * plot.resolution;
    let largest = plot.amplitude.iter().copied().fold(0.0, f64::max);
    let x = Scale { values: (0.0, highest), positions: (LEFT, right) };
    let y = decades(largest, (bottom, TOP));
    drawing.rectangle("panel", LEFT, TOP, right - LEFT, PANEL);
    for (value, text) in ticks(x.values, 10) {
        drawing.line("grid", (x.at(value), TOP), (x.at(value), bottom));
        drawing.text("", Anchor::Middle, x.at(value), bottom + 17.0, &text);
    }
    draw_decades(drawing, &y, right);
    let places = thin(plot.amplitude, MOST_POINTS);
    drawing
        .curve(0, places.into_iter().map(|k| (x.at(k as f64 * plot.resolution), y.at(level(plot.amplitude[k], &y)))));
    let mut free = 0.0;
    let mut tracks: Vec<&TrackCurve<'_>> = plot.tracks.iter().filter(|track| track.order <= highest).collect();
    tracks.sort_by(|one, other| one.order.total_cmp(&other.order));
    for track in tracks {
        let at = x.at(track.order);
        drawing.line("floor", (at, TOP), (at, bottom));
        let width = 8.0 * track.name.chars().count() as f64;
        let place = f64::max(at, free + 0.5 * width);
        free = place + 0.5 * width + 4.0;
        drawing.text("", Anchor::Middle, place, TOP - 8.0, track.name);
    }
    drawing.upright_text("", 18.0, TOP + 0.5 * PANEL, plot.unit);
    let name = format!("order: periods in a turn of the {}", plot.reference);
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + right), bottom + 38.0, &name);
}

fn draw_tracks(drawing: &mut Drawing, plot: &OrderPlot<'_>, top: f64) {
    let (right, bottom) = (WIDTH - RIGHT, top + PANEL);
    drawing.rectangle("panel", LEFT, top, right - LEFT, PANEL);
    let speeds = plot.speed.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
    let largest = plot.tracks.iter().flat_map(|track| track.amplitude).copied().fold(0.0, f64::max);
    if plot.speed.is_empty() || largest == 0.0 {
        drawing.text("note", Anchor::Middle, 0.5 * (LEFT + right), top + 0.5 * PANEL, "no amplitude to show");
        return;
    }
    let widened = if speeds.0 < speeds.1 { speeds } else { (speeds.0 - 1.0, speeds.0 + 1.0) };
    let x = Scale { values: widened, positions: (LEFT, right) };
    let y = decades(largest, (bottom, top));
    for (value, text) in ticks(x.values, 8) {
        drawing.line("grid", (x.at(value), top), (x.at(value), bottom));
        drawing.text("", Anchor::Middle, x.at(value), bottom + 17.0, &text);
    }
    draw_decades(drawing, &y, right);
    for (number, track) in plot.tracks.iter().enumerate() {
        let points = || plot.speed.iter().zip(track.amplitude).map(|(speed, a)| (x.at(*speed), y.at(level(*a, &y))));
        let height = top + 14.0 + 18.0 * number as f64;
        let of_legend = [(right + 10.0, height - 4.0), (right + 30.0, height - 4.0)];
        drawing.curve(number, points());
        drawing.curve(number, of_legend);
        // Colours repeat; curves of the second round have dots.
        if number >= COLOURS {
            points().chain(of_legend).for_each(|(x, y)| drawing.dot(number, x, y));
        }
        drawing.text("", Anchor::Start, right + 36.0, height, track.name);
    }
    drawing.upright_text("", 18.0, top + 0.5 * PANEL, plot.unit);
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + right), bottom + 38.0, "shaft speed in r/min");
}

/// Scale of the decades below the largest amplitude.
fn decades(largest: f64, positions: (f64, f64)) -> Scale {
    let highest = largest.max(f64::MIN_POSITIVE).log10().ceil();
    Scale { values: (highest - DECADES, highest), positions }
}

/// Logarithm of an amplitude within a scale.
fn level(amplitude: f64, y: &Scale) -> f64 {
    amplitude.max(f64::MIN_POSITIVE).log10().clamp(y.values.0, y.values.1)
}

fn draw_decades(drawing: &mut Drawing, y: &Scale, right: f64) {
    for exponent in y.values.0 as i32..=y.values.1 as i32 {
        let at = y.at(f64::from(exponent));
        drawing.line("grid", (LEFT, at), (right, at));
        drawing.text("", Anchor::End, LEFT - 7.0, at + 4.5, &decade(exponent));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn a_plot_has_both_panels_and_the_names_of_tracks() {
        let tracks = [TrackCurve { name: "BPFO", order: 3.5, amplitude: &[1.0, 2.0] }];
        let mut plot = OrderPlot {
            reference: "shaft",
            unit: "m/s²",
            resolution: 0.5,
            amplitude: &[0.0, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0, 2.0, 0.0],
            speed: &[600.0, 3000.0],
            tracks: &tracks,
        };
        let svg = orders_svg("Orders", "s", &plot);
        assert_well_formed(&svg);
        assert!(svg.matches(">BPFO<").count() == 2 && svg.contains("turn of the shaft") && svg.contains("r/min"));
        (plot.amplitude, plot.speed, plot.tracks) = (&[], &[], &[]);
        assert_well_formed(&orders_svg("Orders", "s", &plot));
    }
}
