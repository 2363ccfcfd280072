//! Scenes before they run: defaults, derived quantities, and presets.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use utoipa::ToSchema;

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadBody, BadQuery, NamesExpired, NotAccepted};
use super::request::{JsonBody, NoQuery, Query, negotiated};
use crate::contract::scene::presets::PresetsAnswer;
use crate::contract::scene::scene_input::SceneInput;
use crate::contract::{ResolveAnswer, parse_scene_request_with, presets_answer, resolve_answer};

/// A scene, or a whole job.
#[derive(ToSchema)]
#[allow(dead_code, reason = "only describes the body; the contract reads it")]
struct SceneRequest {
    /// The scene. All other fields of a job are allowed.
    scene: SceneInput,
}

/// Resolve a scene
///
/// Returns the scene with every default filled in, derived quantities, the terms that the equations will omit with the reason, and the
/// estimated cost. No job is created. The body may also be a whole job.
#[utoipa::path(
    post, path = "/v1/scenes/resolve", tag = openapi::SCENES, operation_id = "resolveScene",
    request_body(content = SceneRequest, content_type = "application/json", example = json!({"scene": {"bearing": "6205", "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}}})),
    responses((status = 200, description = "The resolved scene", body = ResolveAnswer), NamesExpired, BadBody, NotAccepted, Anywhere)
)]
pub async fn resolve(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    permit: RequestPermit,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Json<ResolveAnswer>, ApiError> {
    negotiated(&headers, &["application/json"])?;
    let uploads = app.jobs.named_series(&owner, &body).await?;
    let resolved =
        computed(&permit, move |_| parse_scene_request_with(&body, &uploads).map(|job| resolve_answer(&job)));
    Ok(Json(resolved.await??.ok_or(ApiError::Internal)?))
}

/// List presets
///
/// Bearings, materials and lubricants by name, each with every value that it sets.
#[utoipa::path(
    get, path = "/v1/presets", tag = openapi::SCENES, operation_id = "listPresets",
    responses((status = 200, description = "The presets", body = PresetsAnswer), BadQuery, NotAccepted, Anywhere)
)]
pub async fn presets(headers: HeaderMap, _: Query<NoQuery>) -> Result<Json<PresetsAnswer>, ApiError> {
    negotiated(&headers, &["application/json"])?;
    Ok(Json(presets_answer()))
}
