//! `GET /metrics`: service metrics for Prometheus.

use std::time::{Duration, Instant};

use serde_json::json;

use crate::common::{Server, job_with, request};
use crate::server::{ServerSettings, start, start_with};

/// The value of the line that begins with this text.
fn value(text: &str, words: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix(words));
    line.and_then(|value| value.trim().parse().ok()).unwrap_or_else(|| panic!("no {words} in {text}"))
}

/// The text once it contains this line: a run is counted a moment after its end is written.
fn text_with(server: &impl Server, line: &str) -> String {
    let begin = Instant::now();
    loop {
        let text = server.get("/metrics").body;
        if text.lines().any(|there| there == line) {
            return text;
        }
        assert!(begin.elapsed() < Duration::from_secs(10), "no {line} in {text}");
    }
}

#[test]
fn service_metrics_follow_the_queue_and_its_runs() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let slow = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&slow, &["running"]);
    let waiting = server.submit(&job_with(json!({ "labels": ["slow"], "reuse": false })));
    text_with(&server, "raceway_claims_total 1");
    let answer = server.get("/metrics");
    assert_eq!(answer.status, 200, "{answer:?}");
    assert!(answer.header("content-type").is_some_and(|kind| kind.starts_with("application/openmetrics-text")));
    let text = &answer.body;
    assert_eq!((value(text, "raceway_jobs_waiting "), value(text, "raceway_jobs_running ")), (1.0, 1.0), "{text}");
    assert_eq!(value(text, "raceway_worker_slots "), 1.0, "{text}");
    assert!(value(text, "raceway_oldest_waiting_seconds ") >= 0.0 && text.ends_with("# EOF\n"), "{text}");
    for path in [&waiting, &slow] {
        server.post(&format!("{path}/cancel"), &json!({}));
        server.wait_for(path, &["cancelled"]);
    }
    let failing = server.submit(&job_with(json!({ "labels": ["fail"] })));
    server.wait_for(&failing, &["failed"]);
    text_with(&server, "raceway_runs_total{end=\"cancelled\"} 1");
    text_with(&server, "raceway_runs_total{end=\"failed\"} 1");
}

#[test]
fn times_of_runs_are_counted() {
    let server = start();
    let path = server.submit(&job_with(json!({ "reuse": false })));
    server.wait_for(&path, &["succeeded"]);
    let text = text_with(&server, "raceway_runs_total{end=\"succeeded\"} 1");
    assert_eq!(value(&text, "raceway_run_time_seconds_count "), 1.0, "{text}");
    assert_eq!(value(&text, "raceway_real_time_factor_count "), 1.0, "{text}");
    assert!(value(&text, "raceway_database_wait_seconds_count ") > 2.0, "{text}");
}

#[test]
fn service_metrics_need_a_token() {
    let server = start_with(ServerSettings { tokens: "mine", ..ServerSettings::default() });
    server.get("/metrics").problem(401);
    let headers = [("Authorization", "Bearer mine")];
    assert_eq!(request(server.address(), "GET", "/metrics", &headers, b"").status, 200);
}
