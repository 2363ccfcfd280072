//! Tokens created and revoked by command, before and while a service runs; database users without the right to create tables.

use std::path::Path;
use std::process::Output;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::common::{POSTGRES, Process, Server, execute, job_with, postgres_database, request};

/// An empty database on PostgreSQL if available, else a file.
fn database(place: &Path) -> String {
    postgres_database().unwrap_or_else(|| format!("sqlite://{}", place.join("raceway.db").display()))
}

fn short_job() -> Value {
    job_with(json!({ "settle_s": 0.0, "duration_s": 0.001 }))
}

fn raceway(arguments: &[&str], database: &str) -> Output {
    Process::command(arguments).args(["--database", database]).output().expect("the program starts")
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The printed token.
fn created(arguments: &[&str], database: &str) -> String {
    let text = stdout(&raceway(&[&["token", "create"], arguments].concat(), database));
    let token = text.strip_suffix('\n').expect("one line");
    let secret = token.strip_prefix("raceway_").expect("a word that scanners know");
    assert!(secret.len() == 64 && secret.bytes().all(|byte| byte.is_ascii_hexdigit()), "{token}");
    token.to_owned()
}

fn status(server: &Process, path: &str, token: &str) -> u16 {
    let bearer = format!("Bearer {token}");
    request(server.address(), "GET", path, &[("Authorization", &bearer)], b"").status
}

#[test]
fn a_running_service_follows_changes_of_its_tokens() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    let first = created(&["portal"], &database);
    let server = Process::serve_on(&database, &["--listen", "0.0.0.0:0"], &[]);
    assert_eq!(server.get("/v1/jobs").status, 401);
    let bearer = format!("Bearer {first}");
    let headers = [("Authorization", bearer.as_str()), ("Content-Type", "application/json")];
    let body = short_job().to_string();
    let submitted = request(server.address(), "POST", "/v1/jobs", &headers, body.as_bytes());
    assert_eq!(submitted.status, 202);
    let path = submitted.header("location").expect("a location").to_owned();

    let listed = stdout(&raceway(&["token", "list"], &database));
    let owner = listed.lines().nth(1).and_then(|line| line.split_whitespace().nth(1)).expect("an owner").to_owned();
    assert!(listed.contains("portal") && listed.contains("valid") && !listed.contains(&first), "{listed}");
    let same_owner = created(&["portal-2", "--owner", &owner, "--expires-in-days", "1"], &database);
    let other = created(&[], &database);
    assert_eq!((status(&server, &path, &same_owner), status(&server, &path, &other)), (200, 404));

    assert!(raceway(&["token", "revoke", "portal"], &database).status.success());
    let begin = Instant::now();
    while status(&server, &path, &first) != 401 {
        assert!(begin.elapsed() < Duration::from_secs(10), "a revoked token lets in");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(status(&server, &path, &same_owner), 200);
    assert!(stdout(&raceway(&["token", "list"], &database)).contains("revoked 2"));
}

/// Requests with unknown tokens cause reads of the tokens. A token that is created between two reads is accepted at once.
#[test]
fn a_new_token_is_accepted_at_once() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    created(&[], &database);
    let server = Process::serve_on(&database, &["--listen", "127.0.0.1:0"], &[]);
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                assert_eq!(status(&server, "/v1/jobs", "guess"), 401);
            }
        });
        let answers: Vec<u16> = (0..8).map(|_| status(&server, "/v1/jobs", &created(&[], &database))).collect();
        is_over.store(true, Ordering::Relaxed);
        assert_eq!(answers, [200; 8]);
    });
}

#[test]
fn a_stream_ends_when_its_token_is_revoked() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    let token = created(&["portal"], &database);
    let server = Process::serve_on(&database, &["--listen", "127.0.0.1:0"], &[]);
    let bearer = format!("Bearer {token}");
    let headers = [("Authorization", bearer.as_str()), ("Content-Type", "application/json"), ("Prefer", "wait=4")];
    let post = |headers: &[(&str, &str)], job: &Value| {
        request(server.address(), "POST", "/v1/jobs", headers, job.to_string().as_bytes())
    };
    let long_job = job_with(json!({ "duration_s": 100.0, "solver": { "rung": "full" }, "reuse": false }));
    let path = post(&headers[..2], &long_job).header("location").expect("a 202 has a location").to_owned();
    std::thread::scope(|scope| {
        let waits = scope.spawn(|| post(&headers, &long_job).status);
        let follows = scope.spawn(|| {
            let begin = Instant::now();
            let answer = request(server.address(), "GET", &format!("{path}/events"), &headers[..1], b"");
            (answer.status, begin.elapsed())
        });
        std::thread::sleep(Duration::from_millis(500));
        assert!(raceway(&["token", "revoke", "portal"], &database).status.success());
        assert_eq!(waits.join().expect("an answer"), 401);
        let (status, time) = follows.join().expect("an answer");
        // The job runs for more than a minute.
        assert!(status == 200 && time < Duration::from_secs(20), "{status} {time:?}");
    });
}

#[test]
fn a_service_that_has_had_tokens_never_opens_again() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    created(&["only"], &database);
    assert!(raceway(&["token", "revoke", "only"], &database).status.success());
    for listen in ["127.0.0.1:0", "0.0.0.0:0"] {
        let server = Process::serve_on(&database, &["--listen", listen], &[]);
        assert_eq!((server.get("/v1/jobs").status, server.get("/health/ready").status), (401, 200), "{listen}");
    }
}

#[test]
fn an_open_service_closes_with_its_first_token() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    let server = Process::serve_on(&database, &["--listen", "127.0.0.1:0"], &[]);
    assert_eq!(server.get("/v1/jobs").status, 200);
    let token = created(&[], &database);
    let begin = Instant::now();
    while server.get("/v1/jobs").status != 401 {
        assert!(begin.elapsed() < Duration::from_secs(10), "it is still open");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(status(&server, "/v1/jobs", &token), 200);
}

#[test]
fn errors_of_token_commands_state_their_cause() {
    let place = tempfile::tempdir().expect("a directory");
    let file = place.path().join("none.db");
    let missing = format!("sqlite://{}", file.display());
    for arguments in [&["token", "list"][..], &["token", "revoke", "portal"]] {
        let refused = raceway(arguments, &missing);
        assert_eq!(refused.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&refused.stderr).contains("there is no database"), "{refused:?}");
    }
    assert!(!file.exists());
    let database = database(place.path());
    created(&["portal"], &database);
    for (arguments, word) in [
        (&["token", "create", "portal"][..], "already"),
        (&["token", "revoke", "portal-2"], "no token portal-2"),
        (&["token", "create", "a name"], "without spaces"),
        (&["token", "create", "--expires-in-days", "0"], "1..=36500"),
    ] {
        let refused = raceway(arguments, &database);
        assert!(!refused.status.success() && refused.stdout.is_empty(), "{refused:?}");
        assert!(String::from_utf8_lossy(&refused.stderr).contains(word), "{refused:?}");
    }
}

#[test]
fn each_owner_has_its_own_rate_and_queue_limit() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    let limits = ["--rate-limit", "20", "--queue-limit-per-owner", "2", "--workers", "1"];
    let server = Process::serve_on(
        &database,
        &[&["--listen", "127.0.0.1:0"][..], &limits].concat(),
        &[("RACEWAY_API_TOKENS", "alpha,beta")],
    );
    let post = |token: &str| {
        let bearer = format!("Bearer {token}");
        let job = job_with(json!({ "duration_s": 100.0, "reuse": false }));
        let headers = [("Authorization", bearer.as_str()), ("Content-Type", "application/json")];
        request(server.address(), "POST", "/v1/jobs", &headers, job.to_string().as_bytes())
    };
    assert_eq!([post("alpha").status, post("alpha").status], [202, 202]);
    // Two jobs wait; the first may already run when the third is submitted.
    let refused = (0..3).map(|_| post("alpha")).find(|answer| answer.status == 429).expect("no more places");
    assert_eq!(refused.problem(429)["type"], "urn:raceway:problem:queue-full");
    assert_eq!(post("beta").status, 202);

    let mut statuses: Vec<u16> = (0..60).map(|_| status(&server, "/v1/presets", "alpha")).collect();
    statuses.sort_unstable();
    statuses.dedup();
    assert_eq!(statuses, [200, 429]);
    let begin = Instant::now();
    let refused = loop {
        let answer = request(server.address(), "GET", "/v1/presets", &[("Authorization", "Bearer alpha")], b"");
        if answer.status == 429 {
            break answer;
        }
        assert!(begin.elapsed() < Duration::from_secs(10), "nothing is refused");
    };
    assert_eq!(refused.problem(429)["type"], "urn:raceway:problem:too-often");
    assert_eq!(refused.header("retry-after"), Some("1"));
    assert_eq!(status(&server, "/v1/presets", "beta"), 200);
    assert_eq!(server.get("/health/live").status, 200);
}

#[test]
fn the_tables_of_a_recreated_database_are_restored() {
    let Some(database) = postgres_database() else { return };
    let (server_url, name) = database.rsplit_once('/').expect("a URL with a database");
    let server = Process::serve_on(&database, &["--listen", "127.0.0.1:0"], &[]);
    server.wait_for(&server.submit(&short_job()), &["succeeded"]);
    let postgres = format!("{server_url}/postgres");
    execute(&postgres, &format!("DROP DATABASE {name} WITH (FORCE)"));
    execute(&postgres, &format!("CREATE DATABASE {name}"));
    let begin = Instant::now();
    loop {
        let answer = server.post("/v1/jobs", &short_job());
        if answer.status == 202 {
            let path = answer.header("location").expect("a 202 has a location");
            assert_eq!(server.wait_for(path, &["succeeded", "failed"])["status"], "succeeded");
            break;
        }
        assert_eq!(answer.problem(503)["type"], "urn:raceway:problem:database-away");
        assert!(begin.elapsed() < Duration::from_secs(60), "it does not come back");
        std::thread::sleep(Duration::from_millis(500));
    }
}

#[test]
fn too_few_connections_are_reported_at_the_start() {
    let Some(database) = postgres_database() else { return };
    let user = format!("few_{}", uuid::Uuid::now_v7().simple());
    execute(&database, &format!("CREATE ROLE {user} LOGIN SUPERUSER CONNECTION LIMIT 3"));
    execute(&database, &format!("ALTER ROLE {user} NOSUPERUSER; GRANT CREATE ON SCHEMA public TO {user}"));
    let as_user = database.replacen("raceway@", &format!("{user}@"), 1);
    let refused = raceway(&["serve", "--listen", "127.0.0.1:0"], &as_user);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && told.contains("needs at least 5 connections"), "{told}");
}

#[test]
fn a_database_user_without_the_right_to_create_tables_can_serve_and_work() {
    let Some(database) = postgres_database() else { return };
    let user = format!("service_{}", uuid::Uuid::now_v7().simple());
    let as_user = database.replacen("raceway@", &format!("{user}@"), 1);
    execute(&database, &format!("CREATE ROLE {user} LOGIN"));
    let early = raceway(&["migrate"], &as_user);
    assert!(
        !early.status.success() && String::from_utf8_lossy(&early.stderr).contains("permission denied"),
        "{early:?}"
    );

    assert!(raceway(&["migrate"], &database).status.success());
    execute(
        &database,
        &format!(
            "GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA public TO {user}; \
             GRANT USAGE ON ALL SEQUENCES IN SCHEMA public TO {user}"
        ),
    );
    let server = Process::serve_on(&as_user, &["--listen", "127.0.0.1:0", "--workers", "0"], &[]);
    let path = server.submit(&short_job());
    let _worker = Process::worker(&as_user, &[]);
    assert_eq!(server.wait_for(&path, &["succeeded", "failed"])["status"], "succeeded");
}

#[test]
fn the_connection_to_postgresql_can_be_encrypted() {
    let (Some(database), Ok(certificate)) = (postgres_database(), std::env::var(format!("{POSTGRES}_CA"))) else {
        return;
    };
    let checked = format!("{database}?sslmode=verify-full&sslrootcert={certificate}");
    let server = Process::serve_on(&checked, &["--listen", "127.0.0.1:0"], &[]);
    let path = server.submit(&short_job());
    assert_eq!(server.wait_for(&path, &["succeeded", "failed"])["status"], "succeeded");
    // No certificate authority has signed for that name.
    let foreign = checked.replacen("127.0.0.1", "localhost", 1);
    let refused = raceway(&["migrate"], &foreign);
    assert!(!refused.status.success(), "{refused:?}");
}

/// Jobs that were submitted while no token was needed are accessible only to a token for open jobs.
#[test]
fn jobs_from_before_the_first_token_need_a_token_for_open_jobs() {
    let place = tempfile::tempdir().expect("a directory");
    let database = database(place.path());
    let server = Process::serve_on(&database, &["--listen", "127.0.0.1:0"], &[]);
    let body = short_job().to_string();
    let json = [("Content-Type", "application/json")];
    let submitted = request(server.address(), "POST", "/v1/jobs", &json, body.as_bytes());
    let path = submitted.header("location").expect("a location").to_owned();
    drop(server);
    let (own, open) = (created(&["own"], &database), created(&["before", "--open-jobs"], &database));
    let listed = stdout(&raceway(&["token", "list"], &database));
    assert!(listed.lines().any(|line| line.starts_with("before") && line.contains("(open)")), "{listed}");
    let server = Process::serve_on(&database, &["--listen", "127.0.0.1:0"], &[]);
    assert_eq!((status(&server, &path, &own), status(&server, &path, &open)), (404, 200));
    // Two tokens are ambiguous.
    let (own, open) = (format!("Bearer {own}"), format!("Bearer {open}"));
    let both = [("Authorization", open.as_str()), ("Authorization", own.as_str())];
    assert_eq!(request(server.address(), "GET", &path, &both, b"").status, 401);
}
