//! Starts with wrong settings, and logs.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::Value;

use crate::common::{Process, Server, job_with};

fn refused(arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let place = tempfile::tempdir().expect("a directory");
    let output = Process::command(arguments)
        .envs(environment.iter().copied())
        .current_dir(place.path())
        .output()
        .expect("the program starts");
    assert!(!output.status.success(), "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn tokens_are_required_beyond_loopback() {
    for listen in ["0.0.0.0:0", "[::]:0"] {
        let stderr = refused(&["serve", "--listen", listen], &[]);
        assert!(stderr.contains("RACEWAY_API_TOKENS") && stderr.contains("--insecure-no-auth"), "{stderr}");
    }
    refused(&["serve"], &[("RACEWAY_LISTEN", "0.0.0.0:0")]);
}

#[test]
fn invalid_settings_are_refused() {
    for tokens in ["", " , "] {
        let stderr = refused(&["serve", "--listen", "127.0.0.1:0"], &[("RACEWAY_API_TOKENS", tokens)]);
        assert!(stderr.contains("holds no token"), "{stderr}");
    }
    let stderr = refused(&["serve", "--listen", "127.0.0.1:0"], &[("RACEWAY_LOG", "loud")]);
    assert!(stderr.contains("loud") && stderr.contains("error, warn, info, debug or trace"), "{stderr}");
    let stderr = refused(&["serve", "--listen", "127.0.0.1:0"], &[("RACEWAY_LOG_FORMAT", "xml")]);
    assert!(stderr.contains("xml") && stderr.contains("text or json"), "{stderr}");
    for no in ["0", "false"] {
        let environment = [("RACEWAY_INSECURE_NO_AUTH", no)];
        assert!(refused(&["serve", "--listen", "0.0.0.0:0"], &environment).contains("RACEWAY_API_TOKENS"));
    }
    refused(&["serve", "--listen", "0.0.0.0:0"], &[("RACEWAY_INSECURE_NO_AUTH", "perhaps")]);
}

#[test]
fn the_service_can_be_stopped_as_soon_as_it_listens() {
    for signal in ["-TERM", "-INT"] {
        let place = tempfile::tempdir().expect("a directory");
        let mut server = Process::serve(&place.path().join("a.db"), &[]);
        server.signal(signal);
        assert!(server.child.wait().is_ok_and(|status| status.success()), "{signal}");
    }
}

#[test]
fn logs_in_a_file_have_no_colours() {
    let environment = [("RACEWAY_INSECURE_NO_AUTH", "1"), ("RACEWAY_LOG", "warn")];
    let database = "sqlite:///no/such/directory/raceway.db";
    let stderr = refused(&["serve", "--listen", "0.0.0.0:0", "--database", database], &environment);
    assert!(stderr.contains("WARN") && !stderr.contains('\u{1b}'), "{stderr}");
}

#[test]
fn json_logs_have_one_object_per_line() {
    let environment = [("RACEWAY_INSECURE_NO_AUTH", "1"), ("RACEWAY_LOG_FORMAT", "json")];
    let database = "sqlite:///no/such/directory/raceway.db";
    let stderr = refused(&["serve", "--listen", "0.0.0.0:0", "--database", database], &environment);
    let line: Value = serde_json::from_str(stderr.lines().next().expect("a line")).expect("an object");
    assert!(line["level"] == "WARN" && line["listen"] == "0.0.0.0:0" && line["message"].is_string(), "{stderr}");
}

/// The log of a session: its address, its runs, and its stop.
#[test]
fn a_session_is_logged_in_a_few_lines() {
    let place = tempfile::tempdir().expect("a directory");
    let database = format!("sqlite://{}", place.path().join("a.db").display());
    let mut command =
        Process::command(&["serve", "--listen", "127.0.0.1:0", "--workers", "1", "--database", &database]);
    let mut child = command.env("RACEWAY_LOG_FORMAT", "json").spawn().expect("the program starts");
    let mut line = String::new();
    let stdout = child.stdout.take().expect("stdout is a pipe");
    BufReader::new(stdout).read_line(&mut line).expect("the program says that it is there");
    let stderr = child.stderr.take().expect("stderr is a pipe");
    let server = Process { child, address: line.trim().trim_start_matches("listening on http://").to_owned() };
    let path = server.submit(&job_with(serde_json::json!({ "settle_s": 0.0, "duration_s": 0.001 })));
    server.wait_for(&path, &["succeeded"]);
    server.signal("-TERM");
    let lines = BufReader::new(stderr).lines().map_while(Result::ok);
    let lines: Vec<Value> = lines.map(|line| serde_json::from_str(&line).expect("an object")).collect();
    let said: Vec<&str> = lines.iter().filter_map(|line| line["message"].as_str()).collect();
    assert_eq!(said, ["serving", "a run has succeeded", "stopping; running jobs go back into the queue", "stopped"]);
    let (start, run) = (&lines[0], &lines[1]);
    assert_eq!(
        (&start["version"], &start["database"]),
        (&env!("CARGO_PKG_VERSION").into(), &"SQLite".into()),
        "{start}"
    );
    assert!(start["address"] == format!("http://{}", server.address).as_str() && start["workers"] == 1, "{start}");
    assert!(path.ends_with(run["job"].as_str().expect("an id")) && run["rung"].is_string(), "{run}");
    assert!(run["seconds"].is_f64() && lines.iter().all(|line| line.get("spans").is_none()), "{run}");
}

#[test]
fn with_tokens_or_insecure_no_auth_the_service_listens_on_all_interfaces() {
    let place = tempfile::tempdir().expect("a directory");
    let open = ["--listen", "0.0.0.0:0", "--insecure-no-auth"];
    let server = Process::serve_with(&place.path().join("a.db"), &open, &[]);
    assert_eq!(server.get("/v1/presets").status, 200);
    let closed = ["--listen", "0.0.0.0:0"];
    let token = [("RACEWAY_API_TOKENS", "a-token-of-this-test")];
    let server = Process::serve_with(&place.path().join("b.db"), &closed, &token);
    server.get("/v1/presets").problem(401);
    let guessed = refused(&["serve", "--listen", "0.0.0.0:0"], &[("RACEWAY_API_TOKENS", "alpha,a-token-of-this-test")]);
    assert!(guessed.contains("fewer than 16 characters") && !guessed.contains("alpha"), "{guessed}");
}

#[test]
fn errors_of_unusable_databases_name_them_without_secrets() {
    // No server listens on port 1.
    let url = "postgres://me:secret@127.0.0.1:1/db";
    for command in [&["serve", "--listen", "127.0.0.1:0", "--database", url][..], &["worker", "--database", url]] {
        let stderr = refused(command, &[]);
        assert!(stderr.contains("cannot open the database postgres://127.0.0.1:1/db"), "{stderr}");
        assert!(!stderr.contains("secret"), "{stderr}");
    }
    refused(&["serve", "--database", "raceway.db"], &[]);
    assert!(refused(&["worker", "--database", "sqlite://raceway.db"], &[]).contains("a file serves one process"));
    let alone = refused(&["serve", "--listen", "127.0.0.1:0", "--workers", "0"], &[]);
    assert!(alone.contains("--workers 0") && alone.contains("postgres://"), "{alone}");
}

#[test]
fn a_database_that_cannot_be_opened_is_named() {
    let place = tempfile::tempdir().expect("a directory");
    let file = place.path().join("no.db");
    std::fs::write(&file, "no database at all, whatever its name says".repeat(100)).expect("a file is written");
    for path in ["/no/such/directory/raceway.db", &file.display().to_string()] {
        let url = format!("sqlite://{path}");
        let stderr = refused(&["serve", "--listen", "127.0.0.1:0", "--database", &url], &[]);
        assert!(stderr.contains(&format!("cannot open the database {path}: ")), "{stderr}");
    }
}

#[test]
fn tokens_are_never_shown() {
    let stderr = refused(
        &["serve", "--listen", "0.0.0.0:0", "--database", "sqlite:///no/such/directory/x.db"],
        &[("RACEWAY_API_TOKENS", "a-secret-token"), ("RACEWAY_LOG", "trace")],
    );
    assert!(!stderr.contains("a-secret-token"), "{stderr}");
}

#[test]
fn an_incomplete_request_delays_no_other() {
    let place = tempfile::tempdir().expect("a directory");
    let server = Process::serve(&place.path().join("a.db"), &[]);
    let mut lazy: Vec<TcpStream> = (0..50)
        .map(|_| {
            let mut stream = TcpStream::connect(server.address()).expect("the server listens");
            stream.write_all(b"GET /v1/jobs HTTP/1.1\r\nHost: local").expect("half a header is read");
            stream
        })
        .collect();
    assert_eq!(server.get("/health/live").status, 200);
    server.signal("-TERM");
    // A stopping service does not wait for the rest of the request.
    lazy[0].set_read_timeout(Some(Duration::from_secs(10))).expect("a socket has timeouts");
    assert!(lazy[0].read(&mut [0; 1]).is_ok_and(|count| count == 0), "the connection is closed");
}
