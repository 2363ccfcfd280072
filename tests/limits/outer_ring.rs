//! An outer ring that turns about its axis: only the speed of the rings relative to each other rolls the balls.

use std::f64::consts::TAU;

use raceway::contract::{Metrics, Outcome, execute, parse_job};
use raceway::physics::kinematics::ideal_frequencies;
use raceway::simulation::input::control::Control;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::state::{CageState, SpindleState};
use serde_json::{Value, json};

use crate::scenes::{advance, changed, disturbed, everything, model, watched, waves};

/// The scene of all forces without those that know a direction or a speed in space.
fn weightless(inner_rpm: f64, outer_rpm: f64) -> Value {
    changed(
        everything(),
        json!({
            "gravity_m_s2": 0,
            "operation": {
                "speed_rpm": inner_rpm, "outer_speed_rpm": outer_rpm,
                "radial_load_y_n": 0, "radial_load_z_n": 0, "axial_load_n": 0
            },
            "spindle": { "balance_grade": 0 }
        }),
    )
}

/// From a frame that turns with the inner ring the outer one turns backwards, and every contact is the same: its penetration, slip, spin and
/// film. Only the centrifugal force knows the frame. Velocities of 100 m/s leave 1e-11 of slips of a tenth of that. The widths of contacts that
/// average waves follow the centrifugal load, so that heights of waves differ by 10⁻¹⁰ m, which small
/// loads feel.
#[test]
fn contacts_are_the_same_from_a_frame_that_turns() {
    let speed = 40_000.0;
    for (surfaces, share) in [(json!({}), 1.0), (waves(), 1e7)] {
        let pair = [(speed, 0.0), (0.0, -speed), (1.7 * speed, 0.7 * speed)];
        let models = pair.map(|(inner, outer)| model(&changed(weightless(inner, outer), surfaces.clone())));
        for seed in 1..=5 {
            let mut state = disturbed(&models[0], seed);
            // A spindle or a cage beside the axis would circle in the turning frame.
            let layout = models[0].mechanism().layout;
            let CageState { arc, arc_velocity, .. } = layout.cage(&state);
            layout.set_cage(&mut state, &CageState { arc, arc_velocity, ..CageState::default() });
            layout.set_spindle(&mut state, &SpindleState::default());
            let [one, others @ ..] = models.each_ref().map(|model| watched(model, 1.3e-4, &state).1);
            for other in &others {
                let pairs = one.inner.iter().zip(&other.inner).chain(one.outer.iter().zip(&other.outer));
                for (a, b) in pairs {
                    let size = a.normal.abs() + 1e-3;
                    assert!((a.normal - b.normal).abs() < 1e-9 * share * size, "{a:?} {b:?}");
                    for k in 0..3 {
                        assert!((a.force[k] - b.force[k]).abs() < 1e-8 * share * size, "{a:?} {b:?}");
                    }
                    assert!((a.slip.0 - b.slip.0).abs() < 1e-11 * share && (a.slip.1 - b.slip.1).abs() < 1e-11 * share);
                }
                for (a, b) in one.pocket.iter().zip(&other.pocket) {
                    assert!((a.normal - b.normal).abs() < 1e-9 * (a.normal.abs() + 1e-3));
                }
            }
        }
    }
}

/// Rings that turn together carry balls and cage along as one body: nothing slips, and the outer ring alone holds the balls, against
/// m r ω².
#[test]
fn rings_that_turn_together_carry_all_along() {
    let rpm = 20_000.0;
    let model = model(&changed(weightless(rpm, rpm), json!({ "terms": { "hydrodynamics": "off" } })));
    let m = model.mechanism();
    let start = start_state(&model).unwrap();
    let end = advance(&model, &start, (0.0, 2e-3), 1e-7, |_| {});
    let (speed, loads) = (rpm * TAU / 60.0, watched(&model, 2e-3, &end).1);
    for ball in 0..m.layout.balls {
        let radius = m.pitch_radius + m.layout.ball(&end, ball).radial;
        let centrifugal = m.ball_mass * radius * speed * speed;
        let outer = &loads.outer[ball];
        assert!((outer.normal / centrifugal - 1.0).abs() < 1e-6, "{} N for {centrifugal} N", outer.normal);
        // Of 20 m/s.
        assert!(outer.slip.0.abs() < 1e-6 && outer.slip.1.abs() < 1e-6, "{:?}", outer.slip);
        assert!(loads.inner[ball].normal <= 0.0);
        assert!(m.layout.ball(&end, ball).arc.abs() < 1e-9);
    }
}

fn metrics(scene: &Value, duration: f64) -> Metrics {
    let job = json!({ "kind": "simulation", "duration_s": duration, "scene": scene,
        "outputs": { "spectra": ["spindle.y.acceleration"] } });
    let job = parse_job(job.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(simulated)) = execute(&job, &Control::until(&|| false)) else { panic!("{scene}") };
    simulated.metrics
}

/// A 6205 with both rings turning: cage and passages within 0.3 % of rolling on the outer ring, since drag acts
/// on the orbit in space, and all lines are multiples of
/// Z·FTF, at which the balls pass the load.
#[test]
fn passages_follow_the_relative_speed() {
    for (inner, outer) in [(3000.0, -1000.0), (3000.0, 1000.0), (0.0, -3000.0), (-3000.0, 1000.0)] {
        let scene = json!({ "bearing": "6205", "gravity_m_s2": 0,
            "operation": { "speed_rpm": inner, "outer_speed_rpm": outer, "radial_load_y_n": 500 } });
        let found = metrics(&scene, 0.1);
        let scene = raceway::contract::scene_from_json(&scene.to_string()).unwrap();
        let ideal = ideal_frequencies(&scene.bearing, scene.operating_speeds());
        let at = &found.frequencies_hz;
        let rolling = ideal.ball_pass_outer;
        for (name, found, expected, size) in [
            ("shaft", at.shaft, ideal.shaft, ideal.shaft),
            ("cage", at.cage, ideal.cage, rolling / 9.0),
            ("outer ring", at.outer_ring.unwrap(), ideal.outer_ring, ideal.outer_ring),
            ("under the load", at.ball_pass.unwrap(), ideal.ball_pass, rolling),
            ("BPFO", at.ball_pass_outer, ideal.ball_pass_outer, rolling),
            ("BPFI", at.ball_pass_inner, ideal.ball_pass_inner, ideal.ball_pass_inner),
            // The mean of all balls: those without load slip.
            ("BSF", at.ball_spin, ideal.ball_spin, 10.0 * ideal.ball_spin),
        ] {
            assert!((found - expected).abs() <= 3e-3 * size, "{inner}, {outer}: {name} {found} for {expected} Hz");
        }
        let lines = found.lines.as_ref().unwrap();
        let passage = lines.iter().find(|line| line.label == "9·FTF").expect("a line at the passage");
        assert!((passage.frequency_hz / at.ball_pass.unwrap() - 1.0).abs() < 1e-3);
        for line in lines {
            let order = line.label.strip_suffix("·FTF").and_then(|order| order.parse::<u32>().ok());
            assert!(order.is_some_and(|order| order % 9 == 0), "{inner}, {outer}: {line:?}");
        }
    }
}

/// Waves of order 8 on the outer ring of nine balls move the spindle round at 8 (f_c − f_o) + f_c = f_o − BPFO. Those of order 10 do so at
/// −10 (f_c − f_o) + f_c = BPFO + f_o. The ring turns faster than the cage.
#[test]
fn waves_of_a_turning_outer_ring_have_its_sidebands() {
    for (order, side) in [(8, -1.0), (10, 1.0)] {
        let scene = json!({ "bearing": { "preset": "6205", "radial_clearance_um": -4 }, "gravity_m_s2": 0,
            "operation": { "speed_rpm": 0, "outer_speed_rpm": 3000 },
            "surfaces": { "outer": { "waviness": [{ "order": order, "amplitude_nm": 100 }] } } });
        let found = metrics(&scene, 0.5);
        let at = &found.frequencies_hz;
        let expected = at.ball_pass_outer + side * at.outer_ring.unwrap();
        let strongest = &found.lines.as_ref().unwrap()[0];
        assert!((strongest.frequency_hz / expected - 1.0).abs() < 1e-3, "{order}: {:?}, {at:?}", found.lines);
        assert_eq!(strongest.label, if side > 0.0 { "BPFO + f_o" } else { "BPFO − f_o" }, "{:?}", found.lines);
    }
}

/// Rings that turn against each other leave the cage at rest, and their balls turn in place.
#[test]
fn rings_against_each_other_leave_the_cage_at_rest() {
    let scene = |outer: f64| {
        json!({ "bearing": "6205", "gravity_m_s2": 0, "terms": { "drag": "off", "churning": "off" },
            "operation": { "speed_rpm": 3000, "outer_speed_rpm": outer, "radial_load_y_n": 500 } })
    };
    let alone = raceway::contract::scene_from_json(&scene(0.0).to_string()).unwrap();
    let ratio = raceway::physics::kinematics::ideal_orbit_ratio(&alone.bearing);
    let found = metrics(&scene(-3000.0 * ratio / (1.0 - ratio)), 0.05);
    let at = &found.frequencies_hz;
    // Of 33 Hz relative to the outer ring; contacts under load roll on other radii than free ones.
    assert!(at.cage.abs() < 2e-3 * at.outer_ring.unwrap(), "{} Hz", at.cage);
    assert!((at.ball_pass_inner / (9.0 * 50.0) - 1.0).abs() < 2e-3, "{at:?}");
    assert!((at.ball_pass_outer / (9.0 * at.outer_ring.unwrap()) - 1.0).abs() < 2e-3, "{at:?}");
}
