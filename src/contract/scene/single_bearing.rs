//! A scene with a list of one bearing, as the scene of that bearing alone.
//!
//! The bearing stands at the mass centre of a rigid spindle. Its fields move to those of the scene, so that both forms are the same work.

use serde_json::{Map, Value};

use crate::contract::json::numbers::short;
use crate::contract::json::problem::{FieldError, Refusal};

const SHAFT: &str = "/scene/shaft";
const LIST: &str = "/scene/bearings";
const ITEM: &str = "/scene/bearings/0";
/// Fields of the item that a scene of one bearing has, too.
const OF_SCENE: [&str; 4] = ["bearing", "lubricant", "damping", "surfaces"];

/// A request, and the fields of its scene that were given in the list.
struct Unfolded {
    request: Value,
    moved: Vec<&'static str>,
}

/// Checks a request by `job`, with the one bearing of a list as that of the scene. Pointers of errors are those of the request.
pub fn with_single_bearing<J>(request: Value, job: impl FnOnce(Value) -> Result<J, Refusal>) -> Result<J, Refusal> {
    if request.pointer(SHAFT).is_some() {
        let detail = "this kind of job has one bearing on a rigid spindle; submit a job of kind `machine` or `rotor` for each shaft";
        return Err(FieldError::new(SHAFT, detail).into());
    }
    if request.pointer(LIST).is_none() {
        return job(request);
    }
    let Unfolded { request, moved } = unfolded(request).map_err(|errors| Refusal::Invalid { errors })?;
    job(request).map_err(|refusal| refusal.map_errors(|error| in_list(error, &moved)))
}

/// The pointer of an error in the request as it was given.
fn in_list(error: FieldError, moved: &[&str]) -> FieldError {
    let of_field = |field: &&&str| {
        let rest = error.pointer.strip_prefix("/scene/")?.strip_prefix(**field)?;
        (rest.is_empty() || rest.starts_with('/')).then(|| format!("{ITEM}/{field}{rest}"))
    };
    match moved.iter().find_map(|field| of_field(&field)) {
        Some(pointer) => FieldError { pointer, ..error },
        None => error,
    }
}

fn unfolded(mut request: Value) -> Result<Unfolded, Vec<FieldError>> {
    let refuse = |pointer: &str, detail: String| Err(vec![FieldError::new(pointer, detail)]);
    let scene = request.get_mut("scene").and_then(Value::as_object_mut);
    let Some(scene) = scene else { return Ok(Unfolded { request, moved: Vec::new() }) };
    if scene.contains_key("bearing") {
        return refuse(LIST, "give either `bearing` or `bearings`".to_owned());
    }
    let item = match scene.remove("bearings") {
        Some(Value::Array(mut list)) if list.len() == 1 => list.remove(0),
        Some(Value::Array(list)) => {
            let detail =
                format!("{} bearings: this kind of job has one; give `kind` `machine` for several", list.len());
            return refuse(LIST, detail);
        }
        _ => return refuse(LIST, "expected an array".to_owned()),
    };
    let Value::Object(mut item) = item else { return refuse(ITEM, "expected an object".to_owned()) };
    let mut errors = errors_of_place(&item, scene.get("spindle"));
    if let Some(Value::Object(spindle)) = scene.get_mut("spindle") {
        spindle.remove("centre_mm");
    }
    let mut moved = Vec::new();
    for field in OF_SCENE {
        let Some(value) = item.remove(field) else { continue };
        if scene.contains_key(field) {
            errors.push(FieldError::new(format!("{ITEM}/{field}"), format!("the scene has `{field}`, too: give one")));
        }
        scene.insert(field.to_owned(), value);
        moved.push(field);
    }
    if !moved.contains(&"bearing") {
        errors.push(FieldError::new(format!("{ITEM}/bearing"), "required, but missing"));
    }
    for field in item.keys().filter(|field| !OF_PLACE.contains(&field.as_str())) {
        errors.push(FieldError::new(format!("{ITEM}/{field}"), "unknown field"));
    }
    if errors.is_empty() { Ok(Unfolded { request, moved }) } else { Err(errors) }
}

/// Fields of the item that place a bearing on a spindle.
const OF_PLACE: [&str; 5] = ["name", "at_mm", "faces", "start_azimuth_deg", "outer_ring"];

/// Errors of a bearing that does not stand at the mass centre as a bearing alone does.
fn errors_of_place(item: &Map<String, Value>, spindle: Option<&Value>) -> Vec<FieldError> {
    let mut errors = Vec::new();
    let mut refuse = |field: &str, detail: String| errors.push(FieldError::new(format!("{ITEM}/{field}"), detail));
    let for_machine = "a job of kind `machine` takes it";
    if item.get("name").is_some_and(|name| !name.is_string()) {
        refuse("name", "expected a string".to_owned());
    }
    let place = item.get("at_mm").map(Value::as_f64);
    if place == Some(None) {
        refuse("at_mm", "expected a number".to_owned());
    }
    let centre = spindle.and_then(|spindle| spindle.get("centre_mm")).and_then(Value::as_f64);
    if let Some(centre) = centre.filter(|centre| place.flatten().unwrap_or_default() != *centre) {
        let detail = format!("must be {} mm, the mass centre of the spindle; {for_machine} elsewhere", short(centre));
        refuse("at_mm", detail);
    }
    if item.get("faces").is_some_and(|faces| faces != "+x") {
        refuse("faces", format!("must be `+x`, as of a bearing alone; {for_machine} as `-x`"));
    }
    if item.get("start_azimuth_deg").is_some_and(|azimuth| azimuth.as_f64() != Some(0.0)) {
        refuse("start_azimuth_deg", format!("must be 0 °, as of a bearing alone; {for_machine}"));
    }
    if item.get("outer_ring").is_some_and(|ring| !stands_centred(ring)) {
        refuse("outer_ring", format!("must be `rigid` without offset and tilt, as of a bearing alone; {for_machine}"));
    }
    errors
}

/// Returns true for an outer ring that is held at its place.
fn stands_centred(ring: &Value) -> bool {
    let are_zero = |values: &Value| {
        values.as_object().is_some_and(|values| values.values().all(|value| value.as_f64() == Some(0.0)))
    };
    let is_centred = |(field, value): (&String, &Value)| match field.as_str() {
        "seat" => value == "rigid",
        "offset_um" | "tilt_mrad" => are_zero(value),
        _ => false,
    };
    ring.as_object().is_some_and(|ring| ring.iter().all(is_centred))
}
