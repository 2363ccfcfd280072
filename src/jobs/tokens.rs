//! Bearer tokens in the database: created, listed and revoked by commands.

use std::fmt;

use jiff::{SignedDuration, Timestamp};
use sha2::{Digest, Sha256};
use uuid::Uuid;

use super::database_lock::DatabaseLock;
use super::error::JobError;
use super::store::database::Store;
use super::store::location::Location;

pub use super::store::tokens::Token;

/// SHA-256 of a token.
pub type TokenDigest = [u8; 32];

/// Digest of a token.
pub fn digest_of(token: &str) -> TokenDigest {
    Sha256::digest(token).into()
}

/// Default owner of a token: the start of its digest.
pub fn owner_of(digest: &TokenDigest) -> String {
    hex(&digest[..8])
}

/// A token as a client sends it. It is printed once and never logged.
pub struct Secret(String);

impl Secret {
    /// 256 random bits from the system, with a prefix that scanners for leaked secrets recognize.
    fn generate() -> Result<Self, JobError> {
        let mut bits = [0; 32];
        getrandom::fill(&mut bits).map_err(|error| JobError::Io(error.into()))?;
        Ok(Self(format!("raceway_{}", hex(&bits))))
    }

    /// The text of the token.
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

/// Properties of a new token.
#[derive(Debug, Clone, Default)]
pub struct NewToken {
    /// A name that no other token has.
    pub name: String,
    /// Owner of the jobs that it gives access to; by default an owner of its own.
    pub owner: Option<String>,
    /// Time until it expires; `None`: never.
    pub valid_for: Option<SignedDuration>,
}

/// The tokens of a database, for the commands.
#[derive(Debug)]
pub struct TokenBook {
    store: Store,
}

impl TokenBook {
    /// Opens the tokens of a database. A running service may be using it.
    pub async fn open(location: &Location) -> Result<Self, JobError> {
        let opening = |error| JobError::opening(location, error);
        let store = Store::open(location, 0, None).await.map_err(opening)?;
        let lock = match location {
            Location::File(path) => match DatabaseLock::take(path) {
                // The service that holds the lock has created the tables.
                Err(JobError::Locked(_)) => return Ok(Self { store }),
                lock => Some(lock?),
            },
            Location::Server(_) => None,
        };
        store.migrate().await.map_err(opening)?;
        drop(lock);
        Ok(Self { store })
    }

    /// Creates a token; `None`: the name is taken.
    pub async fn create(&self, new: NewToken) -> Result<Option<(Secret, Token)>, JobError> {
        let secret = Secret::generate()?;
        let digest = digest_of(secret.reveal());
        let created_at = Timestamp::now();
        let expires_at = new.valid_for.map(|span| created_at.checked_add(span).unwrap_or(Timestamp::MAX));
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

    /// All tokens, revoked and expired ones included, oldest first.
    pub async fn list(&self) -> Result<Vec<Token>, JobError> {
        self.store.tokens().await
    }

    /// Revokes the token with this name or id; `None`: not found.
    pub async fn revoke(&self, which: &str) -> Result<Option<Token>, JobError> {
        self.store.revoke_token(which).await
    }

    pub async fn close(self) {
        self.store.disconnect().await;
    }
}
