//! Headers of a submission: `Prefer: wait=N` and `Idempotency-Key`.

use axum::http::{HeaderMap, HeaderName};
use utoipa::IntoParams;

use super::error::ApiError;
use super::request::header;

const PREFER: HeaderName = HeaderName::from_static("prefer");
const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");
pub const IDEMPOTENT_REPLAYED: HeaderName = HeaderName::from_static("idempotent-replayed");
pub const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");

/// Longest time that an answer waits for the end of a job [s].
const MAX_WAIT_S: u64 = 60;

/// Headers of a submission.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
#[allow(dead_code, reason = "only describes the headers; `preferred_wait` and `idempotency_key` read them")]
pub struct SubmissionHeaders {
    /// `wait=N`: answer once the job has ended, after N seconds at the latest (at most 60).
    #[param(rename = "Prefer", nullable = false, example = "wait=10")]
    prefer: Option<String>,
    /// A key of the client for this submission, 1 to 255 visible ASCII characters. A repeated request with the same body creates no
    /// second job: it returns the first answer with `Idempotent-Replayed: true`. With another body it is refused (422). The key is kept
    /// as long as the job, at least 24 h.
    #[param(
        rename = "Idempotency-Key",
        nullable = false,
        min_length = 1,
        max_length = 255,
        pattern = "^[!-~]+$",
        example = "4f2c7a1e-line-3"
    )]
    idempotency_key: Option<String>,
}

/// The wait of `Prefer: wait=N` [s]. Other preferences are ignored, as RFC 7240 allows.
pub fn preferred_wait(headers: &HeaderMap) -> Result<Option<u64>, ApiError> {
    let preferences = header(headers, &PREFER).unwrap_or_default().split([',', ';']).map(str::trim);
    let mut wait = preferences.filter_map(|preference| preference.split_once('='));
    let Some((_, seconds)) = wait.find(|(name, _)| name.trim().eq_ignore_ascii_case("wait")) else { return Ok(None) };
    let number = seconds.trim().trim_matches('"');
    match number.parse::<u64>() {
        // Digits that overflow count as the longest wait.
        Err(_) if !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit()) => Ok(Some(MAX_WAIT_S)),
        Ok(seconds) => Ok(Some(seconds.min(MAX_WAIT_S))),
        Err(_) => Err(wrong_wait(seconds.trim())),
    }
}

/// The error for a wrong `Prefer: wait`.
pub fn wrong_wait(given: &str) -> ApiError {
    let given: String = given.chars().take(20).collect();
    ApiError::BadRequest(format!(
        "Prefer: wait={given}: must be a whole number of seconds; more than {MAX_WAIT_S} count as {MAX_WAIT_S}"
    ))
}

/// The client's `Idempotency-Key`.
pub fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, ApiError> {
    let mut keys = headers.get_all(IDEMPOTENCY_KEY).iter();
    let Some(key) = keys.next() else { return Ok(None) };
    if keys.next().is_some() {
        return Err(ApiError::BadRequest("Idempotency-Key was sent twice".into()));
    }
    let is_visible = |key: &&[u8]| (1..=255).contains(&key.len()) && key.iter().all(u8::is_ascii_graphic);
    let key = Some(key.as_bytes()).filter(is_visible).and_then(|key| std::str::from_utf8(key).ok());
    let refused = || ApiError::BadRequest("Idempotency-Key must be 1 to 255 visible ASCII characters".into());
    Ok(Some(key.ok_or_else(refused)?.to_owned()))
}
