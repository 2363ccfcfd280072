//! Work that takes processor time, on threads that serve no HTTP.

use tokio_util::sync::CancellationToken;

use super::concurrency::RequestPermit;
use super::error::ApiError;

/// Result of `work` on a thread that delays no other request. The work counts as a request in work until it ends, also after its client has
/// left. Its argument then returns true.
pub async fn computed<T: Send + 'static>(
    permit: &RequestPermit,
    work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
) -> Result<T, ApiError> {
    let (permit, unwanted) = (permit.clone(), CancellationToken::new());
    let (_cancels, _computing) = (unwanted.clone().drop_guard(), permit.computing());
    let done = tokio::task::spawn_blocking(move || {
        let _held = permit;
        work(&|| unwanted.is_cancelled())
    });
    done.await.map_err(|_| ApiError::Internal)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use axum::extract::{FromRequestParts, Request};

    use super::*;

    /// The work of a request that is dropped learns of it, and keeps its permit until then.
    #[tokio::test]
    async fn dropped_work_is_told_to_stop() {
        let (mut parts, ()) = Request::new(()).into_parts();
        let Ok(permit) = RequestPermit::from_request_parts(&mut parts, &()).await;
        permit.acquire().unwrap();
        let ((begun, begins), (ended, ends)) = (channel(), channel());
        let work = computed(&permit, move |stop| {
            begun.send(()).unwrap();
            while !stop() {
                std::thread::yield_now();
            }
            ended.send(()).unwrap();
        });
        let waited = tokio::time::timeout(Duration::from_millis(50), work).await;
        assert!(waited.is_err() && begins.recv().is_ok() && ends.recv().is_ok());
        assert_eq!(computed(&permit, |stop| stop()).await.ok(), Some(false));
    }
}
