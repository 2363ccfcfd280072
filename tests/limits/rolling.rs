//! Loaded balls roll, and carry cage and unloaded balls with them at the speed of rolling.

use raceway::simulation::run::start_state;
use serde_json::json;

use crate::article_run::balanced;
use crate::scenes::{advance, article, changed, model};

/// The article's cage turns within 1 % of FTF = 327.6 Hz and balls spin within 1 % of BSF = 1860.8 Hz; no loaded
/// contact slips by more than 1 % of the 27 m/s at which the inner raceway passes.
#[test]
fn cage_and_balls_turn_at_the_speeds_of_ideal_rolling() {
    let summary = &balanced().summary;
    let cage = summary.cage.as_ref().unwrap();
    assert!((cage.speed / 327.6 - 1.0).abs() < 0.01 && cage.slip.unwrap().abs() < 0.01);
    assert!((summary.frequencies.ball_spin / 1860.8 - 1.0).abs() < 0.01);
    let contacts = &summary.contacts.as_ref().unwrap().raceway;
    assert!(contacts.inner.max_slip < 0.27 && contacts.outer.max_slip < 0.27);
}

/// A ball that the load has left for the time being keeps orbiting and spinning near the speeds of rolling: it
/// touches the outer raceway alone, pressed by its centrifugal force.
#[test]
fn unloaded_ball_orbits_at_rolling_speed() {
    let model = model(&article());
    let m = model.mechanism();
    let speed = m.speed.at(0.0).1;
    let rolling = m.orbit_ratio * speed * m.pitch_radius;
    let mut worst: f64 = 0.0;
    let start = start_state(&model).unwrap();
    advance(&model, &start, (0.0, 6e-3), 1e-5, |step| {
        for ball in 0..m.layout.balls {
            let state = m.layout.ball(step.state(), ball);
            let spin = state.spin[0].abs() / (m.spin_ratio * speed).abs();
            worst = worst.max((state.arc_velocity / rolling).abs()).max(spin);
        }
    });
    assert!(worst < 0.03, "{worst}");
}

/// Without any load the balls are held by their centrifugal force against the outer raceway alone and keep rolling
/// on it, turned by nothing and braked by nothing but the mixture.
#[test]
fn balls_without_a_load_keep_rolling() {
    let free = json!({ "gravity_m_s2": 0, "operation": { "radial_load_y_n": 0 }, "terms": { "drag": "off", "churning": "off" } });
    let model = model(&changed(article(), free));
    let m = model.mechanism();
    let speed = m.speed.at(0.0).1;
    let end = advance(&model, &start_state(&model).unwrap(), (0.0, 3e-3), 1e-5, |_| {});
    for ball in 0..m.layout.balls {
        let state = m.layout.ball(&end, ball);
        let orbit = state.arc_velocity / (m.orbit_ratio * speed * m.pitch_radius);
        assert!(orbit.abs() < 1e-3 && (state.spin[0] / (m.spin_ratio * speed)).abs() < 1e-3);
    }
}
