//! Stored answers, read and formatted, with their media types.

use axum::http::header::{CONTENT_TYPE, VARY};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde::de::DeserializeOwned;
use uuid::Uuid;

use super::app::App;
use super::error::ApiError;
use crate::contract::{SpectrumAnswer, SpectrumKind};
use crate::jobs::{JobError, StoredSeries};

pub const JSON: &str = "application/json";
pub const CSV: &str = "text/csv";
pub const NPY: &str = "application/x-npy";
pub const SVG: &str = "image/svg+xml";

/// A stored spectrum; the error for an unknown channel lists the kept ones.
pub async fn spectrum_of(
    app: &App,
    owner: &str,
    id: Uuid,
    kind: SpectrumKind,
    channel: &str,
) -> Result<SpectrumAnswer, ApiError> {
    app.jobs.spectrum(owner, id, kind, channel).await.map_err(|error| channel_error(error, channel))
}

/// A stored series; the error for an unknown channel lists the kept ones.
pub async fn series_of(app: &App, owner: &str, id: Uuid, channel: &str) -> Result<StoredSeries, ApiError> {
    app.jobs.series(owner, id, channel).await.map_err(|error| channel_error(error, channel))
}

fn channel_error(error: JobError, channel: &str) -> ApiError {
    match error {
        JobError::UnknownChannel { kept } => ApiError::UnknownChannel { channel: channel.to_owned(), kept },
        other => other.into(),
    }
}

/// Formats an answer on a thread that serves no HTTP: it may contain a million numbers.
pub async fn formatted(
    format: impl FnOnce() -> Result<Response, ApiError> + Send + 'static,
) -> Result<Response, ApiError> {
    tokio::task::spawn_blocking(format).await.unwrap_or(Err(ApiError::Internal))
}

/// Parses a stored answer.
pub fn read<T: DeserializeOwned>(stored: &[u8]) -> Result<T, ApiError> {
    serde_json::from_slice(stored).map_err(|error| JobError::Corrupt(error.to_string()).into())
}

/// An answer as JSON text.
pub fn json_text(answer: &impl Serialize) -> Result<Vec<u8>, ApiError> {
    serde_json::to_vec(answer).map_err(|error| JobError::Corrupt(error.to_string()).into())
}

/// A response in a negotiated format.
pub fn respond(format: &'static str, body: impl IntoResponse) -> Response {
    // Spreadsheets take tables without a charset for another encoding.
    let content_type = if format == CSV { "text/csv; charset=utf-8" } else { format };
    ([(VARY, "Accept"), (CONTENT_TYPE, content_type)], body.into_response().into_body()).into_response()
}
