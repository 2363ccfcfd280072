//! Fuzz target for HTTP: the service reads route, path, query, headers and body of a request and answers it.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use raceway::api::fuzzing::{Answer, Service};
use serde_json::Value;

static SERVICE: LazyLock<Service> = LazyLock::new(|| {
    let service = Service::default();
    for path in Service::paths() {
        let path = path.replace("{id}", JOB).replace("{file}", "spectrum.svg");
        let routed = ["GET", "POST"].into_iter().any(|method| ask(&service, method, &path).status != 404);
        assert!(routed, "{path} is in the document, but not here");
    }
    service
});

const JOB: &str = "01990000-0000-7000-8000-000000000000";

fn ask(service: &Service, method: &str, target: &str) -> Answer {
    service.answer(method, target, &[], b"").expect("a good request")
}

fuzz_target!(|text: &[u8]| {
    let Some((method, target, headers, body)) = parts(text) else { return };
    if let Some(answer) = SERVICE.answer(method, target, &headers, body) {
        check(method, target, &answer);
    }
});

type Headers<'a> = Vec<(&'a [u8], &'a [u8])>;

/// Method, target, headers and body of a text: request line, header lines, an empty line, the body.
fn parts(text: &[u8]) -> Option<(&str, &str, Headers<'_>, &[u8])> {
    let mut lines = text.splitn(2, |byte| *byte == b'\n');
    let (method, target) = std::str::from_utf8(lines.next()?).ok()?.split_once(' ')?;
    let mut rest = lines.next().unwrap_or_default();
    let mut headers = Vec::new();
    while let Some(end) = rest.iter().position(|byte| *byte == b'\n') {
        let line = &rest[..end];
        rest = &rest[end + 1..];
        if line.is_empty() {
            return Some((method, target, headers, rest));
        }
        let colon = line.iter().position(|byte| *byte == b':')?;
        headers.push((&line[..colon], line[colon + 1..].trim_ascii()));
    }
    Some((method, target, headers, b""))
}

fn check(method: &str, target: &str, answer: &Answer) {
    let header = |name: &str| answer.headers.get(name).and_then(|value| value.to_str().ok());
    assert!(answer.status < 500, "{answer:?}");
    if answer.status >= 400 {
        // The HTTP server removes the body of an answer to HEAD, not this router.
        if method == "HEAD" {
            return;
        }
        assert_eq!(header("content-type"), Some("application/problem+json"), "{answer:?}");
        let problem: Value = serde_json::from_slice(&answer.body).expect("a problem is JSON");
        assert_eq!(problem["status"], answer.status, "{problem}");
        for field in ["type", "title", "detail"] {
            assert!(problem[field].as_str().is_some_and(|text| !text.is_empty()), "{problem}");
        }
        return;
    }
    if let Some(next) = header("link").and_then(|link| link.strip_prefix('/').map(|_| link)) {
        let page = ask(&SERVICE, "GET", next);
        assert_eq!((page.status, page.headers.get("link")), (200, answer.headers.get("link")), "{next}");
    }
    // A fragment is not part of the request target.
    let path = target.split(['?', '#']).next().unwrap_or_default();
    let is_of_job = path.starts_with("/v1/jobs/");
    if answer.status == 200 && is_of_job && (path.ends_with("/spectrum") || path.ends_with("/series")) {
        signal(header("content-type"), &answer.body);
    }
}

/// Each line or record has as many values as there are columns, and all values are finite.
fn signal(media_type: Option<&str>, body: &[u8]) {
    match media_type {
        Some("application/json") => {
            let signal: Value = serde_json::from_slice(body).expect("JSON");
            let numbers = |names: [&str; 2]| names.iter().find_map(|name| signal[*name].as_array()).cloned();
            let places = numbers(["time_s", "frequency_hz"]).expect("places");
            let values = numbers(["value", "amplitude"]).expect("values");
            assert_eq!(places.len(), values.len());
            assert!(places.iter().chain(&values).all(Value::is_number));
            assert!(places.windows(2).all(|pair| pair[0].as_f64() < pair[1].as_f64()), "{places:?}");
        }
        Some("text/csv; charset=utf-8") => {
            let text = std::str::from_utf8(body).expect("UTF-8");
            let rows: Vec<_> = text.lines().map(|line| line.split(',').collect::<Vec<_>>()).collect();
            assert!(rows.iter().all(|row| row.len() == 2), "{text}");
            assert!(rows[1..].iter().flatten().all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite)), "{text}");
        }
        Some("application/x-npy") => {
            let header = usize::from(u16::from_le_bytes([body[8], body[9]])) + 10;
            assert!(
                body.starts_with(b"\x93NUMPY") && header.is_multiple_of(64) && (body.len() - header).is_multiple_of(16)
            );
        }
        other => panic!("{other:?}"),
    }
}
