//! Metrics, spectra, series and error against run time of a succeeded job.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::{CONTENT_TYPE, VARY};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::auth::Owner;
use super::describe::{Anywhere, BadQuery, NoChannel, NoJob, NoResult, NotAccepted, Unchanged};
use super::error::ApiError;
use super::request::{JobId, Nothing, Query, negotiated};
use super::{App, describe, load};
use crate::contract::answer::csv;
use crate::contract::{
    JobKind, Metrics, OptimumAnswer, SeriesAnswer, SpectrumAnswer, SpectrumKind, WorkPrecisionAnswer,
};
use crate::jobs::{JobError, Signal};

pub(super) const JSON: &str = "application/json";
pub(super) const CSV: &str = "text/csv";
pub(super) const NPY: &str = "application/x-npy";

/// Get the metrics
///
/// Vibration levels, labelled lines, loads, cage motion, how the solver worked, how far the result can be
/// trusted, and what was left out of the equations.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/metrics", tag = describe::RESULTS, operation_id = "getMetrics",
    params(("id" = Uuid, Path, description = "The job")),
    responses((status = 200, description = "The metrics", body = Metrics), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn metrics(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    Ok(([(CONTENT_TYPE, JSON)], app.jobs.metrics(&owner, id).await?).into_response())
}

/// List the channels
///
/// Of which spectra and series are kept: what `…/spectrum` and `…/series` take.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/channels", tag = describe::RESULTS, operation_id = "getChannels",
    params(("id" = Uuid, Path, description = "The job")),
    responses((status = 200, description = "The channels by what is kept of them", body = ChannelsAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn channels(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let kept = |signal| app.jobs.channels(&owner, id, signal);
    let (spectra, envelopes, series) =
        (kept(Signal::Amplitude).await?, kept(Signal::Envelope).await?, kept(Signal::Series).await?);
    Ok(Json(ChannelsAnswer { spectra, envelopes, series }).into_response())
}

/// What is kept of a job, by channel.
#[derive(Debug, Serialize, ToSchema)]
pub struct ChannelsAnswer {
    /// With an amplitude spectrum.
    #[schema(example = json!(["spindle.y.acceleration", "spindle.z.acceleration"]))]
    pub spectra: Vec<String>,
    /// With an envelope spectrum.
    #[schema(example = json!(["spindle.y.acceleration", "spindle.z.acceleration"]))]
    pub envelopes: Vec<String>,
    /// With a whole time series.
    #[schema(example = json!([]))]
    pub series: Vec<String>,
}

/// Get a spectrum
///
/// One-sided amplitude spectrum of a channel that the request asked for, of the first one unless told: a sine of amplitude 1 reads 1. As
/// JSON, or as CSV with the header `Accept: text/csv`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/spectrum", tag = describe::RESULTS, operation_id = "getSpectrum",
    params(("id" = Uuid, Path, description = "The job"), SpectrumQuery),
    responses(
        (status = 200, description = "The spectrum", content((SpectrumAnswer = "application/json"), (String = "text/csv", example = json!("frequency_hz,spindle.y.acceleration [m/s²]\n0,0\n8,0.0123\n")))),
        Unchanged, BadQuery, NoChannel, NoResult, NotAccepted, Anywhere
    )
)]
pub async fn spectrum(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    query: Result<Query<SpectrumQuery>, ApiError>,
) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV])?;
    let query = unless_of_other_kind(&app, &owner, id, query.and_then(SpectrumQuery::checked)).await?;
    let kind = query.kind.unwrap_or(SpectrumKind::Amplitude);
    let channel = named_or_first(&app, &owner, id, kind.into(), query.channel.clone()).await?;
    let spectrum = spectrum_of(&app, &owner, id, kind, &channel).await?;
    shaped(move || query.shape(format, spectrum)).await
}

/// Get a time series
///
/// A channel whose series the request asked for, the first one unless told, thinned to `max_points` or fewer in such a way that peaks survive.
/// As JSON; as CSV with the header `Accept: text/csv`; as NPY, for NumPy's `load`, with `Accept: application/x-npy`: an array of records with the
/// fields `time_s` and `value`, doubles.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/series", tag = describe::RESULTS, operation_id = "getSeries",
    params(("id" = Uuid, Path, description = "The job"), SeriesQuery),
    responses(
        (status = 200, description = "The series", content((SeriesAnswer = "application/json"), (String = "text/csv", example = json!("time_s,spindle.y.displacement [µm]\n0.02,0.31\n")), (String = "application/x-npy", example = json!("(bytes) NUMPY {'descr': [('time_s', '<f8'), ('value', '<f8')], …")))),
        Unchanged, BadQuery, NoChannel, NoResult, NotAccepted, Anywhere
    )
)]
pub async fn series(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    query: Result<Query<SeriesQuery>, ApiError>,
) -> Result<Response, ApiError> {
    let format = negotiated(&headers, &[JSON, CSV, NPY])?;
    let query = unless_of_other_kind(&app, &owner, id, query.and_then(SeriesQuery::checked)).await?;
    let place = app.load.series()?;
    let channel = named_or_first(&app, &owner, id, Signal::Series, query.channel.clone()).await?;
    let stored = series_of(&app, &owner, id, &channel).await?;
    if format == JSON && query.from_s.is_none() && query.to_s.is_none() && query.max_points.is_none() {
        return Ok(load::holding(place, sent(JSON, stored)));
    }
    Ok(load::holding(place, shaped(move || query.shape(format, &stored)).await?))
}

/// Get error against run time
///
/// Of an accuracy job: what each method costs at each tolerance, how far it is from the reference, and how far the
/// reference itself can be trusted.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/accuracy", tag = describe::RESULTS, operation_id = "getAccuracy",
    params(("id" = Uuid, Path, description = "The job, of kind `accuracy`")),
    responses((status = 200, description = "Error against run time", body = WorkPrecisionAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn accuracy(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    Ok(([(CONTENT_TYPE, JSON)], app.jobs.report(&owner, id, JobKind::Accuracy).await?).into_response())
}

/// Get the optimum
///
/// Of an optimum job: the best point that was run, how well it is known, where others may be as good, and every run of the search.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/optimum", tag = describe::RESULTS, operation_id = "getOptimum",
    params(("id" = Uuid, Path, description = "The job, of kind `optimum`")),
    responses((status = 200, description = "The optimum", body = OptimumAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn optimum(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<Nothing>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    Ok(([(CONTENT_TYPE, JSON)], app.jobs.report(&owner, id, JobKind::Optimum).await?).into_response())
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SpectrumQuery {
    /// The channel; the first that is kept (`…/channels`), where none is named.
    #[param(example = "spindle.y.acceleration")]
    channel: Option<String>,
    /// `amplitude` unless told.
    #[param(inline = false)]
    kind: Option<SpectrumKind>,
    /// Highest frequency of the answer [Hz].
    #[param(minimum = 0, example = 5000.0)]
    max_frequency_hz: Option<f64>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SeriesQuery {
    /// The channel; the first that is kept (`…/channels`), where none is named.
    #[param(example = "cage.y.displacement")]
    channel: Option<String>,
    /// Begin of the answer, in time since the start of the run, settling included [s]: the first kept value stands at `settle_s`.
    from_s: Option<f64>,
    /// End of the answer, in the same time [s].
    to_s: Option<f64>,
    /// Points of the answer at most. Of each of half as many stretches of equal length the least and the greatest value are kept, so
    /// that there may be fewer points, at uneven distances: one less where this is odd, or where both are one value.
    #[param(value_type = Option<u64>, minimum = 1, maximum = 4_294_967_295_u32, example = 2000)]
    max_points: Option<u32>,
}

impl SpectrumQuery {
    /// What is asked for of a spectrum.
    pub(super) fn shape(&self, format: &'static str, spectrum: SpectrumAnswer) -> Result<Response, ApiError> {
        let spectrum = spectrum.up_to(self.max_frequency_hz.unwrap_or(f64::INFINITY));
        Ok(match format {
            CSV => sent(CSV, csv::spectrum_csv(&spectrum)),
            _ => sent(JSON, written(&spectrum)?),
        })
    }

    pub(super) fn checked(Query(query): Query<Self>) -> Result<Self, ApiError> {
        match query.max_frequency_hz {
            Some(highest) if !highest.is_finite() || highest < 0.0 => {
                Err(ApiError::BadRequest(format!("query: max_frequency_hz: {highest} Hz: must be at least 0 Hz")))
            }
            _ => Ok(query),
        }
    }
}

impl SeriesQuery {
    /// What is asked for of a stored series.
    pub(super) fn shape(&self, format: &'static str, stored: &[u8]) -> Result<Response, ApiError> {
        let (from, to) = (self.from_s.unwrap_or(f64::NEG_INFINITY), self.to_s.unwrap_or(f64::INFINITY));
        let series = read::<SeriesAnswer>(stored)?.between(from, to);
        let series = match self.max_points {
            Some(most) => series.thinned(most as usize),
            None => series,
        };
        Ok(match format {
            CSV => sent(CSV, csv::series_csv(&series)),
            NPY => sent(NPY, csv::series_npy(&series)),
            _ => sent(JSON, written(&series)?),
        })
    }

    pub(super) fn checked(Query(query): Query<Self>) -> Result<Self, ApiError> {
        let refuse = |what: &str| Err(ApiError::BadRequest(format!("query: {what}")));
        match (query.from_s, query.to_s, query.max_points) {
            (Some(from), _, _) if from.is_nan() => refuse("from_s: not a number"),
            (_, Some(to), _) if to.is_nan() => refuse("to_s: not a number"),
            (Some(from), Some(to), _) if from > to => refuse("from_s: after to_s"),
            (_, _, Some(0)) => refuse("max_points: 0: must be at least 1"),
            _ => Ok(query),
        }
    }
}

/// The query; a wrong one of a job whose kind keeps no signals is told that, for no query would do.
async fn unless_of_other_kind<T>(app: &App, owner: &str, id: Uuid, query: Result<T, ApiError>) -> Result<T, ApiError> {
    match query {
        Ok(query) => Ok(query),
        Err(refused) => match app.jobs.channels(owner, id, Signal::Amplitude).await {
            Err(other @ JobError::OtherKind { .. }) => Err(other.into()),
            _ => Err(refused),
        },
    }
}

/// The channel that is named, the first one that is kept where there is none, so that the links of a job can be followed as they stand.
async fn named_or_first(
    app: &App,
    owner: &str,
    id: Uuid,
    signal: Signal,
    named: Option<String>,
) -> Result<String, ApiError> {
    match named {
        Some(channel) => Ok(channel),
        None => {
            let first = app.jobs.channels(owner, id, signal).await?.into_iter().next();
            first.ok_or(ApiError::UnknownChannel { channel: String::new(), kept: Vec::new() })
        }
    }
}

/// A spectrum, or of which channels there are.
pub async fn spectrum_of(
    app: &App,
    owner: &str,
    id: Uuid,
    kind: SpectrumKind,
    channel: &str,
) -> Result<SpectrumAnswer, ApiError> {
    app.jobs.spectrum(owner, id, kind, channel).await.map_err(|error| of_channel(error, channel))
}

/// A stored series, or of which channels there are.
pub async fn series_of(app: &App, owner: &str, id: Uuid, channel: &str) -> Result<Vec<u8>, ApiError> {
    app.jobs.series(owner, id, channel).await.map_err(|error| of_channel(error, channel))
}

fn of_channel(error: JobError, channel: &str) -> ApiError {
    match error {
        JobError::UnknownChannel { kept } => ApiError::UnknownChannel { channel: channel.to_owned(), kept },
        other => other.into(),
    }
}

/// Shapes an answer away from the threads that serve HTTP: it may hold a million numbers.
pub async fn shaped(shape: impl FnOnce() -> Result<Response, ApiError> + Send + 'static) -> Result<Response, ApiError> {
    tokio::task::spawn_blocking(shape).await.unwrap_or(Err(ApiError::Internal))
}

/// A stored answer.
pub fn read<T: DeserializeOwned>(stored: &[u8]) -> Result<T, ApiError> {
    serde_json::from_slice(stored).map_err(|error| JobError::Corrupt(error.to_string()).into())
}

fn written(answer: &impl serde::Serialize) -> Result<Vec<u8>, ApiError> {
    serde_json::to_vec(answer).map_err(|error| JobError::Corrupt(error.to_string()).into())
}

fn sent(format: &'static str, body: impl IntoResponse) -> Response {
    ([(VARY, "Accept"), (CONTENT_TYPE, format)], body.into_response().into_body()).into_response()
}
