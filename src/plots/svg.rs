//! Writes SVG text.

use std::fmt::Write;

/// Colours and fonts of all plots. Selectors are scoped because a plot may be part of a page. No CSS variables: not every renderer supports
/// them. Sizes for pages are in a media query that only browsers read.
const LIGHT: &str = "\
.raceway-plot{font-family:system-ui,'Segoe UI',Helvetica,Arial,sans-serif;font-size:13px}\
@media screen{.raceway-plot{max-width:100%;height:auto}}\
.raceway-plot .paper{fill:#fff}\
.raceway-plot .panel{fill:#f7f9fb;stroke:#b8c2cc}\
.raceway-plot .grid{stroke:#dde3e9;stroke-width:1}\
.raceway-plot text{fill:#2b333b}\
.raceway-plot .title{font-size:18px;font-weight:600}\
.raceway-plot .subtitle{font-size:13.5px;fill:#56616c}\
.raceway-plot .name{font-size:14px;font-weight:600}\
.raceway-plot .note{fill:#56616c}\
.raceway-plot .leader{stroke:#7b8792;stroke-width:.8}\
.raceway-plot .curve{fill:none;stroke-width:1.1;stroke-linejoin:round}\
.raceway-plot .c0{stroke:#0b63b0}.raceway-plot .c1{stroke:#b4530a}.raceway-plot .c2{stroke:#2e7d32}\
.raceway-plot .c3{stroke:#8e2a8c}.raceway-plot .c4{stroke:#5c6670}\
.raceway-plot .dot{stroke:none}\
.raceway-plot .f0{fill:#0b63b0}.raceway-plot .f1{fill:#b4530a}.raceway-plot .f2{fill:#2e7d32}\
.raceway-plot .f3{fill:#8e2a8c}.raceway-plot .f4{fill:#5c6670}\
.raceway-plot .ring{fill:none;stroke-width:1.3}.raceway-plot .cross{fill:none;stroke-width:1.8}\
.raceway-plot .floor{stroke:#7b8792;stroke-width:1.2;stroke-dasharray:6 4}\
.raceway-plot .dashed{stroke-dasharray:7 4}.raceway-plot .dotted{stroke-dasharray:2 3}\
.raceway-plot .rest{fill:#5c6670;fill-opacity:.16}.raceway-plot .support{fill:#5c6670}\
.raceway-plot .small{font-size:11.5px;fill:#56616c}\
.raceway-plot .band{fill:#0b63b0;fill-opacity:.13}";
/// Colours on a dark ground.
const DARK: &str = "\
.raceway-plot .paper{fill:#14181d}\
.raceway-plot .panel{fill:#1a2027;stroke:#48535e}\
.raceway-plot .grid{stroke:#2b343d}\
.raceway-plot .band{fill:#6cb4ff;fill-opacity:.2}\
.raceway-plot text{fill:#e4e9ee}\
.raceway-plot .subtitle,.raceway-plot .note,.raceway-plot .small{fill:#a3afba}\
.raceway-plot .leader,.raceway-plot .floor{stroke:#8693a0}\
.raceway-plot .c0{stroke:#6cb4ff}.raceway-plot .c1{stroke:#ffb26b}.raceway-plot .c2{stroke:#7fd08a}\
.raceway-plot .c3{stroke:#e08fe0}.raceway-plot .c4{stroke:#b4bec8}\
.raceway-plot .f0{fill:#6cb4ff}.raceway-plot .f1{fill:#ffb26b}.raceway-plot .f2{fill:#7fd08a}\
.raceway-plot .f3{fill:#e08fe0}.raceway-plot .f4{fill:#b4bec8}";

/// Ground on which a plot is seen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Theme {
    /// As the viewer is set.
    #[default]
    Auto,
    Light,
    Dark,
}

fn style(theme: Theme) -> String {
    match theme {
        Theme::Auto => format!("{LIGHT}@media (prefers-color-scheme:dark){{{DARK}}}"),
        Theme::Light => LIGHT.to_owned(),
        Theme::Dark => format!("{LIGHT}{DARK}"),
    }
}

/// The same picture on another ground and with another width [px], which its height follows.
pub fn seen(svg: &str, theme: Theme, width: Option<u32>) -> String {
    let svg = svg.replacen(&style(Theme::Auto), &style(theme), 1);
    width.and_then(|width| sized(&svg, width)).unwrap_or(svg)
}

/// The picture with a width [px]; `None` if it states no size.
fn sized(svg: &str, width: u32) -> Option<String> {
    let (before, rest) = svg.split_once("width=\"")?;
    let (own_width, rest) = rest.split_once("\" height=\"")?;
    let (own_height, rest) = rest.split_once('"')?;
    let height = f64::from(width) * own_height.parse::<f64>().ok()? / own_width.parse::<f64>().ok()?;
    Some(format!("{before}width=\"{width}\" height=\"{height:.0}\"{rest}"))
}

/// Number of colours before they repeat.
pub const COLOURS: usize = 5;

/// Alignment of a text at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing; later elements cover earlier ones.
pub struct Drawing {
    svg: String,
}

impl Drawing {
    /// An empty drawing with its headings; `description` is its text alternative.
    pub fn new(width: f64, height: f64, title: &str, subtitle: &str, description: &str) -> Self {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"raceway-plot\" role=\"img\" width=\"{width:.0}\" \
             height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\">\n<title>{}</title>\n<desc>{}</desc>\n\
             <style>{}</style>\n",
            escaped(title),
            escaped(description),
            style(Theme::Auto)
        );
        let mut drawing = Self { svg };
        drawing.rectangle("paper", 0.0, 0.0, width, height);
        drawing.text("title", Anchor::Start, 16.0, 30.0, &shortened(title, (width / 10.5) as usize));
        drawing.text("subtitle", Anchor::Start, 16.0, 51.0, &shortened(subtitle, (width / 7.6) as usize));
        drawing
    }

    pub fn rectangle(&mut self, class: &str, x: f64, y: f64, width: f64, height: f64) {
        self.element(format_args!(
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        ));
    }

    /// A rectangle in a colour given as `#rrggbb`.
    pub fn filled(&mut self, colour: &str, x: f64, y: f64, width: f64, height: f64) {
        self.element(format_args!(
            "<rect fill=\"{colour}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        ));
    }

    /// A ring that is visible on every colour.
    pub fn mark(&mut self, x: f64, y: f64) {
        for (colour, width) in [("#000", 3.5), ("#fff", 1.5)] {
            self.element(format_args!(
                "<circle fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\"/>"
            ));
        }
    }

    /// A small dot that is visible on every colour.
    pub fn run(&mut self, x: f64, y: f64) {
        self.element(format_args!(
            "<circle fill=\"white\" stroke=\"black\" stroke-width=\"0.6\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.6\"/>"
        ));
    }

    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        self.element(format_args!(
            "<line class=\"{class}\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
            from.0, from.1, to.0, to.1
        ));
    }

    /// A curve in the colour with this number.
    pub fn curve(&mut self, colour: usize, points: impl IntoIterator<Item = (f64, f64)>) {
        self.dashed_curve(colour, "", points);
    }

    /// A curve with dashes: `dashed`, `dotted` or none.
    pub fn dashed_curve(&mut self, colour: usize, dashes: &str, points: impl IntoIterator<Item = (f64, f64)>) {
        let mut path = String::new();
        for (x, y) in points {
            let command = if path.is_empty() { 'M' } else { 'L' };
            write!(path, "{command}{x:.1} {y:.1}").expect("writing to a string cannot fail");
        }
        if !path.is_empty() {
            let space = if dashes.is_empty() { "" } else { " " };
            let colour = colour % COLOURS;
            self.element(format_args!("<path class=\"curve c{colour}{space}{dashes}\" d=\"{path}\"/>"));
        }
    }

    pub fn dot(&mut self, colour: usize, x: f64, y: f64) {
        self.element(format_args!(
            "<circle class=\"dot f{}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\"/>",
            colour % COLOURS
        ));
    }

    /// A line that is visible on every colour.
    pub fn order(&mut self, points: impl IntoIterator<Item = (f64, f64)>) {
        let points: Vec<String> = points.into_iter().map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
        if !points.is_empty() {
            let path = points.join("L");
            self.element(format_args!(
                "<path fill=\"none\" stroke=\"#fff\" stroke-width=\"0.9\" stroke-opacity=\"0.65\" stroke-dasharray=\"2 5\" d=\"M{path}\"/>"
            ));
        }
    }

    /// A picture in PNG as base64, stretched over a rectangle.
    pub fn image(&mut self, x: f64, y: f64, width: f64, height: f64, png: &str) {
        self.element(format_args!(
            "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{png}\"/>"
        ));
    }

    /// A text that leads to another picture.
    pub fn link(&mut self, anchor: Anchor, x: f64, y: f64, text: &str, to: &str) {
        self.svg += &format!("<a href=\"{}\">\n", escaped(to));
        self.text("note", anchor, x, y, text);
        self.svg += "</a>\n";
    }

    /// A hollow dot.
    pub fn ring(&mut self, colour: usize, x: f64, y: f64) {
        self.element(format_args!(
            "<circle class=\"ring c{}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>",
            colour % COLOURS
        ));
    }

    pub fn cross(&mut self, colour: usize, x: f64, y: f64) {
        let (left, right, top, bottom) = (x - 4.0, x + 4.0, y - 4.0, y + 4.0);
        self.element(format_args!(
            "<path class=\"cross c{}\" d=\"M{left:.1} {top:.1}L{right:.1} {bottom:.1}M{left:.1} {bottom:.1}L{right:.1} {top:.1}\"/>",
            colour % COLOURS
        ));
    }

    /// A support below its place on the shaft: a triangle with its tip there.
    pub fn triangle(&mut self, x: f64, y: f64) {
        let (left, right, bottom) = (x - 6.0, x + 6.0, y + 10.0);
        self.element(format_args!(
            "<path class=\"support\" d=\"M{x:.1} {y:.1}L{right:.1} {bottom:.1}L{left:.1} {bottom:.1}Z\"/>"
        ));
    }

    pub fn text(&mut self, class: &str, anchor: Anchor, x: f64, y: f64, text: &str) {
        self.placed_text(class, anchor, format_args!("x=\"{x:.1}\" y=\"{y:.1}\""), text);
    }

    /// A text that reads upwards, centred at the position.
    pub fn upright_text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        let place = format_args!("transform=\"translate({x:.1} {y:.1}) rotate(-90)\"");
        self.placed_text(class, Anchor::Middle, place, text);
    }

    pub fn finish(mut self) -> String {
        self.svg += "</svg>\n";
        self.svg
    }

    fn placed_text(&mut self, class: &str, anchor: Anchor, place: std::fmt::Arguments<'_>, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        self.element(format_args!("<text class=\"{class}\" text-anchor=\"{anchor}\" {place}>{text}</text>"));
    }

    fn element(&mut self, element: std::fmt::Arguments<'_>) {
        writeln!(self.svg, "{element}").expect("writing to a string cannot fail");
    }
}

/// Text escaped for XML, without characters that XML does not allow.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\u{fffe}' | '\u{ffff}' => {}
            c if c.is_control() && !c.is_ascii_whitespace() => {}
            c => out.push(c),
        }
    }
    out
}

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// Panics unless every tag is closed in order and every `&` begins an entity.
#[cfg(test)]
pub fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (tag, text) = tag.split_once('>').expect("a tag ends");
        assert!(!text.contains('>'), "stray > in {text}");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "still open: {open:?}");
    for entity in svg.split('&').skip(1) {
        assert!(["amp;", "lt;", "gt;", "quot;"].iter().any(|known| entity.starts_with(known)), "&{entity}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf\""), "a coordinate is no number");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped_and_long_headings_shortened() {
        let mut drawing = Drawing::new(200.0, 100.0, "<b> & \"co\"", &"x".repeat(300), "a < b\u{0}");
        drawing.text("note", Anchor::End, 1.0, 2.0, "</svg>&");
        drawing.upright_text("note", 1.0, 2.0, "m/s²");
        drawing.curve(4, [(0.0, 1.0), (2.0, 3.0)]);
        drawing.curve(0, []);
        let svg = drawing.finish();
        assert_well_formed(&svg);
        assert!(svg.contains("<title>&lt;b&gt; &amp; &quot;co&quot;</title>"));
        assert!(svg.contains("&lt;/svg&gt;&amp;") && svg.contains("x…") && svg.contains("d=\"M0.0 1.0L2.0 3.0\""));
    }

    #[test]
    fn a_picture_is_seen_on_another_ground_and_at_another_width() {
        let svg = Drawing::new(200.0, 100.0, "t", "s", "d").finish();
        assert_eq!(seen(&svg, Theme::Auto, None), svg);
        let [light, dark] = [Theme::Light, Theme::Dark].map(|theme| seen(&svg, theme, Some(300)));
        for one in [&light, &dark] {
            assert_well_formed(one);
            assert!(
                one.contains("width=\"300\" height=\"150\" viewBox=\"0 0 200 100\"") && !one.contains("prefers-color")
            );
        }
        assert!(dark.contains("#14181d") && !light.contains("#14181d"));
        assert_eq!(seen("<svg>", Theme::Dark, Some(300)), "<svg>");
    }
}
