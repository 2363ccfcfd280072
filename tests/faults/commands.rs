//! Commands of the program.

use std::io::Write;
use std::process::{Output, Stdio};

use serde_json::Value;

use crate::common::{Process, Server, job_with};

fn simulate(job: &str, more: &[&str]) -> Output {
    run("simulate", job, more)
}

/// A command that reads a job from stdin.
fn run(command: &str, job: &str, more: &[&str]) -> Output {
    let mut arguments = vec![command, "-"];
    arguments.extend(more);
    let mut child = Process::command(&arguments).stdin(Stdio::piped()).spawn().expect("the program starts");
    child.stdin.take().expect("a pipe").write_all(job.as_bytes()).expect("the job is read");
    child.wait_with_output().expect("the program ends")
}

#[test]
fn simulate_prints_metrics_and_writes_files() {
    let place = tempfile::tempdir().expect("a directory");
    let directory = place.path().join("out").display().to_string();
    let job = job_with(serde_json::json!({ "settle_s": 0.0, "duration_s": 0.002 }));
    let output = simulate(&job.to_string(), &["--output", &directory]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let metrics: Value = serde_json::from_slice(&output.stdout).expect("stdout is JSON and nothing else");
    assert!(metrics["solver"]["steps"].as_u64() > Some(0));
    for file in ["metrics.json", "spectrum.spindle.y.acceleration.csv", "spectrum.svg"] {
        assert!(place.path().join("out").join(file).exists(), "{file}");
    }
}

#[test]
fn the_error_for_an_unwritable_directory_names_it() {
    let place = tempfile::NamedTempFile::new().expect("a file");
    let directory = place.path().join("out").display().to_string();
    // Reported before the run, which would take hours.
    let job = job_with(serde_json::json!({ "duration_s": 1000, "solver": { "rung": "full" } }));
    let output = simulate(&job.to_string(), &["--output", &directory]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(1), true), "{stderr}");
    assert!(stderr.contains(&format!("cannot write {directory}: ")) && !stderr.contains("estimated"), "{stderr}");
}

#[test]
fn a_refused_job_exits_with_2_and_prints_its_problem() {
    let output = simulate(r#"{"kind":"simulation","scene":{"bearing":"nope","operation":{"speed_rpm":1}}}"#, &[]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty());
    let problem: Value = serde_json::from_slice(&output.stderr).expect("stderr is a problem");
    assert!(problem["errors"][0]["pointer"].is_string(), "{problem}");
}

#[test]
fn accuracy_prints_a_table_and_writes_json_and_svg() {
    let place = tempfile::tempdir().expect("a directory");
    let directory = place.path().display().to_string();
    let request = serde_json::json!({ "scene": job_with(serde_json::json!({}))["scene"], "settle_s": 0, "duration_s": 0.001,
        "methods": ["dormand_prince"], "relative_tolerances": [1e-3, 1e-5] });
    let output = run("accuracy", &request.to_string(), &["--output", &directory, "--repetitions", "2"]);
    let table = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    for words in
        ["method", "rtol", "reference radau at 1e-11", "dormand_prince", "1e-5", "succeeded", "median and range of 2"]
    {
        assert!(table.contains(words), "{words}: {table}");
    }
    let written = std::fs::read_to_string(place.path().join("accuracy.json")).expect("the JSON is there");
    let answer: Value = serde_json::from_str(&written).expect("it is JSON");
    assert_eq!(answer["points"].as_array().map(Vec::len), Some(2));
    let svg = std::fs::read_to_string(place.path().join("work-precision.svg")).expect("the plot is there");
    assert!(svg.starts_with("<svg"));
    // The written job can be run again.
    let again = run("accuracy", &answer["repeat"]["job"].to_string(), &["--output", &directory]);
    assert_eq!(again.status.code(), Some(0), "{again:?}");
}

#[test]
fn accuracy_refuses_a_simulation() {
    let place = tempfile::tempdir().expect("a directory");
    let directory = place.path().display().to_string();
    let output = run("accuracy", &job_with(serde_json::json!({})).to_string(), &["--output", &directory]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let problem: Value = serde_json::from_slice(&output.stderr).expect("stderr is a problem");
    assert_eq!(problem["errors"][0]["pointer"], "/kind");
    assert_eq!(place.path().read_dir().expect("a directory").count(), 0);
}

#[test]
fn health_reports_by_its_exit_status() {
    let place = tempfile::tempdir().expect("a directory");
    let server = Process::serve(&place.path().join("a.db"), &[]);
    let listen = server.address().to_owned();
    let health = || Process::command(&["health", "--listen", &listen]).output().expect("the program starts");
    assert!(health().status.success(), "{:?}", health());
    server.kill();
    assert_eq!(health().status.code(), Some(1));
}

#[test]
fn the_document_is_printed() {
    let output = Process::command(&["openapi"]).output().expect("the program starts");
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(document["info"]["title"], "raceway");
}
