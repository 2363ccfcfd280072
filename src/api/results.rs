//! Results of a succeeded job: metrics, channels, spectra, series, optimum, and error against run time.

use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::HeaderMap;
use axum::http::header::{CONTENT_TYPE, RANGE};
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::app::App;
use super::concurrency::hold_until_sent;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadQuery, BadRange, NoChannel, NoJob, NoResult, NotAccepted, Unchanged};
use super::request::{JobId, NoQuery, Query, header, negotiated};
use super::series_answer::Part;
use super::stored_answer::{CSV, JSON, NPY, formatted, json_text, respond, series_of, spectrum_of};
use crate::contract::answer::csv;
use crate::contract::answer::signals::SpectrumScaling;
use crate::contract::answer::spectrum_view::{BandsAnswer, SpectrumQuantity};
use crate::contract::job::outputs::{MAX_BAND_EDGES, MIN_BAND_EDGES};
use crate::contract::{
    AccuracyJobAnswer, JobKind, MachineAnswer, Metrics, OptimumAnswer, SeriesAnswer, SpectrumAnswer, SpectrumKind,
};
use crate::jobs::{JobError, Signal, StoredSeries};
use raceway_core::simulation::input::settings::BAND_EDGES;

/// Get the metrics
///
/// Vibration levels, labelled lines, contact loads, motion of the cage, statistics of the solver, the accuracy of the result, and the
/// terms that the equations omit.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/metrics", tag = openapi::RESULTS, operation_id = "getMetrics",
    params(("id" = Uuid, Path, description = "The job")),
    responses((status = 200, description = "The metrics", body = Metrics), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn metrics(wanted: StoredResult) -> Result<Response, ApiError> {
    wanted.metrics(JobKind::Simulation).await
}

/// List the channels
///
/// Channels with a kept spectrum or series: the values of `channel` in `…/spectrum` and `…/series`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/channels", tag = openapi::RESULTS, operation_id = "getChannels",
    params(("id" = Uuid, Path, description = "The job")),
    responses((status = 200, description = "The channels by kind of signal", body = ChannelsAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn channels(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let kept = |signal| app.jobs.channels(&owner, id, signal);
    let (spectra, envelopes, series) =
        (kept(Signal::Amplitude).await?, kept(Signal::Envelope).await?, kept(Signal::Series).await?);
    Ok(Json(ChannelsAnswer { spectra, envelopes, series }).into_response())
}

/// Channels by kind of kept signal.
#[derive(Debug, Serialize, ToSchema)]
struct ChannelsAnswer {
    /// Channels with an amplitude spectrum.
    #[schema(example = json!(["spindle.y.acceleration", "spindle.z.acceleration"]))]
    spectra: Vec<String>,
    /// Channels with an envelope spectrum.
    #[schema(example = json!(["spindle.y.acceleration", "spindle.z.acceleration"]))]
    envelopes: Vec<String>,
    /// Channels with a full time series.
    #[schema(example = json!([]))]
    series: Vec<String>,
}

/// Get a spectrum
///
/// One-sided spectrum of a requested channel, by default the first: of amplitudes, where a sine of amplitude 1 reads 1, of root mean squares, or
/// the power spectral density. A motion also comes as displacement, velocity or acceleration. JSON, or CSV with the header `Accept: text/csv`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/spectrum", tag = openapi::RESULTS, operation_id = "getSpectrum",
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
    formatted(move || query.formatted(format, spectrum)).await
}

/// Get vibration in bands
///
/// Root mean square of velocity and acceleration between given frequencies, from the stored Hann spectrum of an acceleration, by default of the
/// first kept channel in the bands of ISO 15242-1.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/bands", tag = openapi::RESULTS, operation_id = "getBands",
    params(("id" = Uuid, Path, description = "The job"), BandsQuery),
    responses((status = 200, description = "The bands", body = BandsAnswer), Unchanged, BadQuery, NoChannel, NoResult, NotAccepted, Anywhere)
)]
pub async fn bands(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JobId(id): JobId,
    query: Result<Query<BandsQuery>, ApiError>,
) -> Result<Response, ApiError> {
    negotiated(&headers, &[JSON])?;
    let (channel, edges) = unless_of_other_kind(&app, &owner, id, query.and_then(BandsQuery::checked)).await?;
    let channel = named_or_first(&app, &owner, id, Signal::Amplitude, channel).await?;
    let spectrum = spectrum_of(&app, &owner, id, SpectrumKind::Amplitude, &channel).await?;
    formatted(move || bands_response(&spectrum, &edges)).await
}

/// The bands of a spectrum between edges [Hz], as a response.
pub fn bands_response(spectrum: &SpectrumAnswer, edges: &[f64]) -> Result<Response, ApiError> {
    let bands = spectrum.bands(edges).map_err(|detail| ApiError::BadRequest(format!("query: {detail}")))?;
    Ok(respond(JSON, json_text(&bands)?))
}

/// Get a time series
///
/// Time series of a requested channel, by default the first, thinned to at most `max_points` points so that peaks survive. JSON; CSV with
/// the header `Accept: text/csv`; NPY, for `numpy.load`, with `Accept: application/x-npy`: an array of records with the fields `time_s` and
/// `value`, both double. NPY is sent without compression, and with `Range` in parts, so that an interrupted transfer can go on.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/series", tag = openapi::RESULTS, operation_id = "getSeries",
    params(
        ("id" = Uuid, Path, description = "The job"), SeriesQuery,
        ("Range" = Option<String>, Header, description = "Bytes of the NPY file: one range, such as `bytes=0-1023`; ignored in other formats", example = "bytes=0-1023"),
        ("If-Range" = Option<String>, Header, description = "`ETag` of an earlier answer: with another one the whole file is sent", example = "\"0123456789abcdef0123456789abcdef\"")
    ),
    responses(
        (status = 200, description = "The series", content((SeriesAnswer = "application/json"), (String = "text/csv", example = json!("time_s,spindle.y.displacement [µm]\n0.02,0.31\n")), (String = "application/x-npy", example = json!("(bytes) NUMPY {'descr': [('time_s', '<f8'), ('value', '<f8')], …")))),
        (status = 206, description = "The requested bytes of the NPY file", content((String = "application/x-npy", example = json!("(bytes) NUMPY {'descr': [('time_s', '<f8'), ('value', '<f8')], …"))), headers(("Content-Range" = String, description = "Place of the bytes in the file, and its length: `bytes 0-1023/163968`"))),
        BadRange, Unchanged, BadQuery, NoChannel, NoResult, NotAccepted, Anywhere
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
    let permit = app.concurrency.series()?;
    let channel = named_or_first(&app, &owner, id, Signal::Series, query.channel.clone()).await?;
    let part = query.part(series_of(&app, &owner, id, &channel).await?);
    Ok(hold_until_sent(permit, part.answer(format, header(&headers, &RANGE)).await?))
}

/// Get error against run time
///
/// Result of an accuracy job: run time and error of each method at each tolerance, or of each number of modes of a shaft, and the error of the reference itself.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/accuracy", tag = openapi::RESULTS, operation_id = "getAccuracy",
    params(("id" = Uuid, Path, description = "The job, of kind `accuracy`")),
    responses((status = 200, description = "Error against run time", body = AccuracyJobAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn accuracy(wanted: StoredResult) -> Result<Response, ApiError> {
    wanted.report(JobKind::Accuracy).await
}

/// Get the optimum
///
/// Result of an optimum job: the best point and its uncertainty, points that may be as good, and every run of the search.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/optimum", tag = openapi::RESULTS, operation_id = "getOptimum",
    params(("id" = Uuid, Path, description = "The job, of kind `optimum`")),
    responses((status = 200, description = "The optimum", body = OptimumAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn optimum(wanted: StoredResult) -> Result<Response, ApiError> {
    wanted.report(JobKind::Optimum).await
}

/// Get the result of a machine job
///
/// Metrics of every signal, labelled lines, what each bearing did, natural frequencies, and the error of the levels. Spectra are in
/// `…/spectrum`.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/machine", tag = openapi::RESULTS, operation_id = "getMachine",
    params(("id" = Uuid, Path, description = "The job, of kind `machine`")),
    responses((status = 200, description = "The result", body = MachineAnswer), Unchanged, BadQuery, NoJob, NoResult, NotAccepted, Anywhere)
)]
pub async fn machine(wanted: StoredResult) -> Result<Response, ApiError> {
    wanted.metrics(JobKind::Machine).await
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SpectrumQuery {
    /// The channel; by default the first kept one (`…/channels`).
    #[param(example = "spindle.y.acceleration", pattern = r"^[^\u0000]*$")]
    channel: Option<String>,
    /// Kind of spectrum; default `amplitude`.
    #[param(inline = false)]
    kind: Option<SpectrumKind>,
    /// Kind of the values; default `amplitude`.
    #[param(inline = false)]
    scaling: Option<SpectrumScaling>,
    /// Motion that is shown; default: that of the channel. Bins below 10 Hz, and the first two, are left out of an integrated spectrum.
    #[param(inline)]
    quantity: Option<SpectrumQuantity>,
    /// Highest frequency of the answer [Hz].
    #[param(minimum = 0, example = 5000.0)]
    max_frequency_hz: Option<f64>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct BandsQuery {
    /// The channel, an acceleration; by default the first kept one (`…/channels`).
    #[param(example = "spindle.y.acceleration", pattern = r"^[^\u0000]*$")]
    channel: Option<String>,
    /// Rising edges of the bands [Hz], 2 to 17 of them, separated by commas. Default: 50, 300, 1800, 10 000.
    #[param(example = "10,1000", pattern = r"^[^\u0000]*$")]
    edges_hz: Option<String>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SeriesQuery {
    /// The channel; by default the first kept one (`…/channels`).
    #[param(example = "cage.y.displacement", pattern = r"^[^\u0000]*$")]
    channel: Option<String>,
    /// Start of the answer, as time since the start of the run [s]. The first kept value is at `settle_s`.
    from_s: Option<f64>,
    /// End of the answer, as time since the start of the run [s].
    to_s: Option<f64>,
    /// Largest number of points of the answer. The series is divided into half as many intervals of equal length, and the least and the
    /// greatest value of each are kept. So the points are not equidistant, and there may be fewer.
    #[param(value_type = Option<u64>, minimum = 1, maximum = 4_294_967_295_u32, example = 2000)]
    max_points: Option<u32>,
}

impl SpectrumQuery {
    /// The requested part of a spectrum, as a response.
    pub fn formatted(&self, format: &'static str, spectrum: SpectrumAnswer) -> Result<Response, ApiError> {
        let wrong = |detail| ApiError::BadRequest(format!("query: {detail}"));
        let spectrum = match self.quantity {
            Some(quantity) => spectrum.of_quantity(quantity).map_err(wrong)?,
            None => spectrum,
        };
        let spectrum = spectrum.scaled(self.scaling.unwrap_or_default());
        let spectrum = spectrum.up_to(self.max_frequency_hz.unwrap_or(f64::INFINITY));
        Ok(match format {
            CSV => respond(CSV, csv::spectrum_csv(&spectrum)),
            _ => respond(JSON, json_text(&spectrum)?),
        })
    }

    /// The query, if its values are valid.
    pub fn checked(Query(query): Query<Self>) -> Result<Self, ApiError> {
        match query.max_frequency_hz {
            Some(highest) if !highest.is_finite() || highest < 0.0 => {
                Err(ApiError::BadRequest(format!("query: max_frequency_hz: {highest} Hz: must be at least 0 Hz")))
            }
            _ => Ok(query),
        }
    }
}

impl BandsQuery {
    /// The channel and the edges [Hz], if these are numbers.
    pub fn checked(Query(query): Query<Self>) -> Result<(Option<String>, Vec<f64>), ApiError> {
        let Some(text) = query.edges_hz else { return Ok((query.channel, BAND_EDGES.to_vec())) };
        let number = |edge: &str| {
            let shown: String = edge.chars().take(20).collect();
            let refused = || ApiError::BadRequest(format!("query: edges_hz: `{shown}`: must be a number [Hz]"));
            edge.trim().parse::<f64>().ok().filter(|edge| edge.is_finite()).ok_or_else(refused)
        };
        let edges = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
        match edges.len() {
            MIN_BAND_EDGES..=MAX_BAND_EDGES => Ok((query.channel, edges)),
            count => {
                let range = format!("{MIN_BAND_EDGES} to {MAX_BAND_EDGES}");
                Err(ApiError::BadRequest(format!("query: edges_hz: {count} edges: must be {range}")))
            }
        }
    }
}

impl SeriesQuery {
    /// The requested part of a stored series.
    pub fn part(&self, series: StoredSeries) -> Part {
        let places = series.between(self.from_s.unwrap_or(f64::NEG_INFINITY), self.to_s.unwrap_or(f64::INFINITY));
        Part { series, places, max_points: self.max_points.map(|most| most as usize) }
    }

    /// The query, if its values are valid.
    pub fn checked(Query(query): Query<Self>) -> Result<Self, ApiError> {
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

/// A request for the stored result of a job, as JSON.
pub struct StoredResult {
    app: App,
    owner: String,
    id: Uuid,
}

impl FromRequestParts<App> for StoredResult {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        let Ok(Owner(owner)) = Owner::from_request_parts(parts, app).await;
        let JobId(id) = JobId::from_request_parts(parts, app).await?;
        Query::<NoQuery>::from_request_parts(parts, app).await?;
        negotiated(&parts.headers, &[JSON])?;
        Ok(Self { app: app.clone(), owner, id })
    }
}

impl StoredResult {
    /// The result of a job of a kind that keeps signals beside it.
    async fn metrics(self, kind: JobKind) -> Result<Response, ApiError> {
        let text = self.app.jobs.metrics(&self.owner, self.id, kind).await?;
        Ok(([(CONTENT_TYPE, JSON)], text).into_response())
    }

    /// The result of a job of another kind.
    pub async fn report(self, kind: JobKind) -> Result<Response, ApiError> {
        let text = self.app.jobs.report(&self.owner, self.id, kind).await?;
        Ok(([(CONTENT_TYPE, JSON)], text).into_response())
    }
}

/// The query. For a job whose kind keeps no signals, that error is reported instead of a wrong query.
async fn unless_of_other_kind<T>(app: &App, owner: &str, id: Uuid, query: Result<T, ApiError>) -> Result<T, ApiError> {
    match query {
        Ok(query) => Ok(query),
        Err(refused) => match app.jobs.channels(owner, id, Signal::Amplitude).await {
            Err(other @ JobError::OtherKind { .. }) => Err(other.into()),
            _ => Err(refused),
        },
    }
}

/// The named channel, or the first kept one, so that the links of a job are valid without a query.
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
