//! A measured record beside the prediction of a job, compared at once.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::{IntoResponse, Response};
use uuid::Uuid;

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadBody, NoComparison, NoResult, NotAccepted};
use super::request::{JobId, JsonBody, NoQuery, Query, negotiated};
use super::stored_answer::{JSON, read, spectrum_of};
use crate::contract::job::measurement::MeasurementInput;
use crate::contract::{
    FieldError, Job, JobKind, MachineAnswer, MeasuredAnswer, MeasurementRequest, Metrics, Prediction, Refusal,
    SpectrumKind, Uploads, parse_job_with, unit_factor,
};
use crate::jobs::{JobError, Signal};

/// Compare a measurement
///
/// Levels and lines of a measured record, an uploaded series, beside those of a predicted channel. Both have the same window, resolution and
/// averages. Lines are compared by order: by frequency over the speed of the own shaft. The answer comes at once; no job is created.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/comparison", tag = openapi::RESULTS, operation_id = "compareMeasurement",
    params(("id" = Uuid, Path, description = "The job, of kind `simulation` or `machine`, at a constant speed")),
    request_body(content = MeasurementInput, content_type = "application/json", example = json!({
        "series": "0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f", "unit": "g", "speed_rpm": 2998.5
    })),
    responses((status = 200, description = "The comparison", body = MeasuredAnswer), BadBody, NoComparison, NoResult, NotAccepted, Anywhere)
)]
pub async fn compare(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    permit: RequestPermit,
    _: Query<NoQuery>,
    JsonBody(body): JsonBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let kept = app.jobs.channels(&owner, id, Signal::Amplitude).await?;
    let request = MeasurementRequest::read(&body)?;
    let channel = kept_channel(request.channel(), &kept)?;
    unit_factor(request.unit(), channel)?;
    let prediction = prediction(&app, &owner, id, &permit, channel).await?;
    let place = permit.comparison_place().await?;
    let uploads = app.jobs.named_series(&owner, &body).await?;
    let compared = computed(&permit, move |stop| {
        let _held = place;
        MeasuredAnswer::of(&request.with(&uploads)?, &prediction, stop)
    });
    let compared = compared.await??;
    Ok(Json(compared.ok_or(ApiError::Internal)?).into_response())
}

/// The named channel, or the first kept one.
fn kept_channel<'a>(named: Option<&'a String>, kept: &'a [String]) -> Result<&'a str, ApiError> {
    match named {
        Some(channel) if kept.contains(channel) => Ok(channel),
        None if !kept.is_empty() => Ok(&kept[0]),
        _ => {
            let shown: Vec<String> = kept.iter().map(|channel| format!("`{channel}`")).collect();
            let detail = match shown.is_empty() {
                true => "the job kept no spectrum: name a channel in outputs.spectra".to_owned(),
                false => format!("the spectrum is not kept; kept are {}", shown.join(", ")),
            };
            Err(Refusal::from(FieldError::new("/channel", detail)).into())
        }
    }
}

/// The prediction of a channel.
async fn prediction(
    app: &App,
    owner: &str,
    id: Uuid,
    permit: &RequestPermit,
    channel: &str,
) -> Result<Prediction, ApiError> {
    let request = app.jobs.get(owner, id).await?.request;
    let job = computed(permit, move |_| parse_job_with(request.as_bytes(), &Uploads::stand_in()));
    let job = job.await?.map_err(|error| ApiError::from(JobError::Corrupt(error.to_string())))?;
    let speed_hz = constant_speed(&job)?;
    let spectrum = spectrum_of(app, owner, id, SpectrumKind::Amplitude, channel).await?;
    let envelopes = app.jobs.channels(owner, id, Signal::Envelope).await?;
    let envelope = job.envelope().filter(|_| envelopes.iter().any(|kept| kept == channel));
    let text = app.jobs.metrics(owner, id, job.kind()).await?;
    if job.kind() == JobKind::Machine {
        let metrics: MachineAnswer = read(text.as_bytes())?;
        return Ok(Prediction {
            level_error_db: metrics.accuracy.level_errors_db.get(channel).copied(),
            level_scatter_db: None,
            is_resolved: true,
            lines: metrics.lines,
            envelope_lines: metrics.envelope_lines,
            spectrum,
            envelope,
            speed_hz,
        });
    }
    let metrics: Metrics = read(text.as_bytes())?;
    let of_channel = metrics.channels.as_ref().and_then(|channels| channels.get(channel));
    Ok(Prediction {
        level_error_db: of_channel.and_then(|of| of.level_error_db),
        level_scatter_db: of_channel.and_then(|of| of.level_scatter_db),
        is_resolved: of_channel.is_none_or(|of| of.resolved != Some(false)),
        lines: metrics.lines.unwrap_or_default(),
        envelope_lines: metrics.envelope_lines.unwrap_or_default(),
        spectrum,
        envelope,
        speed_hz,
    })
}

/// Speed of the shaft of a prediction [Hz], which must be constant.
fn constant_speed(job: &Job) -> Result<f64, ApiError> {
    let refuse = |detail: &str| Err(Refusal::from(FieldError::new("", detail)).into());
    let Some(angle) = job.recorded_turns(0.0).and_then(|run| run.angle) else {
        return refuse("the predicted outer ring turns, or the shaft reverses: a comparison needs orders of the shaft");
    };
    let (least, most) = angle.speeds();
    if least < most {
        return refuse("the predicted speed varies: a comparison needs a prediction at a constant speed");
    }
    if most <= 0.0 {
        return refuse("the predicted shaft stands: a comparison needs orders of the shaft");
    }
    Ok(most)
}
