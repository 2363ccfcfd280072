//! Submit, list, show, cancel and delete jobs.

use std::time::Duration;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::header::{LINK, LOCATION, RETRY_AFTER};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};

use super::app::App;
use super::auth::Credential;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::job_response::{JobAnswer, JobList, path_of};
use super::list_query::ListQuery;
use super::openapi::{
    Anywhere, BadBody, BadQuery, HasEnded, HasNotEnded, KeyExpired, NoJob, NoSpace, NotAccepted, QueueFull,
};
use super::rate_limit::{JOBS, LeftPlaces, POINTS};
use super::request::{JobId, JsonBody, NoQuery, Query, negotiated};
use super::submission_headers::{
    IDEMPOTENT_REPLAYED, PREFERENCE_APPLIED, SubmissionHeaders, idempotency_key, preferred_wait,
};
use super::{conditional, openapi};
use crate::contract::job::input::JobInput;
use crate::contract::{self, Job, Uploads};
use crate::jobs::{Cancelled, IdempotencyKey, JobError, JobRecord, Submitted};

const JSON: &[&str] = &["application/json"];

/// Submit a job
///
/// Checks the job and puts it into the queue. After the answer the job survives a crash of the service and a power cut. With
/// `Prefer: wait=N` the answer waits up to N seconds for the end of the job. A busy service may answer at once, without
/// `Preference-Applied`. Answers to requests with a token tell in `RateLimit` what is left of the rates of its owner; those to
/// submissions also how many jobs, or points of studies, it may add to its unfinished ones.
#[utoipa::path(
    post, path = "/v1/jobs", tag = openapi::JOBS, operation_id = "submitJob",
    params(SubmissionHeaders),
    request_body(content = JobInput, content_type = "application/json", examples(
        ("article" = (summary = "The article's integrated bearing", value = json!({"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}}))),
        ("unbalanced" = (summary = "The article's integrated bearing on an unbalanced spindle", value = json!({"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}, "spindle": {"balance_grade": 6.3}}}))),
        ("study" = (summary = "Level over the curvature of the inner groove", value = json!({"kind": "study", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}, "axes": [{"path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.54, "count": 7}]}))),
        ("optimum" = (summary = "Curvature of the inner groove with the lowest level", value = json!({"kind": "optimum", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}, "axes": [{"path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.54}], "metric": "/channels/spindle.y.acceleration/level_db"}))),
        ("accuracy" = (summary = "Error against run time", value = json!({"kind": "accuracy", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}, "repetitions": 5})))
    )),
    responses(
        (status = 202, description = "The job is in the queue, or an existing result of identical work answered it (`reused`)", body = JobAnswer,
            headers(("Location" = String, description = "Path of the job"), ("Retry-After" = u32, description = "Seconds after which to ask again; absent when the job has ended"), ("Preference-Applied" = String, description = "The granted wait, if one was requested"), ("Idempotent-Replayed" = String, description = "`true` if an earlier request with this `Idempotency-Key` created the job"), ("RateLimit-Policy" = String, description = "Limits by name: `q` in `w` seconds, or `q` unfinished ones"), ("RateLimit" = String, description = "What is left of them: `r`, and `t` seconds until something is left again"))),
        (status = 200, description = "The job has ended within the time of `Prefer: wait`; with its metrics", body = JobAnswer,
            headers(("Location" = String, description = "Path of the job"), ("Preference-Applied" = String, description = "The granted wait"), ("RateLimit-Policy" = String, description = "Limits by name: `q` in `w` seconds, or `q` unfinished ones"), ("RateLimit" = String, description = "What is left of them: `r`, and `t` seconds until something is left again"))),
        BadBody, KeyExpired, NotAccepted, NoSpace, Anywhere, QueueFull
    )
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
    let wait = preferred_wait(&headers)?;
    let key = idempotency_key(&headers)?;
    let uploads = app.jobs.named_series(&owner.0, &body).await?;
    let job = parsed(&body, uploads, &permit).await?;
    let key = key.map(|key| IdempotencyKey::new(key, &job));
    if credential.has_token() {
        app.access.rates.charge(&owner, job.cost());
    }
    let Submitted { record, replayed, left } = app.jobs.submit(&job, &owner.0, key).await?;
    let left = Extension(LeftPlaces(vec![(if job.points().is_some() { POINTS } else { JOBS }, left)]));
    tracing::debug!(job = %record.id, replayed, "accepted");
    let replayed = replayed.then_some((IDEMPOTENT_REPLAYED, HeaderValue::from_static("true")));
    let headers: HeaderMap = replayed.into_iter().chain([(LOCATION, text(path_of(record.id)))]).collect();
    drop((job, body));
    // A waiting request occupies a connection. Without a free permit the preference is not applied.
    let Some((wait, _follower)) =
        wait.and_then(|wait| Some((wait, permit.concurrency().follow(credential.has_token().then_some(&owner))?)))
    else {
        return Ok(
            (StatusCode::ACCEPTED, left, headers, retry_after(&record), Json(JobAnswer::of(record)?)).into_response()
        );
    };
    permit.release();
    let applied = [(PREFERENCE_APPLIED, text(format!("wait={wait}")))];
    let (record, metrics) = match app.jobs.wait(&owner.0, record.id, Duration::from_secs(wait)).await {
        // The job of a repeated key may have been deleted: it is not created again.
        Err(JobError::NotFound) => {
            return Ok((StatusCode::ACCEPTED, left, headers, Json(JobAnswer::of(record)?)).into_response());
        }
        // The job exists, and its address must reach the client even if the database is unreachable.
        Err(error) if error.is_away() => {
            return Ok((StatusCode::ACCEPTED, left, headers, retry_after(&record), Json(JobAnswer::of(record)?))
                .into_response());
        }
        current => current?,
    };
    // The token may have been revoked meanwhile.
    if !credential.is_valid(&app) {
        return Err(ApiError::Unauthorized);
    }
    let status = if record.status.is_final() { StatusCode::OK } else { StatusCode::ACCEPTED };
    let retry_after = retry_after(&record);
    let answer = JobAnswer::of(record)?.with_metrics(metrics)?;
    Ok((status, left, headers, applied, retry_after, Json(answer)).into_response())
}

/// The job of a body, checked on a thread that delays no other request: a short body can describe thousands of scenes.
async fn parsed(body: &Bytes, uploads: Uploads, permit: &RequestPermit) -> Result<Job, ApiError> {
    let body = body.clone();
    Ok(computed(permit, move |_| contract::parse_job_with(&body, &uploads)).await??)
}

/// List jobs
///
/// Newest first. `next` is the path of the next page; the header `Link` repeats it. A page looks at 10 000 jobs at most: with several
/// filters it may have fewer jobs than `limit`, or none, and a next page.
#[utoipa::path(
    get, path = "/v1/jobs", tag = openapi::JOBS, operation_id = "listJobs", params(ListQuery),
    responses(
        (status = 200, description = "A page of jobs", body = JobList,
            headers(("Link" = String, description = "The next page, `rel=\"next\"`; absent on the last page"))),
        BadQuery, NotAccepted, Anywhere
    )
)]
pub async fn list(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    Query(query): Query<ListQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, JSON)?;
    let (records, next) = app.jobs.list(&owner, &query.filter()?).await?;
    let next = next.map(|last| query.page_after(last));
    let link = next.iter().map(|next| (LINK, text(format!("<{next}>; rel=\"next\"")))).collect::<HeaderMap>();
    let jobs = records.into_iter().map(JobAnswer::of).collect::<Result<_, _>>()?;
    Ok((link, Json(JobList { jobs, next })).into_response())
}

/// Show a job
///
/// Status, progress, cause of a failure and expiry; with `include=metrics` also the metrics.
#[utoipa::path(
    get, path = "/v1/jobs/{id}", tag = openapi::JOBS, operation_id = "showJob",
    params(("id" = Uuid, Path, description = "The job"), ShowQuery),
    responses(
        (status = 200, description = "The job", body = JobAnswer,
            headers(("Retry-After" = u32, description = "Seconds after which to ask again; absent when the job has ended"), ("ETag" = String, description = "Weak; a request with it in `If-None-Match` is answered by 304 until the job changes"))),
        (status = 304, description = "The job has not changed since the answer with the ETag in `If-None-Match`"),
        BadQuery, NoJob, NotAccepted, Anywhere
    )
)]
pub async fn show(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    Query(query): Query<ShowQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, JSON)?;
    let (record, metrics) = match query.include {
        Some(Include::Metrics) => app.jobs.get_with_metrics(&owner, id).await?,
        None => (app.jobs.get(&owner, id).await?, None),
    };
    let retry_after = retry_after(&record);
    let answer = JobAnswer::of(record)?.with_metrics(metrics)?;
    let json = serde_json::to_vec(&answer).map_err(|_| ApiError::Internal)?;
    Ok((retry_after, conditional::job(&headers, json)).into_response())
}

/// Cancel a job
///
/// A queued job is cancelled at once. A running job stops within 0.5 s, even if a full disk refuses to record the request (507).
/// Cancelling again changes nothing.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", tag = openapi::JOBS, operation_id = "cancelJob",
    params(("id" = Uuid, Path, description = "The job")),
    responses(
        (status = 200, description = "The job is cancelled", body = JobAnswer),
        (status = 202, description = "The job is running and has been asked to stop", body = JobAnswer,
            headers(("Retry-After" = u32, description = "Seconds after which to ask again"))),
        HasEnded, BadQuery, NoJob, NotAccepted, NoSpace, Anywhere
    )
)]
pub async fn cancel(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, JSON)?;
    let (status, record) = match app.jobs.cancel(&owner, id).await? {
        Cancelled::Now(record) => (StatusCode::OK, record),
        Cancelled::Soon(record) => (StatusCode::ACCEPTED, record),
    };
    Ok((status, retry_after(&record), Json(JobAnswer::of(record)?)).into_response())
}

/// Delete a job
///
/// Removes the job with its result. A queued or running job must be cancelled first.
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", tag = openapi::JOBS, operation_id = "deleteJob",
    params(("id" = Uuid, Path, description = "The job")),
    responses(
        (status = 204, description = "The job is removed"),
        HasNotEnded, BadQuery, NoJob, NoSpace, Anywhere
    )
)]
pub async fn delete(
    State(app): State<App>,
    Owner(owner): Owner,
    JobId(id): JobId,
    _: Query<NoQuery>,
) -> Result<StatusCode, ApiError> {
    app.jobs.delete(&owner, id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Parts of the answer.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct ShowQuery {
    /// `metrics`: with the metrics, if the job has succeeded.
    #[param(inline = true)]
    include: Option<Include>,
}

#[derive(Debug, Clone, Copy, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum Include {
    Metrics,
}

/// `Retry-After` of an unfinished job.
fn retry_after(record: &JobRecord) -> HeaderMap {
    let is_unfinished = !record.status.is_final();
    is_unfinished.then(|| (RETRY_AFTER, HeaderValue::from_static("1"))).into_iter().collect()
}

/// A header value. Paths and numbers are visible ASCII, so the conversion cannot fail.
fn text(value: String) -> HeaderValue {
    HeaderValue::try_from(value).unwrap_or_else(|_| HeaderValue::from_static(""))
}
