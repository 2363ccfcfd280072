//! The mirror image of a bearing in the plane of X and Y is a bearing, with φ → −φ. The load along Z, the speed and the tilt
//! about Y change their sign. So does the phase of the unbalance: it starts at +Y and turns in the other direction.

use raceway::physics::frames::Vector;
use raceway::simulation::model::Model;
use raceway::simulation::model::state::{BallAttitude, BallState, CageState, SpindleState};
use serde_json::{Value, json};

use crate::article_run::{patient, settings};
use crate::scenes::{
    article, axial_waves, changed, defects, disturbed, everything, model, model_on, rates, scene, turning_outer_ring,
    unequal, uneven_balls, waves,
};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::RunSettings;
use raceway::simulation::solve::run::simulate;

const TIME: f64 = 2.3e-4;

/// Mirror image of a force, displacement or velocity, as [x, y, z] or [x, r, t].
fn polar([x, y, z]: Vector) -> Vector {
    [x, y, -z]
}

/// Mirror image of a moment or angular velocity: the component normal to the mirror keeps its sign.
fn axial([x, y, z]: Vector) -> Vector {
    [-x, -y, z]
}

/// Mirror image of a state or of its rates: ball j becomes ball Z − j.
pub fn mirrored(model: &Model, y: &[f64]) -> Vec<f64> {
    let layout = model.mechanism().layout;
    let mut image = vec![0.0; y.len()];
    for ball in 0..layout.balls {
        let s = layout.ball(y, ball);
        let s = BallState { arc: -s.arc, arc_velocity: -s.arc_velocity, spin: axial(s.spin), ..s };
        let number = (layout.balls - ball) % layout.balls;
        layout.set_ball(&mut image, number, &s);
        let [first, x, y, z] = layout.attitude(y, ball).0;
        let [x, y, z] = axial([x, y, z]);
        let first = if layout.planar { -first } else { first };
        layout.set_attitude(&mut image, number, &BallAttitude([first, x, y, z]));
    }
    let s = layout.cage(y);
    let flipped = |[about_y, about_z]: [f64; 2]| [-about_y, about_z];
    let s = CageState {
        centre: polar(s.centre),
        arc: -s.arc,
        tilt: flipped(s.tilt),
        velocity: polar(s.velocity),
        arc_velocity: -s.arc_velocity,
        tilt_rate: flipped(s.tilt_rate),
    };
    layout.set_cage(&mut image, &s);
    let s = layout.spindle(y);
    let s = SpindleState {
        position: polar(s.position),
        velocity: polar(s.velocity),
        tilt: flipped(s.tilt),
        tilt_rate: flipped(s.tilt_rate),
    };
    layout.set_spindle(&mut image, &s);
    image
}

/// Mirror image of a scene.
pub fn mirrored_scene(mut json: Value) -> Value {
    let negate = |value: &mut Value| {
        if let Some(number) = value.as_f64() {
            *value = json!(-number);
        }
    };
    let operation = &mut json["operation"];
    for field in ["radial_load_z_n", "speed_rpm", "outer_speed_rpm"] {
        if operation.get(field).is_some() {
            negate(&mut operation[field]);
        }
    }
    for field in ["speed_rpm", "outer_speed_rpm"] {
        let points = operation.get_mut(field).and_then(Value::as_array_mut);
        points.into_iter().flatten().for_each(|point| negate(&mut point["rpm"]));
    }
    if operation.get("misalignment_mrad").is_some() {
        negate(&mut operation["misalignment_mrad"]["y"]);
    }
    for (list, field) in [("waviness", "phase_deg"), ("axial_waviness", "phase_deg"), ("defects", "azimuth_deg")] {
        for ring in ["inner", "outer"] {
            let items = json.pointer_mut(&format!("/surfaces/{ring}/{list}")).and_then(Value::as_array_mut);
            for item in items.into_iter().flatten() {
                if item.get(field).is_some() {
                    negate(&mut item[field]);
                }
            }
        }
    }
    // Ball and pocket j become Z − j.
    let count = json.pointer("/bearing/ball_count").and_then(Value::as_u64).unwrap_or(7);
    for item in json.pointer_mut("/surfaces/balls").and_then(Value::as_array_mut).into_iter().flatten() {
        item["ball"] = json!((count + 1 - item["ball"].as_u64().unwrap()) % count + 1);
        for (list, field) in [("waviness", "phase_deg"), ("defects", "longitude_deg")] {
            for part in item.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten() {
                if part.get(field).is_some() {
                    negate(&mut part[field]);
                }
            }
        }
    }
    if let Some(pockets) = json.pointer_mut("/bearing/cage/pocket_spacing_mrad").and_then(Value::as_array_mut) {
        pockets.iter_mut().for_each(negate);
        pockets[1..].reverse();
    }
    json
}

/// Largest difference of two vectors of rates. Each entry is relative to the size of its unit and to the largest acceleration
/// or velocity among the balls, of the cage or of the spindle.
pub fn difference(model: &Model, a: &[f64], b: &[f64]) -> f64 {
    let layout = model.mechanism().layout;
    let sizes = layout.sizes();
    let moves = |name: &str| ["velocity", "spin", "speed", "rate"].iter().any(|word| name.contains(word));
    let groups: Vec<(bool, &str)> = (0..a.len())
        .map(|entry| {
            let name = layout.name(entry);
            let body = ["ball", "cage", "spindle"].into_iter().find(|body| name.contains(body));
            (moves(&name), body.unwrap())
        })
        .collect();
    let size = |i: usize| a[i].abs().max(b[i].abs()) / sizes[i];
    let largest = |group| (0..a.len()).filter(|&i| groups[i] == group).map(size).fold(1e-300, f64::max);
    (0..a.len()).map(|i| (a[i] - b[i]).abs() / sizes[i] / largest(groups[i])).fold(0.0, f64::max)
}

/// Rounding error of the rates: penetrations of about 1 µm are differences of millimetres, so that forces have 12 digits, and
/// the sums run in another order.
const ROUNDING: f64 = 1e-11;

/// dy/dt of the mirrored state in the mirrored scene = mirrored dy/dt, to rounding.
#[test]
fn rates_of_the_mirror_image_are_the_mirror_image_of_the_rates() {
    let ramp = json!([{ "at_s": 0, "rpm": 30_000 }, { "at_s": 0.01, "rpm": 50_000 }]);
    let of = |change: Value| changed(everything(), change);
    for (name, json) in [
        ("article", article()),
        ("everything", everything()),
        ("free to tilt", of(json!({ "spindle": { "tilt": "free" } }))),
        ("misaligned", of(json!({ "operation": { "misalignment_mrad": { "y": 1.0, "z": -0.7 } } }))),
        (
            "angular contact, rising speed, drag",
            of(json!({
                "bearing": { "type": "angular_contact", "contact_angle_deg": 15 },
                "operation": { "speed_rpm": ramp },
                "terms": { "drag": "on", "churning": "on" }
            })),
        ),
        (
            "land-guided",
            of(
                json!({ "bearing": { "cage": { "land": { "clearance_mm": 0.1, "diameter_mm": 15, "width_mm": 0.5 } } } }),
            ),
        ),
        ("turning outer ring", of(turning_outer_ring())),
        (
            "land in a turning ring",
            changed(
                of(turning_outer_ring()),
                json!({
                    "bearing": { "cage": { "land": { "clearance_mm": 0.1, "diameter_mm": 15, "width_mm": 0.5 } } }
                }),
            ),
        ),
        ("defects of a turning ring", changed(of(turning_outer_ring()), defects(0.1))),
        ("waves", of(waves())),
        ("unequal balls", of(unequal())),
        ("defects", of(defects(0.1))),
        ("axial waves", of(axial_waves())),
        ("uneven balls", of(uneven_balls(5.0))),
        ("eight balls", of(json!({ "bearing": { "ball_count": 8 } }))),
    ] {
        let (model, image) = (model(&json), model(&mirrored_scene(json)));
        for seed in 1..=10 {
            let state = disturbed(&model, seed);
            let expected = mirrored(&model, &rates(&model, TIME, &state));
            let found = rates(&image, TIME, &mirrored(&model, &state));
            let off = difference(&model, &found, &expected);
            assert!(off < ROUNDING, "{name}, state {seed}: {off:e}");
        }
    }
}

/// The mirrored rates of planar models are equal, too.
#[test]
fn plane_motion_is_mirrored_too() {
    let json =
        changed(article(), json!({ "operation": { "radial_load_z_n": 70 }, "spindle": { "balance_grade": 6.3 } }));
    let model = model_on(&json, Some(ModelLevel::Planar));
    let image = model_on(&mirrored_scene(json), Some(ModelLevel::Planar));
    for seed in 1..=10 {
        let state = disturbed(&model, seed);
        let expected = mirrored(&model, &rates(&model, TIME, &state));
        let off = difference(&model, &rates(&image, TIME, &mirrored(&model, &state)), &expected);
        assert!(off < ROUNDING, "state {seed}: {off:e}");
    }
}

/// A load of opposite sign along Z is not a mirror image without the change of speed. So the tests above detect an ignored
/// speed.
#[test]
fn the_speed_alone_breaks_the_symmetry() {
    let json = changed(article(), json!({ "operation": { "radial_load_z_n": 70 } }));
    let model = model(&json);
    let image = self::model(&changed(json, json!({ "operation": { "radial_load_z_n": -70 } })));
    let state = disturbed(&model, 1);
    let expected = mirrored(&model, &rates(&model, 0.0, &state));
    assert!(difference(&model, &rates(&image, 0.0, &mirrored(&model, &state)), &expected) > 1e-2);
}

/// The opposite rotation mirrors the motion. The metrics are the same, the direction of whirl relative to the shaft included.
#[test]
fn metrics_do_not_depend_on_the_sense_of_rotation() {
    let run_at = |speed: f64| {
        let settings = RunSettings { settle: 2e-3, duration: 4e-3, ..settings() };
        let json = changed(article(), json!({ "operation": { "speed_rpm": speed } }));
        simulate(&scene(&json), &settings, &patient()).unwrap().summary.cage.unwrap()
    };
    let (forward, backward) = (run_at(50_000.0), run_at(-50_000.0));
    assert!((forward.speed / backward.speed - 1.0).abs() < 1e-9);
    let (ahead, mirrored) = (forward.whirl_ratio.unwrap(), backward.whirl_ratio.unwrap());
    assert!((ahead - mirrored).abs() < 1e-3 * ahead.abs(), "{ahead} {mirrored}");
}
