//! Access control: bearer tokens. Without tokens a service on loopback accepts only requests that were addressed to it.

use std::convert::Infallible;

use axum::extract::{FromRequestParts, Request, State};
use axum::http::header::{AUTHORIZATION, HOST};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Method, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::app::App;
use super::connection_places::Arrival;
use super::credentials::{Owner, owner_among};
use super::error::ApiError;
use super::public_paths::{is_public, is_submission};
use super::rate_limit::LeftPlaces;
use crate::jobs::tokens::{TokenDigest, digest_of};

/// The token of a request that outlasts a check, such as an event stream: it is checked again while the request lasts.
#[derive(Clone, Default)]
pub struct Credential(Option<TokenDigest>);

impl Credential {
    /// Returns whether the token is still accepted.
    pub fn is_valid(&self, app: &App) -> bool {
        match &self.0 {
            Some(digest) => known_owner(app, digest).is_some(),
            None => !needs_token(app),
        }
    }

    /// Returns whether the request has a token, so that its owner's shares are counted.
    pub fn has_token(&self) -> bool {
        self.0.is_some()
    }
}

impl<S: Sync> FromRequestParts<S> for Credential {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get::<Credential>().cloned().unwrap_or_default())
    }
}

/// Checks the token and the rate of a request, and records its owner. A token is needed once one has ever existed. A connection keeps
/// its place after a request that passes and is not to a public path.
pub async fn guard(State(app): State<App>, mut request: Request, next: Next) -> Result<Response, ApiError> {
    let access = &app.access;
    let needs_token = needs_token(&app);
    if access.is_local && !needs_token {
        check_host(request.uri(), request.headers())?;
    }
    if is_public(request.uri().path()) {
        return Ok(next.run(request).await);
    }
    if needs_token {
        let token = bearer(request.headers()).ok_or(ApiError::Unauthorized)?;
        let digest = digest_of(token);
        let owner = owner(&app, &digest).await?;
        let is_submission = request.method() == Method::POST && is_submission(request.uri().path());
        if let Err(refused) = access.rates.take(&owner, is_submission) {
            return Ok(with_limits(&app, Some(&owner), refused.into_response()));
        }
        request.extensions_mut().insert(owner.clone());
        request.extensions_mut().insert(Credential(Some(digest)));
        authorised(&request);
        return Ok(with_limits(&app, Some(&owner), next.run(request).await));
    }
    authorised(&request);
    Ok(with_limits(&app, None, next.run(request).await))
}

/// Marks the connection of an authorised request, so that it gives way to none.
fn authorised(request: &Request) {
    if let Some(arrival) = request.extensions().get::<Arrival>() {
        arrival.remove();
    }
}

/// The response with headers that tell what the limits leave.
fn with_limits(app: &App, owner: Option<&Owner>, mut response: Response) -> Response {
    let places = response.extensions_mut().remove::<LeftPlaces>().unwrap_or_default();
    app.access.rates.describe(owner, &places, response.headers_mut());
    response
}

/// Returns whether a token is needed: one exists, or has ever existed.
fn needs_token(app: &App) -> bool {
    !app.access.tokens.is_empty() || !app.jobs.tokens().is_empty()
}

/// The owner of a token by its digest, from tokens that are at most a second old.
fn known_owner(app: &App, digest: &TokenDigest) -> Option<Owner> {
    app.access.tokens.owner(digest).or_else(|| owner_among(&app.jobs.tokens(), digest))
}

/// The owner of a token by its digest.
async fn owner(app: &App, digest: &TokenDigest) -> Result<Owner, ApiError> {
    match known_owner(app, digest) {
        Some(owner) => Ok(owner),
        // The token may have been created a moment ago.
        None => owner_among(&app.jobs.tokens_now().await?, digest).ok_or(ApiError::Unauthorized),
    }
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let mut sent = headers.get_all(AUTHORIZATION).iter();
    // Two headers are ambiguous.
    let (Some(only), None) = (sent.next(), sent.next()) else { return None };
    let (scheme, token) = only.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

/// Refuses a foreign `Host`, against DNS rebinding.
///
/// A web page can point its own name to 127.0.0.1 and reach a service without tokens through its reader's browser. It cannot choose
/// the `Host` that the browser sends.
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
    // With a user name in front the prefix does not match.
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
