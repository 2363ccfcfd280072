//! Errors of a request: the field, and the reason.

/// A refused request.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The body is no JSON text.
    #[error("not JSON: {detail}")]
    NotJson { detail: String },
    /// The body is JSON, but no valid request. Never empty.
    #[error("{}", joined(.errors))]
    Invalid { errors: Vec<FieldError> },
}

/// One wrong field.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
pub struct FieldError {
    /// JSON pointer (RFC 6901) to the field from the root of the body.
    #[schema(example = "/scene/bearing/ball_diameter_mm")]
    pub pointer: String,
    /// Reason, in the user's units.
    #[schema(example = "-1 mm: must be from 0.1 to 500 mm")]
    pub detail: String,
}

/// Largest number of errors reported for one body.
pub const MAX_ERRORS: usize = 32;
/// Longest pointer and longest detail [characters].
const MAX_POINTER: usize = 250;
const MAX_DETAIL: usize = 1000;

/// The first `max` characters of the text.
fn cut(text: String, max: usize) -> String {
    match text.char_indices().nth(max) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

impl FieldError {
    /// Both texts are cut where they are longer than those of any field: an error response must not multiply what a client sends.
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: cut(pointer.into(), MAX_POINTER), detail: cut(detail.into(), MAX_DETAIL) }
    }

    /// True if the pointer leads to this field, into it, or to an object that contains it.
    pub fn concerns(&self, pointer: &str) -> bool {
        let within = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        within(pointer, &self.pointer) || within(&self.pointer, pointer)
    }
}

impl std::fmt::Display for FieldError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let field = if self.pointer.is_empty() { "the body" } else { &self.pointer };
        write!(f, "{field}: {}", self.detail)
    }
}

impl Refusal {
    /// The refusal with each error changed by `change`.
    pub fn map_errors(self, change: impl FnMut(FieldError) -> FieldError) -> Self {
        match self {
            Self::Invalid { errors } => Self::Invalid { errors: errors.into_iter().map(change).collect() },
            other => other,
        }
    }
}

impl From<FieldError> for Refusal {
    fn from(error: FieldError) -> Self {
        Self::Invalid { errors: vec![error] }
    }
}

/// A key as a reference token of a JSON pointer.
pub fn escape(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// Names in backticks, separated by commas.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn joined(errors: &[FieldError]) -> String {
    errors.iter().map(FieldError::to_string).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut() {
        let error = FieldError::new("/é".repeat(500_000), "x".repeat(1_000_000));
        assert_eq!(error.pointer.chars().count(), MAX_POINTER + 1);
        assert!(error.detail.len() < MAX_DETAIL + 4 && error.detail.ends_with('…'));
        assert_eq!(FieldError::new("/scene", "x").pointer, "/scene");
    }
}
