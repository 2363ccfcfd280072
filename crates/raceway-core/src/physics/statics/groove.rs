//! One raceway, and a ball in it.

use crate::physics::contact::hertz::HertzContact;

/// One raceway.
#[derive(Debug, Clone)]
pub(super) struct Groove {
    /// 1 for the outer raceway, −1 for the inner one.
    pub(super) side: f64,
    /// Radius of the circle of the groove's centres [m].
    pub(super) centre_radius: f64,
    /// Distance of ball and groove centre at touch, (f − ½) d [m].
    pub(super) touch_distance: f64,
    pub(super) hertz: HertzContact,
}

/// A ball in a groove.
#[derive(Debug, Clone, Copy)]
pub(super) struct InGroove {
    /// From the groove's centre to the ball's [m].
    pub(super) distance: f64,
    pub(super) penetration: f64,
    /// [N]
    pub(super) load: f64,
    /// Direction from the groove's centre to the ball's, along the axis and the radius.
    pub(super) direction: (f64, f64),
}

impl Groove {
    /// Largest pressure under a load [N], in Pa.
    pub(super) fn max_pressure(&self, load: f64) -> f64 {
        self.hertz.max_pressure(load)
    }

    /// A ball at an axial and a radial place [m] in this groove.
    pub(super) fn at(&self, axial: f64, radius: f64) -> InGroove {
        let radial = radius - self.centre_radius;
        let distance = axial.hypot(radial);
        let penetration = distance - self.touch_distance;
        // A groove is an arc: beyond its centre there is no surface to touch.
        let touches = self.side * radial > 0.0 && penetration > 0.0;
        let load = if touches { self.hertz.stiffness * penetration * penetration.sqrt() } else { 0.0 };
        InGroove { distance, penetration, load, direction: (axial / distance, radial / distance) }
    }
}
