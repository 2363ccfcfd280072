//! How much is done at a time. What comes beyond is refused at once, with a time to come back: whoever waited would be answered too
//! late, and would hold what others need meanwhile.

use std::convert::Infallible;
use std::pin::Pin;
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

use super::error::ApiError;
use super::{App, auth};
use crate::jobs::JobError;

/// Requests that are worked on at a time; those whose body is still on its way, or that wait for a job, are not.
pub const REQUESTS: usize = 512;

/// Event streams and requests that wait for a job, at a time: each keeps a connection, so that fewer are allowed than there are.
pub const FOLLOWERS: usize = 256;

/// Time that a request may be worked on: longer than any takes whose database answers at all.
pub const WORKING_TIME: Duration = Duration::from_secs(60);

/// Time series that are on their way at a time: some have a hundred megabytes, and are sent as slowly as a client reads.
pub const SERIES: usize = 8;

/// Bytes of bodies that are held at a time, in units of `BODY_UNIT`.
pub const BODIES: usize = 64 << 20;

/// What a permit for a body stands for.
const BODY_UNIT: usize = 1024;

/// The limits and what is left of them.
#[derive(Debug, Clone)]
pub struct Load {
    requests: Arc<Semaphore>,
    followers: Arc<Semaphore>,
    series: Arc<Semaphore>,
    bodies: Arc<Semaphore>,
}

impl Default for Load {
    fn default() -> Self {
        let places = |count| Arc::new(Semaphore::new(count));
        Self {
            requests: places(REQUESTS),
            followers: places(FOLLOWERS),
            series: places(SERIES),
            bodies: places(BODIES / BODY_UNIT),
        }
    }
}

impl Load {
    /// A place for one that follows a job, for as long as it is held.
    pub fn follow(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.followers).try_acquire_owned().ok()
    }

    /// A place for a time series, to be held until it is sent.
    pub fn series(&self) -> Result<OwnedSemaphorePermit, ApiError> {
        Arc::clone(&self.series).try_acquire_owned().map_err(|_| ApiError::Overloaded)
    }

    /// Room for so many bytes of a body, for as long as it is held.
    pub fn room(&self, bytes: usize) -> Result<OwnedSemaphorePermit, ApiError> {
        let units = u32::try_from(bytes.div_ceil(BODY_UNIT)).unwrap_or(u32::MAX);
        Arc::clone(&self.bodies).try_acquire_many_owned(units).map_err(|_| ApiError::Overloaded)
    }
}

/// An answer that keeps a place until it is sent.
pub fn holding(place: OwnedSemaphorePermit, response: Response) -> Response {
    response.map(|body| Body::new(Holding { body, _place: place }))
}

struct Holding {
    body: Body,
    _place: OwnedSemaphorePermit,
}

impl HttpBody for Holding {
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

/// A request's place among those that are worked on. It is left while the client, or a job, is waited for.
#[derive(Debug, Clone)]
pub struct Place {
    load: Load,
    held: Arc<Mutex<Option<Held>>>,
}

#[derive(Debug)]
struct Held {
    since: Instant,
    _place: OwnedSemaphorePermit,
}

impl Place {
    fn new(load: Load) -> Self {
        Self { load, held: Arc::default() }
    }

    pub fn enter(&self) -> Result<(), ApiError> {
        let place = Arc::clone(&self.load.requests).try_acquire_owned().map_err(|_| ApiError::Overloaded)?;
        self.hold(Some(Held { since: Instant::now(), _place: place }));
        Ok(())
    }

    pub fn leave(&self) {
        self.hold(None);
    }

    fn hold(&self, place: Option<Held>) {
        *self.held() = place;
    }

    fn held(&self) -> MutexGuard<'_, Option<Held>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends once the place has been held for too long.
    async fn overdue(&self) {
        loop {
            let held_for = self.held().as_ref().map_or(Duration::ZERO, |held| held.since.elapsed());
            match WORKING_TIME.checked_sub(held_for) {
                None | Some(Duration::ZERO) => return,
                Some(left) => tokio::time::sleep(left).await,
            }
        }
    }

    pub fn load(&self) -> &Load {
        &self.load
    }
}

impl<S: Sync> FromRequestParts<S> for Place {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Self>().cloned().unwrap_or_else(|| Self::new(Load::default())))
    }
}

/// Gives each request a place, or refuses it.
pub async fn limit(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, ApiError> {
    let place = Place::new(app.load);
    if !is_always_answered(request.uri().path()) {
        place.enter()?;
    }
    request.extensions_mut().insert(place.clone());
    let answered = tokio::select! {
        response = next.run(request) => Ok(response),
        () = place.overdue() => Err(JobError::NotWritable.into()),
    };
    // Held until here, whatever became of the request's own copies.
    place.leave();
    answered
}

/// What costs next to nothing, and what those who look after the service ask for.
fn is_always_answered(path: &str) -> bool {
    path == "/metrics" || auth::is_open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_beyond_the_limits_is_refused_and_what_is_left_can_be_had_again() {
        let load = Load::default();
        let places: Vec<Place> = (0..REQUESTS).map(|_| Place::new(load.clone())).collect();
        assert!(places.iter().all(|place| place.enter().is_ok()));
        let late = Place::new(load.clone());
        assert!(matches!(late.enter(), Err(ApiError::Overloaded)));
        places[0].leave();
        assert!(late.enter().is_ok());

        let followers: Vec<_> = std::iter::repeat_with(|| load.follow()).take_while(Option::is_some).collect();
        assert_eq!(followers.len(), FOLLOWERS);

        let body = load.room(BODIES - 1).ok();
        assert!(body.is_some() && matches!(load.room(1), Err(ApiError::Overloaded)));
        drop(body);
        assert!(load.room(1).is_ok());
    }
}
