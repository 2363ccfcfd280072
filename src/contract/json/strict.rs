//! Reads JSON text more strictly than serde: duplicate keys, `null` and numbers beyond double precision are refused, each with a
//! pointer to its place.

use std::cell::RefCell;
use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::problem::{FieldError, MAX_ERRORS, Refusal, escape};

/// The bytes of a JSON text without the byte-order mark that some editors put before UTF-8.
pub fn text(body: &[u8]) -> &[u8] {
    body.strip_prefix(b"\xef\xbb\xbf").unwrap_or(body)
}

/// The value of a JSON text.
pub fn read(body: &[u8]) -> Result<Value, Refusal> {
    let body = text(body);
    let reader = Reader::default();
    let mut deserializer = serde_json::Deserializer::from_slice(body);
    let value = (&reader).deserialize(&mut deserializer).and_then(|value| deserializer.end().map(|()| value));
    let errors = reader.errors.into_inner();
    match value {
        Ok(value) if errors.is_empty() => Ok(value),
        Ok(_) => Err(Refusal::Invalid { errors }),
        Err(error) if error.to_string().starts_with("number out of range") => {
            let pointer: String = reader.path.into_inner().concat();
            Err(FieldError::new(pointer, "a number beyond double precision (about ±1.8e308)").into())
        }
        Err(error) => {
            let detail = cause(body, &error, &reader.path.into_inner().concat()).unwrap_or_else(|| error.to_string());
            Err(Refusal::NotJson { detail })
        }
    }
}

/// Cause of an error that the parser shows only by its place: UTF-16, NaN, or an infinity.
fn cause(body: &[u8], error: &serde_json::Error, pointer: &str) -> Option<String> {
    if matches!(body, [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, _, ..] | [_, 0, ..]) {
        return Some("the text is UTF-16: encode it as UTF-8".into());
    }
    let line = body.split(|byte| *byte == b'\n').nth(error.line().checked_sub(1)?)?;
    // The column is that of the first byte that is no part of a value, which may be the second of `-Infinity`.
    let rest = |back: usize| line.get(error.column().checked_sub(back)?..);
    let name = ["-Infinity", "Infinity", "NaN"]
        .into_iter()
        .find(|name| (0..=2).any(|back| rest(back).is_some_and(|rest| rest.starts_with(name.as_bytes()))))?;
    let place = if pointer.is_empty() { String::new() } else { format!(" at {pointer}") };
    Some(format!("{name}{place}: JSON has finite numbers only; omit the field, or give a number"))
}

/// Builds a value and knows the path to the part that it reads.
#[derive(Default)]
struct Reader {
    /// Reference tokens with their slashes, from the root to the value being read.
    path: RefCell<Vec<String>>,
    errors: RefCell<Vec<FieldError>>,
}

impl Reader {
    fn refuse(&self, detail: &str) {
        let mut errors = self.errors.borrow_mut();
        if errors.len() < MAX_ERRORS {
            errors.push(FieldError::new(self.path.borrow().concat(), detail));
        }
    }

    /// Runs `step` one level deeper. After an error the path is kept: it locates the error.
    fn at<T, E>(&self, token: &str, step: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        self.path.borrow_mut().push(format!("/{}", escape(token)));
        let result = step()?;
        self.path.borrow_mut().pop();
        Ok(result)
    }
}

impl<'de> DeserializeSeed<'de> for &Reader {
    type Value = Value;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for &Reader {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a JSON value")
    }
    fn visit_unit<E>(self) -> Result<Value, E> {
        self.refuse("null is no value; omit the field to get its default");
        Ok(Value::Null)
    }
    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_string<E>(self, value: String) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = self.at(&values.len().to_string(), || sequence.next_element_seed(self))? {
            values.push(value);
        }
        Ok(values.into())
    }
    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            let value = self.at(&key, || {
                if object.contains_key(&key) {
                    self.refuse("given more than once");
                }
                entries.next_value_seed(self)
            })?;
            object.insert(key, value);
        }
        Ok(object.into())
    }
}
