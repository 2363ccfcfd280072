//! The scenes on which models are compared: the article's bearing with other clearances, loads, speeds, balls and spindles.

use raceway::contract::scene_from_json;
use raceway::simulation::input::scene::Scene;
use serde_json::{Value, json};

/// r/min, N, P_d [µm], balls, spindle [g], balance grade [mm/s].
pub const SCENES: [(f64, f64, f64, u32, f64, f64); 18] = [
    (50_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 7, 50.0, 6.3),
    (50_000.0, 200.0, 2.0, 7, 50.0, 0.0),
    (50_000.0, 200.0, 10.0, 7, 50.0, 0.0),
    (50_000.0, 50.0, 5.0, 7, 50.0, 0.0),
    (50_000.0, 400.0, 5.0, 7, 50.0, 0.0),
    (30_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (10_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (60_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 6, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 8, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 9, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 7, 100.0, 0.0),
    (20_000.0, 100.0, 8.0, 8, 70.0, 2.5),
    (40_000.0, 300.0, 3.0, 9, 80.0, 6.3),
    (60_000.0, 100.0, 4.0, 6, 60.0, 1.0),
    (10_000.0, 50.0, 3.0, 9, 100.0, 0.0),
    (30_000.0, 400.0, 10.0, 8, 50.0, 6.3),
];

/// One of them, and its JSON.
pub fn scene(number: usize) -> (Scene, String) {
    let (speed, load, clearance, balls, mass, grade) = SCENES[number];
    // Nine balls of this size need a larger circle.
    let pitch = if balls > 8 { 14.0 } else { 13.0 };
    let json: Value = json!({
        "bearing": {
            "preset": "article-integrated", "ball_count": balls, "radial_clearance_um": clearance,
            "pitch_diameter_mm": pitch, "outer_diameter_mm": pitch + 5.0, "inner_diameter_mm": pitch - 4.5
        },
        "spindle": if grade > 0.0 { json!({ "mass_kg": 1e-3 * mass, "balance_grade": grade }) } else { json!({ "mass_kg": 1e-3 * mass }) },
        "operation": { "speed_rpm": speed, "radial_load_y_n": load }
    });
    let text = json.to_string();
    (scene_from_json(&text).unwrap_or_else(|fault| panic!("{text}: {fault:?}")), text)
}
