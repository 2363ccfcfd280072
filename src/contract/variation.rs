//! What is varied in a scene, and the simulation with other values in its place.

use serde_json::{Map, Value, json};

use super::filling::Filling;
use super::job::{Job, JobKind, simulation_of};
use super::problem::{FieldError, Refusal, escape, listed};
use super::scene::{ResolvedScene, SceneInput};
use super::strict;
use super::units::significant;
use crate::physics::rating::dynamic_load_rating;

/// Longest path and longest word among the values [characters]: each row of a table repeats them.
pub const LONGEST_NAME: usize = 200;
const AXIAL_LOAD_OVER_RATING: &str = "axial_load_over_rating";

/// A field of the scene, or a quantity made of several.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// Pointer or quantity, as in the request.
    pub name: String,
    target: Target,
}

/// What a value sets.
#[derive(Debug, Clone, PartialEq)]
enum Target {
    /// A field of the scene, by reference tokens.
    Field(Vec<String>),
    AxialLoadOverRating,
}

impl Varied {
    /// By the path or the quantity of an axis at `pointer` of the request.
    pub fn of(path: Option<String>, quantity: Option<String>, pointer: &str, filling: &mut Filling) -> Option<Self> {
        if let Some(path) = path.as_ref().filter(|path| path.chars().count() > LONGEST_NAME) {
            let long = path.chars().count();
            filling.refuse(format!("{pointer}/path"), format!("{long} characters: at most {LONGEST_NAME}"));
            return None;
        }
        match (path, quantity) {
            (Some(path), None) => match tokens(&path) {
                Some(tokens) => return Some(Self { name: path, target: Target::Field(tokens) }),
                None => filling.refuse(
                    format!("{pointer}/path"),
                    "must be a JSON pointer into the scene, such as `/spindle/mass_kg`",
                ),
            },
            (None, Some(quantity)) if quantity == AXIAL_LOAD_OVER_RATING => {
                return Some(Self { name: quantity, target: Target::AxialLoadOverRating });
            }
            (None, Some(quantity)) => {
                let quantity: String = quantity.chars().take(100).collect();
                filling.refuse(
                    format!("{pointer}/quantity"),
                    format!("no quantity is called `{quantity}`; there is `{AXIAL_LOAD_OVER_RATING}`"),
                );
            }
            _ => filling.refuse(pointer, "takes either `path` or `quantity`"),
        }
        None
    }

    /// The way to what is set in the scene.
    fn way(&self) -> Vec<String> {
        match &self.target {
            Target::Field(tokens) => tokens.clone(),
            Target::AxialLoadOverRating => ["operation", "axial_load_n"].map(str::to_owned).to_vec(),
        }
    }

    /// Whether setting this and that one sets the same field, or one a part of the other: the second would undo the first.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.way().iter().zip(&other.way()).all(|(a, b)| a == b)
    }

    /// Whether the field at a pointer into the request is what is set, or a part of it.
    pub fn sets(&self, pointer: &str) -> bool {
        let field = pointer.strip_prefix("/scene").and_then(tokens);
        field.is_some_and(|field| field.starts_with(&self.way()))
    }

    /// Whether other values than numbers can have a meaning.
    pub fn takes_words(&self) -> bool {
        self.target != Target::AxialLoadOverRating
    }

    /// What is wrong with the field at a pointer into the request, as an axis may say it: by the path into the scene, unless that
    /// is what it varies.
    pub fn told(&self, error: &FieldError) -> String {
        let path = error.pointer.strip_prefix("/scene").unwrap_or(&error.pointer);
        if path == self.name { error.detail.clone() } else { format!("`{path}`: {}", error.detail) }
    }
}

/// An error of a simulation with these values, told of the axis that has set the field: in the request there may be none.
pub fn of_an_axis<'a>(error: FieldError, axes: impl Iterator<Item = &'a Varied>) -> FieldError {
    for (place, varied) in axes.enumerate() {
        if varied.sets(&error.pointer) {
            return FieldError::new(format!("/axes/{place}"), varied.told(&error));
        }
    }
    error
}

/// Reference tokens of a pointer to a field; `None` of no such pointer.
fn tokens(path: &str) -> Option<Vec<String>> {
    let tokens: Vec<String> =
        path.strip_prefix('/')?.split('/').map(|t| t.replace("~1", "/").replace("~0", "~")).collect();
    tokens.iter().all(|token| !token.is_empty()).then_some(tokens)
}

/// Values between two ends, which belong to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub from: f64,
    pub to: f64,
    pub scale: Scale,
}

/// How values between two ends are spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    Linear,
    Log,
}

/// Significant digits of values that are computed: what rounding adds is nobody's wish.
const DIGITS: usize = 9;

impl Range {
    /// Of an axis at `pointer` of the request, linear where it does not say.
    pub fn of(from: f64, to: f64, scale: Option<&str>, pointer: &str, filling: &mut Filling) -> Option<Self> {
        let mut refuse = |field: &str, detail: String| {
            filling.refuse(format!("{pointer}/{field}"), detail);
            None
        };
        if from == to {
            return refuse("to", "the same as `from`".to_owned());
        }
        if !(to - from).is_finite() || scale == Some("log") && from != 0.0 && !(to / from).is_finite() {
            return refuse("to", format!("too far from `from`, {from:e}, for a computer to divide"));
        }
        match scale.unwrap_or("linear") {
            "linear" => Some(Self { from, to, scale: Scale::Linear }),
            "log" if from > 0.0 && to > 0.0 => Some(Self { from, to, scale: Scale::Log }),
            "log" => refuse("scale", "`log` needs `from` and `to` above 0".to_owned()),
            other => {
                let other: String = other.chars().take(100).collect();
                refuse("scale", format!("no scale is called `{other}`; scales are {}", listed(["linear", "log"])))
            }
        }
    }

    /// The value at a share of the way, 0–1.
    pub fn at(&self, share: f64) -> f64 {
        if share == 0.0 || share == 1.0 {
            return if share == 0.0 { self.from } else { self.to };
        }
        let value = match self.scale {
            Scale::Linear => self.from + share * (self.to - self.from),
            Scale::Log => self.from * (self.to / self.from).powf(share),
        };
        significant(value, DIGITS)
    }
}

/// A request for simulations that differ in what is varied.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// The request without what belongs to the study alone.
    base: Value,
    /// The scene of the request with every default.
    complete: Value,
}

/// Fields of a request that its simulations do not have.
const OF_THE_WHOLE: [&str; 7] = ["axes", "metric", "goal", "labels", "priority", "reuse", "keep_for_s"];

impl Variation {
    /// Of a request whose scene with every default is `complete`.
    pub fn new(request: &Value, complete: Value) -> Self {
        let mut base = request.clone();
        if let Value::Object(fields) = &mut base {
            for field in OF_THE_WHOLE {
                fields.remove(field);
            }
            fields.insert("kind".into(), JobKind::Simulation.name().into());
            let outputs = fields.entry("outputs").or_insert_with(|| Value::Object(Map::new()));
            // Outputs that are none have been refused.
            if let Value::Object(outputs) = outputs {
                outputs.insert("spectra".into(), json!([]));
            }
        }
        Self { base, complete }
    }

    /// What all simulations have in common.
    pub fn base(&self) -> &Value {
        &self.base
    }

    /// The simulation with these values.
    pub fn job<'a>(&self, values: impl Iterator<Item = (&'a Varied, Value)>) -> Result<Job, Refusal> {
        simulation_of(self.request(values)?)
    }

    /// Its scene alone, which is sooner there.
    pub fn scene<'a>(&self, values: impl Iterator<Item = (&'a Varied, Value)>) -> Result<ResolvedScene, Refusal> {
        scene_of(&self.request(values)?)
    }

    /// Length of the scene as JSON.
    pub fn bytes(&self) -> usize {
        self.base.get("scene").map_or(0, |scene| scene.to_string().len()).max(1)
    }

    /// Why nothing in the scene can be varied by this name, whatever its value is.
    pub fn refuses(&self, varied: &Varied) -> Option<String> {
        let Target::Field(tokens) = &varied.target else { return None };
        let mut scene = self.base.get("scene").cloned().unwrap_or_default();
        if let Err(detail) = set(&mut scene, &self.complete, tokens, Value::Bool(true)) {
            return Some(detail);
        }
        // No field takes this value, so that there is an error, and it is of the name or of the value.
        let error = strict::typed::<SceneInput>(&scene, "").err()?;
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
            // The rating follows from what the other axes have made of the bearing.
            let rating = dynamic_load_rating(&scene_of(&request)?.scene.bearing);
            request["scene"]["operation"]["axial_load_n"] = (share * rating).into();
        }
        Ok(request)
    }
}

/// The scene of a request.
fn scene_of(request: &Value) -> Result<ResolvedScene, Refusal> {
    let scene = request.get("scene").unwrap_or(&Value::Null);
    strict::typed::<SceneInput>(scene, "/scene")?.resolve().map_err(|errors| Refusal::Invalid { errors })
}

/// Parts of a scene that fill themselves in around a field.
const OPEN_PARTS: [&str; 3] = ["operation", "spindle", "terms"];

/// Fields that say what a part is: what else it has by default follows from them.
const SAYS_WHAT: [&str; 2] = ["kind", "law"];

/// Sets a field of a scene. Where the way to it leads through a name, or through nothing, the part stands there with its defaults,
/// as `complete` has it; of a bearing by name, and of the parts that stand open, only the field is given, so that what follows
/// from it still follows; and so it is where the field says what the part is.
fn set(scene: &mut Value, complete: &Value, tokens: &[String], value: Value) -> Result<(), String> {
    let Some((field, way)) = tokens.split_last() else { return Err("no field".to_owned()) };
    let (mut at, mut filled, mut path) = (scene, Some(complete), String::new());
    let mut is_named = true;
    for (depth, token) in way.iter().enumerate() {
        path += &format!("/{}", escape(token));
        filled = filled.and_then(|part| part.get(token));
        let Value::Object(fields) = at else { return Err(format!("`{path}` is no object")) };
        let next = fields.entry(token.as_str()).or_insert(Value::Null);
        if let Value::String(name) = next
            && depth == 0
            && token == "bearing"
        {
            *next = json!({ "preset": name });
        } else if next.is_null() && depth == 0 && OPEN_PARTS.contains(&token.as_str()) {
            *next = json!({});
        } else if !next.is_object() && !next.is_array() {
            *next =
                filled.filter(|part| part.is_object()).cloned().ok_or_else(|| format!("the scene has no `{path}`"))?;
            is_named = false;
        }
        at = next;
    }
    match at {
        Value::Object(fields) => {
            if !is_named && SAYS_WHAT.contains(&field.as_str()) {
                fields.clear();
            }
            fields.insert(field.clone(), value);
            Ok(())
        }
        Value::Array(items) => match field.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
            Some(item) => {
                *item = value;
                Ok(())
            }
            None => Err(format!("`{path}` has no item {field}")),
        },
        _ => Err(format!("`{path}` is no object")),
    }
}
