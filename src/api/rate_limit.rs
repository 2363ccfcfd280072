//! Rate limits of each owner: of requests, and of submissions by what they cost.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use axum::http::{HeaderMap, HeaderName, HeaderValue};

use super::credentials::Owner;
use super::error::ApiError;
use crate::jobs::Left;

/// Largest number per second of requests of each owner and of jobs and points that it submits, and of either at once after a pause.
///
/// A submission is accepted if anything is left, and its cost beyond that is a debt: no request is refused for its size. Only requests
/// with a token are counted, so the number of owners is small.
#[derive(Debug, Default)]
pub struct RateLimits {
    /// 0: no limit.
    per_second: u32,
    of_owners: Mutex<HashMap<Owner, OfOwner>>,
}

/// Rest of the rates of an owner.
#[derive(Debug)]
struct OfOwner {
    requests: f64,
    /// Negative in debt.
    submissions: f64,
    at: Instant,
}

/// A kind of limit in the headers of an answer.
#[derive(Debug, Clone, PartialEq)]
struct Limit {
    name: &'static str,
    quota: u64,
    left: u64,
    /// Time until something is left again [s].
    wait_s: u64,
    is_rate: bool,
}

/// Rests of the limits of unfinished work after a submission, by name. It travels in the extensions of a response.
#[derive(Debug, Clone, Default)]
pub struct LeftPlaces(pub Vec<(&'static str, Left)>);

/// Names of the limits of unfinished work.
pub const JOBS: &str = "jobs";
pub const POINTS: &str = "points";

pub const RATE_LIMIT: HeaderName = HeaderName::from_static("ratelimit");
pub const RATE_LIMIT_POLICY: HeaderName = HeaderName::from_static("ratelimit-policy");

impl OfOwner {
    fn refill(&mut self, per_second: f64, now: Instant) {
        let more = per_second * now.saturating_duration_since(self.at).as_secs_f64();
        self.requests = (self.requests + more).min(per_second);
        self.submissions = (self.submissions + more).min(per_second);
        self.at = now;
    }
}

impl RateLimits {
    /// A limit per second; 0: no limit.
    pub fn new(per_second: u32) -> Self {
        Self { per_second, of_owners: Mutex::default() }
    }

    fn with<T>(&self, owner: &Owner, now: Instant, change: impl FnOnce(f64, &mut OfOwner) -> T) -> Option<T> {
        if self.per_second == 0 {
            return None;
        }
        let rate = f64::from(self.per_second);
        let mut of_owners = self.of_owners.lock().unwrap_or_else(PoisonError::into_inner);
        let of_owner = of_owners.entry(owner.clone()).or_insert(OfOwner { requests: rate, submissions: rate, at: now });
        of_owner.refill(rate, now);
        Some(change(rate, of_owner))
    }

    /// Counts a request, and a submission as one; an error if nothing is left.
    pub fn take(&self, owner: &Owner, is_submission: bool) -> Result<(), ApiError> {
        self.take_at(owner, is_submission, Instant::now())
    }

    fn take_at(&self, owner: &Owner, is_submission: bool, now: Instant) -> Result<(), ApiError> {
        let limit = self.per_second;
        let taken = self.with(owner, now, |rate, left| {
            let too_often =
                |left, of_submissions| Err(ApiError::TooOften { limit, wait_s: wait_s(left, rate), of_submissions });
            if left.requests < 1.0 {
                return too_often(left.requests, false);
            }
            if is_submission && left.submissions < 1.0 {
                return too_often(left.submissions, true);
            }
            left.requests -= 1.0;
            left.submissions -= f64::from(u8::from(is_submission));
            Ok(())
        });
        taken.unwrap_or(Ok(()))
    }

    /// Charges a submission of `cost` jobs and points, of which one was counted with the request.
    pub fn charge(&self, owner: &Owner, cost: usize) {
        let rest = cost.saturating_sub(1) as f64;
        self.with(owner, Instant::now(), |_, left| left.submissions -= rest);
    }

    fn limits(&self, owner: &Owner) -> Vec<Limit> {
        let limits = self.with(owner, Instant::now(), |rate, of_owner| {
            [("requests", of_owner.requests), ("submissions", of_owner.submissions)].map(|(name, left)| Limit {
                name,
                quota: u64::from(self.per_second),
                left: left.max(0.0) as u64,
                wait_s: if left < 1.0 { wait_s(left, rate) } else { 0 },
                is_rate: true,
            })
        });
        limits.into_iter().flatten().collect()
    }

    /// Adds headers that tell an owner what is left. `owner`: of the token of the request, if tokens are needed.
    pub fn describe(&self, owner: Option<&Owner>, places: &LeftPlaces, headers: &mut HeaderMap) {
        let mut limits = owner.map(|owner| self.limits(owner)).unwrap_or_default();
        limits.extend(places.0.iter().map(|(name, left)| Limit {
            name,
            quota: left.limit,
            left: left.left,
            wait_s: 0,
            is_rate: false,
        }));
        let policy = limits
            .iter()
            .map(|limit| format!("\"{}\";q={}{}", limit.name, limit.quota, if limit.is_rate { ";w=1" } else { "" }));
        let left = limits.iter().map(|limit| match limit.wait_s {
            0 => format!("\"{}\";r={}", limit.name, limit.left),
            wait_s => format!("\"{}\";r={};t={wait_s}", limit.name, limit.left),
        });
        for (name, items) in [(RATE_LIMIT_POLICY, policy.collect::<Vec<_>>()), (RATE_LIMIT, left.collect())] {
            if let (false, Ok(value)) = (items.is_empty(), HeaderValue::from_str(&items.join(", "))) {
                headers.insert(name, value);
            }
        }
    }
}

/// Whole seconds until one is left, at least 1.
fn wait_s(left: f64, per_second: f64) -> u64 {
    (((1.0 - left) / per_second).ceil() as u64).max(1)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn owners() -> [Owner; 2] {
        ["one", "other"].map(|name| Owner(name.to_owned()))
    }

    #[test]
    fn each_owner_has_its_own_rate() {
        let (rates, [one, other], now) = (RateLimits::new(3), owners(), Instant::now());
        assert!((0..3).all(|_| rates.take_at(&one, false, now).is_ok()));
        let refused = rates.take_at(&one, false, now);
        assert!(matches!(refused, Err(ApiError::TooOften { limit: 3, wait_s: 1, of_submissions: false })));
        assert!(rates.take_at(&one, false, now + Duration::from_millis(334)).is_ok());
        assert!(rates.take_at(&other, false, now).is_ok());
        assert!((0..1000).all(|_| RateLimits::new(0).take(&one, true).is_ok()));
    }

    #[test]
    fn a_submission_larger_than_the_limit_is_a_debt_that_is_paid_by_time() {
        let (rates, [one, other], now) = (RateLimits::new(100), owners(), Instant::now());
        assert!(rates.take_at(&one, true, now).is_ok());
        rates.charge(&one, 1000);
        let refused = rates.take_at(&one, true, now + Duration::from_secs(1));
        assert!(matches!(refused, Err(ApiError::TooOften { of_submissions: true, wait_s: 9, .. })), "{refused:?}");
        assert!(rates.take_at(&one, false, now + Duration::from_secs(1)).is_ok());
        assert!(rates.take_at(&other, true, now).is_ok());
        assert!(rates.take_at(&one, true, now + Duration::from_secs(10)).is_ok());
    }

    #[test]
    fn headers_tell_what_is_left() {
        let (rates, [one, _]) = (RateLimits::new(2), owners());
        rates.take(&one, true).expect("one is left");
        rates.charge(&one, 5);
        let mut headers = HeaderMap::new();
        rates.describe(Some(&one), &LeftPlaces(vec![(JOBS, Left { limit: 50, left: 7 })]), &mut headers);
        assert_eq!(headers[RATE_LIMIT_POLICY], r#""requests";q=2;w=1, "submissions";q=2;w=1, "jobs";q=50"#);
        assert_eq!(headers[RATE_LIMIT], r#""requests";r=1, "submissions";r=0;t=2, "jobs";r=7"#);
        let mut none = HeaderMap::new();
        rates.describe(None, &LeftPlaces::default(), &mut none);
        assert!(none.is_empty());
    }
}
