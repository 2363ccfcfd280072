//! What the OpenAPI document says beside the operations: title, tags, tokens, and the errors that
//! operations share.

use std::collections::BTreeMap;

use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityScheme};
use utoipa::openapi::{ContentBuilder, OpenApi as Document, Ref, RefOr, Response, ResponseBuilder};
use utoipa::{IntoResponses, Modify, OpenApi};

use super::error::{PROBLEM_JSON, Problem};

pub const JOBS: &str = "jobs";
pub const RESULTS: &str = "results";
pub const SCENES: &str = "scenes";
pub const HEALTH: &str = "health";

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
        (name = "health", description = "Probes")
    ),
    security(("token" = [])),
    components(schemas(Problem)),
    modifiers(&Tokens)
)]
pub struct Description;

struct Tokens;

impl Modify for Tokens {
    fn modify(&self, document: &mut Document) {
        let text = "One of the tokens of RACEWAY_API_TOKENS; none is needed where the service has none.";
        let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).description(Some(text)).build();
        document.components.get_or_insert_default().add_security_scheme("token", SecurityScheme::Http(scheme));
    }
}

/// Types that stand for errors with their descriptions.
macro_rules! problems {
    ($($(#[$doc:meta])* $name:ident { $($status:literal: $description:literal),+ $(,)? })+) => {$(
        $(#[$doc])*
        pub struct $name;

        impl IntoResponses for $name {
            fn responses() -> BTreeMap<String, RefOr<Response>> {
                BTreeMap::from([$(($status.to_owned(), problem($description))),+])
            }
        }
    )+};
}

problems! {
    /// Every operation that needs a token.
    Anywhere {
        "401": "No token, or an unknown one",
        "421": "Without tokens: a `Host` that is neither an address nor localhost",
        "500": "An error of the service; its cause is in the log",
        "503": "The service is stopping, or its database is away",
    }
    BadBody {
        "400": "The body is not JSON, or a header or the query is wrong",
        "408": "The body did not arrive in time",
        "413": "The body is larger than 1 MiB",
        "415": "The body is not `application/json`",
        "422": "The body is JSON, but not valid; `errors` names the fields",
    }
    BadQuery { "400": "The query is wrong" }
    NoJob { "404": "There is no such job, or it belongs to another token" }
    NoChannel { "404": "There is no such job, or the channel is not kept; `detail` names the kept ones" }
    NoResult { "409": "`result-not-ready`: the job has not ended, try again; `no-result`: it failed or was cancelled, or is of a kind that has no such result" }
    NotAccepted { "406": "The answer is not available in a format that `Accept` names" }
    QueueFull { "429": "The queue is full; `Retry-After` tells when to try again" }
    NoSpace { "507": "No space is left for the database; nothing was written" }
}

fn problem(description: &str) -> RefOr<Response> {
    let schema = Ref::from_schema_name("Problem");
    let content = ContentBuilder::new().schema(Some(schema)).build();
    ResponseBuilder::new().description(description).content(PROBLEM_JSON, content).build().into()
}
