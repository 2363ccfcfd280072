//! Longest step of error control near defects of raceways and balls, and under loads that vary. Between two balls nothing announces an edge,
//! and a long step would pass over the whole defect, or over a shock.

use crate::numerics::angle::small_angle;
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Vector, add, length, scale, subtract};
use crate::physics::raceway::RacewayContact;
use crate::physics::surface::defects::DefectReach;
use crate::simulation::model::mechanism::{Mechanism, UnevenBall};

/// End of the next step of error control [s], no later than `stop`. The way to the stop is divided into equal steps.
pub(crate) fn end_of_step(mechanism: &Mechanism, time: f64, state: &[f64], stop: f64) -> f64 {
    let steps = ((stop - time) / longest_step(mechanism, time, state)).ceil();
    if steps > 1.0 { time + (stop - time) / steps } else { stop }
}

/// The time in which no ball rolls beyond the entry of a defect, or within one farther than a share of its contact [s]. Loads change by a part
/// of their course in it. It is infinite without defects and under constant loads.
fn longest_step(mechanism: &Mechanism, time: f64, state: &[f64]) -> f64 {
    let of_loads = mechanism.varying_loads.as_ref().map_or(f64::INFINITY, |loads| loads.longest_step_from(time));
    if !mechanism.has_defects() {
        return of_loads;
    }
    let PerRaceway { inner, outer } = &mechanism.defects;
    let rotations = mechanism.rotations(time);
    let spindle = mechanism.layout.spindle(state).position;
    let mut longest = of_loads;
    let mut limit = |defects: &[DefectReach], azimuth: f64, rate: f64| {
        for defect in defects {
            longest = longest.min(defect.largest_angle(azimuth) / rate.abs());
        }
    };
    for index in 0..mechanism.layout.balls {
        let ball = mechanism.layout.ball(state, index);
        let azimuth = mechanism.azimuth(index, &rotations, ball.arc);
        let rate = mechanism.orbit_speed(&rotations, ball.arc_velocity);
        limit(outer, azimuth - rotations.outer.angle, rate - rotations.outer.speed);
        // About the axis of the spindle, tilt apart.
        let [_, towards, along] = Azimuth::new(azimuth).to_orbit(spindle);
        let turn = small_angle(mechanism.pitch_radius + ball.radial - towards, -along);
        limit(inner, azimuth + turn - rotations.inner.angle, rate - rotations.inner.speed);
    }
    (0..mechanism.uneven_balls.len()).map(|index| on_ball(mechanism, time, state, index)).fold(longest, f64::min)
}

/// The same of the defects of a ball, by the angles between their directions and those of the contacts.
fn on_ball(mechanism: &Mechanism, time: f64, state: &[f64], index: usize) -> f64 {
    let UnevenBall { axes, defects: PerRaceway { inner, outer }, .. } = &mechanism.uneven_balls[index];
    if inner.is_empty() && outer.is_empty() {
        return f64::INFINITY;
    }
    let (layout, rotations) = (&mechanism.layout, mechanism.rotations(time));
    let (ball, attitude) = (layout.ball(state, index), layout.attitude(state, index));
    let [about_x, about_r, about_t] = ball.spin;
    let turning = [about_x + rotations.turn_speed - ball.arc_velocity / mechanism.pitch_radius, about_r, about_t];
    let axes = attitude.axes(axes, Azimuth::new(rotations.turn), layout.planar);
    let azimuth = mechanism.azimuth(index, &rotations, ball.arc);
    let at = [ball.axial, mechanism.pitch_radius + ball.radial, 0.0];
    let [x, towards, along] = Azimuth::new(azimuth).to_orbit(layout.spindle(state).position);
    let from_spindle = subtract(at, [x + mechanism.axial_offset, towards, along]);
    let nearest = |contact: &RacewayContact, defects: &[(Vector, DefectReach)], from: Vector| {
        let (_, (axial, radial)) = match layout.planar {
            true => contact.penetration::<true>(0.0, from[1]),
            false => contact.penetration::<false>(from[0], from[1]),
        };
        let angle = |&(direction, reach): &(Vector, DefectReach)| {
            let [one, two, three] = direction;
            let direction = add(scale(one, axes[0]), add(scale(two, axes[1]), scale(three, axes[2])));
            reach.largest_angle_from(angle_between([axial, radial, 0.0], direction))
        };
        defects.iter().map(angle).fold(f64::INFINITY, f64::min)
    };
    let PerRaceway { inner: on_inner, outer: on_outer } = &mechanism.raceway;
    nearest(on_inner, inner, from_spindle).min(nearest(on_outer, outer, at)) / length(turning)
}

/// Angle between two directions [rad].
fn angle_between(a: Vector, b: Vector) -> f64 {
    // By half of it, which small_angle knows to 1e-7 and better.
    2.0 * small_angle(length(add(a, b)), length(subtract(a, b)))
}
