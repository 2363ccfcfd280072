//! Heights of raceways with waves and defects and of wavy balls in the models whose balls are in radial equilibrium between both raceways.
//!
//! Heights add to the approach of the raceways, D = s_r − s_t²/(2r) − P_d/2 + h_i + h_e, and the ball stands at r = r₀ + δ_e − h_e. Each
//! raceway pushes the ball along the orbit by −Q h'/r, where r is the distance of the ball from the raceway's axis. The raceway takes the
//! opposite force. The height of a ball depends on the longitude of the contact on it and pushes in the same way; it also turns the ball by
//! the moment Q h'.

use std::sync::Arc;

use crate::numerics::lanes::{Lanes, Real, side_by_side};
use crate::physics::bearing::PerRaceway;
use crate::physics::surface::sphere::SphereProfiles;
use crate::physics::surface::{Rise, SurfaceProfile};
use crate::simulation::model::mechanism::Mechanism;

/// Heights of both raceways under a ball, by azimuth, and of the ball at both contacts, by longitude.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Heights<T = f64> {
    pub raceway: PerRaceway<Rise<T>>,
    pub ball: PerRaceway<Rise<T>>,
}
side_by_side!(Heights { raceway, ball });

/// A height [m] and its rates in time [m/s, m/s²].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lift<T = f64> {
    pub height: T,
    pub rate: T,
    pub acceleration: T,
}

impl<T: Real> Heights<T> {
    /// Lift of each raceway on which a ball moves on at an angular speed, while the ball turns at another [rad/s]. Changes of these speeds
    /// lift a ball much less.
    #[inline(always)]
    pub(crate) fn lifts(&self, speed: PerRaceway<T>, of_contact: PerRaceway<T>, spin: T) -> PerRaceway<Lift<T>> {
        let one = |raceway: &Rise<T>, ball: &Rise<T>, speed: T, of_contact: T| {
            let turning = of_contact - spin;
            Lift {
                height: raceway.height + ball.height,
                rate: raceway.slope * speed + ball.slope * turning,
                acceleration: raceway.curvature * (speed * speed) + ball.curvature * (turning * turning),
            }
        };
        let Self { raceway, ball } = self;
        PerRaceway {
            inner: one(&raceway.inner, &ball.inner, speed.inner, of_contact.inner),
            outer: one(&raceway.outer, &ball.outer, speed.outer, of_contact.outer),
        }
    }

    /// Slopes of raceway and ball together, which push the ball along the orbit [m/rad].
    #[inline(always)]
    pub(crate) fn slopes(&self) -> PerRaceway<T> {
        PerRaceway {
            inner: self.raceway.inner.slope + self.ball.inner.slope,
            outer: self.raceway.outer.slope + self.ball.outer.slope,
        }
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
        let both = |pair: &PerRaceway<Rise<Lanes<N>>>| PerRaceway { inner: one(&pair.inner), outer: one(&pair.outer) };
        Heights { raceway: both(&self.raceway), ball: both(&self.ball) }
    }
}

/// Raceways and balls of a scene with waves or defects.
#[derive(Debug, Clone)]
pub(crate) struct Waves {
    surface: PerRaceway<SurfaceProfile>,
    /// `None`: all balls are spheres.
    balls: Option<PerRaceway<Arc<SphereProfiles>>>,
}

impl Waves {
    /// The heights of a planar mechanism; `None` where both raceways are ideal circles and all balls spheres.
    pub(crate) fn of(mechanism: &Mechanism) -> Option<Self> {
        let surface = mechanism.raceway.map(|contact| contact.surface().clone());
        let balls = mechanism.layout.attitude.then(|| mechanism.raceway.map(|contact| contact.balls().clone()));
        let is_ideal = surface.inner.is_ideal() && surface.outer.is_ideal() && balls.is_none();
        (!is_ideal).then_some(Self { surface, balls })
    }

    /// Returns true where a ball has waves.
    #[inline(always)]
    pub(crate) fn are_of_balls(&self) -> bool {
        self.balls.is_some()
    }

    /// Heights of both rings at the azimuths of several balls [rad].
    #[inline(always)]
    pub(crate) fn at<const N: usize>(&self, azimuth: &PerRaceway<Lanes<N>>) -> Heights<Lanes<N>> {
        let raceway = PerRaceway {
            inner: self.surface.inner.rises(&azimuth.inner),
            outer: self.surface.outer.rises(&azimuth.outer),
        };
        Heights { raceway, ..Heights::default() }
    }

    /// Heights of the balls from `first` on at the longitudes of both contacts [rad]; 0 for spheres.
    #[inline(always)]
    pub(crate) fn of_balls(&self, first: usize, longitude: &PerRaceway<Lanes>) -> PerRaceway<Rise<Lanes>> {
        match &self.balls {
            None => PerRaceway::default(),
            Some(PerRaceway { inner, outer }) => PerRaceway {
                inner: inner.on_tracks(first, &longitude.inner),
                outer: outer.on_tracks(first, &longitude.outer),
            },
        }
    }
}
