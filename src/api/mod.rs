//! The HTTP service. `routes` lists every route; `error` maps errors to status codes. Knows contract and jobs; computes nothing.

/// State shared by the handlers.
mod app;
/// Access control.
mod auth;
/// Work that takes processor time.
mod computation;
/// Number of simultaneous requests, streams and bodies.
mod concurrency;
/// ETags and 304.
mod conditional;
/// Places of connections.
mod connection_places;
/// Tokens and owners.
pub mod credentials;
/// Errors as problem details (RFC 9457).
mod error;
/// Jobs as JSON.
mod job_response;
/// Limits of the size of a request.
mod limits;
/// Filters and pages of a job list.
mod list_query;
mod machine;
/// The OpenAPI document beside the operations.
mod openapi;
/// Threads of runs that are shown and not kept.
mod preview_threads;
/// Paths that need no token.
mod public_paths;
/// Ranges of bytes.
mod range;
/// Requests per second of each owner.
pub mod rate_limit;
/// Parts of a request.
mod request;
/// Time series, sent chunk by chunk.
mod series_answer;
/// The status of a job by its name.
mod status_name;
/// Stored answers, read and formatted.
mod stored_answer;
/// Headers of a submission.
mod submission_headers;

mod batch;
mod comparison;
mod events;
mod health;
mod jobs;
mod orders;
mod plots;
mod portal;
mod preview;
mod results;
mod rotor;
mod scenes;
mod studies;
mod uploaded_series;

/// Web pages of other origins.
pub mod cors;
/// Errors of the framework and panics as problems.
mod error_layers;
/// Request ids.
mod request_id;
/// Every route.
mod routes;
/// The accept loop.
mod server;
/// The service and the worker, with their start and stop.
pub mod service;
/// A stream that closes when the client stops reading.
mod write_timeout;

/// Requests without a service behind them.
#[cfg(fuzzing)]
#[doc(hidden)]
pub mod fuzzing;

pub use app::Access;
pub use error::{ApiError, Problem};
pub use routes::{document, document_text};
