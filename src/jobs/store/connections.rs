//! Connections to a file or a server.

use std::path::Path;
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgPool, PgPoolOptions};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection, PgConnection, SqliteConnection};

use crate::jobs::JobError;

/// Opens a file for one writer and some readers.
pub async fn open_file(
    path: &Path,
    readers: u32,
    max_pages: Option<u32>,
) -> Result<(SqlitePool, SqlitePool), JobError> {
    let mut options = SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        // A 202 promises that the job survives a power cut.
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(Duration::from_secs(10));
    // Asked of the file itself: SQLite would tell it with the first write only, and leave a log that can be written as little.
    match std::fs::OpenOptions::new().append(true).open(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.into()),
        _ => {}
    }
    if let Some(pages) = max_pages {
        options = options.pragma("max_page_count", pages.to_string());
    }
    let writer = file_pool(1).connect_with(options.clone()).await?;
    let readers = file_pool(readers).connect_lazy_with(options.create_if_missing(false).read_only(true));
    Ok((writer, readers))
}

fn file_pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(Duration::from_secs(30))
        // A file is not lost like a link, and asking each time costs a third of a read.
        .test_before_acquire(false)
        .before_acquire(|connection, _| Box::pin(std::future::ready(Ok(is_outside_transactions(connection)))))
}

/// Whether the connection may be used again. On a full disk SQLite ends a transaction by itself; sqlx then
/// fails to end it, counts it as open for ever, and refuses every later one.
fn is_outside_transactions(connection: &SqliteConnection) -> bool {
    !connection.is_in_transaction()
}

/// Connections that a process needs which runs jobs: two hear what others tell, one takes deliveries, one writes.
const LEAST_CONNECTIONS: usize = 4;

/// Refuses a server that gives so few connections that runs would wait for each other's.
pub async fn check_room(options: &PgConnectOptions) -> Result<(), JobError> {
    let mut held = Vec::new();
    while held.len() < LEAST_CONNECTIONS {
        match PgConnection::connect_with(options).await {
            Ok(connection) => held.push(connection),
            Err(error) if held.is_empty() => return Err(error.into()),
            Err(error) => {
                let given = held.len();
                let needed = format!(
                    "{error}; a process that runs jobs needs {LEAST_CONNECTIONS} connections at least, and got {given}"
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

/// Connects to a server.
pub async fn connect(options: &PgConnectOptions, connections: u32) -> Result<PgPool, JobError> {
    // A process that is frozen within a transaction would keep its locks, and with them all others.
    let options = options.clone().application_name("raceway").options([("idle_in_transaction_session_timeout", "10s")]);
    // A pool tries again and again, and does not say why in vain.
    PgConnection::connect_with(&options).await?.close().await?;
    let port = options.get_port();
    let pool = PgPoolOptions::new()
        .max_connections(connections)
        .after_connect(move |_, _| {
            #[cfg(target_os = "linux")]
            super::link::prepare(port);
            Box::pin(std::future::ready(Ok(())))
        })
        // Whoever waits for an answer does not wait longer for a server that is away.
        .acquire_timeout(Duration::from_secs(5))
        // Only a connection that has rested may have been cut meanwhile; asking each time would double the way of a query.
        .test_before_acquire(false)
        .before_acquire(|connection, rest| {
            Box::pin(async move {
                let rested = rest.idle_for > Duration::from_secs(1);
                Ok(!rested || answers(connection).await)
            })
        })
        // Before the pool asks the same without a limit.
        .after_release(|connection, _| {
            Box::pin(async move { if answers(connection).await { Ok(true) } else { Err(sqlx::Error::WorkerCrashed) } })
        });
    Ok(pool.connect_with(options).await?)
}

/// Whether a connection can be used.
async fn answers(connection: &mut PgConnection) -> bool {
    tokio::time::timeout(LONGEST_PING, connection.ping()).await.is_ok_and(|answer| answer.is_ok())
}

/// Time that a server has to answer a ping: less than a request waits for a connection, so that another one can still be had.
const LONGEST_PING: Duration = Duration::from_secs(2);
