//! Accuracy jobs of a shaft.

use raceway_core::simulation::input::control::Control;
use serde_json::{Value, json};

use crate::contract::{AccuracyJobAnswer, Job, JobKind, Outcome, Refusal, execute, parse_accuracy_request, parse_job};

fn scene() -> Value {
    let bearing =
        |name: &str, at: f64, faces: &str| json!({"name": name, "bearing": "6205", "at_mm": at, "faces": faces});
    json!({
        "shaft": {"sections": [{"length_mm": 200, "outer_diameter_mm": 25}]},
        "bearings": [bearing("A", 40.0, "+x"), bearing("B", 160.0, "-x")],
        "preloads": [{"between": ["A", "B"], "force_n": 200}],
        "sensors": [{"name": "probe", "at_mm": 100, "direction": "y"}],
        "operation": {"speed_rpm": 6000, "radial_load_y_n": 100}})
}

fn job(fields: Value) -> Value {
    let mut job = json!({"kind": "accuracy", "scene": scene()});
    job.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
    job
}

fn errors(fields: Value) -> Vec<(String, String)> {
    let Err(Refusal::Invalid { errors }) = parse_job(job(fields).to_string().as_bytes()) else { panic!("accepted") };
    errors.into_iter().map(|error| (error.pointer, error.detail)).collect()
}

#[test]
fn numbers_of_modes_are_compared_with_a_reference() {
    let request = job(json!({"mode_ranges": [1, 0.25], "reference_range": 1.5, "settle_s": 0.003, "duration_s": 0.005,
        "step_us": 5.5, "repetitions": 2}));
    let parsed = parse_job(request.to_string().as_bytes()).unwrap();
    assert_eq!(parsed.kind(), JobKind::Accuracy);
    let Ok(Outcome::Modes(answer)) = execute(&parsed, &Control::until(&|| false)) else { panic!("the run failed") };
    let text = serde_json::to_string(&answer).unwrap();
    let answer: Value = serde_json::from_str(&text).unwrap();
    let points = answer["points"].as_array().unwrap();
    assert_eq!(points.iter().map(|point| point["mode_range"].as_f64().unwrap()).collect::<Vec<_>>(), [1.0, 0.25]);
    for point in points {
        assert_eq!(point["status"], "succeeded", "{point}");
        assert_eq!(
            point["level_errors_db"].as_object().unwrap().len(),
            answer["reference"]["levels_db"].as_object().unwrap().len()
        );
        assert!(point["coordinates"].as_u64() < answer["reference"]["coordinates"].as_u64());
        assert!(point["mode_error_db"].is_number() && point["steps"].as_u64() > Some(1000));
    }
    assert!(points[0]["level_errors_db"]["sensor.probe.acceleration"].is_number());
    assert_eq!((&answer["compared"]["step_us"], &answer["reference"]["step_us"]), (&json!(5.5), &json!(2.75)));
    assert_eq!(answer["compared"]["scene"], "shaft on A, B, 6000 r/min");
    let again = parse_job(answer["repeat"]["job"].to_string().as_bytes()).unwrap();
    assert_eq!(again.canonical(), parsed.canonical());
    let read: AccuracyJobAnswer = serde_json::from_str(&text).unwrap();
    let AccuracyJobAnswer::Modes(read) = read else { panic!("another result was read") };
    let svg = crate::plots::draw::mode_precision(&read);
    assert!(svg.starts_with("<svg"), "{svg}");
    for text in ["probe", "highest kept modes over 20 kHz", "0.25"] {
        assert!(svg.contains(text), "{text}");
    }
}

#[test]
fn defaults_of_a_shaft_are_shown() {
    let Ok(Job::Modes(comparison)) = parse_accuracy_request(scene().to_string().as_bytes(), Some(3)) else {
        panic!("a scene alone is an accuracy job")
    };
    let job = comparison.complete();
    assert_eq!(job["mode_ranges"], json!([1.0, 1.5, 2.0]));
    assert_eq!(
        (&job["reference_range"], &job["duration_s"], &job["repetitions"]),
        (&json!(5.0), &json!(0.1), &json!(3))
    );
    assert!(job["settle_s"].is_null() && job["step_us"].is_null(), "{job}");
}

#[test]
fn impossible_accuracy_jobs_of_a_shaft_are_refused() {
    for (fields, pointer, detail) in [
        (json!({"mode_ranges": []}), "/mode_ranges", "0 ranges: must be from 1 to 12"),
        (json!({"mode_ranges": [1, 9]}), "/mode_ranges/1", "must be from 0.1 to 5"),
        (json!({"mode_ranges": [1, 1]}), "/mode_ranges/1", "given more than once"),
        (json!({"mode_ranges": [1, 3], "reference_range": 2}), "/mode_ranges/1", "3: must be below reference_range, 2"),
        (json!({"reference_range": 7}), "/reference_range", "must be from 0.1 to 5"),
        (json!({"step_us": 100}), "/step_us", "must be from 0.1 to 20 µs"),
        (json!({"repetitions": 10}), "/repetitions", "from 1 to 9"),
        (json!({"duration_s": 0}), "/duration_s", "must be from 0.001 to 60 s"),
        (json!({"reuse": true}), "/reuse", "never reused"),
        (json!({"methods": ["gear"]}), "/methods", "unknown field"),
    ] {
        let found = errors(fields.clone());
        assert!(found.iter().any(|(at, why)| at == pointer && why.contains(detail)), "{fields}: {found:?}");
    }
}
