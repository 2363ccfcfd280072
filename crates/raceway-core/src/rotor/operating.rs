//! Static equilibrium of a shaft on ball bearings: each bearing's force depends on its displacement, and on speed.

use nalgebra::{DMatrix, DVector};

use super::input::{Rotor, RotorBearing, RotorError};
use crate::physics::frame::support::{PORT, PortMatrix};
use crate::physics::statics::ring::RingState;
use crate::physics::statics::{Pose, Wrench};

/// Shaft and bearings in equilibrium at a speed.
#[derive(Debug, Clone)]
pub struct OperatingPoint {
    pub coordinates: DVector<f64>,
    /// The bearings, in their order.
    pub rings: Vec<RingState>,
}

/// The linear part of the equilibrium: stiffness and load over the coordinates, and the displacements of each bearing's place.
pub struct Frame<'a> {
    pub stiffness: &'a DMatrix<f64>,
    pub load: &'a DVector<f64>,
    pub ports: &'a [DMatrix<f64>],
}

/// Remainder of the forces, relative to all forces, at which an equilibrium has converged [-].
const CONVERGED: f64 = 1e-10;
const MOST_STEPS: usize = 300;
/// Restoring stiffness of the first step over the mass [1/s²], that of 50 Hz: loose bearings have none of their own.
const FIRST_HOLD: f64 = 1e5;

/// The equilibrium at a speed [rad/s], searched from a neighbouring one.
///
/// Newton's method with a hold μ on every coordinate, (K + K_b + μ) Δq = r, which grows where a step fails and fades as the remainder
/// falls (pseudo-transient continuation; C. T. Kelley & D. E. Keyes, *SIAM J. Numer. Anal.* 35 (1998) 508).
pub fn operating_point(
    frame: &Frame<'_>,
    rotor: &Rotor,
    speed: f64,
    start: Option<&OperatingPoint>,
) -> Result<OperatingPoint, RotorError> {
    let failed = || RotorError::NoEquilibrium(speed);
    let size = frame.load.len();
    let (mut at, mut hold) = match start {
        Some(start) => (evaluated(frame, rotor, speed, start.coordinates.clone(), Some(start)), 0.0),
        None => (None, FIRST_HOLD),
    };
    if at.is_none() {
        at = evaluated(frame, rotor, speed, DVector::zeros(size), None);
        hold = FIRST_HOLD;
    }
    let mut at = at.ok_or_else(failed)?;
    for _ in 0..MOST_STEPS {
        if at.remainder <= CONVERGED * at.applied {
            return Ok(at.point);
        }
        let mut matrix = frame.stiffness.clone();
        for ((port, bearing), ring) in frame.ports.iter().zip(&rotor.bearings).zip(&at.point.rings) {
            matrix += port.transpose() * in_nalgebra(&bearing.mounted.along_shaft(&ring.stiffness.mean)) * port;
        }
        for place in 0..size {
            matrix[(place, place)] += hold;
        }
        let step = matrix.lu().solve(&at.rest).filter(|step| step.iter().all(|value| value.is_finite()));
        let next = step.and_then(|step| evaluated(frame, rotor, speed, &at.point.coordinates + step, Some(&at.point)));
        match next.filter(|next| next.remainder < 2.0 * at.remainder) {
            Some(next) => {
                let fade = (next.remainder / at.remainder).clamp(0.05, 2.0);
                hold = if hold < 1e-6 * FIRST_HOLD { 0.0 } else { hold * fade };
                at = next;
            }
            None => hold = (10.0 * hold).max(FIRST_HOLD),
        }
        if hold > 1e15 {
            break;
        }
    }
    Err(failed())
}

/// Shaft and bearings at a displacement that need not be in equilibrium.
struct Evaluated {
    point: OperatingPoint,
    /// Forces that no reaction takes.
    rest: DVector<f64>,
    /// Sizes of the remainder and of all forces, by the displacements that they cause.
    remainder: f64,
    applied: f64,
}

/// `None` where balls cannot be in equilibrium.
fn evaluated(
    frame: &Frame<'_>,
    rotor: &Rotor,
    speed: f64,
    coordinates: DVector<f64>,
    near: Option<&OperatingPoint>,
) -> Option<Evaluated> {
    let mut rest = frame.load - frame.stiffness * &coordinates;
    // A force on a stiff coordinate matters less.
    let weight = |forces: &DVector<f64>| -> f64 {
        let by_place = forces.iter().enumerate();
        by_place.map(|(k, force)| force * force / (frame.stiffness[(k, k)] + FIRST_HOLD)).sum::<f64>().sqrt()
    };
    let mut applied = weight(frame.load);
    let mut rings = Vec::with_capacity(rotor.bearings.len());
    for (index, (bearing, port)) in rotor.bearings.iter().zip(frame.ports).enumerate() {
        let moved = port * &coordinates;
        let pose: Pose = bearing.mounted.ring_pose(&std::array::from_fn(|k| moved[k]), 0.0);
        let from = near.map(|near| &near.rings[index]);
        let ring = from.and_then(|from| bearing.mounted.bearing.near(&pose, speed, from).ok());
        let ring = ring.or_else(|| bearing.mounted.bearing.at(&pose, speed).ok())?;
        let reaction = port.transpose() * DVector::from_row_slice(&wrench(bearing, &ring));
        // Preloaded bearings carry each other, without a reaction of the shaft.
        let carried = ring.wrench[..3].iter().map(|force| force * force).sum::<f64>().sqrt();
        applied += weight(&(port.transpose() * DVector::from_row_slice(&[carried, carried, carried, 0.0, 0.0])));
        rest += reaction;
        rings.push(ring);
    }
    let remainder = weight(&rest);
    Some(Evaluated { point: OperatingPoint { coordinates, rings }, rest, remainder, applied })
}

/// Forces and moments of a bearing on the shaft.
pub fn wrench(bearing: &RotorBearing, ring: &RingState) -> Wrench {
    bearing.mounted.wrench_on_shaft(&ring.wrench)
}

/// A port's matrix for products.
pub fn in_nalgebra(matrix: &PortMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(PORT, PORT, |row, column| matrix[row][column])
}
