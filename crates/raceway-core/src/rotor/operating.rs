//! Static equilibrium of a shaft on ball bearings: each bearing's force depends on its displacement, and on speed.

use nalgebra::{DMatrix, DVector};

use super::input::{NoEquilibrium, Rotor, RotorBearing, RotorError};
use super::potential::{Frame, RotorPotential};
use crate::physics::frame::support::{PORT, PortMatrix};
use crate::physics::statics::ring::RingState;
use crate::physics::statics::{FIRST_STEP, Pose, Wrench, check_residual, search};

/// Shaft and bearings in equilibrium at a speed.
#[derive(Debug, Clone)]
pub struct OperatingPoint {
    pub coordinates: DVector<f64>,
    /// The bearings, in their order.
    pub rings: Vec<RingState>,
}

/// The equilibrium at a speed [rad/s], searched from a neighbouring one.
///
/// It is the least potential of shaft and balls together. A search for the balls inside one for the shaft would meet balls between two open
/// contacts, which have no place of their own.
pub fn operating_point(
    frame: &Frame<'_>,
    rotor: &Rotor,
    speed: f64,
    start: Option<&OperatingPoint>,
) -> Result<OperatingPoint, RotorError> {
    let equilibrium =
        Equilibrium { potential: RotorPotential::new(frame, &rotor.bearings, speed, rotor.shaft.mass()), rotor, speed };
    let found = start.and_then(|start| equilibrium.near(start).ok()).map_or_else(|| equilibrium.afresh(), Ok);
    found.map_err(|cause| RotorError::NoEquilibrium { speed, cause })
}

/// The search of an equilibrium.
struct Equilibrium<'a> {
    potential: RotorPotential<'a>,
    rotor: &'a Rotor,
    speed: f64,
}

impl Equilibrium<'_> {
    /// From a shaft without deflection, balls between the grooves.
    fn afresh(&self) -> Result<OperatingPoint, NoEquilibrium> {
        let place = self.potential.place(&DVector::zeros(self.potential.len()), None);
        let first_damping = self.potential.force(&place) / FIRST_STEP;
        self.search(place, first_damping)
    }

    fn near(&self, start: &OperatingPoint) -> Result<OperatingPoint, NoEquilibrium> {
        let balls = start.rings.iter().flat_map(|ring| ring.balls().as_flattened()).copied().collect();
        self.search(self.potential.place(&start.coordinates, Some(balls)), 0.0)
    }

    fn search(&self, mut place: Vec<f64>, first_damping: f64) -> Result<OperatingPoint, NoEquilibrium> {
        let pitch_radii = self.rotor.bearings.iter().map(|bearing| bearing.mounted.bearing.pitch_radius());
        let force = self.potential.force(&place);
        let search = search(force, pitch_radii.fold(0.0, f64::max), first_damping);
        let slopes = search.minimise(&self.potential, &mut place);
        for ((index, bearing), (pose, balls)) in
            self.rotor.bearings.iter().enumerate().zip(self.potential.rings(&place))
        {
            check_pose(index, bearing, &pose)?;
            let is_in_reach = bearing.mounted.bearing.check_depth(&pose, balls);
            is_in_reach.map_err(|source| NoEquilibrium::Bearing { bearing: index + 1, source })?;
        }
        check_residual(slopes.residual(), force)?;
        let of_balls = slopes.gradient.len() - self.potential.len();
        let of_balls = slopes.gradient[..of_balls].iter().map(|slope| slope.abs()).fold(search.converged, f64::max);
        let rings = self
            .rotor
            .bearings
            .iter()
            .zip(self.potential.rings(&place))
            .map(|(bearing, (pose, balls))| bearing.mounted.bearing.with_balls(&pose, self.speed, balls, of_balls));
        Ok(OperatingPoint { coordinates: self.potential.coordinates(&place), rings: rings.collect() })
    }
}

/// Refuses an inner ring beyond the reach of its balls.
fn check_pose(index: usize, bearing: &RotorBearing, pose: &Pose) -> Result<(), NoEquilibrium> {
    let [x, y, z, ..] = *pose;
    let (play, bearing) = (bearing.mounted.bearing.play(), index + 1);
    let departs = |direction, displacement, limit| NoEquilibrium::Departs { bearing, direction, displacement, limit };
    if y.hypot(z) > play.radial {
        Err(departs("radially", y.hypot(z), play.radial))
    } else if x.abs() > play.axial {
        Err(departs("axially", x.abs(), play.axial))
    } else {
        Ok(())
    }
}

/// Forces and moments of a bearing on the shaft.
pub fn wrench(bearing: &RotorBearing, ring: &RingState) -> Wrench {
    bearing.mounted.wrench_on_shaft(&ring.wrench)
}

/// A port's matrix for products.
pub fn in_nalgebra(matrix: &PortMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(PORT, PORT, |row, column| matrix[row][column])
}

#[cfg(test)]
mod tests;
