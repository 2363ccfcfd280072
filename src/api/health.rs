//! Probes.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::describe::{OnlyLocal, TakesNoJobs};
use super::error::ApiError;
use super::{App, describe};

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
