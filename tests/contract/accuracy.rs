//! Accuracy jobs: from the request to the plot.

use std::time::Instant;

use serde_json::{Value, json};

use crate::common::{Server, job, job_with, request};
use crate::server::{ServerSettings, start, start_with};

fn accuracy_with(fields: Value) -> Value {
    let mut job = job_with(fields);
    job["kind"] = json!("accuracy");
    job
}

#[test]
fn error_against_run_time_over_http() {
    let server = start();
    let path = server.submit(&accuracy_with(json!({ "labels": ["compare"], "repetitions": 2 })));
    let job = server.wait_for(&path, &["succeeded", "failed"]);
    assert_eq!(
        (&job["status"], &job["kind"], &job["reused"]),
        (&json!("succeeded"), &json!("accuracy"), &json!(false)),
        "{job}"
    );
    for (name, link) in [("accuracy", "accuracy"), ("work_precision_svg", "plots/work-precision.svg")] {
        assert_eq!(job["links"][name], format!("{path}/{link}"));
    }
    assert!(job["links"]["metrics"].is_null());
    let answer = server.get(&format!("{path}/accuracy"));
    assert_eq!((answer.status, answer.header("content-type")), (200, Some("application/json")));
    let answer = answer.json();
    for field in ["method", "relative_tolerance", "own_error_db"] {
        assert!(!answer["reference"][field].is_null(), "{field}: {}", answer["reference"]);
    }
    let points = answer["points"].as_array().expect("points");
    assert_eq!(points.len(), 4);
    for field in [
        "method",
        "relative_tolerance",
        "status",
        "wall_time_s",
        "trajectory_error",
        "level_error_db",
        "steps",
        "rejected_steps",
        "rhs_evaluations",
        "jacobian_evaluations",
        "factorizations",
    ] {
        assert!(points.iter().all(|point| !point[field].is_null()), "{field}");
    }
    assert_eq!((&answer["timing"]["repetitions"], &answer["timing"]["most_other_runs"]), (&json!(2), &json!(0)));
    assert_eq!(answer["compared"]["scene"], "608, 3000 r/min, no load");
    assert!(answer["recommended"].is_array());
    let plot = server.get(&format!("{path}/plots/work-precision.svg"));
    assert_eq!((plot.status, plot.header("content-type")), (200, Some("image/svg+xml")));
    assert!(plot.body.starts_with("<svg") && plot.body.contains("fine_abm"), "{plot:?}");
    let listed = server.get("/v1/jobs?kind=accuracy").json();
    assert_eq!(listed["jobs"].as_array().map(Vec::len), Some(1));
}

#[test]
fn each_kind_has_its_own_results() {
    let server = start();
    let accuracy = server.submit(&accuracy_with(json!({})));
    let simulation = server.submit(&job());
    for path in [&accuracy, &simulation] {
        assert_eq!(server.wait_for(path, &["succeeded", "failed"])["status"], "succeeded");
    }
    for below in [
        "metrics",
        "spectrum?channel=spindle.y.acceleration",
        "series?channel=cage.speed",
        "plots/spectrum.svg",
        "spectrum",
        "series",
        "spectrum?channel=cage.speed&max_frequency_hz=-1",
        "series?max_points=0",
    ] {
        let problem = server.get(&format!("{accuracy}/{below}")).problem(409);
        assert_eq!(problem["type"], "urn:raceway:problem:no-result", "{below}");
        assert!(problem["detail"].as_str().is_some_and(|detail| detail.contains("/accuracy")), "{problem}");
    }
    server.get(&format!("{simulation}/spectrum?max_frequency_hz=-1")).problem(400);
    server.get(&format!("{simulation}/series?channel=cage.speed&max_points=0")).problem(400);
    for below in ["accuracy", "plots/work-precision.svg"] {
        let problem = server.get(&format!("{simulation}/{below}")).problem(409);
        assert_eq!(problem["type"], "urn:raceway:problem:no-result", "{below}");
        assert!(problem["detail"].as_str().is_some_and(|detail| detail.contains("/metrics")), "{problem}");
    }
    let unknown = server.get(&format!("{accuracy}/plots/cat.svg")).problem(404);
    assert!(unknown["detail"].as_str().is_some_and(|detail| detail.contains("work-precision.svg")), "{unknown}");
    assert!(server.get(&format!("{accuracy}?include=metrics")).json()["metrics"].is_null());
    server.get("/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f/accuracy").problem(404);
    server.get(&format!("{accuracy}/accuracy?x=1")).problem(400);
    request(server.address(), "GET", &format!("{accuracy}/accuracy"), &[("Accept", "text/csv")], b"").problem(406);
    assert_eq!(request(server.address(), "DELETE", &accuracy, &[], b"").status, 204);
    server.get(&format!("{accuracy}/accuracy")).problem(404);
}

#[test]
fn an_accuracy_job_is_never_reused_and_waits_like_any_job() {
    let server = start();
    let first = server.submit(&accuracy_with(json!({})));
    server.wait_for(&first, &["succeeded"]);
    let headers = [("Content-Type", "application/json"), ("Prefer", "wait=30")];
    let body = accuracy_with(json!({})).to_string();
    let again = request(server.address(), "POST", "/v1/jobs", &headers, body.as_bytes());
    assert_eq!(again.status, 200, "{again:?}");
    let again = again.json();
    assert_eq!((&again["status"], &again["reused"]), (&json!("succeeded"), &json!(false)));
    assert!(again["metrics"].is_null());
}

#[test]
fn an_accuracy_job_takes_one_worker_and_its_result_can_be_waited_for() {
    let server = start_with(ServerSettings { workers: 2, ..ServerSettings::default() });
    let slow = |kind: &str| {
        let mut job = job_with(json!({ "labels": ["slow"] }));
        job["kind"] = json!(kind);
        server.submit(&job)
    };
    let running = slow("simulation");
    server.wait_for(&running, &["running"]);
    let study = slow("accuracy");
    let problem = server.get(&format!("{study}/accuracy"));
    assert_eq!(problem.header("retry-after"), Some("1"));
    assert_eq!(problem.problem(409)["type"], "urn:raceway:problem:result-not-ready");
    server.wait_for(&study, &["running"]);
    assert_eq!(server.get(&running).json()["status"], "running");
    let begin = Instant::now();
    assert_eq!(server.post(&format!("{study}/cancel"), &json!({})).status, 202);
    server.wait_for(&study, &["cancelled"]);
    assert!(begin.elapsed().as_secs_f64() < 0.5);
    assert_eq!(server.get(&format!("{study}/accuracy")).problem(409)["type"], "urn:raceway:problem:no-result");
}

#[test]
fn invalid_accuracy_jobs_are_refused_with_their_fields() {
    let server = start();
    for (fields, pointer) in [
        (json!({ "solver": { "method": "gear" } }), "/solver/method"),
        (json!({ "methods": ["gear", "newton"] }), "/methods/1"),
        (json!({ "relative_tolerances": [1] }), "/relative_tolerances/0"),
        (json!({ "repetitions": 100 }), "/repetitions"),
        (json!({ "repetitions": -1 }), "/repetitions"),
        (json!({ "duration_s": 1e-300 }), "/duration_s"),
        (json!({ "outputs": { "series": [] } }), "/outputs/series"),
    ] {
        let problem = server.post("/v1/jobs", &accuracy_with(fields)).problem(422);
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{problem}");
    }
    let problem = server.post("/v1/jobs", &job_with(json!({ "methods": ["gear"] }))).problem(422);
    assert_eq!(problem["errors"][0]["pointer"], "/methods");
    let resolved = server.post("/v1/scenes/resolve", &accuracy_with(json!({ "methods": ["gear"] })));
    assert_eq!(resolved.status, 200, "{resolved:?}");
    assert_eq!(resolved.json()["methods"], json!(["gear"]));
}

#[test]
fn an_accuracy_job_of_a_shaft_compares_numbers_of_modes() {
    let server = start();
    let bearing = |name: &str, at: f64| json!({ "name": name, "bearing": "6205", "at_mm": at });
    let mut job = json!({
        "kind": "accuracy", "mode_ranges": [0.5, 1], "reference_range": 1.5,
        "settle_s": 0.002, "duration_s": 0.004, "step_us": 5.5,
        "scene": {
            "shaft": { "sections": [{ "length_mm": 200, "outer_diameter_mm": 25 }] },
            "bearings": [bearing("A", 40.0), bearing("B", 160.0)],
            "operation": { "speed_rpm": 6000, "radial_load_y_n": 300 },
        },
    });
    let path = server.submit(&job);
    let ended = server.wait_for(&path, &["succeeded", "failed"]);
    assert_eq!((&ended["status"], &ended["kind"]), (&json!("succeeded"), &json!("accuracy")), "{ended}");
    let answer = server.get(&format!("{path}/accuracy")).json();
    let points = answer["points"].as_array().expect("points");
    assert_eq!(points.len(), 2);
    for field in ["coordinates", "wall_time_s", "steps", "evaluations", "level_error_db", "mode_error_db"] {
        assert!(points.iter().all(|point| point[field].is_number()), "{field}: {answer}");
    }
    assert_eq!(answer["timing"]["most_other_runs"], 0);
    let plot = server.get(&format!("{path}/plots/work-precision.svg"));
    assert_eq!((plot.status, plot.header("content-type")), (200, Some("image/svg+xml")));
    job["mode_ranges"] = json!([2]);
    let problem = server.post("/v1/jobs", &job).problem(422);
    assert_eq!(problem["errors"][0]["pointer"], "/mode_ranges/0", "{problem}");
    server.post("/v1/scenes/resolve", &job).problem(422);
}
