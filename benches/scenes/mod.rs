//! The scenes on which models are compared: the article's bearing with other clearances, loads, speeds, balls and spindles.

use raceway::contract::scene_from_json;
use raceway::simulation::scene::Scene;
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

/// What lies outside of those, by name: light, slow, dry, flooded, preloaded, axially loaded and rattling bearings.
pub fn extremes() -> Vec<(&'static str, Scene)> {
    let article = |name, bearing: Value, rest: Value| {
        let mut json = json!({
            "bearing": { "preset": "article-integrated" },
            "operation": { "speed_rpm": 50_000, "radial_load_y_n": 200 }
        });
        merge(&mut json["bearing"], bearing);
        merge(&mut json, rest);
        (name, json)
    };
    let operation = |speed: f64, load: f64| json!({ "operation": { "speed_rpm": speed, "radial_load_y_n": load } });
    let axial = |load: f64, axial: f64| json!({ "operation": { "speed_rpm": 50_000, "radial_load_y_n": load, "axial_load_n": axial } });
    let none = || json!({});
    let catalogue = |name, preset: &str, speed: f64, load: f64| {
        let json = json!({ "bearing": preset, "operation": { "speed_rpm": speed, "radial_load_y_n": load } });
        (name, json)
    };
    [
        article("5 N", none(), operation(50_000.0, 5.0)),
        article("20 N", none(), operation(50_000.0, 20.0)),
        article("1000 r/min", none(), operation(1000.0, 200.0)),
        article("3000 r/min, 50 N", none(), operation(3000.0, 50.0)),
        article("dry, Coulomb", none(), json!({ "lubricant": "dry" })),
        article("dry, Coulomb, film", json!({ "cage": { "film": "empirical-11" } }), json!({ "lubricant": "dry" })),
        article("oil", none(), json!({ "lubricant": "oil" })),
        article("oil, fill 0.5", none(), json!({ "lubricant": { "kind": "oil", "fill": 0.5 } })),
        article("Eyring oil", none(), json!({ "lubricant": { "kind": "oil", "traction": { "law": "eyring" } } })),
        article(
            "traction from 0.1 m/s",
            none(),
            json!({ "lubricant": { "traction": { "law": "four_parameter", "at_slip_m_s": 0.1 } } }),
        ),
        article("preload −3 µm", json!({ "radial_clearance_um": -3 }), none()),
        article(
            "preload, closed seats",
            json!({ "radial_clearance_um": -3, "cage": { "seat": "closed", "offset_mm": 0 } }),
            none(),
        ),
        article("axial 30 N", none(), axial(50.0, 30.0)),
        article("axial 100 N", none(), axial(20.0, 100.0)),
        article("no film", json!({ "cage": { "film": "none" } }), none()),
        article(
            "land",
            json!({ "cage": { "land": { "clearance_mm": 0.2, "diameter_mm": 14.6, "width_mm": 1 } } }),
            none(),
        ),
        catalogue("6205, 500 N, 1797 r/min", "6205", 1797.0, 500.0),
        catalogue("6205, 2000 N, 6000 r/min", "6205", 6000.0, 2000.0),
        catalogue("608, 50 N, 20 000 r/min", "608", 20_000.0, 50.0),
    ]
    .map(|(name, json)| {
        let text = json.to_string();
        (name, scene_from_json(&text).unwrap_or_else(|fault| panic!("{text}: {fault:?}")))
    })
    .into()
}

/// Sets fields of an object, objects within it field by field.
fn merge(into: &mut Value, changes: Value) {
    match (into, changes) {
        (Value::Object(fields), Value::Object(changes)) => {
            for (name, value) in changes {
                merge(fields.entry(name).or_insert(Value::Null), value);
            }
        }
        (into, value) => *into = value,
    }
}
