//! Studies: from the request to the table, cancellation and resumption, priority, and reuse.

use std::time::Duration;

use serde_json::{Value, json};

use crate::common::{Server, job, job_with, request};
use crate::server::{ServerSettings, start, start_with};

/// A study of the smallest job over the speed.
fn study_of(points: u32) -> Value {
    let mut study = job();
    study["kind"] = json!("study");
    study["outputs"] = json!({ "metrics": ["vibration"] });
    study["axes"] = json!([{ "path": "/operation/speed_rpm", "from": 3000, "to": 6000, "count": points }]);
    study
}

fn statuses(table: &Value) -> Vec<&str> {
    table["rows"].as_array().expect("rows").iter().map(|row| row["status"].as_str().expect("a status")).collect()
}

#[test]
fn a_study_fills_its_table() {
    let server = start();
    let path = server.submit(&study_of(5));
    let job = server.wait_for(&path, &["succeeded", "failed"]);
    assert_eq!((&job["status"], &job["progress"], &job["kind"]), (&json!("succeeded"), &json!(1.0), &json!("study")));
    assert_eq!(job["links"]["table"], format!("{path}/table"));
    assert!(job["links"]["metrics"].is_null() && job["links"]["resume"].is_null());
    let table = server.get(&format!("{path}/table")).json();
    assert_eq!((&table["points"], &table["ended"], &table["succeeded"]), (&json!(5), &json!(5), &json!(5)));
    assert_eq!(statuses(&table), ["succeeded"; 5]);
    assert_eq!(table["rows"][4]["point"], json!({ "/operation/speed_rpm": 6000.0 }));
    assert!(table["rows"][0]["metrics"]["channels"]["spindle.y.velocity"]["rms"].is_number());
    assert!(table["rows"][0]["metrics"]["lines"].is_null());
    assert!(table["best"]["/channels/spindle.y.velocity/rms"]["value"].is_number());
    let csv = request(server.address(), "GET", &format!("{path}/table"), &[("Accept", "text/csv")], b"");
    assert_eq!((csv.header("content-type"), csv.body.lines().count()), (Some("text/csv; charset=utf-8"), 6));
    assert!(csv.body.starts_with("/operation/speed_rpm,status,error,"), "{}", csv.body);
    let plot = server.get(&format!("{path}/plots/trend.svg"));
    assert_eq!((plot.status, plot.header("content-type")), (200, Some("image/svg+xml")));
    server.get(&format!("{path}/plots/map.svg")).problem(404);
    server.get(&format!("{path}/metrics")).problem(409);
    server.post(&format!("{path}/resume"), &json!({})).problem(409);
    let deleted = request(server.address(), "DELETE", &path, &[], b"");
    assert_eq!(deleted.status, 204);
    server.get(&format!("{path}/table")).problem(404);
}

#[test]
fn a_point_that_cannot_be_built_is_a_failed_row() {
    let server = start();
    let mut study = study_of(2);
    // Twelve of the larger balls overlap.
    study["axes"] = json!([
        { "path": "/bearing/ball_count", "values": [7, 12] },
        { "path": "/bearing/ball_diameter_mm", "values": [2.778, 4] },
    ]);
    study["scene"]["bearing"] = json!("article-integrated");
    let path = server.submit(&study);
    assert_eq!(server.wait_for(&path, &["succeeded", "failed"])["status"], "succeeded");
    let table = server.get(&format!("{path}/table")).json();
    assert_eq!(statuses(&table), ["succeeded", "succeeded", "succeeded", "failed"]);
    let error = &table["rows"][3]["error"];
    assert_eq!(
        (&error["cause"], &error["errors"][0]["pointer"]),
        (&json!("invalid"), &json!("/scene/bearing/ball_count"))
    );
}

#[test]
fn an_axis_value_that_is_never_valid_is_refused_with_its_pointer() {
    let server = start();
    let mut study = study_of(2);
    study["axes"] = json!([{ "path": "/bearing", "values": ["608", "6250"] }]);
    let refused = server.post("/v1/jobs", &study).problem(422);
    assert_eq!(refused["errors"][0]["pointer"], "/axes/0/values/1");
}

#[test]
fn a_study_above_the_point_limit_is_refused_for_good() {
    let server = start_with(ServerSettings { point_limit: 4, ..ServerSettings::default() });
    let refused = server.post("/v1/jobs", &study_of(5)).problem(422);
    assert_eq!(
        refused["errors"],
        json!([{ "pointer": "/axes", "detail": "a grid of 5 points: at most 4 may be unfinished at a time" }])
    );
    server.submit(&study_of(4));
}

#[test]
fn a_cancelled_study_keeps_its_points_and_can_be_resumed() {
    let server = start();
    let path = server.submit(&study_of(400));
    loop {
        let ended = server.get(&format!("{path}/table")).json()["ended"].as_u64().expect("a count");
        if ended > 20 {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let answer = server.post(&format!("{path}/cancel"), &json!({}));
    assert!([200, 202].contains(&answer.status), "{answer:?}");
    let job = server.wait_for(&path, &["cancelled"]);
    assert_eq!(job["links"]["resume"], format!("{path}/resume"));
    let before = server.get(&format!("{path}/table")).json();
    let ended = before["ended"].as_u64().expect("a count");
    assert!((20..400).contains(&ended), "{ended}");
    assert!(statuses(&before).iter().all(|status| ["succeeded", "cancelled"].contains(status)));
    let resumed = server.post(&format!("{path}/resume"), &json!({}));
    assert_eq!((resumed.status, resumed.header("location")), (202, Some(path.as_str())), "{resumed:?}");
    server.post(&format!("{path}/resume"), &json!({})).problem(409);
    assert_eq!(server.wait_for(&path, &["succeeded"])["progress"], 1.0);
    let after = server.get(&format!("{path}/table")).json();
    assert_eq!(after["succeeded"], 400);
    for (before, after) in before["rows"].as_array().unwrap().iter().zip(after["rows"].as_array().unwrap()) {
        assert!(before["status"] == "cancelled" || before == after, "a point was computed again");
    }
}

/// A lost point runs again although the study has succeeded with the others.
#[test]
fn lost_points_of_a_succeeded_study_can_be_resumed() {
    let server = start();
    let path = server.submit(&study_of(3));
    server.wait_for(&path, &["succeeded"]);
    server.post(&format!("{path}/resume"), &json!({})).problem(409);
    let whole = server.get(&format!("{path}/table")).json();
    let lost = "UPDATE points SET status = 'failed', cause = 'worker-lost', content_hash = NULL WHERE number = 1";
    server.sql(lost, lost);
    assert_eq!(server.post(&format!("{path}/resume"), &json!({})).status, 202);
    server.wait_for(&path, &["succeeded"]);
    let again = server.get(&format!("{path}/table")).json();
    assert_eq!(again["succeeded"], 3);
    assert_eq!(again["rows"][1]["metrics"]["channels"], whole["rows"][1]["metrics"]["channels"]);
}

/// A single job does not wait for the end of a study that keeps every worker busy.
#[test]
fn single_jobs_go_before_studies() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let study = server.submit(&study_of(900));
    server.wait_for(&study, &["running"]);
    let single = server.submit(&job());
    server.wait_for(&single, &["succeeded"]);
    assert_eq!(server.get(&study).json()["status"], "running");
    let (other, last) = (server.submit(&study_of(3)), server.submit(&job_with(json!({ "priority": 4 }))));
    server.wait_for(&other, &["succeeded"]);
    server.wait_for(&last, &["succeeded"]);
    server.post(&format!("{study}/cancel"), &json!({}));
    server.wait_for(&study, &["cancelled", "succeeded"]);
}

#[test]
fn points_reuse_identical_finished_work() {
    let server = start();
    let first = server.submit(&study_of(4));
    server.wait_for(&first, &["succeeded"]);
    let rows = |path: &str| server.get(&format!("{path}/table")).json()["rows"].clone();
    let again = server.submit(&study_of(4));
    assert_eq!(server.wait_for(&again, &["succeeded"])["reused"], false);
    let (a, b) = (rows(&first), rows(&again));
    for (a, b) in a.as_array().unwrap().iter().zip(b.as_array().unwrap()) {
        assert_eq!((&a["reused"], &b["reused"], &a["metrics"]), (&json!(false), &json!(true), &b["metrics"]));
    }
    let mut afresh = study_of(4);
    afresh["reuse"] = json!(false);
    let afresh = server.submit(&afresh);
    server.wait_for(&afresh, &["succeeded"]);
    assert!(rows(&afresh).as_array().unwrap().iter().all(|row| row["reused"] == false));
}

/// The reused simulation was submitted as a single job.
#[test]
fn a_point_reuses_a_simulation_of_the_same_work() {
    let server = start();
    let timed = |fields: Value| {
        let mut job = job_with(fields);
        (job["settle_s"], job["duration_s"]) = (json!(0.0), json!(0.001));
        job
    };
    let alone = server.submit(&timed(json!({})));
    server.wait_for(&alone, &["succeeded"]);
    let mut study = timed(json!({}));
    let speed = study["scene"]["operation"]["speed_rpm"].clone();
    study["kind"] = json!("study");
    study["axes"] = json!([{ "path": "/operation/speed_rpm", "values": [speed, 4321] }]);
    let rows = |path: &str| {
        server.wait_for(path, &["succeeded"]);
        server.get(&format!("{path}/table")).json()["rows"].clone()
    };
    let found = rows(&server.submit(&study));
    assert_eq!((&found[0]["reused"], &found[1]["reused"]), (&json!(true), &json!(false)));
    study["reuse"] = json!(false);
    let afresh = rows(&server.submit(&study));
    for part in ["channels", "contacts", "kinematics", "cage", "accuracy", "lines"] {
        assert_eq!(found[0]["metrics"][part], afresh[0]["metrics"][part], "{part}");
    }
}

#[test]
fn only_studies_resume_and_only_queued_ones_wait() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    let slow = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&slow, &["running"]);
    server.post(&format!("{slow}/resume"), &json!({})).problem(409);
    server.get(&format!("{slow}/table")).problem(409);
    let study = server.submit(&study_of(3));
    assert_eq!(server.get(&study).json()["status"], "queued");
    assert_eq!(server.post(&format!("{study}/cancel"), &json!({})).status, 200);
    assert_eq!(server.get(&study).json()["status"], "cancelled");
    server.post(&format!("{slow}/cancel"), &json!({}));
    assert_eq!(server.post(&format!("{study}/resume"), &json!({})).status, 202);
    server.wait_for(&study, &["succeeded"]);
}

#[test]
fn a_table_that_changed_has_another_tag() {
    let server = start();
    let path = server.submit(&study_of(3));
    server.wait_for(&path, &["succeeded"]);
    let table = |tag: &str| {
        let headers = [("Accept", "text/csv"), ("If-None-Match", tag)];
        request(server.address(), "GET", &format!("{path}/table"), &headers, b"")
    };
    let first = table("\"none\"");
    let tag = first.header("etag").expect("a tag").to_owned();
    assert_eq!(first.header("cache-control"), Some("private, no-cache"));
    assert_eq!(table(&tag).status, 304);
    let fail = "UPDATE points SET status = 'failed', cause = 'time-limit', digest = NULL WHERE number = 1; \
                UPDATE studies SET succeeded = 2";
    server.sql(fail, fail);
    assert_eq!(server.post(&format!("{path}/resume"), &json!({})).status, 202);
    server.wait_for(&path, &["succeeded"]);
    let second = table(&tag);
    assert_eq!(second.status, 200);
    assert_ne!(second.header("etag"), Some(tag.as_str()));
}

#[test]
fn a_study_that_is_cancelled_while_it_waits_keeps_its_retention() {
    let server = start_with(ServerSettings { workers: 1, ..ServerSettings::default() });
    server.wait_for(&server.submit(&job_with(json!({ "labels": ["slow"] }))), &["running"]);
    let mut study = study_of(2);
    study["keep_for_s"] = json!(5);
    let path = server.submit(&study);
    let cancelled = request(server.address(), "POST", &format!("{path}/cancel"), &[], b"").json();
    let time = |field: &str| cancelled[field].as_str().and_then(|time| time.parse::<jiff::Timestamp>().ok());
    let (end, expiry) = (time("finished_at").expect("an end"), time("expires_at").expect("an expiry"));
    assert_eq!(expiry.duration_since(end).as_secs(), 5);
}
