//! Frame of an inner contact: on a raceway parallel to X, and on a tilted one.

use crate::numerics::angle::small_angle;
use crate::numerics::lanes::{Lanes, SideBySide, side_by_side};
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, scale, subtract, turn_about};

/// Position of a ball on the inner raceway: place and axes of the contact's frame, in the orbit frame.
pub(super) trait ContactFrame: Copy {
    type Several: SideBySide<One = Self> + Default;
    /// Data of the raceway's axis.
    type Axis: Copy;
    /// In the orbit frame, velocity of a place that the tilting ring carries along, and angular velocity of the tilt.
    fn carried(axis: &Self::Axis, azimuth: Azimuth, from_centre: Vector) -> (Vector, Vector);
    /// Frame of a ball at an azimuth; `from_centre`: its place relative to the centre of the raceway, in its orbit frame.
    fn new(axis: &Self::Axis, azimuth: Azimuth, from_centre: Vector) -> Self;
    /// Distances along the raceway's axis and from it [m].
    fn place(&self) -> (f64, f64);
    /// Azimuth on the raceway less that about the bearing [rad].
    fn turn(&self) -> f64;
    /// Components in the contact's frame of a vector of the orbit frame.
    fn components(&self, v: Vector) -> Vector;
    /// Vector of the orbit frame with components in the contact's frame.
    fn vector(&self, c: Vector) -> Vector;
}

/// Frame on a raceway whose axis is parallel to X: the orbit frame turned about X.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StraightFrame<T = f64> {
    axial: T,
    radius: T,
    turn: Azimuth<T>,
}
side_by_side!(StraightFrame { axial, radius, turn });

impl ContactFrame for StraightFrame {
    type Several = StraightFrame<Lanes>;
    type Axis = ();

    #[inline(always)]
    fn carried(_: &(), _: Azimuth, _: Vector) -> (Vector, Vector) {
        ([0.0; 3], [0.0; 3])
    }

    #[inline(always)]
    fn new(_: &(), _: Azimuth, [axial, r, t]: Vector) -> Self {
        let radius = (r * r + t * t).sqrt();
        let per_radius = 1.0 / radius;
        Self { axial, radius, turn: Azimuth { cosine: per_radius * r, sine: per_radius * t } }
    }

    #[inline(always)]
    fn place(&self) -> (f64, f64) {
        (self.axial, self.radius)
    }

    #[inline(always)]
    fn turn(&self) -> f64 {
        small_angle(self.turn.cosine, self.turn.sine)
    }

    #[inline(always)]
    fn components(&self, v: Vector) -> Vector {
        self.turn.to_orbit(v)
    }

    #[inline(always)]
    fn vector(&self, c: Vector) -> Vector {
        self.turn.to_inertial(c)
    }
}

/// Axis of a ring that is tilted or tilts, in the inertial frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct TiltedAxis {
    /// Unit vector along the axis.
    pub direction: Vector,
    /// Angular velocity of axes that tilt with the ring and do not turn about its axis [rad/s].
    pub tilting: Vector,
}

impl TiltedAxis {
    /// Axis of a ring at an angle and rates about Y and about the new Z.
    #[inline(always)]
    pub(super) fn new([about_y, about_z]: [f64; 2], [rate_y, rate_z]: [f64; 2]) -> Self {
        let [direction, _, z] = Tilt::new(about_y, about_z).columns;
        Self { direction, tilting: add([0.0, rate_y, 0.0], scale(rate_z, z)) }
    }
}

/// Frame on a raceway whose axis is tilted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TiltedFrame<T = f64> {
    axial: T,
    radius: T,
    axis: Vector<T>,
    radial: Vector<T>,
    tangential: Vector<T>,
}
side_by_side!(TiltedFrame { axial, radius, axis, radial, tangential });

impl ContactFrame for TiltedFrame {
    type Several = TiltedFrame<Lanes>;
    type Axis = TiltedAxis;

    #[inline(always)]
    fn carried(axis: &TiltedAxis, azimuth: Azimuth, from_centre: Vector) -> (Vector, Vector) {
        let tilting = azimuth.to_orbit(axis.tilting);
        (cross(tilting, from_centre), tilting)
    }

    #[inline(always)]
    fn new(axis: &TiltedAxis, azimuth: Azimuth, from_centre: Vector) -> Self {
        let axis = azimuth.to_orbit(axis.direction);
        let axial = dot(from_centre, axis);
        let across = subtract(from_centre, scale(axial, axis));
        let radius = dot(across, across).sqrt();
        let radial = scale(1.0 / radius, across);
        Self { axial, radius, axis, radial, tangential: cross(axis, radial) }
    }

    #[inline(always)]
    fn place(&self) -> (f64, f64) {
        (self.axial, self.radius)
    }

    #[inline(always)]
    fn turn(&self) -> f64 {
        turn_about(self.axis, self.radial)
    }

    #[inline(always)]
    fn components(&self, v: Vector) -> Vector {
        [dot(self.axis, v), dot(self.radial, v), dot(self.tangential, v)]
    }

    #[inline(always)]
    fn vector(&self, c: Vector) -> Vector {
        add(scale(c[0], self.axis), add(scale(c[1], self.radial), scale(c[2], self.tangential)))
    }
}
