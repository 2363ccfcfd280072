//! Loads of the operation: what is accepted, and each refusal with its pointer.

use serde_json::{Value, json};

use super::requests::operation;
use crate::contract::answer::resolve::resolve_answer;
use crate::contract::{Refusal, parse_job};

fn body(loads: &Value, spindle: &Value) -> String {
    json!({
        "kind": "simulation",
        "scene": {
            "bearing": "article-integrated", "spindle": spindle,
            "operation": { "speed_rpm": 30000, "radial_load_y_n": 100, "loads": loads }
        }
    })
    .to_string()
}

fn errors(loads: Value) -> Vec<(String, String)> {
    match parse_job(body(&loads, &json!({ "axial": "fixed" })).as_bytes()) {
        Err(Refusal::Invalid { errors }) => errors.into_iter().map(|error| (error.pointer, error.detail)).collect(),
        other => panic!("{loads}: {:?}", other.map(|_| "a job")),
    }
}

#[test]
fn every_wrong_load_is_refused_at_its_field() {
    let shock = |fields: Value| json!([{ "direction": "y", "shock": fields }]);
    let harmonic = |fields: Value| json!([{ "direction": "y", "harmonic": fields }]);
    let cases = [
        (json!([{ "direction": "y" }]), "", "exactly one of"),
        (json!([{ "direction": "y", "constant_n": 1, "points": [{ "at_s": 0, "n": 1 }] }]), "", "2 given"),
        (json!([{ "constant_n": 1 }]), "/direction", "required"),
        (json!([{ "direction": "up", "constant_n": 1 }]), "/direction", "unknown variant"),
        (json!([{ "direction": "y", "constant_n": 2e7 }]), "/constant_n", "20000000 N: must be from -10000000"),
        (json!([{ "direction": "y", "constant_n_m": 2 }]), "/constant_n_m", "that of a force: give constant_n"),
        (json!([{ "direction": "x", "constant_n": 2 }]), "/direction", "axial direction is free"),
        (json!([{ "direction": "about_y", "constant_n_m": 2 }]), "/direction", "whose tilt is free"),
        (json!([{ "direction": "y", "points": [] }]), "/points", "0 points"),
        (json!([{ "direction": "y", "points": [{ "at_s": 0 }] }]), "/points/0/n", "required"),
        (
            json!([{ "direction": "y", "points": [{ "at_s": 1, "n": 1 }, { "at_s": 1, "n": 2 }] }]),
            "/points",
            "must rise by at least 1 ns",
        ),
        (harmonic(json!({ "amplitude_n": 3 })), "/harmonic", "either `frequency_hz` or `order`"),
        (harmonic(json!({ "order": 1 })), "/harmonic/amplitude_n", "required"),
        (harmonic(json!({ "amplitude_n": 3, "frequency_hz": 0 })), "/harmonic/frequency_hz", "0 Hz: must be above 0"),
        (harmonic(json!({ "amplitude_n": 3, "order": 500 })), "/harmonic/order", "250000 Hz at the largest speed"),
        (
            json!([{ "direction": "y", "rotating": { "amplitude_n": 3, "order": 1 } }]),
            "/direction",
            "leave the direction",
        ),
        (shock(json!({ "peak_n": 3, "at_s": -1, "duration_s": 0.1 })), "/shock/at_s", "-1 s: must be from 0"),
        (shock(json!({ "peak_n": 3, "at_s": 1, "duration_s": 0 })), "/shock/duration_s", "0 s: must be from 1e-6"),
        (shock(json!({ "peak_n": 3, "at_s": 1 })), "/shock/duration_s", "required"),
        (json!([{ "on": "shaft", "direction": "y", "constant_n": 1 }]), "/on", "has no `shaft`"),
        (json!([{ "at_mm": 3, "direction": "y", "constant_n": 1 }]), "/at_mm", "only a `shaft` has places"),
        (json!([{ "on": "housing", "direction": "y", "constant_n": 1 }]), "/on", "unknown variant"),
    ];
    for (loads, field, words) in cases {
        let found = errors(loads.clone());
        let pointer = format!("/scene/operation/loads/0{field}");
        assert!(matches!(&found[..], [(at, detail)] if *at == pointer && detail.contains(words)), "{loads}: {found:?}");
    }
    let many = vec![json!({ "direction": "y", "constant_n": 1 }); 33];
    assert_eq!(errors(json!(many)), [("/scene/operation/loads".to_owned(), "33 loads: at most 32".to_owned())]);
    let order_at_rest = operation(r#""speed_rpm":0,"loads":[{"rotating":{"amplitude_n":3,"order":1}}]"#);
    let Err(Refusal::Invalid { errors }) = parse_job(order_at_rest.as_bytes()) else { panic!("accepted") };
    assert_eq!(errors[0].pointer, "/scene/operation/loads/0/rotating/order");
}

/// A load along X frees the axial direction, as an axial load does, and `resolve` describes each load.
#[test]
fn loads_are_described() {
    let loads = json!([
        { "direction": "x", "constant_n": 20 },
        { "direction": "about_z", "harmonic": { "amplitude_n_m": 0.1, "order": 2 } },
        { "direction": "y", "shock": { "peak_n": -30, "at_s": 0.3, "duration_s": 0.001 } }
    ]);
    let job = parse_job(body(&loads, &json!({ "tilt": "free" })).as_bytes()).unwrap();
    let answer = resolve_answer(&job).unwrap();
    assert_eq!(answer.scene["spindle"]["axial"], "free");
    assert_eq!(answer.scene["operation"]["loads"][1]["harmonic"]["phase_deg"], 0.0);
    let [force, moment, shock] = &answer.derived.loads[..] else { panic!("{:?}", answer.derived.loads) };
    assert_eq!((force.kind.as_str(), force.at_start, force.largest_change), ("constant", 20.0, 0.0));
    assert_eq!(moment.unit, "N·m");
    assert!(moment.frequency_hz.is_some_and(|frequency| (frequency - 1000.0).abs() < 1e-9));
    assert_eq!((shock.largest_change, shock.end_s), (30.0, Some(0.301)));
    assert!(shock.longest_step_us.is_some_and(|step| (step - 200.0).abs() < 1e-9));
    // The default recorded time holds the shock and 0.1 s after it.
    assert!((answer.settle_s + answer.duration_s - 0.401).abs() < 1e-6, "{} {}", answer.settle_s, answer.duration_s);
    assert!(answer.warnings.is_empty(), "{:?}", answer.warnings);
}
