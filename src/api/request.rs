//! Extractors for the parts of a request. Each refuses a wrong part with its own problem.

use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::header::{ACCEPT, CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_TYPE};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName};
use axum::middleware::Next;
use axum::response::Response;
use http_body_util::{BodyExt, LengthLimitError, Limited};
use percent_encoding::percent_decode_str;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use tokio::sync::OwnedSemaphorePermit;
use uuid::Uuid;

use super::concurrency::{Concurrency, RequestPermit};
use super::error::ApiError;
use super::limits::{BODY_LIMIT, HEADER_LIMIT, SERIES_LIMIT};
use crate::contract::is_content_hash;
use crate::jobs::JobError;

/// Layer that refuses long headers. The limit of hyper applies to its buffer, which may hold twice as much.
pub async fn limit_header(request: Request, next: Next) -> Result<Response, ApiError> {
    let fields = request.headers().iter().map(|(name, value)| name.as_str().len() + value.len() + 4);
    if request.uri().to_string().len() + fields.sum::<usize>() > HEADER_LIMIT {
        return Err(ApiError::HeaderTooLarge { limit: HEADER_LIMIT });
    }
    Ok(next.run(request).await)
}

/// Longest time in which a body must arrive.
const BODY_TIMEOUT: Duration = Duration::from_secs(30);

/// A body with the media type of JSON. It holds its permits until it is dropped.
pub struct JsonBody(pub Bytes);

impl<S: Sync> FromRequest<S> for JsonBody {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        check_media_type(request.headers())?;
        whole_body(request, state, BODY_LIMIT).await.map(Self)
    }
}

/// Format of an uploaded series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeriesFormat {
    Json,
    Csv,
}

/// A body with an uploaded series. It holds its permits until it is dropped.
pub struct SeriesBody(pub SeriesFormat, pub Bytes);

impl<S: Sync> FromRequest<S> for SeriesBody {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        let format = match media_type(request.headers())? {
            Some(name) if name.eq_ignore_ascii_case("application/json") => SeriesFormat::Json,
            Some(name) if name.eq_ignore_ascii_case("text/csv") => SeriesFormat::Csv,
            _ => {
                let detail = "send Content-Type: application/json or text/csv";
                return Err(ApiError::UnsupportedMediaType(detail.to_owned()));
            }
        };
        Ok(Self(format, whole_body(request, state, SERIES_LIMIT).await?))
    }
}

/// The body of a request, of at most `limit` bytes.
async fn whole_body<S: Sync>(request: Request, state: &S, limit: usize) -> Result<Bytes, ApiError> {
    let announced = header(request.headers(), &CONTENT_LENGTH).and_then(|length| length.parse::<usize>().ok());
    if announced.is_some_and(|length| length > limit) {
        return Err(ApiError::TooLarge { limit });
    }
    let (mut parts, body) = request.into_parts();
    let Ok(permit) = RequestPermit::from_request_parts(&mut parts, state).await;
    // A slow client must not occupy the permit of another request.
    permit.release();
    let body = tokio::time::timeout(BODY_TIMEOUT, read(body, permit.concurrency(), limit))
        .await
        .unwrap_or(Err(ApiError::SlowBody))?;
    permit.acquire()?;
    Ok(Bytes::from_owner(body))
}

/// A body with its permits.
struct HeldBody {
    bytes: Vec<u8>,
    permits: Vec<OwnedSemaphorePermit>,
}

impl AsRef<[u8]> for HeldBody {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Reads a body. Only bytes that have arrived need permits, whatever length was announced.
async fn read(body: Body, concurrency: &Concurrency, limit: usize) -> Result<HeldBody, ApiError> {
    let mut body = Limited::new(body, limit);
    let mut held = HeldBody { bytes: Vec::new(), permits: Vec::new() };
    while let Some(frame) = body.frame().await {
        let frame = frame.map_err(|error| match error.is::<LengthLimitError>() {
            true => ApiError::TooLarge { limit },
            false => ApiError::BadRequest("the body ended too early".into()),
        })?;
        let Some(bytes) = frame.data_ref() else { continue };
        held.reserve(bytes.len(), concurrency)?;
        held.bytes.extend_from_slice(bytes);
    }
    Ok(held)
}

impl HeldBody {
    /// Takes permits for `more` bytes, in doubling steps like the capacity of the vector.
    fn reserve(&mut self, more: usize, concurrency: &Concurrency) -> Result<(), ApiError> {
        if self.bytes.len() + more > self.bytes.capacity() {
            let capacity = (self.bytes.len() + more).next_power_of_two().max(4096);
            self.permits.push(concurrency.body_bytes(capacity - self.bytes.capacity())?);
            self.bytes.reserve_exact(capacity - self.bytes.len());
        }
        Ok(())
    }
}

/// Refuses other media types than JSON: a form on a foreign page can send text/plain without a preflight request, but not JSON.
fn check_media_type(headers: &HeaderMap) -> Result<(), ApiError> {
    match media_type(headers)? {
        Some(media_type) if media_type.eq_ignore_ascii_case("application/json") => Ok(()),
        _ => Err(ApiError::UnsupportedMediaType("send Content-Type: application/json".to_owned())),
    }
}

/// The media type of a body without encoding.
fn media_type(headers: &HeaderMap) -> Result<Option<&str>, ApiError> {
    match header(headers, &CONTENT_ENCODING) {
        None | Some("identity") => {}
        Some(_) => return Err(ApiError::UnsupportedMediaType("send the body without Content-Encoding".to_owned())),
    }
    Ok(header(headers, &CONTENT_TYPE).map(|value| value.split(';').next().unwrap_or_default().trim()))
}

/// A header as text.
pub fn header<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    headers.get(name)?.to_str().ok()
}

/// The query. Unknown parameters are refused, and repeated parameters that take one value.
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Query<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        match percent_decode_str(parts.uri.query().unwrap_or_default()).decode_utf8() {
            // PostgreSQL does not accept it in text.
            Ok(query) if query.contains('\0') => {
                return Err(ApiError::BadRequest("query: contains a NUL character".into()));
            }
            Ok(_) => {}
            Err(_) => return Err(ApiError::BadRequest("query: is not UTF-8".into())),
        }
        match axum::extract::Query::from_request_parts(parts, state).await {
            Ok(axum::extract::Query(query)) => Ok(Self(query)),
            Err(rejection) => Err(ApiError::BadRequest(format!("query: {}", query_message(&innermost(&rejection))))),
        }
    }
}

/// The query of an operation without parameters.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoQuery {}

/// The message of serde, in terms of query parameters.
fn query_message(fault: &str) -> String {
    const WORDS: [(&str, &str); 6] = [
        ("invalid digit found in string", "must be a whole number"),
        ("invalid float literal", "must be a number"),
        ("there are no fields", "this operation has none"),
        ("unknown field", "unknown parameter"),
        ("unknown variant", "unknown value"),
        ("missing field", "missing parameter"),
    ];
    WORDS.iter().fold(fault.to_owned(), |fault, (serde, query)| fault.replace(serde, query))
}

fn innermost(error: &dyn std::error::Error) -> String {
    let mut error = error;
    while let Some(source) = error.source() {
        error = source;
    }
    error.to_string()
}

/// The id of the job in the path; an invalid UUID is an unknown job.
pub struct JobId(pub Uuid);

impl<S: Send + Sync> FromRequestParts<S> for JobId {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let id = segment(parts, state, "id").await.ok_or(ApiError::UnknownJob)?;
        // Only the form in which ids are issued: another form would be a second address of the same job.
        let parsed: Uuid = id.parse().map_err(|_| ApiError::UnknownJob)?;
        if parsed.to_string() == id { Ok(Self(parsed)) } else { Err(ApiError::UnknownJob) }
    }
}

/// The content hash of a series in the path; a text of another form is an unknown series.
pub struct SeriesHash(pub String);

impl<S: Send + Sync> FromRequestParts<S> for SeriesHash {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let hash = segment(parts, state, "hash").await.filter(|hash| is_content_hash(hash.as_bytes()));
        hash.map(Self).ok_or(ApiError::Job(JobError::NoSeries))
    }
}

/// The plot in the path.
pub struct PlotFile(pub String);

impl<S: Send + Sync> FromRequestParts<S> for PlotFile {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        segment(parts, state, "file").await.map(Self).ok_or(ApiError::UnknownPath)
    }
}

/// A named segment of the path; `None` also if it is not UTF-8.
async fn segment<S: Send + Sync>(parts: &mut Parts, state: &S, name: &str) -> Option<String> {
    let Path(segments) = Path::<Vec<(String, String)>>::from_request_parts(parts, state).await.ok()?;
    segments.into_iter().find(|segment| segment.0 == name).map(|segment| segment.1)
}

/// The offered format that the client prefers; the first of equals.
pub fn negotiated(headers: &HeaderMap, offered: &'static [&'static str]) -> Result<&'static str, ApiError> {
    let accepted: Vec<&str> = headers.get_all(ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    let accepted = accepted.join(",");
    // An empty header states no preference.
    if accepted.trim_matches([',', ' ', '\t']).is_empty() {
        return Ok(offered[0]);
    }
    let mut best: (&str, f32) = ("", 0.0);
    for &format in offered {
        let quality = quality(&accepted, format);
        if quality > best.1 {
            best = (format, quality);
        }
    }
    offered.iter().copied().find(|&format| format == best.0).ok_or(ApiError::NotAcceptable { offered })
}

/// Quality of a format in an Accept header, 0–1; the most specific range counts (RFC 9110, 12.5.1).
fn quality(accepted: &str, format: &str) -> f32 {
    let group = format.split('/').next().unwrap_or_default();
    let mut found: (u8, f32) = (0, 0.0);
    for range in accepted.split(',') {
        let mut parts = range.split(';').map(str::trim);
        let specific = match parts.next().unwrap_or_default().to_ascii_lowercase() {
            range if range == format => 3,
            range if range.strip_suffix("/*") == Some(group) => 2,
            range if range == "*/*" => 1,
            _ => continue,
        };
        let quality = parts.find_map(|part| part.strip_prefix("q=")).map_or(Some(1.0), |q| q.trim().parse().ok());
        if specific > found.0 {
            found = (specific, quality.unwrap_or(0.0));
        }
    }
    found.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preferred_format_is_chosen() {
        const OFFERED: &[&str] = &["application/json", "text/csv"];
        let choose = |accept: &'static str| {
            let headers = HeaderMap::from_iter([(ACCEPT, axum::http::HeaderValue::from_static(accept))]);
            negotiated(&headers, OFFERED).ok()
        };
        assert_eq!(negotiated(&HeaderMap::new(), OFFERED).ok(), Some("application/json"));
        assert_eq!(choose("*/*"), Some("application/json"));
        assert_eq!(choose(""), Some("application/json"));
        assert_eq!(choose(" , ,"), Some("application/json"));
        assert_eq!(choose("text/csv"), Some("text/csv"));
        assert_eq!(choose("text/*;q=0.9, application/json;q=0.2"), Some("text/csv"));
        assert_eq!(choose("text/csv;q=0, */*"), Some("application/json"));
        assert_eq!(choose("application/json;q=0"), None);
        assert_eq!(choose("image/png"), None);
    }
}
