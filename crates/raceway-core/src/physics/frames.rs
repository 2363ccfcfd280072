//! Every sign convention of the program.
//!
//! * Inertial frame XYZ: X along the bearing axis, radial load and gravity along +Y, right-handed.
//! * Azimuth φ from +Y towards +Z.
//! * Orbit frame of a ball: `x` ∥ X, `r` radially outward, `t` (circumferential) towards rising φ;
//!   x × r = t. Vectors in it are written `[x, r, t]`.
//! * Positive spindle speed turns +Y towards +Z; a rolling ball then spins negatively about x.

use std::ops::{Add, Mul, Sub};

use crate::numerics::angle::{sin_cos, small_angle};
use crate::numerics::lanes::side_by_side;

/// A vector of three components.
pub type Vector<T = f64> = [T; 3];

/// a · b
#[inline(always)]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b
#[inline(always)]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + b
#[inline(always)]
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b
#[inline(always)]
pub fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// factor · a
#[inline(always)]
pub fn scale(factor: f64, a: Vector) -> Vector {
    [factor * a[0], factor * a[1], factor * a[2]]
}

/// √(a · a)
#[inline(always)]
pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Azimuth about an axis of a place at `radial` from it, less the azimuth of the orbit frame [rad]. Both start at the same direction,
/// which the smallest rotation from X to the axis carries along. Vectors in the orbit frame, the axis of length 1.
#[inline(always)]
pub(crate) fn turn_about(axis: Vector, radial: Vector) -> f64 {
    let share = radial[0] / (1.0 + axis[0]);
    small_angle(radial[1] - axis[1] * share, radial[2] - axis[2] * share)
}

/// The direction of an azimuth.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Azimuth<T = f64> {
    pub cosine: T,
    pub sine: T,
}
side_by_side!(Azimuth { cosine, sine });

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Azimuth<T> {
    /// The sum of two azimuths.
    #[inline(always)]
    pub fn turned(self, by: Self) -> Self {
        Self {
            cosine: self.cosine * by.cosine - self.sine * by.sine,
            sine: self.sine * by.cosine + self.cosine * by.sine,
        }
    }
}

impl Azimuth {
    /// Azimuth of an angle [rad].
    #[inline(always)]
    pub fn new(angle: f64) -> Self {
        let (sine, cosine) = sin_cos(angle);
        Self { cosine, sine }
    }

    /// In single precision.
    #[inline(always)]
    pub fn single(self) -> Azimuth<f32> {
        Azimuth { cosine: self.cosine as f32, sine: self.sine as f32 }
    }

    /// A vector of the inertial frame, in the orbit frame at this azimuth.
    #[inline(always)]
    pub fn to_orbit(self, v: Vector) -> Vector {
        [v[0], self.cosine * v[1] + self.sine * v[2], self.cosine * v[2] - self.sine * v[1]]
    }

    /// A vector of the orbit frame at this azimuth, in the inertial frame.
    #[inline(always)]
    pub fn to_inertial(self, v: Vector) -> Vector {
        [v[0], self.cosine * v[1] - self.sine * v[2], self.cosine * v[2] + self.sine * v[1]]
    }
}

/// A frame whose x axis is tilted by an angle about Y, then about the new Z. Columns are its axes in the inertial frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tilt {
    pub columns: [Vector; 3],
}

impl Tilt {
    /// No tilt.
    pub(crate) const NONE: Self = Self { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// Tilts about Y and about the new Z [rad].
    #[inline(always)]
    pub fn new(about_y: f64, about_z: f64) -> Self {
        let (sb, cb) = sin_cos(about_y);
        let (sz, cz) = sin_cos(about_z);
        Self { columns: [[cb * cz, sz, -sb * cz], [-cb * sz, cz, sb * sz], [sb, 0.0, cb]] }
    }

    /// Cosine of the tilt about the new Z.
    pub(crate) fn cosine_about_z(&self) -> f64 {
        self.columns[1][1]
    }

    /// Tangent of the tilt about the new Z.
    pub(crate) fn tangent_about_z(&self) -> f64 {
        self.columns[0][1] / self.columns[1][1]
    }

    /// A vector of the inertial frame, in the tilted frame.
    #[inline(always)]
    #[allow(clippy::wrong_self_convention, reason = "nine numbers are not copied for each vector")]
    pub(crate) fn to_tilted(&self, v: Vector) -> Vector {
        [dot(self.columns[0], v), dot(self.columns[1], v), dot(self.columns[2], v)]
    }

    /// A vector of the tilted frame, in the inertial frame.
    #[inline(always)]
    pub fn to_inertial(&self, v: Vector) -> Vector {
        add(scale(v[0], self.columns[0]), add(scale(v[1], self.columns[1]), scale(v[2], self.columns[2])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbit_frame_is_right_handed_and_turns_y_towards_z() {
        let quarter = Azimuth::new(std::f64::consts::FRAC_PI_2);
        let outward = quarter.to_inertial([0.0, 1.0, 0.0]);
        assert!(length(subtract(outward, [0.0, 0.0, 1.0])) < 1e-15);
        assert_eq!(cross([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        let v = [0.3, -0.7, 1.1];
        assert!(length(subtract(quarter.to_orbit(quarter.to_inertial(v)), v)) < 1e-15);
    }

    #[test]
    fn tilted_frame_is_a_rotation() {
        let tilt = Tilt::new(0.2, -0.4);
        let [x, y, z] = tilt.columns;
        assert!(length(subtract(cross(x, y), z)) < 1e-15);
        let v = [0.3, -0.7, 1.1];
        assert!(length(subtract(tilt.to_tilted(tilt.to_inertial(v)), v)) < 1e-15);
        // A small tilt about Y moves the axis towards −Z, about Z towards +Y.
        assert!(Tilt::new(1e-3, 0.0).columns[0][2] < 0.0);
        assert!(Tilt::new(0.0, 1e-3).columns[0][1] > 0.0);
    }
}
