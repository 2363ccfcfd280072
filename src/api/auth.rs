//! Who may ask: bearer tokens, and without them only requests that were meant for this service.

use std::convert::Infallible;

use axum::extract::{FromRequestParts, Request, State};
use axum::http::header::{AUTHORIZATION, HOST};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri};
use axum::middleware::Next;
use axum::response::Response;
use jiff::Timestamp;
use subtle::{Choice, ConstantTimeEq};

use super::App;
use super::error::ApiError;
use crate::jobs::tokens::{Token, TokenDigest, digest_of, owner_of};

/// Tokens from the environment: digests, so that nothing can log the tokens themselves.
#[derive(Clone, Default)]
pub struct Tokens {
    digests: Vec<TokenDigest>,
    is_weak: bool,
}

/// Characters of a token below which it may be guessed.
pub const LEAST_TOKEN: usize = 16;

impl std::fmt::Debug for Tokens {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} tokens", self.digests.len())
    }
}

impl Tokens {
    /// Tokens separated by commas.
    pub fn parse(list: &str) -> Self {
        let tokens = || list.split(',').map(str::trim).filter(|token| !token.is_empty());
        Self { digests: tokens().map(digest_of).collect(), is_weak: tokens().any(|token| token.len() < LEAST_TOKEN) }
    }

    /// Whether one of them is so short that it may be guessed.
    pub fn is_weak(&self) -> bool {
        self.is_weak
    }

    pub fn is_empty(&self) -> bool {
        self.digests.is_empty()
    }

    /// The owner behind a digest. Every digest is compared, in constant time: how long it takes says nothing.
    fn owner(&self, digest: &TokenDigest) -> Option<Owner> {
        let known = self.digests.iter().fold(Choice::from(0), |known, other| known | other.ct_eq(digest));
        bool::from(known).then(|| Owner(owner_of(digest)))
    }
}

/// The owner behind a digest among tokens of the database that hold, compared as above.
fn owner_among(tokens: &[Token], digest: &TokenDigest) -> Option<Owner> {
    let is_it = |token: &Token| bool::from(token.digest.ct_eq(digest));
    let matching = tokens.iter().fold(None, |found, token| if is_it(token) { Some(token) } else { found })?;
    matching.holds(Timestamp::now()).then(|| Owner(matching.owner.clone()))
}

/// Whose jobs a request sees: the owner of its token, empty where there are no tokens.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct Owner(pub String);

impl<S: Sync> FromRequestParts<S> for Owner {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Owner>().cloned().unwrap_or_default())
    }
}

/// What a request came in by, for those who stay longer than the token may hold.
#[derive(Clone, Default)]
pub struct Pass(Option<TokenDigest>);

impl Pass {
    /// Whether it would still be let in.
    pub fn holds(&self, app: &App) -> bool {
        match &self.0 {
            Some(digest) => known(app, digest).is_some(),
            None => !is_closed(app),
        }
    }
}

impl<S: Sync> FromRequestParts<S> for Pass {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Pass>().cloned().unwrap_or_default())
    }
}

/// Lets in who may ask as often as it does, and notes who it is. Where there has ever been a token, one is needed.
pub async fn guard(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, ApiError> {
    let access = &app.access;
    let is_closed = is_closed(&app);
    if access.is_local && !is_closed {
        check_host(request.uri(), request.headers())?;
    }
    if is_closed && !is_open(request.uri().path()) {
        let token = bearer(request.headers()).ok_or(ApiError::Unauthorized)?;
        let digest = digest_of(token);
        let owner = owner(&app, &digest).await?;
        access.rates.check(&owner)?;
        request.extensions_mut().insert(owner);
        request.extensions_mut().insert(Pass(Some(digest)));
    }
    Ok(next.run(request).await)
}

/// Whether a token is needed: there is one, or has ever been.
fn is_closed(app: &App) -> bool {
    !app.access.tokens.is_empty() || !app.jobs.tokens().is_empty()
}

/// The owner behind a digest, as tokens stood a second ago at most.
fn known(app: &App, digest: &TokenDigest) -> Option<Owner> {
    app.access.tokens.owner(digest).or_else(|| owner_among(&app.jobs.tokens(), digest))
}

async fn owner(app: &App, digest: &TokenDigest) -> Result<Owner, ApiError> {
    match known(app, digest) {
        Some(owner) => Ok(owner),
        // It may have been made a moment ago.
        None => owner_among(&app.jobs.tokens_now().await?, digest).ok_or(ApiError::Unauthorized),
    }
}

/// Paths that show nothing of anybody's work.
pub fn is_open(path: &str) -> bool {
    let folders = ["/health/", "/docs/", "/portal/"];
    matches!(path, "/" | "/docs" | "/openapi.json") || folders.iter().any(|folder| path.starts_with(folder))
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let mut given = headers.get_all(AUTHORIZATION).iter();
    // Of two nobody knows which is meant.
    let (Some(only), None) = (given.next(), given.next()) else { return None };
    let (scheme, token) = only.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

/// A page on the internet can have its name point to 127.0.0.1 and so reach a service without tokens
/// through its reader's browser, but it cannot choose the Host that the browser sends.
fn check_host(uri: &Uri, headers: &HeaderMap) -> Result<(), ApiError> {
    let mut hosts = headers.get_all(HOST).iter();
    let host = match (uri.authority(), hosts.next(), hosts.next()) {
        (Some(authority), ..) => authority.as_str(),
        (None, Some(host), None) => host.to_str().unwrap_or("?"),
        _ => return Err(ApiError::BadRequest("send one Host header".into())),
    };
    if is_local(host) { Ok(()) } else { Err(ApiError::ForeignHost(host.to_owned())) }
}

fn is_local(host: &str) -> bool {
    let Ok(authority) = host.parse::<Authority>() else { return false };
    // What follows the name; with a user's name in front there is none.
    let Some(port) = host.strip_prefix(authority.host()) else { return false };
    if !port.is_empty() && !port.strip_prefix(':').is_some_and(is_port) {
        return false;
    }
    let name = authority.host().trim_start_matches('[').trim_end_matches(']');
    let name = name.strip_suffix('.').unwrap_or(name);
    let is_name = name.eq_ignore_ascii_case("localhost") || name.to_ascii_lowercase().ends_with(".localhost");
    is_name || name.parse::<std::net::IpAddr>().is_ok()
}

fn is_port(text: &str) -> bool {
    text.bytes().all(|byte| byte.is_ascii_digit()) && text.parse::<u16>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_known_by_its_digest_only() {
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
    fn a_token_of_the_database_lets_in_while_it_holds() {
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

    #[test]
    fn addresses_and_localhost_are_local() {
        for host in ["localhost.", "localhost.:80", "127.0.0.1"] {
            assert!(is_local(host), "{host}");
        }
        for host in ["me@localhost", "me:80@127.0.0.1", "localhost:99999", "localhost:+80", "localhost:http"] {
            assert!(!is_local(host), "{host}");
        }
        for host in ["localhost", "LOCALHOST:80", "127.0.0.1:8080", "[::1]:8080", "192.168.0.3", "a.localhost"] {
            assert!(is_local(host), "{host}");
        }
        for host in ["example.org", "localhost.example.org", "127.0.0.1.nip.io:80", "", "a b", "user@example.org"] {
            assert!(!is_local(host), "{host}");
        }
    }
}
