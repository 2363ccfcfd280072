//! Deviation of a raceway from its ideal circle: a height over azimuth, out of the material.
//!
//! The height h adds to the penetration δ and its rate to the damping. Because δ depends on the azimuth φ of the ball on the ring, a
//! load Q also pushes the ball along the raceway with −Q h_φ/r, and the ring with the opposite at the same point: the tilt of the
//! contact normal. Without this lean force the height would do work that no body pays for.
//!
//! A profile has a continuous second derivative: a step in slope would be an impact that no step size resolves.

mod table;
pub mod waviness;

use std::sync::Arc;

use self::table::HeightTable;
use self::waviness::Wave;
use crate::numerics::lanes::{Lanes, SideBySide, side_by_side};

/// Height that is added to the penetration of a contact [m], positive out of the material.
#[derive(Debug, Clone, Default)]
pub enum SurfaceProfile {
    /// The ideal circle.
    #[default]
    None,
    /// The same height everywhere [m]: a radius that differs from nominal.
    Constant(f64),
    /// Waves round the ring.
    Waves(Arc<HeightTable>),
}

/// Height under a ball [m], with its first and second derivative by the azimuth on the ring [m/rad, m/rad²].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Rise<T = f64> {
    pub height: T,
    pub slope: T,
    pub curvature: T,
}
side_by_side!(Rise { height, slope, curvature });

impl SurfaceProfile {
    /// The sum of some waves; ideal without any.
    pub fn of_waves(waves: &[Wave]) -> Self {
        if waves.is_empty() { Self::None } else { Self::Waves(Arc::new(HeightTable::of_waves(waves))) }
    }

    /// Returns true where the profile has no effect.
    pub fn is_ideal(&self) -> bool {
        matches!(self, Self::None)
    }

    /// Height [m] at an azimuth on the ring [rad], and its change with the azimuth [m/rad].
    #[inline(always)]
    pub fn height_and_slope(&self, azimuth: f64) -> (f64, f64) {
        match self {
            Self::None => (0.0, 0.0),
            Self::Constant(height) => (*height, 0.0),
            Self::Waves(table) => table.height_and_slope(azimuth),
        }
    }

    /// Heights with both derivatives at the azimuths of several balls.
    #[inline(always)]
    pub(crate) fn rises<const N: usize>(&self, azimuth: &Lanes<N>) -> Rise<Lanes<N>> {
        match self {
            Self::None => Rise::default(),
            Self::Constant(height) => Rise { height: Lanes::all(*height), ..Rise::default() },
            Self::Waves(table) => table.rises(azimuth),
        }
    }

    /// Heights and slopes at the azimuths of several balls. A call of its own: scenes with ideal circles keep their loops as they are.
    #[inline(never)]
    pub(crate) fn heights_and_slopes<const N: usize>(&self, azimuth: &Lanes<N>) -> (Lanes<N>, Lanes<N>) {
        let mut of = <(Lanes<N>, Lanes<N>)>::default();
        for lane in 0..N {
            of.put(lane, self.height_and_slope(azimuth[lane]));
        }
        of
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_height_has_no_slope() {
        assert_eq!(SurfaceProfile::Constant(2e-6).height_and_slope(1.0), (2e-6, 0.0));
        assert_eq!(SurfaceProfile::None.height_and_slope(1.0), (0.0, 0.0));
        assert!(SurfaceProfile::of_waves(&[]).is_ideal() && !SurfaceProfile::Constant(0.0).is_ideal());
    }
}
