//! Several jobs in one request.

use axum::extract::State;
use axum::http::header::RETRY_AFTER;
use axum::http::{HeaderMap, HeaderValue};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use futures_util::future::join_all;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::app::App;
use super::auth::Credential;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::{ApiError, Problem};
use super::job_response::JobAnswer;
use super::openapi::{self, Anywhere, BadBody, NamesExpired, NotAccepted};
use super::rate_limit::{JOBS, LeftPlaces, POINTS};
use super::request::{JsonBody, NoQuery, Query, negotiated};
use super::submission_headers::{IDEMPOTENT_REPLAYED, idempotency_key};
use crate::contract::job::input::JobInput;
use crate::contract::{self, Job, Refusal};
use crate::jobs::{IdempotencyKey, JobError, Left, Submitted};

const JSON: &[&str] = &["application/json"];

/// Jobs of one request.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "only describes the body; `contract::parse_batch` reads it")]
struct BatchInput {
    /// The jobs, each as in `POST /v1/jobs`.
    #[schema(min_items = 1, max_items = 1000)]
    jobs: Vec<JobInput>,
}

/// The answers to the jobs, in their order.
#[derive(Serialize, ToSchema)]
struct BatchAnswer {
    /// One answer for each job, in their order.
    answers: Vec<ItemAnswer>,
}

/// The answer to one job.
#[derive(Serialize, ToSchema)]
struct ItemAnswer {
    /// Status code that `POST /v1/jobs` would have answered: 202, 422, 429, …
    #[schema(minimum = 200, maximum = 599, example = 202)]
    status: u16,
    /// The created job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    job: Option<JobAnswer>,
    /// Reason why no job was created; pointers are relative to the job.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    problem: Option<Problem>,
    /// Seconds after which to try again, if that may succeed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    retry_after_s: Option<u32>,
}

/// Headers of a batch.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
#[allow(dead_code, reason = "only describes the header; `idempotency_key` reads it")]
struct BatchHeaders {
    /// A key of the client for this request, 1 to 255 visible ASCII characters.
    #[param(
        rename = "Idempotency-Key",
        nullable = false,
        min_length = 1,
        max_length = 255,
        pattern = "^[!-~]+$",
        example = "night-run-17"
    )]
    idempotency_key: Option<String>,
}

/// Submit several jobs
///
/// Each job is answered as if it had been submitted alone; a refused job does not affect the others. At most 1000 jobs in 1 MiB. With
/// `Idempotency-Key` the same bytes can be sent again: existing jobs are not created again (`Idempotent-Replayed: true`), and jobs
/// that found the queue full are created now. Another body with the same key is refused (422).
#[utoipa::path(
    post, path = "/v1/jobs/batch", tag = openapi::JOBS, operation_id = "submitJobs",
    params(BatchHeaders),
    request_body(content = BatchInput, content_type = "application/json", example = json!({"jobs": [
        {"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}},
        {"kind": "simulation", "scene": {"bearing": "6205", "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}}}
    ]})),
    responses((status = 200, description = "An answer for each job, in their order", body = BatchAnswer,
        headers(("Idempotent-Replayed" = String, description = "`true` if an earlier request with this `Idempotency-Key` created the jobs"), ("RateLimit-Policy" = String, description = "Limits by name: `q` in `w` seconds, or `q` unfinished ones"), ("RateLimit" = String, description = "What is left of them: `r`, and `t` seconds until something is left again"))), NamesExpired, BadBody, NotAccepted, Anywhere)
)]
pub async fn submit(
    State(app): State<App>,
    owner: Owner,
    credential: Credential,
    headers: HeaderMap,
    permit: RequestPermit,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, JSON)?;
    let key = idempotency_key(&headers)?;
    let key = key.map(|key| IdempotencyKey::of_batch(key, &body));
    // A scene takes some milliseconds to check, and there may be a thousand.
    let uploads = app.jobs.named_series(&owner.0, &body).await?;
    let jobs = computed(&permit, move |stop| contract::parse_batch(&body, &uploads, stop)).await??;
    if credential.has_token() {
        app.access.rates.charge(&owner, jobs.iter().flatten().map(Job::cost).sum());
    }
    let owner = owner.0;
    // The first valid job is submitted alone: if the key was used with another body, no job is created.
    let lead = jobs.iter().position(Result::is_ok);
    let key_of = |place: usize| {
        let place = if Some(place) == lead { "first".to_owned() } else { place.to_string() };
        key.as_ref().map(|key| key.of_item(&place))
    };
    let first = match lead.and_then(|place| Some((place, jobs[place].as_ref().ok()?))) {
        Some((place, job)) => Some((place, app.jobs.submit(job, &owner, key_of(place)).await)),
        None => None,
    };
    if let Some((_, Err(JobError::KeyReused))) = first {
        return Err(JobError::KeyReused.into());
    }
    let replayed = matches!(&first, Some((_, Ok(submitted))) if submitted.replayed);
    let (lead, mut first) = first.map_or((None, None), |(place, made)| (Some(place), Some(made)));
    let answers = jobs.into_iter().enumerate().map(|(place, job)| {
        let made = if lead == Some(place) { first.take() } else { None };
        answer(&app, &owner, job, made, key_of(place))
    });
    let answers: Vec<_> = answers.collect();
    let headers = replayed.then_some((IDEMPOTENT_REPLAYED, HeaderValue::from_static("true")));
    let headers: HeaderMap = headers.into_iter().collect();
    let (answers, left): (Vec<ItemAnswer>, Vec<_>) = join_all(answers).await.into_iter().unzip();
    // The least of each kind: the jobs may have been written in any order.
    let least = |kind| {
        let of_kind = left.iter().flatten().filter(move |(name, _)| *name == kind);
        of_kind.min_by_key(|(_, left)| left.left).copied()
    };
    let left = Extension(LeftPlaces([JOBS, POINTS].into_iter().filter_map(least).collect()));
    Ok((left, headers, Json(BatchAnswer { answers })).into_response())
}

/// The answer to one job, and what it left of its limit. `made`: the job has already been submitted.
async fn answer(
    app: &App,
    owner: &str,
    job: Result<Job, Refusal>,
    made: Option<Result<Submitted, JobError>>,
    key: Option<IdempotencyKey>,
) -> (ItemAnswer, Option<(&'static str, Left)>) {
    let kind = job.as_ref().map_or(JOBS, |job| if job.points().is_some() { POINTS } else { JOBS });
    let submitted = async {
        let submitted = match made {
            Some(made) => made?,
            None => app.jobs.submit(&job?, owner, key).await?,
        };
        Ok::<_, ApiError>((JobAnswer::of(submitted.record)?, submitted.left))
    };
    match submitted.await {
        Ok((job, left)) => {
            (ItemAnswer { status: 202, job: Some(job), problem: None, retry_after_s: None }, Some((kind, left)))
        }
        Err(error) => {
            let (status, problem) = error.problem();
            let retry_after = error.headers().get(RETRY_AFTER).and_then(|seconds| seconds.to_str().ok()?.parse().ok());
            let answer =
                ItemAnswer { status: status.as_u16(), job: None, problem: Some(problem), retry_after_s: retry_after };
            (answer, None)
        }
    }
}
