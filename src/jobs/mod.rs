//! Queue and store of jobs: what was accepted survives a power cut, is run once, and ends in one of
//! three ways. Our table of jobs is the truth; the queue only delivers. Knows contract and simulation;
//! knows no HTTP.

/// The life of a job.
pub mod job;
/// What the rest of the service asks for: submit, look, cancel, delete.
pub mod service;

/// What can go wrong, with what the caller may do about it.
pub mod error;
/// What operators watch.
mod figures;
/// One transaction for many submissions.
mod intake;
/// Every order of what two processes can do with a job.
#[cfg(test)]
mod interleavings;
/// One server a database.
mod lock;
/// The port to the queue, and River behind it.
mod queue;
/// Runs of this process: stop flags, progress, and who waits for an end.
mod running;
/// Every SQL statement.
mod store;
/// One strand of a study.
mod strand;
/// Brings back what was lost, removes what has expired.
mod sweep;
/// Threads that simulate.
mod threads;
/// Bearer tokens of the database.
pub mod tokens;
/// One job from claim to result.
mod worker;

pub use error::JobError;
pub use figures::MEDIA_TYPE as FIGURES_MEDIA_TYPE;
pub use intake::Submitted;
pub use job::{Failure, IdempotencyKey, JobRecord, NewJob, Status};
pub use running::View;
pub use service::{Cancelled, Jobs, Settings, Simulator};
pub use store::Location;
pub use store::results::decompressed;
pub use store::studies::StoredPoint;
pub use store::{Filter, Signal};
