//! Input of a rotor analysis.

use nalgebra::DMatrix;

use super::sensor::Sensor;
use crate::physics::contact::damping::DampingFactor;
use crate::physics::frame::disc::UnbalancePlane;
use crate::physics::frame::housing::Housing;
use crate::physics::frame::shaft::Shaft;
use crate::physics::frame::support::{PortMatrix, Support};
use crate::physics::kinematics::RingSpeeds;
use crate::physics::loads::{Load, SpindleLoad, start_and_largest_change};
use crate::physics::statics::ring::NoBalance;
use crate::physics::statics::shaft::{Mounted, Spring};

/// Largest slope of the shaft under its loads [rad]: its sine is smaller by 0.2 %.
pub(super) const MOST_SLOPE: f64 = 0.1;

/// A ball bearing on a shaft.
#[derive(Debug, Clone)]
pub struct RotorBearing {
    /// Place of its pocket plane along the shaft [m].
    pub at: f64,
    /// Bearing, facing and outer ring; its own position is that of `at`.
    pub mounted: Mounted,
    /// Damping of its contacts.
    pub damping: DampingFactor,
    /// Number of the housing's part that holds its outer ring; `None`: the ground.
    pub on: Option<usize>,
    pub seat: Seat,
    /// True if its balls see a tilt of its rings and act against it.
    pub has_moments: bool,
}

/// Seat of an outer ring in its body or in the ground.
#[expect(clippy::large_enum_variant, reason = "a machine has eight seats at most, and they stay copies")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seat {
    /// The ring moves with its body, whose mass contains it.
    Rigid,
    /// The ring is a body of its own on a spring and a dashpot. Mass [kg], inertia about a diameter and about the axis [kg m²]. A ring that turns takes
    /// its seat along; the seat is then the same in every direction across the axis.
    Elastic { mass: f64, inertia: f64, polar: f64, stiffness: PortMatrix, damping: PortMatrix },
    /// The ring slides along X on a spring that loads its balls, with its mass [kg] and damping [N s/m]; it moves with its body otherwise.
    Sliding { mass: f64, spring: Spring, damping: f64 },
}

impl RotorBearing {
    /// Place of its outer ring along the shaft [m].
    pub fn outer_ring(&self) -> f64 {
        self.at + self.mounted.outer[0]
    }

    /// Share of displacements x, y, z, β_y, β_z of a ring that its balls see, a row each.
    pub fn seen(&self, mut rows: DMatrix<f64>) -> DMatrix<f64> {
        if !self.has_moments {
            rows.rows_mut(3, 2).fill(0.0);
        }
        rows
    }

    /// True if its outer ring turns and takes an elastic seat along.
    pub fn turns_in_own_seat(&self) -> bool {
        matches!(self.seat, Seat::Elastic { .. }) && self.mounted.bearing.outer_speed() != 0.0
    }

    /// True if its outer ring moves.
    pub fn has_moving_outer_ring(&self) -> bool {
        self.on.is_some() || self.seat != Seat::Rigid
    }
}

/// A load on a place of the shaft [m].
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedLoad {
    pub at: f64,
    pub load: Load,
}

impl PlacedLoad {
    /// The load at the start, and the largest difference from it; of a harmonic load the mean.
    pub fn start_and_largest_change(&self) -> (SpindleLoad, SpindleLoad) {
        start_and_largest_change(std::slice::from_ref(&self.load))
    }
}

/// A shaft on linear supports and ball bearings, which stand in a housing or on the ground.
#[derive(Debug, Clone)]
pub struct Rotor {
    pub shaft: Shaft,
    pub unbalances: Vec<UnbalancePlane>,
    pub supports: Vec<Support>,
    pub bearings: Vec<RotorBearing>,
    pub housing: Housing,
    /// Operating speed [rad/s].
    pub speed: f64,
    /// Acceleration along +Y [m/s²].
    pub gravity: f64,
    /// Force on the mass centre along X, Y, Z [N].
    pub load: [f64; 3],
    /// Loads beside it. The equilibrium takes them as they are at the start.
    pub loads: Vec<PlacedLoad>,
}

impl Rotor {
    /// True if something beside the shaft moves.
    pub fn has_moving_housing(&self) -> bool {
        self.housing.moves() || self.bearings.iter().any(RotorBearing::has_moving_outer_ring)
    }

    /// Places of the shaft at which something acts, rising [m].
    pub fn places(&self) -> Vec<f64> {
        let discs = self.shaft.discs.iter().map(|disc| disc.at);
        let planes = self.unbalances.iter().map(|plane| plane.at);
        let held = self.supports.iter().map(|support| support.at).chain(self.bearings.iter().map(|bearing| bearing.at));
        let loaded = self.loads.iter().map(|load| load.at);
        rising(discs.chain(planes).chain(held).chain(loaded).collect())
    }

    /// The rotor with its shaft and the outer rings of its bearings at these speeds [rad/s].
    pub fn at_speeds(mut self, speeds: RingSpeeds) -> Self {
        self.speed = speeds.inner;
        for bearing in &mut self.bearings {
            let mounted = &mut bearing.mounted;
            mounted.bearing = mounted.bearing.clone().with_outer_speed(speeds.outer);
        }
        self
    }
}

/// Places in rising order, each once.
pub(crate) fn rising(mut places: Vec<f64>) -> Vec<f64> {
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}

/// Elements of the shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Elements {
    /// Refined until the kept frequencies have converged.
    #[default]
    Auto,
    /// One for each section, divided only where something acts on the shaft.
    Sections,
}

/// Quantities and resolution of an analysis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Request {
    pub elements: Elements,
    /// Speeds, rising, none negative [rad/s].
    pub speeds: Vec<f64>,
    /// Number of natural frequencies.
    pub modes: usize,
    pub sensors: Vec<Sensor>,
}

/// Reason why there is no result.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RotorError {
    /// Supports and loaded bearings leave a motion of the shaft free, or push it away.
    #[error(
        "supports and loaded bearings do not restrain every motion of the shaft; a bearing without load has no stiffness"
    )]
    Unrestrained,
    /// Stiffness and damping too far apart for double precision.
    #[error(
        "the eigenvalues of the rotor did not converge: a damper far above the critical damping of the shaft holds it; give it as stiffness"
    )]
    Unsolved,
    /// No position of the shaft was found at which the bearings carry its loads.
    #[error("no static equilibrium of shaft and bearings was found at {:.0} r/min: {cause}", 60.0 * speed / std::f64::consts::TAU)]
    NoEquilibrium { speed: f64, cause: NoEquilibrium },
    /// The caller no longer wants the result.
    #[error("stopped")]
    Stopped,
    /// A shaft without mass, or with lengths too far apart for double precision.
    #[error("the shaft has no free modes")]
    Singular,
}

/// Reason why a shaft has no static equilibrium. Bearings count from 1 along `scene.bearings`.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoEquilibrium {
    #[error(transparent)]
    Unbalanced(#[from] NoBalance),
    #[error("in bearing {bearing}, {source}")]
    Bearing { bearing: usize, source: NoBalance },
    /// The inner ring has left its balls.
    #[error(
        "the inner ring of bearing {bearing} moves {direction} by {displacement:.2e} m, but its balls hold it up to {limit:.2e} m only"
    )]
    Departs { bearing: usize, direction: &'static str, displacement: f64, limit: f64 },
    /// Bending and levers are linear.
    #[error("the shaft leans by {slope:.2} rad at {:.1} mm; linear bending holds up to {MOST_SLOPE} rad", 1e3 * at)]
    Leans { at: f64, slope: f64 },
}
