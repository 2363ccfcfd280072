//! The OpenAPI document beside its operations: title, tags, tokens, shared error responses, examples and links.

use std::collections::BTreeMap;

use axum::http::header::{ACCEPT, CONTENT_RANGE, HeaderName, HeaderValue, RETRY_AFTER, WWW_AUTHENTICATE};
use serde_json::Value;
use utoipa::openapi::example::Example;
use utoipa::openapi::header::{Header, HeaderBuilder};
use utoipa::openapi::link::Link;
use utoipa::openapi::path::{Operation, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityScheme};
use utoipa::openapi::{ContentBuilder, OpenApi as Document, Ref, RefOr, Required, Response, ResponseBuilder};
use utoipa::{IntoResponses, Modify, OpenApi};

use super::error::{ApiError, PROBLEM_JSON, Problem};
use super::limits::{BODY_LIMIT, SERIES_LIMIT};
use super::submission_headers::wrong_wait;
use crate::contract::job::machine::MachineInput;
use crate::contract::job::mode_comparison::ModeComparisonInput;
use crate::contract::job::schema;
use crate::contract::{FieldError, Refusal};
use crate::jobs::{ExpiredJob, JobError, Status};

pub const JOBS: &str = "jobs";
pub const RESULTS: &str = "results";
pub const SCENES: &str = "scenes";
pub const HEALTH: &str = "health";
pub const DOCUMENT: &str = "document";

/// The document without its operations, which the routes add.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "raceway",
        description = "Predicts the vibration of rolling bearings: full dynamics of balls, cage and spindle, as \
                       jobs. Post a scene, wait for the job, read its metrics and spectra. Every field carries its \
                       unit in its name; errors are problem details (RFC 9457).",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
        contact(name = "raceway")
    ),
    servers((url = "/", description = "This service")),
    tags(
        (name = "jobs", description = "Submit, follow, cancel and delete simulations"),
        (name = "results", description = "Metrics, spectra, series and plots of succeeded jobs"),
        (name = "scenes", description = "Scenes before they run"),
        (name = "health", description = "Probes and service metrics"),
        (name = "document", description = "This description; as a page at `/docs/`")
    ),
    security(("token" = [])),
    components(schemas(Problem, MachineInput, ModeComparisonInput)),
    modifiers(&TokenScheme)
)]
pub struct Description;

struct TokenScheme;

impl Modify for TokenScheme {
    fn modify(&self, document: &mut Document) {
        let text = "A token from `raceway token create` or RACEWAY_API_TOKENS. Without any token the API is open.";
        let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).description(Some(text)).build();
        document.components.get_or_insert_default().add_security_scheme("token", SecurityScheme::Http(scheme));
    }
}

/// Groups of error responses: status, name in the document, description, and the errors that serve as examples.
macro_rules! problems {
    ($($(#[$doc:meta])* $group:ident {
        $($status:literal $name:ident: $description:literal => [$($error:expr),+ $(,)?]),+ $(,)?
    })+) => {
        $(
            $(#[$doc])*
            pub struct $group;

            impl IntoResponses for $group {
                fn responses() -> BTreeMap<String, RefOr<Response>> {
                    let named = |name| RefOr::Ref(Ref::from_response_name(name));
                    BTreeMap::from([$(($status.to_owned(), named(stringify!($name)))),+])
                }
            }
        )+

        fn problems() -> Vec<(&'static str, Response)> {
            use ApiError::*;
            vec![$($((stringify!($name), problem($description, &[$($error),+]))),+),+]
        }
    };
}

/// The answer 304 of results.
pub struct Unchanged;

impl IntoResponses for Unchanged {
    fn responses() -> BTreeMap<String, RefOr<Response>> {
        let text =
            "The client has the result: its `ETag` is in `If-None-Match`. Results of succeeded jobs never change";
        BTreeMap::from([("304".to_owned(), ResponseBuilder::new().description(text).build().into())])
    }
}

problems! {
    /// Errors of every operation that needs a token.
    Anywhere {
        "401" Unauthorized: "The token is missing or unknown" => [Unauthorized],
        "421" ForeignHost: "Without tokens: the `Host` is neither an IP address nor localhost" => [ForeignHost("raceway.example".into())],
        "429" TooOften: "The owner of the token has sent too many requests; try again after `Retry-After`" => [TooOften { limit: 1000, wait_s: 1, of_submissions: false }],
        "500" InternalError: "An internal error; its cause is in the log of the service. `result-corrupt`: a stored result is not what was written" => [Internal, Job(JobError::ResultCorrupt { part: "metrics".into() })],
        "503" Unavailable: "The service is stopping or busy, or its database is not available" => [Job(JobError::Stopping), Overloaded, Job(JobError::Database(sqlx::Error::PoolTimedOut))],
    }
    /// Errors of operations that need no token.
    OnlyLocal { "421" ForeignHost: "Without tokens: the `Host` is neither an IP address nor localhost" => [ForeignHost("raceway.example".into())] }
    /// Errors of operations with a body.
    BadBody {
        "400" BadRequest: "The body is not JSON, or a header or the query is not valid" => [
            Refused(Refusal::NotJson { detail: "expected `,` or `}` at line 3 column 5".into() }),
            wrong_wait("1min"),
        ],
        "408" SlowBody: "The body did not arrive in time" => [SlowBody],
        "413" TooLarge: "The body is larger than 1 MiB" => [TooLarge { limit: BODY_LIMIT }],
        "415" UnsupportedMediaType: "The body is not `application/json`" => [UnsupportedMediaType("send Content-Type: application/json".into())],
        "422" InvalidRequest: "The body is JSON but not a valid request; `errors` lists the invalid fields" => [Refused(wrong_diameter())],
    }
    BadSeries {
        "400" BadRequest: "The body is not JSON, or a header or the query is not valid" => [
            Refused(Refusal::NotJson { detail: "expected `,` or `}` at line 3 column 5".into() }),
            wrong_wait("1min"),
        ],
        "408" SlowBody: "The body did not arrive in time" => [SlowBody],
        "409" SeriesFull: "The series of the owner would take too many bytes" => [Job(JobError::SeriesFull { used: 1_073_000_000, limit: 1_073_741_824 })],
        "413" SeriesTooLarge: "The body is larger than 32 MiB" => [TooLarge { limit: SERIES_LIMIT }],
        "415" SeriesMediaType: "The body is neither JSON nor CSV" => [UnsupportedMediaType("send Content-Type: application/json or text/csv".into())],
        "422" WrongSeries: "The values or their rate are not valid" => [Refused(FieldError::new("/values", "1 values: must be from 2 to 2000000, all finite").into())],
    }
    NoSeries {
        "404" UnknownSeries: "There is no such series, or it belongs to another owner" => [Job(JobError::NoSeries)],
        "410" SeriesExpired: "The series has expired" => [expired_series()],
    }
    NamesExpired {
        "410" NamedSeriesExpired: "A load names a series that has expired" => [expired_series()],
    }
    SeriesInUse { "409" SeriesInUse: "An unfinished job names the series" => [Job(JobError::SeriesInUse)] }
    BadRange { "416" BadRange: "`Range` begins behind the end of the file" => [Unsatisfiable { length: 163_968 }] }
    BadQuery { "400" BadQuery: "The query is not valid" => [BadRequest("query: limit 0: must be 1 to 200".into())] }
    NoJob {
        "404" UnknownJob: "There is no such job, or it belongs to another owner" => [UnknownJob],
        "410" JobExpired: "The job has expired; `job` has its last state" => [expired()],
    }
    NoChannel {
        "404" UnknownChannel: "There is no such job, or the channel is not kept; `detail` lists the kept channels" => [
            UnknownJob,
            UnknownChannel { channel: "cage.speed".into(), kept: vec!["spindle.y.acceleration".into()] },
        ],
        "410" JobExpired: "The job has expired; `job` has its last state" => [expired()],
    }
    NoComparison {
        "404" UnknownJob: "There is no such job, or it belongs to another owner" => [UnknownJob],
        "410" ComparisonExpired: "The job has expired, and `job` has its last state; or a series has expired" => [expired(), expired_series()],
    }
    NoPlot {
        "404" UnknownPlot: "There is no such job, or it has no such plot; `detail` lists its plots" => [
            UnknownJob,
            UnknownPlot { known: &["spectrum.svg", "velocity.svg", "acceleration.svg"] },
        ],
        "410" JobExpired: "The job has expired; `job` has its last state" => [expired()],
    }
    KeyExpired { "410" SubmissionExpired: "The job of the key has expired, and `job` has its last state; or a load names a series that has expired" => [expired(), expired_series()] }
    NoResult {
        "409" NoResult: "`result-not-ready`: the job has not ended; try again. `no-result`: the job failed, was cancelled, or is of a kind without such a result" => [
            Job(JobError::NotReady(Status::Running)),
            Job(JobError::NoResult(Status::Failed)),
        ],
    }
    HasEnded { "409" HasEnded: "The job has succeeded or failed" => [Job(JobError::Conflict(Status::Succeeded))] }
    HasNotEnded { "409" HasNotEnded: "The job is queued or running" => [Job(JobError::Conflict(Status::Running))] }
    CannotResume {
        "409" CannotResume: "The job is not a study, has not ended, or has no points left to run" => [Job(JobError::CannotResume(Status::Running))],
    }
    NotAccepted { "406" NotAcceptable: "The answer is not available in a format of `Accept`" => [NotAcceptable { offered: &["application/json"] }] }
    QueueFull { "429" QueueFull: "The queue is full, or the owner of the token has sent too many requests, jobs or points; try again after `Retry-After`" => [Job(JobError::QueueFull { limit: 10_000, of_owner: false }), Job(JobError::PointsFull { points: 10_000, unfinished: 45_000, limit: 50_000, of_owner: true }), TooOften { limit: 1000, wait_s: 1, of_submissions: false }] }
    NoSpace { "507" NoSpace: "No space is left for the database; nothing was written" => [Job(JobError::DiskFull)] }
    TakesNoJobs { "503" TakesNoJobs: "The service accepts no jobs now" => [NotReady(JobError::Stopping)] }
}

fn expired() -> ApiError {
    let at =
        jiff::Timestamp::UNIX_EPOCH.saturating_add(jiff::SignedDuration::from_secs(1_767_225_600)).unwrap_or_default();
    let expired_at = at.saturating_add(jiff::SignedDuration::from_hours(720)).unwrap_or_default();
    ApiError::Job(JobError::Expired(Box::new(ExpiredJob {
        id: uuid::uuid!("01919f5c-8c4e-7d3a-9a51-2f6d1b0c4e7f"),
        kind: "simulation".into(),
        status: Status::Succeeded,
        finished_at: at,
        expired_at,
    })))
}

fn expired_series() -> ApiError {
    let expired_at = jiff::Timestamp::UNIX_EPOCH.saturating_add(jiff::SignedDuration::from_secs(1_769_817_600));
    let hash = "0f".repeat(32);
    ApiError::Job(JobError::SeriesExpired { hash, expired_at: expired_at.unwrap_or_default() })
}

fn wrong_diameter() -> Refusal {
    FieldError::new("/scene/bearing/ball_diameter_mm", "-1 mm: must be from 0.1 to 500 mm").into()
}

/// A response with one example for each error, by the kind of problem.
fn problem(description: &str, errors: &[ApiError]) -> Response {
    let schema = Ref::from_schema_name("Problem");
    let problems = errors.iter().map(|error| error.problem().1);
    let examples = problems.map(|problem| {
        let name = problem.kind.rsplit(':').next().unwrap_or_default().to_owned();
        (name, Example::builder().summary(&problem.title).value(serde_json::to_value(&problem).ok()).build())
    });
    let content = ContentBuilder::new().schema(Some(schema)).examples_from_iter(examples).build();
    let response = ResponseBuilder::new().description(description).content(PROBLEM_JSON, content);
    let headers: BTreeMap<&str, Header> =
        errors.iter().flat_map(|error| error.headers()).filter_map(documented).collect();
    headers.into_iter().fold(response, |response, (name, header)| response.header(name, header)).build()
}

/// Documentation of a header of an error.
fn documented((name, value): (Option<HeaderName>, HeaderValue)) -> Option<(&'static str, Header)> {
    let (name, kind, description) = match name? {
        RETRY_AFTER => ("Retry-After", Type::Integer, "Seconds after which to try again"),
        WWW_AUTHENTICATE => ("WWW-Authenticate", Type::String, "How to send a token"),
        ACCEPT => ("Accept", Type::String, "Supported media type of the body"),
        CONTENT_RANGE => ("Content-Range", Type::String, "Length of the file"),
        _ => return None,
    };
    let value = value.to_str().ok()?;
    let example = value.parse::<u64>().map_or_else(|_| value.into(), Value::from);
    let schema = ObjectBuilder::new().schema_type(kind).examples([example]);
    Some((name, HeaderBuilder::new().schema(Some(schema)).description(Some(description)).build()))
}

/// Recorded answers, by operation and status.
const EXAMPLES: &str = include_str!("examples.json");

/// The document completed by shared responses, recorded examples, and links from a job to its operations.
pub fn completed(mut document: Document) -> Document {
    let examples: Value = serde_json::from_str(EXAMPLES).unwrap_or_default();
    let components = document.components.get_or_insert_default();
    components.responses.extend(problems().into_iter().map(|(name, response)| (name.to_owned(), response.into())));
    components.links.extend(links_of_job().map(|(name, link)| (name.to_owned(), link.into())));
    schema::complete(&mut components.schemas);
    add_request_id(&mut document);
    for operation in operations(&mut document) {
        let examples = &examples[operation.operation_id.as_deref().unwrap_or_default()];
        for (status, response) in &mut operation.responses.responses {
            let RefOr::T(response) = response else { continue };
            complete(response, &examples[status.as_str()]);
        }
    }
    document
}

/// Adds the request id, which every request may and every answer does contain.
fn add_request_id(document: &mut Document) {
    const NAME: &str = "X-Request-Id";
    let text = || ObjectBuilder::new().schema_type(Type::String).build();
    let parameter = ParameterBuilder::new()
        .name(NAME)
        .parameter_in(ParameterIn::Header)
        .required(Required::False)
        .description(Some(
            "An id of the client for this request, at most 128 visible ASCII characters; the answer and the log repeat it. The \
             service replaces a missing or invalid id",
        ))
        .schema(Some(text()))
        .example(Some("portal-17".into()));
    let header = HeaderBuilder::new().schema(Some(text())).description(Some("The id of the request, as in the log"));
    let components = document.components.get_or_insert_default();
    components.parameters.insert(NAME.to_owned(), parameter.build().into());
    components.headers.insert(NAME.to_owned(), header.build().into());
    let named = |response: &mut RefOr<Response>| {
        if let RefOr::T(response) = response {
            let header = Ref::new(format!("#/components/headers/{NAME}"));
            response.headers.insert(NAME.to_owned(), RefOr::Ref(header));
        }
    };
    components.responses.values_mut().for_each(named);
    for operation in operations(document) {
        let parameter = Ref::new(format!("#/components/parameters/{NAME}"));
        operation.parameters.get_or_insert_default().push(RefOr::Ref(parameter));
        operation.responses.responses.values_mut().for_each(named);
    }
}

fn operations(document: &mut Document) -> impl Iterator<Item = &mut Operation> {
    let items = document.paths.paths.values_mut();
    items.flat_map(|item| [&mut item.get, &mut item.post, &mut item.delete].into_iter().flatten())
}

fn complete(response: &mut Response, example: &Value) {
    let Some(RefOr::T(content)) = response.content.get_mut("application/json") else { return };
    if !example.is_null() {
        content.example = Some(example.clone());
    }
    if matches!(&content.schema, Some(RefOr::Ref(schema)) if schema.ref_location.ends_with("/JobAnswer")) {
        let named =
            |(name, _): (&str, _)| (name.to_owned(), RefOr::Ref(Ref::new(format!("#/components/links/{name}"))));
        response.links = links_of_job().map(named).collect();
    }
}

/// Links from a job in an answer to the operations on it.
fn links_of_job() -> impl Iterator<Item = (&'static str, Link)> {
    const ALWAYS: &str = "The job";
    const OF_SIMULATION: &str = "For a succeeded simulation";
    let links = [
        ("showJob", ALWAYS, None),
        ("followJob", ALWAYS, None),
        ("getChannels", OF_SIMULATION, None),
        ("cancelJob", "Until the job has ended", None),
        ("deleteJob", "When the job has ended", None),
        ("resumeStudy", "For a study or an uncertainty job that was cancelled or failed", None),
        ("getMetrics", OF_SIMULATION, None),
        ("getSpectrum", OF_SIMULATION, Some(("channel", "spindle.y.acceleration"))),
        ("getBands", OF_SIMULATION, None),
        ("getSeries", "For a simulation with requested series", Some(("channel", "spindle.y.displacement"))),
        ("getOrders", "For a simulation with requested orders or series", None),
        ("getWaterfall", "For a simulation with requested orders or series", None),
        ("getPlot", OF_SIMULATION, Some(("file", "spectrum.svg"))),
        ("getTable", "For a study or an uncertainty job", None),
        ("getUncertainty", "For an uncertainty job", None),
        ("getOptimum", "For a succeeded optimum job", None),
        ("getAccuracy", "For a succeeded accuracy job", None),
        ("getRotor", "For a succeeded rotor job", None),
        ("getRotorScript", "For a succeeded rotor job", None),
        ("getMachine", "For a succeeded machine job", None),
    ];
    links.into_iter().map(|(operation, description, more)| {
        let link =
            Link::builder().operation_id(operation).description(description).parameter("id", "$response.body#/id");
        let link = more.into_iter().fold(link, |link, (name, value)| link.parameter(name, value));
        (operation, link.build())
    })
}
