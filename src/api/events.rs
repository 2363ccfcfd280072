//! Progress of a job as server-sent events.

use std::convert::Infallible;
use std::time::{Duration, Instant};

use axum::extract::State;
use axum::http::header::HeaderName;
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use raceway_core::simulation::input::control::Phase;
use raceway_core::simulation::result::metrics::level_db;
use serde_json::{Map, Value, json};
use utoipa::ToSchema;
use uuid::Uuid;

use super::app::App;
use super::auth::Credential;
use super::concurrency::{FollowerPermit, RequestPermit};
use super::credentials::Owner;
use super::error::ApiError;
use super::job_response::JobAnswer;
use super::openapi::{self, Anywhere, BadQuery, NoJob, NotAccepted};
use super::request::{JobId, NoQuery, Query, header, negotiated};
use crate::contract::JobKind;
use crate::jobs::{JobError, JobRecord, Status, View};

const STREAM: &[&str] = &["text/event-stream"];
const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");
/// Header that makes nginx and compatible proxies pass on each event at once.
const X_ACCEL_BUFFERING: HeaderName = HeaderName::from_static("x-accel-buffering");
/// Time between two reads of the run of this process.
const RUN_POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Time between two reads of the record of a job that waits, runs in another process, or is a study.
const RECORD_POLL_INTERVAL: Duration = Duration::from_millis(200);
/// Time between two reads of the record of a job that runs in this process.
const RECORD_POLL_INTERVAL_OF_RUN: Duration = Duration::from_secs(1);
/// Silence after which a comment keeps the stream alive.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Follow a job
///
/// Server-sent events. `progress` is sent at every change: the job without its request, with `phase` and, while the motion is recorded,
/// `level_db`: the acceleration levels up to now by channel [dB], over all frequencies. The phases are `queued`, `starting`, `checking`
/// (a reduced model), `settling`, `recording`, `judging` (the accuracy), `computing` (the points of a study) and `running` (in another
/// process). The last event is `succeeded`, `failed` or `cancelled`; a job that has ended gets it at once. With `Last-Event-ID` that
/// event is not repeated. At most 256 streams and waiting requests are open at a time, and half of
/// them of one owner of tokens; further requests get 503 and should poll the job. The stream also
/// ends when the service stops, and when the token is revoked or expires.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = openapi::JOBS, operation_id = "followJob",
    params(
        ("id" = Uuid, Path, description = "The job"),
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last received event", example = "recording-430")
    ),
    responses(
        (status = 200, description = "Events", body = JobEvent, content_type = "text/event-stream",
            headers(("X-Accel-Buffering" = String, description = "`no`: a proxy passes on each event at once")),
            example = json!({"event": "progress", "id": "recording-430", "data": "{\"id\":\"0199…\",\"status\":\"running\",\"progress\":0.43,\"phase\":\"recording\"}"})),
        (status = 204, description = "The last event of an ended job was received: no more events follow"),
        BadQuery, NoJob, NotAccepted, Anywhere
    )
)]
pub async fn events(
    State(app): State<App>,
    owner: Owner,
    credential: Credential,
    headers: HeaderMap,
    JobId(id): JobId,
    permit: RequestPermit,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, STREAM)?;
    // A missing job is reported before the stream begins.
    let record = app.jobs.get(&owner.0, id).await?;
    let seen = header(&headers, &LAST_EVENT_ID).map(str::to_owned);
    if record.status.is_final() && seen == Some(id_of(&record, None)) {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let follower_permit =
        permit.concurrency().follow(credential.has_token().then_some(&owner)).ok_or(ApiError::Overloaded)?;
    let owner = owner.0;
    let read_at = Instant::now();
    let follower =
        Follower { app, owner, credential, id, record, read_at, seen, first: true, _permit: follower_permit };
    let stream = stream::unfold(follower, |mut follower| async move { Some((follower.next().await?, follower)) });
    let events = Sse::new(stream).keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    Ok(([(X_ACCEL_BUFFERING, "no")], events).into_response())
}

/// An event of the stream.
#[derive(ToSchema)]
#[allow(dead_code, reason = "only describes the stream")]
struct JobEvent {
    /// `progress`, or the final status: `succeeded`, `failed`, `cancelled`.
    #[schema(example = "progress")]
    event: String,
    /// Id for `Last-Event-ID`.
    #[schema(example = "recording-430")]
    id: String,
    /// JSON: the job without its request, with `phase` and `level_db`.
    data: String,
}

/// State of one event stream.
struct Follower {
    app: App,
    owner: String,
    credential: Credential,
    id: Uuid,
    /// The record as it was last read.
    record: JobRecord,
    read_at: Instant,
    /// Id of the last event.
    seen: Option<String>,
    first: bool,
    _permit: FollowerPermit,
}

impl Follower {
    /// The next event; `None` after the last event, when the job is deleted, when the token is no longer valid, and when the service stops.
    async fn next(&mut self) -> Option<Result<Event, Infallible>> {
        loop {
            if !self.first && self.record.status.is_final() || self.app.jobs.is_stopping() {
                return None;
            }
            let mut completion = self.app.jobs.completion(self.id);
            // At once after the end, else after the poll interval.
            let has_ended = async { tokio::time::timeout(RUN_POLL_INTERVAL, completion.changed()).await.is_ok() };
            let now = std::mem::take(&mut self.first) || has_ended.await;
            if (now || self.is_stale()) && !self.read().await {
                return None;
            }
            if !self.credential.is_valid(&self.app) {
                return None;
            }
            let record = self.app.jobs.with_progress(self.record.clone());
            let view = self.app.jobs.view(self.id);
            let event_id = id_of(&record, view.as_ref());
            let ended = record.status.is_final();
            if ended || self.seen.as_ref() != Some(&event_id) {
                let name = if ended { record.status.name() } else { "progress" };
                let data = event_data(record, view)?;
                self.seen = Some(event_id.clone());
                return Some(Ok(Event::default().event(name).id(event_id).data(data)));
            }
        }
    }

    /// Returns whether the stored record may be newer than the last read one.
    fn is_stale(&self) -> bool {
        let runs_here = !JobKind::has_points(&self.record.kind) && self.app.jobs.view(self.id).is_some();
        let has_started = runs_here && self.record.status == Status::Queued;
        has_started
            || self.read_at.elapsed() >= if runs_here { RECORD_POLL_INTERVAL_OF_RUN } else { RECORD_POLL_INTERVAL }
    }

    /// Reads the record again; returns whether the job still exists.
    async fn read(&mut self) -> bool {
        match self.app.jobs.get(&self.owner, self.id).await {
            Ok(record) => (self.record, self.read_at) = (record, Instant::now()),
            Err(JobError::NotFound | JobError::Expired(_)) => return false,
            Err(error) => tracing::warn!(%error, "the job of an event stream could not be read"),
        }
        true
    }
}

/// Id of the event: it changes with the phase and with every 0.1 % of progress.
fn id_of(record: &JobRecord, view: Option<&View>) -> String {
    let permille = (1000.0 * record.progress).floor();
    let phase = if record.status == Status::Running { phase(record, view) } else { record.status.name() };
    format!("{phase}-{permille}")
}

fn phase(record: &JobRecord, view: Option<&View>) -> &'static str {
    match (record.status, view.and_then(|view| view.phase)) {
        (Status::Running, _) if JobKind::has_points(&record.kind) => "computing",
        (Status::Running, Some(Phase::Checking)) => "checking",
        (Status::Running, Some(Phase::Settling)) => "settling",
        (Status::Running, Some(Phase::Recording)) => "recording",
        (Status::Running, Some(Phase::Judging)) => "judging",
        // The job runs in another process.
        (Status::Running, None) if view.is_none() => "running",
        (Status::Running, None) => "starting",
        (status, _) => status.name(),
    }
}

/// The job without its request, with its phase and current levels; `None` if it cannot be serialized.
fn event_data(record: JobRecord, view: Option<View>) -> Option<String> {
    let phase = phase(&record, view.as_ref());
    let levels = view.and_then(|view| view.accelerations).filter(|_| record.status == Status::Running);
    let Ok(Value::Object(mut data)) = serde_json::to_value(JobAnswer::of(record).ok()?) else { return None };
    data.remove("request");
    data.insert("phase".into(), phase.into());
    if let Some(levels) = levels {
        let channels = ["spindle.y.acceleration", "spindle.z.acceleration"];
        let levels = channels
            .into_iter()
            .zip(levels)
            .filter_map(|(channel, rms)| Some((channel.to_owned(), json!(level_db(rms)?))));
        data.insert("level_db".into(), levels.collect::<Map<_, _>>().into());
    }
    serde_json::to_string(&data).ok()
}
