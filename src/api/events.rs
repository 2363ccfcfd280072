//! A job as it goes, as server-sent events.

use std::convert::Infallible;
use std::time::{Duration, Instant};

use axum::extract::State;
use axum::http::header::HeaderName;
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde_json::{Map, Value, json};
use tokio::sync::OwnedSemaphorePermit;
use utoipa::ToSchema;
use uuid::Uuid;

use super::answers::JobAnswer;
use super::auth::{Owner, Pass};
use super::describe::{Anywhere, BadQuery, NoJob, NotAccepted};
use super::error::ApiError;
use super::load::Place;
use super::request::{JobId, Nothing, Query, header, negotiated};
use super::{App, describe};
use crate::contract::JobKind;
use crate::jobs::{JobError, JobRecord, Status, View};
use crate::simulation::input::control::Phase;
use crate::simulation::result::metrics::level_db;

const STREAM: &[&str] = &["text/event-stream"];
const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");
/// Between two looks at the job: at what is known of its run here, and at its record while it waits, runs elsewhere or is a study, and
/// while it runs here.
const LOOK: Duration = Duration::from_millis(100);
const READ: Duration = Duration::from_millis(200);
const READ_OF_RUN: Duration = Duration::from_secs(1);
/// Silence after which a comment tells that the stream is alive.
const ALIVE: Duration = Duration::from_secs(15);

/// Follow a job
///
/// Server-sent events. `progress`, whenever something has changed: the job without its request, with `phase` (`queued`, `starting`,
/// `checking` a reduced model, `settling`, `recording`, `judging` the accuracy, `computing` the points of a study, `running` in another process) and, while it is
/// recorded, `level_db`: the acceleration levels so far by channel [dB], of all frequencies. Then one of `succeeded`, `failed`, `cancelled`, and the
/// stream ends; a job that has ended gets that at once. Of all that follow jobs at a time, 256 are served; more get 503 and look at the job instead. With `Last-Event-ID` what that event said is not said again. The stream also ends when the service stops, and when the token is revoked or expires.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = describe::JOBS, operation_id = "followJob",
    params(
        ("id" = Uuid, Path, description = "The job"),
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event that was seen", example = "recording-430")
    ),
    responses(
        (status = 200, description = "Events", body = JobEvent, content_type = "text/event-stream",
            example = json!({"event": "progress", "id": "recording-430", "data": "{\"id\":\"0199…\",\"status\":\"running\",\"progress\":0.43,\"phase\":\"recording\"}"})),
        (status = 204, description = "The last event of a job that has ended was seen: nothing more will come"),
        BadQuery, NoJob, NotAccepted, Anywhere
    )
)]
pub async fn events(
    State(app): State<App>,
    Owner(owner): Owner,
    pass: Pass,
    headers: HeaderMap,
    JobId(id): JobId,
    place: Place,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, STREAM)?;
    // Whether the job is there is told before the stream begins.
    let record = app.jobs.get(&owner, id).await?;
    let seen = header(&headers, &LAST_EVENT_ID).map(str::to_owned);
    if record.status.is_final() && seen == Some(id_of(&record, None)) {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let follows = place.load().follow().ok_or(ApiError::Overloaded)?;
    let watch = Watch { app, owner, pass, id, record, read_at: Instant::now(), seen, first: true, _follows: follows };
    let stream = stream::unfold(watch, |mut watch| async move { Some((watch.next().await?, watch)) });
    Ok(Sse::new(stream).keep_alive(KeepAlive::new().interval(ALIVE)).into_response())
}

/// An event of a stream, as a client's parser gives it.
#[derive(ToSchema)]
#[allow(dead_code, reason = "only describes the stream")]
pub struct JobEvent {
    /// `progress`, or how the job has ended: `succeeded`, `failed`, `cancelled`.
    #[schema(example = "progress")]
    event: String,
    /// For `Last-Event-ID`.
    #[schema(example = "recording-430")]
    id: String,
    /// JSON: the job without its request, with `phase` and `level_db`.
    data: String,
}

/// One who follows a job.
struct Watch {
    app: App,
    owner: String,
    pass: Pass,
    id: Uuid,
    /// As it was read last.
    record: JobRecord,
    read_at: Instant,
    /// Id of the last event.
    seen: Option<String>,
    first: bool,
    _follows: OwnedSemaphorePermit,
}

impl Watch {
    /// The next event; `None` after the last one, when the job is deleted, when the token does not hold any more, and when the service stops.
    async fn next(&mut self) -> Option<Result<Event, Infallible>> {
        loop {
            if !self.first && self.record.status.is_final() || self.app.jobs.is_stopping() {
                return None;
            }
            let mut bell = self.app.jobs.bell(self.id);
            // A look at once after the end, one now and then before.
            let now = std::mem::take(&mut self.first) || tokio::time::timeout(LOOK, bell.changed()).await.is_ok();
            if (now || self.is_stale()) && !self.read().await {
                return None;
            }
            if !self.pass.holds(&self.app) {
                return None;
            }
            let record = self.app.jobs.live(self.record.clone());
            let view = self.app.jobs.view(self.id);
            let event_id = id_of(&record, view.as_ref());
            let ended = record.status.is_final();
            if ended || self.seen.as_ref() != Some(&event_id) {
                let name = if ended { record.status.name() } else { "progress" };
                let data = told(record, view)?;
                self.seen = Some(event_id.clone());
                return Some(Ok(Event::default().event(name).id(event_id).data(data)));
            }
        }
    }

    /// Whether the record may say more than what is known here.
    fn is_stale(&self) -> bool {
        let runs_here = self.record.kind != JobKind::Study.name() && self.app.jobs.view(self.id).is_some();
        let has_begun = runs_here && self.record.status == Status::Queued;
        has_begun || self.read_at.elapsed() >= if runs_here { READ_OF_RUN } else { READ }
    }

    /// Reads the record again; whether the job is still there.
    async fn read(&mut self) -> bool {
        match self.app.jobs.get(&self.owner, self.id).await {
            Ok(record) => (self.record, self.read_at) = (record, Instant::now()),
            Err(JobError::NotFound) => return false,
            Err(error) => tracing::warn!(%error, "a job that is followed could not be read"),
        }
        true
    }
}

/// Changes whenever there is something to tell.
fn id_of(record: &JobRecord, view: Option<&View>) -> String {
    let permille = (1000.0 * record.progress).floor();
    let phase = if record.status == Status::Running { phase(record, view) } else { record.status.name() };
    format!("{phase}-{permille}")
}

fn phase(record: &JobRecord, view: Option<&View>) -> &'static str {
    match (record.status, view.and_then(|view| view.phase)) {
        (Status::Running, _) if record.kind == JobKind::Study.name() => "computing",
        (Status::Running, Some(Phase::Checking)) => "checking",
        (Status::Running, Some(Phase::Settling)) => "settling",
        (Status::Running, Some(Phase::Recording)) => "recording",
        (Status::Running, Some(Phase::Judging)) => "judging",
        // Another process runs it.
        (Status::Running, None) if view.is_none() => "running",
        (Status::Running, None) => "starting",
        (status, _) => status.name(),
    }
}

/// The job without its request, its phase, and levels so far; `None` where it cannot be written.
fn told(record: JobRecord, view: Option<View>) -> Option<String> {
    let phase = phase(&record, view.as_ref());
    let levels = view.and_then(|view| view.accelerations).filter(|_| record.status == Status::Running);
    let Ok(Value::Object(mut told)) = serde_json::to_value(JobAnswer::of(record).ok()?) else { return None };
    told.remove("request");
    told.insert("phase".into(), phase.into());
    if let Some(levels) = levels {
        let channels = ["spindle.y.acceleration", "spindle.z.acceleration"];
        let levels = channels
            .into_iter()
            .zip(levels)
            .filter_map(|(channel, rms)| Some((channel.to_owned(), json!(level_db(rms)?))));
        told.insert("level_db".into(), levels.collect::<Map<_, _>>().into());
    }
    serde_json::to_string(&told).ok()
}
