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
fn filters_select_jobs() {
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
    let many = ["label=x"; 17].join("&");
    server.get(&format!("/v1/jobs?{many}")).problem(400);
    let detail = |query: &str| server.get(&format!("/v1/jobs?{query}")).problem(400)["detail"].clone();
    assert_eq!(detail("limit=x"), "query: limit: must be a whole number");
    assert!(detail("status=done").as_str().is_some_and(|detail| detail.contains("unknown value `done`")));
    assert!(detail("colour=red").as_str().is_some_and(|detail| detail.contains("unknown parameter `colour`")));
}

#[test]
fn several_labels_kinds_and_statuses_select_jobs() {
    let server = start();
    let submit = |labels: Value| server.submit(&job_with(json!({ "labels": labels, "reuse": false })));
    let failed = submit(json!(["fail", "a, b", "é"]));
    let running = submit(json!(["slow", "a, b"]));
    let waiting = submit(json!(["slow", "a"]));
    server.wait_for(&failed, &["failed"]);
    server.wait_for(&running, &["running"]);
    server.wait_for(&waiting, &["running", "queued"]);
    let found = |query: &str| {
        let mut paths: Vec<String> = ids(&server.get(&format!("/v1/jobs?{query}")).json());
        paths.iter_mut().for_each(|id| *id = format!("/v1/jobs/{id}"));
        paths
    };
    let all = vec![waiting.clone(), running.clone(), failed.clone()];
    assert_eq!(found("status=failed&status=running&status=queued"), all);
    assert_eq!(found("kind=study&kind=simulation"), all);
    assert_eq!(found("kind=study&kind=optimum"), Vec::<String>::new());
    assert_eq!(found("label=slow&label=a%2C%20b"), std::slice::from_ref(&running));
    assert_eq!(found("label=slow&label=fail"), Vec::<String>::new());
    assert_eq!(found("without_label=slow"), std::slice::from_ref(&failed));
    assert_eq!(found("label=a%2C+b&without_label=%C3%A9&without_label=a"), [running]);
    assert_eq!(found("without_label=a&without_label=a%2C%20b"), Vec::<String>::new());
    // The next page has the same filters.
    let page = server.get("/v1/jobs?label=slow&without_label=x%26y&status=running&status=queued&limit=1").json();
    let next = page["next"].as_str().expect("another page");
    assert!(next.contains("&status=running&status=queued&label=slow&without_label=x%26y"), "{next}");
    assert_eq!(ids(&server.get(next).json()).len(), 1);
}
