//! The article's case as JSON, and changes of it. The benches include this file, too.

use serde_json::{Value, json};

/// The article's case: integrated bearing, 50 000 r/min, 200 N along +Y, grease.
pub fn article() -> Value {
    json!({
        "bearing": { "preset": "article-integrated" },
        "operation": { "speed_rpm": 50_000, "radial_load_y_n": 200 }
    })
}

/// `base` with the fields of `changes`, merged object by object.
pub fn changed(mut base: Value, changes: Value) -> Value {
    fn merge(base: &mut Value, changes: Value) {
        match (base, changes) {
            (Value::Object(fields), Value::Object(changes)) => {
                for (name, change) in changes {
                    merge(fields.entry(name).or_insert(Value::Null), change);
                }
            }
            (base, changes) => *base = changes,
        }
    }
    merge(&mut base, changes);
    base
}
