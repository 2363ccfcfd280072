//! Kinds of paths: those that need no token, and those of submissions.

/// Returns whether a path needs no token. Such paths contain no data of users.
pub fn is_public(path: &str) -> bool {
    let folders = ["/health/", "/docs/", "/portal/"];
    matches!(path, "/" | "/docs" | "/openapi.json") || folders.iter().any(|folder| path.starts_with(folder))
}

/// Returns whether a request with method POST to this path submits jobs.
pub fn is_submission(path: &str) -> bool {
    matches!(path, "/v1/jobs" | "/v1/jobs/batch")
}
