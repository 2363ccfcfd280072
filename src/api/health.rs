//! Probes, and metrics for Prometheus.

use axum::Json;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use serde::Serialize;
use utoipa::ToSchema;

use super::app::App;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadQuery, OnlyLocal, TakesNoJobs};
use super::request::{NoQuery, Query};
use crate::jobs::METRICS_MEDIA_TYPE;

/// Health of the service.
#[derive(Debug, Serialize, ToSchema)]
pub struct Health {
    /// Always `ok`; any other state is answered with a problem.
    #[schema(example = "ok")]
    status: &'static str,
    /// Version of the service.
    #[schema(example = "0.1.0")]
    version: &'static str,
}

/// Readiness of the service.
#[derive(Debug, Serialize, ToSchema)]
pub struct Readiness {
    /// Always `ok`; any other state is answered with a problem.
    #[schema(example = "ok")]
    status: &'static str,
    /// Version of the service.
    #[schema(example = "0.1.0")]
    version: &'static str,
    /// State of the stored results.
    stored_results: StoredResults,
}

/// State of the stored results.
#[derive(Debug, Serialize, ToSchema)]
struct StoredResults {
    /// `corrupt` if a stored result is known to differ from what was written; the service stays ready for all others.
    state: StoredState,
    /// Number of jobs with such a result. `raceway check` lists them; deleting them clears the state.
    #[schema(minimum = 0, example = 0)]
    corrupt: i64,
}

/// True where all stored results are known to have the digests of their writing.
#[derive(Debug, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum StoredState {
    Ok,
    Corrupt,
}

const OK: Health = Health { status: "ok", version: env!("CARGO_PKG_VERSION") };

/// Liveness probe
///
/// Answers as long as the process serves HTTP. Without an answer the process should be restarted.
#[utoipa::path(
    get, path = "/health/live", tag = openapi::HEALTH, operation_id = "isAlive", security(()),
    responses((status = 200, description = "The service is alive", body = Health), OnlyLocal)
)]
pub async fn live() -> Json<Health> {
    Json(OK)
}

/// Readiness probe
///
/// Succeeds if the service accepts jobs. It fails while the service stops, the database is not available, or the disk is full. It does
/// not fail because of corrupt stored results, which it counts.
#[utoipa::path(
    get, path = "/health/ready", tag = openapi::HEALTH, operation_id = "isReady", security(()),
    responses(
        (status = 200, description = "The service accepts jobs", body = Readiness),
        TakesNoJobs, OnlyLocal
    )
)]
pub async fn ready(State(app): State<App>) -> Result<Json<Readiness>, ApiError> {
    let corrupt = app.jobs.ready().await.map_err(ApiError::NotReady)?;
    let state = if corrupt == 0 { StoredState::Ok } else { StoredState::Corrupt };
    let Health { status, version } = OK;
    Ok(Json(Readiness { status, version, stored_results: StoredResults { state, corrupt } }))
}

/// Service metrics
///
/// For Prometheus, in the text format of OpenMetrics: queued and running jobs, age of the oldest queued job, and worker slots. Since the
/// start of this process: ended runs by their end, wall time, real-time factor, claims and lost claims, and waits for the database.
#[utoipa::path(
    get, path = "/metrics", tag = openapi::HEALTH, operation_id = "getFigures",
    responses(
        (status = 200, description = "Counts and times", body = String, content_type = "application/openmetrics-text",
            example = json!("# TYPE raceway_jobs_waiting gauge\nraceway_jobs_waiting 3\n# EOF\n")),
        BadQuery, Anywhere
    )
)]
pub async fn service_metrics(
    State(app): State<App>,
    _: Owner,
    _: Query<NoQuery>,
) -> Result<impl IntoResponse, ApiError> {
    Ok(([(CONTENT_TYPE, METRICS_MEDIA_TYPE)], app.jobs.service_metrics().await?))
}
