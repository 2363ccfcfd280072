//! Rate limit of each owner.

use std::fmt;
use std::num::NonZeroU32;
use std::time::Duration;

use governor::clock::{Clock, DefaultClock};
use governor::state::keyed::HashMapStateStore;
use governor::{Quota, RateLimiter};

use super::credentials::Owner;
use super::error::ApiError;

/// Largest number of requests per second of each owner, and of requests at once after a pause. Only requests with a token are counted,
/// so the number of owners is small.
#[derive(Default)]
pub struct RateLimits {
    limiter: Option<(u32, ByOwner)>,
}

type ByOwner = RateLimiter<Owner, HashMapStateStore<Owner>, DefaultClock>;

impl fmt::Debug for RateLimits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.limiter {
            Some((rate, _)) => write!(f, "{rate} requests per second"),
            None => f.write_str("no limit"),
        }
    }
}

impl RateLimits {
    /// A limit of requests per second; 0: no limit.
    pub fn new(per_second: u32) -> Self {
        let quota = NonZeroU32::new(per_second).map(Quota::per_second);
        Self { limiter: quota.map(|quota| (per_second, RateLimiter::hashmap(quota))) }
    }

    /// Counts a request; an error beyond the limit.
    pub fn check(&self, owner: &Owner) -> Result<(), ApiError> {
        let Some((limit, limiter)) = &self.limiter else { return Ok(()) };
        limiter.check_key(owner).map_err(|early| {
            let wait: Duration = early.wait_time_from(limiter.clock().now());
            ApiError::TooOften { limit: *limit, wait_s: wait.as_secs() + 1 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_owner_has_its_own_rate() {
        let (rates, [one, other]) = (RateLimits::new(3), ["one", "other"].map(|name| Owner(name.to_owned())));
        assert!((0..3).all(|_| rates.check(&one).is_ok()));
        assert!(matches!(rates.check(&one), Err(ApiError::TooOften { limit: 3, wait_s: 1 })));
        assert!(rates.check(&other).is_ok());
        assert!((0..1000).all(|_| RateLimits::new(0).check(&one).is_ok()));
    }
}
