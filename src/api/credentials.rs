//! Tokens of the environment, and the owner behind a token.

use std::convert::Infallible;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use jiff::Timestamp;
use subtle::{Choice, ConstantTimeEq};

use crate::jobs::tokens::{Token, TokenDigest, digest_of, owner_of};

/// Tokens from the environment. Only digests are kept, so that the tokens themselves cannot be logged.
#[derive(Clone, Default)]
pub struct Tokens {
    digests: Vec<TokenDigest>,
    is_weak: bool,
}

/// Shortest token that counts as not guessable [characters].
pub const MIN_TOKEN_LENGTH: usize = 16;

impl std::fmt::Debug for Tokens {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} tokens", self.digests.len())
    }
}

impl Tokens {
    /// Tokens separated by commas.
    pub fn parse(list: &str) -> Self {
        let tokens = || list.split(',').map(str::trim).filter(|token| !token.is_empty());
        Self {
            digests: tokens().map(digest_of).collect(),
            is_weak: tokens().any(|token| token.len() < MIN_TOKEN_LENGTH),
        }
    }

    /// Returns whether a token is short enough to be guessed.
    pub fn is_weak(&self) -> bool {
        self.is_weak
    }

    pub fn is_empty(&self) -> bool {
        self.digests.is_empty()
    }

    /// The owner of a token by its digest. Every digest is compared in constant time, so the time reveals nothing.
    pub fn owner(&self, digest: &TokenDigest) -> Option<Owner> {
        let known = self.digests.iter().fold(Choice::from(0), |known, other| known | other.ct_eq(digest));
        bool::from(known).then(|| Owner(owner_of(digest)))
    }
}

/// The owner of a valid token of the database by its digest, compared as in `Tokens::owner`.
pub fn owner_among(tokens: &[Token], digest: &TokenDigest) -> Option<Owner> {
    let matches = |token: &Token| bool::from(token.digest.ct_eq(digest));
    let matching = tokens.iter().fold(None, |found, token| if matches(token) { Some(token) } else { found })?;
    matching.is_valid(Timestamp::now()).then(|| Owner(matching.owner.clone()))
}

/// Owner of the jobs that a request gives access to: the owner of its token, empty without tokens.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct Owner(pub String);

impl<S: Sync> FromRequestParts<S> for Owner {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Owner>().cloned().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_recognized_by_its_digest_only() {
        let tokens = Tokens::parse(" one, two ,,");
        let owner = |token| tokens.owner(&digest_of(token));
        assert!(owner("one").is_some_and(|owner| owner.0.len() == 16));
        assert_ne!(owner("one"), owner("two"));
        for wrong in ["", "three", "one,two", "One"] {
            assert_eq!(owner(wrong), None, "{wrong}");
        }
        assert_eq!(format!("{tokens:?}"), "2 tokens");
        assert!(Tokens::parse(" , ").is_empty());
    }

    #[test]
    fn a_token_of_the_database_is_accepted_while_it_is_valid() {
        let digest = digest_of("secret");
        let hour = jiff::SignedDuration::from_hours(1);
        let (created_at, id) = (Timestamp::now() - 2 * hour, uuid::Uuid::now_v7());
        let token = |expires_at, revoked_at| {
            let (name, owner, digest) = ("a".to_owned(), "portal".to_owned(), digest.to_vec());
            [Token { id, name, owner, digest, created_at, expires_at, revoked_at }]
        };
        let portal = Some(Owner("portal".to_owned()));
        assert_eq!(owner_among(&token(None, None), &digest), portal);
        assert_eq!(owner_among(&token(Some(Timestamp::now() + hour), None), &digest), portal);
        assert_eq!(owner_among(&token(Some(Timestamp::now() - hour), None), &digest), None);
        assert_eq!(owner_among(&token(None, Some(created_at + hour)), &digest), None);
        assert_eq!(owner_among(&token(None, None), &digest_of("guess")), None);
    }
}
