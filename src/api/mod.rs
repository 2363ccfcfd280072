//! HTTP. Every route stands on this page; what a status code means for an error stands in `error`. Knows
//! contract and jobs; nothing is computed here.

pub mod auth;
pub mod origins;
pub mod service;

mod answers;
mod batch;
mod conditional;
mod describe;
mod error;
mod events;
/// Requests without a service behind them.
#[cfg(fuzzing)]
#[doc(hidden)]
pub mod fuzzing;
mod health;
mod jobs;
mod load;
mod patience;
mod plots;
mod portal;
pub mod rates;
mod refusals;
mod request;
mod request_id;
mod results;
mod scenes;
mod server;
mod studies;

use std::sync::{Arc, LazyLock};

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::HeaderValue;
use axum::http::header::CONTENT_TYPE;
use axum::middleware;
use axum::response::IntoResponse;
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Document;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::{Config, SwaggerUi};

use crate::jobs::Jobs;

pub use error::{ApiError, Problem};

/// What the handlers share.
#[derive(Clone)]
pub struct App {
    pub jobs: Jobs,
    pub access: Arc<Access>,
    pub load: load::Load,
}

impl App {
    pub fn new(jobs: Jobs, access: Access) -> Self {
        Self { jobs, access: Arc::new(access), load: load::Load::default() }
    }
}

/// Who may ask.
#[derive(Debug, Default)]
pub struct Access {
    /// Tokens from the environment, beside those of the database.
    pub tokens: auth::Tokens,
    /// Whether only this machine can ask: then, without tokens, the Host must be an address or localhost.
    pub is_local: bool,
    pub rates: rates::Rates,
    /// Origins of web pages from elsewhere that may use the API.
    pub origins: Vec<HeaderValue>,
}

/// Every described route.
fn routes(app: &Option<App>) -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(describe::Description::openapi())
        .routes(routes!(jobs::submit, jobs::list))
        .routes(routes!(batch::submit))
        .routes(routes!(jobs::show, jobs::delete))
        .routes(routes!(jobs::cancel))
        .routes(routes!(studies::resume))
        .routes(routes!(events::events))
        .merge(results_of_jobs(app))
        .routes(routes!(scenes::resolve))
        .routes(routes!(scenes::presets))
        .routes(routes!(health::live))
        .routes(routes!(health::ready))
        .routes(routes!(health::figures))
        .routes(routes!(send_document))
}

/// Get this document
///
/// OpenAPI 3.1: every operation with its fields, units and ranges.
#[utoipa::path(
    get, path = "/openapi.json", tag = describe::DOCUMENT, operation_id = "getDocument", security(()),
    responses((status = 200, description = "The document", body = BTreeMap<String, serde_json::Value>), describe::OnlyLocal)
)]
async fn send_document() -> impl IntoResponse {
    static TEXT: LazyLock<String> = LazyLock::new(|| serde_json::to_string(&document()).unwrap_or_default());
    ([(CONTENT_TYPE, "application/json")], TEXT.as_str())
}

/// What a job leaves; tagged, where there is a service behind it.
fn results_of_jobs(app: &Option<App>) -> OpenApiRouter<App> {
    let routes = OpenApiRouter::new()
        .routes(routes!(results::metrics))
        .routes(routes!(results::channels))
        .routes(routes!(results::spectrum))
        .routes(routes!(results::series))
        .routes(routes!(results::accuracy))
        .routes(routes!(results::optimum))
        .routes(routes!(studies::table))
        .routes(routes!(plots::plot));
    match app {
        Some(app) => routes.layer(middleware::from_fn_with_state(app.clone(), conditional::results)),
        None => routes,
    }
}

/// The OpenAPI document.
pub fn document() -> Document {
    describe::completed(routes(&None).into_openapi())
}

/// The OpenAPI document as it is printed and checked in.
pub fn document_text() -> String {
    let mut text = serde_json::to_string_pretty(&document()).unwrap_or_default();
    text.push('\n');
    text
}

/// The whole service.
pub fn router(app: App) -> Router {
    let (described, _) = routes(&Some(app.clone())).split_for_parts();
    let open = described
        .route("/", get(portal::page))
        .route("/portal/{*file}", get(portal::file))
        .merge(SwaggerUi::new("/docs").config(Config::from("/openapi.json")));
    enclosed(open, app)
}

/// Routes within what holds for every request: who may ask, how much at a time, and how errors look.
fn enclosed(routes: Router<App>, app: App) -> Router {
    let guarded = routes
        .layer(middleware::from_fn_with_state(app.clone(), load::limit))
        .layer(middleware::from_fn_with_state(app.clone(), auth::guard));
    // Browsers ask before they send a token.
    let shared = match app.access.origins.as_slice() {
        [] => guarded,
        origins => guarded.layer(origins::allowed(origins)),
    };
    shared
        .layer(CatchPanicLayer::custom(refusals::of_panic))
        .layer(middleware::from_fn(request::limit_header))
        .layer(CompressionLayer::new())
        .layer(middleware::from_fn(refusals::as_problems))
        .layer(middleware::from_fn(request_id::named))
        // Bodies are read by our own extractor, which has the limit.
        .layer(DefaultBodyLimit::disable())
        .with_state(app)
}

/// What a worker answers, which takes no jobs: how it is.
fn probes(app: App) -> Router {
    enclosed(health_routes().route("/metrics", get(health::figures)), app)
}

/// What is answered where all connections are taken: how the service is, to those who would restart it otherwise.
pub fn lobby(app: App) -> Router {
    health_routes()
        .fallback(|| std::future::ready(ApiError::Overloaded))
        .layer(middleware::from_fn_with_state(app.clone(), auth::guard))
        .with_state(app)
}

fn health_routes() -> Router<App> {
    Router::new().route("/health/live", get(health::live)).route("/health/ready", get(health::ready))
}
