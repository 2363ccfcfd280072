//! Machines before they run: defaults, what follows of each bearing, and expected time.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadBody, NotAccepted};
use super::request::{JsonBody, NoQuery, Query, negotiated};
use super::rotor::refused;
use super::stored_answer::JSON;
use crate::contract::job::machine::MachineInput;
use crate::contract::{self, Job, MachinePlanAnswer};

/// Resolve a machine
///
/// Returns a job of kind `machine` with every default filled in, ratings, clearances and frequencies of its bearings, and the estimated cost. No job
/// is created.
#[utoipa::path(
    post, path = "/v1/machine/resolve", tag = openapi::SCENES, operation_id = "resolveMachine",
    request_body(content = MachineInput, content_type = "application/json", example = json!({
        "kind": "machine",
        "scene": {
            "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 40}]},
            "bearings": [{"name": "A", "bearing": "6205", "at_mm": 40}, {"name": "B", "bearing": "6205", "at_mm": 260}],
            "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}
        }
    })),
    responses((status = 200, description = "The plan", body = MachinePlanAnswer), BadBody, NotAccepted, Anywhere)
)]
pub async fn resolve(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    permit: RequestPermit,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Json<MachinePlanAnswer>, ApiError> {
    negotiated(&headers, &[JSON])?;
    let uploads = app.jobs.named_series(&owner, &body).await?;
    let planned = computed(&permit, move |stop| match contract::parse_machine_request(&body, &uploads)? {
        Job::Machine(machine) => contract::plan_machine(&machine, stop).map_err(refused),
        _ => Err(ApiError::Internal),
    });
    Ok(Json(planned.await??))
}
