//! Queue and store of jobs. An accepted job survives a power cut, runs once, and ends in one of three ways. The table of jobs is
//! authoritative; the queue only delivers. Knows contract and simulation; knows no HTTP.

/// One server per database file.
mod database_lock;
/// Errors of requests about jobs.
pub mod error;
/// One transaction for many submissions.
mod intake;
/// The life of a job.
pub mod job;
/// Starting and stopping.
mod lifecycle;
/// The parts of a running service.
mod parts;
/// Limits of unfinished work.
mod places;
/// The queue, with River behind it.
mod queue;
/// Runs of this process.
mod running;
/// Time series of a run on their way to the store.
mod series_writer;
/// Submitting, reading, cancelling and deleting jobs.
mod service;
/// Counts and times for Prometheus.
mod service_metrics;
/// Settings of queue and store.
mod settings;
/// Threads that simulate.
mod solver_threads;
/// Every SQL statement.
mod store;
/// One shard of a study.
mod study_shard;
/// Recovery of lost runs, removal of expired jobs.
mod sweep;
/// Bearer tokens of the running service.
mod token_cache;
/// Bearer tokens: created, listed and revoked.
pub mod tokens;
/// Every stored result compared with its digests.
pub mod verification;
/// One job from claim to result.
mod worker;

/// Submissions of several processes.
#[cfg(test)]
mod acceptance;
/// Every order of actions of two processes on one job.
#[cfg(test)]
mod interleavings;
/// Time series of runs that end, are rejected or are lost.
#[cfg(test)]
mod series_of_runs;
/// The order of turns of several owners.
#[cfg(test)]
mod turn_order;

pub use error::JobError;
pub use intake::Submitted;
pub use job::{ExpiredJob, Failure, IdempotencyKey, JobRecord, NewJob, Status};
pub use places::{Left, WorkLimits};
pub use running::View;
pub use service::{Cancelled, Jobs};
pub use service_metrics::MEDIA_TYPE as METRICS_MEDIA_TYPE;
pub use settings::{Settings, Simulator};
pub use solver_threads::SolverThreads;
pub use store::compression::decompressed;
pub use store::integrity::Inspection;
pub use store::location::Location;
pub use store::records::Filter;
pub use store::results::Fingerprint;
pub use store::series_reader::StoredSeries;
pub use store::signal::Signal;
pub use store::studies::StoredPoint;
pub use store::uploaded_series::{BYTES_OF_OWNER, PackedSeries, UploadedSeries};
