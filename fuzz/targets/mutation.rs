//! Mutations of a job as JSON. Random bytes are refused by the first check; most of these mutations reach the solver.

use std::sync::LazyLock;

use libfuzzer_sys::fuzzer_mutate;
use raceway::contract::parse_job;
use serde_json::{Map, Number, Value, json};

/// Valid jobs, with which the corpus begins.
const SEEDS: [&str; 14] = [
    include_str!("../corpus/job/accuracy.json"),
    include_str!("../corpus/job/angular.json"),
    include_str!("../corpus/job/article.json"),
    include_str!("../corpus/job/dry.json"),
    include_str!("../corpus/job/everything.json"),
    include_str!("../corpus/job/fixed-step.json"),
    include_str!("../corpus/job/optimum.json"),
    include_str!("../corpus/job/ordered.json"),
    include_str!("../corpus/job/planar.json"),
    include_str!("../corpus/job/profile.json"),
    include_str!("../corpus/job/reduced.json"),
    include_str!("../corpus/job/short.json"),
    include_str!("../corpus/job/study.json"),
    include_str!("../corpus/job/uncertainty.json"),
];

/// The values that may stand at each path of a job.
struct Library {
    jobs: Vec<Value>,
    /// Values by their path from the root, from all jobs as written and with every default.
    fields: Vec<(Vec<String>, Value)>,
    words: Vec<String>,
}

static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let mut library = Library { jobs: Vec::new(), fields: Vec::new(), words: Vec::new() };
    for seed in SEEDS {
        let job = parse_job(seed.as_bytes()).unwrap_or_else(|refusal| panic!("{refusal} in {seed}"));
        let complete = job.complete();
        let request = &job.submission().request;
        for value in [request, &complete] {
            gather(value, &mut Vec::new(), &mut library);
        }
        library.jobs.extend([request.clone(), complete]);
    }
    library.words.sort();
    library.words.dedup();
    library
});

fn gather(value: &Value, way: &mut Vec<String>, library: &mut Library) {
    if !way.is_empty() {
        library.fields.push((way.clone(), value.clone()));
    }
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                way.push(name.clone());
                gather(field, way, library);
                way.pop();
            }
        }
        Value::Array(items) => {
            for (place, item) in items.iter().enumerate() {
                way.push(place.to_string());
                gather(item, way, library);
                way.pop();
            }
        }
        Value::String(word) => library.words.push(word.clone()),
        _ => {}
    }
}

/// Numbers at which formulas reach their limits.
const NUMBERS: [f64; 22] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    0.5,
    1e-3,
    1e-6,
    1e-9,
    1e-12,
    1e-30,
    1e-300,
    5e-324,
    90.0,
    180.0,
    1e3,
    1e4,
    1e6,
    1e9,
    1e30,
    1e300,
    f64::MAX,
];
/// Factors for numbers. Most are near 1, so that the scene remains consistent.
const FACTORS: [f64; 16] =
    [1.000000001, 0.999999999, 1.001, 0.999, 1.01, 0.99, 1.1, 0.9, 1.3, 0.7, 2.0, 0.5, 10.0, 0.1, 1e3, -1.0];

/// SplitMix64.
struct Dice(u64);

impl Dice {
    fn below(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % sides.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, choices: &'a [T]) -> &'a T {
        &choices[self.below(choices.len())]
    }
}

/// The mutator that libFuzzer calls; returns the new size.
pub fn mutate(data: &mut [u8], size: usize, most: usize, seed: u32) -> usize {
    let mut dice = Dice(u64::from(seed));
    if dice.below(16) == 0 {
        return fuzzer_mutate(data, size, most);
    }
    let parsed = serde_json::from_slice(&data[..size]).ok().filter(Value::is_object);
    let mut job = parsed.unwrap_or_else(|| dice.of(&LIBRARY.jobs).clone());
    for _ in 0..[1, 1, 1, 2, 3, 6][dice.below(6)] {
        change(&mut job, &mut dice);
    }
    let text = job.to_string();
    if text.len() > most {
        return fuzzer_mutate(data, size, most);
    }
    data[..text.len()].copy_from_slice(text.as_bytes());
    text.len()
}

fn change(job: &mut Value, dice: &mut Dice) {
    match dice.below(8) {
        // Adds a field, or changes the value of one.
        0 | 1 => {
            let (way, value) = dice.of(&LIBRARY.fields).clone();
            graft(job, &way, value);
        }
        2 => {
            let count = nodes(job);
            let place = dice.below(count);
            remove(job, &mut { place }, dice);
        }
        _ => {
            let count = nodes(job);
            let place = dice.below(count);
            if let Some(node) = nth(job, &mut { place }) {
                alter(node, dice);
            }
        }
    }
}

/// Candidates that replace a node.
fn alter(node: &mut Value, dice: &mut Dice) {
    let number = |value: f64| Number::from_f64(value).map_or(Value::Null, Value::Number);
    *node = match (&*node, dice.below(32)) {
        (_, 0) => dice.of(&[json!(null), json!(true), json!([]), json!({}), json!(""), json!("x"), json!(1)]).clone(),
        (Value::Number(_), 1..5) => number(*dice.of(&NUMBERS)),
        (Value::Number(of), 5..8) => number(of.as_f64().unwrap_or(0.0).round() + dice.below(3) as f64 - 1.0),
        (Value::Number(of), _) => number(of.as_f64().unwrap_or(0.0) * dice.of(&FACTORS)),
        (Value::String(_), _) => dice.of(&LIBRARY.words).as_str().into(),
        (Value::Bool(truth), _) => (!truth).into(),
        (Value::Array(items), choice) => {
            let mut items = items.clone();
            match (items.is_empty(), choice % 3) {
                (false, 0) => items.push(items[dice.below(items.len())].clone()),
                (false, 1) => drop(items.remove(dice.below(items.len()))),
                (false, _) => items.reverse(),
                (true, _) => items.push(dice.of(&LIBRARY.fields).1.clone()),
            }
            items.into()
        }
        // Values from the same path of other jobs are inserted elsewhere; these come from other paths.
        (Value::Object(_), 1) => dice.of(&LIBRARY.fields).1.clone(),
        (same, _) => same.clone(),
    };
}

/// Sets a value and creates the objects on its path.
fn graft(job: &mut Value, way: &[String], value: Value) {
    let Some((name, rest)) = way.split_first() else {
        *job = value;
        return;
    };
    match job {
        Value::Array(items) => {
            if let Some(item) = name.parse::<usize>().ok().and_then(|place| items.get_mut(place)) {
                graft(item, rest, value);
            }
        }
        Value::Object(fields) => graft(fields.entry(name.clone()).or_insert(Value::Null), rest, value),
        other => {
            *other = Value::Object(Map::new());
            graft(other, way, value);
        }
    }
}

fn nodes(value: &Value) -> usize {
    1 + match value {
        Value::Object(fields) => fields.values().map(nodes).sum(),
        Value::Array(items) => items.iter().map(nodes).sum::<usize>(),
        _ => 0,
    }
}

/// The node at an index, counted in preorder from the root.
fn nth<'a>(value: &'a mut Value, place: &mut usize) -> Option<&'a mut Value> {
    if *place == 0 {
        return Some(value);
    }
    *place -= 1;
    match value {
        Value::Object(fields) => fields.values_mut().find_map(|field| nth(field, place)),
        Value::Array(items) => items.iter_mut().find_map(|item| nth(item, place)),
        _ => None,
    }
}

/// Removes a member of the object at or below a path.
fn remove(value: &mut Value, place: &mut usize, dice: &mut Dice) {
    if let Some(Value::Object(fields)) = nth(value, place) {
        let names: Vec<String> = fields.keys().cloned().collect();
        if !names.is_empty() {
            fields.remove(dice.of(&names));
        }
    }
}
