//! Load distribution of a bearing at rest. Published distributions are in `tests/verification`.

use std::f64::consts::TAU;

use raceway::simulation::model::equilibrium::{StaticLoads, static_loads};
use serde_json::{Value, json};

use crate::scenes::{article, changed, needs, scene};

fn at_rest(json: &Value) -> StaticLoads {
    let scene = scene(json);
    static_loads(&scene, &needs(&scene, None)).unwrap()
}

fn clearance(um: f64) -> Value {
    changed(article(), json!({ "bearing": { "radial_clearance_um": um }, "gravity_m_s2": 0 }))
}

/// The raceways carry the applied load: Σ Q cos φ = F, with φ the direction from the displaced spindle to the ball. To the share
/// of 1e-6 by which the displacement of the balls changes that direction.
#[test]
fn static_loads_balance_the_applied_load() {
    for um in [-2.0, 0.0, 5.0, 13.0] {
        let rest = at_rest(&clearance(um));
        let radius = 6.5e-3;
        let (mut along, mut across) = (0.0, 0.0);
        for (ball, load) in rest.ball_loads.iter().enumerate() {
            let (sine, cosine) = (TAU * ball as f64 / 7.0).sin_cos();
            let (y, z) = (radius * cosine - rest.radial_displacement, radius * sine);
            along += load * y / y.hypot(z);
            across += load * z / y.hypot(z);
        }
        assert!((along / 200.0 - 1.0).abs() < 1e-5 && across.abs() < 1e-9, "{um}: {along}, {across}");
    }
}

/// Grooves with a curvature close to that of the ball. A heavy load moves the balls opposite to it past the centres of their
/// grooves. A groove is an arc, and these balls carry no load.
#[test]
fn balls_opposite_the_load_carry_no_load() {
    let json = json!({
        "bearing": {
            "preset": "6205", "inner_groove_curvature": 0.5005, "outer_groove_curvature": 0.5005, "radial_clearance_um": 5
        },
        "operation": { "speed_rpm": 20_000, "radial_load_y_n": 14_000 }
    });
    let rest = at_rest(&json);
    let balls = rest.ball_loads.len();
    let mut along = 0.0;
    for (ball, load) in rest.ball_loads.iter().enumerate() {
        let cosine = (TAU * ball as f64 / balls as f64).cos();
        along += load * cosine;
        assert!(cosine > 0.0 || *load == 0.0, "{ball}: {load} N");
    }
    assert!((along / 14_000.0 - 1.0).abs() < 0.01, "{along}");
}

/// A load beyond the capacity of the geometry has no equilibrium. The balls still carry a tenth of it.
#[test]
fn a_load_that_presses_balls_into_their_raceways_has_no_equilibrium() {
    let under = |load: f64| {
        let scene = scene(&changed(article(), json!({ "operation": { "radial_load_y_n": load } })));
        static_loads(&scene, &needs(&scene, None)).map(|rest| rest.ball_loads.iter().sum::<f64>())
    };
    assert!(under(1e5).unwrap() > 1e5);
    let words = under(1e6).unwrap_err().to_string();
    assert!(words.contains("press a ball into its raceways by"), "{words}");
}
