//! Who may ask.

use std::io::{Read, Write};
use std::net::TcpStream;

use serde_json::json;

use crate::common::{Answer, Server, job, request};
use crate::server::{InProcess, Wishes, start, start_with};

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
fn without_tokens_one_host_is_needed() {
    let server = start();
    let mut stream = TcpStream::connect(server.address()).expect("the server listens");
    stream.write_all(b"GET /v1/jobs HTTP/1.1\r\nConnection: close\r\n\r\n").expect("a request is read");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer comes");
    assert!(answer.starts_with("HTTP/1.1 400 ") && answer.contains("urn:raceway:problem:bad-request"), "{answer}");
    get(&server, "/v1/jobs", &[("Host", "localhost"), ("Host", "example.org")]).problem(400);
}

#[test]
fn with_tokens_everything_but_the_open_pages_needs_one() {
    let server = start_with(Wishes { tokens: "alpha, beta", ..Wishes::default() });
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

#[test]
fn jobs_of_other_tokens_are_not_there() {
    let server = start_with(Wishes { tokens: "alpha,beta", ..Wishes::default() });
    let headers = [("Authorization", "Bearer alpha"), ("Content-Type", "application/json")];
    let mine = request(server.address(), "POST", "/v1/jobs", &headers, job().to_string().as_bytes());
    let path = mine.header("location").expect("a location");
    let other = [("Authorization", "Bearer beta")];
    get(&server, path, &other).problem(404);
    get(&server, &format!("{path}/metrics"), &other).problem(404);
    request(server.address(), "POST", &format!("{path}/cancel"), &other, b"").problem(404);
    request(server.address(), "DELETE", path, &other, b"").problem(404);
    assert_eq!(get(&server, "/v1/jobs", &other).json()["jobs"], json!([]));
    assert_eq!(get(&server, path, &headers).status, 200);
}

#[test]
fn pages_of_listed_origins_alone_may_use_the_api() {
    const PORTAL: &str = "https://portal.example";
    let server = start_with(Wishes { tokens: "alpha", origins: &[PORTAL], ..Wishes::default() });
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
    // Refusals can be read, too.
    let refused = get(&server, "/v1/jobs", &[("Origin", PORTAL)]);
    refused.problem(401);
    assert_eq!(refused.header("access-control-allow-origin"), Some(PORTAL));
    assert!(refused.header("access-control-expose-headers").is_some_and(|names| names.contains("location")));
    assert_eq!(start().get("/v1/jobs").header("access-control-allow-origin"), None);
}
