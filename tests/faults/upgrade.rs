//! Databases of the previous release: they are opened, their waiting jobs end, their results can be read.

use std::io::Read;
use std::path::Path;

use serde_json::Value;

use crate::common::{Process, Server, execute, postgres_database, request};

/// A file that the release at commit 96b61de left when it was killed, compressed: an ended simulation, study and optimum, a running
/// simulation and a waiting one. The jobs are kept for ten years.
const FILE: &[u8] = include_bytes!("previous/96b61de.db.gz");
/// The same without the optimum, from a server (`pg_dump --inserts`), compressed.
const DUMP: &[u8] = include_bytes!("previous/96b61de.sql.gz");

fn decompressed(bytes: &[u8]) -> Vec<u8> {
    let mut content = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut content).expect("the file is compressed");
    content
}

fn check(database: &str) -> (Option<i32>, String) {
    let output = Process::command(&["check", "--database", database]).output().expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

fn jobs(server: &Process, query: &str) -> Vec<Value> {
    server.get(&format!("/v1/jobs?{query}")).json()["jobs"].as_array().expect("a list").clone()
}

fn assert_upgraded(database: &str) {
    let server = Process::serve_on(database, &["--listen", "127.0.0.1:0"], &[]);
    let kept = jobs(&server, "label=kept&kind=simulation");
    let [simulation] = kept.as_slice() else { panic!("{kept:?}") };
    for name in ["metrics", "spectrum", "series", "spectrum_svg", "orbit_svg"] {
        let path = simulation["links"][name].as_str().expect("a link");
        assert_eq!(server.get(path).status, 200, "{path}");
    }
    let level = server.get(simulation["links"]["metrics"].as_str().expect("a link")).json();
    assert!(level["channels"]["spindle.y.acceleration"]["level_db"].is_number(), "{level}");
    let study = &jobs(&server, "kind=study&label=kept&status=succeeded")[0];
    let table = server.get(study["links"]["table"].as_str().expect("a link")).json();
    assert_eq!(table["rows"].as_array().map(Vec::len), Some(2), "{table}");
    let optima = jobs(&server, "kind=optimum");
    for optimum in &optima {
        assert!(server.get(optimum["links"]["optimum"].as_str().expect("a link")).json()["value"].is_number());
    }
    for label in ["running", "waiting"] {
        let unfinished = &jobs(&server, &format!("label={label}"))[0];
        server.wait_for(unfinished["links"]["self"].as_str().expect("a link"), &["succeeded"]);
    }
    // The key of the previous release still stands for its job.
    let keyed = jobs(&server, "kind=simulation&without_label=kept&without_label=running&without_label=waiting");
    let key = [("Content-Type", "application/json"), ("Idempotency-Key", "before")];
    let again = request(server.address(), "POST", "/v1/jobs", &key, keyed[0]["request"].to_string().as_bytes());
    assert_eq!((again.header("idempotent-replayed"), &again.json()["id"]), (Some("true"), &keyed[0]["id"]));
    let (status, listed) = check(database);
    assert_eq!(status, Some(0), "{listed}");
    // The requests of four simulations, the study and an optimum in the file.
    assert_eq!(listed.matches("without digest").count(), 5 + optima.len(), "{listed}");
}

#[test]
fn a_file_of_the_previous_release_is_upgraded() {
    let place = tempfile::tempdir().expect("a directory");
    let path = place.path().join("raceway.db");
    std::fs::write(&path, decompressed(FILE)).expect("the file is written");
    assert_upgraded(&url_of(&path));
}

fn url_of(path: &Path) -> String {
    format!("sqlite://{}", path.display())
}

#[test]
fn a_server_of_the_previous_release_is_upgraded() {
    let Some(database) = postgres_database() else { return };
    execute(&database, &String::from_utf8(decompressed(DUMP)).expect("SQL is text"));
    assert_upgraded(&database);
}
