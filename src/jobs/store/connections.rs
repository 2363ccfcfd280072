//! Connections to a file or a server.

use std::path::Path;
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgPool, PgPoolOptions};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection, PgConnection, SqliteConnection};

use crate::jobs::error::JobError;

/// Connections to a file.
pub struct OpenFile {
    pub writer: SqlitePool,
    pub readers: [SqlitePool; 2],
}

/// Opens a file with one connection that writes and two pools of as many connections that read.
pub async fn open_file(path: &Path, readers: [u32; 2], max_pages: Option<u32>) -> Result<OpenFile, JobError> {
    create_private(path)?;
    let mut options = SqliteConnectOptions::new()
        .filename(path)
        .journal_mode(SqliteJournalMode::Wal)
        // An answer 202 promises that the job survives a power cut.
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(Duration::from_secs(10));
    // Tests the file itself: SQLite would report a read-only file only at the first write, and leave an unwritable log.
    match std::fs::OpenOptions::new().append(true).open(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.into()),
        _ => {}
    }
    if let Some(pages) = max_pages {
        options = options.pragma("max_page_count", pages.to_string());
    }
    let writer = file_pool(1).connect_with(options.clone()).await?;
    let options = options.read_only(true);
    let readers = readers.map(|connections| file_pool(connections).connect_lazy_with(options.clone()));
    Ok(OpenFile { writer, readers })
}

/// Creates a missing file that only its user can read and write. SQLite gives its log the same mode.
pub fn create_private(path: &Path) -> std::io::Result<()> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    match options.open(path) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => Err(error),
        _ => Ok(()),
    }
}

fn file_pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(Duration::from_secs(30))
        // Unlike a network connection a file is not lost, and a test costs a third of a read.
        .test_before_acquire(false)
        .before_acquire(|connection, _| Box::pin(std::future::ready(Ok(is_outside_transactions(connection)))))
}

/// Returns whether the connection may be used again.
///
/// On a full disk SQLite ends a transaction by itself. sqlx then fails to end it, counts it as open for ever, and refuses every
/// later one.
fn is_outside_transactions(connection: &SqliteConnection) -> bool {
    !connection.is_in_transaction()
}

/// Least number of connections of a process that runs jobs: two listen to notifications, one takes deliveries, one writes, one reads
/// lists.
const MIN_CONNECTIONS: usize = 5;

/// Fails if the server grants fewer than the least number of connections: runs would wait for each other.
pub async fn check_connection_limit(options: &PgConnectOptions) -> Result<(), JobError> {
    let mut held = Vec::new();
    while held.len() < MIN_CONNECTIONS {
        match PgConnection::connect_with(options).await {
            Ok(connection) => held.push(connection),
            Err(error) if held.is_empty() => return Err(error.into()),
            Err(error) => {
                let granted = held.len();
                let needed = format!(
                    "{error}; a process that runs jobs needs at least {MIN_CONNECTIONS} connections, and got {granted}"
                );
                return Err(JobError::Migration(needed));
            }
        }
    }
    for connection in held {
        connection.close().await?;
    }
    Ok(())
}

/// Connects to a server with two pools of as many connections. The second one opens its connections when it needs them.
pub async fn connect(options: &PgConnectOptions, connections: [u32; 2]) -> Result<[PgPool; 2], JobError> {
    // A process that freezes within a transaction would hold its locks and block all others.
    let options = options.clone().application_name("raceway").options([("idle_in_transaction_session_timeout", "10s")]);
    // The pool retries without reporting the cause; one direct connection reports it.
    PgConnection::connect_with(&options).await?.close().await?;
    let [first, second] = connections.map(|connections| server_pool(connections, options.get_port()));
    let second = second.connect_lazy_with(options.clone());
    Ok([first.connect_with(options).await?, second])
}

fn server_pool(connections: u32, port: u16) -> PgPoolOptions {
    PgPoolOptions::new()
        .max_connections(connections)
        .after_connect(move |_, _| {
            #[cfg(target_os = "linux")]
            super::tcp_options::set_for_port(port);
            Box::pin(std::future::ready(Ok(())))
        })
        // Longest time that a request waits for an unreachable server.
        .acquire_timeout(Duration::from_secs(5))
        // Only an idle connection may have been cut; a ping before every query would double its round trips.
        .test_before_acquire(false)
        .before_acquire(|connection, rest| {
            Box::pin(async move {
                let was_idle = rest.idle_for > Duration::from_secs(1);
                Ok(!was_idle || answers(connection).await)
            })
        })
        // Runs before the pool's own ping, which has no time limit.
        .after_release(|connection, _| {
            Box::pin(async move { if answers(connection).await { Ok(true) } else { Err(sqlx::Error::WorkerCrashed) } })
        })
}

/// Returns whether the server answers a ping in time.
async fn answers(connection: &mut PgConnection) -> bool {
    tokio::time::timeout(PING_TIMEOUT, connection.ping()).await.is_ok_and(|answer| answer.is_ok())
}

/// Shorter than the time that a request waits for a connection, so that it can still get another one.
const PING_TIMEOUT: Duration = Duration::from_secs(2);
