//! A load over the balls of a bearing at rest. Published distributions are in `tests/verification`.

use std::f64::consts::TAU;

use raceway::simulation::equilibrium::{StaticLoads, static_loads};
use serde_json::{Value, json};

use crate::scenes::{article, changed, needs, scene};

fn at_rest(json: &Value) -> StaticLoads {
    let scene = scene(json);
    static_loads(&scene, &needs(&scene, None)).unwrap()
}

fn clearance(um: f64) -> Value {
    changed(article(), json!({ "bearing": { "radial_clearance_um": um } }))
}

/// The raceways carry what is applied: Σ Q cos φ = F with φ the direction from the displaced spindle to the ball.
/// To the share 1e-6 by which balls move off the pitch circle and change that direction.
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
