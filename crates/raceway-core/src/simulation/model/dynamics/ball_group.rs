//! Balls side by side: their motion, its rates, and the slopes of what acts on them.

use super::contact_frame::ContactFrame;
use super::forces::Reaction;
use crate::numerics::lanes::{LANES, Lanes, SideBySide};
use crate::physics::ball::BallMotion;
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Vector, add};
use crate::physics::pocket::{PocketLoad, PocketSlopes};
use crate::physics::raceway::{ContactSlopes, RacewayLoad};
use crate::simulation::model::state::{BallAttitude, BallState};
use crate::simulation::model::step_loads::StepLoads;

/// Balls side by side: their motion, its rates, and the forces that they exert.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Balls {
    pub motion: BallMotion<Lanes>,
    pub rates: BallState<Lanes>,
    pub reaction: Reaction<Lanes>,
    /// Moments on a spindle that tilts, inertial frame [N m].
    pub on_tilt: Option<Vector<Lanes>>,
    /// Forces and moments about its centre on an outer ring that moves, inertial frame [N, N m].
    pub on_outer: Option<[Vector<Lanes>; 2]>,
    /// Attitudes, which are an input, and their rates; `None`: spheres have none.
    pub attitude: Option<[BallAttitude<Lanes>; 2]>,
}

impl Balls {
    /// Balls on a spindle that tilts, or not.
    #[inline(always)]
    pub(super) fn new(tilts: bool) -> Self {
        let on_tilt = tilts.then(Default::default);
        Self {
            motion: BallMotion::default(),
            rates: BallState::default(),
            reaction: Reaction::default(),
            on_tilt,
            on_outer: None,
            attitude: None,
        }
    }

    /// Adds the moments of the first `balls` lanes on a spindle that tilts, one ball after the other.
    #[inline(always)]
    pub(super) fn add_on_tilt(&self, sum: &mut Vector, balls: usize) {
        if let Some(on_tilt) = &self.on_tilt {
            for lane in 0..LANES.min(balls) {
                *sum = add(*sum, on_tilt.at(lane));
            }
        }
    }
}

impl Balls {
    /// Adds forces and moments of the first `balls` lanes on an outer ring that moves, one ball after the other.
    #[inline(always)]
    pub(super) fn add_on_outer(&self, sum: &mut [Vector; 2], balls: usize) {
        if let Some([forces, moments]) = &self.on_outer {
            for lane in 0..LANES.min(balls) {
                *sum = [add(sum[0], forces.at(lane)), add(sum[1], moments.at(lane))];
            }
        }
    }
}

/// Loads on balls side by side.
pub(super) struct BallLoads<'a, F: ContactFrame> {
    /// Frames of the inner contacts.
    pub frames: &'a F::Several,
    pub raceway: &'a PerRaceway<RacewayLoad<Lanes>>,
    pub pocket: &'a PocketLoad<Lanes>,
    /// From the cage's centre of mass to the balls, in the cage's tilted frame [m].
    pub places: &'a Vector<Lanes>,
    /// Drag along the orbit [N].
    pub drag: &'a Lanes,
    /// Churning moment over spin [N m s].
    pub churning_factor: &'a Lanes,
}

/// Slopes of the loads on balls side by side over their own motion, in their orbit frames.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slopes<T = f64> {
    pub raceway: PerRaceway<ContactSlopes<T>>,
    pub pocket: PocketSlopes<T>,
    /// From the cage's centre of mass to the contact, inertial frame [m].
    pub arm: Vector<T>,
    /// Slip of the raceways over the ball, along the groove and across it [m/s].
    pub slip: PerRaceway<(T, T)>,
    /// Loads, angles and rolling speeds, without the squares of the slip.
    pub loads: StepLoads<T>,
}
