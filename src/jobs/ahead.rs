//! Runs that begin as soon as their job is in the record, while the queue still delivers it: whoever waits for a short job waits for
//! some ways to the database less. A run that is ahead owns nothing: what it finds is written by the delivery that claims the job,
//! and thrown away where none comes to this process soon.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, oneshot};
use uuid::Uuid;

use super::running::{Run, StopReason};
use super::store::StoredResult;
use crate::contract::RunFailure;

/// Time in which the delivery has to come. A slot that others may wait for is held no longer in vain.
pub const DELIVERED_WITHIN: Duration = Duration::from_millis(100);

/// Where the solver's thread leaves what it has found.
pub type Solution = oneshot::Receiver<Result<StoredResult, RunFailure>>;

/// A slot and the run in it. The run stops when this is dropped, unless someone has taken what it finds.
#[derive(Debug)]
pub struct Begun {
    pub _slot: OwnedSemaphorePermit,
    pub run: Arc<Run>,
    /// `None`: it has not begun.
    pub solution: Option<Solution>,
}

impl Drop for Begun {
    fn drop(&mut self) {
        if self.solution.is_some() {
            self.run.stop(StopReason::ClaimLost);
        }
    }
}

/// The runs of this process that are ahead of their deliveries, by job.
#[derive(Debug, Default)]
pub struct Ahead {
    begun: Mutex<HashMap<Uuid, Begun>>,
}

impl Ahead {
    pub fn enter(&self, job: Uuid, begun: Begun) {
        self.locked().insert(job, begun);
    }

    pub fn take(&self, job: Uuid) -> Option<Begun> {
        self.locked().remove(&job)
    }

    /// Ends them all.
    pub fn stop(&self) {
        self.locked().clear();
    }

    /// Whole after every statement, so that a panic elsewhere spoils nothing.
    fn locked(&self) -> MutexGuard<'_, HashMap<Uuid, Begun>> {
        self.begun.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use tokio::sync::Semaphore;

    use super::*;

    fn begun(slots: &Arc<Semaphore>, run: &Arc<Run>) -> Begun {
        let slot = Arc::clone(slots).try_acquire_owned().expect("a slot is free");
        Begun { _slot: slot, run: Arc::clone(run), solution: Some(oneshot::channel().1) }
    }

    #[test]
    fn what_nobody_takes_stops_and_gives_its_slot_back() {
        let (ahead, slots, run) = (Ahead::default(), Arc::new(Semaphore::new(1)), Arc::new(Run::default()));
        let job = Uuid::now_v7();
        ahead.enter(job, begun(&slots, &run));
        drop(ahead.take(Uuid::now_v7()));
        assert_eq!((run.stopped(), slots.available_permits()), (None, 0));
        ahead.stop();
        assert_eq!((run.stopped(), slots.available_permits()), (Some(StopReason::ClaimLost), 1));
        assert!(ahead.take(job).is_none());
    }

    #[test]
    fn what_is_taken_goes_on_in_its_slot() {
        let (ahead, slots, run) = (Ahead::default(), Arc::new(Semaphore::new(1)), Arc::new(Run::default()));
        let job = Uuid::now_v7();
        ahead.enter(job, begun(&slots, &run));
        let mut taken = ahead.take(job).expect("it is there");
        assert!(taken.solution.take().is_some());
        assert_eq!((run.stopped(), slots.available_permits()), (None, 0));
        drop(taken);
        assert_eq!((run.stopped(), slots.available_permits()), (None, 1));
    }
}
