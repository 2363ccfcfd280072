//! A bearing, rotated by a ball spacing, is the same bearing, and the numbers of its balls are arbitrary.

use std::f64::consts::TAU;

use raceway::physics::frames::{Azimuth, Vector};
use raceway::simulation::model::Model;
use raceway::simulation::model::state::{CageState, SpindleState};
use serde_json::json;

use crate::mirror_symmetry::difference;
use crate::scenes::{article, changed, disturbed, everything, model, rates};

const TIME: f64 = 2.3e-4;
const ROUNDING: f64 = 1e-11;

/// A state, or its rates, rotated by `steps` ball spacings: ball j becomes ball j + `steps`. The cage must not be tilted,
/// because Cardan angles do not rotate like vectors.
fn turned(model: &Model, y: &[f64], steps: usize) -> Vec<f64> {
    let layout = model.mechanism().layout;
    let turn = Azimuth::new(TAU * steps as f64 / layout.balls as f64);
    let pair = |[y, z]: [f64; 2]| {
        let [_, y, z] = turn.to_inertial([0.0, y, z]);
        [y, z]
    };
    let mut image = vec![0.0; y.len()];
    for ball in 0..layout.balls {
        layout.set_ball(&mut image, (ball + steps) % layout.balls, &layout.ball(y, ball));
    }
    let s = layout.cage(y);
    let cage = CageState {
        centre: turn.to_inertial(s.centre),
        velocity: turn.to_inertial(s.velocity),
        tilt: pair(s.tilt),
        tilt_rate: pair(s.tilt_rate),
        ..s
    };
    layout.set_cage(&mut image, &cage);
    let s = layout.spindle(y);
    let turn_vector = |v: Vector| turn.to_inertial(v);
    let spindle = SpindleState { position: turn_vector(s.position), velocity: turn_vector(s.velocity), ..s };
    layout.set_spindle(&mut image, &spindle);
    image
}

/// Without gravity and unbalance, a rotation of load and balls gives rotated rates, to rounding.
#[test]
fn rotated_load_and_balls_give_rotated_rates() {
    let load = |steps: usize| {
        let angle = TAU * steps as f64 / 7.0;
        let (y, z) = (200.0 * angle.cos(), 200.0 * angle.sin());
        changed(
            everything(),
            json!({
                "gravity_m_s2": 0,
                "spindle": { "balance_grade": 0 },
                "operation": { "radial_load_y_n": y, "radial_load_z_n": z }
            }),
        )
    };
    let model = model(&load(0));
    let layout = model.mechanism().layout;
    for steps in 1..7 {
        let image = self::model(&load(steps));
        for seed in 1..=5 {
            let mut state = disturbed(&model, seed);
            let upright = CageState { tilt: [0.0; 2], ..layout.cage(&state) };
            layout.set_cage(&mut state, &upright);
            let expected = turned(&model, &rates(&model, TIME, &state), steps);
            let found = rates(&image, TIME, &turned(&model, &state, steps));
            let off = difference(&model, &found, &expected);
            assert!(off < ROUNDING, "{steps} spacings, state {seed}: {off:e}");
        }
    }
}

/// The static state rotates with the load, too.
#[test]
fn the_static_state_rotates_with_the_load() {
    let at = |steps: usize| {
        let angle = TAU * steps as f64 / 7.0;
        let load = json!({ "radial_load_y_n": 200.0 * angle.cos(), "radial_load_z_n": 200.0 * angle.sin() });
        let model = model(&changed(article(), json!({ "gravity_m_s2": 0, "operation": load })));
        let state = raceway::simulation::model::equilibrium::start_state(&model).unwrap();
        (model, state)
    };
    let (model, state) = at(0);
    for steps in 1..7 {
        let image = at(steps).1;
        let expected = turned(&model, &state, steps);
        for (found, expected) in image.iter().zip(&expected) {
            // Each search ends at a residual of 1e-11 of the load, on contacts of 1e7 N/m.
            assert!((found - expected).abs() < 1e-14, "{steps}: {found:e} {expected:e}");
        }
    }
}

/// A state with the numbers of balls and pockets shifted by `steps`, and otherwise unchanged.
fn renumbered(model: &Model, y: &[f64], steps: usize, rates: bool) -> Vec<f64> {
    let m = model.mechanism();
    let layout = m.layout;
    // A renumbered ball has another start azimuth, from which its arc is measured.
    let moved = |number: usize| if rates { 0.0 } else { m.pitch_radius * m.start_azimuth(number) };
    let mut image = y.to_vec();
    for ball in 0..layout.balls {
        let number = (ball + steps) % layout.balls;
        let mut s = layout.ball(y, ball);
        // All arcs change by the same amount, except for whole turns.
        s.arc += moved(ball) - moved(number);
        layout.set_ball(&mut image, number, &s);
    }
    let mut cage = layout.cage(y);
    cage.arc -= moved(steps);
    layout.set_cage(&mut image, &cage);
    image
}

/// The resultant does not depend on the order of summation: the same balls and pockets with other numbers.
///
/// To rounding: arcs of up to a circumference give errors of 1e-15 in azimuths and 1e-17 m in positions. A pocket film of
/// 1e5 N/m and contacts of 1e8 N/m turn them into 1e-9 N.
#[test]
fn numbers_of_balls_do_not_matter() {
    let model = model(&everything());
    for steps in 1..7 {
        for seed in 1..=5 {
            let state = disturbed(&model, seed);
            let expected = renumbered(&model, &rates(&model, TIME, &state), steps, true);
            let found = rates(&model, TIME, &renumbered(&model, &state, steps, false));
            let off = difference(&model, &found, &expected);
            assert!(off < ROUNDING, "{steps} numbers on, state {seed}: {off:e}");
        }
    }
}

/// Without a cage any two balls that touch no other may exchange their numbers.
#[test]
fn two_balls_may_exchange_numbers_without_a_cage() {
    let model = model(&changed(everything(), json!({ "terms": { "cage": "off", "pocket_film": "off" } })));
    let m = model.mechanism();
    let swap = |y: &[f64], (a, b): (usize, usize), rates: bool| {
        let mut image = y.to_vec();
        let step = if rates { 0.0 } else { m.pitch_radius * (m.start_azimuth(b) - m.start_azimuth(a)) };
        let (mut first, mut second) = (m.layout.ball(y, a), m.layout.ball(y, b));
        first.arc -= step;
        second.arc += step;
        m.layout.set_ball(&mut image, a, &second);
        m.layout.set_ball(&mut image, b, &first);
        image
    };
    for pair in [(0, 1), (2, 6), (3, 5)] {
        let state = disturbed(&model, 4);
        let expected = swap(&rates(&model, TIME, &state), pair, true);
        let off = difference(&model, &rates(&model, TIME, &swap(&state, pair, false)), &expected);
        assert!(off < ROUNDING, "{pair:?}: {off:e}");
    }
}
