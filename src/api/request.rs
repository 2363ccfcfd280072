//! Parts of a request, each refused with a problem of its own.

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

use super::error::ApiError;
use super::load::{Load, Place};

/// Bytes of a body at most.
pub const BODY_LIMIT: usize = 1 << 20;

/// Bytes of a request's header at most, with its first line.
pub const HEADER_LIMIT: usize = 64 << 10;

/// Refuses longer ones: hyper's own limit is of its buffer, which may hold twice as much.
pub async fn limit_header(request: Request, next: Next) -> Result<Response, ApiError> {
    let fields = request.headers().iter().map(|(name, value)| name.as_str().len() + value.len() + 4);
    if request.uri().to_string().len() + fields.sum::<usize>() > HEADER_LIMIT {
        return Err(ApiError::HeaderTooLarge { limit: HEADER_LIMIT });
    }
    Ok(next.run(request).await)
}

/// Time that a body has to arrive.
const BODY_TIME: Duration = Duration::from_secs(30);

/// A body that says it is JSON. It takes room among the bodies until it is dropped.
pub struct JsonBody(pub Bytes);

impl<S: Sync> FromRequest<S> for JsonBody {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        check_media_type(request.headers())?;
        let announced = header(request.headers(), &CONTENT_LENGTH).and_then(|length| length.parse::<usize>().ok());
        if announced.is_some_and(|length| length > BODY_LIMIT) {
            return Err(ApiError::TooLarge { limit: BODY_LIMIT });
        }
        let (mut parts, body) = request.into_parts();
        let Ok(place) = Place::from_request_parts(&mut parts, state).await;
        // Slow clients keep no quick ones out.
        place.leave();
        let body =
            tokio::time::timeout(BODY_TIME, read(body, place.load())).await.unwrap_or(Err(ApiError::SlowBody))?;
        place.enter()?;
        Ok(Self(Bytes::from_owner(body)))
    }
}

/// A body with the room that it takes.
struct Held {
    bytes: Vec<u8>,
    room: Vec<OwnedSemaphorePermit>,
}

impl AsRef<[u8]> for Held {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Reads as it comes: only what has arrived takes room, whatever length was announced.
async fn read(body: Body, load: &Load) -> Result<Held, ApiError> {
    let mut body = Limited::new(body, BODY_LIMIT);
    let mut held = Held { bytes: Vec::new(), room: Vec::new() };
    while let Some(frame) = body.frame().await {
        let frame = frame.map_err(|error| match error.is::<LengthLimitError>() {
            true => ApiError::TooLarge { limit: BODY_LIMIT },
            false => ApiError::BadRequest("the body ended too early".into()),
        })?;
        let Some(bytes) = frame.data_ref() else { continue };
        held.make_room(bytes.len(), load)?;
        held.bytes.extend_from_slice(bytes);
    }
    Ok(held)
}

impl Held {
    /// Room comes in doubling steps, as the vector's own does.
    fn make_room(&mut self, more: usize, load: &Load) -> Result<(), ApiError> {
        if self.bytes.len() + more > self.bytes.capacity() {
            let capacity = (self.bytes.len() + more).next_power_of_two().max(4096);
            self.room.push(load.room(capacity - self.bytes.capacity())?);
            self.bytes.reserve_exact(capacity - self.bytes.len());
        }
        Ok(())
    }
}

/// A form of a foreign page can send text/plain without being asked, but not JSON.
fn check_media_type(headers: &HeaderMap) -> Result<(), ApiError> {
    let refuse = |detail: &str| Err(ApiError::UnsupportedMediaType(detail.to_owned()));
    let media_type = header(headers, &CONTENT_TYPE).map(|value| value.split(';').next().unwrap_or_default().trim());
    match media_type {
        Some(media_type) if media_type.eq_ignore_ascii_case("application/json") => {}
        _ => return refuse("send Content-Type: application/json"),
    }
    match header(headers, &CONTENT_ENCODING) {
        None | Some("identity") => Ok(()),
        Some(_) => refuse("send the body without Content-Encoding"),
    }
}

/// A header as text.
pub fn header<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    headers.get(name)?.to_str().ok()
}

/// The query; unknown parameters are refused, and repeated ones that take one value.
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Query<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        match percent_decode_str(parts.uri.query().unwrap_or_default()).decode_utf8() {
            // No name or label has one, and PostgreSQL takes none.
            Ok(query) if query.contains('\0') => {
                return Err(ApiError::BadRequest("query: holds a NUL character".into()));
            }
            Ok(_) => {}
            Err(_) => return Err(ApiError::BadRequest("query: is not UTF-8".into())),
        }
        match axum::extract::Query::from_request_parts(parts, state).await {
            Ok(axum::extract::Query(query)) => Ok(Self(query)),
            Err(rejection) => Err(ApiError::BadRequest(format!("query: {}", of_query(&innermost(&rejection))))),
        }
    }
}

/// No query at all, where there are no parameters.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nothing {}

/// What is wrong with a query, in words of queries.
fn of_query(fault: &str) -> String {
    const WORDS: [(&str, &str); 6] = [
        ("invalid digit found in string", "must be a whole number"),
        ("invalid float literal", "must be a number"),
        ("there are no fields", "there are none here"),
        ("unknown field", "unknown parameter"),
        ("unknown variant", "unknown value"),
        ("missing field", "missing parameter"),
    ];
    WORDS.iter().fold(fault.to_owned(), |fault, (of_serde, of_ours)| fault.replace(of_serde, of_ours))
}

fn innermost(error: &dyn std::error::Error) -> String {
    let mut error = error;
    while let Some(source) = error.source() {
        error = source;
    }
    error.to_string()
}

/// The job that the path names; what is no UUID names none.
pub struct JobId(pub Uuid);

impl<S: Send + Sync> FromRequestParts<S> for JobId {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let id = segment(parts, state, "id").await.ok_or(ApiError::UnknownJob)?;
        // The one form in which ids are given out; others would be a second address of the same job.
        let parsed: Uuid = id.parse().map_err(|_| ApiError::UnknownJob)?;
        if parsed.to_string() == id { Ok(Self(parsed)) } else { Err(ApiError::UnknownJob) }
    }
}

/// The file that the path names.
pub struct PlotFile(pub String);

impl<S: Send + Sync> FromRequestParts<S> for PlotFile {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        segment(parts, state, "file").await.map(Self).ok_or(ApiError::UnknownPath)
    }
}

/// A named segment of the path; `None` also where it is no UTF-8.
async fn segment<S: Send + Sync>(parts: &mut Parts, state: &S, name: &str) -> Option<String> {
    let Path(segments) = Path::<Vec<(String, String)>>::from_request_parts(parts, state).await.ok()?;
    segments.into_iter().find(|segment| segment.0 == name).map(|segment| segment.1)
}

/// The format that the client likes best among those offered, the first in doubt.
pub fn negotiated(headers: &HeaderMap, offered: &'static [&'static str]) -> Result<&'static str, ApiError> {
    let accepted: Vec<&str> = headers.get_all(ACCEPT).iter().filter_map(|value| value.to_str().ok()).collect();
    let accepted = accepted.join(",");
    // A header that names nothing asks for nothing.
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

/// How much an Accept header likes a format, 0–1; the most specific range counts.
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
    fn the_format_that_is_liked_best_is_chosen() {
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
