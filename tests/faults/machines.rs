//! Several processes on one PostgreSQL database. Skipped unless `RACEWAY_TEST_POSTGRES` names a server.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::common::{Process, Server, execute, job_with, postgres_database, request};

/// Settings with which losses are found within two seconds.
const SOON: [&str; 2] = ["--lost-after-s", "1"];

/// A server without workers on its own database; `None` without PostgreSQL.
fn server() -> Option<(String, Process)> {
    let url = postgres_database()?;
    let server = Process::serve_on(&url, &["--listen", "127.0.0.1:0", "--workers", "0", SOON[0], SOON[1]], &[]);
    Some((url, server))
}

fn worker(url: &str) -> Process {
    Process::worker(url, &["--workers", "1", SOON[0], SOON[1]])
}

/// A run of some seconds.
fn long_job(load_n: f64) -> Value {
    let mut job = job_with(json!({ "settle_s": 0.0, "duration_s": 0.1, "reuse": false }));
    job["scene"]["operation"]["radial_load_y_n"] = json!(load_n);
    job
}

fn short_job() -> Value {
    job_with(json!({ "settle_s": 0.0, "duration_s": 0.001, "reuse": false }))
}

/// Metrics without measured times.
fn timeless(server: &Process, path: &str) -> Value {
    let mut metrics = server.get(&format!("{path}/metrics")).json();
    for field in ["wall_time_s", "real_time_factor"] {
        metrics["solver"][field] = json!(0);
    }
    metrics
}

#[test]
fn jobs_wait_for_a_worker_and_are_followed_and_cancelled_from_another_process() {
    let Some((url, server)) = server() else { return };
    let first = server.submit(&short_job());
    assert_eq!(server.get(&first).json()["status"], "queued");
    let _worker = worker(&url);
    assert_eq!(server.wait_for(&first, &["succeeded", "failed"])["status"], "succeeded");
    let headers = [("Content-Type", "application/json"), ("Prefer", "wait=30")];
    let waited = request(server.address(), "POST", "/v1/jobs", &headers, short_job().to_string().as_bytes());
    assert_eq!((waited.status, &waited.json()["status"]), (200, &json!("succeeded")));

    let path = server.submit(&job_with(json!({ "settle_s": 0.0, "duration_s": 100.0 })));
    server.wait_for(&path, &["running"]);
    let begin = Instant::now();
    while server.get(&path).json()["progress"].as_f64() <= Some(0.0) {
        assert!(begin.elapsed() < Duration::from_secs(20), "no progress is seen");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(server.post(&format!("{path}/cancel"), &json!({})).status, 202);
    let begin = Instant::now();
    server.wait_for(&path, &["cancelled"]);
    assert!(begin.elapsed() < Duration::from_secs(5), "a cancellation took {:?}", begin.elapsed());
}

#[test]
fn another_worker_finishes_the_job_of_a_killed_one_with_the_same_bits() {
    let Some((url, server)) = server() else { return };
    let first = worker(&url);
    let undisturbed = server.submit(&long_job(100.0));
    server.wait_for(&undisturbed, &["succeeded"]);
    let path = server.submit(&long_job(100.0));
    server.wait_for(&path, &["running"]);
    first.kill();
    let _second = worker(&url);
    assert_eq!(server.wait_for(&path, &["succeeded", "failed"])["status"], "succeeded");
    assert_eq!(timeless(&server, &path), timeless(&server, &undisturbed));
}

#[test]
fn a_suspended_worker_that_lost_its_claim_changes_nothing() {
    let Some((url, server)) = server() else { return };
    let sleeper = worker(&url);
    let path = server.submit(&long_job(110.0));
    server.wait_for(&path, &["running"]);
    sleeper.signal("-STOP");
    let _other = worker(&url);
    let job = server.wait_for(&path, &["succeeded", "failed"]);
    let result = timeless(&server, &path);
    sleeper.signal("-CONT");
    // The worker continues with its own jobs.
    let later: Vec<String> = (0..4).map(|_| server.submit(&short_job())).collect();
    later.iter().for_each(|path| drop(server.wait_for(path, &["succeeded"])));
    std::thread::sleep(Duration::from_secs(2));
    let now = server.get(&path).json();
    assert_eq!((&now["status"], &now["finished_at"]), (&json!("succeeded"), &job["finished_at"]));
    assert_eq!(timeless(&server, &path), result);
}

#[test]
fn a_job_that_ends_its_workers_fails_and_other_jobs_do_not() {
    let Some(url) = postgres_database() else { return };
    let options = ["--max-lost-runs", "2", SOON[0], SOON[1]];
    let server = Process::serve_on(
        &url,
        &["--listen", "127.0.0.1:0", "--workers", "0", options[0], options[1], options[2], options[3]],
        &[],
    );
    let path = server.submit(&job_with(json!({ "settle_s": 0.0, "duration_s": 100.0 })));
    let mut last = Value::Null;
    for _ in 0..2 {
        let worker = Process::worker(&url, &options);
        let begin = Instant::now();
        // Running under its own claim.
        while [&Value::Null, &last].contains(&&server.get(&path).json()["started_at"]) {
            assert!(begin.elapsed() < Duration::from_secs(20), "it is not taken up again");
            std::thread::sleep(Duration::from_millis(20));
        }
        last = server.get(&path).json()["started_at"].clone();
        worker.kill();
    }
    let _last = Process::worker(&url, &options);
    let job = server.wait_for(&path, &["failed"]);
    assert_eq!(job["error"]["type"], "urn:raceway:problem:worker-lost", "{job}");
    let neighbour = server.submit(&short_job());
    assert_eq!(server.wait_for(&neighbour, &["succeeded", "failed"])["status"], "succeeded");
}

#[test]
fn a_job_without_a_living_worker_can_be_cancelled() {
    let Some((url, server)) = server() else { return };
    let only = worker(&url);
    let job = server.submit(&job_with(json!({ "settle_s": 0.0, "duration_s": 100.0 })));
    server.wait_for(&job, &["running"]);
    only.kill();
    assert_eq!(server.post(&format!("{job}/cancel"), &json!({})).status, 202);
    server.wait_for(&job, &["cancelled"]);

    let mut other = worker(&url);
    let study = server.submit(&json!({
        "kind": "study", "scene": { "bearing": "608", "operation": { "speed_rpm": 3000 } }, "reuse": false,
        "axes": [{ "path": "/operation/speed_rpm", "values": [3000, 4000] }], "settle_s": 0.0, "duration_s": 100.0
    }));
    server.wait_for(&study, &["running"]);
    other.signal("-TERM");
    assert!(other.child.wait().is_ok_and(|status| status.success()));
    assert_eq!(server.post(&format!("{study}/cancel"), &json!({})).json()["status"], "cancelled");
}

/// Simulates a connection that breaks after the server has handed out a delivery.
#[test]
fn a_delivery_that_never_arrived_is_delivered_again() {
    let Some((url, server)) = server() else { return };
    let _worker = worker(&url);
    let first = server.submit(&job_with(json!({ "settle_s": 0.0, "duration_s": 100.0 })));
    server.wait_for(&first, &["running"]);
    let next = server.submit(&short_job());
    execute(
        &url,
        "UPDATE river_job SET state = 'running', attempted_at = now() - INTERVAL '1 minute', \
         attempted_by = (SELECT attempted_by FROM river_job WHERE state = 'running') WHERE state = 'available'",
    );
    assert_eq!(server.post(&format!("{first}/cancel"), &json!({})).status, 202);
    assert_eq!(server.wait_for(&next, &["succeeded", "failed"])["status"], "succeeded");
}

#[test]
fn a_worker_answers_only_probes_and_metrics() {
    let Some((url, server)) = server() else { return };
    let mut worker = Process::probed_worker(&url, &["--workers", "1", SOON[0], SOON[1]]);
    server.wait_for(&server.submit(&short_job()), &["succeeded"]);
    assert_eq!((worker.get("/health/live").status, worker.get("/health/ready").status), (200, 200));
    let figures = |process: &Process| process.get("/metrics").body;
    assert!(figures(&worker).contains("\nraceway_runs_total{end=\"succeeded\"} 1\n"));
    assert!(!figures(&server).contains("raceway_runs_total{"), "the server has run nothing");
    for path in ["/v1/jobs", "/", "/docs/", "/openapi.json"] {
        assert_eq!(worker.get(path).status, 404, "{path}");
    }
    // A token of the service also protects the metrics of its workers, but not their probes.
    let mut token = Process::command(&["token", "create", "--database", &url]);
    assert!(token.status().is_ok_and(|status| status.success()));
    let begin = Instant::now();
    while worker.get("/metrics").status != 401 {
        assert!(begin.elapsed() < Duration::from_secs(20), "the figures are open");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(worker.get("/health/ready").status, 200);
    worker.signal("-TERM");
    assert!(worker.child.wait().is_ok_and(|status| status.success()));
}

#[test]
fn a_study_continues_with_remaining_and_new_workers() {
    let Some((url, server)) = server() else { return };
    let study = json!({
        "kind": "study",
        "scene": { "bearing": "608", "operation": { "speed_rpm": 3000, "radial_load_y_n": 20 } },
        "axes": [{ "path": "/operation/speed_rpm", "from": 3000, "to": 6000, "count": 64 }],
        "outputs": { "metrics": ["vibration"] }, "settle_s": 0.0, "duration_s": 0.002, "reuse": false
    });
    let first = worker(&url);
    let path = server.submit(&study);
    server.wait_for(&path, &["running"]);
    let second = worker(&url);
    let begin = Instant::now();
    while server.get(&path).json()["progress"].as_f64() < Some(0.1) {
        assert!(begin.elapsed() < Duration::from_secs(40), "no point ends");
        std::thread::sleep(Duration::from_millis(5));
    }
    first.kill();
    assert_eq!(server.wait_for(&path, &["succeeded", "failed"])["status"], "succeeded");
    let disturbed = server.get(&format!("{path}/table")).json();
    assert_eq!(disturbed["succeeded"], 64);
    drop(second);
}
