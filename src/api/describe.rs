//! What the OpenAPI document says beside the operations: title, tags, tokens, and the errors that
//! operations share.

use std::collections::BTreeMap;

use axum::http::header::{ACCEPT, HeaderName, HeaderValue, RETRY_AFTER, WWW_AUTHENTICATE};
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
use super::jobs::wrong_wait;
use super::request::BODY_LIMIT;
use crate::contract::job::schema;
use crate::contract::{FieldError, Refusal};
use crate::jobs::{JobError, Status};

pub const JOBS: &str = "jobs";
pub const RESULTS: &str = "results";
pub const SCENES: &str = "scenes";
pub const HEALTH: &str = "health";
pub const DOCUMENT: &str = "document";

/// The document without its operations, which bring themselves.
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
        (name = "scenes", description = "What a scene means before it runs"),
        (name = "health", description = "Probes"),
        (name = "document", description = "This description; as a page at `/docs/`")
    ),
    security(("token" = [])),
    components(schemas(Problem)),
    modifiers(&Tokens)
)]
pub struct Description;

struct Tokens;

impl Modify for Tokens {
    fn modify(&self, document: &mut Document) {
        let text = "A token made by `raceway token create`, or one of RACEWAY_API_TOKENS; none is needed where there never was any.";
        let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).description(Some(text)).build();
        document.components.get_or_insert_default().add_security_scheme("token", SecurityScheme::Http(scheme));
    }
}

/// Types that stand for errors: status, name in the document, when it comes, and what is answered then.
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

/// Results of succeeded jobs, which never change.
pub struct Unchanged;

impl IntoResponses for Unchanged {
    fn responses() -> BTreeMap<String, RefOr<Response>> {
        let text =
            "The result that `If-None-Match` names, which never changes; each answer of a succeeded job has an `ETag`";
        BTreeMap::from([("304".to_owned(), ResponseBuilder::new().description(text).build().into())])
    }
}

problems! {
    /// Every operation that needs a token.
    Anywhere {
        "401" Unauthorized: "No token, or an unknown one" => [Unauthorized],
        "421" ForeignHost: "Without tokens: a `Host` that is neither an address nor localhost" => [ForeignHost("raceway.example".into())],
        "429" TooOften: "The token asks more often than it may; `Retry-After` tells when to try again" => [TooOften { limit: 1000, wait_s: 1 }],
        "500" InternalError: "An error of the service; its cause is in the log" => [Internal],
        "503" Unavailable: "The service is stopping or busy, or its database is away" => [Job(JobError::Stopping), Overloaded, Job(JobError::Database(sqlx::Error::PoolTimedOut))],
    }
    /// Operations that are open to everybody.
    OnlyLocal { "421" ForeignHost: "Without tokens: a `Host` that is neither an address nor localhost" => [ForeignHost("raceway.example".into())] }
    /// Operations with a body.
    BadBody {
        "400" BadRequest: "The body is not JSON, or a header or the query is wrong" => [
            Refused(Refusal::NotJson { detail: "expected `,` or `}` at line 3 column 5".into() }),
            wrong_wait("1min"),
        ],
        "408" SlowBody: "The body did not arrive in time" => [SlowBody],
        "413" TooLarge: "The body is larger than 1 MiB" => [TooLarge { limit: BODY_LIMIT }],
        "415" UnsupportedMediaType: "The body is not `application/json`" => [UnsupportedMediaType("send Content-Type: application/json".into())],
        "422" InvalidRequest: "The body is JSON, but not valid; `errors` names the fields" => [Refused(wrong_diameter())],
    }
    BadQuery { "400" BadQuery: "The query is wrong" => [BadRequest("query: limit 0: must be 1 to 200".into())] }
    NoJob { "404" UnknownJob: "There is no such job, or it belongs to another token" => [UnknownJob] }
    NoChannel {
        "404" UnknownChannel: "There is no such job, or the channel is not kept; `detail` names the kept ones" => [
            UnknownJob,
            UnknownChannel { channel: "cage.speed".into(), kept: vec!["spindle.y.acceleration".into()] },
        ],
    }
    NoPlot {
        "404" UnknownPlot: "There is no such job, or it has no such plot; `detail` names those it has" => [
            UnknownJob,
            UnknownPlot { known: &["spectrum.svg", "velocity.svg", "acceleration.svg"] },
        ],
    }
    NoResult {
        "409" NoResult: "`result-not-ready`: the job has not ended, try again; `no-result`: it failed or was cancelled, or is of a kind that has no such result" => [
            Job(JobError::NotReady(Status::Running)),
            Job(JobError::NoResult(Status::Failed)),
        ],
    }
    HasEnded { "409" HasEnded: "The job has succeeded or failed" => [Job(JobError::Conflict(Status::Succeeded))] }
    HasNotEnded { "409" HasNotEnded: "The job waits or runs" => [Job(JobError::Conflict(Status::Running))] }
    CannotResume {
        "409" CannotResume: "The job is no study, it waits or runs, or nothing is left to do" => [Job(JobError::CannotResume(Status::Running))],
    }
    NotAccepted { "406" NotAcceptable: "The answer is not available in a format that `Accept` names" => [NotAcceptable { offered: &["application/json"] }] }
    QueueFull { "429" QueueFull: "The queue is full, or the token asks more often than it may; `Retry-After` tells when to try again" => [Job(JobError::QueueFull { limit: 10_000 }), TooOften { limit: 1000, wait_s: 1 }] }
    NoSpace { "507" NoSpace: "No space is left for the database; nothing was written" => [Job(JobError::DiskFull)] }
    TakesNoJobs { "503" TakesNoJobs: "The service takes no jobs now" => [NotReady(JobError::Stopping)] }
}

fn wrong_diameter() -> Refusal {
    FieldError::new("/scene/bearing/ball_diameter_mm", "-1 mm: must be from 0.1 to 500 mm").into()
}

/// A response with what is answered in each case, by the kind of problem.
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

/// A header of an error.
fn documented((name, value): (Option<HeaderName>, HeaderValue)) -> Option<(&'static str, Header)> {
    let (name, kind, description) = match name? {
        RETRY_AFTER => ("Retry-After", Type::Integer, "Seconds after which to try again"),
        WWW_AUTHENTICATE => ("WWW-Authenticate", Type::String, "How to send a token"),
        ACCEPT => ("Accept", Type::String, "What a body may be"),
        _ => return None,
    };
    let value = value.to_str().ok()?;
    let example = value.parse::<u64>().map_or_else(|_| value.into(), Value::from);
    let schema = ObjectBuilder::new().schema_type(kind).examples([example]);
    Some((name, HeaderBuilder::new().schema(Some(schema)).description(Some(description)).build()))
}

/// Answers of a run of the service, by operation and status.
const EXAMPLES: &str = include_str!("examples.json");

/// The document with what its operations share: problems by name, examples of answers, and where a job leads.
pub fn completed(mut document: Document) -> Document {
    let examples: Value = serde_json::from_str(EXAMPLES).unwrap_or_default();
    let components = document.components.get_or_insert_default();
    components.responses.extend(problems().into_iter().map(|(name, response)| (name.to_owned(), response.into())));
    components.links.extend(links_of_job().map(|(name, link)| (name.to_owned(), link.into())));
    schema::complete(&mut components.schemas);
    name_requests(&mut document);
    for operation in operations(&mut document) {
        let examples = &examples[operation.operation_id.as_deref().unwrap_or_default()];
        for (status, response) in &mut operation.responses.responses {
            let RefOr::T(response) = response else { continue };
            complete(response, &examples[status.as_str()]);
        }
    }
    document
}

/// Every request may bring a name, and every answer has it.
fn name_requests(document: &mut Document) {
    const NAME: &str = "X-Request-Id";
    let text = || ObjectBuilder::new().schema_type(Type::String).build();
    let parameter = ParameterBuilder::new()
        .name(NAME)
        .parameter_in(ParameterIn::Header)
        .required(Required::False)
        .description(Some(
            "A name of the client's for this request, at most 128 visible ASCII characters, which the answer and the log repeat; \
             in the place of another, or of none, the service makes one",
        ))
        .schema(Some(text()))
        .example(Some("portal-17".into()));
    let header = HeaderBuilder::new().schema(Some(text())).description(Some("The request's name, as in the log"));
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

/// Operations on a job that an answer has told of.
fn links_of_job() -> impl Iterator<Item = (&'static str, Link)> {
    const ALWAYS: &str = "The job";
    const OF_SIMULATION: &str = "Of a simulation that has succeeded";
    let links = [
        ("showJob", ALWAYS, None),
        ("followJob", ALWAYS, None),
        ("getChannels", OF_SIMULATION, None),
        ("cancelJob", "While it has not ended", None),
        ("deleteJob", "Once it has ended", None),
        ("resumeStudy", "Of a study that was cancelled or failed", None),
        ("getMetrics", OF_SIMULATION, None),
        ("getSpectrum", OF_SIMULATION, Some(("channel", "spindle.y.acceleration"))),
        ("getSeries", "Of a simulation that was asked for it", Some(("channel", "spindle.y.displacement"))),
        ("getPlot", OF_SIMULATION, Some(("file", "spectrum.svg"))),
        ("getTable", "Of a study", None),
        ("getOptimum", "Of an optimum job that has succeeded", None),
        ("getAccuracy", "Of an accuracy job that has succeeded", None),
    ];
    links.into_iter().map(|(operation, description, more)| {
        let link =
            Link::builder().operation_id(operation).description(description).parameter("id", "$response.body#/id");
        let link = more.into_iter().fold(link, |link, (name, value)| link.parameter(name, value));
        (operation, link.build())
    })
}
