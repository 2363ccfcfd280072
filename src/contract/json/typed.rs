//! Checked JSON values to Rust types, with a JSON pointer to each wrong field.

use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::Segment;

use super::problem::{FieldError, MAX_ERRORS, escape};

/// The value as `T`; pointers of errors begin with `base`.
pub fn typed<T: DeserializeOwned>(value: &Value, base: &str) -> Result<T, FieldError> {
    if !value.is_object() {
        return Err(FieldError::new(base, "must be an object"));
    }
    serde_path_to_error::deserialize(value).map_err(|error| {
        let mut pointer = base.to_owned();
        for segment in error.path() {
            match segment {
                Segment::Seq { index } => pointer += &format!("/{index}"),
                Segment::Map { key } | Segment::Enum { variant: key } => pointer += &format!("/{}", escape(key)),
                Segment::Unknown => break,
            }
        }
        let detail = error.inner().to_string();
        if EXPECTS_NAME.iter().any(|words| detail.contains(words))
            && let Some(known) = known_names_at::<T>(value, &pointer[base.len()..])
        {
            return FieldError::new(pointer, known);
        }
        match detail.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
            Some(field) => FieldError::new(format!("{pointer}/{}", escape(field)), "required, but missing"),
            None => FieldError::new(pointer, in_json(&detail)),
        }
    })
}

/// Message of serde for a wrong type where it expects one of several names.
const EXPECTS_NAME: [&str; 2] = ["expected string or map", "expected map with a single key"];

/// The names that a field takes, from serde's error for an unknown one; `None` where that error does not list them.
fn known_names_at<T: DeserializeOwned>(value: &Value, pointer: &str) -> Option<String> {
    let (mut value, unknown) = (value.clone(), "?");
    *value.pointer_mut(pointer)? = unknown.into();
    let detail = serde_path_to_error::deserialize::<_, T>(value).err()?.inner().to_string();
    let known = detail.strip_prefix(&format!("unknown variant `{unknown}`, "))?;
    Some(format!("wrong type: {known}"))
}

/// An error of serde with the names of JSON types in place of Rust's.
fn in_json(detail: &str) -> String {
    const WORDS: [(&str, &str); 4] = [
        ("expected f64", "expected a number"),
        ("expected a sequence", "expected an array"),
        ("expected string or map", "expected a string or an object"),
        ("floating point", "number"),
    ];
    WORDS.iter().fold(detail.to_owned(), |detail, (of_serde, of_json)| detail.replace(of_serde, of_json))
}

/// The value as `T` without its wrong fields, and all their errors, so that one does not hide the others; `None` where a required field
/// is missing or wrong.
pub fn typed_with_errors<T: DeserializeOwned>(value: &Value) -> (Option<T>, Vec<FieldError>) {
    let mut rest = value.clone();
    let mut errors: Vec<FieldError> = Vec::new();
    let mut has_substitute = false;
    while errors.len() < MAX_ERRORS {
        match typed(&rest, "") {
            // A substitute for a missing value makes the other values useless, but not their errors.
            Ok(read) => return (Some(read).filter(|_| !has_substitute), errors),
            Err(error) => {
                let is_known = errors.iter().any(|known| known.concerns(&error.pointer));
                let is_substituted = !is_known && put_number(&mut rest, &error.pointer);
                has_substitute |= is_substituted;
                let removed = is_substituted || remove_field(&mut rest, &error.pointer);
                if !is_known {
                    errors.push(error);
                }
                if !removed {
                    break;
                }
            }
        }
    }
    (None, errors)
}

/// Puts a number into a missing field of an object. Returns whether it did.
fn put_number(value: &mut Value, pointer: &str) -> bool {
    let Some((object, key)) = pointer.rsplit_once('/') else { return false };
    let Some(Value::Object(fields)) = value.pointer_mut(object) else { return false };
    let key = key.replace("~1", "/").replace("~0", "~");
    !fields.contains_key(&key) && fields.insert(key, 1.into()).is_none()
}

/// Removes the innermost field of an object that the pointer leads to or through. Never removes an item of an array: that would
/// change the indices of the items after it. Returns whether there was such a field.
fn remove_field(value: &mut Value, pointer: &str) -> bool {
    let mut end = pointer.len();
    while let Some(slash) = pointer[..end].rfind('/') {
        let key = pointer[slash + 1..end].replace("~1", "/").replace("~0", "~");
        if let Some(Value::Object(fields)) = value.pointer_mut(&pointer[..slash]) {
            return fields.remove(&key).is_some();
        }
        end = slash;
    }
    false
}
