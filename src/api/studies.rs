//! Studies: their table, and how they go on after they were cancelled.

use axum::Json;
use axum::extract::State;
use axum::http::header::{CONTENT_TYPE, LOCATION, VARY};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use super::answers::{JobAnswer, path_of};
use super::auth::Owner;
use super::describe::{Anywhere, BadQuery, CannotResume, NoJob, NoResult, NoSpace, NotAccepted, Unchanged};
use super::error::ApiError;
use super::load::{self, Place};
use super::request::{JobId, Nothing, Query, negotiated};
use super::results::{read, shaped};
use super::{App, describe};
use crate::contract::answer::csv;
use crate::contract::{self, Job, PointEnd, PointStatus, Row, TableAnswer};
use crate::jobs::{JobError, StoredPoint, decompressed};

const JSON: &str = "application/json";
const CSV: &str = "text/csv";

/// Get the table of a study
///
/// A row a point, with what has been computed so far, whatever the status of the study; the best points by each metric with
/// those that may be as good; how each metric changes along the axis. As JSON, or as CSV with the header `Accept: text/csv`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/table", tag = describe::RESULTS, operation_id = "getTable",
    params(("id" = Uuid, Path, description = "The job, of kind `study`")),
    responses(
        (status = 200, description = "The table", content((TableAnswer = "application/json"), (String = "text/csv", example = json!("/spindle/mass_kg,status,error,/solver/rung,/channels/spindle.y.acceleration/level_db\n0.05,succeeded,,radially_condensed,66.9\n")))),
        Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere
    )
)]
pub async fn table(
    State(app): State<App>,
    Owner(owner): Owner,
    place: Place,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV])?;
    let held = place.load().series()?;
    let (request, points) = app.jobs.points(&owner, id).await?;
    let response = shaped(move || {
        let table = table_of(&request, points)?;
        let body = match format {
            CSV => csv::table_csv(&table),
            _ => serde_json::to_string(&table).map_err(|error| JobError::Corrupt(error.to_string()))?,
        };
        Ok(([(VARY, "Accept"), (CONTENT_TYPE, format)], body).into_response())
    });
    // Of ten thousand points it takes a hundred megabytes, and is sent as slowly as a client reads.
    Ok(load::holding(held, response.await?))
}

/// Resume a study
///
/// A study that was cancelled goes on; so does one with points that failed by a time limit, a lost worker or an error of the service.
/// Points that have ended otherwise are kept.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/resume", tag = describe::JOBS, operation_id = "resumeStudy",
    params(("id" = Uuid, Path, description = "The job, of kind `study`")),
    responses(
        (status = 202, description = "The study is in the queue again", body = JobAnswer, headers(("Location" = String, description = "Path of the job"))),
        CannotResume, BadQuery, NoJob, NotAccepted, NoSpace, Anywhere
    )
)]
pub async fn resume(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let record = app.jobs.resume(&owner, id).await?;
    Ok((StatusCode::ACCEPTED, [(LOCATION, path_of(id))], Json(JobAnswer::of(record)?)).into_response())
}

/// The table of a study's request and its stored points.
pub fn table_of(request: &str, points: Vec<StoredPoint>) -> Result<TableAnswer, ApiError> {
    let study = contract::parse_job(request.as_bytes()).ok().and_then(Job::into_study);
    let study = study.ok_or_else(|| JobError::Corrupt("the request of a study".into()))?;
    let mut rows = Vec::with_capacity(points.len());
    for point in points {
        let row = Row { status: point.status, reused: point.reused, ..Row::queued(&study, point.number) };
        let answer = point.answer.map(|answer| decompressed(&answer)).transpose()?;
        rows.push(match (point.status, answer) {
            (PointStatus::Succeeded, Some(answer)) => row.ended(PointEnd::Succeeded(read(&answer)?)),
            (PointStatus::Failed, Some(answer)) => row.ended(PointEnd::Failed(read(&answer)?)),
            _ => row,
        });
    }
    Ok(TableAnswer::of(&study, rows))
}
