//! Who may ask: bearer tokens, and without them only requests that were meant for this service.

use std::convert::Infallible;

use axum::extract::{FromRequestParts, Request, State};
use axum::http::header::{AUTHORIZATION, HOST};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri};
use axum::middleware::Next;
use axum::response::Response;
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;

use super::App;
use super::error::ApiError;

/// Digests of the tokens that are let in; the tokens themselves are not kept, so nothing can log them.
#[derive(Clone, Default)]
pub struct Tokens {
    digests: Vec<[u8; 32]>,
}

impl std::fmt::Debug for Tokens {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} tokens", self.digests.len())
    }
}

impl Tokens {
    /// Tokens separated by commas.
    pub fn parse(list: &str) -> Self {
        let tokens = list.split(',').map(str::trim).filter(|token| !token.is_empty());
        Self { digests: tokens.map(|token| Sha256::digest(token).into()).collect() }
    }

    pub fn is_empty(&self) -> bool {
        self.digests.is_empty()
    }

    /// The owner behind a token. Every digest is compared, in constant time: how long it takes says nothing.
    fn owner(&self, token: &str) -> Option<Owner> {
        let digest: [u8; 32] = Sha256::digest(token).into();
        let known = self.digests.iter().fold(subtle::Choice::from(0), |known, other| known | other.ct_eq(&digest));
        bool::from(known).then(|| Owner(digest[..8].iter().map(|byte| format!("{byte:02x}")).collect()))
    }
}

/// Whose jobs a request sees: the start of its token's digest, empty where there are no tokens.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Owner(pub String);

impl<S: Sync> FromRequestParts<S> for Owner {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Owner>().cloned().unwrap_or_default())
    }
}

/// Lets in who may ask, and notes who it is.
pub async fn guard(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, ApiError> {
    if app.access.only_local_hosts {
        check_host(request.uri(), request.headers())?;
    }
    if !app.access.tokens.is_empty() && !is_open(request.uri().path()) {
        let owner = bearer(request.headers()).and_then(|token| app.access.tokens.owner(token));
        request.extensions_mut().insert(owner.ok_or(ApiError::Unauthorized)?);
    }
    Ok(next.run(request).await)
}

/// Paths that show nothing of anybody's work.
pub fn is_open(path: &str) -> bool {
    let folders = ["/health/", "/docs/", "/portal/"];
    matches!(path, "/" | "/docs" | "/openapi.json") || folders.iter().any(|folder| path.starts_with(folder))
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, token) = headers.get(AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
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
        assert!(tokens.owner("one").is_some_and(|owner| owner.0.len() == 16));
        assert_ne!(tokens.owner("one"), tokens.owner("two"));
        for wrong in ["", "three", "one,two", "One"] {
            assert_eq!(tokens.owner(wrong), None, "{wrong}");
        }
        assert_eq!(format!("{tokens:?}"), "2 tokens");
        assert!(Tokens::parse(" , ").is_empty());
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
