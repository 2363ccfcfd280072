//! The tokens of the database as the running service knows them, so that a request costs no query.

use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

use tokio_util::sync::CancellationToken;

use super::error::JobError;
use super::store::database::Store;
use super::store::tokens::Token;

/// The tokens as they were last read from the database.
#[derive(Debug)]
pub struct TokenCache {
    store: Store,
    tokens: RwLock<Arc<[Token]>>,
    read_at: tokio::sync::Mutex<Instant>,
}

/// Shortest time between two reads for unknown tokens: it bounds the load by a client that guesses tokens.
const MIN_READ_INTERVAL: Duration = Duration::from_millis(50);

/// Time between two regular reads: a revoked token is accepted for as long as this.
const READ_INTERVAL: Duration = Duration::from_secs(1);

impl TokenCache {
    pub async fn read(store: Store) -> Result<Self, JobError> {
        let tokens = RwLock::new(store.tokens().await?.into());
        Ok(Self { store, tokens, read_at: Instant::now().into() })
    }

    /// The tokens as they were last read.
    pub fn get(&self) -> Arc<[Token]> {
        Arc::clone(&self.tokens.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Reads the tokens after this call, at the shortest interval at most. Simultaneous callers share one read.
    pub async fn refresh(&self) -> Result<(), JobError> {
        let called = Instant::now();
        let mut read_at = self.read_at.lock().await;
        if *read_at < called {
            tokio::time::sleep(MIN_READ_INTERVAL.saturating_sub(read_at.elapsed())).await;
            let begin = Instant::now();
            let tokens: Arc<[Token]> = self.store.tokens().await?.into();
            *self.tokens.write().unwrap_or_else(PoisonError::into_inner) = tokens;
            *read_at = begin;
        }
        Ok(())
    }

    /// Reads the tokens regularly until the service stops or is dropped.
    pub fn keep_current(self: &Arc<Self>, stopping: CancellationToken) {
        let cache = Arc::downgrade(self);
        tokio::spawn(async move {
            loop {
                tokio::time::sleep(READ_INTERVAL).await;
                let Some(cache) = cache.upgrade() else { return };
                if stopping.is_cancelled() {
                    return;
                }
                if let Err(error) = cache.refresh().await {
                    tracing::debug!(%error, "the tokens could not be read");
                }
            }
        });
    }
}
