//! Scenes before they run: defaults, derived quantities, and presets.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadBody, BadQuery, NamesExpired, NotAccepted};
use super::request::{JsonBody, NoQuery, Query, negotiated};
use crate::contract::scene::presets::PresetsAnswer;
use crate::contract::scene::scene_input::SceneInput;
use crate::contract::{
    CatalogueAnswer, CatalogueSearch, ResolveAnswer, catalogue_answer, parse_scene_request_with, presets_answer,
    resolve_answer,
};

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

/// Conditions that a bearing must meet.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct CatalogueQuery {
    /// Series, such as `62`, `160` or `718`.
    #[param(example = "62", pattern = r"^[^\u0000]*$")]
    series: Option<String>,
    /// Bore [mm].
    #[param(minimum = 0, example = 25.0)]
    bore_mm: Option<f64>,
    /// Least basic dynamic load rating by ISO 281 [kN].
    #[param(minimum = 0, example = 12.0)]
    min_c_kn: Option<f64>,
    /// Text in the designation, without regard to case.
    #[param(example = "6205", pattern = r"^[^\u0000]*$")]
    q: Option<String>,
}

impl CatalogueQuery {
    /// The bearings; an error for a number that is none.
    pub fn answer(self) -> Result<CatalogueAnswer, ApiError> {
        for (name, number) in [("bore_mm", self.bore_mm), ("min_c_kn", self.min_c_kn)] {
            if number.is_some_and(|number| !(number.is_finite() && number >= 0.0)) {
                return Err(ApiError::BadRequest(format!("{name}: must be at least 0")));
            }
        }
        let Self { series, bore_mm, min_c_kn, q: text } = self;
        Ok(catalogue_answer(&CatalogueSearch { series, bore_mm, min_c_kn, text }))
    }
}

/// Search the catalogue
///
/// Ball bearings by designation, with balls, ratings and frequencies, and with source, confidence and note of each. A bearing must meet
/// all given conditions; without any, all are listed.
#[utoipa::path(
    get, path = "/v1/catalogue", tag = openapi::SCENES, operation_id = "searchCatalogue", params(CatalogueQuery),
    responses((status = 200, description = "The bearings", body = CatalogueAnswer), BadQuery, NotAccepted, Anywhere)
)]
pub async fn catalogue(
    headers: HeaderMap,
    Query(query): Query<CatalogueQuery>,
) -> Result<Json<CatalogueAnswer>, ApiError> {
    negotiated(&headers, &["application/json"])?;
    Ok(Json(query.answer()?))
}
