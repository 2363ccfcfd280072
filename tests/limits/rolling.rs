//! Loaded balls roll, and drive cage and unloaded balls at the speed of rolling.

use raceway::contract::{Metrics, Outcome, execute, parse_job};
use raceway::physics::kinematics::ideal_frequencies;
use raceway::simulation::input::control::Control;
use raceway::simulation::model::equilibrium::start_state;
use serde_json::{Value, json};

use crate::article_run::balanced;
use crate::scenes::{advance, article, changed, model};

/// The cage of the article's bearing turns within 1 % of FTF = 327.6 Hz, and its balls spin within 1 % of BSF = 1860.8 Hz. No
/// loaded contact slips by more than 1 % of the 27 m/s of the inner raceway.
#[test]
fn cage_and_balls_turn_at_the_speeds_of_ideal_rolling() {
    let summary = &balanced().summary;
    let cage = summary.cage.as_ref().unwrap();
    assert!((cage.speed / 327.6 - 1.0).abs() < 0.01 && cage.slip.unwrap().abs() < 0.01);
    assert!((summary.frequencies.ball_spin / 1860.8 - 1.0).abs() < 0.01);
    let contacts = &summary.contacts.as_ref().unwrap().raceway;
    assert!(contacts.inner.max_slip < 0.27 && contacts.outer.max_slip < 0.27);
}

/// Metrics of a 6205 at 3000 r/min without gravity.
fn metrics_of_6205(operation: &Value, solver: &Value) -> Metrics {
    let mut job = json!({ "kind": "simulation", "duration_s": 0.05, "outputs": { "metrics": ["cage"], "spectra": [] },
        "solver": solver, "scene": { "bearing": "6205", "operation": operation, "gravity_m_s2": 0 } });
    job["scene"]["operation"]["speed_rpm"] = json!(3000);
    let job = parse_job(job.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(simulated)) = execute(&job, &Control::until(&|| false)) else { panic!("it runs") };
    simulated.metrics
}

/// An axial load raises the contact angle and with it the cage speed, which is no slip. The rest is conformity and spin.
#[test]
fn slip_against_the_loaded_contact_angle_is_small() {
    for (load, slip, free_angle) in [(50, -0.00025, -0.0056), (200, -0.00085, -0.0079), (3000, -0.0041, -0.0212)] {
        let operation = json!({ "radial_load_y_n": 20, "axial_load_n": load });
        let metrics = metrics_of_6205(&operation, &json!({}));
        let found = metrics.kinematics.unwrap();
        let (ours, old) = (found.cage_slip.unwrap(), found.cage_slip_free_angle.unwrap());
        assert!((ours - slip).abs() < 1.5e-4, "{load} N: {ours} for {slip}");
        assert!((old - free_angle).abs() < 1e-4, "{load} N: {old} for {free_angle}");
        assert!(metrics.accuracy.cage_slip_error.unwrap() < 1e-5);
    }
}

/// In the plane the angle is zero on every model level, and the slip is the same.
#[test]
fn model_levels_agree_on_the_slip() {
    let of = |rung: &str| {
        let metrics = metrics_of_6205(&json!({ "radial_load_y_n": 500 }), &json!({ "rung": rung }));
        assert_eq!(metrics.solver.rung, rung);
        metrics.kinematics.unwrap().cage_slip.unwrap()
    };
    let full = of("full");
    for rung in ["planar", "radially_condensed"] {
        let slip = of(rung);
        assert!((slip - full).abs() < 1e-5, "{rung}: {slip}, full: {full}");
    }
}

/// At high speed and without load the balls touch the outer raceway alone. Nothing drives them, so no slip is stated.
#[test]
fn balls_without_load_have_no_slip() {
    let job = json!({ "kind": "simulation", "settle_s": 0.01, "duration_s": 0.01,
        "outputs": { "metrics": ["cage"], "spectra": [] },
        "scene": { "bearing": "6205", "operation": { "speed_rpm": 20_000 }, "gravity_m_s2": 0 } });
    let job = parse_job(job.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(simulated)) = execute(&job, &Control::until(&|| false)) else { panic!("it runs") };
    let found = simulated.metrics.kinematics.unwrap();
    assert_eq!((found.cage_slip, simulated.metrics.accuracy.cage_slip_error), (None, None));
    assert!(found.cage_slip_free_angle.is_some());
    assert_eq!(raceway::contract::resolve_answer(&job).unwrap().derived.frequencies_loaded_hz, None);
}

/// A ball outside the load zone continues to orbit and spin near the speeds of rolling. Its centrifugal force presses it against
/// the outer raceway only.
#[test]
fn unloaded_ball_orbits_at_rolling_speed() {
    let model = model(&article());
    let m = model.mechanism();
    let speed = m.rotation.inner.at(0.0).1;
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

/// Without load the centrifugal force presses the balls against the outer raceway only. They continue to roll on it without a
/// driving force, braked by the lubricant mixture only.
#[test]
fn balls_without_a_load_keep_rolling() {
    let free = json!({ "gravity_m_s2": 0, "operation": { "radial_load_y_n": 0 }, "terms": { "drag": "off", "churning": "off" } });
    let model = model(&changed(article(), free));
    let m = model.mechanism();
    let speed = m.rotation.inner.at(0.0).1;
    let end = advance(&model, &start_state(&model).unwrap(), (0.0, 3e-3), 1e-5, |_| {});
    for ball in 0..m.layout.balls {
        let state = m.layout.ball(&end, ball);
        let orbit = state.arc_velocity / (m.orbit_ratio * speed * m.pitch_radius);
        assert!(orbit.abs() < 1e-3 && (state.spin[0] / (m.spin_ratio * speed)).abs() < 1e-3);
    }
}

/// A ball with a contact angle spins about an axis inclined by that angle. BSF is the spin about this axis. The spin about X is a
/// quarter less at 40°.
#[test]
fn balls_under_a_contact_angle_spin_at_bsf() {
    let job = json!({ "kind": "simulation", "settle_s": 0.03, "duration_s": 0.005,
        "outputs": { "metrics": ["cage"], "spectra": [] },
        "scene": { "operation": { "speed_rpm": 12000, "axial_load_n": 400 },
            "bearing": { "type": "angular_contact", "outer_diameter_mm": 52, "inner_diameter_mm": 25, "width_mm": 15, "ball_count": 7,
                "ball_diameter_mm": 7.94, "pitch_diameter_mm": 39.04, "contact_angle_deg": 40 } } });
    let job = parse_job(job.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(simulated)) = execute(&job, &Control::until(&|| false)) else { panic!("it runs") };
    let scene = job.scene().unwrap();
    let ideal = ideal_frequencies(&scene.bearing, scene.operating_speed()).ball_spin;
    let found = simulated.metrics.frequencies_hz.ball_spin;
    assert!((found / ideal - 1.0).abs() < 0.02, "{found} Hz for {ideal} Hz");
}
