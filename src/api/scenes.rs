//! Scenes before they run: defaults, derived quantities, presets.

use axum::Json;
use axum::http::HeaderMap;
use utoipa::ToSchema;

use super::describe;
use super::describe::{Anywhere, BadBody, BadQuery, NotAccepted};
use super::error::ApiError;
use super::request::{JsonBody, Nothing, Query, negotiated};
use crate::contract::answer::resolve::{ResolveAnswer, resolve_answer};
use crate::contract::scene::presets::PresetsAnswer;
use crate::contract::scene::scene_input::SceneInput;
use crate::contract::{parse_scene_request, presets_answer};

/// A scene, or a whole job.
#[derive(ToSchema)]
#[allow(dead_code, reason = "only describes the body; the contract reads it")]
pub struct SceneRequest {
    /// The scene; all other fields of a job may stand beside it.
    scene: SceneInput,
}

/// Resolve a scene
///
/// No job is made: answers with the scene with every default filled in, quantities that follow from it, what
/// will be left out of the equations and why, and the estimated cost. Takes a whole job, too.
#[utoipa::path(
    post, path = "/v1/scenes/resolve", tag = describe::SCENES, operation_id = "resolveScene",
    request_body(content = SceneRequest, content_type = "application/json", example = json!({"scene": {"bearing": "6205", "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}}})),
    responses((status = 200, description = "What the scene means", body = ResolveAnswer), BadBody, NotAccepted, Anywhere)
)]
pub async fn resolve(
    headers: HeaderMap,
    _: Query<Nothing>,
    JsonBody(body): JsonBody,
) -> Result<Json<ResolveAnswer>, ApiError> {
    negotiated(&headers, &["application/json"])?;
    let resolved = tokio::task::spawn_blocking(move || Ok(resolve_answer(&parse_scene_request(&body)?)));
    Ok(Json(resolved.await.unwrap_or(Err(ApiError::Internal))?))
}

/// List presets
///
/// Bearings, materials and lubricants by name, each with every default it sets.
#[utoipa::path(
    get, path = "/v1/presets", tag = describe::SCENES, operation_id = "listPresets",
    responses((status = 200, description = "The presets", body = PresetsAnswer), BadQuery, NotAccepted, Anywhere)
)]
pub async fn presets(headers: HeaderMap, _: Query<Nothing>) -> Result<Json<PresetsAnswer>, ApiError> {
    negotiated(&headers, &["application/json"])?;
    Ok(Json(presets_answer()))
}
