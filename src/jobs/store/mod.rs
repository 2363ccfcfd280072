//! Every SQL statement about jobs, for SQLite and for PostgreSQL. Knows records and results; knows no runs, threads or HTTP.
//!
//! On SQLite one connection writes and a few read. Every write transaction takes the write lock when it begins: one that reads
//! first and writes later fails as soon as there is another. On PostgreSQL a transaction that decides by a row it has read locks
//! the row first, by an update.

/// Chunks of time series as they are stored.
pub mod chunk_codec;
/// Claims, heartbeats and ends, all fenced.
pub mod claims;
/// Compression of stored answers.
pub mod compression;
/// Connections to a file or a server.
pub mod connections;
/// The open database.
pub mod database;
/// River's table of deliveries.
pub mod deliveries;
/// SQL that differs between the two databases.
pub mod dialect;
/// Digests of stored answers.
pub mod digest;
/// Whose work is due.
pub mod due;
/// Idempotency keys and the jobs they created.
pub mod idempotency_keys;
/// Comparison of stored results with the digests of their writing.
pub mod integrity;
/// A file or a server.
pub mod location;
/// Lost runs and listed workers.
pub mod maintenance;
/// The tables, brought up to date.
mod migrations;
/// Notifications between processes.
pub mod notifications;
/// Names of the parts of a result.
pub mod part_names;
/// Connection pools and write transactions.
pub mod pool;
/// Jobs read, listed and cancelled.
pub mod records;
/// Removed jobs.
pub mod removal;
/// Results written and read.
pub mod results;
/// The search for a finished result of identical work.
pub mod reuse;
/// Requests of jobs with their digests.
mod sealed_request;
/// Time series written chunk by chunk, and the removal of those of lost runs.
pub mod series_chunks;
/// Time series read chunk by chunk.
pub mod series_reader;
/// Kinds of stored signals.
pub mod signal;
/// Spectra as they are stored.
mod spectrum_codec;
/// Statements that run on both databases.
pub mod statement;
/// Times as they are stored.
mod stored_time;
/// Studies and their points.
pub mod studies;
/// Submissions.
pub mod submissions;
/// TCP options of connections to a server.
#[cfg(target_os = "linux")]
mod tcp_options;
/// New databases of tests.
#[cfg(test)]
pub mod test_database;
/// Bearer tokens.
pub mod tokens;
/// Deliveries used as turns.
pub mod turns;
/// Uploaded series.
pub mod uploaded_series;
