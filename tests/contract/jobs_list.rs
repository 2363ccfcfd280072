//! `GET /v1/jobs`.

use serde_json::{Value, json};

use crate::common::{Server, job_with};
use crate::server::start;

fn ids(list: &Value) -> Vec<String> {
    let jobs = list["jobs"].as_array().expect("a list").iter();
    jobs.map(|job| job["id"].as_str().expect("an id").to_owned()).collect()
}

#[test]
fn pages_follow_each_other_newest_first() {
    let server = start();
    let submit = |label: &str| server.submit(&job_with(json!({ "labels": ["fail", label], "reuse": false })));
    let paths: Vec<String> = (0..5).map(|number| submit(&format!("a & {}", number % 2))).collect();
    let newest_first: Vec<String> = paths.iter().rev().map(|path| path.replace("/v1/jobs/", "")).collect();
    let all = server.get("/v1/jobs");
    assert_eq!(ids(&all.json()), newest_first);
    assert!(all.json()["next"].is_null() && all.header("link").is_none());
    let mut seen = Vec::new();
    let mut path = "/v1/jobs?limit=2".to_owned();
    loop {
        let page = server.get(&path);
        seen.extend(ids(&page.json()));
        let Some(next) = page.json()["next"].as_str().map(str::to_owned) else { break };
        assert_eq!(page.header("link"), Some(format!("<{next}>; rel=\"next\"").as_str()));
        path = next;
    }
    assert_eq!(seen, newest_first);
    let labelled = server.get("/v1/jobs?label=a%20%26%201&limit=1").json();
    assert_eq!(ids(&labelled), newest_first[1..2]);
    let next = labelled["next"].as_str().expect("another page");
    assert_eq!(ids(&server.get(next).json()), newest_first[3..4]);
}

#[test]
fn filters_choose() {
    let server = start();
    let failed = server.submit(&job_with(json!({ "labels": ["fail"] })));
    let running = server.submit(&job_with(json!({ "labels": ["slow"] })));
    server.wait_for(&failed, &["failed"]);
    server.wait_for(&running, &["running"]);
    let count = |query: &str| ids(&server.get(&format!("/v1/jobs?{query}")).json()).len();
    assert_eq!(count("status=failed"), 1);
    assert_eq!(count("status=running"), 1);
    assert_eq!(count("status=succeeded"), 0);
    assert_eq!(count("kind=simulation"), 2);
    assert_eq!(count("kind=study"), 0);
    assert_eq!(count("label=slow&status=running&kind=simulation"), 1);
    for query in
        ["limit=0", "limit=201", "limit=x", "status=done", "kind=race", "cursor=x", "colour=red", "limit=1&limit=2"]
    {
        server.get(&format!("/v1/jobs?{query}")).problem(400);
    }
}
