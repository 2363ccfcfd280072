//! Surfaces of the raceways: fields, defaults, refusals, and what `resolve` tells of them.

use serde_json::{Value, json};

use super::requests::scene;
use crate::contract::{Refusal, parse_job, parse_scene_request, resolve_answer};

fn wavy(surfaces: Value) -> String {
    scene(&format!(r#""surfaces":{surfaces}"#))
}

/// Each wrong number has its own pointer, unit and range.
#[test]
fn wrong_surfaces_are_refused() {
    let inner = |fields: Value| json!({ "inner": fields });
    let wave = |order: Value, amplitude: f64, phase: f64| {
        let good = json!({ "order": 8, "amplitude_nm": 10 });
        inner(json!({ "waviness": [good, { "order": order, "amplitude_nm": amplitude, "phase_deg": phase }] }))
    };
    let random = |fields: Value| inner(json!({ "random_waviness": fields }));
    let many = vec![json!({ "order": 8, "amplitude_nm": 10 }); 65];
    for (surfaces, pointer, words) in [
        (wave(json!(0), 1.0, 0.0), "inner/waviness/1/order", "0: must be from 1 to 100000"),
        (wave(json!(2.5), 1.0, 0.0), "inner/waviness/1/order", "2.5: must be a whole number from 1 to 100000"),
        (wave(json!(2), -1.0, 0.0), "inner/waviness/1/amplitude_nm", "-1 nm: must be from 0 to 100000 nm"),
        (wave(json!(2), 2e5, 0.0), "inner/waviness/1/amplitude_nm", "200000 nm: must be from 0 to 100000 nm"),
        (wave(json!(2), 1.0, 400.0), "inner/waviness/1/phase_deg", "400 °: must be from -360 to 360 °"),
        (inner(json!({ "waviness": [{ "order": 3 }] })), "inner/waviness/0/amplitude_nm", "required, but missing"),
        (inner(json!({ "waviness": many })), "inner/waviness", "65 waves: at most 64"),
        (random(json!({})), "inner/random_waviness/amplitude_nm", "required, but missing"),
        (
            random(json!({ "amplitude_nm": 1, "exponent": 5 })),
            "inner/random_waviness/exponent",
            "5: must be from 0 to 4",
        ),
        (
            random(json!({ "amplitude_nm": 1, "from_order": 0 })),
            "inner/random_waviness/from_order",
            "0: must be from 1",
        ),
        (
            random(json!({ "amplitude_nm": 1, "from_order": 9, "to_order": 8 })),
            "inner/random_waviness/to_order",
            "8 is below from_order, 9",
        ),
        (json!({ "seed": -1 }), "seed", "-1: must be a whole number from 0 to 9007199254740991"),
        (inner(json!({ "defects": [] })), "inner/defects", "not supported yet"),
        (inner(json!({ "axial_waviness": [] })), "inner/axial_waviness", "not supported yet"),
        (json!({ "balls": [] }), "balls", "not supported yet"),
        (json!({ "every_ball": {} }), "every_ball", "not supported yet"),
    ] {
        let body = wavy(surfaces);
        let Err(Refusal::Invalid { errors }) = parse_job(body.as_bytes()) else { panic!("{body}") };
        let pointer = format!("/scene/surfaces/{pointer}");
        let [error] = &errors[..] else { panic!("{body}: {errors:?}") };
        assert!(error.pointer == pointer && error.detail.contains(words), "{body}: {error:?}");
    }
}

/// The resolved scene names the defaults and is the same scene when sent again; without surfaces it has no such field.
#[test]
fn surfaces_have_defaults() {
    let body = wavy(json!({
        "inner": { "waviness": [{ "order": 8, "amplitude_nm": 10 }] },
        "outer": { "random_waviness": { "amplitude_nm": 5 } }
    }));
    let job = parse_job(body.as_bytes()).unwrap();
    let complete = job.scene_json();
    assert_eq!(
        complete["surfaces"],
        json!({
            "inner": { "waviness": [{ "order": 8, "amplitude_nm": 10.0, "phase_deg": 0.0 }] },
            "outer": { "random_waviness": { "amplitude_nm": 5.0, "at_order": 10, "exponent": 1.0, "from_order": 2 } },
            "seed": 1
        })
    );
    let again = json!({ "kind": "simulation", "scene": complete });
    assert_eq!(parse_job(again.to_string().as_bytes()).unwrap().scene_json(), complete);
    assert_eq!(parse_job(scene(r#""gravity_m_s2":9.81"#).as_bytes()).unwrap().scene_json().get("surfaces"), None);
}

/// Ten turns of the cage are recorded, and only the dynamics are tried.
#[test]
fn waves_take_ten_turns_of_the_cage_and_the_dynamics() {
    let of = |amplitude: f64| {
        let scene = json!({
            "bearing": "6205",
            "operation": { "speed_rpm": 600, "radial_load_y_n": 500 },
            "surfaces": { "outer": { "waviness": [
                { "order": 10, "amplitude_nm": amplitude },
                { "order": 90_000, "amplitude_nm": amplitude },
            ] } }
        });
        let request = json!({ "scene": scene }).to_string();
        serde_json::to_value(resolve_answer(&parse_scene_request(request.as_bytes()).unwrap())).unwrap()
    };
    let (wavy, ideal) = (of(10.0), of(0.0));
    let turns = wavy["duration_s"].as_f64().unwrap() * wavy["derived"]["frequencies_hz"]["cage"].as_f64().unwrap();
    assert!((turns - 10.0).abs() < 1e-3, "{turns}");
    assert!(ideal["duration_s"].as_f64().unwrap() < 1.01 && ideal["derived"].get("surfaces").is_none());
    assert_eq!(wavy["rungs"], json!(["full"]));
    let messages = wavy["messages"].to_string();
    assert!(messages.contains("scene.surfaces") && ideal["rungs"].as_array().unwrap().len() > 1, "{messages}");
    let outer = &wavy["derived"]["surfaces"]["outer"];
    assert_eq!(outer["left_out"], json!([{ "from_order": 90_000, "to_order": 90_000, "reason": "averaged" }]));
    assert!(outer["waves"][0]["averaging"].as_f64().unwrap() > 0.999 && outer["kept"] == 1, "{outer}");
}

/// A study varies each number of a surface.
#[test]
fn a_study_varies_waves() {
    for path in [
        "/surfaces/inner/waviness/0/amplitude_nm",
        "/surfaces/inner/waviness/0/order",
        "/surfaces/inner/waviness/0/phase_deg",
        "/surfaces/outer/random_waviness/exponent",
        "/surfaces/outer/random_waviness/to_order",
        "/surfaces/seed",
    ] {
        let request = json!({
            "kind": "study",
            "scene": {
                "bearing": "article-integrated",
                "operation": { "speed_rpm": 50000 },
                "surfaces": {
                    "inner": { "waviness": [{ "order": 8, "amplitude_nm": 10 }] },
                    "outer": { "random_waviness": { "amplitude_nm": 5 } }
                }
            },
            "axes": [{ "path": path, "values": [2, 3] }]
        });
        let study = parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{path}: {refusal}"));
        let point = study.into_study().unwrap().point(1).unwrap().scene_json();
        assert_eq!(point.pointer(path).and_then(Value::as_f64), Some(3.0), "{path}");
    }
}
