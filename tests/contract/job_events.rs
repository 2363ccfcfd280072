//! `GET /v1/jobs/{id}/events`.

use std::time::Duration;

use serde_json::{Value, json};

use crate::common::{Server, job, job_with, request};
use crate::server::start;

/// Events of an ended stream: name, id and data.
fn events(body: &str) -> Vec<(String, String, Value)> {
    let field = |event: &str, name: &str| {
        let line = event.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        line.unwrap_or_default().to_owned()
    };
    let of = |event: &str| {
        let data = serde_json::from_str(&field(event, "data")).expect("data is JSON");
        (field(event, "event"), field(event, "id"), data)
    };
    body.split("\n\n").filter(|event| event.contains("data:")).map(of).collect()
}

#[test]
fn an_ended_job_gets_its_last_event_at_once() {
    let server = start();
    let path = server.submit(&job());
    let done = server.wait_for(&path, &["succeeded"]);
    let answer = server.get(&format!("{path}/events"));
    assert_eq!((answer.status, answer.header("content-type")), (200, Some("text/event-stream")));
    assert!(answer.header("content-encoding").is_none());
    assert_eq!(answer.header("x-accel-buffering"), Some("no"));
    let [(name, _, data)] = &events(&answer.body)[..] else { panic!("{}", answer.body) };
    assert_eq!((name.as_str(), &data["id"], &data["status"]), ("succeeded", &done["id"], &json!("succeeded")));
    assert!(data["request"].is_null() && data["phase"] == "succeeded" && data["links"]["metrics"].is_string());
    server.get(&format!("{path}0/events")).problem(404);
    request(server.address(), "GET", &format!("{path}/events"), &[("Accept", "application/json")], b"").problem(406);
}

#[test]
fn a_stream_reports_progress_and_ends_with_the_job() {
    let server = start();
    let path = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&path, &["running"]);
    let (address, followed) = (server.address().to_owned(), format!("{path}/events"));
    let follow = |headers: Vec<(&'static str, String)>| {
        let (address, path) = (address.clone(), followed.clone());
        std::thread::spawn(move || {
            let headers: Vec<_> = headers.iter().map(|(name, value)| (*name, value.as_str())).collect();
            events(&request(&address, "GET", &path, &headers, b"").body)
        })
    };
    let first = follow(vec![]);
    std::thread::sleep(Duration::from_millis(300));
    server.post(&format!("{path}/cancel"), &json!({}));
    let first = first.join().expect("a stream");
    let names: Vec<&str> = first.iter().map(|event| event.0.as_str()).collect();
    assert!(names.len() >= 2 && names[0] == "progress" && names[names.len() - 1] == "cancelled", "{names:?}");
    let last = &first[first.len() - 1];
    assert_eq!(last.2["status"], "cancelled");
    let shown = first.iter().find(|event| event.2["progress"] == 0.25).expect("the progress of the run");
    assert_eq!(shown.2["status"], "running");
    // A client that has received the last event gets 204.
    let again = request(server.address(), "GET", &format!("{path}/events"), &[("Last-Event-ID", &last.1)], b"");
    assert_eq!((again.status, again.body.as_str()), (204, ""));
}

#[test]
fn a_received_event_is_not_repeated() {
    let server = start();
    let path = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&path, &["running"]);
    std::thread::sleep(Duration::from_millis(50));
    let address = server.address().to_owned();
    let followed = format!("{path}/events");
    let seen = std::thread::spawn(move || {
        events(&request(&address, "GET", &followed, &[("Last-Event-ID", "starting-250")], b"").body)
    });
    std::thread::sleep(Duration::from_millis(300));
    server.post(&format!("{path}/cancel"), &json!({}));
    let seen = seen.join().expect("a stream");
    assert!(seen.iter().all(|event| event.1 != "starting-250"), "{seen:?}");
    assert_eq!(seen[seen.len() - 1].0, "cancelled");
}
