//! `POST /v1/jobs/{id}/cancel`.

use std::time::{Duration, Instant};

use serde_json::json;

use crate::common::{Answer, Server, job, job_with, request};
use crate::server::{InProcess, ServerSettings, start, start_with};

fn cancel(server: &InProcess, path: &str) -> Answer {
    request(server.address(), "POST", &format!("{path}/cancel"), &[], b"")
}

#[test]
fn a_waiting_job_is_cancelled_at_once() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let slow = job_with(json!({ "labels": ["slow"] }));
    let running = server.submit(&slow);
    server.wait_for(&running, &["running"]);
    let waiting = server.submit(&slow);
    let answer = cancel(&server, &waiting);
    assert_eq!((answer.status, &answer.json()["status"]), (200, &json!("cancelled")));
    assert!(answer.json()["cancel_requested_at"].is_string() && answer.json()["started_at"].is_null());
    assert_eq!(cancel(&server, &waiting).status, 200, "again changes nothing");
}

#[test]
fn a_running_job_is_cancelled_soon() {
    let server = start();
    let path = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&path, &["running"]);
    let begin = Instant::now();
    let answer = cancel(&server, &path);
    assert_eq!(answer.status, 202, "{answer:?}");
    assert!(answer.json()["cancel_requested_at"].is_string());
    let cancelled = server.wait_for(&path, &["cancelled"]);
    assert!(begin.elapsed() < Duration::from_millis(500), "{:?}", begin.elapsed());
    assert!(cancelled["finished_at"].is_string() && cancelled["error"].is_null());
    assert_eq!(server.get(&format!("{path}/metrics")).problem(409)["type"], "urn:raceway:problem:no-result");
}

#[test]
fn a_run_stops_even_if_its_cancellation_cannot_be_written() {
    let server = start();
    let path = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&path, &["running"]);
    server.sql(
        "CREATE TRIGGER refuse BEFORE UPDATE OF cancel_requested_at ON jobs BEGIN SELECT RAISE(ABORT, 'no'); END",
        "CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN RAISE 'no'; END $$; \
         CREATE TRIGGER refuse BEFORE UPDATE OF cancel_requested_at ON jobs FOR EACH ROW EXECUTE FUNCTION refuse()",
    );
    cancel(&server, &path).problem(500);
    server.wait_for(&path, &["cancelled"]);
}

#[test]
fn an_ended_job_is_not_cancelled() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    cancel(&server, &path).problem(409);
    let failed = server.submit(&job_with(json!({ "labels": ["fail"], "reuse": false })));
    server.wait_for(&failed, &["failed"]);
    cancel(&server, &failed).problem(409);
    cancel(&server, "/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f").problem(404);
}
