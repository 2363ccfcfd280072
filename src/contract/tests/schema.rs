//! The schema of requests.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use utoipa::openapi::RefOr;
use utoipa::openapi::schema::Schema;
use utoipa::{PartialSchema, ToSchema};

use crate::contract::job::input::JobInput;
use crate::contract::job::kind::FIELDS_OF_SOME_KINDS;
use crate::contract::job::schema::{self, KINDS};
use crate::contract::parse_job;

fn job_schemas() -> BTreeMap<String, RefOr<Schema>> {
    let mut schemas = Vec::new();
    JobInput::schemas(&mut schemas);
    schemas.push((JobInput::name().into_owned(), JobInput::schema()));
    let mut schemas = schemas.into_iter().collect();
    schema::complete(&mut schemas);
    schemas
}

/// A field of a kind of job, in JSON.
fn property(kind: &str, way: &[&str]) -> Value {
    let schemas = serde_json::to_value(job_schemas()).unwrap();
    let mut at = schemas[kind].clone();
    for field in way {
        // Where a name or an object may stand, the object is meant.
        while at["properties"].is_null() {
            let of = at["$ref"].as_str().or_else(|| {
                at["oneOf"]
                    .as_array()?
                    .iter()
                    .find_map(|one| one["$ref"].as_str().filter(|name| !name.ends_with("Name")))
            });
            at = schemas[of.expect("a schema by name").rsplit('/').next().unwrap()].clone();
        }
        at = at["properties"][field].take();
    }
    at
}

/// Validation and schema have the same table; here is what some of its rows become.
#[test]
fn limits_stand_in_the_schema() {
    let limits = |kind: &str, way: &[&str]| {
        let field = property(kind, way);
        ["minimum", "exclusiveMinimum", "maximum"].map(|limit| field[limit].as_f64())
    };
    let bearing = |field: &'static str| limits("SimulationJob", &["scene", "bearing", field]);
    assert_eq!(bearing("ball_diameter_mm"), [Some(0.1), None, Some(500.0)]);
    assert_eq!(bearing("inner_groove_curvature"), [None, Some(0.5), Some(1.0)]);
    assert_eq!(bearing("radial_clearance_um"), [Some(-10_000.0), None, Some(500_000.0)]);
    assert_eq!(bearing("contact_angle_deg"), [Some(0.0), None, Some(60.0)]);
    assert_eq!(limits("SimulationJob", &["scene", "bearing", "cage", "mass_g"]), [Some(1e-9), None, Some(1e6)]);
    assert_eq!(limits("BearingAccuracyJob", &["solver", "model_tolerance_db"]), [Some(0.0), None, Some(20.0)]);
    assert_eq!(limits("StudyJob", &["priority"]), [Some(1.0), None, Some(4.0)]);
    let tolerances = property("BearingAccuracyJob", &["relative_tolerances"]);
    assert_eq!((&tolerances["items"]["minimum"], &tolerances["items"]["maximum"]), (&json!(1e-12), &json!(0.01)));
    let schemas = serde_json::to_value(job_schemas()).unwrap();
    assert_eq!(schemas["SpeedInput"]["oneOf"][0]["maximum"], 500_000);
    assert_eq!(schemas["SpeedPointInput"]["properties"]["at_s"]["maximum"], 1_000_000);
    assert_eq!(schemas["SpeedInput"]["oneOf"][0]["minimum"], -500_000);
    let without = |name: &str, field: &Value| {
        field["type"] == "number" && field["maximum"].is_null() && name != "from" && name != "to"
    };
    for (schema, fields) in schemas.as_object().unwrap() {
        for (name, field) in fields["properties"].as_object().into_iter().flatten() {
            assert!(!without(name, field), "{schema}.{name} has no limits");
        }
    }
}

#[test]
fn defaults_that_are_fixed_stand_in_the_schema() {
    let default = |kind: &str, way: &[&str]| property(kind, way)["default"].clone();
    assert_eq!(default("SimulationJob", &["scene", "gravity_m_s2"]), 9.81);
    assert_eq!(default("SimulationJob", &["scene", "bearing", "cage", "friction"]), 0.08);
    assert_eq!(default("SimulationJob", &["scene", "terms", "drag"]), "auto");
    assert_eq!(default("SimulationJob", &["outputs", "metrics"]), json!(["vibration", "contacts", "cage"]));
    assert_eq!(default("BearingAccuracyJob", &["duration_s"]), 0.02);
    assert_eq!(default("OptimumJob", &["goal"]), "minimum");
    assert_eq!(default("OptimumJob", &["outputs", "metrics"]), Value::Null);
    for kind in &KINDS {
        assert_eq!(default(kind.name, &["priority"]), 2);
    }
}

/// The schema of a kind has the fields that validation accepts with it, and each with its default in a request changes nothing.
#[test]
fn kinds_take_what_their_schemas_say() {
    let base = |kind: &str| {
        let mut job = json!({ "kind": kind, "scene": { "bearing": "608", "operation": { "speed_rpm": 3000 } } });
        match kind {
            "study" => job["axes"] = json!([{ "path": "/spindle/mass_kg", "values": [0.05] }]),
            "optimum" => {
                job["axes"] = json!([{ "path": "/spindle/mass_kg", "from": 0.05, "to": 0.1 }]);
                job["metric"] = json!("/channels/spindle.y.acceleration/rms");
            }
            "uncertainty" => {
                let distribution = json!({ "type": "uniform", "from": 0.05, "to": 0.1 });
                job["inputs"] = json!([{ "path": "/spindle/mass_kg", "distribution": distribution }]);
            }
            _ => {}
        }
        job
    };
    let parsed = |job: &Value| parse_job(job.to_string().as_bytes());
    for kind in &KINDS {
        let job = base(kind.kind.name());
        let canonical = parsed(&job).unwrap().canonical();
        for field in FIELDS_OF_SOME_KINDS.into_iter().filter(|field| !kind.kind.takes().contains(field)) {
            let mut with = job.clone();
            with[field] = match field {
                "axes" => json!([]),
                "metric" | "goal" => json!("minimum"),
                "design" => json!("sobol"),
                "samples" => json!(64),
                "statistic" => json!("mean"),
                "repetitions" | "seed" => json!(1),
                _ => json!([]),
            };
            let refused = parsed(&with).map(|_| ()).unwrap_err().to_string();
            assert!(refused.contains(&format!("/{field}: goes with")), "{}: {refused}", kind.name);
        }
        let mut said = job.clone();
        for (name, field) in property(kind.name, &[])["properties"].as_object().unwrap() {
            if !field["default"].is_null() {
                said[name] = field["default"].clone();
            }
        }
        assert_eq!(parsed(&said).unwrap().canonical(), canonical);
    }
    let mut said = base("simulation");
    let defaults = |way: &[&str]| {
        let of = property("SimulationJob", way);
        let name = of["$ref"].as_str().unwrap().rsplit('/').next().unwrap().to_owned();
        let fields = property(&name, &[])["properties"].take();
        let given = fields.as_object().unwrap().iter().filter(|field| !field.1["default"].is_null());
        given.map(|(name, field)| (name.clone(), field["default"].clone())).collect::<serde_json::Map<_, _>>()
    };
    said["solver"] = defaults(&["solver"]).into();
    said["outputs"] = defaults(&["outputs"]).into();
    said["scene"]["terms"] = defaults(&["scene", "terms"]).into();
    said["scene"]["bearing"] = json!({ "preset": "608", "cage": defaults(&["scene", "bearing", "cage"]) });
    said["scene"]["operation"].as_object_mut().unwrap().append(&mut defaults(&["scene", "operation"]));
    assert_eq!(parsed(&said).unwrap().canonical(), parsed(&base("simulation")).unwrap().canonical());
}

/// Requests refuse null, so no schema of theirs allows it; and every type has a description.
#[test]
fn no_request_schema_allows_null() {
    let schemas = job_schemas();
    assert!(schemas.len() > 20);
    for (name, schema) in &schemas {
        let json = serde_json::to_string(schema).unwrap();
        assert!(!json.contains("\"null\""), "{name}: {json}");
    }
}
