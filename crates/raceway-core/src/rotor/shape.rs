//! Direction and shape of natural motions.

use nalgebra::{Complex, DVector};

use super::coordinates::Coordinates;
use super::result::{Direction, Mode, ModePoint};
use crate::numerics::quadratic_eigen::Oscillation;

/// Difference of the forward and the backward energy over both, below which rounding decides [-]. Shapes in a plane had up to 2e-8.
const PLANAR: f64 = 1e-6;

/// Frequency, damping and direction of an oscillation at a speed [rad/s]. Where nothing acts against the rotation otherwise than with it, no motion
/// has a direction.
///
/// A motion y + i z = F e^(iωt) + B e^(−iωt) has F = (Y + i Z)/2 and B = (Y* + i Z*)/2. The mass is 1 over the coordinates, so that
/// sums of their squares are kinetic energies.
pub fn point(oscillation: &Oscillation, coordinates: &Coordinates, speed: f64) -> ModePoint {
    let vector = &oscillation.vector;
    let turned = Complex::i();
    let energy = |sign: f64| -> f64 {
        coordinates.pairs().map(|(y, z)| (vector[y] + turned * sign * vector[z]).norm_sqr() / 2.0).sum()
    };
    let (forward, backward) = (energy(1.0), energy(-1.0));
    let axial: f64 = coordinates.axial().map(|x| vector[x].norm_sqr()).sum();
    let lateral = forward + backward;
    let is_planar = speed == 0.0 || !coordinates.has_sense || (forward - backward).abs() <= PLANAR * lateral;
    let direction = match () {
        () if axial > lateral => Direction::Axial,
        () if is_planar => Direction::Planar,
        () if forward > backward => Direction::Forward,
        () => Direction::Backward,
    };
    let value = oscillation.value;
    let forward_share = if is_planar { 0.5 } else { forward / lateral };
    ModePoint { frequency: value.im, damping_ratio: -value.re / value.norm(), direction, forward_share }
}

/// The oscillation with the displacements of every node and body.
pub fn mode(oscillation: &Oscillation, coordinates: &Coordinates, speed: f64) -> Mode {
    let mut shape = displacements(&oscillation.vector, coordinates);
    let mut bodies = coordinates.housing.displacements(&oscillation.vector);
    let moved = shape.iter().flatten().chain(bodies.iter().flat_map(|body| &body[..3]));
    let largest = moved.copied().max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
    if let Some(largest) = largest.filter(|value| *value != Complex::ZERO) {
        let all = shape.iter_mut().flatten().chain(bodies.iter_mut().flatten());
        all.for_each(|value| *value /= largest);
    }
    Mode { point: point(oscillation, coordinates, speed), shape, bodies }
}

/// Displacements x, y, z of every node.
pub fn displacements(vector: &DVector<Complex<f64>>, coordinates: &Coordinates) -> Vec<[Complex<f64>; 3]> {
    let of_node = |node: usize| {
        let rows = coordinates.port(node);
        [0, 1, 2].map(|row| rows.row(row).iter().zip(vector.iter()).map(|(share, value)| value * *share).sum())
    };
    (0..coordinates.mesh.nodes.len()).map(of_node).collect()
}
