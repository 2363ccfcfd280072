//! Longest step of error control near defects of the raceways. Between two balls nothing announces an edge, and a long step would pass
//! over the whole defect.

use crate::numerics::angle::small_angle;
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::Azimuth;
use crate::physics::surface::defects::DefectReach;
use crate::simulation::model::mechanism::Mechanism;

/// End of the next step of error control [s], no later than `stop`. The way to the stop is divided into equal steps.
pub(crate) fn end_of_step(mechanism: &Mechanism, time: f64, state: &[f64], stop: f64) -> f64 {
    let steps = ((stop - time) / longest_step(mechanism, time, state)).ceil();
    if steps > 1.0 { time + (stop - time) / steps } else { stop }
}

/// The time in which no ball rolls beyond the entry of a defect, or within a defect farther than a share of its contact [s]; infinite
/// without defects.
fn longest_step(mechanism: &Mechanism, time: f64, state: &[f64]) -> f64 {
    if !mechanism.has_defects() {
        return f64::INFINITY;
    }
    let PerRaceway { inner, outer } = &mechanism.defects;
    let (angle, speed, _) = mechanism.speed.at(time);
    let spindle = mechanism.layout.spindle(state).position;
    let mut longest = f64::INFINITY;
    let mut limit = |defects: &[DefectReach], azimuth: f64, rate: f64| {
        for defect in defects {
            longest = longest.min(defect.largest_angle(azimuth) / rate.abs());
        }
    };
    for index in 0..mechanism.layout.balls {
        let ball = mechanism.layout.ball(state, index);
        let azimuth = mechanism.start.angle[index] + mechanism.orbit_ratio * angle + ball.arc / mechanism.pitch_radius;
        let rate = mechanism.orbit_ratio * speed + ball.arc_velocity / mechanism.pitch_radius;
        limit(outer, azimuth, rate);
        // About the axis of the spindle, tilt apart.
        let [_, towards, along] = Azimuth::new(azimuth).to_orbit(spindle);
        let turn = small_angle(mechanism.pitch_radius + ball.radial - towards, -along);
        limit(inner, azimuth + turn - angle, rate - speed);
    }
    longest
}
