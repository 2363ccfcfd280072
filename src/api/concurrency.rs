//! Limits of simultaneous requests, streams and bodies. A request beyond a limit is refused at once with `Retry-After`: if it waited, it
//! would be answered too late, and would occupy resources meanwhile.

use std::collections::HashMap;
use std::convert::Infallible;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::{FromRequestParts, Request, State};
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::Response;
use hyper::body::{Frame, SizeHint};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::credentials::Owner;
use super::error::ApiError;
use super::public_paths::is_public;
use crate::jobs::JobError;

/// Largest number of requests in work. Requests whose body is still arriving, or that wait for a job, are not counted.
const MAX_REQUESTS: usize = 512;

/// Largest number of event streams and of requests that wait for a job. Each occupies a connection, so it is less than their number.
const MAX_FOLLOWERS: usize = 256;

/// Longest time that a request is in work. It is exceeded by a long computation, and otherwise only if the database does not answer.
const WORK_TIMEOUT: Duration = Duration::from_secs(60);

/// Largest number of time series being sent: some have a hundred megabytes, and a slow client reads slowly.
const MAX_SERIES: usize = 8;

/// Comparisons with a record that are computed at once. Each takes a core for seconds and a hundred megabytes; later ones wait.
const MAX_COMPARISONS: usize = 2;

/// Largest total size of request bodies in memory [B].
const MAX_BODY_BYTES: usize = 64 << 20;

/// Size that one permit for a body stands for [B].
const BODY_UNIT: usize = 1024;

/// The free permits of each limit.
#[derive(Debug, Clone)]
pub struct Concurrency {
    requests: Arc<Semaphore>,
    followers: Arc<Semaphore>,
    followers_of_owners: Arc<Mutex<HashMap<Owner, usize>>>,
    /// Largest number of followers of one owner.
    followers_per_owner: usize,
    series: Arc<Semaphore>,
    comparisons: Arc<Semaphore>,
    bodies: Arc<Semaphore>,
}

impl Default for Concurrency {
    fn default() -> Self {
        let permits = |count| Arc::new(Semaphore::new(count));
        Self {
            requests: permits(MAX_REQUESTS),
            followers: permits(MAX_FOLLOWERS),
            followers_of_owners: Arc::default(),
            followers_per_owner: MAX_FOLLOWERS / 2,
            series: permits(MAX_SERIES),
            comparisons: permits(MAX_COMPARISONS),
            bodies: permits(MAX_BODY_BYTES / BODY_UNIT),
        }
    }
}

impl Concurrency {
    /// Limits with another number of followers of one owner; `None`: half of them.
    pub fn new(followers_per_owner: Option<usize>) -> Self {
        let limits = Self::default();
        let followers_per_owner = followers_per_owner.unwrap_or(limits.followers_per_owner);
        Self { followers_per_owner, ..limits }
    }

    /// A permit for an event stream or a request that waits for a job. `owner`: of a token, whose share is limited.
    pub fn follow(&self, owner: Option<&Owner>) -> Option<FollowerPermit> {
        let permit = Arc::clone(&self.followers).try_acquire_owned().ok()?;
        if let Some(owner) = owner {
            let mut of_owners = locked(&self.followers_of_owners);
            let of_owner = of_owners.entry(owner.clone()).or_default();
            if *of_owner >= self.followers_per_owner {
                return None;
            }
            *of_owner += 1;
        }
        let share = owner.map(|owner| (Arc::clone(&self.followers_of_owners), owner.clone()));
        Some(FollowerPermit { _permit: permit, share })
    }

    /// A permit for a time series, held until the series is sent.
    pub fn series(&self) -> Result<OwnedSemaphorePermit, ApiError> {
        Arc::clone(&self.series).try_acquire_owned().map_err(|_| ApiError::Overloaded)
    }

    /// A permit for `bytes` of a body, held as long as the body.
    pub fn body_bytes(&self, bytes: usize) -> Result<OwnedSemaphorePermit, ApiError> {
        let units = u32::try_from(bytes.div_ceil(BODY_UNIT)).unwrap_or(u32::MAX);
        Arc::clone(&self.bodies).try_acquire_many_owned(units).map_err(|_| ApiError::Overloaded)
    }
}

/// Number of event streams and of waiting requests, by owner.
type OfOwners = Mutex<HashMap<Owner, usize>>;

/// The permit of an event stream or of a request that waits for a job.
#[derive(Debug)]
pub struct FollowerPermit {
    _permit: OwnedSemaphorePermit,
    /// The numbers by owner, and the owner in them.
    share: Option<(Arc<OfOwners>, Owner)>,
}

impl Drop for FollowerPermit {
    fn drop(&mut self) {
        let Some((of_owners, owner)) = &self.share else { return };
        let mut of_owners = locked(of_owners);
        if let Some(count) = of_owners.get_mut(owner) {
            *count -= 1;
            if *count == 0 {
                of_owners.remove(owner);
            }
        }
    }
}

/// Ignores poisoning: what is locked is consistent after every statement.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A response that holds a permit until it is sent.
pub fn hold_until_sent(permit: OwnedSemaphorePermit, response: Response) -> Response {
    response.map(|body| Body::new(PermitBody { body, _permit: permit }))
}

struct PermitBody {
    body: Body,
    _permit: OwnedSemaphorePermit,
}

impl HttpBody for PermitBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// The permit of a request in work. It is released while the request waits for its client or for a job.
#[derive(Debug, Clone)]
pub struct RequestPermit {
    concurrency: Concurrency,
    held: Arc<Mutex<Option<HeldPermit>>>,
    is_computing: Arc<AtomicBool>,
}

/// A computation that a request waits for.
#[derive(Debug)]
pub struct ComputingGuard(Arc<AtomicBool>);

impl Drop for ComputingGuard {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

#[derive(Debug)]
struct HeldPermit {
    since: Instant,
    _permit: OwnedSemaphorePermit,
}

impl RequestPermit {
    fn new(concurrency: Concurrency) -> Self {
        Self { concurrency, held: Arc::default(), is_computing: Arc::default() }
    }

    /// Says whether the request waits for a computation, as long as the guard lives.
    pub fn computing(&self) -> ComputingGuard {
        self.is_computing.store(true, Ordering::Relaxed);
        ComputingGuard(Arc::clone(&self.is_computing))
    }

    /// Takes the permit; an error if none is free.
    pub fn acquire(&self) -> Result<(), ApiError> {
        let permit = Arc::clone(&self.concurrency.requests).try_acquire_owned().map_err(|_| ApiError::Overloaded)?;
        self.set(Some(HeldPermit { since: Instant::now(), _permit: permit }));
        Ok(())
    }

    /// Returns the permit.
    pub fn release(&self) {
        self.set(None);
    }

    /// A place for a comparison with a record; waits for one.
    pub async fn comparison_place(&self) -> Result<OwnedSemaphorePermit, ApiError> {
        // The wait is for the computations of others.
        let _computing = self.computing();
        let place = Arc::clone(&self.concurrency.comparisons).acquire_owned().await;
        place.map_err(|_| ApiError::Internal)
    }

    fn set(&self, permit: Option<HeldPermit>) {
        *self.held() = permit;
    }

    fn held(&self) -> MutexGuard<'_, Option<HeldPermit>> {
        locked(&self.held)
    }

    /// Ends when the permit has been held for too long, with the cause.
    async fn expired(&self) -> ApiError {
        loop {
            let held_for = self.held().as_ref().map_or(Duration::ZERO, |held| held.since.elapsed());
            match WORK_TIMEOUT.checked_sub(held_for) {
                None | Some(Duration::ZERO) if self.is_computing.load(Ordering::Relaxed) => {
                    return ApiError::TooLong { limit_s: WORK_TIMEOUT.as_secs() };
                }
                None | Some(Duration::ZERO) => return JobError::NotWritable.into(),
                Some(left) => tokio::time::sleep(left).await,
            }
        }
    }

    pub fn concurrency(&self) -> &Concurrency {
        &self.concurrency
    }
}

impl<S: Sync> FromRequestParts<S> for RequestPermit {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Self>().cloned().unwrap_or_else(|| Self::new(Concurrency::default())))
    }
}

/// Layer that gives each request a permit or refuses it.
pub async fn limit(
    State(concurrency): State<Concurrency>,
    mut request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let permit = RequestPermit::new(concurrency);
    if !is_unlimited(request.uri().path()) {
        permit.acquire()?;
    }
    request.extensions_mut().insert(permit.clone());
    let answered = tokio::select! {
        response = next.run(request) => Ok(response),
        cause = permit.expired() => Err(cause),
    };
    // Handlers may still hold copies of the permit.
    permit.release();
    answered
}

/// Returns whether a path is exempt: the metrics for operators, and public paths, which cost very little.
fn is_unlimited(path: &str) -> bool {
    path == "/metrics" || is_public(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A request that has been in work for too long names what it waits for.
    #[tokio::test]
    async fn late_requests_name_their_cause() {
        let permit = RequestPermit::new(Concurrency::default());
        permit.acquire().unwrap();
        if let Some(held) = permit.held().as_mut() {
            held.since -= WORK_TIMEOUT;
        }
        let computing = permit.computing();
        assert!(matches!(permit.expired().await, ApiError::TooLong { limit_s: 60 }));
        drop(computing);
        assert!(matches!(permit.expired().await, ApiError::Job(JobError::NotWritable)));
    }

    /// A third comparison waits for one of two.
    #[tokio::test]
    async fn comparisons_wait_for_a_place() {
        let permit = RequestPermit::new(Concurrency::default());
        let (one, _other) = (permit.comparison_place().await.unwrap(), permit.comparison_place().await.unwrap());
        let mut third = Box::pin(permit.comparison_place());
        let waited = tokio::time::timeout(Duration::from_millis(20), &mut third).await;
        assert!(waited.is_err() && permit.is_computing.load(Ordering::Relaxed));
        drop(one);
        assert!(third.await.is_ok() && !permit.is_computing.load(Ordering::Relaxed));
    }

    #[test]
    fn requests_beyond_the_limits_are_refused_and_released_permits_can_be_reused() {
        let concurrency = Concurrency::default();
        let permits: Vec<RequestPermit> = (0..MAX_REQUESTS).map(|_| RequestPermit::new(concurrency.clone())).collect();
        assert!(permits.iter().all(|permit| permit.acquire().is_ok()));
        let late = RequestPermit::new(concurrency.clone());
        assert!(matches!(late.acquire(), Err(ApiError::Overloaded)));
        permits[0].release();
        assert!(late.acquire().is_ok());

        let follow = |owner: Option<&Owner>| -> Vec<FollowerPermit> {
            std::iter::from_fn(|| concurrency.follow(owner)).collect()
        };
        let owner = Owner("one".into());
        let of_owner = follow(Some(&owner));
        assert_eq!(of_owner.len(), MAX_FOLLOWERS / 2);
        let others = follow(None);
        assert_eq!(others.len(), MAX_FOLLOWERS / 2);
        drop(of_owner);
        assert_eq!(follow(Some(&owner)).len(), MAX_FOLLOWERS / 2);

        let body = concurrency.body_bytes(MAX_BODY_BYTES - 1).ok();
        assert!(body.is_some() && matches!(concurrency.body_bytes(1), Err(ApiError::Overloaded)));
        drop(body);
        assert!(concurrency.body_bytes(1).is_ok());
    }
}
