//! Spectra: one panel for each channel, logarithmic amplitude against linear frequency, with labels of the strongest lines.

use super::axis::{Scale, decade, ticks};
use super::svg::{Anchor, Drawing};
use raceway_core::numerics::statistics::thin;
use raceway_core::simulation::result::lines::Line;

/// One channel's spectrum.
pub struct SpectrumCurve<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    pub resolution_hz: f64,
    /// Entry `k` belongs to `k · resolution_hz`.
    pub amplitude: &'a [f64],
    /// Strongest first.
    pub lines: &'a [Line],
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 18.0;
/// Height of the headings above the first panel.
const TOP: f64 = 66.0;
/// Height of a panel's frame, and from one frame to the next.
const PANEL: f64 = 236.0;
const PITCH: f64 = PANEL + 46.0;
const BOTTOM: f64 = 48.0;

/// Highest frequency shown [Hz].
const HIGHEST: f64 = 20_000.0;
/// Amplitude of a line without label, relative to the strongest line, from which on the axis includes it [-].
const STRONG: f64 = 0.02;
/// Length of the frequency axis divided by the frequency of the last shown line [-].
const BEYOND_LAST_LINE: f64 = 1.2;
/// Smallest and largest number of decades; within them, down to the quietest tenth of the spectrum.
const DECADES: (i32, i32) = (2, 6);
const MOST_LABELS: usize = 8;
const LABEL_ROWS: usize = 3;
const ROW: f64 = 17.0;
const LABEL_STRIP: f64 = LABEL_ROWS as f64 * ROW + 8.0;
/// Number of placements tried for a set of labels before the weakest label is dropped.
const SEARCH_LIMIT: usize = 20_000;
/// Upper estimate of the mean width of a character of a label.
const CHARACTER: f64 = 7.6;

/// Upper end of the frequency axis [Hz]: it includes each labelled or strong line, up to 20 kHz and the end of the spectrum. Without lines it
/// is that maximum.
fn highest_shown(curves: &[SpectrumCurve<'_>]) -> f64 {
    let reach = curves.iter().map(|c| c.amplitude.len().saturating_sub(1) as f64 * c.resolution_hz).fold(0.0, f64::max);
    let all = if reach > 0.0 { reach.min(HIGHEST) } else { HIGHEST };
    let shown = |curve: &SpectrumCurve<'_>| {
        let strongest = curve.lines.iter().fold(0.0, |most, line| f64::max(most, line.amplitude));
        let counts = |line: &&Line| !line.label.is_empty() || line.amplitude >= STRONG * strongest;
        curve.lines.iter().filter(counts).fold(0.0, |last, line| f64::max(last, line.frequency))
    };
    let last = curves.iter().map(shown).fold(0.0, f64::max);
    if last == 0.0 {
        return all;
    }
    // Rounded up to the next half or whole multiple of the power of ten below.
    let step = 0.5 * 10f64.powf(last.log10().floor());
    ((BEYOND_LAST_LINE * last / step).ceil() * step).min(all)
}

/// Stacked spectra on one amplitude scale, up to the last line and at most 20 kHz; `waterfall`: address of the waterfall to see instead.
pub fn spectrum_svg(title: &str, subtitle: &str, curves: &[SpectrumCurve<'_>], waterfall: Option<&str>) -> String {
    let height = TOP + 22.0 + curves.len().max(1) as f64 * PITCH - 46.0 + BOTTOM;
    let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description(subtitle, curves));
    if let Some(waterfall) = waterfall {
        drawing.link(Anchor::End, WIDTH - RIGHT, 30.0, "see the waterfall", waterfall);
    }
    let highest = highest_shown(curves);
    let mut bottom = TOP + 22.0;
    for (number, curve) in curves.iter().enumerate() {
        let top = TOP + 22.0 + number as f64 * PITCH;
        bottom = top + PANEL;
        let x = Scale { values: (0.0, highest), positions: (LEFT, WIDTH - RIGHT) };
        // Channels of one unit share the scale, so that they can be compared.
        let alike: Vec<_> = curves.iter().filter(|other| other.unit == curve.unit).collect();
        let (floor, ceiling) = amplitude_range(&alike, highest);
        let y = Scale { values: (f64::from(floor), ceiling), positions: (bottom, top + LABEL_STRIP) };
        drawing.text("name", Anchor::Start, LEFT, top - 8.0, curve.name);
        frame(&mut drawing, top, &x, &y, curve.unit);
        let drawn = draw_curve(&mut drawing, number, curve, &x, &y);
        if !drawn {
            let note = format!("nothing above {} {}", decade(floor), curve.unit);
            drawing.text("note", Anchor::Middle, x.at(0.5 * highest), top + 0.5 * PANEL, &note);
        } else {
            draw_labels(&mut drawing, number, curve, top, &x, &y);
        }
    }
    let resolution = curves.first().map_or(String::new(), |curve| {
        format!(" (one-sided amplitude, resolution {} Hz)", significant(curve.resolution_hz))
    });
    let caption = format!("frequency in kHz{resolution}");
    drawing.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), bottom + 40.0, &caption);
    drawing.finish()
}

/// Panel, grid and axis labels.
fn frame(drawing: &mut Drawing, top: f64, x: &Scale, y: &Scale, unit: &str) {
    let bottom = top + PANEL;
    let (left, right) = x.positions;
    drawing.rectangle("panel", left, top, right - left, PANEL);
    for (kilohertz, text) in ticks((0.0, x.values.1 / 1e3), 10) {
        let at = x.at(1e3 * kilohertz);
        drawing.line("grid", (at, top), (at, bottom));
        drawing.text("", Anchor::Middle, at, bottom + 17.0, &text);
    }
    for exponent in y.values.0 as i32..=y.values.1.floor() as i32 {
        let at = y.at(f64::from(exponent));
        drawing.line("grid", (left, at), (right, at));
        drawing.text("", Anchor::End, left - 7.0, at + 4.5, &decade(exponent));
    }
    drawing.upright_text("", 18.0, 0.5 * (y.positions.0 + y.positions.1), unit);
}

/// The curve, thinned so that peaks are kept; false where all of it is below the axis.
fn draw_curve(drawing: &mut Drawing, number: usize, curve: &SpectrumCurve<'_>, x: &Scale, y: &Scale) -> bool {
    let shown = shown(curve, x.values.1);
    let logarithm = |amplitude: f64| amplitude.max(f64::MIN_POSITIVE).log10().max(y.values.0);
    if !shown.iter().any(|&amplitude| logarithm(amplitude) > y.values.0) {
        return false;
    }
    // Two points per unit of width are as fine as a screen resolves.
    let points = thin(shown, 2 * (WIDTH - LEFT - RIGHT) as usize);
    drawing.curve(
        number,
        points
            .into_iter()
            .skip_while(|&bin| bin == 0)
            .map(|bin| (x.at(bin as f64 * curve.resolution_hz), y.at(logarithm(shown[bin])))),
    );
    true
}

/// Position of a label: its row, counted from the lowest, its extent, and the position of its line.
#[derive(Debug)]
struct Label {
    row: usize,
    from: f64,
    to: f64,
    at: f64,
}

impl Label {
    /// True if the texts overlap, or the leader of the higher label crosses the text of the lower one.
    fn collides(&self, other: &Label) -> bool {
        let (upper, lower) = if self.row > other.row { (self, other) } else { (other, self) };
        if upper.row == lower.row {
            upper.from < lower.to && lower.from < upper.to
        } else {
            upper.at > lower.from - 2.0 && upper.at < lower.to + 2.0
        }
    }
}

/// Labels of the strongest lines in the strip above the curve, as many as fit, each with a leader to its line.
fn draw_labels(drawing: &mut Drawing, number: usize, curve: &SpectrumCurve<'_>, top: f64, x: &Scale, y: &Scale) {
    let visible = |line: &&Line| line.frequency <= x.values.1 && line.amplitude.log10() > y.values.0;
    let lines: Vec<&Line> = curve.lines.iter().filter(visible).take(MOST_LABELS).collect();
    let texts: Vec<String> = lines
        .iter()
        .map(|line| match line.label.as_str() {
            "" => format!("{:.2} kHz", line.frequency / 1e3),
            label => label.to_owned(),
        })
        .collect();
    let wanted: Vec<(f64, f64)> = lines
        .iter()
        .zip(&texts)
        .map(|(line, text)| (x.at(line.frequency), CHARACTER * text.chars().count() as f64 + 4.0))
        .collect();
    for ((line, text), label) in lines.iter().zip(&texts).zip(arranged(&wanted, x.positions)) {
        let baseline = top + LABEL_STRIP - 8.0 - label.row as f64 * ROW;
        let peak = y.at(line.amplitude.log10()).max(baseline + 6.0);
        drawing.line("leader", (label.at, baseline + 3.5), (label.at, peak));
        drawing.dot(number, label.at, peak);
        drawing.text("label", Anchor::Middle, 0.5 * (label.from + label.to), baseline, text);
    }
}

/// Positions of labels (position, width), strongest first, for the largest number of labels that a short search places without overlap.
fn arranged(wanted: &[(f64, f64)], edges: (f64, f64)) -> Vec<Label> {
    for count in (1..=wanted.len()).rev() {
        let (mut placed, mut tries) = (Vec::new(), SEARCH_LIMIT);
        if place_all(&wanted[..count], edges, &mut placed, &mut tries) {
            return placed;
        }
    }
    Vec::new()
}

/// Places the remaining labels by backtracking, low rows and centred texts first.
fn place_all(wanted: &[(f64, f64)], edges: (f64, f64), placed: &mut Vec<Label>, tries: &mut usize) -> bool {
    let Some(&(at, width)) = wanted.get(placed.len()) else { return true };
    for row in 0..LABEL_ROWS {
        for share in [0.5, 0.06, 0.94, 0.3, 0.7] {
            let from = (at - share * width).clamp(edges.0 + 2.0, edges.1 - width - 2.0);
            let label = Label { row, from, to: from + width, at };
            if *tries == 0 {
                return false;
            }
            *tries -= 1;
            if placed.iter().any(|other| label.collides(other)) {
                continue;
            }
            placed.push(label);
            if place_all(wanted, edges, placed, tries) {
                return true;
            }
            placed.pop();
        }
    }
    false
}

/// Decade at the bottom and logarithm at the top of the amplitude axis.
fn amplitude_range(curves: &[&SpectrumCurve<'_>], highest: f64) -> (i32, f64) {
    let mut all: Vec<f64> =
        curves.iter().flat_map(|curve| shown(curve, highest)).copied().filter(|a| *a > 0.0 && a.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let Some(largest) = all.last().copied() else { return (-3, 0.0) };
    let quiet = all[all.len() / 10].log10().floor() as i32;
    let ceiling = largest.log10();
    let top = ceiling.floor() as i32;
    (quiet.clamp(top - DECADES.1, top - DECADES.0), ceiling + 0.05)
}

fn shown<'a>(curve: &SpectrumCurve<'a>, highest: f64) -> &'a [f64] {
    let bins = if curve.resolution_hz > 0.0 { (highest / curve.resolution_hz + 1e-9) as usize + 1 } else { 0 };
    &curve.amplitude[..bins.min(curve.amplitude.len())]
}

/// Text description of the plot.
fn description(subtitle: &str, curves: &[SpectrumCurve<'_>]) -> String {
    let mut text = format!("{subtitle}. One-sided spectra, logarithmic amplitude over frequency.");
    for curve in curves {
        let lines: Vec<String> = curve
            .lines
            .iter()
            .take(MOST_LABELS)
            .map(|line| {
                let name = if line.label.is_empty() { "a line" } else { &line.label };
                format!("{name} at {:.1} Hz with {} {}", line.frequency, significant(line.amplitude), curve.unit)
            })
            .collect();
        let lines = if lines.is_empty() { "no lines".to_owned() } else { lines.join(", ") };
        text += &format!(" {}: {lines}.", curve.name);
    }
    text
}

/// The number in three significant digits.
fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let decimals = 2 - value.abs().log10().floor() as i32;
    match decimals {
        0..=6 => {
            let text = format!("{value:.*}", decimals as usize);
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
        -4..0 => format!("{value:.0}"),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    fn line(frequency: f64, amplitude: f64, label: &str) -> Line {
        Line { frequency, amplitude, label: label.to_owned(), deviation: 0.0 }
    }

    /// A spectrum with those lines over a rough floor.
    fn amplitude(lines: &[Line], floor: f64) -> Vec<f64> {
        let mut amplitude: Vec<f64> = (0..5121)
            .map(|bin| floor * (1.2 + (f64::from(bin) * 12.9898).sin() * (f64::from(bin) * 0.7).cos()))
            .collect();
        for line in lines {
            let bin = (line.frequency / 10.0).round() as usize;
            for (d, share) in [(0, 0.5), (1, 1.0), (2, 0.5)] {
                amplitude[bin + d - 1] += share * line.amplitude;
            }
        }
        amplitude
    }

    fn crowded() -> Vec<Line> {
        vec![
            line(2293.4, 41.0, "BPFO"),
            line(4586.9, 12.0, "2·BPFO"),
            line(833.3, 7.0, "f_r"),
            line(1666.7, 5.0, "2·f_r"),
            line(3126.8, 3.0, "BPFO + f_r"),
            line(1460.1, 2.9, "BPFO − f_r"),
            line(6880.3, 2.0, "3·BPFO"),
            line(19_950.0, 1.5, ""),
            line(3539.9, 1.0, "BPFI"),
        ]
    }

    #[test]
    fn picture_has_panels_units_ticks_and_labels_and_is_well_formed() {
        let (y, z) = (crowded(), vec![line(2293.4, 9.0, "BPFO"), line(3721.6, 2.0, "2·BSF")]);
        let (y_amplitude, z_amplitude) = (amplitude(&y, 0.004), amplitude(&z, 0.003));
        let curve =
            |name, amplitude, lines| SpectrumCurve { name, unit: "m/s²", resolution_hz: 10.0, amplitude, lines };
        let svg = spectrum_svg(
            "Acceleration of the spindle",
            "article-integrated & <more>",
            &[curve("spindle.y.acceleration", &y_amplitude, &y), curve("spindle.z.acceleration", &z_amplitude, &z)],
            Some("waterfall.svg"),
        );
        assert!(svg.contains("<a href=\"waterfall.svg\">"));
        assert_well_formed(&svg);
        for text in
            ["m/s²", "frequency in kHz", "resolution 10 Hz", ">20<", ">0.01<", ">BPFO<", ">BPFO + f_r<", ">2·BSF<"]
        {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("spindle.y.acceleration") && svg.contains("spindle.z.acceleration"));
        assert!(svg.contains("article-integrated &amp; &lt;more&gt;") && svg.contains("prefers-color-scheme:dark"));
        assert!(svg.contains("BPFO at 2293.4 Hz with 41 m/s²"), "the description names the lines");
    }

    #[test]
    fn labels_do_not_stand_on_each_other() {
        let label = |row, from, to, at| Label { row, from, to, at };
        assert!(label(0, 0.0, 10.0, 5.0).collides(&label(0, 9.0, 20.0, 15.0)));
        assert!(!label(0, 0.0, 10.0, 5.0).collides(&label(0, 10.0, 20.0, 15.0)));
        assert!(label(0, 0.0, 10.0, 5.0).collides(&label(1, 0.0, 20.0, 8.0)), "a leader crosses the lower text");
        assert!(!label(1, 0.0, 10.0, 5.0).collides(&label(0, 8.0, 20.0, 15.0)));
    }

    #[test]
    fn labels_close_together_are_all_placed_and_hopeless_ones_left_out() {
        let edges = (76.0, 742.0);
        let close = [(152.0, 34.0), (231.0, 42.0), (104.0, 26.0), (131.0, 42.0), (180.0, 87.0), (125.0, 87.0)];
        let placed = arranged(&close, edges);
        assert_eq!(placed.len(), close.len());
        for (i, label) in placed.iter().enumerate() {
            assert!(placed[..i].iter().all(|other| !label.collides(other)));
            assert!(edges.0 < label.from && label.to < edges.1);
        }
        assert!((1..8).contains(&arranged(&[(300.0, 90.0); 8], edges).len()));
    }

    #[test]
    fn silent_empty_and_missing_spectra_are_drawn_too() {
        let silent = vec![0.0; 5121];
        let curve =
            |amplitude, resolution_hz| SpectrumCurve { name: "z", unit: "m/s²", resolution_hz, amplitude, lines: &[] };
        assert!(spectrum_svg("t", "s", &[curve(&silent, 10.0)], None).contains("nothing above"));
        for svg in [
            spectrum_svg("t", "s", &[], None),
            spectrum_svg("t", "s", &[curve(&[], 0.0)], None),
            spectrum_svg("t", "s", &[curve(&silent[..1], 10.0), curve(&[0.0, f64::NAN, 1.0], 10.0)], None),
        ] {
            assert_well_formed(&svg);
        }
    }

    #[test]
    fn amplitudes_read_with_three_digits() {
        assert_eq!(
            [0.0, 41.0, 0.012345, 9.9961, 123_456.0, 1.5e-9].map(significant),
            ["0", "41", "0.0123", "10", "123456", "1.50e-9"]
        );
    }
}
