//! Every route, and the layers that hold for every request: access, concurrency, and the form of errors.

use std::sync::LazyLock;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::header::CONTENT_TYPE;
use axum::middleware;
use axum::response::IntoResponse;
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{DefaultPredicate, NotForContentType, Predicate};
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Document;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::{Config, SwaggerUi};

use super::app::App;
use super::error::ApiError;
use super::stored_answer::NPY;
use super::{
    auth, batch, comparison, concurrency, conditional, cors, error_layers, events, health, jobs, machine, openapi,
    orders, plots, portal, preview, request, request_id, results, rotor, scenes, studies, uploaded_series,
};

/// Every documented route.
fn routes(app: &Option<App>) -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(openapi::Description::openapi())
        .routes(routes!(jobs::submit, jobs::list))
        .routes(routes!(batch::submit))
        .routes(routes!(jobs::show, jobs::delete))
        .routes(routes!(jobs::cancel))
        .routes(routes!(studies::resume))
        .routes(routes!(events::events))
        .merge(result_routes(app))
        .routes(routes!(comparison::compare))
        .routes(routes!(scenes::resolve))
        .routes(routes!(scenes::presets))
        .routes(routes!(scenes::catalogue))
        .routes(routes!(uploaded_series::upload, uploaded_series::list))
        .routes(routes!(uploaded_series::show, uploaded_series::delete))
        .routes(routes!(rotor::analyse))
        .routes(routes!(machine::resolve))
        .routes(routes!(preview::run))
        .routes(routes!(health::live))
        .routes(routes!(health::ready))
        .routes(routes!(health::service_metrics))
        .routes(routes!(send_document))
}

/// Get this document
///
/// OpenAPI 3.1: every operation with its fields, units and ranges.
#[utoipa::path(
    get, path = "/openapi.json", tag = openapi::DOCUMENT, operation_id = "getDocument", security(()),
    responses((status = 200, description = "The document", body = BTreeMap<String, serde_json::Value>), openapi::OnlyLocal)
)]
async fn send_document() -> impl IntoResponse {
    static TEXT: LazyLock<String> = LazyLock::new(|| serde_json::to_string(&document()).unwrap_or_default());
    ([(CONTENT_TYPE, "application/json")], TEXT.as_str())
}

/// Results of jobs. With an `app` they carry ETags.
fn result_routes(app: &Option<App>) -> OpenApiRouter<App> {
    let routes = OpenApiRouter::new()
        .routes(routes!(results::metrics))
        .routes(routes!(results::channels))
        .routes(routes!(results::spectrum))
        .routes(routes!(results::bands))
        .routes(routes!(results::series))
        .routes(routes!(orders::orders))
        .routes(routes!(orders::waterfall))
        .routes(routes!(results::accuracy))
        .routes(routes!(results::optimum))
        .routes(routes!(rotor::result))
        .routes(routes!(rotor::ross_script))
        .routes(routes!(results::machine))
        .routes(routes!(studies::table))
        .routes(routes!(studies::uncertainty))
        .routes(routes!(plots::plot));
    match app {
        Some(app) => routes.layer(middleware::from_fn_with_state(app.clone(), conditional::results)),
        None => routes,
    }
}

/// The OpenAPI document.
pub fn document() -> Document {
    openapi::completed(routes(&None).into_openapi())
}

/// The OpenAPI document as it is printed and checked in.
pub fn document_text() -> String {
    let mut text = serde_json::to_string_pretty(&document()).unwrap_or_default();
    text.push('\n');
    text
}

/// The whole service.
pub fn router(app: App) -> Router {
    let (documented, _) = routes(&Some(app.clone())).split_for_parts();
    with_layers(documented.merge(pages()), app)
}

/// The page at `/` and the one of the document at `/docs/`. The base layout has no bar for documents of other origins.
fn pages() -> Router<App> {
    let document = SwaggerUi::new("/docs").config(Config::from("/openapi.json").use_base_layout());
    Router::new()
        .route("/", get(portal::page))
        .route("/portal/{*file}", get(portal::file))
        .merge(document)
        .layer(middleware::map_response(portal::policies))
}

/// Adds the layers that hold for every request: access, concurrency, and the form of errors.
fn with_layers(routes: Router<App>, app: App) -> Router {
    let guarded = routes
        .layer(middleware::from_fn_with_state(app.concurrency.clone(), concurrency::limit))
        .layer(middleware::from_fn_with_state(app.clone(), auth::guard));
    // Outside the guard, because the preflight requests of browsers carry no token.
    let shared = match app.access.origins.as_slice() {
        [] => guarded,
        origins => guarded.layer(cors::layer(origins)),
    };
    shared
        .layer(CatchPanicLayer::custom(error_layers::of_panic))
        .layer(middleware::from_fn(request::limit_header))
        // Parts of a file that is compressed differently each time would not fit together.
        .layer(CompressionLayer::new().compress_when(DefaultPredicate::new().and(NotForContentType::const_new(NPY))))
        .layer(middleware::from_fn(error_layers::as_problems))
        .layer(middleware::from_fn(request_id::layer))
        // The extractor of bodies has its own limit.
        .layer(DefaultBodyLimit::disable())
        .with_state(app)
}

/// Routes of a worker, which accepts no jobs: probes and metrics.
pub fn probes(app: App) -> Router {
    with_layers(health_routes().route("/metrics", get(health::service_metrics)), app)
}

/// Routes of connections beyond the limit: only the probes, so that a busy service is not restarted.
pub fn overflow(app: App) -> Router {
    health_routes()
        .fallback(|| std::future::ready(ApiError::Overloaded))
        .layer(middleware::from_fn_with_state(app.clone(), auth::guard))
        .with_state(app)
}

fn health_routes() -> Router<App> {
    Router::new().route("/health/live", get(health::live)).route("/health/ready", get(health::ready))
}
