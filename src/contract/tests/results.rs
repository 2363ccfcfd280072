//! Resolving and running.

use serde_json::{Value, json};

use crate::contract::{Outcome, RunFailure, SpectrumKind, execute, parse_job, parse_scene_request, resolve_answer};
use crate::simulation::run::Control;

fn article() -> Value {
    json!({"kind": "simulation", "settle_s": 0.001, "duration_s": 0.004,
        "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}},
        "outputs": {"series": ["cage.y.displacement"]}})
}

/// Stiffnesses, frequencies and clearance of the article's case (the model's table).
#[test]
fn the_article_resolves_to_its_numbers() {
    let job = parse_scene_request(article().to_string().as_bytes()).unwrap();
    let answer = resolve_answer(&job);
    let derived = &answer.derived;
    assert!((derived.inner_stiffness_n_per_m1_5 / 1.399e10 - 1.0).abs() < 1e-3);
    assert!((derived.outer_stiffness_n_per_m1_5 / 1.492e10 - 1.0).abs() < 1e-3);
    assert!((derived.frequencies_hz.ball_pass_outer - 2293.4).abs() < 0.1);
    assert!((derived.radial_clearance_um - 5.0).abs() < 1e-12);
    assert!((derived.dynamic_load_rating_n - 1786.0).abs() < 5.0, "{derived:?}");
    let at_rest = derived.at_rest.as_ref().unwrap();
    assert!((120.0..150.0).contains(&at_rest.max_ball_load_n), "{at_rest:?}");
    assert!(answer.left_out.iter().any(|left_out| left_out.term == "hydrodynamics"));
    assert!(answer.defaults.iter().any(|pointer| pointer == "/scene/spindle/mass_kg"));
    assert_eq!(answer.cost.states, 7 * 9 + 12 + 4);
    let json = serde_json::to_value(&answer).unwrap();
    assert!(json["derived"]["static"]["ball_loads_n"].as_array().is_some_and(|loads| loads.len() == 7));
}

#[test]
fn a_short_run_gives_what_was_asked_for() {
    let mut request = article();
    request["outputs"]["metrics"] = json!(["vibration"]);
    let job = parse_job(request.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(outcome)) = execute(&job, &Control { stop: &|| false, progress: &|_| () }) else {
        panic!("the run failed")
    };
    let metrics = serde_json::to_value(&outcome.metrics).unwrap();
    assert!(metrics["channels"]["spindle.y.acceleration"]["level_db"].is_f64());
    for absent in ["contacts", "kinematics", "cage"] {
        assert!(metrics.get(absent).is_none(), "{absent}");
    }
    assert_eq!(metrics["solver"]["rung"], "full");
    let kinds: Vec<_> = outcome.spectra.iter().map(|spectrum| spectrum.kind).collect();
    assert_eq!(kinds, [SpectrumKind::Amplitude, SpectrumKind::Envelope].repeat(2));
    assert_eq!(outcome.series.len(), 1);
    assert_eq!(outcome.series[0].value.len(), outcome.series[0].time_s.len());
}

#[test]
fn extremes_run() {
    for request in [
        json!({"kind": "simulation", "duration_s": 1e-6, "settle_s": 0, "scene": {"bearing": "608", "operation": {"speed_rpm": 1000}}}),
        json!({"kind": "simulation", "duration_s": 0.002, "settle_s": 0, "scene": {"bearing": "608", "operation": {"speed_rpm": 0}}}),
        json!({"kind": "simulation", "duration_s": 0.002, "settle_s": 0, "scene": {"bearing": "608", "gravity_m_s2": 0, "operation": {"speed_rpm": 0}}}),
    ] {
        let job = parse_job(request.to_string().as_bytes()).unwrap();
        let outcome = execute(&job, &Control { stop: &|| false, progress: &|_| () });
        assert!(outcome.is_ok(), "{request}: {:?}", outcome.err());
    }
}

#[test]
fn a_stopped_run_is_cancelled() {
    let job = parse_job(article().to_string().as_bytes()).unwrap();
    let failure = execute(&job, &Control { stop: &|| true, progress: &|_| () });
    assert_eq!(failure.err(), Some(RunFailure::Cancelled));
}

/// Whatever number is put into whatever field, it is refused or every number of the answer is finite.
#[test]
fn absurd_numbers_never_reach_an_answer() {
    let body = br#"{"scene":{"bearing":"608","operation":{"speed_rpm":20000,"radial_load_y_n":100}}}"#;
    let scene = parse_scene_request(body).unwrap().scene_json();
    let mut pointers = Vec::new();
    number_pointers(&scene, String::new(), &mut pointers);
    assert!(pointers.len() > 40);
    for pointer in &pointers {
        for value in [1e-300, 1e-9, 0.0, 0.7, 1e3, 1e9, 1e300, -1e-300, -1.0] {
            let mut scene = scene.clone();
            *scene.pointer_mut(pointer).unwrap() = json!(value);
            let body = json!({"scene": scene}).to_string();
            let Ok(job) = parse_scene_request(body.as_bytes()) else { continue };
            let answer = serde_json::to_string(&resolve_answer(&job)).unwrap();
            assert!(!answer.contains("null"), "{pointer} {value}: {answer}");
        }
    }
}

fn number_pointers(value: &Value, pointer: String, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(pointer),
        Value::Object(fields) => {
            fields.iter().for_each(|(key, field)| number_pointers(field, format!("{pointer}/{key}"), found));
        }
        _ => {}
    }
}
