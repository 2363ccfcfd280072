//! Conditional requests: ETags and answers 304. Results never change, so their tag is a digest of the work and the request; that of a
//! study, which can be resumed, also covers when it ended. The tag of a job is a digest of its JSON text.

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::header::{ACCEPT, ACCEPT_ENCODING, CACHE_CONTROL, ETAG, IF_NONE_MATCH, IF_RANGE, RANGE, VARY};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use sha2::{Digest, Sha256};
use uuid::Uuid;

use super::app::App;
use super::credentials::Owner;
use super::error::ApiError;
use crate::jobs::Fingerprint;

/// Caching of results by the client, not by proxies.
const IMMUTABLE: HeaderValue = HeaderValue::from_static("private, max-age=31536000, immutable");
/// Caching with a conditional request each time.
const REVALIDATE: HeaderValue = HeaderValue::from_static("private, no-cache");
/// Length of the digest in a tag [B].
const TAG_BYTES: usize = 16;

/// Layer that adds an ETag to results of succeeded jobs, or answers 304 if the client has them.
pub async fn results(
    State(app): State<App>,
    Owner(owner): Owner,
    mut request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let id = request.uri().path().split('/').nth(3).and_then(|id| id.parse::<Uuid>().ok());
    let work = match id {
        Some(id) => app.jobs.fingerprint(&owner, id).await?,
        None => None,
    };
    let Some(Fingerprint { work, study_ended }) = work else {
        let mut response = next.run(request).await;
        response.headers_mut().entry(CACHE_CONTROL).or_insert(REVALIDATE);
        return Ok(response);
    };
    let asked = request.uri().path_and_query().map_or("", |path| path.as_str());
    // The body depends on the format and the content coding.
    let headers = request.headers();
    let accepted = [ACCEPT, ACCEPT_ENCODING].map(|name| headers.get_all(name).iter().cloned().collect::<Vec<_>>());
    let accepted: Vec<&[u8]> = accepted.iter().flatten().map(HeaderValue::as_bytes).collect();
    let version = env!("CARGO_PKG_VERSION").as_bytes();
    let ended = study_ended.unwrap_or(0).to_le_bytes();
    let tag = tag("", &[&work, version, asked.as_bytes(), &accepted.join(&b","[..]), &ended]);
    let caching = if study_ended.is_some() { REVALIDATE } else { IMMUTABLE };
    // A matching tag came with an answer to the same request.
    if has(request.headers(), &tag) {
        return Ok(not_modified(tag, caching));
    }
    let has_any = has_any(request.headers());
    if request.headers().get(IF_RANGE).is_some_and(|known| *known != tag) {
        request.headers_mut().remove(RANGE);
    }
    let mut response = next.run(request).await;
    if response.status() == StatusCode::OK && has_any {
        return Ok(not_modified(tag, caching));
    }
    if [StatusCode::OK, StatusCode::PARTIAL_CONTENT].contains(&response.status()) {
        let headers = response.headers_mut();
        headers.insert(ETAG, tag);
        headers.insert(CACHE_CONTROL, caching);
        headers.insert(VARY, HeaderValue::from_static("Accept"));
    }
    Ok(response)
}

/// The JSON text of a job with a weak ETag, or 304 if the client has it.
pub fn job(headers: &HeaderMap, json: Vec<u8>) -> Response {
    let tag = tag("W/", &[&json]);
    if has(headers, &tag) || has_any(headers) {
        return not_modified(tag, REVALIDATE);
    }
    let fields = [
        (ETAG, tag),
        (CACHE_CONTROL, REVALIDATE),
        (axum::http::header::CONTENT_TYPE, HeaderValue::from_static("application/json")),
    ];
    (fields, Body::from(json)).into_response()
}

fn not_modified(tag: HeaderValue, caching: HeaderValue) -> Response {
    let vary = HeaderValue::from_static("Accept, Accept-Encoding");
    (StatusCode::NOT_MODIFIED, [(ETAG, tag), (CACHE_CONTROL, caching), (VARY, vary)]).into_response()
}

fn tag(prefix: &str, parts: &[&[u8]]) -> HeaderValue {
    let mut digest = Sha256::new();
    for part in parts {
        digest.update(part.len().to_le_bytes());
        digest.update(part);
    }
    let hex: String = digest.finalize().iter().take(TAG_BYTES).map(|byte| format!("{byte:02x}")).collect();
    HeaderValue::try_from(format!("{prefix}\"{hex}\"")).unwrap_or(HeaderValue::from_static("\"\""))
}

/// Returns whether `If-None-Match` is `*`.
fn has_any(headers: &HeaderMap) -> bool {
    headers.get(IF_NONE_MATCH).is_some_and(|value| value.as_bytes().trim_ascii() == b"*")
}

/// Returns whether `If-None-Match` contains the tag. The comparison is weak (RFC 9110, 13.1.2).
fn has(headers: &HeaderMap, tag: &HeaderValue) -> bool {
    let strip = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    let Ok(tag) = tag.to_str().map(strip) else { return false };
    let named = headers.get_all(IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    named.flat_map(|value| value.split(',')).any(|named| strip(named) == tag)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_is_found_among_others_weak_or_strong() {
        let tag = tag("W/", &[b"job"]);
        let text = tag.to_str().unwrap_or_default().to_owned();
        for (sent, found) in [
            (text.clone(), true),
            (text.trim_start_matches("W/").to_owned(), true),
            (format!("\"a\", {text}"), true),
            ("\"a\"".to_owned(), false),
            (String::new(), false),
        ] {
            let headers = HeaderMap::from_iter([(IF_NONE_MATCH, HeaderValue::try_from(sent.clone()).unwrap())]);
            assert_eq!(has(&headers, &tag), found, "{sent}");
        }
    }
}
