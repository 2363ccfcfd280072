//! `POST /v1/jobs`, `GET` and `DELETE /v1/jobs/{id}`.

use std::time::{Duration, Instant};

use serde_json::json;

use crate::common::{Server, job, job_with, request};
use crate::server::{ServerSettings, on_postgres, start, start_with};

#[test]
fn a_job_is_accepted_run_and_shown() {
    let server = start();
    let answer = server.post("/v1/jobs", &job_with(json!({ "labels": ["line 3"], "priority": 3 })));
    assert_eq!(answer.status, 202, "{answer:?}");
    let accepted = answer.json();
    assert_eq!(accepted["status"], "queued");
    assert_eq!(answer.header("retry-after"), Some("1"));
    let path = answer.header("location").expect("a location").to_owned();
    assert_eq!(path, format!("/v1/jobs/{}", accepted["id"].as_str().expect("an id")));
    let done = server.wait_for(&path, &["succeeded"]);
    assert_eq!(done["progress"], 1.0);
    assert_eq!(done["labels"], json!(["line 3"]));
    assert_eq!(done["priority"], 3);
    assert_eq!(done["created_at"], accepted["created_at"]);
    assert_eq!(done["request"]["scene"]["bearing"], "608");
    assert!(done["error"].is_null() && done["metrics"].is_null() && done["cancel_requested_at"].is_null());
    let times = ["created_at", "started_at", "finished_at", "expires_at"].map(|field| done[field].to_string());
    assert!(times.is_sorted(), "{times:?}");
    let with_metrics = server.get(&format!("{path}?include=metrics")).json();
    assert!(with_metrics["metrics"]["solver"]["steps"].as_u64() > Some(0));
}

#[test]
fn failures_state_their_cause_and_do_not_affect_other_jobs() {
    let server = start();
    let failing = server.submit(&job_with(json!({ "labels": ["fail"] })));
    let panicking = server.submit(&job_with(json!({ "labels": ["panic"] })));
    let good = server.submit(&job());
    let failed = server.wait_for(&failing, &["failed"]);
    assert_eq!(failed["error"]["type"], "urn:raceway:problem:did-not-converge");
    assert_eq!(failed["error"]["detail"], "intended by the test");
    let broken = server.wait_for(&panicking, &["failed"]);
    assert_eq!(broken["error"]["type"], "urn:raceway:problem:internal");
    assert!(!broken.to_string().contains("intended by the test"), "causes are logged, not sent");
    server.wait_for(&good, &["succeeded"]);
    let no_result = server.get(&format!("{failing}/metrics")).problem(409);
    assert_eq!(no_result["type"], "urn:raceway:problem:no-result");
}

#[test]
fn a_run_ends_at_its_time_limit() {
    let server = start_with(ServerSettings { time_limit: Duration::from_millis(100), ..ServerSettings::default() });
    let path = server.submit(&job_with(json!({ "labels": ["slow"] })));
    let failed = server.wait_for(&path, &["failed"]);
    assert_eq!(failed["error"]["type"], "urn:raceway:problem:time-limit");
}

#[test]
fn progress_is_shown_while_the_job_runs() {
    let server = start();
    let path = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&path, &["running"]);
    let begin = Instant::now();
    while server.get(&path).json()["progress"] != 0.25 {
        assert!(begin.elapsed() < Duration::from_secs(5));
    }
    let early = server.get(&format!("{path}/metrics"));
    assert_eq!(early.problem(409)["type"], "urn:raceway:problem:result-not-ready");
    assert_eq!(early.header("retry-after"), Some("1"));
}

#[test]
fn a_full_queue_refuses_and_recovers() {
    let server = start_with(ServerSettings { workers: 1, queue_limit: 3, ..ServerSettings::default() });
    let slow = job_with(json!({ "labels": ["slow"] }));
    let running = server.submit(&slow);
    server.wait_for(&running, &["running"]);
    let waiting = [server.submit(&slow), server.submit(&slow)];
    let refused = server.post("/v1/jobs", &slow);
    assert_eq!(refused.problem(429)["type"], "urn:raceway:problem:queue-full");
    assert!(refused.header("retry-after").is_some());
    server.post(&format!("{}/cancel", waiting[0]), &json!({}));
    server.submit(&slow);
}

#[test]
fn a_full_disk_refuses_and_recovers_and_loses_nothing() {
    // SQLite can simulate the size of a disk; the disk of a server is filled by a check outside these tests.
    if on_postgres() {
        return;
    }
    let server = start_with(ServerSettings { workers: 1, max_pages: Some(200), ..ServerSettings::default() });
    let large = |first: &str| {
        let labels: Vec<String> = std::iter::once(first.to_owned()).chain((0..15).map(|_| "x".repeat(200))).collect();
        job_with(json!({ "labels": labels }))
    };
    let ended: Vec<String> = (0..10).map(|_| server.submit(&large("fail"))).collect();
    ended.iter().for_each(|path| drop(server.wait_for(path, &["failed"])));
    let running = server.submit(&large("slow"));
    server.wait_for(&running, &["running"]);
    let mut accepted = Vec::new();
    let refused = loop {
        let answer = server.post("/v1/jobs", &large("fail"));
        match answer.status {
            202 => accepted.push(answer.header("location").expect("a location").to_owned()),
            _ => break answer,
        }
    };
    assert_eq!(refused.problem(507)["type"], "urn:raceway:problem:disk-full");
    server.get("/health/ready").problem(503);
    accepted.iter().for_each(|path| assert_eq!(server.get(path).json()["status"], "queued"));
    for path in &ended {
        assert_eq!(request(server.address(), "DELETE", path, &[], b"").status, 204);
    }
    let begin = Instant::now();
    while server.get("/health/ready").status != 200 {
        assert!(begin.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(20));
    }
    server.post(&format!("{running}/cancel"), &json!({}));
    accepted.iter().for_each(|path| drop(server.wait_for(path, &["failed"])));
    server.submit(&large("fail"));
}

#[test]
fn identical_finished_work_is_reused_unless_disabled() {
    let server = start();
    let first = server.submit(&job());
    assert_eq!(server.wait_for(&first, &["succeeded"])["reused"], false);
    let again = server.post("/v1/jobs", &job_with(json!({ "labels": ["again"] })));
    assert_eq!(again.status, 202);
    let again = again.json();
    assert_eq!((&again["status"], &again["reused"]), (&json!("succeeded"), &json!(true)));
    let path = again["links"]["self"].as_str().expect("a path").to_owned();
    let metrics = |path: &str| server.get(&format!("{path}/metrics")).body;
    assert_eq!(metrics(&path), metrics(&first));
    let afresh = server.submit(&job_with(json!({ "reuse": false })));
    assert_eq!(server.wait_for(&afresh, &["succeeded"])["reused"], false);
    // The result is kept as long as a job refers to it.
    assert_eq!(request(server.address(), "DELETE", &first, &[], b"").status, 204);
    assert_eq!(server.get(&format!("{path}/metrics")).status, 200);
}

#[test]
fn an_answer_may_wait_for_the_end() {
    let server = start();
    let post = |wait: &str, job: serde_json::Value| {
        let headers = [("Content-Type", "application/json"), ("Prefer", wait)];
        request(server.address(), "POST", "/v1/jobs", &headers, job.to_string().as_bytes())
    };
    let done = post("respond-async, wait=30", job());
    assert_eq!(done.status, 200, "{done:?}");
    assert_eq!(done.header("preference-applied"), Some("wait=30"));
    assert!(done.json()["metrics"]["solver"].is_object());
    let not_yet = post("wait=1", job_with(json!({ "labels": ["slow"], "reuse": false })));
    assert_eq!(not_yet.status, 202);
    assert_eq!(not_yet.json()["status"], "running");
    post("wait=soon", job()).problem(400);
}

#[test]
fn a_deleted_job_is_removed_with_its_result() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    let delete = || request(server.address(), "DELETE", &path, &[], b"");
    assert_eq!((delete().status, delete().status), (204, 404));
    server.get(&path).problem(404);
    server.get(&format!("{path}/metrics")).problem(404);
    let slow = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&slow, &["running"]);
    request(server.address(), "DELETE", &slow, &[], b"").problem(409);
}

#[test]
fn a_job_is_removed_when_it_expires() {
    let server = start();
    let path = server.submit(&job_with(json!({ "keep_for_s": 1 })));
    server.wait_for(&path, &["succeeded"]);
    let begin = Instant::now();
    while server.get(&path).status != 410 {
        assert!(begin.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(50));
    }
    let id = path.rsplit('/').next().expect("an id");
    for of_job in ["", "/metrics", "/events", "/table"] {
        let problem = server.get(&format!("{path}{of_job}")).problem(410);
        assert_eq!(problem["type"], "urn:raceway:problem:job-expired", "{of_job}");
        assert_eq!((&problem["job"]["id"], &problem["job"]["status"]), (&json!(id), &json!("succeeded")));
    }
    request(server.address(), "DELETE", &path, &[], b"").problem(410);
}
