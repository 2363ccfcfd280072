//! Jobs that are run point by point: their table, what it says of uncertain inputs, and resuming them.

use axum::Json;
use axum::extract::State;
use axum::http::header::LOCATION;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use uuid::Uuid;

use super::app::App;
use super::concurrency::{RequestPermit, hold_until_sent};
use super::credentials::Owner;
use super::error::ApiError;
use super::job_response::{JobAnswer, path_of};
use super::openapi::{
    self, Anywhere, BadQuery, CannotResume, NoJob, NoResult, NoSpace, NotAccepted, QueueFull, Unchanged,
};
use super::request::{JobId, NoQuery, Query, negotiated};
use super::stored_answer::{CSV, JSON, formatted, json_text, read, respond};
use crate::contract::answer::csv;
use crate::contract::{self, Job, JobKind, PointEnd, PointStatus, Row, Study, TableAnswer, UncertaintyAnswer, Uploads};
use crate::jobs::{JobError, StoredPoint, decompressed};

/// Get the table of a study or an uncertainty job
///
/// One row for each point, with the points that have been computed, whatever the status of the job. The table of a study also has the best point
/// for each metric with points that may be as good, and the change of each metric along the axis. JSON, or CSV with the header
/// `Accept: text/csv`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/table", tag = openapi::RESULTS, operation_id = "getTable",
    params(("id" = Uuid, Path, description = "The job, of kind `study` or `uncertainty`")),
    responses(
        (status = 200, description = "The table", content((TableAnswer = "application/json"), (String = "text/csv", example = json!("/spindle/mass_kg,status,error,/solver/rung,/channels/spindle.y.acceleration/level_db\n0.05,succeeded,,radially_condensed,66.9\n")))),
        Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere
    )
)]
pub async fn table(
    State(app): State<App>,
    Owner(owner): Owner,
    permit: RequestPermit,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV])?;
    let held = permit.concurrency().series()?;
    let (request, points) = app.jobs.points(&owner, id).await?;
    let response = formatted(move || {
        let table = table_of(&request, points)?;
        let body = match format {
            CSV => csv::table_csv(&table).into_bytes(),
            _ => json_text(&table)?,
        };
        Ok(respond(format, body))
    });
    // A table of ten thousand points has a hundred megabytes, and a slow client reads slowly.
    Ok(hold_until_sent(held, response.await?))
}

/// Get the uncertainty
///
/// Distribution of each metric of an uncertainty job, from the points that have been computed, whatever the status of the job: mean, standard
/// deviation, percentiles with intervals, histogram, and the share of the variance that each input explains. Errors of four kinds are stated
/// beside each other and never added.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/uncertainty", tag = openapi::RESULTS, operation_id = "getUncertainty",
    params(("id" = Uuid, Path, description = "The job, of kind `uncertainty`")),
    responses((status = 200, description = "The distributions", body = UncertaintyAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn uncertainty(
    State(app): State<App>,
    Owner(owner): Owner,
    permit: RequestPermit,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let held = permit.concurrency().series()?;
    let (request, points) = uncertainty_points(&app, &owner, id).await?;
    let response = formatted(move || Ok(respond(JSON, json_text(&uncertainty_of(&request, points)?)?)));
    Ok(hold_until_sent(held, response.await?))
}

/// The request of an uncertainty job and its stored points.
pub async fn uncertainty_points(app: &App, owner: &str, id: Uuid) -> Result<(String, Vec<StoredPoint>), ApiError> {
    let kind = app.jobs.get(owner, id).await?.kind;
    if kind != JobKind::Uncertainty.name() {
        return Err(JobError::OtherKind { kind }.into());
    }
    Ok(app.jobs.points(owner, id).await?)
}

/// The answer of an uncertainty job from its request and its stored points.
pub fn uncertainty_of(request: &str, points: Vec<StoredPoint>) -> Result<UncertaintyAnswer, ApiError> {
    match contract::parse_job_with(request.as_bytes(), &Uploads::stand_in()) {
        Ok(Job::Uncertainty(job)) => Ok(UncertaintyAnswer::of(&job, &rows_of(&job.study, points)?)),
        _ => Err(JobError::Corrupt("the request of an uncertainty job".into()).into()),
    }
}

/// Resume a study or an uncertainty job
///
/// Continues a job that was cancelled, or that has points which failed by a time limit, a lost worker or an internal error. All other
/// finished points are kept.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/resume", tag = openapi::JOBS, operation_id = "resumeStudy",
    params(("id" = Uuid, Path, description = "The job, of kind `study` or `uncertainty`")),
    responses(
        (status = 202, description = "The study is queued again", body = JobAnswer, headers(("Location" = String, description = "Path of the job"))),
        CannotResume, BadQuery, NoJob, NotAccepted, NoSpace, Anywhere, QueueFull
    )
)]
pub async fn resume(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let record = app.jobs.resume(&owner, id).await?;
    Ok((StatusCode::ACCEPTED, [(LOCATION, path_of(id))], Json(JobAnswer::of(record)?)).into_response())
}

/// The table of a study from its request and its stored points.
pub fn table_of(request: &str, points: Vec<StoredPoint>) -> Result<TableAnswer, ApiError> {
    let study = contract::parse_job_with(request.as_bytes(), &Uploads::stand_in()).ok().and_then(Job::into_study);
    let study = study.ok_or_else(|| JobError::Corrupt("the request of a study".into()))?;
    Ok(TableAnswer::of(&study, rows_of(&study, points)?))
}

/// The rows of stored points.
fn rows_of(study: &Study, points: Vec<StoredPoint>) -> Result<Vec<Row>, ApiError> {
    let mut rows = Vec::with_capacity(points.len());
    for point in points {
        let row = Row { status: point.status, reused: point.reused, ..Row::queued(study, point.number) };
        let answer = point.answer.map(|answer| decompressed(&answer)).transpose()?;
        rows.push(match (point.status, answer) {
            (PointStatus::Succeeded, Some(answer)) => row.ended(PointEnd::Succeeded(read(&answer)?)),
            (PointStatus::Failed, Some(answer)) => row.ended(PointEnd::Failed(read(&answer)?)),
            _ => row,
        });
    }
    Ok(rows)
}
