//! State shared by the handlers.

use std::sync::Arc;

use axum::http::HeaderValue;

use super::concurrency::Concurrency;
use super::credentials::Tokens;
use super::preview_threads::Previews;
use super::rate_limit::RateLimits;
use crate::jobs::Jobs;

/// State shared by the handlers.
#[derive(Clone)]
pub struct App {
    pub jobs: Jobs,
    pub access: Arc<Access>,
    pub concurrency: Concurrency,
    pub previews: Previews,
}

impl App {
    pub fn new(jobs: Jobs, access: Access) -> Self {
        let concurrency = Concurrency::new(access.followers_per_owner);
        Self { jobs, access: Arc::new(access), concurrency, previews: Previews::default() }
    }
}

/// Rules of access.
#[derive(Debug, Default)]
pub struct Access {
    /// Tokens from the environment, in addition to those of the database.
    pub tokens: Tokens,
    /// True if the service listens on loopback only. Without tokens the `Host` must then be an address or localhost.
    pub is_local: bool,
    pub rates: RateLimits,
    /// Largest number of event streams and waiting requests of one owner; `None`: half of all.
    pub followers_per_owner: Option<usize>,
    /// Origins of other web pages that may use the API.
    pub origins: Vec<HeaderValue>,
}
