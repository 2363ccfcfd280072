//! Edits of the schemas in the OpenAPI document: limits and defaults of fields, which the derived schemas do not contain.

use std::collections::BTreeMap;

use serde_json::Value;
use utoipa::Number;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{AllOfBuilder, ArrayItems, Object, Schema, SchemaType, Type};

use super::limits::FieldLimits;

/// Schemas by name.
pub type Schemas = BTreeMap<String, RefOr<Schema>>;

/// Sets the default of a field of an object, or of all fields (`*`), from the complete object.
pub fn set_defaults(object: &mut Object, field: &str, complete: Option<&Value>) {
    for (name, property) in &mut object.properties {
        if field != "*" && field != name {
            continue;
        }
        let Some(value) = complete.and_then(|complete| complete.get(name)).cloned() else { continue };
        match property {
            RefOr::T(Schema::Object(of)) => of.default = Some(value),
            RefOr::T(Schema::Array(of)) => of.default = Some(value),
            RefOr::Ref(named) => {
                // A reference cannot carry a default.
                let description = Some(std::mem::take(&mut named.description)).filter(|text| !text.is_empty());
                let of = AllOfBuilder::new().description(description).default(Some(value)).item(named.clone());
                *property = RefOr::T(of.into());
            }
            RefOr::T(_) => {}
        }
    }
}

/// Sets the limits of a number.
pub fn set_limits(number: &mut Object, limits: &FieldLimits) {
    if !matches!(number.schema_type, SchemaType::Type(Type::Number | Type::Integer)) {
        return;
    }
    let lowest = Some(in_json(limits.lowest));
    if limits.exclusive {
        number.exclusive_minimum = lowest;
    } else {
        number.minimum = lowest;
    }
    number.maximum = Some(in_json(limits.highest));
}

/// The number, a whole one without a fraction.
fn in_json(number: f64) -> Number {
    if number.fract() == 0.0 && number.abs() < 1e15 { Number::Int(number as isize) } else { Number::Float(number) }
}

/// Changes the object at a path of fields in a named schema.
pub fn change(schemas: &mut Schemas, name: &str, path: &[&str], change: &impl Fn(&mut Object)) {
    let mut next = vec![(name.to_owned(), path)];
    while let Some((name, path)) = next.pop() {
        if let Some(schema) = schemas.get_mut(&name) {
            follow(schema, path, change, &mut next);
        }
    }
}

/// Follows a path to its end, or to the named schemas in which it continues. A list takes no step of the path, and all alternatives are
/// followed.
fn follow<'a>(
    schema: &mut RefOr<Schema>,
    path: &'a [&'a str],
    change: &impl Fn(&mut Object),
    next: &mut Vec<(String, &'a [&'a str])>,
) {
    match schema {
        RefOr::Ref(named) => next.extend(named.ref_location.rsplit('/').next().map(|name| (name.to_owned(), path))),
        RefOr::T(Schema::Object(object)) => match path.split_first() {
            None => change(object),
            Some((field, rest)) => {
                if let Some(property) = object.properties.get_mut(*field) {
                    follow(property, rest, change, next);
                }
            }
        },
        RefOr::T(Schema::OneOf(of)) => of.items.iter_mut().for_each(|item| follow(item, path, change, next)),
        RefOr::T(Schema::AllOf(of)) => of.items.iter_mut().for_each(|item| follow(item, path, change, next)),
        RefOr::T(Schema::Array(array)) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                follow(items, path, change, next);
            }
        }
        RefOr::T(_) => {}
    }
}
