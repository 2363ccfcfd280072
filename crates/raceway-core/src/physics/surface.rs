//! Deviation of a surface from its ideal circle: a height over azimuth.
//!
//! Waviness and local defects are added here. Profiles must be continuous with a continuous slope. The height enters
//! the penetration δ and the slope its rate; a step in height would be an impact that no step size resolves.

use crate::numerics::lanes::{Lanes, SideBySide};

/// Height that is added to the penetration of a contact [m], positive outwards.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum SurfaceProfile {
    /// The ideal circle.
    #[default]
    None,
    /// The same height everywhere [m]: a radius that differs from nominal.
    Constant(f64),
}

impl SurfaceProfile {
    /// Height at an azimuth in the frame of the body [rad], added to the penetration [m].
    #[inline(always)]
    pub fn height(&self, _azimuth: f64) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Constant(height) => height,
        }
    }

    /// Change of the height with azimuth [m/rad]; its product with the angular velocity of the contact along
    /// the body adds to the rate of penetration.
    #[inline(always)]
    pub fn slope(&self, _azimuth: f64) -> f64 {
        match *self {
            Self::None | Self::Constant(_) => 0.0,
        }
    }

    /// Heights and slopes at the azimuths of several balls.
    #[inline(always)]
    pub(crate) fn heights_and_slopes<const N: usize>(&self, azimuth: &Lanes<N>) -> (Lanes<N>, Lanes<N>) {
        let mut of = <(Lanes<N>, Lanes<N>)>::default();
        if !matches!(self, Self::None) {
            for lane in 0..N {
                of.put(lane, (self.height(azimuth[lane]), self.slope(azimuth[lane])));
            }
        }
        of
    }

    /// Returns true where the profile has no effect.
    #[cfg(test)]
    fn is_ideal(&self) -> bool {
        match *self {
            Self::None => true,
            Self::Constant(height) => height == 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slope is the derivative of the height (central difference), everywhere.
    #[test]
    fn slope_is_the_derivative_of_the_height() {
        for profile in [SurfaceProfile::None, SurfaceProfile::Constant(2e-6)] {
            for azimuth in [-3.0, 0.0, 0.1, 7.0] {
                let difference = profile.height(azimuth + 1e-4) - profile.height(azimuth - 1e-4);
                assert_eq!(profile.slope(azimuth), difference / 2e-4);
            }
        }
        assert_eq!(SurfaceProfile::Constant(2e-6).height(1.0), 2e-6);
        assert!(SurfaceProfile::default().is_ideal() && !SurfaceProfile::Constant(2e-6).is_ideal());
    }
}
