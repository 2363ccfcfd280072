//! HTTP. Every route stands on this page; what a status code means for an error stands in `error`. Knows
//! contract and jobs; nothing is computed here.

pub mod auth;
pub mod service;

mod answers;
mod describe;
mod error;
mod health;
mod jobs;
mod patience;
mod plots;
mod refusals;
mod request;
mod results;
mod scenes;
mod server;
mod studies;

use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::header::CONTENT_TYPE;
use axum::middleware;
use axum::response::Redirect;
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::trace::TraceLayer;
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
}

/// Who may ask.
#[derive(Debug, Default)]
pub struct Access {
    pub tokens: auth::Tokens,
    /// Answer only requests whose Host is an address or localhost.
    pub only_local_hosts: bool,
}

/// Every described route.
fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(describe::Description::openapi())
        .routes(routes!(jobs::submit, jobs::list))
        .routes(routes!(jobs::show, jobs::delete))
        .routes(routes!(jobs::cancel))
        .routes(routes!(results::metrics))
        .routes(routes!(results::spectrum))
        .routes(routes!(results::series))
        .routes(routes!(results::accuracy))
        .routes(routes!(results::optimum))
        .routes(routes!(studies::table))
        .routes(routes!(studies::resume))
        .routes(routes!(plots::plot))
        .routes(routes!(scenes::resolve))
        .routes(routes!(scenes::presets))
        .routes(routes!(health::live))
        .routes(routes!(health::ready))
}

/// The OpenAPI document.
pub fn document() -> Document {
    routes().into_openapi()
}

/// The OpenAPI document as it is printed and checked in.
pub fn document_text() -> String {
    let mut text = serde_json::to_string_pretty(&document()).unwrap_or_default();
    text.push('\n');
    text
}

/// The whole service.
pub fn router(app: App) -> Router {
    let (described, document) = routes().split_for_parts();
    let document = serde_json::to_string(&document).unwrap_or_default();
    let send_document = || async move { ([(CONTENT_TYPE, "application/json")], document) };
    described
        .route("/", get(|| async { Redirect::temporary("/docs/") }))
        .route("/openapi.json", get(send_document))
        .merge(SwaggerUi::new("/docs").config(Config::from("/openapi.json")))
        .layer(middleware::from_fn_with_state(app.clone(), auth::guard))
        .layer(middleware::from_fn(refusals::as_problems))
        .layer(CatchPanicLayer::custom(refusals::of_panic))
        .layer(CompressionLayer::new())
        .layer(TraceLayer::new_for_http())
        // Bodies are read by our own extractor, which has the limit.
        .layer(DefaultBodyLimit::disable())
        .with_state(app)
}
