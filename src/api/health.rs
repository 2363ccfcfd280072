//! Probes.

use axum::Json;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use serde::Serialize;
use utoipa::ToSchema;

use super::auth::Owner;
use super::describe::{Anywhere, BadQuery, OnlyLocal, TakesNoJobs};
use super::error::ApiError;
use super::request::{Nothing, Query};
use super::{App, describe};
use crate::jobs::FIGURES_MEDIA_TYPE;

/// How the service is.
#[derive(Debug, Serialize, ToSchema)]
pub struct Health {
    /// Always `ok`: what is not is answered with a problem.
    #[schema(example = "ok")]
    status: &'static str,
    /// Version of the service.
    #[schema(example = "0.1.0")]
    version: &'static str,
}

const OK: Health = Health { status: "ok", version: env!("CARGO_PKG_VERSION") };

/// Is the service alive?
///
/// Answers as long as the process serves HTTP; restart it when it does not.
#[utoipa::path(
    get, path = "/health/live", tag = describe::HEALTH, operation_id = "isAlive", security(()),
    responses((status = 200, description = "The service is alive", body = Health), OnlyLocal)
)]
pub async fn live() -> Json<Health> {
    Json(OK)
}

/// Does the service take jobs?
///
/// Not while it stops, while the database is away, and while the disk is full.
#[utoipa::path(
    get, path = "/health/ready", tag = describe::HEALTH, operation_id = "isReady", security(()),
    responses(
        (status = 200, description = "The service takes jobs", body = Health),
        TakesNoJobs, OnlyLocal
    )
)]
pub async fn ready(State(app): State<App>) -> Result<Json<Health>, ApiError> {
    app.jobs.ready().await.map_err(ApiError::NotReady)?;
    Ok(Json(OK))
}

/// How busy is the service?
///
/// For Prometheus, in the text format of OpenMetrics: jobs that wait and run, age of the oldest, places for runs; since this process began
/// its runs by how they ended, their time, real-time factor, claims taken and lost, waits for the database.
#[utoipa::path(
    get, path = "/metrics", tag = describe::HEALTH, operation_id = "getFigures",
    responses(
        (status = 200, description = "Counts and times", body = String, content_type = "application/openmetrics-text",
            example = json!("# TYPE raceway_jobs_waiting gauge\nraceway_jobs_waiting 3\n# EOF\n")),
        BadQuery, Anywhere
    )
)]
pub async fn figures(State(app): State<App>, _: Owner, _: Query<Nothing>) -> Result<impl IntoResponse, ApiError> {
    Ok(([(CONTENT_TYPE, FIGURES_MEDIA_TYPE)], app.jobs.figures().await?))
}
