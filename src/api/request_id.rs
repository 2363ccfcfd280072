//! A name for every request: the client's own or a new one. It comes back with the answer, and stands in every line that the log has
//! of the request.

use std::time::Instant;

use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue, StatusCode};
use axum::middleware::Next;
use axum::response::Response;
use tracing::Instrument;
use uuid::Uuid;

pub const X_REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Characters of a name at most, and of a path in the log.
const LONGEST: usize = 128;

/// Names the request, and notes in the log how it was answered.
pub async fn named(request: Request, next: Next) -> Response {
    let id = id_of(&request);
    // Percent-encoded, so that no line is broken by it.
    let path: String = request.uri().path().chars().take(LONGEST).collect();
    // Of the highest level, or lines of that level would go without it.
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

/// What the client calls it, if that is short and visible; else a new name.
fn id_of(request: &Request) -> HeaderValue {
    let given = request
        .headers()
        .get(X_REQUEST_ID)
        .filter(|id| (1..=LONGEST).contains(&id.len()) && id.as_bytes().iter().all(u8::is_ascii_graphic));
    let new = || HeaderValue::try_from(Uuid::now_v7().to_string()).unwrap_or(HeaderValue::from_static("-"));
    given.cloned().unwrap_or_else(new)
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    #[test]
    fn a_clients_name_is_kept_if_it_is_short_and_visible() {
        let id = |given: &[u8]| {
            let request = Request::builder().header(X_REQUEST_ID, HeaderValue::from_bytes(given).expect("a header"));
            id_of(&request.body(Body::empty()).expect("a request"))
        };
        assert_eq!(id(b"portal-17/a"), "portal-17/a");
        for other in [&b""[..], b"a b", "für".as_bytes(), &[b'x'; LONGEST + 1]] {
            assert!(Uuid::try_parse(id(other).to_str().expect("visible")).is_ok(), "{other:?}");
        }
    }
}
