//! Shared by both test binaries: a minimal HTTP client, and servers inside and outside the process.
#![allow(dead_code, reason = "each test binary uses its part")]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// An answer.
#[derive(Debug, Clone)]
pub struct Answer {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: String,
}

impl Answer {
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|header| header.0.eq_ignore_ascii_case(name)).map(|header| header.1.as_str())
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// The answer as JSON, after checking that it is a problem with this status.
    pub fn problem(&self, status: u16) -> Value {
        assert_eq!(self.status, status, "{self:?}");
        assert_eq!(self.header("content-type"), Some("application/problem+json"), "{self:?}");
        let problem = self.json();
        for field in ["type", "title", "detail"] {
            assert!(problem[field].is_string(), "{self:?}");
        }
        assert_eq!(problem["status"], status, "{self:?}");
        problem
    }
}

/// One request over a new connection.
pub fn request(address: &str, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
    let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\nContent-Length: {}\r\n", body.len());
    if !headers.iter().any(|header| header.0.eq_ignore_ascii_case("host")) {
        text.push_str(&format!("Host: {address}\r\n"));
    }
    headers.iter().for_each(|(name, value)| text.push_str(&format!("{name}: {value}\r\n")));
    text.push_str("\r\n");
    let mut stream = TcpStream::connect(address).expect("the server listens");
    stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a socket has timeouts");
    // The server may answer and close before it has read the whole request.
    let _ = stream.write_all(text.as_bytes()).and_then(|()| stream.write_all(body));
    let mut bytes = Vec::new();
    let _ = stream.read_to_end(&mut bytes);
    parse(&bytes)
}

fn parse(bytes: &[u8]) -> Answer {
    let text = String::from_utf8_lossy(bytes);
    let (head, body) = text.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no answer: {text}"));
    let mut lines = head.lines();
    let status = lines.next().and_then(|line| line.split(' ').nth(1)).and_then(|status| status.parse().ok());
    let headers = lines.filter_map(|line| line.split_once(": ")).map(|(n, v)| (n.to_owned(), v.to_owned()));
    let headers: Vec<_> = headers.collect();
    let chunked = headers.iter().any(|(name, value)| name == "transfer-encoding" && value == "chunked");
    let body = if chunked { unchunked(body) } else { body.to_owned() };
    Answer { status: status.expect("a status line"), headers, body }
}

fn unchunked(mut body: &str) -> String {
    let mut text = String::new();
    while let Some((size, rest)) = body.split_once("\r\n") {
        let size = usize::from_str_radix(size, 16).expect("a chunk size");
        text.push_str(&rest[..size]);
        body = rest.get(size + 2..).unwrap_or_default();
    }
    text
}

/// A server under test.
pub trait Server {
    fn address(&self) -> &str;

    fn get(&self, path: &str) -> Answer {
        request(self.address(), "GET", path, &[], b"")
    }

    fn post(&self, path: &str, body: &Value) -> Answer {
        let headers = [("Content-Type", "application/json")];
        request(self.address(), "POST", path, &headers, body.to_string().as_bytes())
    }

    /// Submits a job and returns its path.
    fn submit(&self, job: &Value) -> String {
        let answer = self.post("/v1/jobs", job);
        assert_eq!(answer.status, 202, "{answer:?}");
        answer.header("location").expect("a 202 has a location").to_owned()
    }

    /// The job, as soon as it has one of these statuses.
    fn wait_for(&self, path: &str, statuses: &[&str]) -> Value {
        let begin = Instant::now();
        loop {
            let job = self.get(path).json();
            if statuses.iter().any(|status| job["status"] == *status) {
                return job;
            }
            assert!(begin.elapsed() < Duration::from_secs(180), "{path} is still {job}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// The smallest job.
pub fn job() -> Value {
    json!({ "kind": "simulation", "scene": { "bearing": "608", "operation": { "speed_rpm": 3000 } } })
}

/// The smallest job with other fields.
pub fn job_with(fields: Value) -> Value {
    let mut job = job();
    for (name, value) in fields.as_object().expect("fields") {
        job[name] = value.clone();
    }
    job
}

/// Environment variable of a PostgreSQL server on which tests create databases; without it tests use files.
pub const POSTGRES: &str = "RACEWAY_TEST_POSTGRES";

/// The URL of an empty database on that server; `None` where there is none.
pub fn postgres_database() -> Option<String> {
    let server = std::env::var(POSTGRES).ok()?;
    let name = format!("raceway_{}", uuid::Uuid::now_v7().simple());
    execute(&server, &format!("CREATE DATABASE {name}"));
    let (server, _) = server.rsplit_once('/').expect("a URL with a database");
    Some(format!("{server}/{name}"))
}

/// Runs a statement on the database as whoever may do everything.
pub fn execute(database: &str, sql: &str) {
    use sqlx::{Connection, Executor};
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(async {
        let mut connection = sqlx::PgConnection::connect(database).await.expect("the server is there");
        connection.execute(sqlx::AssertSqlSafe(sql.to_owned())).await.expect("the statement is right");
        connection.close().await.expect("the connection ends");
    });
}

/// The real program, killed when it is dropped.
pub struct Process {
    pub child: Child,
    pub address: String,
}

impl Server for Process {
    fn address(&self) -> &str {
        &self.address
    }
}

impl Process {
    /// A command of the real program.
    pub fn command(arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raceway"));
        command.args(arguments).env_clear().stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// `raceway serve` on a database, once it listens.
    pub fn serve(database: &Path, more: &[&str]) -> Self {
        let mut arguments = vec!["--listen", "127.0.0.1:0"];
        arguments.extend(more);
        Self::serve_with(database, &arguments, &[])
    }

    /// The same, wherever it listens.
    pub fn serve_with(database: &Path, more: &[&str], environment: &[(&str, &str)]) -> Self {
        Self::serve_on(&format!("sqlite://{}", database.display()), more, environment)
    }

    /// The same on any database.
    pub fn serve_on(database: &str, more: &[&str], environment: &[(&str, &str)]) -> Self {
        let mut command = Self::command(&["serve", "--database", database]);
        command.args(more).envs(environment.iter().copied());
        Self::announced(command, &["listening on http://"])
    }

    /// `raceway worker` on a database, once it works.
    pub fn worker(database: &str, more: &[&str]) -> Self {
        let mut command = Self::command(&["worker", "--database", database]);
        command.args(more);
        Self::announced(command, &["working for postgres://"])
    }

    /// The same with probes, at its address.
    pub fn probed_worker(database: &str, more: &[&str]) -> Self {
        let mut command = Self::command(&["worker", "--database", database, "--probes", "127.0.0.1:0"]);
        command.args(more);
        Self::announced(command, &["working for postgres://", "probes at http://"])
    }

    /// Once it has said these lines; the last one ends with its address.
    fn announced(mut command: Command, lines: &[&str]) -> Self {
        let mut child = command.stderr(Stdio::null()).spawn().expect("the program starts");
        let mut stdout = BufReader::new(child.stdout.take().expect("stdout is a pipe"));
        let mut address = String::new();
        for words in lines {
            let mut line = String::new();
            stdout.read_line(&mut line).expect("the program says that it is there");
            address = line.trim().strip_prefix(words).expect("the line").to_owned();
        }
        Self { child, address }
    }

    pub fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status();
        assert!(sent.is_ok_and(|status| status.success()));
    }

    /// Ends it as a power cut would.
    pub fn kill(mut self) {
        self.child.kill().expect("the process runs");
        self.child.wait().expect("the process ends");
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
