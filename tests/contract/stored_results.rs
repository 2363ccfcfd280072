//! Stored results that are not what was written.

use serde_json::json;

use crate::common::{Server, job, job_with, request};
use crate::server::{InProcess, ServerSettings, start, start_with};

#[test]
fn a_corrupt_result_is_refused_counted_and_not_reused() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    let state = || server.get("/health/ready").json()["stored_results"].clone();
    assert_eq!(state(), json!({ "state": "ok", "corrupt": 0 }));
    let change = "UPDATE results SET metrics = replace(metrics, '1', '2')";
    server.sql(change, change);
    for of_job in ["/metrics", "?include=metrics"] {
        let problem = server.get(&format!("{path}{of_job}")).problem(500);
        assert_eq!(problem["type"], "urn:raceway:problem:result-corrupt", "{of_job}");
    }
    assert_eq!(server.get(&path).status, 200);
    assert_eq!(state(), json!({ "state": "corrupt", "corrupt": 1 }));
    assert!(server.get("/metrics").body.contains("raceway_corrupt_results_total 2\n"));
    let again = server.post("/v1/jobs", &job()).json();
    assert_eq!(again["reused"], false);
    let again = again["links"]["self"].as_str().expect("a link").to_owned();
    server.wait_for(&again, &["succeeded"]);
    assert_eq!(server.post("/v1/jobs", &job()).json()["reused"], true, "the new result is sound");
    assert_eq!(server.get(&format!("{again}/metrics")).status, 200);
}

#[test]
fn a_result_that_became_corrupt_unseen_is_not_reused() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    let [on_sqlite, on_postgres] = [
        "UPDATE signals SET answer = CAST(answer || x'00' AS BLOB)",
        "UPDATE signals SET answer = answer || CAST('\\x00' AS BYTEA)",
    ];
    server.sql(on_sqlite, on_postgres);
    assert_eq!(server.get("/health/ready").json()["stored_results"]["corrupt"], 0, "nobody has read it");
    assert_eq!(server.post("/v1/jobs", &job_with(json!({ "labels": ["again"] }))).json()["reused"], false);
    assert_eq!(server.get("/health/ready").json()["stored_results"]["corrupt"], 1);
}

#[test]
fn a_row_without_digest_is_read_as_before() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    let forget = "UPDATE results SET digest = NULL; UPDATE signals SET digest = NULL; UPDATE views SET digest = NULL";
    server.sql(forget, forget);
    assert_eq!(server.get(&format!("{path}/metrics")).status, 200);
    assert_eq!(server.post("/v1/jobs", &job()).json()["reused"], true);
}

/// The answer to a request for a damaged job.
fn assert_corrupt(server: &InProcess, path: &str) {
    assert_eq!(server.get(path).problem(500)["type"], "urn:raceway:problem:result-corrupt", "{path}");
}

#[test]
fn a_result_in_the_place_of_another_is_refused() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    let other = server.submit(&job_with(json!({ "reuse": false })));
    server.wait_for(&other, &["succeeded"]);
    let exchange = "UPDATE results SET (metrics, digest) = \
                    (SELECT other.metrics, other.digest FROM results AS other WHERE other.id <> results.id)";
    server.sql(exchange, exchange);
    let refused = [path, other].iter().filter(|path| server.get(&format!("{path}/metrics")).status == 500).count();
    assert!(refused > 0, "SQLite changes one row after the other");
}

#[test]
fn a_changed_request_is_never_shown_run_or_reused() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let ended = server.submit(&job());
    server.wait_for(&ended, &["succeeded"]);
    let running = server.submit(&job_with(json!({ "reuse": false, "labels": ["slow"] })));
    server.wait_for(&running, &["running"]);
    let waiting = server.submit(&job_with(json!({ "reuse": false, "labels": ["waiting"] })));
    let axes = json!([{ "path": "/operation/speed_rpm", "values": [3000, 3100] }]);
    let study = job_with(json!({ "kind": "study", "outputs": { "metrics": ["vibration"] }, "axes": axes }));
    let study = server.submit(&study);
    let change = "UPDATE jobs SET request = replace(request, '3000', '3001') WHERE labels NOT LIKE '%slow%'";
    server.sql(change, change);
    for path in [&ended, &waiting, &study, &format!("{ended}/metrics"), &format!("{study}/table")] {
        assert_corrupt(&server, path);
    }
    assert_eq!(server.get("/v1/jobs").json()["jobs"].as_array().map(Vec::len), Some(1), "the others are left out");
    assert_eq!(server.get("/health/ready").json()["stored_results"]["corrupt"], 3);
    assert_eq!(server.post("/v1/jobs", &job()).json()["reused"], false);
    request(server.address(), "POST", &format!("{running}/cancel"), &[], b"");
    let restore = "UPDATE jobs SET request = replace(request, '3001', '3000') WHERE finished_at IS NOT NULL";
    for path in [&waiting, &study] {
        let ended = std::iter::repeat_with(|| {
            std::thread::sleep(std::time::Duration::from_millis(20));
            server.sql(restore, restore);
            server.get(path)
        });
        let ended = ended.take(500).find(|answer| answer.status == 200).expect("it ends").json();
        assert_eq!(ended["status"], "failed", "{ended}");
        assert_eq!(ended["error"]["type"], "urn:raceway:problem:result-corrupt", "{ended}");
    }
}

#[test]
fn a_missing_result_is_refused_and_counted() {
    let server = start();
    let path = server.submit(&job());
    server.wait_for(&path, &["succeeded"]);
    server.sql(
        "PRAGMA foreign_keys = OFF; DELETE FROM results",
        "ALTER TABLE jobs DROP CONSTRAINT jobs_result_id_fkey; DELETE FROM results",
    );
    assert_corrupt(&server, &format!("{path}?include=metrics"));
    assert_eq!(server.get("/health/ready").json()["stored_results"]["corrupt"], 1);
    assert_eq!(server.post("/v1/jobs", &job()).json()["reused"], false);
}
