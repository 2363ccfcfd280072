//! Bearer tokens that are kept in the database: made, listed and revoked by commands, and known to the service as they stood a
//! moment ago.

use std::fmt;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};
use sha2::{Digest, Sha256};
use uuid::Uuid;

use super::JobError;
use super::lock::DatabaseLock;
use super::service::Inner;
use super::store::{Location, Store};

pub use super::store::tokens::Token;

/// SHA-256 of a token.
pub type TokenDigest = [u8; 32];

/// Digest of a token.
pub fn digest_of(token: &str) -> TokenDigest {
    Sha256::digest(token).into()
}

/// Whose jobs a token sees unless it was made for somebody: the start of its digest.
pub fn owner_of(digest: &TokenDigest) -> String {
    hex(&digest[..8])
}

/// A token as its user sends it. It is shown once, and never in logs.
pub struct Secret(String);

impl Secret {
    /// 256 bits from the system, behind a word by which scanners of leaked secrets know it.
    fn draw() -> Result<Self, JobError> {
        let mut bits = [0; 32];
        getrandom::fill(&mut bits).map_err(|error| JobError::Io(error.into()))?;
        Ok(Self(format!("raceway_{}", hex(&bits))))
    }

    /// The token itself.
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a token")
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What a new token is to be.
#[derive(Debug, Clone, Default)]
pub struct NewToken {
    /// A name of its own.
    pub name: String,
    /// Whose jobs it sees; unless told, its own.
    pub owner: Option<String>,
    /// How long it lets in.
    pub holds_for: Option<SignedDuration>,
}

/// The tokens of a database, for the commands.
#[derive(Debug)]
pub struct TokenBook {
    store: Store,
}

impl TokenBook {
    /// Opens the tokens of a database, which a running service may be using.
    pub async fn open(location: &Location) -> Result<Self, JobError> {
        let opening = |error| JobError::opening(location, error);
        let store = Store::open(location, 0, None).await.map_err(opening)?;
        let lock = match location {
            Location::File(path) => match DatabaseLock::take(path) {
                // Its tables are those of the service that uses it.
                Err(JobError::Locked(_)) => return Ok(Self { store }),
                lock => Some(lock?),
            },
            Location::Server(_) => None,
        };
        store.migrate().await.map_err(opening)?;
        drop(lock);
        Ok(Self { store })
    }

    /// Makes a token; `None`: the name is taken.
    pub async fn create(&self, new: NewToken) -> Result<Option<(Secret, Token)>, JobError> {
        let secret = Secret::draw()?;
        let digest = digest_of(secret.reveal());
        let created_at = Timestamp::now();
        let expires_at = new.holds_for.map(|span| created_at.checked_add(span).unwrap_or(Timestamp::MAX));
        let token = Token {
            id: Uuid::now_v7(),
            name: new.name,
            owner: new.owner.unwrap_or_else(|| owner_of(&digest)),
            digest: digest.to_vec(),
            created_at,
            expires_at,
            revoked_at: None,
        };
        Ok(self.store.add_token(&token).await?.then_some((secret, token)))
    }

    /// All tokens that ever were, oldest first.
    pub async fn list(&self) -> Result<Vec<Token>, JobError> {
        self.store.tokens().await
    }

    /// Revokes the token of that name or id; `None`: there is none.
    pub async fn revoke(&self, which: &str) -> Result<Option<Token>, JobError> {
        self.store.revoke_token(which).await
    }

    pub async fn close(self) {
        self.store.disconnect().await;
    }
}

/// Tokens as they stood a moment ago, so that a request costs no query.
#[derive(Debug)]
pub struct KnownTokens {
    known: RwLock<Arc<[Token]>>,
    read_at: tokio::sync::Mutex<Instant>,
}

/// Between two looks on behalf of unknown tokens: whoever guesses asks the database this often at most, and waits for it.
const APART: Duration = Duration::from_millis(50);

impl KnownTokens {
    pub async fn read(store: &Store) -> Result<Self, JobError> {
        let known = RwLock::new(store.tokens().await?.into());
        Ok(Self { known, read_at: Instant::now().into() })
    }

    /// The tokens as they were read last.
    pub fn get(&self) -> Arc<[Token]> {
        Arc::clone(&self.known.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Has them read since it was called, and no more often than may be: those who wait for it share one look.
    pub async fn refresh(&self, store: &Store) -> Result<(), JobError> {
        let called = Instant::now();
        let mut read_at = self.read_at.lock().await;
        if *read_at < called {
            tokio::time::sleep(APART.saturating_sub(read_at.elapsed())).await;
            let begin = Instant::now();
            let tokens: Arc<[Token]> = store.tokens().await?.into();
            *self.known.write().unwrap_or_else(PoisonError::into_inner) = tokens;
            *read_at = begin;
        }
        Ok(())
    }
}

/// How long a revoked token may still let in.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Reads the tokens again and again until the service is dropped.
pub(super) fn follow(inner: &Arc<Inner>) {
    let inner = Arc::downgrade(inner);
    tokio::spawn(async move {
        loop {
            tokio::time::sleep(LOOK_EVERY).await;
            let Some(inner) = inner.upgrade() else { return };
            if inner.is_stopping() {
                return;
            }
            if let Err(error) = inner.tokens.refresh(&inner.store).await {
                tracing::debug!(%error, "the tokens could not be read");
            }
        }
    });
}
