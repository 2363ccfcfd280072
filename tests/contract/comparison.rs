//! `POST /v1/jobs/{id}/comparison`: a measured record beside a prediction.

use serde_json::{Value, json};

use crate::common::{Server, job_with, request};
use crate::server::{InProcess, ServerSettings, start, start_with};

const CHANNEL: &str = "spindle.y.acceleration";

/// A finished run that kept a series, and this series after an upload with a factor.
fn finished(server: &InProcess, factor: f64) -> (String, String) {
    let path =
        server.submit(&job_with(json!({ "outputs": { "series": [CHANNEL], "bands_hz": [3000, 10_000, 20_000] } })));
    server.wait_for(&path, &["succeeded"]);
    let series = server.get(&format!("{path}/series?channel={CHANNEL}")).json();
    let values: Vec<f64> = series["value"]
        .as_array()
        .expect("values")
        .iter()
        .filter_map(Value::as_f64)
        .map(|value| factor * value)
        .collect();
    let stored = server.post("/v1/series", &json!({ "rate_hz": 102_400, "values": values })).json();
    (path, stored["hash"].as_str().expect("a hash").to_owned())
}

fn compared(server: &InProcess, path: &str, hash: &str, more: &Value) -> Value {
    let mut request = json!({ "series": hash, "unit": "m/s2", "speed_rpm": 3000, "bands_hz": [3000, 10_000] });
    request.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
    let answer = server.post(&format!("{path}/comparison"), &request);
    assert_eq!(answer.status, 200, "{answer:?}");
    answer.json()
}

fn ratios(answer: &Value) -> Vec<f64> {
    let all = [&answer["levels"], &answer["lines"], &answer["envelope"]["lines"]];
    let ratios = all.into_iter().filter_map(Value::as_array).flatten();
    ratios.map(|one| one["level_ratio_db"].as_f64().expect("a ratio")).collect()
}

#[test]
fn the_series_of_a_run_differs_by_nothing_from_it() {
    let server = start();
    let (path, hash) = finished(&server, 1.0);
    let answer = compared(&server, &path, &hash, &json!({}));
    let found = ratios(&answer);
    assert!(found.len() >= 3 && found.iter().all(|ratio| ratio.abs() < 1e-3), "{answer}");
    assert_eq!((&answer["channel"], &answer["unit"]), (&json!(CHANNEL), &json!("m/s²")));
    for line in answer["lines"].as_array().expect("lines") {
        assert!(line["order_difference_percent"].as_f64().expect("a number").abs() < 1e-3, "{line}");
    }
    assert!(answer["unmatched"]["predicted"].as_array().expect("lines").is_empty(), "{answer}");
    assert!(answer.get("gain").is_none() && answer.get("score").is_none(), "{answer}");
    // No job is made.
    assert_eq!(server.get("/v1/jobs").json()["jobs"].as_array().map(Vec::len), Some(1));
    let (path, hash) = finished(&server, 2.0);
    let found = ratios(&compared(&server, &path, &hash, &json!({})));
    assert!(found.iter().all(|ratio| (ratio - 6.0206).abs() < 0.01), "{found:?}");
    let answer = compared(&server, &path, &hash, &json!({ "gain": 0.5 }));
    assert!(ratios(&answer).iter().all(|ratio| ratio.abs() < 0.01), "{answer}");
    assert!((answer["gain"]["db"].as_f64().expect("a number") + 6.0206).abs() < 1e-3, "{answer}");
}

#[test]
fn wrong_comparisons_are_refused() {
    let server = start();
    let (path, hash) = finished(&server, 1.0);
    let path = format!("{path}/comparison");
    let pointers = |body: &Value| {
        let problem = server.post(&path, body).problem(422);
        let errors = problem["errors"].as_array().expect("errors").clone();
        errors.iter().map(|error| error["pointer"].as_str().unwrap_or_default().to_owned()).collect::<Vec<_>>()
    };
    let with = |more: Value| {
        let mut body = json!({ "series": hash, "unit": "m/s2", "speed_rpm": 3000 });
        body.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        body
    };
    assert_eq!(pointers(&json!({ "series": hash, "unit": "m/s2" })), ["/speed_rpm"]);
    assert_eq!(pointers(&with(json!({ "channel": "cage.speed" }))), ["/channel"]);
    assert_eq!(pointers(&with(json!({ "unit": "um" }))), ["/unit"]);
    assert_eq!(pointers(&with(json!({ "series": "0b".repeat(32) }))), ["/series"]);
    // Fields that need no record are refused before it is looked for.
    let unknown = "0b".repeat(32);
    assert_eq!(pointers(&with(json!({ "series": unknown, "channel": "cage.speed" }))), ["/channel"]);
    assert_eq!(pointers(&with(json!({ "series": unknown, "unit": "um" }))), ["/unit"]);
    assert_eq!(pointers(&with(json!({ "series": unknown, "bands_hz": [300, 50] }))), ["/bands_hz/1"]);
    assert_eq!(
        pointers(&with(json!({ "speed_rpm": 0, "gain": 0, "bands_hz": [5] }))),
        ["/speed_rpm", "/gain", "/bands_hz"]
    );
    assert_eq!(pointers(&with(json!({ "windows": 3 }))), ["/windows"]);
    let short = server.post("/v1/series", &json!({ "rate_hz": 102_400, "values": vec![0.0; 20] })).json();
    assert_eq!(pointers(&with(json!({ "series": short["hash"] }))), ["/series"]);
    server.post("/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f/comparison", &with(json!({}))).problem(404);
    request(server.address(), "POST", &path, &[("Content-Type", "text/csv")], b"1").problem(415);
    let run_up = json!([{ "at_s": 0, "rpm": 3000 }, { "at_s": 1, "rpm": 6000 }]);
    let run_up = server.submit(&json!({
        "kind": "simulation", "scene": { "bearing": "6205", "operation": { "speed_rpm": run_up, "radial_load_y_n": 500 } }
    }));
    server.wait_for(&run_up, &["succeeded"]);
    let problem = server.post(&format!("{run_up}/comparison"), &with(json!({}))).problem(422);
    assert!(problem["errors"][0]["detail"].as_str().is_some_and(|detail| detail.contains("speed varies")), "{problem}");
}

#[test]
fn unfinished_jobs_and_other_kinds_have_no_comparison() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let body = json!({ "series": "0b".repeat(32), "unit": "g", "speed_rpm": 3000 });
    let slow = server.submit(&job_with(json!({ "labels": ["slow"] })));
    let problem = server.post(&format!("{slow}/comparison"), &body).problem(409);
    assert!(problem["type"].as_str().is_some_and(|kind| kind.ends_with("result-not-ready")), "{problem}");
    server.post(&format!("{slow}/cancel"), &json!({}));
    server.wait_for(&slow, &["cancelled"]);
    server.post(&format!("{slow}/comparison"), &body).problem(409);
}
