//! Series of a load, uploaded once and named by their content hash.

use axum::Json;
use axum::extract::State;
use axum::http::header::LOCATION;
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use raceway_core::physics::samples::{MOST_VALUES, RATES, Samples};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::app::App;
use super::computation::computed;
use super::concurrency::RequestPermit;
use super::credentials::Owner;
use super::error::ApiError;
use super::openapi::{self, Anywhere, BadQuery, BadSeries, NoSeries, NoSpace, NotAccepted, SeriesInUse};
use super::request::{NoQuery, Query, SeriesBody, SeriesFormat, SeriesHash, negotiated};
use super::stored_answer::JSON;
use crate::contract::{FieldError, Refusal};
use crate::jobs::{PackedSeries, UploadedSeries};

const OFFERED: &[&str] = &[JSON];

/// Values of a load from time 0 on.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SeriesInput {
    /// Values per second [Hz].
    #[schema(minimum = 100, maximum = 200_000, example = 1000.0)]
    rate_hz: f64,
    /// Forces [N] or moments [N·m], by the direction of the load that names them.
    #[schema(min_items = 2, max_items = 2_000_000, example = json!([0, 12.5, 20, 12.5, 0]))]
    values: Vec<f64>,
}

/// The rate of a series as CSV.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SeriesQuery {
    /// Values per second of a body in CSV [Hz]; required there. In JSON the field of the body counts.
    #[param(nullable = false, minimum = 100, maximum = 200_000, example = 1000.0)]
    pub(super) rate_hz: Option<f64>,
}

/// An uploaded series.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct UploadedSeriesAnswer {
    /// Content hash: a load names the series by it.
    #[schema(pattern = "^[0-9a-f]{64}$")]
    hash: String,
    /// Values per second [Hz].
    rate_hz: f64,
    /// Number of values.
    values: u64,
    /// Time of the last value [s].
    duration_s: f64,
    /// Stored bytes, which count for the owner.
    bytes: u64,
    /// Time of the first upload (RFC 3339, UTC).
    #[schema(value_type = String, format = DateTime)]
    created_at: Timestamp,
    /// Time at which the values are removed, unless a job names the series before.
    #[schema(value_type = String, format = DateTime)]
    expires_at: Timestamp,
}

/// Uploaded series.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct SeriesList {
    /// Newest first, at most 1000.
    series: Vec<UploadedSeriesAnswer>,
}

impl From<UploadedSeries> for UploadedSeriesAnswer {
    fn from(series: UploadedSeries) -> Self {
        let UploadedSeries { hash, rate_hz, count, bytes, created_at, expires_at } = series;
        let duration_s = count.saturating_sub(1) as f64 / rate_hz;
        Self { hash, rate_hz, values: count, duration_s, bytes, created_at, expires_at }
    }
}

/// Upload a series
///
/// Values of a load, for `operation.loads[].series`. CSV has one value a line, after an optional heading, and `rate_hz` in the query. The same
/// values have the same hash, and are stored once for each owner. They are kept 30 days after the last request that names them. All series of an
/// owner may take 1 GiB.
#[utoipa::path(
    post, path = "/v1/series", tag = openapi::SCENES, operation_id = "uploadSeries", params(SeriesQuery),
    request_body(content((SeriesInput = "application/json"), (String = "text/csv")), description = "At most 2 million values and 32 MiB"),
    responses(
        (status = 201, description = "The series is stored", body = UploadedSeriesAnswer,
            headers(("Location" = String, description = "Path of the series"))),
        BadSeries, NotAccepted, NoSpace, Anywhere
    )
)]
pub async fn upload(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    permit: RequestPermit,
    Query(SeriesQuery { rate_hz }): Query<SeriesQuery>,
    SeriesBody(format, body): SeriesBody,
) -> Result<Response, ApiError> {
    negotiated(&headers, OFFERED)?;
    let packed = computed(&permit, move |_| {
        let samples = match format {
            SeriesFormat::Json => of_json(rate_hz, &body),
            SeriesFormat::Csv => of_csv(rate_hz, &body),
        };
        samples.map(|samples| PackedSeries::new(&samples))
    });
    let packed = packed.await??.map_err(ApiError::from)?;
    let answer = UploadedSeriesAnswer::from(app.jobs.add_series(&owner, &packed).await?);
    let location = HeaderValue::try_from(format!("/v1/series/{}", answer.hash)).map_err(|_| ApiError::Internal)?;
    Ok((StatusCode::CREATED, [(LOCATION, location)], Json(answer)).into_response())
}

/// List uploaded series
///
/// The series of the owner of the token, newest first.
#[utoipa::path(
    get, path = "/v1/series", tag = openapi::SCENES, operation_id = "listSeries",
    responses((status = 200, description = "The series", body = SeriesList), BadQuery, NotAccepted, Anywhere)
)]
pub async fn list(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, OFFERED)?;
    let series = app.jobs.all_series(&owner).await?.into_iter().map(UploadedSeriesAnswer::from).collect();
    Ok(Json(SeriesList { series }).into_response())
}

/// Show an uploaded series
///
/// Rate, length and expiry. The values are not sent back.
#[utoipa::path(
    get, path = "/v1/series/{hash}", tag = openapi::SCENES, operation_id = "showSeries",
    params(("hash" = String, Path, description = "Content hash", pattern = "^[0-9a-f]{64}$")),
    responses((status = 200, description = "The series", body = UploadedSeriesAnswer), BadQuery, NoSeries, NotAccepted, Anywhere)
)]
pub async fn show(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    SeriesHash(hash): SeriesHash,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, OFFERED)?;
    Ok(Json(UploadedSeriesAnswer::from(app.jobs.uploaded_series(&owner, &hash).await?)).into_response())
}

/// Delete an uploaded series
///
/// Refused while an unfinished job names it. Results of finished jobs stay.
#[utoipa::path(
    delete, path = "/v1/series/{hash}", tag = openapi::SCENES, operation_id = "deleteSeries",
    params(("hash" = String, Path, description = "Content hash", pattern = "^[0-9a-f]{64}$")),
    responses((status = 204, description = "The series is deleted"), SeriesInUse, BadQuery, NoSeries, NotAccepted, NoSpace, Anywhere)
)]
pub async fn delete(
    State(app): State<App>,
    Owner(owner): Owner,
    headers: HeaderMap,
    SeriesHash(hash): SeriesHash,
    _: Query<NoQuery>,
) -> Result<Response, ApiError> {
    negotiated(&headers, OFFERED)?;
    app.jobs.delete_series(&owner, &hash).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

pub(super) fn of_json(query_rate_hz: Option<f64>, body: &[u8]) -> Result<Samples, Refusal> {
    let input: SeriesInput = serde_json::from_slice(body).map_err(|error| match error.classify() {
        serde_json::error::Category::Data => FieldError::new("", error.to_string()).into(),
        _ => Refusal::NotJson { detail: error.to_string() },
    })?;
    query_rate_hz.map_or(Ok(()), |rate_hz| check_rate(rate_hz, ""))?;
    samples(input.rate_hz, input.values, "/rate_hz")
}

/// One value a line; the first line may be a heading. An empty line between values may be a missing one, so that later ones would move.
pub(super) fn of_csv(rate_hz: Option<f64>, body: &[u8]) -> Result<Samples, Refusal> {
    let refuse = |detail: String| Refusal::from(FieldError::new("", detail));
    let rate_hz =
        rate_hz.ok_or_else(|| refuse("CSV needs the rate in the query: /v1/series?rate_hz=1000".to_owned()))?;
    let text = std::str::from_utf8(body).map_err(|_| refuse("the body is not UTF-8".to_owned()))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (mut values, mut gap) = (Vec::new(), None);
    for (number, line) in text.lines().enumerate() {
        match (line.trim(), gap) {
            ("", None) if !values.is_empty() => gap = Some(number),
            ("", _) => {}
            (_, Some(number)) => return Err(refuse(format!("line {}: empty, between two values", number + 1))),
            (entry, None) => match entry.parse::<f64>() {
                Ok(value) if value.is_finite() => values.push(value),
                Err(_) if number == 0 && is_heading(entry) => {}
                _ => {
                    let entry: String = entry.chars().take(40).collect();
                    return Err(refuse(format!("line {}: `{entry}` is no finite number", number + 1)));
                }
            },
        }
    }
    samples(rate_hz, values, "")
}

/// True if a line that is no number is a heading: it begins with a word. Anything else is a wrong value, which must not be passed over.
fn is_heading(line: &str) -> bool {
    line.trim_start_matches(['"', '#', ' ']).starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// `rate_pointer`: pointer to the rate in the body.
fn samples(rate_hz: f64, values: Vec<f64>, rate_pointer: &str) -> Result<Samples, Refusal> {
    check_rate(rate_hz, rate_pointer)?;
    let count = values.len();
    let detail = format!("{count} values: must be from 2 to {MOST_VALUES}, all finite");
    Samples::new(rate_hz, values).ok_or_else(|| FieldError::new("/values", detail).into())
}

fn check_rate(rate_hz: f64, pointer: &str) -> Result<(), Refusal> {
    let [lowest, highest] = RATES;
    if (lowest..=highest).contains(&rate_hz) {
        return Ok(());
    }
    let detail = format!("rate_hz {rate_hz} Hz: must be from {lowest} to {highest} Hz");
    Err(FieldError::new(pointer, detail).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_and_json_give_the_same_values() {
        let csv = of_csv(Some(1000.0), b"force_n\r\n\n0\r\n 12.5\n-3e1\n\n\n").unwrap();
        let json = of_json(None, br#"{"rate_hz": 1000, "values": [0, 12.5, -30]}"#).unwrap();
        assert_eq!(csv, json);
        let marked = of_csv(Some(1000.0), b"\xef\xbb\xbf0\r\n12.5\r\n-30\r\n").unwrap();
        assert_eq!(marked, json, "a byte order mark is no value");
        assert_eq!(of_csv(Some(1000.0), b"\"Force [N]\"\n0\n12.5\n-30").unwrap(), json);
    }

    #[test]
    fn wrong_series_name_their_fault() {
        let text = |refused: Result<Samples, Refusal>| refused.unwrap_err().to_string();
        assert!(text(of_csv(None, b"1\n2")).contains("rate_hz"));
        assert!(text(of_csv(Some(1e3), b"1\n2;3")).contains("line 2: `2;3`"));
        assert!(text(of_csv(Some(1e3), b"1\n2\ninf")).contains("line 3"));
        assert!(text(of_csv(Some(1e3), b"1\n\n\n2")).contains("line 2: empty"));
        for first in ["nan", "inf", "1e999", "−3", "12 N", "1,5", ";"] {
            let body = format!("{first}\n2\n3\n");
            assert!(text(of_csv(Some(1e3), body.as_bytes())).contains(&format!("line 1: `{first}`")), "{first}");
        }
        assert!(text(of_json(None, br#"{"rate_hz": 10, "values": [0, 1]}"#)).contains("must be from 100 to 200000 Hz"));
        assert!(text(of_json(None, br#"{"rate_hz": 1000, "values": [0]}"#)).contains("1 values"));
        assert!(text(of_json(Some(99.0), br#"{"rate_hz": 1000, "values": [0, 1]}"#)).contains("rate_hz 99 Hz"));
        assert!(matches!(of_json(None, b"{"), Err(Refusal::NotJson { .. })));
    }
}
