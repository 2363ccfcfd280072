//! Rotors: an immediate analysis, and the result of a rotor job, as JSON and as a script for ROSS.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadBody, BadQuery, NoJob, NoResult, NotAccepted, Unchanged};
use super::request::{JobId, JsonBody, NoQuery, Query, negotiated};
use super::results::StoredResult;
use super::stored_answer::{JSON, formatted, read};
use crate::contract::answer::ross::{RossVersion, script};
use crate::contract::job::rotor::RotorInput;
use crate::contract::{self, FieldError, Job, JobKind, Refusal, RotorAnswer, RunFailure};

/// Media type of a script.
pub(super) const PYTHON: &str = "text/x-python";

/// Analyse a rotor
///
/// Natural frequencies and damping over speed, critical speeds, response to unbalance, static deflection and support forces of a
/// shaft. The answer comes at once; no job is created. The body is a job of kind `rotor`.
#[utoipa::path(
    post, path = "/v1/rotor", tag = openapi::SCENES, operation_id = "analyseRotor",
    request_body(content = RotorInput, content_type = "application/json", example = json!({
        "kind": "rotor",
        "scene": {
            "shaft": {
                "sections": [{"length_mm": 300, "outer_diameter_mm": 25}],
                "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}],
                "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]
            },
            "supports": [
                {"at_mm": 40, "stiffness_n_per_um": [0, 50, 50], "damping_n_s_per_m": [0, 200, 200]},
                {"at_mm": 260, "stiffness_n_per_um": [0, 50, 50], "damping_n_s_per_m": [0, 200, 200]}
            ],
            "operation": {"speed_rpm": 12000}
        },
        "speeds_rpm": {"from": 0, "to": 30000, "count": 31}
    })),
    responses((status = 200, description = "The analysis", body = RotorAnswer), BadBody, NotAccepted, Anywhere)
)]
pub async fn analyse(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    permit: RequestPermit,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let uploads = app.jobs.named_series(&owner, &body).await?;
    let analysed = computed(&permit, move |stop| match contract::parse_rotor_request(&body, &uploads)? {
        Job::Rotor(rotor) => contract::execute_rotor(&rotor, stop).map_err(refused),
        _ => Err(ApiError::Internal),
    });
    Ok(Json(analysed.await??).into_response())
}

/// A shaft that passes every check of its fields, but has no result.
pub(super) fn refused(failure: RunFailure) -> ApiError {
    let error = FieldError::new("/scene", failure.to_string());
    Refusal::Invalid { errors: vec![error] }.into()
}

/// Get the rotor analysis
///
/// Result of a rotor job: natural frequencies over speed, critical speeds, response to unbalance, static deflection, support forces, and
/// the elements and matrices behind them.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/rotor", tag = openapi::RESULTS, operation_id = "getRotor",
    params(("id" = Uuid, Path, description = "The job, of kind `rotor`")),
    responses((status = 200, description = "The analysis", body = RotorAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn result(wanted: StoredResult) -> Result<Response, ApiError> {
    wanted.report(JobKind::Rotor).await
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct RossQuery {
    /// Version of ROSS that the script is for. Default `2`.
    #[param(inline)]
    ross: Option<RossVersionName>,
}

/// `2`: ross-rotordynamics 2.x, whose tables are over `frequency`. `3`: 3.x, over `speed`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
pub enum RossVersionName {
    #[serde(rename = "2")]
    Two,
    #[serde(rename = "3")]
    Three,
}

/// Get the rotor as a script for ROSS
///
/// A Python script that builds the same elements, discs and supports with ross-rotordynamics. Its axes (x, y, z) are (y, z, x) here. A rigid
/// spindle has none: 400.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/rotor.py", tag = openapi::RESULTS, operation_id = "getRotorScript",
    params(("id" = Uuid, Path, description = "The job, of kind `rotor`"), RossQuery),
    responses((status = 200, description = "The script", body = String, content_type = "text/x-python", example = json!("import numpy as np\nimport ross as rs\n…")), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn ross_script(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    query: Query<RossQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[PYTHON])?;
    let version = match query.0.ross {
        Some(RossVersionName::Three) => RossVersion::Three,
        _ => RossVersion::Two,
    };
    let stored = app.jobs.report(&owner, id, JobKind::Rotor).await?;
    formatted(move || {
        let answer = read::<RotorAnswer>(&stored)?;
        if answer.model.is_rigid_spindle() {
            let detail = "a rigid spindle has no script, because ROSS has no rigid shaft: give the scene a `shaft`";
            return Err(ApiError::BadRequest(detail.into()));
        }
        Ok(([(CONTENT_TYPE, PYTHON)], script(&answer.model, version)).into_response())
    })
    .await
}
