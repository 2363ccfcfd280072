//! Uncertainty jobs: from the request to the distributions, their table and their plot, and resumed after a cancellation.

use serde_json::{Value, json};

use crate::common::{Server, job, request};
use crate::server::{ServerSettings, start, start_with};

const RMS: &str = "/channels/spindle.y.velocity/rms";

/// The smallest job with an uncertain speed and mass.
fn uncertain(samples: u32) -> Value {
    let mut wish = job();
    wish["kind"] = json!("uncertainty");
    wish["samples"] = json!(samples);
    wish["metrics"] = json!([RMS]);
    wish["settle_s"] = json!(0.0);
    wish["duration_s"] = json!(0.001);
    wish["inputs"] = json!([
        { "path": "/operation/speed_rpm", "distribution": { "type": "uniform", "from": 3000, "to": 6000 } },
        { "path": "/spindle/mass_kg", "distribution": { "type": "tolerance", "nominal": 0.5, "plus": 0.1, "minus": 0.1 } },
    ]);
    wish
}

#[test]
fn an_uncertainty_job_over_http() {
    let server = start();
    let path = server.submit(&uncertain(16));
    let job = server.wait_for(&path, &["succeeded", "failed"]);
    assert_eq!(
        (&job["status"], &job["progress"], &job["kind"]),
        (&json!("succeeded"), &json!(1.0), &json!("uncertainty"))
    );
    for (name, place) in
        [("uncertainty", "uncertainty"), ("uncertainty_svg", "plots/uncertainty.svg"), ("table", "table")]
    {
        assert_eq!(job["links"][name], format!("{path}/{place}"));
    }
    assert!(
        job["links"]["trend_svg"].is_null() && job["links"]["metrics"].is_null() && job["links"]["resume"].is_null()
    );
    let answer = server.get(&format!("{path}/uncertainty")).json();
    assert_eq!((&answer["points"], &answer["ended"], &answer["failed"]), (&json!(17), &json!(17), &json!(0)));
    assert_eq!((&answer["samples"], &answer["design"], &answer["seed"]), (&json!(16), &json!("sobol"), &json!(1)));
    assert_eq!(answer["inputs"][1]["nominal"], 0.5);
    let of = &answer["metrics"][RMS];
    assert_eq!((&of["values"], of["percentiles"].as_array().map(Vec::len)), (&json!(16), Some(5)));
    assert!(of["mean"].as_f64() > Some(0.0) && of["nominal"].is_number(), "{of}");
    let table = server.get(&format!("{path}/table")).json();
    assert_eq!((&table["points"], &table["best"], &table["trends"]), (&json!(17), &json!({}), &json!({})));
    assert_eq!(table["rows"][0]["point"], json!({ "/operation/speed_rpm": 4500.0, "/spindle/mass_kg": 0.5 }));
    let csv = request(server.address(), "GET", &format!("{path}/table"), &[("Accept", "text/csv")], b"");
    assert_eq!(csv.body.lines().count(), 18);
    let plot = server.get(&format!("{path}/plots/uncertainty.svg"));
    assert_eq!((plot.status, plot.header("content-type")), (200, Some("image/svg+xml")));
    let problem = server.get(&format!("{path}/metrics")).problem(409);
    assert!(problem["detail"].as_str().is_some_and(|detail| detail.contains("/uncertainty")), "{problem}");
    server.get(&format!("{path}/plots/none.svg")).problem(404);
    assert_eq!(server.get("/v1/jobs?kind=uncertainty").json()["jobs"].as_array().map(Vec::len), Some(1));
    // Its points are reused.
    let again = server.submit(&uncertain(16));
    server.wait_for(&again, &["succeeded"]);
    assert_eq!(server.get(&format!("{again}/uncertainty")).json(), answer);
    assert_eq!(server.get(&format!("{again}/table")).json()["rows"][3]["reused"], true);
}

#[test]
fn a_cancelled_uncertainty_job_keeps_its_points_and_resumes() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let path = server.submit(&uncertain(1024));
    server.wait_for(&path, &["running"]);
    let single = server.submit(&job());
    server.wait_for(&single, &["succeeded"]);
    server.post(&format!("{path}/cancel"), &json!({}));
    server.wait_for(&path, &["cancelled"]);
    let partial = server.get(&format!("{path}/uncertainty")).json();
    assert_eq!(partial["points"], 1025);
    assert!(partial["ended"].as_u64() < Some(1025), "{}", partial["ended"]);
    assert_eq!(server.post(&format!("{path}/resume"), &json!({})).status, 202);
    server.wait_for(&path, &["running", "succeeded"]);
    server.post(&format!("{path}/cancel"), &json!({}));
    server.wait_for(&path, &["cancelled", "succeeded"]);
    assert!(server.get(&format!("{path}/uncertainty")).json()["ended"].as_u64() >= partial["ended"].as_u64());
}

#[test]
fn other_kinds_have_no_uncertainty() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    server.get(&format!("{path}/uncertainty")).problem(409);
    server.get(&format!("{path}/plots/uncertainty.svg")).problem(409);
    server.get("/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f/uncertainty").problem(404);
    let mut wrong = uncertain(100);
    assert_eq!(server.post("/v1/jobs", &wrong).problem(422)["errors"][0]["pointer"], "/samples");
    wrong["samples"] = json!(16);
    wrong["inputs"][0]["distribution"]["to"] = json!(2000);
    assert_eq!(server.post("/v1/jobs", &wrong).problem(422)["errors"][0]["pointer"], "/inputs/0/distribution/to");
}
