//! Waterfalls: amplitude in colour over frequency or order and shaft speed, with labelled orders. Axes are vectors, the colours a picture.

use super::axis::{Scale, ticks};
use super::png::{Picture, base64};
use super::shade::shade_name;
use super::svg::{Anchor, Drawing};

/// A waterfall; rows in the order of time.
pub struct Waterfall<'a> {
    /// Name of the axis to the right, with its unit.
    pub axis_name: &'a str,
    /// Shaft speed [r/min] and time [s] of each row.
    pub speed: &'a [f64],
    pub time: &'a [f64],
    /// Entry `k` of a row belongs to `k · resolution`.
    pub resolution: f64,
    pub columns: usize,
    /// Row after row.
    pub amplitude: &'a [f32],
    pub unit: &'a str,
    pub lines: Vec<OrderLine<'a>>,
}

/// A labelled order.
pub struct OrderLine<'a> {
    pub name: &'a str,
    /// Its place on the axis in each row.
    pub at: Vec<f64>,
}

const WIDTH: f64 = 860.0;
const LEFT: f64 = 86.0;
const RIGHT: f64 = 100.0;
const TOP: f64 = 100.0;
const PANEL: f64 = 440.0;
const BOTTOM: f64 = 56.0;
/// The colour bar: distance from the panel, and width.
const BAR: (f64, f64) = (14.0, 16.0);
const SHADES: usize = 32;
/// Pixels of the embedded picture for each unit of length.
const DENSITY: f64 = 1.5;

/// Quantity along the vertical axis.
struct Upwards<'a> {
    name: &'static str,
    of_row: &'a [f64],
}

impl<'a> Waterfall<'a> {
    /// Speed where it only rises or only falls, else time.
    fn upwards(&self) -> Upwards<'a> {
        let is_monotonic = self.speed.len() < 2
            || self.speed.is_sorted_by(|one, next| one < next)
            || self.speed.is_sorted_by(|one, next| one > next);
        match is_monotonic {
            true => Upwards { name: "shaft speed in r/min", of_row: self.speed },
            false => Upwards { name: "time in s", of_row: self.time },
        }
    }

    /// Largest amplitude, and the level of the darkest colour [dB] relative to it.
    fn largest(&self) -> f32 {
        self.amplitude.iter().copied().fold(0.0, f32::max)
    }

    /// The colours of a picture: the largest amplitude of the bins in a pixel, from the row next to it.
    pub fn picture(&self, width: usize, height: usize, range_db: f64) -> Picture {
        let largest = f64::from(self.largest());
        let of_row = self.upwards().of_row;
        let (low, high) = ends(of_row);
        let mut pixels = Vec::with_capacity(width * height);
        for line in 0..height {
            let at = high - (line as f64 + 0.5) / height as f64 * (high - low);
            let row = nearest(of_row, at);
            for pixel in 0..width {
                let edge = |pixel: usize| pixel * self.columns / width;
                let bins = edge(pixel)..edge(pixel + 1).max(edge(pixel) + 1).min(self.columns);
                let bins = row * self.columns + bins.start..row * self.columns + bins.end;
                let values = self.amplitude.get(bins).unwrap_or_default();
                let amplitude = f64::from(values.iter().copied().fold(0.0, f32::max));
                let decibels = if amplitude > 0.0 { 20.0 * (amplitude / largest).log10() } else { f64::NEG_INFINITY };
                pixels.push((255.0 * (1.0 + decibels / range_db).clamp(0.0, 1.0)).round() as u8);
            }
        }
        Picture { width, height, pixels }
    }

    /// The waterfall with axes.
    pub fn svg(&self, title: &str, subtitle: &str, range_db: f64) -> String {
        let names: Vec<&str> = self.lines.iter().map(|line| line.name).collect();
        let upwards = self.upwards();
        let description = format!(
            "{subtitle}. {} over {} and {}. Orders: {}.",
            self.unit,
            self.axis_name,
            upwards.name,
            names.join(", ")
        );
        let mut drawing = Drawing::new(WIDTH, TOP + PANEL + BOTTOM, title, subtitle, &description);
        let (right, bottom) = (WIDTH - RIGHT, TOP + PANEL);
        let highest = (self.columns as f64 * self.resolution).max(f64::MIN_POSITIVE);
        let x = Scale { values: (0.0, highest), positions: (LEFT, right) };
        let y = Scale { values: ends(upwards.of_row), positions: (bottom, TOP) };
        drawing.rectangle("panel", LEFT, TOP, right - LEFT, PANEL);
        if self.amplitude.is_empty() {
            drawing.text("note", Anchor::Middle, 0.5 * (LEFT + right), TOP + 0.5 * PANEL, "no row is complete");
            return drawing.finish();
        }
        let pixels = |length: f64| (DENSITY * length) as usize;
        let picture = self.picture(pixels(right - LEFT), pixels(PANEL), range_db);
        drawing.image(LEFT, TOP, right - LEFT, PANEL, &base64(&picture.png()));
        for (value, text) in ticks(x.values, 10) {
            drawing.line("leader", (x.at(value), bottom), (x.at(value), bottom + 5.0));
            drawing.text("", Anchor::Middle, x.at(value), bottom + 19.0, &text);
        }
        for (value, text) in ticks(y.values, 8) {
            drawing.line("leader", (LEFT - 5.0, y.at(value)), (LEFT, y.at(value)));
            drawing.text("", Anchor::End, LEFT - 8.0, y.at(value) + 4.5, &text);
        }
        drawing.text("", Anchor::Middle, 0.5 * (LEFT + right), bottom + 42.0, self.axis_name);
        drawing.upright_text("", 18.0, 0.5 * (TOP + bottom), upwards.name);
        self.draw_orders(&mut drawing, &x, &y, upwards.of_row);
        self.bar(&mut drawing, range_db, right + BAR.0);
        drawing.finish()
    }

    /// Dashed lines of the orders, with their names where they leave the panel.
    fn draw_orders(&self, drawing: &mut Drawing, x: &Scale, y: &Scale, of_row: &[f64]) {
        let (mut free, is_inside) = (LEFT, |at: f64| (x.values.0..=x.values.1).contains(&at));
        let mut labels: Vec<(f64, f64, &str)> = Vec::new();
        for line in &self.lines {
            let points: Vec<(f64, f64)> =
                line.at.iter().copied().zip(of_row.iter().copied()).filter(|(at, _)| is_inside(*at)).collect();
            drawing.order(points.iter().map(|(at, up)| (x.at(*at), y.at(*up))));
            let highest = points.iter().max_by(|one, other| one.1.total_cmp(&other.1));
            labels.extend(highest.map(|(at, up)| (x.at(*at), y.at(*up), line.name)));
        }
        labels.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (at, up, name) in labels {
            // A name that would cover the one before it is moved to the right.
            let width = 8.0 * name.chars().count() as f64;
            let place = at.max(free + 0.5 * width);
            free = place + 0.5 * width + 4.0;
            let level = if up > TOP + 40.0 { up - 6.0 } else { TOP - 8.0 };
            drawing.text("", Anchor::Middle, place, level, name);
        }
    }

    /// The colours with their amplitudes relative to the largest.
    fn bar(&self, drawing: &mut Drawing, range_db: f64, left: f64) {
        let bottom = TOP + PANEL;
        let height = PANEL / SHADES as f64;
        for k in 0..SHADES {
            let share = (k as f64 + 0.5) / SHADES as f64;
            drawing.filled(&shade_name(share), left, bottom - (k + 1) as f64 * height, BAR.1, height + 0.4);
        }
        let scale = Scale { values: (-range_db, 0.0), positions: (bottom, TOP) };
        for (value, text) in ticks(scale.values, 6) {
            drawing.text("", Anchor::Start, left + BAR.1 + 6.0, scale.at(value) + 4.5, &text);
        }
        let text = format!("dB re {:.3} {}", self.largest(), self.unit);
        drawing.text("small", Anchor::End, WIDTH - 8.0, bottom + 19.0, &text);
    }
}

/// Least and greatest value; a single one lies in the middle.
fn ends(values: &[f64]) -> (f64, f64) {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    if least < most { (least, most) } else { (least.min(0.0), least.max(0.0) + 1.0) }
}

/// Place of the value next to another, in a list that only rises or only falls.
fn nearest(values: &[f64], at: f64) -> usize {
    let rises = values.first() <= values.last();
    let after = values.partition_point(|value| if rises { *value < at } else { *value > at });
    let far = |place: usize| values.get(place).map_or(f64::INFINITY, |value| (value - at).abs());
    if after > 0 && far(after - 1) <= far(after) { after - 1 } else { after }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    fn waterfall<'a>(speed: &'a [f64], time: &'a [f64], amplitude: &'a [f32]) -> Waterfall<'a> {
        let lines = vec![OrderLine { name: "BPFO", at: vec![1.0, 2.0, 3.0] }];
        Waterfall {
            axis_name: "frequency in Hz",
            speed,
            time,
            resolution: 1.0,
            columns: 4,
            amplitude,
            unit: "m/s²",
            lines,
        }
    }

    #[test]
    fn pixels_show_the_row_of_their_speed_and_the_peak_of_their_bins() {
        let amplitude = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.01];
        let falling = waterfall(&[3000.0, 2000.0, 1000.0], &[0.0, 1.0, 2.0], &amplitude);
        let picture = falling.picture(4, 5, 40.0);
        assert_eq!(picture.pixels[..4], [0, 255, 0, 0], "the fastest row is at the top");
        assert_eq!(picture.pixels[8..12], [0, 0, 128, 0]);
        assert_eq!(picture.pixels[16..], [0, 0, 0, 0]);
        assert_eq!(falling.picture(2, 1, 40.0).pixels, [0, 128]);
        let svg = falling.svg("Waterfall", "a < b", 40.0);
        assert_well_formed(&svg);
        for text in ["BPFO", "frequency in Hz", "shaft speed in r/min", "data:image/png;base64,iVBORw0KGgo"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(waterfall(&[1.0, 2.0, 1.0], &[0.0, 1.0, 2.0], &amplitude).svg("t", "s", 40.0).contains("time in s"));
        assert_well_formed(&waterfall(&[], &[], &[]).svg("t", "s", 40.0));
        assert_well_formed(&waterfall(&[5.0], &[1.0], &[0.0; 4]).svg("t", "s", 40.0));
    }
}
