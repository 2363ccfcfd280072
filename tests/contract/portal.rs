//! The page at `/` and its files.

use crate::common::{Answer, Server, request};
use crate::server::{ServerSettings, start_with};

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

fn send(server: &impl Server, method: &str, path: &str, headers: &[(&str, &str)]) -> Answer {
    request(server.address(), method, path, headers, b"")
}

/// Files that a page or a module names, as paths from the root.
fn named_in(text: &str) -> Vec<String> {
    let absolute = text.split('"').filter(|word| word.starts_with("/portal/")).map(str::to_owned);
    let imported = text.lines().filter(|line| line.starts_with("import ")).filter_map(|line| line.split("'./").nth(1));
    let relative = imported.filter_map(|rest| rest.split('\'').next()).map(|name| format!("/portal/{name}"));
    absolute.chain(relative).collect()
}

#[test]
fn the_page_and_every_file_it_names_answer_without_a_token() {
    let server = start_with(ServerSettings { tokens: "alpha", ..ServerSettings::default() });
    let mut waiting = vec!["/".to_owned()];
    let mut seen = Vec::new();
    while let Some(path) = waiting.pop() {
        if seen.contains(&path) {
            continue;
        }
        let answer = send(&server, "GET", &path, &[]);
        assert_eq!(answer.status, 200, "{path}");
        let expected = match path.rsplit_once('.').map(|(_, ending)| ending) {
            Some("js") => SCRIPT,
            Some("css") => "text/css; charset=utf-8",
            Some("svg") => "image/svg+xml",
            _ => HTML,
        };
        assert_eq!(answer.header("content-type"), Some(expected), "{path}");
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"), "{path}");
        let policy = answer.header("content-security-policy").expect("every file has a policy");
        assert!(policy.starts_with("default-src 'self';") && !policy.contains("unsafe"), "{policy}");
        waiting.extend(named_in(&answer.body));
        seen.push(path);
    }
    assert!(seen.len() > 10, "{seen:?}");
    assert_eq!(send(&server, "GET", "/portal/vendor/LICENSE", &[]).status, 200);
}

#[test]
fn the_page_has_no_inline_code() {
    let server = start_with(ServerSettings::default());
    let page = send(&server, "GET", "/", &[]).body;
    assert!(page.contains("<title>raceway</title>"));
    for inline in ["<style", " style=", " onclick=", "javascript:", "http://", "https://"] {
        assert!(!page.contains(inline), "{inline}");
    }
    assert_eq!(page.matches("<script").count(), page.matches("<script type=\"module\" src=\"/portal/").count());
}

#[test]
fn a_file_that_the_browser_has_is_answered_by_304() {
    let server = start_with(ServerSettings::default());
    let first = send(&server, "GET", "/portal/main.js", &[]);
    let tag = first.header("etag").expect("a tag").to_owned();
    assert!(tag.starts_with('"') && first.header("cache-control") == Some("no-cache"), "{first:?}");
    for known in [tag.clone(), format!("\"other\", W/{tag}"), "*".to_owned()] {
        let again = send(&server, "GET", "/portal/main.js", &[("If-None-Match", &known)]);
        assert!(again.status == 304 && again.body.is_empty(), "{again:?}");
        assert_eq!(again.header("etag"), Some(tag.as_str()));
    }
    assert_eq!(send(&server, "GET", "/portal/main.js", &[("If-None-Match", "\"other\"")]).status, 200);
    assert_ne!(send(&server, "GET", "/portal/api.js", &[]).header("etag"), Some(tag.as_str()));
}

#[test]
fn the_page_accepts_only_get_and_head() {
    let server = start_with(ServerSettings { tokens: "alpha", ..ServerSettings::default() });
    for path in ["/", "/portal/main.js"] {
        let head = send(&server, "HEAD", path, &[]);
        assert!(head.status == 200 && head.body.is_empty(), "{head:?}");
        assert!(head.header("content-type").is_some() && head.header("etag").is_some(), "{head:?}");
        for method in ["POST", "PUT", "DELETE"] {
            let refused = send(&server, method, path, &[]);
            refused.problem(405);
            assert!(refused.header("allow").is_some_and(|allowed| allowed.contains("GET")), "{refused:?}");
        }
    }
    for path in ["/portal/", "/portal/no-such-file", "/portal/../Cargo.toml", "/portal/%ff"] {
        send(&server, "GET", path, &[]).problem(404);
    }
}
