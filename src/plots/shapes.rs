//! Mode shapes on the outline of the shaft: the outline deflected in the plane of the larger motion, and the line of centres across it.

use super::axis::Scale;
use super::svg::{Anchor, Drawing};

/// A length of the shaft; in mm.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    pub from: f64,
    pub to: f64,
    pub diameter: f64,
}

/// A natural motion.
pub struct Shape {
    pub name: String,
    /// Displacement of each node in the plane of the larger motion, and across it [-], each at the instant of its largest.
    pub main: Vec<f64>,
    pub across: Vec<f64>,
}

/// Shapes of a shaft; places along it in mm.
pub struct Shapes<'a> {
    pub pieces: Vec<Piece>,
    pub nodes: &'a [f64],
    /// Places of bearings and supports.
    pub supports: Vec<f64>,
    pub shapes: Vec<Shape>,
}

const WIDTH: f64 = 860.0;
const MARGIN: f64 = 22.0;
const GAP: f64 = 28.0;
const COLUMNS: usize = 2;
const TOP: f64 = 92.0;
const PANEL: f64 = 150.0;
const PITCH: f64 = PANEL + 44.0;
const BOTTOM: f64 = 40.0;
/// Share of a panel's half height that the largest displacement takes.
const DEFLECTION: f64 = 0.5;
/// Share of a panel's half height that the shaft's radius may take.
const RADIUS: f64 = 0.4;
/// Rounding of places at the ends of a piece [mm].
const ROUNDING: f64 = 1e-6;

impl Shapes<'_> {
    /// All shapes, two in a row.
    pub fn svg(&self, title: &str, subtitle: &str) -> String {
        let names: Vec<&str> = self.shapes.iter().map(|shape| shape.name.as_str()).collect();
        let description = format!("{subtitle}. Shapes of the natural motions: {}.", names.join("; "));
        let rows = self.shapes.len().div_ceil(COLUMNS).max(1);
        let height = TOP + PITCH * rows as f64 + BOTTOM - (PITCH - PANEL);
        let mut drawing = Drawing::new(WIDTH, height, title, subtitle, &description);
        let width = (WIDTH - 2.0 * MARGIN - GAP) / COLUMNS as f64;
        for (number, shape) in self.shapes.iter().enumerate() {
            let left = MARGIN + (number % COLUMNS) as f64 * (width + GAP);
            let top = TOP + (number / COLUMNS) as f64 * PITCH;
            drawing.rectangle("panel", left, top, width, PANEL);
            drawing.text("name", Anchor::Start, left, top - 8.0, &shape.name);
            self.draw(&mut drawing, shape, (left + 10.0, left + width - 10.0), top + 0.5 * PANEL);
        }
        let legend =
            "outline: plane of the larger motion; dashed: across it; grey: at rest; triangles: bearings and supports";
        drawing.text("small", Anchor::Middle, 0.5 * WIDTH, height - 16.0, legend);
        drawing.finish()
    }

    fn draw(&self, drawing: &mut Drawing, shape: &Shape, positions: (f64, f64), axis: f64) {
        let length = self.pieces.last().map_or(1.0, |piece| piece.to);
        let x = Scale { values: (0.0, length), positions };
        let widest = self.pieces.iter().map(|piece| 0.5 * piece.diameter).fold(0.0, f64::max);
        let by_length = (positions.1 - positions.0) / length;
        let radial = by_length.min(RADIUS * 0.5 * PANEL / widest.max(1e-9));
        let across = DEFLECTION * 0.5 * PANEL;
        for piece in &self.pieces {
            let half = 0.5 * piece.diameter * radial;
            drawing.rectangle("rest", x.at(piece.from), axis - half, x.at(piece.to) - x.at(piece.from), 2.0 * half);
        }
        for at in &self.supports {
            drawing.triangle(x.at(*at), axis + 0.5 * PANEL - 13.0);
        }
        // One edge of the deflected outline, −1 above the axis and 1 below it.
        let edge = |side: f64| -> Vec<(f64, f64)> {
            let of_piece = |piece: &Piece| -> Vec<(f64, f64)> {
                let (from, to) = (piece.from - ROUNDING, piece.to + ROUNDING);
                let offset = side * 0.5 * piece.diameter * radial;
                let within = self.nodes.iter().zip(&shape.main).filter(|(at, _)| (from..=to).contains(*at));
                within.map(|(at, displacement)| (x.at(*at), axis + offset + across * displacement)).collect()
            };
            self.pieces.iter().flat_map(of_piece).collect()
        };
        let mut outline = edge(-1.0);
        outline.extend(edge(1.0).into_iter().rev());
        outline.extend(outline.first().copied());
        drawing.curve(0, outline);
        let line =
            self.nodes.iter().zip(&shape.across).map(|(at, displacement)| (x.at(*at), axis + across * displacement));
        drawing.dashed_curve(1, "dashed", line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::svg::assert_well_formed;

    #[test]
    fn each_shape_has_its_name_and_its_lines() {
        let piece = |from, to, diameter| Piece { from, to, diameter };
        let shape = |name: &str| Shape { name: name.into(), main: vec![0.0, 1.0, 0.0], across: vec![0.0, -1.0, 0.0] };
        let mut shapes = Shapes {
            pieces: vec![piece(0.0, 50.0, 20.0), piece(50.0, 100.0, 30.0)],
            nodes: &[0.0, 50.0, 100.0],
            supports: vec![20.0, 80.0],
            shapes: vec![shape("100 Hz, forward"), shape("200 Hz, <backward>"), shape("300 Hz")],
        };
        let svg = shapes.svg("Mode shapes", "s");
        assert_well_formed(&svg);
        assert!(svg.contains("200 Hz, &lt;backward&gt;"));
        assert_eq!(
            ["class=\"rest\"", "curve c0", "curve c1", "class=\"support\""].map(|class| svg.matches(class).count()),
            [6, 3, 3, 6]
        );
        (shapes.pieces, shapes.nodes, shapes.shapes) = (Vec::new(), &[], Vec::new());
        assert_well_formed(&shapes.svg("Mode shapes", "s"));
    }
}
