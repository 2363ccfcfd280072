//! A run that is shown and not kept: a position of the page's slider.

use std::time::{Duration, Instant};

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::{IntoResponse, Response};
use raceway_core::simulation::input::control::Control;
use serde::Serialize;
use tokio_util::sync::CancellationToken;
use utoipa::ToSchema;

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadBody, NotAccepted};
use super::request::{JsonBody, NoQuery, Query, negotiated};
use super::stored_answer::JSON;
use crate::contract::job::input::JobInput;
use crate::contract::{
    FieldError, Job, Metrics, Refusal, RunFailure, Simulation, SpectrumAnswer, execute_simulation, parse_job_with,
};

/// Longest run. What takes longer is no preview: it is a job, which can be waited for.
const LONGEST: Duration = Duration::from_secs(10);

/// Outcome of a preview.
#[derive(Debug, Serialize, ToSchema)]
pub struct PreviewAnswer {
    /// Metrics, as those of a job.
    pub metrics: Metrics,
    /// Amplitude spectra of the requested channels.
    pub spectra: Vec<SpectrumAnswer>,
}

/// Preview a run
///
/// Runs a simulation at once and returns its metrics and spectra. No job is created, nothing is kept, and the run yields to all jobs. It ends when
/// the client closes the connection, or after 10 s. The body is a job of kind `simulation` without series or orders.
#[utoipa::path(
    post, path = "/v1/preview", tag = openapi::SCENES, operation_id = "previewRun",
    request_body(content = JobInput, content_type = "application/json", example = json!({
        "kind": "simulation",
        "scene": {"bearing": "6205", "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}},
        "outputs": {"metrics": ["vibration"], "spectra": ["spindle.y.acceleration"]},
        "solver": {"model_tolerance_db": 1}
    })),
    responses((status = 200, description = "Metrics and spectra", body = PreviewAnswer), BadBody, NotAccepted, Anywhere)
)]
pub async fn run(
    State(app): State<App>,
    owner: Owner,
    headers: HeaderMap,
    permit: RequestPermit,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let uploads = app.jobs.named_series(&owner.0, &body).await?;
    let simulation = checked(computed(&permit, move |_| parse_job_with(&body, &uploads)).await??)?;
    let place = app.previews.place(&owner).await?;
    let unwanted = CancellationToken::new();
    let _cancels = unwanted.clone().drop_guard();
    let ran = app.previews.threads.run(move || {
        let _held = place;
        let end = Instant::now() + LONGEST;
        let stop = || unwanted.is_cancelled() || Instant::now() > end;
        execute_simulation(&simulation, &Control::until(&stop))
    });
    let simulated = ran.await.map_err(|_| ApiError::Internal)?.result.map_err(refused)?;
    let spectra = simulated.spectra.into_iter().filter(SpectrumAnswer::is_amplitude).collect();
    Ok(Json(PreviewAnswer { metrics: simulated.metrics, spectra }).into_response())
}

/// The simulation of a preview; refuses what a preview does not run.
pub(super) fn checked(job: Job) -> Result<Simulation, ApiError> {
    let Job::Simulation(simulation) = job else { return Err(invalid("/kind", "a preview is of kind `simulation`")) };
    if !simulation.settings.outputs.series.is_empty() || simulation.outputs.orders.is_some() {
        return Err(invalid("/outputs", "a preview keeps neither series nor orders: submit a job"));
    }
    Ok(simulation)
}

/// A run that passes every check of its fields, but has no result.
fn refused(failure: RunFailure) -> ApiError {
    match failure {
        RunFailure::Cancelled => {
            invalid("", &format!("takes longer than {} s, the longest preview: submit a job", LONGEST.as_secs()))
        }
        failure => invalid("/scene", &failure.to_string()),
    }
}

fn invalid(pointer: &str, detail: &str) -> ApiError {
    Refusal::Invalid { errors: vec![FieldError::new(pointer, detail)] }.into()
}
