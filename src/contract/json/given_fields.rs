//! Input types written back as JSON.

use serde::Serialize;
use serde_json::Value;

/// The JSON of an input type without its empty fields.
pub fn given_fields(input: &impl Serialize) -> Value {
    // Input types have string keys only, so that this never fails.
    let mut value = serde_json::to_value(input).unwrap_or_default();
    prune(&mut value);
    value
}

fn prune(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|_, field| !field.is_null());
            fields.values_mut().for_each(prune);
        }
        Value::Array(items) => items.iter_mut().for_each(prune),
        _ => {}
    }
}
