//! Paths that need no token.

/// Returns whether a path needs no token. Such paths contain no data of users.
pub fn is_public(path: &str) -> bool {
    let folders = ["/health/", "/docs/", "/portal/"];
    matches!(path, "/" | "/docs" | "/openapi.json") || folders.iter().any(|folder| path.starts_with(folder))
}
