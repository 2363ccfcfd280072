//! Times as the tables hold them: whole microseconds since 1970.

use jiff::{SignedDuration, Timestamp};

use crate::jobs::error::JobError;

/// A duration [µs].
pub fn micros(span: SignedDuration) -> i64 {
    i64::try_from(span.as_micros()).unwrap_or(i64::MAX / 2)
}

/// A time [µs since 1970].
pub fn stored(time: Timestamp) -> i64 {
    time.as_microsecond()
}

/// The time behind a stored value.
pub fn time(microseconds: i64) -> Result<Timestamp, JobError> {
    Timestamp::from_microsecond(microseconds).map_err(|error| JobError::Corrupt(error.to_string()))
}

/// Time at which a job that ended at `ended` expires when it is kept for `keep_s` [s].
pub fn expiry(ended: Timestamp, keep_s: f64) -> Timestamp {
    SignedDuration::try_from_secs_f64(keep_s)
        .ok()
        .and_then(|kept| ended.checked_add(kept).ok())
        .unwrap_or(Timestamp::MAX)
}
