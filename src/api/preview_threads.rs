//! Threads and places of previews. They take no job place, and they run while no job wants the processor.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::credentials::Owner;
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
    turns: Arc<Mutex<HashMap<Owner, Weak<Semaphore>>>>,
}

/// A place, and the turn of its owner.
#[derive(Debug)]
pub struct PreviewPlace {
    _place: OwnedSemaphorePermit,
    _turn: OwnedSemaphorePermit,
}

impl Default for Previews {
    fn default() -> Self {
        Self { threads: SolverThreads::yielding(), places: Arc::new(Semaphore::new(PLACES)), turns: Arc::default() }
    }
}

impl Previews {
    /// A place. Owners take turns: one preview of each owner runs or waits for a place, and the others of that owner wait for it. A client that
    /// leaves gives its turn up.
    pub async fn place(&self, owner: &Owner) -> Result<PreviewPlace, ApiError> {
        let turn = self.turn(owner);
        let wait = async {
            let turn = turn.acquire_owned().await?;
            let place = Arc::clone(&self.places).acquire_owned().await?;
            Ok(PreviewPlace { _place: place, _turn: turn })
        };
        let place = tokio::time::timeout(LONGEST_WAIT, wait).await;
        place.map_err(|_| ApiError::PreviewsBusy)?.map_err(|_: tokio::sync::AcquireError| ApiError::Internal)
    }

    /// The turn of an owner, which exists while a preview holds it or waits for it.
    fn turn(&self, owner: &Owner) -> Arc<Semaphore> {
        let mut turns = self.turns.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(turn) = turns.get(owner).and_then(Weak::upgrade) {
            return turn;
        }
        turns.retain(|_, turn| turn.strong_count() > 0);
        let turn = Arc::new(Semaphore::new(1));
        turns.insert(owner.clone(), Arc::downgrade(&turn));
        turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// While a preview runs and its owner waits with another, the next place is that of another owner who comes later.
    #[tokio::test]
    async fn owners_take_turns() {
        let previews = Previews::default();
        let [one, other] = ["one", "other"].map(|name| Owner(name.into()));
        let running = previews.place(&one).await.unwrap();
        let waiting = |owner: Owner| {
            let previews = previews.clone();
            tokio::spawn(async move { previews.place(&owner).await.unwrap() })
        };
        let (second, third) = (waiting(one.clone()), waiting(one));
        tokio::task::yield_now().await;
        let later = waiting(other);
        tokio::task::yield_now().await;
        drop(running);
        let later = later.await.unwrap();
        assert!(!second.is_finished() && !third.is_finished());
        drop(later);
        drop((second.await.unwrap(), third));
        assert_eq!(previews.turns.lock().unwrap().len(), 2);
        previews.turn(&Owner("new".into()));
        assert!(previews.turns.lock().unwrap().len() <= 2);
    }
}
