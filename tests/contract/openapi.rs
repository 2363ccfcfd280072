//! The OpenAPI document: checked in, served, and complete.

use serde_json::Value;

use crate::common::Server;
use crate::server::start;

#[test]
fn the_checked_in_document_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/openapi/openapi.json");
    let checked_in = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        checked_in == raceway::api::document_text(),
        "openapi/openapi.json is out of date: cargo run -- openapi > openapi/openapi.json"
    );
}

#[test]
fn the_served_document_is_the_printed_one() {
    let served = start().get("/openapi.json").json();
    let printed: Value = serde_json::from_str(&raceway::api::document_text()).expect("JSON");
    assert_eq!(served, printed);
}

#[test]
fn every_operation_is_described() {
    let document: Value = serde_json::from_str(&raceway::api::document_text()).expect("JSON");
    let paths = document["paths"].as_object().expect("paths");
    let operations =
        paths.iter().flat_map(|(path, item)| item.as_object().into_iter().flatten().map(move |o| (path, o)));
    let mut count = 0;
    for (path, (method, operation)) in operations {
        for field in ["summary", "description", "operationId", "tags"] {
            assert!(!operation[field].is_null(), "{method} {path}: {field}");
        }
        for (status, response) in operation["responses"].as_object().expect("responses") {
            let response = match response["$ref"].as_str() {
                Some(reference) => document.pointer(&reference[1..]).expect("the response"),
                None => response,
            };
            let description = response["description"].as_str().unwrap_or_default();
            assert!(!description.is_empty(), "{method} {path}: {status}");
            for (format, content) in response["content"].as_object().into_iter().flatten() {
                let shown = !content["example"].is_null() || !content["examples"].is_null();
                assert!(shown || path == "/openapi.json", "{method} {path}: {status}: no example of {format}");
            }
        }
        if !operation["requestBody"].is_null() {
            assert!(!operation["responses"]["422"].is_null(), "{method} {path}: 422");
        }
        count += 1;
    }
    assert!(count >= 13, "{count} operations");
}

#[test]
fn every_field_is_described() {
    let document: Value = serde_json::from_str(&raceway::api::document_text()).expect("JSON");
    for (name, schema) in document["components"]["schemas"].as_object().expect("schemas") {
        assert!(schema["description"].is_string(), "{name}");
        for (field, schema) in schema["properties"].as_object().into_iter().flatten() {
            let described = schema["description"].is_string() || schema["oneOf"][0]["description"].is_string();
            assert!(described, "{name}.{field}");
        }
    }
}
