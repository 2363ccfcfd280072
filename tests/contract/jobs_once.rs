//! `Idempotency-Key`, `POST /v1/jobs/batch`, and conditional requests.

use serde_json::{Value, json};

use crate::common::{Answer, Server, job, job_with, request};
use crate::server::{InProcess, start};

fn post(server: &InProcess, path: &str, key: &str, body: &Value) -> Answer {
    let headers = [("Content-Type", "application/json"), ("Idempotency-Key", key)];
    request(server.address(), "POST", path, &headers, body.to_string().as_bytes())
}

fn ask(server: &InProcess, path: &str, tag: &str) -> Answer {
    request(server.address(), "GET", path, &[("If-None-Match", tag)], b"")
}

#[test]
fn an_idempotency_key_creates_one_job() {
    let server = start();
    let first = post(&server, "/v1/jobs", "night-1", &job());
    let again = post(&server, "/v1/jobs", "night-1", &job());
    assert_eq!((first.status, first.header("idempotent-replayed")), (202, None));
    assert_eq!((again.status, again.header("idempotent-replayed")), (202, Some("true")));
    assert_eq!((first.json(), first.header("location")), (again.json(), again.header("location")));
    let path = first.header("location").expect("a location").to_owned();
    server.wait_for(&path, &["succeeded"]);
    assert_eq!(post(&server, "/v1/jobs", "night-1", &job()).json(), first.json(), "the first answer, also later");
    let waited = {
        let headers = [("Content-Type", "application/json"), ("Idempotency-Key", "night-1"), ("Prefer", "wait=5")];
        request(server.address(), "POST", "/v1/jobs", &headers, job().to_string().as_bytes())
    };
    assert_eq!((waited.status, &waited.json()["status"]), (200, &json!("succeeded")));
    let problem = post(&server, "/v1/jobs", "night-1", &job_with(json!({ "labels": ["other"] }))).problem(422);
    assert_eq!(problem["type"], "urn:raceway:problem:idempotency-key-reused");
    let other = post(&server, "/v1/jobs", "night-2", &job());
    assert_ne!(other.json()["id"], first.json()["id"]);
    assert_eq!(other.json()["reused"], true);
    assert_eq!(post(&server, "/v1/jobs", "night-2", &job()).json(), other.json());
    // A deleted job is not created again.
    request(server.address(), "DELETE", &path, &[], b"");
    assert_eq!(post(&server, "/v1/jobs", "night-1", &job()).json()["id"], first.json()["id"]);
    assert_eq!(server.get("/v1/jobs").json()["jobs"].as_array().map(Vec::len), Some(1));
    for wrong in ["", "a b", "ä", &"x".repeat(256)] {
        post(&server, "/v1/jobs", wrong, &job()).problem(400);
    }
    let refused = post(&server, "/v1/jobs", "night-3", &json!({ "kind": "simulation" }));
    refused.problem(422);
    assert_eq!(post(&server, "/v1/jobs", "night-3", &job()).header("idempotent-replayed"), None, "nothing was made");
}

#[test]
fn a_batch_is_answered_one_by_one() {
    let server = start();
    let body =
        json!({ "jobs": [job(), { "kind": "simulation" }, job_with(json!({ "labels": ["b"], "reuse": false }))] });
    let answer = post(&server, "/v1/jobs/batch", "all", &body);
    assert_eq!(answer.status, 200, "{answer:?}");
    let answers = answer.json()["answers"].clone();
    let statuses: Vec<u64> = answers.as_array().expect("answers").iter().filter_map(|a| a["status"].as_u64()).collect();
    assert_eq!(statuses, [202, 422, 202]);
    assert_eq!(answers[1]["problem"]["errors"][0]["pointer"], "/scene");
    assert_eq!(answers[2]["job"]["labels"], json!(["b"]));
    assert!(answers[0]["problem"].is_null() && answers[1]["job"].is_null());
    assert!(answers[0]["job"]["id"].as_str() < answers[2]["job"]["id"].as_str(), "in their order");
    let again = post(&server, "/v1/jobs/batch", "all", &body).json();
    assert_eq!(again["answers"][0]["job"], answers[0]["job"]);
    assert_eq!(again["answers"][2]["job"], answers[2]["job"]);
    assert_eq!(post(&server, "/v1/jobs/batch", "all", &body).header("idempotent-replayed"), Some("true"));
    let other = post(&server, "/v1/jobs/batch", "all", &json!({ "jobs": [job()] })).problem(422);
    assert_eq!(other["type"], "urn:raceway:problem:idempotency-key-reused");
    assert_eq!(post(&server, "/v1/jobs", "all", &job_with(json!({ "labels": ["c"] }))).status, 202, "a key of its own");
    let text = r#"{ "jobs": [{ "kind": "simulation", "kind": "study" }, null, 5] }"#;
    let headers = [("Content-Type", "application/json")];
    let strict = request(server.address(), "POST", "/v1/jobs/batch", &headers, text.as_bytes()).json();
    assert_eq!([0, 1, 2].map(|item| strict["answers"][item]["status"].as_u64()), [Some(422); 3]);
    for (body, pointer) in [
        (json!({ "jobs": [] }), "/jobs"),
        (json!({ "jobs": {} }), ""),
        (json!({}), ""),
        (json!({ "jobs": [job()], "priority": 1 }), ""),
        (json!([job()]), ""),
    ] {
        assert_eq!(server.post("/v1/jobs/batch", &body).problem(422)["errors"][0]["pointer"], pointer);
    }
}

#[test]
fn a_result_that_the_client_has_is_answered_by_304() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    let shown = server.get(&path);
    let tag = shown.header("etag").expect("a tag").to_owned();
    assert!(tag.starts_with("W/\""));
    assert_eq!((ask(&server, &path, &tag).status, ask(&server, &path, "\"x\"").status), (304, 200));
    assert_eq!(ask(&server, &format!("{path}?include=metrics"), &tag).status, 200);
    for below in ["metrics", "channels", "spectrum?channel=spindle.y.acceleration", "plots/spectrum.svg"] {
        let path = format!("{path}/{below}");
        let answer = server.get(&path);
        let tag = answer.header("etag").expect("a tag").to_owned();
        assert!(tag.starts_with('"') && answer.header("cache-control").is_some_and(|how| how.contains("immutable")));
        assert_eq!(server.get(&path).header("etag"), Some(&*tag));
        let unchanged = ask(&server, &path, &tag);
        assert_eq!((unchanged.status, unchanged.body.as_str(), unchanged.header("etag")), (304, "", Some(&*tag)));
    }
    let spectrum = |most: u32| {
        let path = format!("{path}/spectrum?channel=spindle.y.acceleration&max_frequency_hz={most}");
        server.get(&path).header("etag").expect("a tag").to_owned()
    };
    assert_ne!(spectrum(1000), spectrum(2000));
    let csv = format!("{path}/spectrum?channel=spindle.y.acceleration");
    let tags = ["application/json", "text/csv"].map(|format| {
        request(server.address(), "GET", &csv, &[("Accept", format)], b"").header("etag").map(str::to_owned)
    });
    assert_ne!(tags[0], tags[1]);
    assert_eq!((ask(&server, &path, "*").status, ask(&server, &format!("{path}/metrics"), "*").status), (304, 304));
    let unknown = server.get(&format!("{path}/spectrum?channel=cage.speed"));
    assert_eq!((unknown.status, unknown.header("etag")), (404, None));
}

#[test]
fn channels_are_listed_before_they_are_read() {
    let server = start();
    let outputs = json!({ "outputs": { "series": ["spindle.y.velocity"], "spectra": ["spindle.z.acceleration"] } });
    let path = server.submit(&job_with(outputs));
    server.wait_for(&path, &["succeeded"]);
    let kept = server.get(&format!("{path}/channels")).json();
    assert_eq!(
        kept,
        json!({ "spectra": ["spindle.z.acceleration"], "envelopes": ["spindle.z.acceleration"], "series": ["spindle.y.velocity"] })
    );
    let series = format!("{path}/series?channel=spindle.y.velocity");
    let npy = request(server.address(), "GET", &series, &[("Accept", "application/x-npy")], b"");
    assert_eq!((npy.status, npy.header("content-type")), (200, Some("application/x-npy")));
    assert!(npy.body.contains("NUMPY") && npy.body.contains("'time_s'"), "{npy:?}");
}
