//! Orbit radii of the balls that touch both raceways, and the orbit speed at which they roll.

use super::evaluation::{BallLoads, total};
use crate::numerics::lanes::{LANES, Lanes, Singles};
use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::LoadedBall;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::recording::loaded_rolling::LoadedRolling;

/// Contact angles of balls in the plane of the bearing.
const IN_PLANE: PerRaceway<(f64, f64)> = PerRaceway { inner: (0.0, 1.0), outer: (0.0, 1.0) };

/// Sums over the balls that touch both raceways, by lane.
#[derive(Clone, Copy, Default)]
pub(super) struct LoadedLift {
    /// Number of balls, their loads on the outer raceway [N], and these loads times the excess of the orbit radius [N m].
    balls: Lanes,
    load: Lanes,
    moment: Lanes,
    /// Number of observed times.
    times: f64,
}

impl LoadedLift {
    /// Observes all balls at one time; `present`: 1 for a ball, 0 for a copy.
    #[inline(always)]
    pub(super) fn observe(&mut self, loads: &[BallLoads], present: &[Singles]) {
        self.times += 1.0;
        for (seen, present) in loads.iter().zip(present) {
            self.add(seen, present);
        }
    }

    #[inline(always)]
    fn add(&mut self, seen: &BallLoads, present: &Singles) {
        for lane in 0..LANES {
            let loaded = if seen.load.inner[lane] > 0.0 && seen.load.outer[lane] > 0.0 { present[lane] } else { 0.0 };
            let load = f64::from(loaded * seen.load.outer[lane]);
            self.balls[lane] += f64::from(loaded);
            self.load[lane] += load;
            self.moment[lane] += load * f64::from(seen.lift[lane]);
        }
    }

    /// Rolling at the mean orbit radius: the ratio of each ball is linear in its small excess, to 10⁻⁷.
    pub(super) fn rolling(&self, m: &Mechanism) -> LoadedRolling {
        let load = total(&self.load);
        let lift = if load > 0.0 { total(&self.moment) / load } else { 0.0 };
        let ball = LoadedBall { orbit_radius: m.pitch_radius + lift, ball_radius: m.ball_radius, angle: IN_PLANE };
        // Balls in the plane spin about X.
        let ratio = ball.orbit_ratio((-1.0, 0.0)).unwrap_or_default();
        LoadedRolling::of(self.times * m.layout.balls as f64, total(&self.balls), load, ratio)
    }
}
