//! Invalid requests, and the form of every error.

use serde_json::json;

use crate::common::{Answer, Server, job, request};
use crate::server::start;

#[test]
fn queries_with_nul_are_refused() {
    let server = start();
    server.get("/v1/jobs?label=a%00b").problem(400);
}

#[test]
fn errors_of_the_framework_have_the_same_form() {
    let server = start();
    let problem = server.get("/v1/jobs?label=%ff").problem(400);
    assert_eq!(problem["detail"], "query: is not UTF-8");
    let get = |headers: &[(&str, &str)]| request(server.address(), "GET", "/v1/presets", headers, b"");
    let long = "a".repeat(70_000);
    let problem = get(&[("X-Long", &long)]).problem(431);
    assert_eq!(problem["detail"], "the header with the request line may have at most 65536 bytes");
    assert_eq!(get(&[("X-Long", &long[..60_000])]).status, 200);
    let answer = get(&[("Accept-Encoding", "gzip;q=0, *;q=0")]);
    assert!(answer.header("etag").is_none());
    assert!(answer.problem(406)["detail"].as_str().is_some_and(|detail| detail.contains("gzip")), "{answer:?}");
}

#[test]
fn wrong_bodies_are_refused_with_their_reason() {
    let server = start();
    let json = [("Content-Type", "application/json")];
    let post = |body: &[u8]| request(server.address(), "POST", "/v1/jobs", &json, body);
    let table: [(&[u8], u16); 12] = [
        (b"", 400),
        (b"{", 400),
        (b"not json", 400),
        (b"\xff\xfe", 400),
        (b"null", 422),
        (b"[]", 422),
        (b"{}", 422),
        (br#"{"kind":"simulation"}"#, 422),
        (br#"{"kind":"simulation","scene":{"bearing":"608","operation":{"speed_rpm":"fast"}}}"#, 422),
        (br#"{"kind":"simulation","scene":{"bearing":"608","operation":{"speed_rpm":1e9}}}"#, 422),
        (br#"{"kind":"simulation","scene":{"bearing":"608","operation":{"speed_rpm":3000}},"colour":"red"}"#, 422),
        (br#"{"kind":"simulation","scene":{"bearing":"608","operation":{"speed_rpm":null}}}"#, 422),
    ];
    for (body, status) in table {
        let problem = post(body).problem(status);
        if status == 422 {
            assert!(problem["errors"][0]["pointer"].is_string(), "{problem}");
        }
    }
    assert_eq!(
        post(b"[]").problem(422)["detail"],
        "the body: must be an object; several jobs are a batch, `{\"jobs\": […]}`"
    );
    assert_eq!(server.get("/v1/jobs").json()["jobs"], json!([]), "none of them is a job");
}

#[test]
fn only_json_of_a_reasonable_size_is_read() {
    let server = start();
    let body = job().to_string();
    let post = |headers: &[(&str, &str)], body: &[u8]| request(server.address(), "POST", "/v1/jobs", headers, body);
    post(&[], body.as_bytes()).problem(415);
    post(&[("Content-Type", "text/plain")], body.as_bytes()).problem(415);
    post(&[("Content-Type", "application/json"), ("Content-Encoding", "gzip")], body.as_bytes()).problem(415);
    assert_eq!(post(&[("Content-Type", "application/json; charset=utf-8")], body.as_bytes()).status, 202);
    let large = format!("{}{}", body, " ".repeat(1 << 20));
    post(&[("Content-Type", "application/json")], large.as_bytes()).problem(413);
    let padded = format!("{}{}", body, " ".repeat((1 << 20) - body.len()));
    assert_eq!(post(&[("Content-Type", "application/json")], padded.as_bytes()).status, 202);
}

#[test]
fn every_refusal_is_a_problem() {
    let server = start();
    let send = |method: &str, path: &str| request(server.address(), method, path, &[], b"");
    send("GET", "/v2").problem(404);
    send("GET", "/v1/jobs/").problem(404);
    send("GET", "/v1/jobs/no-uuid").problem(404);
    send("GET", "/v1/jobs/%ff").problem(404);
    send("GET", "/v1/jobs/01919F5C-8C4E-7D3A-9A51-2F6D1B0C4E7F").problem(404);
    send("GET", "/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f").problem(404);
    send("GET", "/docs/no-such-file").problem(404);
    let wrong_method = send("PUT", "/v1/jobs");
    wrong_method.problem(405);
    let allowed = wrong_method.header("allow").expect("a 405 has Allow");
    assert!(allowed.contains("GET") && allowed.contains("POST"), "{allowed}");
    for (method, path) in [("GET", "/v1/presets?x=1"), ("POST", "/v1/jobs?x=1"), ("POST", "/v1/scenes/resolve?x=1")] {
        let json = [("Content-Type", "application/json")];
        request(server.address(), method, path, &json, job().to_string().as_bytes()).problem(400);
    }
    let job = "/v1/jobs/01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f";
    send("GET", &format!("{job}/metrics?x=1")).problem(400);
    send("GET", &format!("{job}/plots/spectrum.svg?x=1")).problem(400);
    send("POST", &format!("{job}/cancel?x=1")).problem(400);
    send("DELETE", &format!("{job}?x=1")).problem(400);
    send("POST", "/v1/presets").problem(405);
    send("BREW", "/v1/presets").problem(405);
}

#[test]
fn probes_and_pages_answer() {
    let server = start();
    assert_eq!(server.get("/health/live").json()["status"], "ok");
    assert_eq!(server.get("/health/ready").json()["status"], "ok");
    assert_eq!(server.get("/").status, 200);
    let page = server.get("/docs/");
    assert!(page.status == 200 && page.body.contains("swagger"), "{page:?}");
    let policy = |answer: &Answer| answer.header("content-security-policy").map(str::to_owned);
    let expected = policy(&server.get("/"));
    assert!(expected.is_some() && policy(&page) == expected, "{page:?}");
    for file in page.body.split("./").skip(1).filter_map(|rest| rest.split('"').next()) {
        let answer = server.get(&format!("/docs/{file}"));
        assert_eq!((answer.status, policy(&answer)), (200, expected.clone()), "{file}");
    }
}
