//! Submit, list, show, cancel and delete jobs.

use std::time::Duration;

use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::header::{HeaderName, LINK, LOCATION, RETRY_AFTER};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error as ValueError;
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::answers::{JobAnswer, JobList, StatusName, path_of};
use super::auth::{Owner, Pass};
use super::describe::{Anywhere, BadBody, BadQuery, HasEnded, HasNotEnded, NoJob, NoSpace, NotAccepted, QueueFull};
use super::error::ApiError;
use super::load::Place;
use super::request::{JobId, JsonBody, Nothing, Query, header, negotiated};
use super::{App, conditional, describe};
use crate::contract;
use crate::contract::job::{input::JobInput, kind::JobKindName};
use crate::contract::{Job, JobKind};
use crate::jobs::{Cancelled, Filter, IdempotencyKey, JobError, JobRecord, Status, Submitted};

const JSON: &[&str] = &["application/json"];
const PREFER: HeaderName = HeaderName::from_static("prefer");
const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");
pub const IDEMPOTENT_REPLAYED: HeaderName = HeaderName::from_static("idempotent-replayed");
const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");

/// Longest time that an answer waits for the end of a job [s].
const LONGEST_WAIT_S: u64 = 60;

/// Submit a job
///
/// Checks the job and puts it into the queue. Once this answers, the job survives a crash of the service and
/// a power cut. With `Prefer: wait=N` the answer waits up to N seconds for the end of the job; a busy service
/// may not wait, and then `Preference-Applied` is absent.
#[utoipa::path(
    post, path = "/v1/jobs", tag = describe::JOBS, operation_id = "submitJob",
    params(SubmitHeaders),
    request_body(content = JobInput, content_type = "application/json", examples(
        ("article" = (summary = "The article's integrated bearing", value = json!({"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}}))),
        ("unbalanced" = (summary = "The same on an unbalanced spindle", value = json!({"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}, "spindle": {"balance_grade": 6.3}}}))),
        ("study" = (summary = "Its level over the curvature of the inner groove", value = json!({"kind": "study", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}, "axes": [{"path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.54, "count": 7}]}))),
        ("optimum" = (summary = "The curvature of least level", value = json!({"kind": "optimum", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}, "axes": [{"path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.54}], "metric": "/channels/spindle.y.acceleration/level_db"}))),
        ("accuracy" = (summary = "Error against run time of the first", value = json!({"kind": "accuracy", "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}, "repetitions": 5})))
    )),
    responses(
        (status = 202, description = "The job is in the queue, or identical finished work answered it (`reused`)", body = JobAnswer,
            headers(("Location" = String, description = "Path of the job"), ("Retry-After" = u32, description = "Seconds after which another look is worth while; absent once the job has ended"), ("Preference-Applied" = String, description = "The wait that was granted, where one was asked for"), ("Idempotent-Replayed" = String, description = "`true` where the `Idempotency-Key` had made this job before"))),
        (status = 200, description = "The job ended within the time of `Prefer: wait`; with its metrics", body = JobAnswer,
            headers(("Location" = String, description = "Path of the job"), ("Preference-Applied" = String, description = "The wait that was granted"))),
        BadBody, NotAccepted, NoSpace, Anywhere, QueueFull
    )
)]
pub async fn submit(
    State(app): State<App>,
    Owner(owner): Owner,
    pass: Pass,
    headers: HeaderMap,
    place: Place,
    _: Query<Nothing>,
    JsonBody(body): JsonBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, JSON)?;
    let wait = preferred_wait(&headers)?;
    let key = idempotency_key(&headers)?;
    let job = parsed(&body).await?;
    let key = key.map(|key| IdempotencyKey::new(key, &job));
    let Submitted { record, replayed } = app.jobs.submit(&job, &owner, key).await?;
    tracing::debug!(job = %record.id, replayed, "accepted");
    let replayed = replayed.then_some((IDEMPOTENT_REPLAYED, HeaderValue::from_static("true")));
    let made: HeaderMap = replayed.into_iter().chain([(LOCATION, text(path_of(record.id)))]).collect();
    drop((job, body));
    // Who waits keeps a connection, so that only some may; a preference may be left.
    let Some((wait, _follows)) = wait.and_then(|wait| Some((wait, place.load().follow()?))) else {
        return Ok((StatusCode::ACCEPTED, made, waiting(&record), Json(JobAnswer::of(record)?)).into_response());
    };
    place.leave();
    let applied = [(PREFERENCE_APPLIED, text(format!("wait={wait}")))];
    let (record, metrics) = match app.jobs.wait(&owner, record.id, Duration::from_secs(wait)).await {
        // What a key has made may be gone: it is not made again, and nobody waits for it.
        Err(JobError::NotFound) => {
            return Ok((StatusCode::ACCEPTED, made, Json(JobAnswer::of(record)?)).into_response());
        }
        // The job is made, and its address must not be lost with the link to the database.
        Err(error) if error.is_away() => {
            return Ok((StatusCode::ACCEPTED, made, waiting(&record), Json(JobAnswer::of(record)?)).into_response());
        }
        now => now?,
    };
    // The token may have been revoked meanwhile.
    if !pass.holds(&app) {
        return Err(ApiError::Unauthorized);
    }
    let status = if record.status.is_final() { StatusCode::OK } else { StatusCode::ACCEPTED };
    let look_again = waiting(&record);
    let answer = JobAnswer::of(record)?.with_metrics(metrics)?;
    Ok((status, made, applied, look_again, Json(answer)).into_response())
}

/// From this length on a body is read on a thread that holds up no other request.
const LONG_BODY: usize = 8 << 10;

async fn parsed(body: &Bytes) -> Result<Job, ApiError> {
    if body.len() < LONG_BODY {
        return Ok(contract::parse_job(body)?);
    }
    let body = body.clone();
    let parsed = tokio::task::spawn_blocking(move || contract::parse_job(&body));
    Ok(parsed.await.map_err(|_| ApiError::Internal)??)
}

/// List jobs
///
/// Newest first. `next` is the path of the next page, also in the header `Link`.
#[utoipa::path(
    get, path = "/v1/jobs", tag = describe::JOBS, operation_id = "listJobs", params(ListQuery),
    responses(
        (status = 200, description = "A page of jobs", body = JobList,
            headers(("Link" = String, description = "The next page, `rel=\"next\"`; absent on the last one"))),
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
    let (records, more) = app.jobs.list(&owner, &query.filter()?).await?;
    let next = records.last().filter(|_| more).map(|last| query.page_after(last.id));
    let link = next.iter().map(|next| (LINK, text(format!("<{next}>; rel=\"next\"")))).collect::<HeaderMap>();
    let jobs = records.into_iter().map(JobAnswer::of).collect::<Result<_, _>>()?;
    Ok((link, Json(JobList { jobs, next })).into_response())
}

/// Show a job
///
/// Its status and progress, why it failed, when it expires; with `include=metrics` its result in short.
#[utoipa::path(
    get, path = "/v1/jobs/{id}", tag = describe::JOBS, operation_id = "showJob",
    params(("id" = Uuid, Path, description = "The job"), ShowQuery),
    responses(
        (status = 200, description = "The job", body = JobAnswer,
            headers(("Retry-After" = u32, description = "Seconds after which another look is worth while; absent once the job has ended"), ("ETag" = String, description = "Weak; `If-None-Match` with it is answered by 304 while nothing has changed"))),
        (status = 304, description = "Nothing has changed since the answer that `If-None-Match` names"),
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
    let look_again = waiting(&record);
    let answer = JobAnswer::of(record)?.with_metrics(metrics)?;
    let json = serde_json::to_vec(&answer).map_err(|_| ApiError::Internal)?;
    Ok((look_again, conditional::standing(&headers, json)).into_response())
}

/// Cancel a job
///
/// A waiting job is cancelled at once, a running one within half a second, even if a full disk
/// does not take the note of it (507). Cancelling again changes nothing.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", tag = describe::JOBS, operation_id = "cancelJob",
    params(("id" = Uuid, Path, description = "The job")),
    responses(
        (status = 200, description = "The job is cancelled", body = JobAnswer),
        (status = 202, description = "The job is running and has been told to stop", body = JobAnswer,
            headers(("Retry-After" = u32, description = "Seconds after which another look is worth while"))),
        HasEnded, BadQuery, NoJob, NotAccepted, NoSpace, Anywhere
    )
)]
pub async fn cancel(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, JSON)?;
    let (status, record) = match app.jobs.cancel(&owner, id).await? {
        Cancelled::Now(record) => (StatusCode::OK, record),
        Cancelled::Soon(record) => (StatusCode::ACCEPTED, record),
    };
    Ok((status, waiting(&record), Json(JobAnswer::of(record)?)).into_response())
}

/// Delete a job
///
/// Removes the job with its result. A job that waits or runs must be cancelled first.
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", tag = describe::JOBS, operation_id = "deleteJob",
    params(("id" = Uuid, Path, description = "The job")),
    responses(
        (status = 204, description = "The job is gone"),
        HasNotEnded, BadQuery, NoJob, NoSpace, Anywhere
    )
)]
pub async fn delete(
    State(app): State<App>,
    Owner(owner): Owner,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<StatusCode, ApiError> {
    app.jobs.delete(&owner, id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Headers of a submission.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
#[allow(dead_code, reason = "only describes the headers; `preferred_wait` and `idempotency_key` read them")]
struct SubmitHeaders {
    /// `wait=N`: answer once the job has ended, after N seconds at the latest (at most 60).
    #[param(rename = "Prefer", nullable = false, example = "wait=10")]
    prefer: Option<String>,
    /// A name of the client's for this submission, 1 to 255 visible ASCII characters: sent again with the same body, the job is not made
    /// again, and the first answer comes back with `Idempotent-Replayed: true`; with another body it is refused (422). Kept as
    /// long as the job, and a day at least.
    #[param(
        rename = "Idempotency-Key",
        nullable = false,
        min_length = 1,
        max_length = 255,
        pattern = "^[!-~]+$",
        example = "4f2c7a1e-line-3"
    )]
    idempotency_key: Option<String>,
}

/// Which jobs a list shows. A parameter that takes several values is repeated, for a label may hold a comma.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(try_from = "Vec<(String, String)>")]
#[into_params(parameter_in = Query)]
pub struct ListQuery {
    /// Only jobs with this status; repeated (`status=failed&status=cancelled`), with any of these.
    #[param(inline = false, required = false, style = Form, explode, max_items = 16)]
    status: Vec<StatusName>,
    /// Only jobs of this kind; repeated, of any of these.
    #[param(inline = false, required = false, style = Form, explode, max_items = 16)]
    kind: Vec<JobKindName>,
    /// Only jobs with this label; repeated (`label=a&label=b`), with all of these.
    #[param(required = false, style = Form, explode, max_items = 16, value_type = Vec<LabelText>, inline)]
    label: Vec<String>,
    /// Only jobs without this label; repeated, without any of these.
    #[param(required = false, style = Form, explode, max_items = 16, value_type = Vec<LabelText>, inline)]
    without_label: Vec<String>,
    /// Jobs a page has at most; 50 unless told.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
    /// Where the page begins, from `next` of the page before.
    #[param(format = Uuid)]
    cursor: Option<String>,
}

/// Values that a parameter takes at most: a job has no more labels.
const MOST_VALUES: usize = 16;

/// A label as a query may name it: none holds a NUL.
#[derive(ToSchema)]
#[schema(value_type = String, pattern = r"^[^\u0000]*$")]
#[expect(dead_code, reason = "only its schema is used")]
struct LabelText(String);

impl TryFrom<Vec<(String, String)>> for ListQuery {
    type Error = String;

    fn try_from(pairs: Vec<(String, String)>) -> Result<Self, String> {
        let mut query = Self::default();
        for (name, value) in pairs {
            let of = |fault: &dyn std::fmt::Display| format!("{name}: {fault}");
            match &*name {
                "status" => query.status.push(named(&value).map_err(|fault| of(&fault))?),
                "kind" => query.kind.push(named(&value).map_err(|fault| of(&fault))?),
                "label" => query.label.push(value),
                "without_label" => query.without_label.push(value),
                "limit" if query.limit.is_none() => query.limit = Some(value.parse().map_err(|fault| of(&fault))?),
                "cursor" if query.cursor.is_none() => query.cursor = Some(value),
                "limit" | "cursor" => return Err(of(&"stands there twice")),
                _ => return Err(format!("unknown field `{name}`, expected one of {LIST_PARAMETERS}")),
            }
        }
        let most =
            [query.status.len(), query.kind.len(), query.label.len(), query.without_label.len()].into_iter().max();
        if most > Some(MOST_VALUES) {
            return Err(format!("a parameter takes at most {MOST_VALUES} values"));
        }
        Ok(query)
    }
}

const LIST_PARAMETERS: &str = "`status`, `kind`, `label`, `without_label`, `limit`, `cursor`";

/// A word as a value of an enumeration.
fn named<'v, T: Deserialize<'v>>(word: &'v str) -> Result<T, ValueError> {
    T::deserialize(word.into_deserializer())
}

impl ListQuery {
    pub(super) fn filter(&self) -> Result<Filter, ApiError> {
        let limit = self.limit.unwrap_or(50);
        if !(1..=200).contains(&limit) {
            return Err(ApiError::BadRequest(format!("query: limit {limit}: must be 1 to 200")));
        }
        let cursor = self.cursor.as_ref().map(|cursor| cursor.parse::<Uuid>()).transpose();
        Ok(Filter {
            statuses: self.status.iter().copied().map(Status::from).collect(),
            kinds: self.kind.iter().map(|kind| JobKind::from(*kind).name().to_owned()).collect(),
            labels: self.label.clone(),
            without_labels: self.without_label.clone(),
            before: cursor.map_err(|_| ApiError::BadRequest("query: cursor: not one of this service".into()))?,
            limit,
        })
    }

    /// The path of the page that goes on behind a job, with the same filters.
    pub(super) fn page_after(&self, last: Uuid) -> String {
        let mut path = format!("/v1/jobs?limit={}&cursor={last}", self.limit.unwrap_or(50));
        let mut add = |name: &str, value: &str| path.push_str(&format!("&{name}={}", percent_encoded(value)));
        self.status.iter().for_each(|status| add("status", Status::from(*status).name()));
        self.kind.iter().for_each(|kind| add("kind", JobKind::from(*kind).name()));
        self.label.iter().for_each(|label| add("label", label));
        self.without_label.iter().for_each(|label| add("without_label", label));
        path
    }
}

fn percent_encoded(value: &str) -> String {
    let encode = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => char::from(byte).to_string(),
        byte => format!("%{byte:02X}"),
    };
    value.bytes().map(encode).collect()
}

/// What comes with a job.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct ShowQuery {
    /// `metrics`: the metrics too, once the job has succeeded.
    #[param(inline = true)]
    include: Option<Include>,
}

#[derive(Debug, Clone, Copy, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Include {
    Metrics,
}

/// When to look again.
fn waiting(record: &JobRecord) -> HeaderMap {
    let look_again = !record.status.is_final();
    look_again.then(|| (RETRY_AFTER, HeaderValue::from_static("1"))).into_iter().collect()
}

/// Seconds of `Prefer: wait=N`; other preferences are the client's wish and may be left.
pub(super) fn preferred_wait(headers: &HeaderMap) -> Result<Option<u64>, ApiError> {
    let preferences = header(headers, &PREFER).unwrap_or_default().split([',', ';']).map(str::trim);
    let mut wait = preferences.filter_map(|preference| preference.split_once('='));
    let Some((_, seconds)) = wait.find(|(name, _)| name.trim().eq_ignore_ascii_case("wait")) else { return Ok(None) };
    let number = seconds.trim().trim_matches('"');
    match number.parse::<u64>() {
        // Longer than any number of seconds that has a name.
        Err(_) if !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit()) => Ok(Some(LONGEST_WAIT_S)),
        Ok(seconds) => Ok(Some(seconds.min(LONGEST_WAIT_S))),
        Err(_) => Err(wrong_wait(seconds.trim())),
    }
}

pub(super) fn wrong_wait(given: &str) -> ApiError {
    let given: String = given.chars().take(20).collect();
    ApiError::BadRequest(format!(
        "Prefer: wait={given}: takes a whole number of seconds; more than {LONGEST_WAIT_S} count as {LONGEST_WAIT_S}"
    ))
}

/// The name that a client gives its submission.
pub fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, ApiError> {
    let mut keys = headers.get_all(IDEMPOTENCY_KEY).iter();
    let Some(key) = keys.next() else { return Ok(None) };
    if keys.next().is_some() {
        return Err(ApiError::BadRequest("Idempotency-Key stands there twice".into()));
    }
    let is_visible = |key: &&[u8]| (1..=255).contains(&key.len()) && key.iter().all(u8::is_ascii_graphic);
    let key = Some(key.as_bytes()).filter(is_visible).and_then(|key| std::str::from_utf8(key).ok());
    let refused = || ApiError::BadRequest("Idempotency-Key takes 1 to 255 visible ASCII characters".into());
    Ok(Some(key.ok_or_else(refused)?.to_owned()))
}

/// Paths and numbers are visible ASCII, so that this always is the value.
fn text(value: String) -> HeaderValue {
    HeaderValue::try_from(value).unwrap_or_else(|_| HeaderValue::from_static(""))
}
