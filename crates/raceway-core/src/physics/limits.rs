//! Limits of each parameter, and the faults of given values.

use std::f64::consts::PI;

/// Largest number of balls accepted.
const MAX_BALLS: f64 = 64.0;
/// Largest angular speed accepted [rad/s]: 500 000 r/min.
const MAX_SPEED: f64 = 500_000.0 * PI / 30.0;

/// Highest frequency of a load [Hz]: five times that of the recorded band.
pub const HIGHEST_FREQUENCY: f64 = 1e5;

/// Highest order of a wave round a ring.
const MAX_ORDER: f64 = 100_000.0;

/// Largest number of points of a profile of speed or load.
pub const MOST_POINTS: usize = 1000;
/// Shortest time between two points of a profile [s].
pub(crate) const SHORTEST_RAMP: f64 = 1e-9;

/// The values that a parameter may take: `lowest ..= highest`, in SI. `exclusive`: the lowest itself is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Path in dots, as `InvalidParameter` has it. A path that begins with a dot matches every path that ends in it:
    /// the same quantity of several materials or contacts.
    parameter: &'static str,
    pub lowest: f64,
    pub highest: f64,
    pub exclusive: bool,
}

const fn within(parameter: &'static str, lowest: f64, highest: f64) -> Limits {
    Limits { parameter, lowest, highest, exclusive: false }
}

const fn above(parameter: &'static str, lowest: f64, highest: f64) -> Limits {
    Limits { parameter, lowest, highest, exclusive: true }
}

/// Limits of existing bearings and of this program. Quantities that only have to be positive have a lowest value far
/// below any real one, so that their reciprocal stays finite. Relations between values are checked in the constructors.
const LIMITS: [Limits; 107] = [
    within("bearing.ball_diameter", 1e-4, 0.5),
    within("bearing.pitch_diameter", 1e-4, 10.0),
    within("bearing.outer_diameter", 1e-4, 12.0),
    within("bearing.inner_diameter", 1e-4, 10.0),
    within("bearing.width", 1e-4, 2.0),
    within("bearing.ball_count", 2.0, MAX_BALLS),
    above("bearing.inner_groove_curvature", 0.5, 1.0),
    above("bearing.outer_groove_curvature", 0.5, 1.0),
    // From a fiftieth of the largest ball to the clearance of the widest grooves.
    within("bearing.radial_clearance", -0.01, 0.5),
    within("bearing.contact_angle", 0.0, PI / 3.0),
    within(".elastic_modulus", 1e6, 2e12),
    within(".poisson_ratio", 0.0, 0.5),
    within(".density", 10.0, 30_000.0),
    within("bearing.cage.mass", 1e-12, 1000.0),
    within("bearing.cage.axial_inertia", 1e-24, 1e4),
    within("bearing.cage.transverse_inertia", 1e-24, 1e4),
    within("bearing.cage.offset", -1.0, 1.0),
    within("bearing.cage.pocket_clearance", 1e-6, 0.1),
    within("bearing.cage.rim_angle", PI / 30.0, PI * 85.0 / 180.0),
    within("bearing.cage.seat_half_width", 1e-6, 1.0),
    within("bearing.cage.friction", 0.0, 2.0),
    within("bearing.cage.friction_speed", 1e-6, 100.0),
    within("bearing.cage.bar_stiffness", 1.0, 1e12),
    within("bearing.cage.land.clearance", 1e-6, 0.1),
    within("bearing.cage.land.diameter", 1e-4, 10.0),
    within("bearing.cage.land.width", 1e-6, 1.0),
    within("bearing.cage.film.stiffness", 0.0, 1e10),
    within("bearing.cage.film.damping", 0.0, 1e5),
    within("spindle.mass", 1e-9, 1e6),
    within("spindle.unbalance", 0.0, 1e3),
    within("spindle.balance_grade", 0.0, 5.0),
    within("spindle.axial.offset", -0.01, 0.01),
    within("spindle.transverse_inertia", 1e-12, 1e6),
    within("spindle.axial_inertia", 1e-12, 1e6),
    within("operation.speed", -MAX_SPEED, MAX_SPEED),
    within("operation.speed.at", 0.0, 1e6),
    within("operation.outer_speed", -MAX_SPEED, MAX_SPEED),
    within("operation.outer_speed.at", 0.0, 1e6),
    within("operation.axial_load", -1e7, 1e7),
    within("operation.radial_load_y", -1e7, 1e7),
    within("operation.radial_load_z", -1e7, 1e7),
    within("operation.loads.constant", -1e7, 1e7),
    within("operation.loads.constant_moment", -1e6, 1e6),
    within("operation.loads.points.at", 0.0, 1e6),
    within("operation.loads.points.force", -1e7, 1e7),
    within("operation.loads.points.moment", -1e6, 1e6),
    within("operation.loads.harmonic.amplitude", 0.0, 1e7),
    within("operation.loads.harmonic.moment_amplitude", 0.0, 1e6),
    above("operation.loads.harmonic.frequency", 0.0, HIGHEST_FREQUENCY),
    above("operation.loads.harmonic.order", 0.0, 1000.0),
    within("operation.loads.harmonic.phase", -2.0 * PI, 2.0 * PI),
    within("operation.loads.rotating.amplitude", 0.0, 1e7),
    above("operation.loads.rotating.frequency", 0.0, HIGHEST_FREQUENCY),
    above("operation.loads.rotating.order", 0.0, 1000.0),
    within("operation.loads.rotating.phase", -2.0 * PI, 2.0 * PI),
    within("operation.loads.series", -1e7, 1e7),
    within("operation.loads.series_moment", -1e6, 1e6),
    within("operation.loads.shock.peak", -1e7, 1e7),
    within("operation.loads.shock.moment_peak", -1e6, 1e6),
    within("operation.loads.shock.at", 0.0, 1e6),
    within("operation.loads.shock.duration", 1e-6, 1000.0),
    within("operation.misalignment.y", -0.02, 0.02),
    within("operation.misalignment.z", -0.02, 0.02),
    within("operation.initial_perturbation.speed", 0.0, 10.0),
    within("lubricant.viscosity", 0.0, 100.0),
    within("lubricant.pressure_viscosity", 0.0, 1e-6),
    within("lubricant.fill", 0.0, 1.0),
    within("lubricant.inlet_distance", 1e-6, 1.0),
    within("lubricant.traction.at_rest", 0.0, 2.0),
    within("lubricant.traction.maximum", 0.0, 2.0),
    within("lubricant.traction.at_slip", 1e-5, 1000.0),
    within("lubricant.traction.limit", 0.0, 2.0),
    within("lubricant.traction.a", -1e4, 1e4),
    within("lubricant.traction.b", -1e4, 1e4),
    within("lubricant.traction.c", 0.0, 1e6),
    within("lubricant.traction.d", -1e4, 1e4),
    within("lubricant.traction.stress", 1.0, 1e9),
    within("lubricant.traction.coefficient", 0.0, 2.0),
    within("lubricant.traction.regularisation", 1e-5, 100.0),
    within(".restitution", 0.05, 1.0),
    within(".at_speed", 1e-6, 100.0),
    within(".viscous", 0.0, 1e9),
    within("gravity", -1000.0, 1000.0),
    within(".waviness.order", 1.0, MAX_ORDER),
    within(".waviness.amplitude", 0.0, 1e-4),
    within(".waviness.phase", -2.0 * PI, 2.0 * PI),
    within(".axial_waviness.order", 1.0, MAX_ORDER),
    within(".axial_waviness.amplitude", 0.0, 1e-4),
    within(".axial_waviness.phase", -2.0 * PI, 2.0 * PI),
    within(".random_waviness.amplitude", 0.0, 1e-4),
    within(".at_order", 1.0, MAX_ORDER),
    within(".exponent", 0.0, 4.0),
    within(".from_order", 1.0, MAX_ORDER),
    within(".to_order", 1.0, MAX_ORDER),
    within(".defects.azimuth", -2.0 * PI, 2.0 * PI),
    above(".defects.length", 0.0, 10.0),
    above(".defects.width", 0.0, 10.0),
    within(".defects.depth", 0.0, 1e-3),
    within(".defects.across", -0.5, 0.5),
    within("bearing.cage.pocket_deviations", -1.0, 1.0),
    within("surfaces.balls.ball", 1.0, MAX_BALLS),
    // A hundredth of the largest ball.
    within(".diameter_deviation", -0.005, 0.005),
    within(".diameter_spread", 0.0, 0.005),
    above(".defects.diameter", 0.0, 0.5),
    within(".defects.latitude", -0.5 * PI, 0.5 * PI),
    within(".defects.longitude", -2.0 * PI, 2.0 * PI),
    within("surfaces.seed", 0.0, 9_007_199_254_740_991.0),
];

/// The limits of a parameter; `None` for an unknown name.
pub fn limits_of(parameter: &str) -> Option<&'static Limits> {
    let is_it = |limits: &&Limits| match limits.parameter.starts_with('.') {
        true => parameter.ends_with(limits.parameter),
        false => parameter == limits.parameter,
    };
    LIMITS.iter().find(is_it)
}

/// An invalid parameter. `parameter` is its path in dots, in SI without unit suffix, such as `bearing.ball_diameter`;
/// `contract` turns it into a JSON pointer and the user's unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvalidParameter {
    /// Outside `lowest ..= highest` (infinite: no limit; `exclusive`: the lowest itself is refused). SI.
    #[error("{parameter} = {value} must lie in {lowest} … {highest}")]
    OutOfRange { parameter: &'static str, value: f64, lowest: f64, highest: f64, exclusive: bool },
    /// Each value is allowed by itself, but no bearing has all of them together. `items`: the place in each list on the path, from the
    /// outermost; empty where the whole list is meant.
    #[error("{parameter}: {reason}")]
    Inconsistent { parameter: &'static str, items: Vec<usize>, reason: String },
}

/// Faults of the parameters of an object to be built.
#[derive(Debug, Default)]
pub(crate) struct Faults(Vec<InvalidParameter>);

impl Faults {
    /// Records a value outside its limits, NaN included; returns true where it is inside. A parameter without limits
    /// has no valid value.
    pub(crate) fn check(&mut self, parameter: &'static str, value: f64) -> bool {
        let (lowest, highest, exclusive) =
            limits_of(parameter).map_or((f64::NAN, f64::NAN, false), |l| (l.lowest, l.highest, l.exclusive));
        let is_inside = value <= highest && if exclusive { value > lowest } else { value >= lowest };
        if !is_inside {
            self.0.push(InvalidParameter::OutOfRange { parameter, value, lowest, highest, exclusive });
        }
        is_inside
    }

    /// Records values that are allowed individually but not together.
    pub(crate) fn inconsistent(&mut self, parameter: &'static str, reason: String) {
        self.inconsistent_item(parameter, &[], reason);
    }

    /// The same of items of lists.
    pub(crate) fn inconsistent_item(&mut self, parameter: &'static str, items: &[usize], reason: String) {
        self.0.push(InvalidParameter::Inconsistent { parameter, items: items.to_vec(), reason });
    }

    /// Records the faults of a part.
    pub(crate) fn part<T>(&mut self, part: Result<T, Vec<InvalidParameter>>) -> Option<T> {
        part.map_err(|mut faults| self.0.append(&mut faults)).ok()
    }

    /// The result of `build` where there are no faults.
    pub(crate) fn or<T>(self, build: impl FnOnce() -> T) -> Result<T, Vec<InvalidParameter>> {
        self.of(Some(()), |()| build())
    }

    /// The result of `build` from a part that has no faults.
    pub(crate) fn of<P, T>(self, part: Option<P>, build: impl FnOnce(P) -> T) -> Result<T, Vec<InvalidParameter>> {
        match part {
            Some(part) if self.0.is_empty() => Ok(build(part)),
            _ => Err(self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_value_is_allowed_unless_it_is_exclusive() {
        let mut faults = Faults::default();
        assert!(faults.check("lubricant.fill", 0.0) && faults.check("lubricant.fill", 1.0));
        assert!(!faults.check("bearing.width", 0.0) && !faults.check("lubricant.fill", f64::NAN));
        assert!(faults.check("bearing.materials.cage.density", 1100.0) && !faults.check("nothing", 1.0));
        assert_eq!(faults.or(|| ()).unwrap_err().len(), 3);
    }
}
