//! Thinnest lubricant films of a run.
//!
//! Most films are thicker than the thinnest so far. A bound over eight balls side by side shows that without their thickness; only
//! balls beyond the bound are evaluated one by one.

use super::ball::Balls;
use super::evaluation::BallLoads;
use crate::numerics::lanes::{LANES, Singles};
use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::ThinnestFilm;
use crate::physics::raceway::{RacewayContact, RelativeMotion};
use crate::simulation::model::mechanism::Mechanism;

/// The thinnest films so far, and the rolling speeds at one spindle speed.
#[derive(Debug, Clone)]
pub(super) struct Films {
    pub thinnest: PerRaceway<ThinnestFilm>,
    /// Spindle speed of `rolling` [rad/s]; not a number before the first step.
    speed: f64,
    rolling: PerRaceway<RollingSpeed>,
}

/// Mean rolling speed at a contact as a linear function of a ball's deviations from ideal rolling.
#[derive(Debug, Clone, Copy, Default)]
struct RollingSpeed {
    /// In ideal rolling [m/s].
    ideal: f32,
    /// Slope over the velocity along the arc [-].
    by_arc_velocity: f32,
    /// Slope over the spin [m].
    by_spin: f32,
}

impl RollingSpeed {
    fn of(m: &Mechanism, contact: &RacewayContact, speed: f64, raceway_speed: f64) -> Self {
        let at = |arc_velocity: f64, spin: f64| rolling_speed(m, contact, speed, raceway_speed, (arc_velocity, spin));
        let ideal = at(0.0, 0.0);
        // Any displacement gives the slope of a linear function.
        let unit = 1.0;
        Self {
            ideal: ideal as f32,
            by_arc_velocity: ((at(unit, 0.0) - ideal) / unit) as f32,
            by_spin: ((at(0.0, unit) - ideal) / unit) as f32,
        }
    }

    /// Rolling speeds of eight balls [m/s].
    #[inline(always)]
    fn at(self, balls: &Balls) -> Singles {
        let mut speeds = Singles::default();
        for lane in 0..LANES {
            speeds[lane] =
                self.ideal + self.by_arc_velocity * balls.arc_velocity[lane] + self.by_spin * balls.spin[lane];
        }
        speeds
    }
}

/// Mean rolling speed of a ball at the pitch radius [m/s]; deviations: velocity along the arc [m/s], spin [rad/s].
fn rolling_speed(
    m: &Mechanism,
    contact: &RacewayContact,
    speed: f64,
    raceway_speed: f64,
    (arc_velocity, spin): (f64, f64),
) -> f64 {
    let orbit_speed = m.orbit_ratio * speed + arc_velocity / m.pitch_radius;
    contact.rolling_speed(&RelativeMotion {
        axial: 0.0,
        radius: m.pitch_radius,
        velocity: [0.0, 0.0, m.pitch_radius * orbit_speed],
        spin: [m.spin_ratio * speed + spin, 0.0, 0.0],
        raceway_speed,
        orbit_speed,
        azimuth: 0.0,
    })
}

impl Films {
    pub(super) fn new() -> Self {
        Self {
            thinnest: PerRaceway { inner: ThinnestFilm::NONE, outer: ThinnestFilm::NONE },
            speed: f64::NAN,
            rolling: PerRaceway::default(),
        }
    }

    /// Records the films of all contacts under load at one time; `speed`: of the spindle [rad/s].
    #[inline(always)]
    pub(super) fn record(&mut self, m: &Mechanism, balls: &[Balls], loads: &[BallLoads], speed: f64) {
        if speed != self.speed {
            self.set_speed(m, speed);
        }
        for (group, (balls, loads)) in balls.iter().zip(loads).enumerate() {
            let inner = self.thinnest.inner.may_be_thinner(&self.rolling.inner.at(balls), &loads.load.inner);
            let outer = self.thinnest.outer.may_be_thinner(&self.rolling.outer.at(balls), &loads.load.outer);
            if inner || outer {
                self.record_group(m, group, balls, loads, speed);
            }
        }
    }

    #[inline(never)]
    fn set_speed(&mut self, m: &Mechanism, speed: f64) {
        self.speed = speed;
        self.rolling = PerRaceway {
            inner: RollingSpeed::of(m, &m.raceway.inner, speed, speed),
            outer: RollingSpeed::of(m, &m.raceway.outer, speed, 0.0),
        };
    }

    #[inline(never)]
    fn record_group(&mut self, m: &Mechanism, group: usize, balls: &Balls, loads: &BallLoads, speed: f64) {
        let count = LANES.min(m.layout.balls - group * LANES);
        for lane in 0..count {
            let deviations = (f64::from(balls.arc_velocity[lane]), f64::from(balls.spin[lane]));
            let record = |contact: &RacewayContact, raceway_speed: f64, load: f32, thinnest: &mut ThinnestFilm| {
                if load > 0.0 {
                    contact.meet_film(
                        rolling_speed(m, contact, speed, raceway_speed, deviations),
                        load.into(),
                        thinnest,
                    );
                }
            };
            record(&m.raceway.inner, speed, loads.load.inner[lane], &mut self.thinnest.inner);
            record(&m.raceway.outer, 0.0, loads.load.outer[lane], &mut self.thinnest.outer);
        }
    }
}
