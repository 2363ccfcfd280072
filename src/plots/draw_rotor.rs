//! Plots of a rotor analysis: Campbell diagram and mode shapes.

use super::campbell::{Campbell, Course, CriticalMark, Whirl};
use super::shapes::{Piece, Shape, Shapes};
use crate::contract::RotorAnswer;
use crate::contract::answer::rotor::{ModeAnswer, WhirlName};
use crate::contract::json::numbers::significant;
use crate::contract::json::units::MM;

/// Natural frequencies over speed with the critical speeds.
pub fn campbell(answer: &RotorAnswer) -> String {
    let courses = answer.modes.iter().map(|mode| Course {
        frequency: &mode.frequency_hz,
        whirl: mode.whirl.iter().map(|whirl| Whirl::from(*whirl)).collect(),
    });
    let critical = |speed, whirl: WhirlName| CriticalMark { speed, whirl: whirl.into() };
    let diagram = Campbell {
        speed: &answer.speeds_rpm,
        courses: courses.collect(),
        criticals: answer.criticals.iter().map(|one| critical(one.speed_rpm, one.whirl)).collect(),
        operating: answer.operating.speed_rpm,
    };
    diagram.svg("Campbell diagram", &subtitle(answer))
}

/// Shapes of the lowest natural motions at the operating speed.
pub fn shapes(answer: &RotorAnswer) -> String {
    let mut end = 0.0;
    let pieces = answer.model.elements.iter().map(|element| {
        let from = end;
        end += MM.to_user(element.length_m);
        Piece { from, to: end, diameter: MM.to_user(element.outer_diameter_m) }
    });
    // Elements of one section are one piece of the outline.
    let mut outline: Vec<Piece> = Vec::new();
    for piece in pieces {
        match outline.last_mut().filter(|last| last.diameter == piece.diameter) {
            Some(last) => last.to = piece.to,
            None => outline.push(piece),
        }
    }
    let shapes = Shapes {
        pieces: outline,
        nodes: &answer.nodes_mm,
        supports: answer.supports.iter().map(|support| support.at_mm).collect(),
        shapes: answer.operating.modes.iter().map(shape).collect(),
    };
    shapes.svg("Mode shapes", &subtitle(answer))
}

fn subtitle(answer: &RotorAnswer) -> String {
    let [speed, mass] = [answer.operating.speed_rpm, answer.mass_kg].map(|value| significant(value, 4));
    format!("operating speed {speed} r/min; shaft and discs {mass} kg; {} bearings and supports", answer.supports.len())
}

fn shape(mode: &ModeAnswer) -> Shape {
    let whirl = match mode.whirl {
        WhirlName::Forward => "forward",
        WhirlName::Backward => "backward",
        WhirlName::None => "in a plane",
        WhirlName::Axial => "axial",
    };
    let [frequency, damping] =
        [(mode.frequency_hz, 4), (mode.damping_ratio, 2)].map(|(value, digits)| significant(value, digits));
    let y = at_largest(&mode.shape.y, &mode.shape.y_phase_deg);
    let z = at_largest(&mode.shape.z, &mode.shape.z_phase_deg);
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let (plane, main, across) = match largest(&mode.shape.y) >= largest(&mode.shape.z) {
        true => ("x–y", y, z),
        false => ("x–z", z, y),
    };
    Shape { name: format!("{frequency} Hz, {whirl}, ζ {damping}; {plane}"), main, across }
}

/// Displacements at the instant of the largest one.
fn at_largest(amplitude: &[f64], phase_deg: &[f64]) -> Vec<f64> {
    let largest = amplitude.iter().zip(phase_deg).max_by(|one, other| one.0.total_cmp(other.0));
    let reference = largest.map_or(0.0, |(_, phase)| *phase);
    amplitude.iter().zip(phase_deg).map(|(a, phase)| a * (phase - reference).to_radians().cos()).collect()
}

impl From<WhirlName> for Whirl {
    fn from(name: WhirlName) -> Self {
        match name {
            WhirlName::Forward => Self::Forward,
            WhirlName::Backward => Self::Backward,
            WhirlName::None | WhirlName::Axial => Self::Other,
        }
    }
}
