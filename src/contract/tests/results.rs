//! Resolving and running.

use serde_json::{Value, json};

use crate::contract::{Outcome, RunFailure, SpectrumKind, execute, parse_job, parse_scene_request, resolve_answer};
use raceway_core::simulation::input::control::Control;

fn article() -> Value {
    json!({"kind": "simulation", "settle_s": 0.001, "duration_s": 0.004,
        "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}},
        "outputs": {"series": ["cage.y.displacement"]}})
}

/// Stiffnesses, frequencies and clearance of the article's case (the model's table).
#[test]
fn the_article_resolves_to_its_numbers() {
    let job = parse_scene_request(article().to_string().as_bytes()).unwrap();
    let answer = resolve_answer(&job).unwrap();
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
    let Ok(Outcome::Simulation(outcome)) = execute(&job, &Control::until(&|| false)) else { panic!("the run failed") };
    let metrics = serde_json::to_value(&outcome.metrics).unwrap();
    assert!(metrics["channels"]["spindle.y.acceleration"]["level_db"].is_f64());
    for absent in ["contacts", "kinematics", "cage"] {
        assert!(metrics.get(absent).is_none(), "{absent}");
    }
    assert_eq!(metrics["solver"]["rung"], "full");
    let kinds: Vec<_> = outcome.spectra.iter().map(|spectrum| spectrum.kind).collect();
    assert_eq!(kinds, [SpectrumKind::Amplitude, SpectrumKind::Envelope].repeat(2));
    assert_eq!(outcome.series.len(), 1);
    let series = &outcome.series[0];
    assert_eq!((series.length, series.values.len(), series.is_finite), (410, 410, true));
}

/// Whatever spectra are asked for, their lines are named, in their units.
#[test]
fn every_spectrum_has_its_lines() {
    let mut request = article();
    request["duration_s"] = json!(0.02);
    request["scene"]["spindle"] = json!({ "balance_grade": 6.3 });
    request["outputs"] = json!({ "spectra": ["spindle.y.velocity", "ball.1.inner.load"] });
    let job = parse_job(request.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(outcome)) = execute(&job, &Control::until(&|| false)) else { panic!("the run failed") };
    let lines = outcome.metrics.lines.as_ref().unwrap();
    let of = |channel: &str| lines.iter().filter(|line| line.channel == channel).collect::<Vec<_>>();
    let velocity = of("spindle.y.velocity");
    assert!(velocity.iter().any(|line| line.label.contains("BPFO") || line.label.contains("f_r")), "{velocity:?}");
    let spectrum = outcome.spectra.iter().find(|s| s.channel == "spindle.y.velocity" && s.is_amplitude()).unwrap();
    let largest = spectrum.amplitude.iter().copied().fold(0.0, f64::max);
    assert!((velocity[0].amplitude / largest - 1.0).abs() < 0.2, "{} {largest} mm/s", velocity[0].amplitude);
    assert!(!of("ball.1.inner.load").is_empty() && of("spindle.y.acceleration").is_empty(), "{lines:?}");
    let svg =
        crate::plots::draw::pictures(&outcome, false).into_iter().find(|(name, _)| *name == "spectrum.svg").unwrap().1;
    assert!(svg.contains(&velocity[0].label), "the picture names them");
}

#[test]
fn an_accuracy_job_compares_methods_with_a_reference() {
    let request = json!({"kind": "accuracy", "settle_s": 0.002, "duration_s": 0.003, "repetitions": 3,
        "methods": ["dormand_prince", "auto"], "relative_tolerances": [1e-6, 1e-3],
        "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}});
    let job = parse_job(request.to_string().as_bytes()).unwrap();
    let shares = std::cell::RefCell::new(vec![0.0]);
    let progress = |share: f64| shares.borrow_mut().push(share);
    let outcome = execute(&job, &Control { progress: &progress, ..Control::until(&|| false) });
    let Ok(Outcome::Accuracy(answer)) = outcome else { panic!("{outcome:?}") };
    assert!(shares.borrow().is_sorted() && shares.borrow().last() > Some(&0.9), "{:?}", shares.borrow().last());
    let answer = serde_json::to_value(&answer).unwrap();
    let points = answer["points"].as_array().unwrap();
    let order: Vec<_> =
        points.iter().map(|p| (p["method"].as_str().unwrap(), p["relative_tolerance"].as_f64().unwrap())).collect();
    assert_eq!(order, [("dormand_prince", 1e-3), ("dormand_prince", 1e-6), ("auto", 1e-3), ("auto", 1e-6)]);
    let number = |value: &Value, field: &str| value[field].as_f64().unwrap_or_else(|| panic!("{field}: {value}"));
    for point in points {
        assert_eq!(point["status"], "succeeded", "{point}");
        let range = point["wall_time_range_s"].as_array().unwrap();
        assert!(
            range[0].as_f64() <= point["wall_time_s"].as_f64() && range[1].as_f64() >= point["wall_time_s"].as_f64()
        );
        assert!(number(point, "trajectory_error") <= number(point, "largest_error"));
        assert!(number(point, "steps") > 0.0 && number(point, "mean_step_s") > 0.0);
    }
    let (loose, tight) = (&points[0], &points[1]);
    for field in ["trajectory_error", "level_error_db", "line_amplitude_error", "line_frequency_error_hz"] {
        assert!(number(tight, field) < 0.1 * number(loose, field), "{field}: {loose} {tight}");
    }
    let ratio = number(loose, "trajectory_error") / 1e-3;
    assert!((number(loose, "error_over_tolerance") / ratio - 1.0).abs() < 1e-12);
    let own = number(&answer["reference"], "own_trajectory_error");
    assert!(own > 0.0 && 10.0 * own < number(tight, "trajectory_error"), "{own}");
    assert_eq!(
        (&tight["below_reference"], answer["reference"]["lines"].as_array().map(|l| l.len() > 1)),
        (&json!(false), Some(true))
    );
    for pointer in [
        "/reference/levels_db/spindle.y.acceleration",
        "/compared/quantity",
        "/timing/inside",
        "/machine/compiler",
        "/repeat/job/methods",
    ] {
        assert!(answer.pointer(pointer).is_some_and(|value| !value.is_null()), "{pointer}");
    }
}

#[test]
fn an_accuracy_job_costs_more_than_a_run() {
    let mut request = json!({"kind": "simulation", "settle_s": 0.02, "duration_s": 0.02,
        "scene": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}}});
    let resolved =
        |request: &Value| resolve_answer(&parse_scene_request(request.to_string().as_bytes()).unwrap()).unwrap();
    let one = resolved(&request);
    request["kind"] = json!("accuracy");
    let many = resolved(&request);
    assert!(many.cost.estimated_wall_time_s.unwrap() > 10.0 * one.cost.estimated_wall_time_s.unwrap());
    assert_eq!((one.methods, many.methods.map(|methods| methods.len())), (None, Some(5)));
    assert!(many.defaults.iter().any(|pointer| pointer == "/relative_tolerances"));
    assert!(many.solver.get("method").is_none() && many.outputs.get("spectra").is_none());
}

#[test]
fn extremes_run() {
    for request in [
        json!({"kind": "simulation", "duration_s": 1e-6, "settle_s": 0, "scene": {"bearing": "608", "operation": {"speed_rpm": 1000}}}),
        json!({"kind": "simulation", "duration_s": 0.002, "settle_s": 0, "scene": {"bearing": "608", "operation": {"speed_rpm": 0}}}),
        json!({"kind": "simulation", "duration_s": 0.002, "settle_s": 0, "scene": {"bearing": "608", "gravity_m_s2": 0, "operation": {"speed_rpm": 0}}}),
    ] {
        let job = parse_job(request.to_string().as_bytes()).unwrap();
        let outcome = execute(&job, &Control::until(&|| false));
        assert!(outcome.is_ok(), "{request}: {:?}", outcome.err());
    }
}

#[test]
fn a_stopped_run_is_cancelled() {
    let job = parse_job(article().to_string().as_bytes()).unwrap();
    let failure = execute(&job, &Control::until(&|| true));
    assert_eq!(failure.err(), Some(RunFailure::Cancelled));
    // In each part of a study: settling, reference, points.
    for share in [0.0, 0.2, 0.5] {
        let mut request = article();
        request["kind"] = json!("accuracy");
        request["outputs"] = json!({});
        let job = parse_job(request.to_string().as_bytes()).unwrap();
        let reached = std::cell::Cell::new(0.0);
        let stop = || reached.get() >= share;
        let failure = execute(&job, &Control { progress: &|share| reached.set(share), ..Control::until(&stop) });
        assert_eq!(failure.err(), Some(RunFailure::Cancelled), "{share}");
        assert!(reached.get() < share + 0.2, "{share}: {}", reached.get());
    }
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
            let answer = serde_json::to_string(&resolve_answer(&job).unwrap()).unwrap();
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

/// Three balls without a cage gather on one side. The raceways of a 6206 touch at d + P_d/2 = 9.531 mm.
#[test]
fn a_spindle_that_leaves_the_bearing_is_a_cause_of_its_own() {
    let request = json!({"kind": "simulation", "settle_s": 0.2, "duration_s": 0.1, "scene": {
        "bearing": {"preset": "6206", "ball_count": 3}, "terms": {"cage": "off"},
        "operation": {"speed_rpm": 600, "radial_load_y_n": 500}}});
    let job = parse_job(request.to_string().as_bytes()).unwrap();
    let Err(RunFailure::Failed { cause, detail }) = execute(&job, &Control::until(&|| false)) else {
        panic!("no failure")
    };
    assert_eq!(cause, "spindle-left-bearing");
    assert!(detail.contains("at t = 0.147") && detail.contains("radially by 9.531 mm"), "{detail}");
}
