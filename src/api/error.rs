//! Errors as problem details (RFC 9457). Only this file maps errors to status codes.

use axum::http::header::{ACCEPT, CONTENT_RANGE, CONTENT_TYPE, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::limits::BODY_LIMIT;
use super::status_name::StatusName;
use crate::contract::job::kind::JobKindName;
use crate::contract::json::problem::{MAX_ERRORS, listed};
use crate::contract::{FieldError, Refusal};
use crate::jobs::{ExpiredJob, Failure, JobError, Status};

pub const PROBLEM_JSON: &str = "application/problem+json";

/// A problem (RFC 9457).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Problem {
    /// Kind of the problem; stable across versions.
    #[serde(rename = "type")]
    #[schema(format = "uri-reference", example = "urn:raceway:problem:invalid-request")]
    pub kind: String,
    /// Short description of the kind.
    #[schema(example = "The request is not valid")]
    pub title: String,
    /// Status code of the answer; absent in the `error` of a job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 400, maximum = 599, example = 422)]
    pub status: Option<u16>,
    /// Description of this occurrence.
    pub detail: String,
    /// Last state of an expired job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub job: Option<LastState>,
    /// The invalid fields of the body.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(nullable = false)]
    pub errors: Vec<FieldError>,
}

/// Last state of an expired job.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LastState {
    /// Id of the job.
    id: Uuid,
    /// Kind of the job.
    #[schema(value_type = JobKindName)]
    kind: String,
    /// Status with which the job ended.
    status: StatusName,
    /// Time of the end (RFC 3339, UTC).
    #[schema(value_type = String, format = DateTime)]
    finished_at: Timestamp,
    /// Time at which the job and its result were removed.
    #[schema(value_type = String, format = DateTime)]
    expired_at: Timestamp,
}

impl Problem {
    fn new(kind: &str, title: &str, detail: impl Into<String>) -> Self {
        Self {
            kind: format!("urn:raceway:problem:{kind}"),
            title: title.to_owned(),
            status: None,
            detail: detail.into(),
            job: None,
            errors: Vec::new(),
        }
    }

    /// The problem of a failed job.
    pub fn of_failure(failure: &Failure) -> Self {
        let title = match failure.cause.as_str() {
            "did-not-converge" => "The simulation did not converge",
            "numerical-blowup" => "The simulation diverged",
            "spindle-left-bearing" => "The spindle left the bearing",
            "time-limit" => "The run took too long",
            "memory-limit" => "The run needed too much memory",
            "no-metric" => "No run has the requested metric",
            "result-corrupt" => "The stored request is damaged",
            "worker-lost" => "The process of the run ended repeatedly",
            _ => "Internal error of the service",
        };
        Self::new(&failure.cause, title, failure.detail.clone())
    }
}

/// An error of a request.
#[derive(Debug)]
pub enum ApiError {
    /// The body is not JSON, or not a valid request.
    Refused(Refusal),
    /// A wrong header or query.
    BadRequest(String),
    Unauthorized,
    /// More requests, or jobs and points, per second than the owner may send.
    TooOften {
        limit: u32,
        wait_s: u64,
        of_submissions: bool,
    },
    UnknownPath,
    UnknownJob,
    UnknownPlot {
        known: &'static [&'static str],
    },
    UnknownChannel {
        channel: String,
        kept: Vec<String>,
    },
    MethodNotAllowed,
    NotAcceptable {
        offered: &'static [&'static str],
    },
    SlowBody,
    TooLarge {
        limit: usize,
    },
    HeaderTooLarge {
        limit: usize,
    },
    UnsupportedMediaType(String),
    /// `Range` begins behind the end of the body.
    Unsatisfiable {
        length: u64,
    },
    ForeignHost(String),
    /// A limit of simultaneous requests is reached.
    Overloaded,
    /// A preview waited too long for its place.
    PreviewsBusy,
    /// The work of an immediate answer did not end in this time [s].
    TooLong {
        limit_s: u64,
    },
    Job(JobError),
    /// The service does not accept jobs now.
    NotReady(JobError),
    /// An internal error; its cause is logged and not sent.
    Internal,
}

impl From<JobError> for ApiError {
    fn from(error: JobError) -> Self {
        match error {
            JobError::NotFound => Self::UnknownJob,
            error => Self::Job(error),
        }
    }
}

impl From<Refusal> for ApiError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

/// `Retry-After` for a full queue [s].
const QUEUE_RETRY_S: &str = "5";
/// `Retry-After` for a result that is not ready [s].
const RESULT_RETRY_S: &str = "1";
/// `Retry-After` for an unreachable database [s].
const DATABASE_RETRY_S: &str = "1";
/// `Retry-After` for a busy service [s].
const OVERLOAD_RETRY_S: &str = "1";

impl ApiError {
    /// Status and problem.
    pub fn problem(&self) -> (StatusCode, Problem) {
        let (status, problem) = self.status_and_problem();
        (status, Problem { status: Some(status.as_u16()), ..problem })
    }

    fn status_and_problem(&self) -> (StatusCode, Problem) {
        use StatusCode as S;
        let of = |status, kind, title, detail: String| (status, Problem::new(kind, title, detail));
        match self {
            Self::Refused(Refusal::NotJson { detail }) => {
                of(S::BAD_REQUEST, "not-json", "The body is not JSON", detail.clone())
            }
            Self::Refused(Refusal::Invalid { errors }) => {
                let detail = match errors.as_slice() {
                    [only] => only.to_string(),
                    several if several.len() > MAX_ERRORS => {
                        format!("{} fields are invalid; the first {MAX_ERRORS} are listed", several.len())
                    }
                    several => format!("{} fields are invalid", several.len()),
                };
                let errors = errors.iter().take(MAX_ERRORS);
                let problem = Problem::new("invalid-request", "The request is not valid", detail);
                (S::UNPROCESSABLE_ENTITY, Problem { errors: errors.cloned().collect(), ..problem })
            }
            Self::BadRequest(detail) => {
                of(S::BAD_REQUEST, "bad-request", "A header or the query is not valid", detail.clone())
            }
            Self::Unauthorized => {
                let detail = "send a token of the service as Authorization: Bearer".into();
                of(S::UNAUTHORIZED, "unauthorized", "A token is needed", detail)
            }
            Self::TooOften { limit, wait_s, of_submissions: true } => {
                let detail = format!(
                    "tokens of one owner may submit {limit} jobs and points of studies per second; the rest of the last \
                     submissions takes {wait_s} s"
                );
                of(S::TOO_MANY_REQUESTS, "too-often", "Too many submissions", detail)
            }
            Self::TooOften { limit, .. } => {
                let detail = format!("tokens of one owner may send {limit} requests per second; try again later");
                of(S::TOO_MANY_REQUESTS, "too-often", "Too many requests", detail)
            }
            Self::UnknownPath => of(
                S::NOT_FOUND,
                "not-found",
                "There is nothing at this path",
                "the paths are listed in /openapi.json".into(),
            ),
            Self::UnknownJob => {
                let detail =
                    "the id is unknown, or the job was deleted, has expired, or belongs to another owner".into();
                of(S::NOT_FOUND, "unknown-job", "There is no such job", detail)
            }
            Self::UnknownPlot { known } => {
                let detail = match known {
                    [] => {
                        "this job has no plots: it is a study over more than two axes, or a simulation without signals"
                            .to_owned()
                    }
                    known => format!("plots of this job: {}", listed(known.iter().copied())),
                };
                of(S::NOT_FOUND, "unknown-plot", "There is no such plot", detail)
            }
            Self::UnknownChannel { channel, kept } => {
                of(S::NOT_FOUND, "unknown-channel", "The channel is not kept", not_kept(channel, kept))
            }
            Self::MethodNotAllowed => {
                let detail = "the header Allow names the methods of this path".into();
                of(S::METHOD_NOT_ALLOWED, "method-not-allowed", "The path has no such method", detail)
            }
            Self::NotAcceptable { offered } => {
                let detail = format!("available formats: {}", listed(offered.iter().copied()));
                of(S::NOT_ACCEPTABLE, "not-acceptable", "The answer is not available in this format", detail)
            }
            Self::SlowBody => {
                let detail = "the body did not arrive in time".into();
                of(S::REQUEST_TIMEOUT, "slow-request", "The request took too long to arrive", detail)
            }
            Self::TooLarge { limit } => {
                let detail = format!("a body may have at most {limit} bytes");
                of(S::PAYLOAD_TOO_LARGE, "too-large", "The body is too large", detail)
            }
            Self::UnsupportedMediaType(detail) => {
                let title = "The format of the body is not supported";
                of(S::UNSUPPORTED_MEDIA_TYPE, "unsupported-media-type", title, detail.clone())
            }
            Self::HeaderTooLarge { limit } => {
                let detail = format!("the header with the request line may have at most {limit} bytes");
                of(S::REQUEST_HEADER_FIELDS_TOO_LARGE, "header-too-large", "The header is too large", detail)
            }
            Self::ForeignHost(host) => {
                let detail = format!(
                    "without tokens the service answers only requests to localhost or an IP address, not to `{}`",
                    host.chars().take(100).collect::<String>()
                );
                of(S::MISDIRECTED_REQUEST, "foreign-host", "The request was meant for another host", detail)
            }
            Self::Unsatisfiable { length } => {
                let detail = format!("`Range` asks for no byte of the {length} bytes of the file");
                of(S::RANGE_NOT_SATISFIABLE, "range-not-satisfiable", "The file has no such bytes", detail)
            }
            Self::Overloaded => {
                let detail = "a limit of simultaneous requests is reached; try again".into();
                of(S::SERVICE_UNAVAILABLE, "overloaded", "The service is busy", detail)
            }
            Self::PreviewsBusy => {
                let detail = "other previews still run; try again, or submit a job".into();
                of(S::SERVICE_UNAVAILABLE, "overloaded", "The service is busy", detail)
            }
            Self::TooLong { limit_s } => {
                let detail =
                    format!("an immediate answer may take {limit_s} s; submit a job to `/v1/jobs`, or ask for less");
                of(S::UNPROCESSABLE_ENTITY, "too-long", "The answer takes too long", detail)
            }
            Self::Job(error) => of_job(error),
            Self::NotReady(error) => {
                let detail = match error {
                    JobError::Stopping | JobError::DiskFull | JobError::NotWritable | JobError::Displaced => {
                        error.to_string()
                    }
                    _ => "the database does not answer".into(),
                };
                of(S::SERVICE_UNAVAILABLE, "not-ready", "The service accepts no jobs now", detail)
            }
            Self::Internal => internal(),
        }
    }

    /// Headers that this error adds to the answer.
    pub fn headers(&self) -> HeaderMap {
        let mut headers = HeaderMap::new();
        let mut set = |name, value| headers.insert(name, HeaderValue::from_static(value));
        match self {
            Self::Unauthorized => drop(set(WWW_AUTHENTICATE, "Bearer")),
            Self::TooOften { wait_s, .. } => drop(headers.insert(RETRY_AFTER, (*wait_s).into())),
            Self::Unsatisfiable { length } => {
                let whole = HeaderValue::try_from(format!("bytes */{length}"));
                headers.extend(whole.ok().map(|whole| (CONTENT_RANGE, whole)));
            }
            Self::UnsupportedMediaType(_) => drop(set(ACCEPT, "application/json")),
            Self::Job(JobError::QueueFull { .. } | JobError::PointsFull { .. }) => {
                drop(set(RETRY_AFTER, QUEUE_RETRY_S))
            }
            Self::Overloaded | Self::PreviewsBusy => drop(set(RETRY_AFTER, OVERLOAD_RETRY_S)),
            Self::Job(JobError::Stopping | JobError::DiskFull) => drop(set(RETRY_AFTER, QUEUE_RETRY_S)),
            Self::Job(away) if away.is_away() => drop(set(RETRY_AFTER, DATABASE_RETRY_S)),
            Self::Job(JobError::NotReady(_)) => drop(set(RETRY_AFTER, RESULT_RETRY_S)),
            _ => {}
        }
        headers
    }
}

fn not_kept(channel: &str, kept: &[String]) -> String {
    let channel: String = channel.chars().take(100).collect();
    match kept {
        [] if channel.is_empty() => "no signal of this kind is kept; see outputs in the request".to_owned(),
        [] => {
            format!("no signal of this kind is kept for `{channel}` or any other channel; see outputs in the request")
        }
        kept => format!("`{channel}` is not kept; kept channels: {}", listed(kept.iter().map(String::as_str))),
    }
}

fn of_job(error: &JobError) -> (StatusCode, Problem) {
    use StatusCode as S;
    let of = |status, kind, title, detail: String| (status, Problem::new(kind, title, detail));
    match error {
        JobError::NotReady(Status::Queued) => {
            of(S::CONFLICT, "result-not-ready", "The result is not ready", "the job is queued".into())
        }
        JobError::NotReady(_) => {
            of(S::CONFLICT, "result-not-ready", "The result is not ready", "the job is running".into())
        }
        JobError::KeyReused => {
            let detail = "this Idempotency-Key was used with another body; a new request needs a new key".into();
            of(S::UNPROCESSABLE_ENTITY, "idempotency-key-reused", "The key belongs to another request", detail)
        }
        JobError::NoResult(status) => {
            let detail = format!("the job has {}; if it failed, its `error` has the cause", ended(*status));
            of(S::CONFLICT, "no-result", "The job has no result", detail)
        }
        JobError::OtherKind { kind } => {
            let has = match kind.as_str() {
                "accuracy" => "…/accuracy and …/plots/work-precision.svg",
                "optimum" => "…/optimum and …/plots/optimum.svg",
                "study" => "…/table, …/plots/trend.svg and …/plots/map.svg",
                "uncertainty" => "…/uncertainty, …/table and …/plots/uncertainty.svg",
                "rotor" => "…/rotor, …/rotor.py, …/plots/campbell.svg and …/plots/shapes.svg",
                "machine" => "…/machine, …/spectrum and …/plots/spectrum.svg",
                _ => "…/metrics, …/spectrum, …/series and …/plots/spectrum.svg",
            };
            let detail = format!("a job of kind `{kind}` has no such result; its results are at {has}");
            of(S::CONFLICT, "no-result", "Jobs of this kind have no such result", detail)
        }
        JobError::NoStudy { kind } => {
            let detail = format!("only studies and uncertainty jobs can be resumed; the job is of kind `{kind}`");
            of(S::CONFLICT, "conflict", "The job is not a study", detail)
        }
        JobError::CannotResume(status) => {
            let detail = if status.is_final() {
                format!("the study has {}, and no point is left that a new run could change", ended(*status))
            } else {
                "the study has not ended".to_owned()
            };
            of(S::CONFLICT, "conflict", "The study cannot be resumed", detail)
        }
        JobError::Conflict(status) => {
            let detail = format!("the job has already {}", ended(*status));
            let detail = if status.is_final() { detail } else { "the job has not ended; cancel it first".into() };
            of(S::CONFLICT, "conflict", "The job's status does not allow it", detail)
        }
        JobError::QueueFull { limit, of_owner } => {
            let detail = format!("{limit} jobs{} are queued or running; try again later", whose(*of_owner));
            of(S::TOO_MANY_REQUESTS, "queue-full", "The queue is full", detail)
        }
        JobError::PointsFull { points, unfinished, limit, of_owner } => {
            let detail = format!(
                "studies{} may have {limit} unfinished points; {unfinished} are unfinished, and this study has {points}",
                whose(*of_owner)
            );
            of(S::TOO_MANY_REQUESTS, "queue-full", "Too many points are unfinished", detail)
        }
        JobError::StudyTooLarge { points, limit } => {
            let detail = format!("a grid of {points} points: at most {limit} may be unfinished at a time");
            ApiError::from(Refusal::from(FieldError::new("/axes", detail))).status_and_problem()
        }
        JobError::NoSeries => {
            let detail = "the hash is unknown, or the series was deleted or belongs to another owner".into();
            of(S::NOT_FOUND, "unknown-series", "There is no such series", detail)
        }
        JobError::SeriesExpired { hash, expired_at } => {
            let detail = format!("the series {hash} expired at {expired_at:.0}; upload it again");
            of(S::GONE, "series-expired", "The series has expired", detail)
        }
        JobError::SeriesInUse => {
            let detail = "a queued or running job names the series; wait for its end, or cancel it".into();
            of(S::CONFLICT, "conflict", "The series is in use", detail)
        }
        JobError::SeriesFull { used, limit } => {
            let detail = format!(
                "series of one owner may take {limit} bytes, and {used} are used; delete series that you do not need"
            );
            of(S::CONFLICT, "series-full", "Too many bytes of series are stored", detail)
        }
        JobError::Stopping => {
            let detail = "accepted jobs are not lost; try again".into();
            of(S::SERVICE_UNAVAILABLE, "stopping", "The service is stopping", detail)
        }
        JobError::DiskFull => {
            let detail = "nothing was written; free disk space and try again".into();
            of(S::INSUFFICIENT_STORAGE, "disk-full", "No space is left for the database", detail)
        }
        JobError::Expired(job) => {
            let ExpiredJob { id, kind, status, finished_at, expired_at } = job.as_ref().clone();
            let detail = format!(
                "the job had {} at {finished_at:.0}; it expired at {expired_at:.0} with its result",
                ended(status)
            );
            let title = "The job has expired";
            let last = LastState { id, kind, status: status.into(), finished_at, expired_at };
            (S::GONE, Problem { job: Some(last), ..Problem::new("job-expired", title, detail) })
        }
        JobError::ResultCorrupt { part } => {
            let detail = format!(
                "the stored {part} of this job are not what was written; submit the job again: a corrupt result is not reused"
            );
            of(S::INTERNAL_SERVER_ERROR, "result-corrupt", "The stored result is corrupt", detail)
        }
        JobError::Displaced => {
            of(S::SERVICE_UNAVAILABLE, "database-away", "The database is not available", error.to_string())
        }
        unavailable if unavailable.is_away() => {
            let detail = "the database does not answer; try again".into();
            of(S::SERVICE_UNAVAILABLE, "database-away", "The database is not available", detail)
        }
        _ => internal(),
    }
}

fn whose(of_owner: bool) -> &'static str {
    if of_owner { " of this token's owner" } else { "" }
}

fn ended(status: Status) -> &'static str {
    match status {
        Status::Cancelled => "been cancelled",
        status => status.name(),
    }
}

fn internal() -> (StatusCode, Problem) {
    let detail = "the cause is in the service's log";
    (StatusCode::INTERNAL_SERVER_ERROR, Problem::new("internal", "Internal error of the service", detail))
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let (status, problem) = self.problem();
        if status == StatusCode::INTERNAL_SERVER_ERROR {
            tracing::error!(cause = ?self, "a request was answered with an internal error");
        }
        answer(status, &problem, self.headers())
    }
}

fn answer(status: StatusCode, problem: &Problem, mut headers: HeaderMap) -> Response {
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(PROBLEM_JSON));
    let body = serde_json::to_string(problem).unwrap_or_default();
    (status, headers, body).into_response()
}

/// The error for a status that axum answered itself, without a body or with plain text.
pub fn of_status(status: StatusCode) -> Option<ApiError> {
    Some(match status {
        StatusCode::NOT_FOUND => ApiError::UnknownPath,
        StatusCode::METHOD_NOT_ALLOWED => ApiError::MethodNotAllowed,
        StatusCode::PAYLOAD_TOO_LARGE => ApiError::TooLarge { limit: BODY_LIMIT },
        StatusCode::UNSUPPORTED_MEDIA_TYPE => ApiError::UnsupportedMediaType("application/json is".into()),
        StatusCode::NOT_ACCEPTABLE => ApiError::NotAcceptable { offered: &["gzip", "no encoding at all"] },
        status if status.is_client_error() => ApiError::BadRequest("the request could not be read".into()),
        status if status.is_server_error() => ApiError::Internal,
        _ => return None,
    })
}
