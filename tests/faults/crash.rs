//! A job survives its process.

use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::common::{Process, Server, job_with};

/// A run that takes some seconds.
fn long_job() -> serde_json::Value {
    let mut job = job_with(json!({ "settle_s": 0.0, "duration_s": 0.1, "reuse": false }));
    // Without a load the balls knock, and without settling time the run is repeated several times.
    job["scene"]["operation"]["radial_load_y_n"] = json!(100);
    job
}

/// A short run.
fn short_job() -> serde_json::Value {
    job_with(json!({ "settle_s": 0.0, "duration_s": 0.001, "reuse": false }))
}

#[test]
fn an_accepted_job_ends_once_although_its_process_is_killed() {
    let place = tempfile::tempdir().expect("a directory");
    let database = place.path().join("raceway.db");
    let server = Process::serve(&database, &["--workers", "1"]);
    let running = server.submit(&long_job());
    server.wait_for(&running, &["running"]);
    let waiting: Vec<String> = (0..5).map(|_| server.submit(&short_job())).collect();
    server.kill();

    let server = Process::serve(&database, &["--workers", "2"]);
    for path in waiting.iter().chain([&running]) {
        let job = server.wait_for(path, &["succeeded", "failed", "cancelled"]);
        assert_eq!(job["status"], "succeeded", "{job}");
        assert_eq!(server.get(&format!("{path}/metrics")).status, 200);
    }
    assert_eq!(server.get("/v1/jobs").json()["jobs"].as_array().map(Vec::len), Some(6));
}

#[test]
fn a_job_that_is_lost_too_often_fails() {
    let place = tempfile::tempdir().expect("a directory");
    let database = place.path().join("raceway.db");
    let options = ["--workers", "1", "--max-lost-runs", "2"];
    let server = Process::serve(&database, &options);
    let path = server.submit(&job_with(json!({ "settle_s": 0.0, "duration_s": 1.0 })));
    server.wait_for(&path, &["running"]);
    server.kill();
    let server = Process::serve(&database, &options);
    let begin = Instant::now();
    // The last process left the status `running`; progress shows that the new process has claimed the job.
    while server.get(&path).json()["progress"].as_f64() <= Some(0.0) {
        assert!(begin.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(5));
    }
    server.kill();
    let server = Process::serve(&database, &options);
    let job = server.wait_for(&path, &["failed"]);
    assert_eq!(job["error"]["type"], "urn:raceway:problem:worker-lost", "{job}");
}

#[test]
fn a_stopping_service_returns_its_runs_to_the_queue() {
    let place = tempfile::tempdir().expect("a directory");
    let database = place.path().join("raceway.db");
    // One loss would be too many; returning a run is not a loss.
    let options = ["--workers", "1", "--max-lost-runs", "1"];
    let mut server = Process::serve(&database, &options);
    let path = server.submit(&long_job());
    server.wait_for(&path, &["running"]);
    let begin = Instant::now();
    server.signal("-TERM");
    let status = server.child.wait().expect("the process ends");
    assert!(status.success() && begin.elapsed() < Duration::from_secs(5), "{status} after {:?}", begin.elapsed());
    assert!(!place.path().join("raceway.db-wal").exists(), "the log is in the database file");
    let server = Process::serve(&database, &options);
    assert_eq!(server.wait_for(&path, &["succeeded", "failed"])["status"], "succeeded");
}

#[test]
fn a_cancellation_survives_the_process() {
    let place = tempfile::tempdir().expect("a directory");
    let database = place.path().join("raceway.db");
    let server = Process::serve(&database, &["--workers", "1"]);
    let running = server.submit(&long_job());
    server.wait_for(&running, &["running"]);
    let waiting = server.submit(&short_job());
    assert_eq!(server.post(&format!("{waiting}/cancel"), &json!({})).status, 200);
    assert_eq!(server.post(&format!("{running}/cancel"), &json!({})).status, 202);
    server.kill();
    let server = Process::serve(&database, &["--workers", "1"]);
    assert_eq!(server.wait_for(&running, &["cancelled", "succeeded"])["status"], "cancelled");
    assert_eq!(server.get(&waiting).json()["status"], "cancelled");
}

#[test]
fn two_servers_do_not_share_a_database() {
    let place = tempfile::tempdir().expect("a directory");
    let database = place.path().join("raceway.db");
    let first = Process::serve(&database, &[]);
    // Also by another name of the file.
    let (hard, soft) = (place.path().join("hard.db"), place.path().join("soft.db"));
    std::fs::hard_link(&database, &hard).expect("a link");
    std::os::unix::fs::symlink(&database, &soft).expect("a link");
    for name in [&database, &hard, &soft] {
        let url = format!("sqlite://{}", name.display());
        let second = Process::command(&["serve", "--listen", "127.0.0.1:0", "--database", &url])
            .stdout(Stdio::piped())
            .output()
            .expect("the program starts");
        assert!(!second.status.success());
        let stderr = String::from_utf8_lossy(&second.stderr);
        assert!(stderr.contains("another server uses the database"), "{stderr}");
        assert!(second.stdout.is_empty());
    }
    assert_eq!(first.get("/health/ready").status, 200);
}

#[test]
fn no_job_is_accepted_into_a_removed_database_file() {
    let place = tempfile::tempdir().expect("a directory");
    let [database, aside] = ["raceway.db", "aside.db"].map(|name| place.path().join(name));
    let server = Process::serve(&database, &["--workers", "1"]);
    let kept = server.submit(&short_job());
    server.wait_for(&kept, &["succeeded"]);
    std::fs::rename(&database, &aside).expect("it can be moved");
    for replaced in [false, true] {
        if replaced {
            std::fs::write(&database, b"something else").expect("it can be written");
        }
        let refused = server.post("/v1/jobs", &long_job()).problem(503);
        assert_eq!(refused["type"], "urn:raceway:problem:database-away");
        let ready = server.get("/health/ready").problem(503);
        assert!(
            ready["detail"].as_str().is_some_and(|detail| detail.contains("moved, removed or replaced")),
            "{ready}"
        );
    }
    std::fs::rename(&aside, &database).expect("it can be moved back");
    assert_eq!(server.get("/health/ready").status, 200);
    assert_eq!(server.post("/v1/jobs", &long_job()).status, 202);
}

/// The table without measured times.
fn timeless(mut table: serde_json::Value) -> serde_json::Value {
    for row in table["rows"].as_array_mut().expect("rows") {
        row["reused"] = json!(false);
        for field in ["wall_time_s", "real_time_factor"] {
            row["metrics"]["solver"][field] = json!(0);
        }
    }
    table
}

/// A study that is cancelled, resumed, and killed three times has the same table as an undisturbed one.
#[test]
fn a_study_survives_kills_with_the_same_table() {
    let place = tempfile::tempdir().expect("a directory");
    let database = place.path().join("raceway.db");
    let options = ["--workers", "2", "--max-lost-runs", "100"];
    let study = json!({
        "kind": "study", "reuse": false, "settle_s": 0.0, "duration_s": 0.001,
        "scene": { "bearing": "608", "operation": { "speed_rpm": 3000 } },
        "outputs": { "metrics": ["vibration"] },
        "axes": [
            { "path": "/operation/speed_rpm", "from": 3000, "to": 9000, "count": 20 },
            { "path": "/bearing/radial_clearance_um", "from": 2, "to": 12, "count": 20 },
        ],
    });
    let table = |server: &Process, path: &str| server.get(&format!("{path}/table")).json();
    let mut server = Process::serve(&database, &options);
    let path = server.submit(&study);
    let reach = |server: &Process, ended: u64| {
        let begin = Instant::now();
        while table(server, &path)["ended"].as_u64() < Some(ended) {
            assert!(begin.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    reach(&server, 30);
    server.post(&format!("{path}/cancel"), &json!({}));
    server.wait_for(&path, &["cancelled"]);
    assert_eq!(server.post(&format!("{path}/resume"), &json!({})).status, 202);
    for ended in [60, 120, 200] {
        reach(&server, ended);
        server.kill();
        server = Process::serve(&database, &options);
        assert!(table(&server, &path)["ended"].as_u64() >= Some(ended));
    }
    assert_eq!(server.wait_for(&path, &["succeeded", "failed", "cancelled"])["status"], "succeeded");
    let undisturbed = server.submit(&study);
    server.wait_for(&undisturbed, &["succeeded"]);
    let (disturbed, undisturbed) = (timeless(table(&server, &path)), timeless(table(&server, &undisturbed)));
    assert_eq!(disturbed["succeeded"], 400);
    assert_eq!(disturbed, undisturbed);
}
