//! Access control.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::common::{Answer, Server, job, job_with, request};
use crate::server::{InProcess, ServerSettings, start, start_with};

fn get(server: &InProcess, path: &str, headers: &[(&str, &str)]) -> Answer {
    request(server.address(), "GET", path, headers, b"")
}

#[test]
fn without_tokens_only_local_hosts_are_answered() {
    let server = start();
    for host in ["localhost", "localhost:8080", "127.0.0.1", "[::1]:80"] {
        assert_eq!(get(&server, "/v1/jobs", &[("Host", host)]).status, 200, "{host}");
    }
    for host in ["example.org", "raceway.internal:8080", "127.0.0.1.example.org"] {
        get(&server, "/v1/jobs", &[("Host", host)]).problem(421);
        get(&server, "/health/ready", &[("Host", host)]).problem(421);
    }
}

#[test]
fn without_tokens_exactly_one_host_header_is_required() {
    let server = start();
    let mut stream = TcpStream::connect(server.address()).expect("the server listens");
    stream.write_all(b"GET /v1/jobs HTTP/1.1\r\nConnection: close\r\n\r\n").expect("a request is read");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer comes");
    assert!(answer.starts_with("HTTP/1.1 400 ") && answer.contains("urn:raceway:problem:bad-request"), "{answer}");
    get(&server, "/v1/jobs", &[("Host", "localhost"), ("Host", "example.org")]).problem(400);
}

#[test]
fn with_tokens_every_path_except_public_ones_needs_one() {
    let server = start_with(ServerSettings { tokens: "alpha, beta", ..ServerSettings::default() });
    for path in ["/health/live", "/health/ready", "/openapi.json", "/docs/", "/docs", "/"] {
        assert!(get(&server, path, &[]).status < 400, "{path}");
    }
    assert_eq!(get(&server, "/", &[("Host", "raceway.example.org")]).status, 200, "any host, as it has a name now");
    for path in ["/v1/jobs", "/v1/presets", "/nothing"] {
        let refused = get(&server, path, &[]);
        refused.problem(401);
        assert_eq!(refused.header("www-authenticate"), Some("Bearer"));
        for wrong in ["Bearer gamma", "Bearer", "Basic alpha", "alpha", "Bearer alpha,beta", "Bearer  "] {
            get(&server, path, &[("Authorization", wrong)]).problem(401);
        }
    }
    for right in ["Bearer alpha", "bearer beta"] {
        assert_eq!(get(&server, "/v1/presets", &[("Authorization", right)]).status, 200, "{right}");
    }
}

const A: (&str, &str) = ("Authorization", "Bearer alpha");
const B: (&str, &str) = ("Authorization", "Bearer beta");
const JSON: (&str, &str) = ("Content-Type", "application/json");

fn post(server: &InProcess, token: (&str, &str), more: &[(&str, &str)], job: &Value) -> Answer {
    let headers = [&[token, JSON], more].concat();
    request(server.address(), "POST", "/v1/jobs", &headers, job.to_string().as_bytes())
}

/// A job of owner A, once it has this status.
fn made(server: &InProcess, job: &Value, status: &str) -> String {
    let path = post(server, A, &[], job).header("location").expect("a location").to_owned();
    let begin = Instant::now();
    while get(server, &path, &[A]).json()["status"] != status {
        assert!(begin.elapsed() < Duration::from_secs(40), "{path} is not {status}");
        std::thread::sleep(Duration::from_millis(5));
    }
    path
}

/// Every operation on a job in the OpenAPI document, with required parameters: method, and path after that of the job.
fn operations_on_a_job() -> Vec<(String, String, &'static [u8])> {
    let document = serde_json::to_value(raceway::api::document()).expect("JSON");
    let mut operations = Vec::new();
    for (path, methods) in document["paths"].as_object().expect("paths") {
        let Some(rest) = path.strip_prefix("/v1/jobs/{id}") else {
            assert!(!path.contains("{id}"), "{path} is about something else, and wants a test of its own");
            continue;
        };
        for (method, operation) in methods.as_object().expect("methods") {
            let parameters = operation["parameters"].as_array().expect("parameters");
            let query = parameters.iter().filter(|one| one["in"] == "query" && one["required"] == true);
            let query: Vec<String> = query
                .map(|one| match one["name"].as_str() {
                    Some("channel") => "channel=spindle.y.acceleration".to_owned(),
                    other => panic!("{method} {path} wants {other:?}"),
                })
                .collect();
            let body: &[u8] = if operation["requestBody"].is_null() { b"" } else { b"{}" };
            let rest = rest.replace("{file}", "spectrum.svg");
            let asked = format!("{rest}?{}", query.join("&")).trim_end_matches('?').to_owned();
            operations.push((method.to_uppercase(), asked, body));
        }
    }
    operations
}

#[test]
fn a_job_of_another_owner_is_unknown_on_every_route() {
    let server = start_with(ServerSettings { tokens: "alpha,beta", workers: 1, ..ServerSettings::default() });
    let study =
        job_with(json!({ "kind": "study", "axes": [{ "path": "/operation/speed_rpm", "values": [3000, 4000] }] }));
    let ended = made(&server, &job(), "succeeded");
    let studied = made(&server, &study, "succeeded");
    let failed = made(&server, &job_with(json!({ "labels": ["fail"], "reuse": false })), "failed");
    let running = made(&server, &job_with(json!({ "labels": ["slow"], "reuse": false })), "running");
    let waiting = made(&server, &job_with(json!({ "labels": ["slow"], "reuse": false })), "queued");
    let theirs = [&ended, &studied, &failed, &running, &waiting];
    let never = "/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f";
    let tag = get(&server, &format!("{ended}/metrics"), &[A]).header("etag").expect("a tag").to_owned();

    let operations = operations_on_a_job();
    assert!(operations.len() >= 13, "{operations:?}");
    let told = |answer: Answer| {
        let headers = answer.headers.into_iter().filter(|header| !header.0.eq_ignore_ascii_case("date"));
        (answer.status, headers.collect::<Vec<_>>(), answer.body)
    };
    for (method, rest, body) in &operations {
        for more in [
            &[][..],
            &[("If-None-Match", tag.as_str())],
            &[("If-None-Match", "*")],
            &[("Last-Event-ID", "succeeded-1000")],
        ] {
            let headers = [&[B, ("X-Request-Id", "one"), ("Content-Type", "application/json")], more].concat();
            let ask = |job: &str| request(server.address(), method, &format!("{job}{rest}"), &headers, body);
            let unknown = ask(never);
            unknown.problem(404);
            let unknown = told(unknown);
            for job in theirs {
                assert_eq!(told(ask(job)), unknown, "{method} {job}{rest} with {more:?}");
            }
        }
    }
    for (job, status) in theirs.iter().zip(["succeeded", "succeeded", "failed", "running", "queued"]) {
        assert_eq!(get(&server, job, &[A]).json()["status"], status, "{job} is as it was");
    }
}

#[test]
fn lists_keys_and_reuse_reveal_nothing_of_other_owners() {
    let server = start_with(ServerSettings { tokens: "alpha,beta", ..ServerSettings::default() });
    let labelled = job_with(json!({ "labels": ["of-alpha"] }));
    let mine = made(&server, &labelled, "succeeded");
    made(&server, &job(), "succeeded");
    let id = mine.strip_prefix("/v1/jobs/").expect("a path");
    let cursors = [get(&server, "/v1/jobs?limit=1", &[A]).json()["next"].as_str().expect("a next page").to_owned()];
    let pages = ["", "?label=of-alpha", "?status=succeeded", "?kind=simulation", &format!("?cursor={id}")];
    for path in pages.iter().map(|query| format!("/v1/jobs{query}")).chain(cursors) {
        assert_eq!(get(&server, &path, &[B]).json(), json!({ "jobs": [], "next": null }), "{path}");
    }
    // For another owner the same work runs again, and the same key is a different one.
    let key = [("Idempotency-Key", "a-key")];
    assert_eq!(post(&server, A, &key, &labelled).json()["reused"], true);
    for body in [&labelled, &job()] {
        let key = [("Idempotency-Key", if body == &labelled { "a-key" } else { "another-key" })];
        let theirs = post(&server, B, &key, body);
        assert_eq!((theirs.status, theirs.header("idempotent-replayed")), (202, None), "{theirs:?}");
        assert_eq!(
            (&theirs.json()["status"], &theirs.json()["reused"]),
            (&json!("queued"), &json!(false)),
            "{theirs:?}"
        );
    }
    assert_eq!(post(&server, A, &key, &labelled).header("idempotent-replayed"), Some("true"));
    assert_eq!(get(&server, "/v1/jobs", &[B]).json()["jobs"].as_array().map(Vec::len), Some(2));
}

#[test]
fn only_pages_of_listed_origins_may_use_the_api() {
    const PORTAL: &str = "https://portal.example";
    let server = start_with(ServerSettings { tokens: "alpha", origins: &[PORTAL], ..ServerSettings::default() });
    let asked = |origin: &str| {
        let headers = [
            ("Origin", origin),
            ("Access-Control-Request-Method", "POST"),
            ("Access-Control-Request-Headers", "authorization,content-type,prefer"),
        ];
        request(server.address(), "OPTIONS", "/v1/jobs", &headers, b"")
    };
    let answer = asked(PORTAL);
    assert_eq!((answer.status, answer.header("access-control-allow-origin")), (200, Some(PORTAL)), "{answer:?}");
    assert!(answer.header("access-control-allow-headers").is_some_and(|names| names.contains("prefer")), "{answer:?}");
    assert_eq!(asked("https://other.example").header("access-control-allow-origin"), None);
    // Pages can also read error answers.
    let refused = get(&server, "/v1/jobs", &[("Origin", PORTAL)]);
    refused.problem(401);
    assert_eq!(refused.header("access-control-allow-origin"), Some(PORTAL));
    assert!(refused.header("access-control-expose-headers").is_some_and(|names| names.contains("location")));
    assert_eq!(start().get("/v1/jobs").header("access-control-allow-origin"), None);
}

#[test]
fn every_answer_has_a_request_id() {
    let server = start_with(ServerSettings { tokens: "alpha", ..ServerSettings::default() });
    for path in ["/health/live", "/v1/jobs", "/nowhere"] {
        assert_eq!(get(&server, path, &[("X-Request-Id", "mine-1")]).header("x-request-id"), Some("mine-1"), "{path}");
        let names = [(); 2].map(|()| get(&server, path, &[("X-Request-Id", "two words")]));
        let [one, other] = names.each_ref().map(|answer| answer.header("x-request-id").expect("a name"));
        assert!(one != other && one.len() == 36, "{path}: {one}, {other}");
    }
}
