//! Slow rotation is a sequence of static states, and at any speed the raceways carry the mean load.

use std::f64::consts::TAU;

use raceway::numerics::ode::OdeSystem;
use raceway::physics::frames::{Azimuth, add, scale};
use raceway::physics::raceway::RacewayContact;
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use serde_json::json;

use crate::scenes::{advance, article, azimuth, changed, model, watched};

/// Static position of the spindle on balls at given azimuths under a load along Y [N].
///
/// Both raceways are in series, Q = K δ^1.5. Weight and centrifugal force of the balls (2e-4 N) are neglected. A contact
/// inclines by the displacement of the spindle over the radius. Each raceway carries half of the resulting tangential force by
/// traction. Newton's method with difference quotients.
fn resting_place(model: &Model, clearance: f64, azimuths: &[f64], load: f64) -> [f64; 2] {
    let raceway = &model.mechanism().raceway;
    let compliance = |contact: &RacewayContact| contact.hertz().stiffness.powf(-2.0 / 3.0);
    let stiffness = (compliance(&raceway.inner) + compliance(&raceway.outer)).powf(-1.5);
    let residual = |[y, z]: [f64; 2]| {
        let mut force = [load, 0.0];
        for angle in azimuths {
            let (sine, cosine) = angle.sin_cos();
            let (towards, aside) = (y * cosine + z * sine, z * cosine - y * sine);
            let lean = -aside / model.mechanism().pitch_radius;
            let penetration = towards + 0.5 * aside * lean - 0.5 * clearance;
            let normal = stiffness * penetration.max(0.0).powf(1.5);
            let tangential = 0.5 * lean * normal;
            force[0] -= normal * cosine - tangential * sine;
            force[1] -= normal * sine + tangential * cosine;
        }
        force
    };
    let mut place = [1.1e-5, 0.0];
    for _ in 0..30 {
        let step = 1e-10;
        let at = residual(place);
        let along_y =
            residual([place[0] + step, place[1]]).iter().zip(at).map(|(b, a)| (b - a) / step).collect::<Vec<_>>();
        let along_z =
            residual([place[0], place[1] + step]).iter().zip(at).map(|(b, a)| (b - a) / step).collect::<Vec<_>>();
        let determinant = along_y[0] * along_z[1] - along_z[0] * along_y[1];
        place[0] -= (at[0] * along_z[1] - along_z[0] * at[1]) / determinant;
        place[1] -= (along_y[0] * at[1] - at[0] * along_y[1]) / determinant;
    }
    place
}

/// At 500 r/min the spindle passes through the static states of the momentary ball azimuths.
///
/// The ball passage frequency of 23 Hz is far below the contact resonance of 4 kHz, (23/4000)² = 3e-5. The bound is 2 % of the
/// path between the position under a ball and that between two balls, 0.3 µm. The azimuths are the momentary ones, because
/// slow balls creep by some 30 µm under the load with a traction law linear in slip.
#[test]
fn a_slow_spindle_passes_through_static_states() {
    let json = changed(article(), json!({ "gravity_m_s2": 0, "operation": { "speed_rpm": 500 } }));
    let model = model(&json);
    let m = model.mechanism();
    let duration = 0.5 * TAU / 7.0 / (m.orbit_ratio * m.rotation.inner.at(0.0).1);
    let mut state = start_state(&model).unwrap();
    let (mut highest, mut lowest, mut worst) = (f64::NEG_INFINITY, f64::INFINITY, 0.0_f64);
    let mut time = 0.0;
    for part in 1..=10 {
        let next = duration * f64::from(part) / 10.0;
        state = advance(&model, &state, (time, next), 1e-5, |_| {});
        time = next;
        let azimuths: Vec<f64> = (0..7).map(|ball| azimuth(&model, time, &state, ball)).collect();
        let expected = resting_place(&model, 5e-6, &azimuths, 200.0);
        let found = m.layout.spindle(&state).position;
        worst = worst.max((found[1] - expected[0]).hypot(found[2] - expected[1]));
        (highest, lowest) = (highest.max(expected[1]), lowest.min(expected[1]));
    }
    let path = highest - lowest;
    assert!(path > 2e-7 && worst < 0.02 * path, "{worst:e} m off a path of {path:e} m");
}

/// The mean reaction of the outer raceway over whole ball passages balances load, weight and the change of momentum.
///
/// The balance is an integral of rates and exact to integration error. In a periodic motion the momentum does not change. The
/// mean reaction of the inner raceway then equals the load on the spindle, to 0.05 N after 6 ms of settling.
#[test]
fn mean_reactions_balance_the_mean_load() {
    let model = model(&article());
    let m = model.mechanism();
    let settled = advance(&model, &start_state(&model).unwrap(), (0.0, 6e-3), 1e-6, |_| {});
    let pass = TAU / 7.0 / (m.orbit_ratio * m.rotation.inner.at(0.0).1);
    let (start, end) = (6e-3, 6e-3 + 8.0 * pass);
    let looks = 8 * 200;
    let (mut inner, mut outer) = ([0.0; 3], [0.0; 3]);
    let mut look = 0;
    let mut between = vec![0.0; model.dimension()];
    advance(&model, &settled, (start, end), 1e-6, |step| {
        // Midpoints of equal parts of whole passages, for which the mean needs no end correction.
        loop {
            let time = start + (f64::from(look) + 0.5) * (end - start) / f64::from(looks);
            if look == looks || time > step.time() {
                break;
            }
            step.interpolate(time, &mut between);
            let (_, loads) = watched(&model, time, &between);
            for ball in 0..m.layout.balls {
                let turn = Azimuth::new(azimuth(&model, time, &between, ball));
                inner = add(inner, scale(1.0 / f64::from(looks), turn.to_inertial(loads.inner[ball].force)));
                outer = add(outer, scale(1.0 / f64::from(looks), turn.to_inertial(loads.outer[ball].force)));
            }
            look += 1;
        }
    });
    let spindle = 200.0 + m.spindle_mass * m.gravity;
    let all = spindle + (7.0 * m.ball_mass + m.cage.mass) * m.gravity;
    assert_eq!(look, looks);
    assert!((inner[1] - spindle).abs() < 0.05 && inner[2].abs() < 0.05, "{inner:?}");
    assert!((outer[1] + all).abs() < 0.05 && outer[2].abs() < 0.05, "{outer:?}");
}
