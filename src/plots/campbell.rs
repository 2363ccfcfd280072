//! Campbell diagram: natural frequencies over speed, the line of one period a turn, and the critical speeds on it.

use super::axis::{Scale, ticks};
use super::svg::{Anchor, Drawing};

/// Whirl of a motion: `Forward` with the rotation, `Backward` against it, `Other` in a plane or along the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whirl {
    Forward,
    Backward,
    Other,
}

/// One natural motion over speed.
pub struct Course<'a> {
    /// Frequency at each speed [Hz]; 0 where the motion does not oscillate.
    pub frequency: &'a [f64],
    /// Whirl at each speed.
    pub whirl: Vec<Whirl>,
}

/// A critical speed [r/min].
#[derive(Debug, Clone, Copy)]
pub struct CriticalMark {
    pub speed: f64,
    pub whirl: Whirl,
}

/// A Campbell diagram; speeds in r/min.
pub struct Campbell<'a> {
    pub speed: &'a [f64],
    pub courses: Vec<Course<'a>>,
    pub criticals: Vec<CriticalMark>,
    pub operating: f64,
}

const WIDTH: f64 = 860.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 76.0;
const PANEL: f64 = 420.0;
const BOTTOM: f64 = 52.0;
/// Distance of rows of the legend, and how many critical speeds it names.
const ROW: f64 = 20.0;
const MOST_NAMED: usize = 14;
/// Colour of each whirl, and the class of its dashes: it shows without colour, too.
const STYLES: [(Whirl, usize, &str, &str); 3] = [
    (Whirl::Forward, 0, "", "forward"),
    (Whirl::Backward, 1, "dashed", "backward"),
    (Whirl::Other, 4, "dotted", "in a plane, axial"),
];

impl Campbell<'_> {
    /// Highest frequency of the diagram [Hz]: twice that of the rotation at the highest speed, and the two lowest motions at least.
    fn highest(&self) -> f64 {
        let twice = 2.0 * self.speed.last().copied().unwrap_or(0.0) / 60.0;
        let largest = |course: &Course<'_>| course.frequency.iter().copied().fold(0.0, f64::max);
        let mut tops: Vec<f64> = self.courses.iter().map(largest).collect();
        tops.sort_by(f64::total_cmp);
        let lowest = tops.iter().take(2).copied().fold(0.0, f64::max);
        let all = tops.last().copied().unwrap_or(0.0);
        let highest = 1.08 * twice.max(lowest).min(all.max(0.5 * twice));
        if highest > 0.0 { highest } else { 1.0 }
    }

    /// The diagram.
    pub fn svg(&self, title: &str, subtitle: &str) -> String {
        let (right, bottom) = (WIDTH - RIGHT, TOP + PANEL);
        let speeds: Vec<String> = self.criticals.iter().map(|critical| format!("{:.0}", critical.speed)).collect();
        let description = match speeds.is_empty() {
            true => format!("{subtitle}. Natural frequencies over speed, without critical speed."),
            false => {
                format!("{subtitle}. Natural frequencies over speed. Critical speeds: {} r/min.", speeds.join(", "))
            }
        };
        let mut drawing = Drawing::new(WIDTH, bottom + BOTTOM, title, subtitle, &description);
        let (first, last) = (self.speed.first().copied().unwrap_or(0.0), self.speed.last().copied().unwrap_or(0.0));
        let last = if last > first { last } else { first + 1.0 };
        let x = Scale { values: (first, last), positions: (LEFT, right) };
        let y = Scale { values: (0.0, self.highest()), positions: (bottom, TOP) };
        drawing.rectangle("panel", LEFT, TOP, right - LEFT, PANEL);
        for (value, text) in ticks(x.values, 8) {
            drawing.line("grid", (x.at(value), TOP), (x.at(value), bottom));
            drawing.text("", Anchor::Middle, x.at(value), bottom + 18.0, &text);
        }
        for (value, text) in ticks(y.values, 8) {
            drawing.line("grid", (LEFT, y.at(value)), (right, y.at(value)));
            drawing.text("", Anchor::End, LEFT - 8.0, y.at(value) + 4.5, &text);
        }
        drawing.text("", Anchor::Middle, 0.5 * (LEFT + right), bottom + 40.0, "speed in r/min");
        drawing.upright_text("", 18.0, TOP + 0.5 * PANEL, "natural frequency in Hz");
        if (first..=last).contains(&self.operating) {
            drawing.line("floor", (x.at(self.operating), TOP), (x.at(self.operating), bottom));
            drawing.text("small", Anchor::Start, x.at(self.operating) + 4.0, TOP + 14.0, "operating");
        }
        let end = last.min(60.0 * y.values.1);
        drawing.line("leader", (x.at(first), y.at(first / 60.0)), (x.at(end), y.at(end / 60.0)));
        let middle = 0.5 * (first + end);
        drawing.text("note", Anchor::Start, x.at(middle) + 6.0, y.at(middle / 60.0) + 14.0, "1×");
        for course in &self.courses {
            draw_course(&mut drawing, self.speed, course, &x, &y);
        }
        for critical in &self.criticals {
            mark(&mut drawing, critical.whirl, x.at(critical.speed), y.at(critical.speed / 60.0));
        }
        self.legend(&mut drawing, right + 16.0);
        drawing.finish()
    }

    fn legend(&self, drawing: &mut Drawing, left: f64) {
        let mut at = TOP + 10.0;
        for (_, colour, dashes, name) in STYLES {
            drawing.dashed_curve(colour, dashes, [(left, at), (left + 26.0, at)]);
            drawing.text("", Anchor::Start, left + 33.0, at + 4.5, name);
            at += ROW;
        }
        at += ROW;
        let name = if self.criticals.is_empty() { "no critical speed" } else { "critical speeds in r/min" };
        drawing.text("note", Anchor::Start, left, at + 4.5, name);
        for critical in self.criticals.iter().take(MOST_NAMED) {
            at += ROW;
            mark(drawing, critical.whirl, left + 6.0, at);
            drawing.text("", Anchor::Start, left + 20.0, at + 4.5, &format!("{:.0}", critical.speed));
        }
        if let Some(more @ 1..) = self.criticals.len().checked_sub(MOST_NAMED) {
            drawing.text("note", Anchor::Start, left, at + ROW + 4.5, &format!("and {more} more"));
        }
    }
}

/// A dot of forward whirl, a ring of backward whirl, a cross of any other motion.
fn mark(drawing: &mut Drawing, whirl: Whirl, x: f64, y: f64) {
    match whirl {
        Whirl::Forward => drawing.dot(0, x, y),
        Whirl::Backward => drawing.ring(1, x, y),
        Whirl::Other => drawing.cross(4, x, y),
    }
}

/// A course in pieces of one whirl; a piece reaches to the first point of the next one.
fn draw_course(drawing: &mut Drawing, speed: &[f64], course: &Course<'_>, x: &Scale, y: &Scale) {
    let count = speed.len().min(course.frequency.len()).min(course.whirl.len());
    let is_shown = |k: usize| course.frequency[k] > 0.0 && course.frequency[k] <= y.values.1;
    let mut from = 0;
    while from < count {
        let Some((_, colour, dashes, _)) = STYLES.into_iter().find(|style| style.0 == course.whirl[from]) else {
            return;
        };
        let piece = (from..count).take_while(|k| is_shown(*k) && course.whirl[*k] == course.whirl[from]).count();
        let beyond = from + piece;
        let end = if piece > 0 && beyond < count && is_shown(beyond) { beyond + 1 } else { beyond };
        if end > from + 1 {
            let points = (from..end).map(|k| (x.at(speed[k]), y.at(course.frequency[k])));
            drawing.dashed_curve(colour, dashes, points);
        }
        from = beyond.max(from + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn a_diagram_names_critical_speeds_and_changes_its_line_with_the_whirl() {
        let mut campbell = Campbell {
            speed: &[0.0, 6000.0, 12000.0],
            courses: vec![
                Course { frequency: &[100.0, 95.0, 90.0], whirl: vec![Whirl::Other, Whirl::Backward, Whirl::Backward] },
                Course { frequency: &[100.0, 106.0, 0.0], whirl: vec![Whirl::Forward; 3] },
                Course { frequency: &[9000.0; 3], whirl: vec![Whirl::Forward; 3] },
            ],
            criticals: vec![CriticalMark { speed: 5700.0, whirl: Whirl::Backward }],
            operating: 6000.0,
        };
        let svg = campbell.svg("Campbell diagram", "s");
        assert_well_formed(&svg);
        assert!(svg.contains(">5700<") && svg.contains(">1×<") && svg.contains(">operating<"));
        // Legend and pieces: one dashed, one dotted up to it, one plain that ends where the motion stops oscillating.
        assert_eq!(["dashed\"", "dotted\"", "curve c0"].map(|class| svg.matches(class).count()), [2, 2, 2]);
        (campbell.speed, campbell.courses, campbell.criticals) = (&[], Vec::new(), Vec::new());
        let svg = campbell.svg("Campbell diagram", "s");
        assert_well_formed(&svg);
        assert!(svg.contains("no critical speed"));
    }

    #[test]
    fn a_legend_of_many_critical_speeds_ends_with_their_number() {
        let criticals = (1..=20).map(|k| CriticalMark { speed: 100.0 * f64::from(k), whirl: Whirl::Forward }).collect();
        let campbell = Campbell { speed: &[0.0, 3000.0], courses: Vec::new(), criticals, operating: 0.0 };
        let svg = campbell.svg("Campbell diagram", "s");
        assert_well_formed(&svg);
        assert!(svg.contains("and 6 more"));
    }
}
