//! Where previews run: not among the jobs, and only when nobody else wants the processor.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::error::ApiError;
use crate::jobs::SolverThreads;

/// Previews that run at once. More would share the processor time that jobs leave, so that each would be late.
const PLACES: usize = 1;

/// Longest wait for a place.
const LONGEST_WAIT: Duration = Duration::from_secs(10);

/// Threads and places of previews.
#[derive(Debug, Clone)]
pub struct Previews {
    pub threads: SolverThreads,
    places: Arc<Semaphore>,
}

impl Default for Previews {
    fn default() -> Self {
        Self { threads: SolverThreads::yielding(), places: Arc::new(Semaphore::new(PLACES)) }
    }
}

impl Previews {
    /// A place, in the order of arrival. A client that leaves gives its turn up.
    pub async fn place(&self) -> Result<OwnedSemaphorePermit, ApiError> {
        let place = tokio::time::timeout(LONGEST_WAIT, Arc::clone(&self.places).acquire_owned()).await;
        place.map_err(|_| ApiError::Overloaded)?.map_err(|_| ApiError::Internal)
    }
}
