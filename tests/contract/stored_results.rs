//! Stored results that are not what was written.

use serde_json::json;

use crate::common::{Server, job, job_with};
use crate::server::start;

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
