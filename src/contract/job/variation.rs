//! The simulations of a request whose scene is varied.

use raceway_core::physics::rating::dynamic_load_rating;
use serde_json::{Map, Value, json};

use super::kind::JobKind;
use super::simulation::Simulation;
use super::varied::{Target, Varied};
use crate::contract::json::problem::{FieldError, Refusal, escape};
use crate::contract::json::typed::typed;
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::scene_input::{ResolvedScene, SceneInput};

/// A request for simulations that differ in the values of the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// The request as a simulation: without the fields that apply to the whole job.
    base: Value,
    /// The scene of the request with all defaults.
    complete: Value,
    /// Series that the simulations may name.
    uploads: Uploads,
}

/// Fields of a request that its simulations do not have.
const FIELDS_OF_WHOLE_JOB: [&str; 13] = [
    "axes",
    "metric",
    "goal",
    "inputs",
    "samples",
    "design",
    "seed",
    "metrics",
    "statistic",
    "labels",
    "priority",
    "reuse",
    "keep_for_s",
];

impl Variation {
    /// From a request whose scene with all defaults is `complete`.
    pub fn new(request: &Value, complete: Value, uploads: &Uploads) -> Self {
        let mut base = request.clone();
        if let Value::Object(fields) = &mut base {
            for field in FIELDS_OF_WHOLE_JOB {
                fields.remove(field);
            }
            fields.insert("kind".into(), JobKind::Simulation.name().into());
            let outputs = fields.entry("outputs").or_insert_with(|| Value::Object(Map::new()));
            // Outputs that are no object have been refused.
            if let Value::Object(outputs) = outputs {
                outputs.insert("spectra".into(), json!([]));
            }
        }
        Self { base, complete, uploads: uploads.clone() }
    }

    /// The request that all simulations share.
    pub fn base(&self) -> &Value {
        &self.base
    }

    /// The simulation with these values.
    pub fn simulation<'a>(&self, values: impl Iterator<Item = (&'a Varied, Value)>) -> Result<Simulation, Refusal> {
        Simulation::of(self.request(values)?, &self.uploads)
    }

    /// The scene with these values; faster than the whole simulation.
    pub fn scene<'a>(&self, values: impl Iterator<Item = (&'a Varied, Value)>) -> Result<ResolvedScene, Refusal> {
        self.scene_of(&self.request(values)?)
    }

    /// Length of the scene as JSON [bytes], at least 1.
    pub fn bytes(&self) -> usize {
        self.base.get("scene").map_or(0, |scene| scene.to_string().len()).max(1)
    }

    /// Reason why the scene has no such field, whatever its value; `None`: it has one.
    pub fn refuses(&self, varied: &Varied) -> Option<String> {
        let Target::Field(tokens) = &varied.target else { return None };
        let mut scene = self.base.get("scene").cloned().unwrap_or_default();
        if let Err(detail) = set(&mut scene, &self.complete, tokens, Value::Bool(true)) {
            return Some(detail);
        }
        // No field takes a boolean: the error concerns either the name or the value.
        let error = typed::<SceneInput>(&scene, "").err()?;
        (error.pointer == varied.name && error.detail.starts_with("unknown field")).then_some(error.detail)
    }

    fn request<'a>(&self, values: impl Iterator<Item = (&'a Varied, Value)>) -> Result<Value, Refusal> {
        let mut request = self.base.clone();
        let mut load_over_rating = None;
        for (varied, value) in values {
            match &varied.target {
                Target::Field(tokens) => set(&mut request["scene"], &self.complete, tokens, value)
                    .map_err(|detail| FieldError::new(format!("/scene{}", varied.name), detail))?,
                Target::AxialLoadOverRating => load_over_rating = value.as_f64(),
            }
        }
        if let Some(share) = load_over_rating {
            // The rating follows from the bearing as the other axes have changed it.
            let rating = dynamic_load_rating(&self.scene_of(&request)?.scene.bearing);
            request["scene"]["operation"]["axial_load_n"] = (share * rating).into();
        }
        Ok(request)
    }

    /// The scene of a request.
    fn scene_of(&self, request: &Value) -> Result<ResolvedScene, Refusal> {
        let scene = typed::<SceneInput>(request.get("scene").unwrap_or(&Value::Null), "/scene")?;
        scene.resolve(&self.uploads).map_err(|errors| Refusal::Invalid { errors })
    }
}

/// Parts of a scene whose other fields keep following their defaults.
const OPEN_PARTS: [&str; 3] = ["operation", "spindle", "terms"];

/// Fields that decide the defaults of the whole part.
const TYPE_FIELDS: [&str; 2] = ["kind", "law"];

/// Index of an item in a JSON pointer: digits without a sign or a leading zero, so that an item has one name.
fn index_of(token: &str) -> Option<usize> {
    token.parse().ok().filter(|index: &usize| index.to_string() == token)
}

/// Sets a field of a scene. A part on the path that is a name or missing is replaced by the part with its defaults, from `complete`.
/// Exceptions, in which only the field is given so that dependent defaults still follow from it: a bearing by name, the open parts,
/// and a type field.
fn set(scene: &mut Value, complete: &Value, tokens: &[String], value: Value) -> Result<(), String> {
    let Some((field, parents)) = tokens.split_last() else { return Err("no field".to_owned()) };
    let (mut at, mut filled, mut path) = (scene, Some(complete), String::new());
    let mut is_named = true;
    for (depth, token) in parents.iter().enumerate() {
        let parent = path.clone();
        path += &format!("/{}", escape(token));
        filled = filled.and_then(|part| part.get(token).or_else(|| part.get(index_of(token)?)));
        let next = match at {
            Value::Object(fields) => fields.entry(token.as_str()).or_insert(Value::Null),
            Value::Array(items) => {
                let item = index_of(token).and_then(|index| items.get_mut(index));
                item.ok_or_else(|| format!("`{parent}` has no item {token}"))?
            }
            _ => return Err(format!("`{parent}` is no object")),
        };
        if let Value::String(name) = next
            && depth == 0
            && token == "bearing"
        {
            *next = json!({ "preset": name });
        } else if next.is_null() && depth == 0 && OPEN_PARTS.contains(&token.as_str()) {
            *next = json!({});
        } else if !next.is_object() && !next.is_array() {
            *next = filled.filter(|part| part.is_object()).cloned().ok_or_else(|| match next.is_null() {
                true => format!("the scene has no `{path}`"),
                false => format!("`{path}` is no object and no list"),
            })?;
            is_named = false;
        }
        at = next;
    }
    match at {
        Value::Object(fields) => {
            if !is_named && TYPE_FIELDS.contains(&field.as_str()) {
                fields.clear();
            }
            fields.insert(field.clone(), value);
            Ok(())
        }
        Value::Array(items) => match index_of(field).and_then(|index| items.get_mut(index)) {
            Some(item) => {
                *item = value;
                Ok(())
            }
            None => Err(format!("`{path}` has no item {field}")),
        },
        _ => Err(format!("`{path}` is no object")),
    }
}
