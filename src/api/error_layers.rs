//! Layers for errors that do not come from a handler: refusals of the framework, and panics.

use std::any::Any;

use axum::extract::Request;
use axum::http::header::{CACHE_CONTROL, CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_TYPE, ETAG, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderName, HeaderValue, Method};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::error::{self, ApiError, PROBLEM_JSON};

/// Headers that describe the replaced body.
const BODY_HEADERS: [HeaderName; 5] = [CONTENT_TYPE, CONTENT_LENGTH, CONTENT_ENCODING, ETAG, CACHE_CONTROL];

/// Layer that replaces every other error answer by problem details. Headers such as `Allow` are kept.
pub async fn as_problems(request: Request, next: Next) -> Response {
    let is_head = request.method() == Method::HEAD;
    let mut response = next.run(request).await;
    let is_problem = response.headers().get(CONTENT_TYPE).is_some_and(|value| value == PROBLEM_JSON);
    if let (false, Some(error)) = (is_problem || is_head, error::of_status(response.status())) {
        let mut problem = error.into_response();
        for (name, value) in response.headers() {
            if !BODY_HEADERS.contains(name) {
                problem.headers_mut().insert(name, value.clone());
            }
        }
        response = problem;
    }
    response.headers_mut().insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    response
}

/// The answer after a panic of a handler. Other requests are not affected.
pub fn of_panic(panic: Box<dyn Any + Send + 'static>) -> Response {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    tracing::error!(panic = text, "a handler panicked");
    ApiError::Internal.into_response()
}
