//! JSON text to values, stricter than serde: duplicate keys, `null` and arrays in the place of
//! objects are refused, each with a pointer to where it stands.

use std::cell::RefCell;
use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, DeserializeSeed, Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};
use serde_path_to_error::Segment;

use super::problem::{FieldError, Refusal, escape};

/// Reports no more faults than this of one body.
pub const MOST_FAULTS: usize = 32;

/// The value of a JSON text without duplicate keys, `null` and numbers beyond double precision.
pub fn read(body: &[u8]) -> Result<Value, Refusal> {
    let reader = Reader::default();
    let mut deserializer = serde_json::Deserializer::from_slice(body);
    let value = (&reader).deserialize(&mut deserializer).and_then(|value| deserializer.end().map(|()| value));
    let faults = reader.faults.into_inner();
    match value {
        Ok(value) if faults.is_empty() => Ok(value),
        Ok(_) => Err(Refusal::Invalid { errors: faults }),
        Err(error) if error.to_string().starts_with("number out of range") => {
            let pointer: String = reader.path.into_inner().concat();
            Err(FieldError::new(pointer, "a number beyond double precision (about ±1.8e308)").into())
        }
        Err(error) => Err(Refusal::NotJson { detail: error.to_string() }),
    }
}

/// Reads a checked value as `T`; pointers of errors begin with `base`.
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
        if WANTS_WORD.iter().any(|words| detail.contains(words))
            && let Some(words) = words_at::<T>(value, &pointer[base.len()..])
        {
            return FieldError::new(pointer, words);
        }
        match detail.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
            Some(field) => FieldError::new(format!("{pointer}/{}", escape(field)), "required, but missing"),
            None => FieldError::new(pointer, in_json(&detail)),
        }
    })
}

/// What serde says of another type in the place of one of several words.
const WANTS_WORD: [&str; 2] = ["expected string or map", "expected map with a single key"];

/// The words that a field takes, as it tells them of one that it does not know; `None`: it does not say.
fn words_at<T: DeserializeOwned>(value: &Value, pointer: &str) -> Option<String> {
    let (mut value, unknown) = (value.clone(), "?");
    *value.pointer_mut(pointer)? = unknown.into();
    let detail = serde_path_to_error::deserialize::<_, T>(value).err()?.inner().to_string();
    let known = detail.strip_prefix(&format!("unknown variant `{unknown}`, "))?;
    Some(format!("wrong type: {known}"))
}

/// What serde says, in words of JSON.
fn in_json(detail: &str) -> String {
    const WORDS: [(&str, &str); 4] = [
        ("expected f64", "expected a number"),
        ("expected a sequence", "expected an array"),
        ("expected string or map", "expected a string or an object"),
        ("floating point", "number"),
    ];
    WORDS.iter().fold(detail.to_owned(), |detail, (of_serde, of_json)| detail.replace(of_serde, of_json))
}

/// The same, going on after a fault without the field that has it, so that one does not hide the others; `None` where
/// nothing can be read without it.
pub fn typed_with_faults<T: DeserializeOwned>(value: &Value) -> (Option<T>, Vec<FieldError>) {
    let mut rest = value.clone();
    let mut faults: Vec<FieldError> = Vec::new();
    let mut stood_in = false;
    while faults.len() < MOST_FAULTS {
        match typed(&rest, "") {
            // A value that stands in for a missing one says nothing of the others.
            Ok(read) => return (Some(read).filter(|_| !stood_in), faults),
            Err(fault) => {
                let already_told = faults.iter().any(|told| told.concerns(&fault.pointer));
                let stands_in = !already_told && put_number(&mut rest, &fault.pointer);
                stood_in |= stands_in;
                let removed = stands_in || remove_field(&mut rest, &fault.pointer);
                if !already_told {
                    faults.push(fault);
                }
                if !removed {
                    break;
                }
            }
        }
    }
    (None, faults)
}

/// Puts a number where an object has no such field; says whether it has put one.
fn put_number(value: &mut Value, pointer: &str) -> bool {
    let Some((object, key)) = pointer.rsplit_once('/') else { return false };
    let Some(Value::Object(fields)) = value.pointer_mut(object) else { return false };
    let key = key.replace("~1", "/").replace("~0", "~");
    !fields.contains_key(&key) && fields.insert(key, 1.into()).is_none()
}

/// Removes the innermost field of an object that the pointer leads to or through, but never a member of an array, whose
/// neighbours would change their places; says whether there was one.
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

/// Either a word or an object, told apart by its JSON type.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum NameOr<N, T> {
    Name(N),
    Object(T),
}

impl<'de, N: Deserialize<'de>, T: Deserialize<'de>> Deserialize<'de> for NameOr<N, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<N, T>(PhantomData<(N, T)>);
        impl<'de, N: Deserialize<'de>, T: Deserialize<'de>> Visitor<'de> for Either<N, T> {
            type Value = NameOr<N, T>;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a name or an object")
            }
            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Self::Value, E> {
                N::deserialize(serde::de::value::StrDeserializer::new(name)).map(NameOr::Name)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(NameOr::Object)
            }
        }
        deserializer.deserialize_any(Either(PhantomData))
    }
}

/// A `T` that only an object gives; serde's derived structs also read arrays.
pub struct ObjectOnly<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for ObjectOnly<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OnlyMaps<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for OnlyMaps<T> {
            type Value = ObjectOnly<T>;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(ObjectOnly)
            }
        }
        deserializer.deserialize_any(OnlyMaps(PhantomData))
    }
}

/// For a field that holds an object.
pub fn object<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<T, D::Error> {
    ObjectOnly::deserialize(deserializer).map(|object| object.0)
}

/// For a field that may hold an object.
pub fn optional_object<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    object(deserializer).map(Some)
}

/// For a field that may hold a whole number; `3.0` is one. What no `u32` holds is refused here, in words of the range
/// from `LEAST` to `MOST` that the field is checked against later.
pub fn whole_number<'de, D: Deserializer<'de>, const LEAST: u32, const MOST: u32>(
    deserializer: D,
) -> Result<Option<u32>, D::Error> {
    let number = f64::deserialize(deserializer)?;
    if number.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&number) {
        return Err(D::Error::custom(format!("{number}: must be a whole number from {LEAST} to {MOST}")));
    }
    Ok(Some(number as u32))
}

/// Builds a value and notes where it stands.
#[derive(Default)]
struct Reader {
    /// Reference tokens with their slashes, from the root to the value being read.
    path: RefCell<Vec<String>>,
    faults: RefCell<Vec<FieldError>>,
}

impl Reader {
    fn fault(&self, detail: &str) {
        let mut faults = self.faults.borrow_mut();
        if faults.len() < MOST_FAULTS {
            faults.push(FieldError::new(self.path.borrow().concat(), detail));
        }
    }

    /// Runs `step` one level deeper. After an error the path stays, to tell where it happened.
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
        self.fault("null is no value; leave the field out to get its default");
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
                    self.fault("given more than once");
                }
                entries.next_value_seed(self)
            })?;
            object.insert(key, value);
        }
        Ok(object.into())
    }
}
