//! `/v1/series`: series of loads, which jobs name by their content hash.

use serde_json::{Value, json};

use crate::common::{Answer, Server, request};
use crate::server::{InProcess, ServerSettings, start, start_with};

const A: (&str, &str) = ("Authorization", "Bearer alpha");
const B: (&str, &str) = ("Authorization", "Bearer beta");
const JSON: (&str, &str) = ("Content-Type", "application/json");

fn upload(server: &InProcess, values: &Value) -> String {
    let answer = server.post("/v1/series", &json!({ "rate_hz": 1000, "values": values }));
    assert_eq!(answer.status, 201, "{answer:?}");
    answer.json()["hash"].as_str().expect("a hash").to_owned()
}

fn delete(server: &InProcess, path: &str) -> Answer {
    request(server.address(), "DELETE", path, &[], b"")
}

fn job(hash: &str, label: &str) -> Value {
    let loads = json!([{ "direction": "y", "series": { "hash": hash } }]);
    json!({
        "kind": "simulation", "labels": [label],
        "scene": { "bearing": "article-integrated", "operation": { "speed_rpm": 50000, "radial_load_y_n": 100, "loads": loads } }
    })
}

#[test]
fn a_series_is_stored_once_and_named_by_its_hash() {
    let server = start();
    let hash = upload(&server, &json!([0, 12.5, -30]));
    let csv = request(
        server.address(),
        "POST",
        "/v1/series?rate_hz=1000",
        &[("Content-Type", "text/csv")],
        b"force_n\r\n0\r\n12.5\r\n-3e1\r\n",
    );
    assert_eq!((csv.status, csv.json()["hash"].as_str()), (201, Some(hash.as_str())));
    assert_eq!(csv.header("location"), Some(format!("/v1/series/{hash}").as_str()));
    let shown = server.get(&format!("/v1/series/{hash}")).json();
    assert_eq!((&shown["values"], &shown["duration_s"]), (&json!(3), &json!(0.002)));
    assert_eq!(server.get("/v1/series").json()["series"].as_array().map(Vec::len), Some(1));
    let resolved = server.post("/v1/scenes/resolve", &job(&hash, "")).json();
    let load = &resolved["derived"]["loads"][0];
    assert_eq!(
        (&load["kind"], &load["largest_change"], &load["end_s"]),
        (&json!("series"), &json!(30.0), &json!(0.002))
    );
    let done = request(
        server.address(),
        "POST",
        "/v1/jobs",
        &[JSON, ("Prefer", "wait=30")],
        job(&hash, "run").to_string().as_bytes(),
    );
    assert_eq!((done.status, &done.json()["status"]), (200, &json!("succeeded")), "{done:?}");
}

#[test]
fn a_study_varies_the_series() {
    let server = start();
    let hashes = [upload(&server, &json!([0, 1])), upload(&server, &json!([0, 2]))];
    let mut study = job(&hashes[0], "study");
    study["kind"] = json!("study");
    study["axes"] = json!([{ "path": "/operation/loads/0/series/hash", "values": hashes }]);
    let id = server.post("/v1/jobs", &study).json()["id"].as_str().expect("an id").to_owned();
    server.wait_for(&format!("/v1/jobs/{id}"), &["succeeded", "failed", "cancelled"]);
    let table = server.get(&format!("/v1/jobs/{id}/table")).json();
    assert_eq!(table["rows"][1]["status"], json!("succeeded"), "{table}");
}

#[test]
fn wrong_series_are_refused() {
    let server = start();
    let wrong = |body: Value| server.post("/v1/series", &body).problem(422)["errors"][0]["pointer"].clone();
    assert_eq!(wrong(json!({ "rate_hz": 99, "values": [0, 1] })), json!("/rate_hz"));
    assert_eq!(wrong(json!({ "rate_hz": 1000, "values": [0] })), json!("/values"));
    assert_eq!(wrong(json!({ "rate_hz": 1000, "values": [0, null] })), json!(""));
    request(server.address(), "POST", "/v1/series", &[("Content-Type", "text/plain")], b"1\n2").problem(415);
    server.get(&format!("/v1/series/{}", "0a".repeat(32))).problem(404);
    server.get("/v1/series/nothing").problem(404);
    let unknown = server.post("/v1/jobs", &job(&"0a".repeat(32), "")).problem(422);
    assert_eq!(unknown["errors"][0]["pointer"], json!("/scene/operation/loads/0/series/hash"));
    // Every value counts against the limit of a load.
    let strong = upload(&server, &json!([0, 2e7]));
    let refused = server.post("/v1/jobs", &job(&strong, "")).problem(422);
    assert_eq!(refused["errors"][0]["pointer"], json!("/scene/operation/loads/0/series/hash"));
}

#[test]
fn a_series_belongs_to_its_owner() {
    let server = start_with(ServerSettings { tokens: "alpha, beta", ..ServerSettings::default() });
    let ask = |method: &str, path: &str, token, body: &Value| -> Answer {
        request(server.address(), method, path, &[JSON, token], body.to_string().as_bytes())
    };
    let stored = ask("POST", "/v1/series", A, &json!({ "rate_hz": 1000, "values": [0, 1] })).json();
    let hash = stored["hash"].as_str().expect("a hash");
    let path = format!("/v1/series/{hash}");
    ask("GET", &path, B, &json!({})).problem(404);
    ask("DELETE", &path, B, &json!({})).problem(404);
    ask("POST", "/v1/jobs", B, &job(hash, "")).problem(422);
    assert_eq!(ask("GET", &path, A, &json!({})).status, 200);
}

#[test]
fn a_series_in_use_is_not_deleted() {
    let server = start();
    let hash = upload(&server, &json!([0, 1, 0]));
    let path = format!("/v1/series/{hash}");
    let id = server.post("/v1/jobs", &job(&hash, "slow")).json()["id"].as_str().expect("an id").to_owned();
    delete(&server, &path).problem(409);
    server.post(&format!("/v1/jobs/{id}/cancel"), &json!({}));
    server.wait_for(&format!("/v1/jobs/{id}"), &["succeeded", "failed", "cancelled"]);
    assert_eq!(delete(&server, &path).status, 204);
    server.get(&path).problem(404);
}

#[test]
fn an_expired_series_is_gone() {
    let server = start();
    let hash = upload(&server, &json!([0, 1, 0]));
    const EXPIRE: &str = "UPDATE uploaded_series SET expires_at = expires_at - 2592001000000";
    server.sql(EXPIRE, EXPIRE);
    let path = format!("/v1/series/{hash}");
    let begin = std::time::Instant::now();
    while server.get(&path).status == 200 && begin.elapsed().as_secs() < 10 {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    server.get(&path).problem(410);
    server.post("/v1/jobs", &job(&hash, "")).problem(410);
    // The same values may be sent again.
    assert_eq!(upload(&server, &json!([0, 1, 0])), hash);
    assert_eq!(server.get(&path).status, 200);
}
