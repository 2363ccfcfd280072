//! Extreme scenes end within seconds, in finite numbers or in an error with its reason.

use std::time::{Duration, Instant};

use raceway::contract::scene_from_json;
use raceway::simulation::input::control::Control;
use raceway::simulation::model::failure::SimulationError;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::settings;
use crate::scenes::{article, changed, scene};

/// Longest wall time of a scene. On an idle machine it takes well under a second.
const PATIENCE: Duration = Duration::from_secs(30);

/// Simulates a settling time and records twice that time.
fn short_run(json: &Value, settle: f64) -> Result<RunResult, SimulationError> {
    let mut settings = settings();
    settings.settle = settle;
    settings.duration = 2.0 * settle;
    let begin = Instant::now();
    let stop = || begin.elapsed() > PATIENCE;
    simulate(&scene(json), &settings, &Control::until(&stop))
}

/// Runs 3 ms of the article's case with changes and checks every number of the result.
fn ends_finite(name: &str, changes: Value) -> RunResult {
    ends_finite_over(name, changes, 1e-3)
}

fn ends_finite_over(name: &str, changes: Value, settle: f64) -> RunResult {
    let result = short_run(&changed(article(), changes), settle).unwrap_or_else(|error| panic!("{name}: {error}"));
    let summary = &result.summary;
    assert_eq!(summary.channels.iter().filter(|(_, metrics)| !metrics.rms.is_finite()).count(), 0, "{name}");
    let text = format!("{summary:?} {:?}", result.spectra);
    assert!(!text.contains("NaN") && !text.contains("inf"), "{name}: {summary:?}");
    // In these scenes no contact of such a small bearing carries a kilonewton, and no spindle leaves its bearing.
    let contacts = summary.contacts.as_ref().unwrap();
    assert!(contacts.raceway.inner.max_load < 2000.0, "{name}: {contacts:?}");
    result
}

fn bearing(changes: Value) -> Value {
    json!({ "bearing": changes })
}

fn operation(changes: Value) -> Value {
    json!({ "operation": changes })
}

#[test]
fn without_load() {
    let still = changed(operation(json!({ "radial_load_y_n": 0 })), json!({ "gravity_m_s2": 0 }));
    let free = ends_finite("no load, no gravity", still);
    // In equilibrium without a disturbance the spindle stays in its place.
    assert!(free.summary.channels.iter().all(|(_, metrics)| metrics.rms < 1e-3));
    ends_finite("no load", operation(json!({ "radial_load_y_n": 0 })));
    ends_finite("heavy load", operation(json!({ "radial_load_y_n": 600 })));
}

#[test]
fn at_every_speed() {
    let standing = ends_finite("no speed", operation(json!({ "speed_rpm": 0 })));
    assert!(standing.summary.channels.iter().all(|(_, metrics)| metrics.rms < 1.0), "{:?}", standing.summary.channels);
    let nothing = json!({ "speed_rpm": 0, "radial_load_y_n": 0 });
    ends_finite("nothing at all", changed(operation(nothing), json!({ "gravity_m_s2": 0 })));
    ends_finite("backwards", operation(json!({ "speed_rpm": -50_000 })));
    ends_finite("slow", operation(json!({ "speed_rpm": 10 })));
    ends_finite("fast", operation(json!({ "speed_rpm": 150_000 })));
    let ramp = json!([{ "at_s": 0, "rpm": 0 }, { "at_s": 0.002, "rpm": 30_000 }, { "at_s": 0.0025, "rpm": 20_000 }]);
    ends_finite("ramp", operation(json!({ "speed_rpm": ramp })));
}

#[test]
fn at_every_clearance_and_curvature() {
    for um in [-2.0, 0.0, 13.0, 100.0] {
        ends_finite(&format!("clearance {um} µm"), bearing(json!({ "radial_clearance_um": um })));
    }
    for curvature in [0.501, 0.505, 0.6] {
        // The largest clearance with the smallest curvature.
        let both = json!({
            "inner_groove_curvature": curvature, "outer_groove_curvature": curvature, "radial_clearance_um": 2
        });
        ends_finite(&format!("curvature {curvature}"), bearing(both));
    }
}

#[test]
fn with_few_and_many_balls() {
    for balls in [3, 5, 12, 30] {
        let pitch = 13.0 * f64::from(balls.max(7)) / 7.0;
        let sizes = json!({
            "ball_count": balls, "pitch_diameter_mm": pitch, "outer_diameter_mm": pitch + 5.0,
            "inner_diameter_mm": pitch - 4.5
        });
        let speed = 50_000.0 * 13.0 / pitch;
        ends_finite(&format!("{balls} balls"), changed(bearing(sizes), operation(json!({ "speed_rpm": speed }))));
    }
}

#[test]
fn out_of_the_plane() {
    ends_finite("axial load", operation(json!({ "axial_load_n": 10 })));
    ends_finite("axial load alone", operation(json!({ "axial_load_n": 10, "radial_load_y_n": 0 })));
    ends_finite("misaligned", operation(json!({ "misalignment_mrad": { "y": 1, "z": 0 } })));
    ends_finite("held off centre", json!({ "spindle": { "axial": { "offset_um": 20 } } }));
    let angular = json!({ "type": "angular_contact", "contact_angle_deg": 15 });
    let loads = json!({ "axial_load_n": 30, "radial_load_y_n": 20 });
    ends_finite("angular contact", changed(bearing(angular), operation(loads)));
}

#[test]
fn with_every_cage() {
    let cage = |changes: Value| bearing(json!({ "cage": changes }));
    ends_finite("closed seat", cage(json!({ "seat": "closed" })));
    ends_finite("closed seat in the plane", cage(json!({ "seat": "closed", "offset_mm": 0 })));
    let off = ends_finite("no cage", json!({ "terms": { "cage": "off" } }));
    assert!(off.summary.cage.is_none());
    ends_finite("land-guided", cage(json!({ "land": { "clearance_mm": 0.1, "diameter_mm": 15, "width_mm": 0.5 } })));
    ends_finite("empirical film", cage(json!({ "film": "empirical-11" })));
    ends_finite("elastic bars", cage(json!({ "bar_stiffness_n_per_m": 1e5 })));
}

#[test]
fn with_every_lubricant_and_traction_law() {
    ends_finite("dry", json!({ "lubricant": "dry" }));
    ends_finite("oil", json!({ "lubricant": "oil", "terms": { "hydrodynamics": "on" } }));
    ends_finite("thick oil", json!({ "lubricant": { "kind": "oil", "viscosity_pa_s": 1, "fill": 1 } }));
    for (name, law) in [
        ("four parameters, sticking", json!({ "law": "four_parameter", "at_rest": 0.02 })),
        ("slide/roll", json!({ "law": "slide_roll", "a": -0.036, "b": 1.5, "c": 30, "d": 0.036 })),
        ("Coulomb", json!({ "law": "coulomb" })),
    ] {
        ends_finite(name, json!({ "lubricant": { "kind": "grease", "traction": law } }));
    }
    // Oil at a gigapascal is so stiff that an explicit method needs steps of 30 ns. A run of 0.3 ms is enough.
    let eyring = json!({ "lubricant": { "kind": "grease", "traction": { "law": "eyring" } } });
    ends_finite_over("Eyring", eyring, 1e-4);
}

/// A scene that cannot be built is refused with the name of the field, before a run.
#[test]
fn impossible_scenes_are_refused_by_name() {
    for (changes, field) in [
        (bearing(json!({ "ball_count": 30 })), "ball_count"),
        (bearing(json!({ "inner_groove_curvature": 0.5 })), "inner_groove_curvature"),
        (bearing(json!({ "radial_clearance_um": 2000 })), "radial_clearance"),
        (json!({ "operation": { "axial_load_n": 10 }, "spindle": { "axial": "fixed" } }), "axial"),
        (operation(json!({ "speed_rpm": 1e9 })), "speed_rpm"),
    ] {
        let refusal = scene_from_json(&changed(article(), changes).to_string()).unwrap_err();
        assert!(format!("{refusal:?}").contains(field), "{field}: {refusal:?}");
    }
}
