//! Heights of wavy raceways in the models whose balls are in radial equilibrium between both.
//!
//! Heights add to the approach of the raceways, D = s_r − s_t²/(2r) − P_d/2 + h_i + h_e, and the ball stands at r = r₀ + δ_e − h_e. Each
//! raceway pushes the ball along the orbit by −Q h'/r, where r is the distance of the ball from the raceway's axis. The raceway takes the
//! opposite force.

use crate::numerics::lanes::{Lanes, Real, side_by_side};
use crate::physics::bearing::PerRaceway;
use crate::physics::surface::{Rise, SurfaceProfile};
use crate::simulation::model::mechanism::Mechanism;

/// Heights of both raceways under a ball.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Heights<T = f64> {
    pub inner: Rise<T>,
    pub outer: Rise<T>,
}
side_by_side!(Heights { inner, outer });

/// A height [m] and its rates in time [m/s, m/s²].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lift<T = f64> {
    pub height: T,
    pub rate: T,
    pub acceleration: T,
}

impl<T: Real> Heights<T> {
    /// Lift of each raceway on which a ball moves on at an angular speed [rad/s]. Changes of that speed lift a ball much less.
    #[inline(always)]
    pub(crate) fn lifts(&self, speed: PerRaceway<T>) -> PerRaceway<Lift<T>> {
        let one = |rise: &Rise<T>, speed: T| Lift {
            height: rise.height,
            rate: rise.slope * speed,
            acceleration: rise.curvature * (speed * speed),
        };
        PerRaceway { inner: one(&self.inner, speed.inner), outer: one(&self.outer, speed.outer) }
    }
}

impl<const N: usize> Heights<Lanes<N>> {
    /// In single precision.
    #[inline(always)]
    pub(crate) fn single(&self) -> Heights<Lanes<N, f32>> {
        let one = |rise: &Rise<Lanes<N>>| Rise {
            height: rise.height.single(),
            slope: rise.slope.single(),
            curvature: rise.curvature.single(),
        };
        Heights { inner: one(&self.inner), outer: one(&self.outer) }
    }
}

/// The raceways of a scene with waves.
#[derive(Debug, Clone)]
pub(crate) struct Waves {
    surface: PerRaceway<SurfaceProfile>,
}

impl Waves {
    /// The waves of a mechanism; `None` where both raceways are ideal circles.
    pub(crate) fn of(mechanism: &Mechanism) -> Option<Self> {
        let surface = mechanism.raceway.map(|contact| contact.surface().clone());
        (!(surface.inner.is_ideal() && surface.outer.is_ideal())).then_some(Self { surface })
    }

    /// Heights at the azimuths of several balls on both rings [rad].
    #[inline(always)]
    pub(crate) fn at<const N: usize>(&self, azimuth: &PerRaceway<Lanes<N>>) -> Heights<Lanes<N>> {
        Heights { inner: self.surface.inner.rises(&azimuth.inner), outer: self.surface.outer.rises(&azimuth.outer) }
    }
}
