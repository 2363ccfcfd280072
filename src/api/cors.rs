//! Cross-origin requests (CORS): only web pages of listed origins may use the API.

use std::time::Duration;

use axum::http::header::{
    ACCEPT_RANGES, AUTHORIZATION, CONTENT_RANGE, CONTENT_TYPE, ETAG, HeaderName, HeaderValue, IF_NONE_MATCH, IF_RANGE,
    LINK, LOCATION, RANGE, RETRY_AFTER,
};
use axum::http::{Method, Uri};
use tower_http::cors::CorsLayer;

use super::rate_limit::{RATE_LIMIT, RATE_LIMIT_POLICY};
use super::request_id::X_REQUEST_ID;

/// Time for which a browser may cache the answer to a preflight request.
const PREFLIGHT_MAX_AGE: Duration = Duration::from_secs(3600);

/// An origin as browsers send it: scheme, host, and the port unless it is the default.
pub fn origin(text: &str) -> Result<HeaderValue, String> {
    let refused =
        || format!("`{text}` is not an origin; write it like https://portal.example or http://localhost:5173");
    let uri: Uri = text.parse().map_err(|_| refused())?;
    match (uri.scheme_str(), uri.authority()) {
        (Some(scheme @ ("http" | "https")), Some(authority)) if text == format!("{scheme}://{authority}") => {
            HeaderValue::from_str(text).map_err(|_| refused())
        }
        _ => Err(refused()),
    }
}

/// Layer that answers preflight requests and allows pages of these origins to read answers.
pub fn layer(origins: &[HeaderValue]) -> CorsLayer {
    let name = HeaderName::from_static;
    CorsLayer::new()
        .allow_origin(origins.to_vec())
        .allow_methods([Method::GET, Method::POST, Method::DELETE])
        .allow_headers([
            AUTHORIZATION,
            CONTENT_TYPE,
            IF_NONE_MATCH,
            IF_RANGE,
            RANGE,
            X_REQUEST_ID,
            name("idempotency-key"),
            name("last-event-id"),
            name("prefer"),
        ])
        .expose_headers([
            ACCEPT_RANGES,
            CONTENT_RANGE,
            ETAG,
            LINK,
            LOCATION,
            RETRY_AFTER,
            X_REQUEST_ID,
            name("idempotent-replayed"),
            name("preference-applied"),
            RATE_LIMIT,
            RATE_LIMIT_POLICY,
        ])
        .max_age(PREFLIGHT_MAX_AGE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_scheme_and_host() {
        for right in ["https://portal.example", "http://localhost:5173", "http://[::1]:80"] {
            assert!(origin(right).is_ok_and(|origin| origin == right), "{right}");
        }
        for wrong in ["", "*", "portal.example", "https://portal.example/", "https://a.example/b", "ftp://a.example"] {
            assert!(origin(wrong).is_err(), "{wrong}");
        }
    }
}
