//! The schema of requests.

use utoipa::{PartialSchema, ToSchema};

use crate::contract::job::JobInput;

/// Requests refuse null, so no schema of theirs allows it; and every type has a description.
#[test]
fn no_request_schema_allows_null() {
    let mut schemas = Vec::new();
    JobInput::schemas(&mut schemas);
    schemas.push((JobInput::name().into_owned(), JobInput::schema()));
    assert!(schemas.len() > 20);
    for (name, schema) in &schemas {
        let json = serde_json::to_string(schema).unwrap();
        assert!(!json.contains("\"null\""), "{name}: {json}");
    }
}
