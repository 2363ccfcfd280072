//! An id for every request: the client's own or a new one. It is in the answer and in every log line of the request.

use std::time::Instant;

use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue, StatusCode};
use axum::middleware::Next;
use axum::response::Response;
use tracing::Instrument;
use uuid::Uuid;

pub const X_REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Longest id, and longest path in the log [characters].
const MAX_LENGTH: usize = 128;

/// Layer that adds the id, and logs the status of the answer.
pub async fn layer(request: Request, next: Next) -> Response {
    let id = id_of(&request);
    // The path is percent-encoded, so it contains no line break.
    let path: String = request.uri().path().chars().take(MAX_LENGTH).collect();
    // The level of a span must not be lower than that of its log lines, or they lack the span.
    let span = tracing::error_span!("request", id = id.to_str().unwrap_or_default(), method = %request.method(), path);
    let begin = Instant::now();
    let mut response = next.run(request).instrument(span.clone()).await;
    span.in_scope(|| {
        let (status, ms) = (response.status().as_u16(), 1e3 * begin.elapsed().as_secs_f64());
        match response.status() {
            StatusCode::INTERNAL_SERVER_ERROR => tracing::error!(status, ms, "answered"),
            _ => tracing::debug!(status, ms, "answered"),
        }
    });
    response.headers_mut().insert(X_REQUEST_ID, id);
    response
}

/// The client's id if it is short and visible, else a new id.
fn id_of(request: &Request) -> HeaderValue {
    let sent = request
        .headers()
        .get(X_REQUEST_ID)
        .filter(|id| (1..=MAX_LENGTH).contains(&id.len()) && id.as_bytes().iter().all(u8::is_ascii_graphic));
    let new = || HeaderValue::try_from(Uuid::now_v7().to_string()).unwrap_or(HeaderValue::from_static("-"));
    sent.cloned().unwrap_or_else(new)
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    #[test]
    fn the_id_of_a_client_is_kept_if_it_is_short_and_visible() {
        let id = |given: &[u8]| {
            let request = Request::builder().header(X_REQUEST_ID, HeaderValue::from_bytes(given).expect("a header"));
            id_of(&request.body(Body::empty()).expect("a request"))
        };
        assert_eq!(id(b"portal-17/a"), "portal-17/a");
        for other in [&b""[..], b"a b", "für".as_bytes(), &[b'x'; MAX_LENGTH + 1]] {
            assert!(Uuid::try_parse(id(other).to_str().expect("visible")).is_ok(), "{other:?}");
        }
    }
}
