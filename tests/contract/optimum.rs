//! Optimum jobs: from the request to the answer and its plot.

use serde_json::{Value, json};

use crate::common::{Server, job};
use crate::server::start;

fn optimum() -> Value {
    let mut wish = job();
    wish["kind"] = json!("optimum");
    wish["axes"] = json!([{ "path": "/operation/speed_rpm", "from": 3000, "to": 6000 }]);
    wish["settle_s"] = json!(0.0);
    wish["duration_s"] = json!(0.001);
    wish["metric"] = json!("/channels/spindle.y.velocity/rms");
    wish
}

#[test]
fn an_optimum_over_http() {
    let server = start();
    let path = server.submit(&optimum());
    let job = server.wait_for(&path, &["succeeded", "failed"]);
    assert_eq!((&job["status"], &job["progress"], &job["kind"]), (&json!("succeeded"), &json!(1.0), &json!("optimum")));
    assert_eq!(job["links"]["optimum"], format!("{path}/optimum"));
    assert_eq!(job["links"]["optimum_svg"], format!("{path}/plots/optimum.svg"));
    assert!(job["links"]["metrics"].is_null() && job["links"]["table"].is_null());
    let answer = server.get(&format!("{path}/optimum")).json();
    let best = answer["point"]["/operation/speed_rpm"].as_f64().expect("a speed");
    assert!((3000.0..=6000.0).contains(&best), "{answer}");
    assert_eq!(answer["runs"].as_u64(), answer["evaluations"].as_array().map(|runs| runs.len() as u64));
    let plot = server.get(&format!("{path}/plots/optimum.svg"));
    assert_eq!((plot.status, plot.header("content-type")), (200, Some("image/svg+xml")));
    let problem = server.get(&format!("{path}/metrics")).problem(409);
    assert!(problem["detail"].as_str().is_some_and(|detail| detail.contains("/optimum")), "{problem}");
    let problem = server.get(&format!("{path}/plots/trend.svg")).problem(409);
    assert_eq!(problem["type"], "urn:raceway:problem:no-result");
    let again = server.submit(&optimum());
    assert_eq!(server.wait_for(&again, &["succeeded"])["reused"], true);
    assert_eq!(server.get("/v1/jobs?kind=optimum").json()["jobs"].as_array().map(Vec::len), Some(2));
}
