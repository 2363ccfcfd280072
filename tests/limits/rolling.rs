//! Loaded balls roll, and carry cage and unloaded balls with them at the speed of rolling.

use raceway::contract::{Outcome, execute, parse_job};
use raceway::physics::kinematics::ideal_frequencies;
use raceway::simulation::input::control::Control;
use raceway::simulation::model::equilibrium::start_state;
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

/// A ball under a contact angle turns about an axis that leans by it: BSF is what it turns by about that, and not about X, which is
/// a quarter less under 40°.
#[test]
fn balls_under_a_contact_angle_spin_at_bsf() {
    let job = json!({ "kind": "simulation", "settle_s": 0.03, "duration_s": 0.005,
        "outputs": { "metrics": ["cage"], "spectra": [] },
        "scene": { "operation": { "speed_rpm": 12000, "axial_load_n": 400 },
            "bearing": { "type": "angular_contact", "outer_diameter_mm": 52, "inner_diameter_mm": 25, "width_mm": 15, "ball_count": 7,
                "ball_diameter_mm": 7.94, "pitch_diameter_mm": 39.04, "contact_angle_deg": 40 } } });
    let job = parse_job(job.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(simulated)) = execute(&job, &Control::until(&|| false)) else { panic!("it runs") };
    let ideal = ideal_frequencies(&job.scene().bearing, job.scene().operating_speed()).ball_spin;
    let found = simulated.metrics.frequencies_hz.ball_spin;
    assert!((found / ideal - 1.0).abs() < 0.02, "{found} Hz for {ideal} Hz");
}
