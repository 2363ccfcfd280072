//! Rating life, and friction moments of empirical models.

use serde_json::{Value, json};

use crate::contract::answer::life::LifeAnswer;
use crate::contract::answer::messages::MessageCode;
use crate::contract::{Outcome, Refusal, execute, parse_job, parse_scene_request, resolve_answer};
use raceway_core::simulation::input::control::Control;

/// The 6205 with the ratings of its maker under 500 N and 200 N, at a speed [r/min], with other fields of the scene.
fn scene(bearing: Value, speed: f64, fields: Value) -> Value {
    let mut bearing_fields =
        json!({"preset": "6205", "dynamic_load_rating_n": 14000, "static_load_rating_n": 7850, "f0": 13.9});
    merge(&mut bearing_fields, bearing);
    let mut scene = json!({"bearing": bearing_fields, "gravity_m_s2": 0,
        "operation": {"speed_rpm": speed, "radial_load_y_n": 500, "axial_load_n": 200}});
    merge(&mut scene, fields);
    json!({ "scene": scene })
}

fn merge(into: &mut Value, from: Value) {
    for (name, value) in from.as_object().into_iter().flatten() {
        into[name] = value.clone();
    }
}

fn derived(request: &Value) -> Value {
    let job = parse_scene_request(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{refusal}"));
    serde_json::to_value(resolve_answer(&job).unwrap().derived).unwrap()
}

fn life(request: &Value) -> LifeAnswer {
    serde_json::from_value(derived(request)["life"].clone()).unwrap()
}

fn assert_rounds(value: Option<f64>, expected: f64, half_digit: f64) {
    assert!(value.is_some_and(|value| (value - expected).abs() <= half_digit), "{value:?} instead of {expected}");
}

#[test]
fn resolve_states_the_life() {
    let oil = json!({"lubricant": {"kind": "oil", "viscosity_40_mm2_s": 46, "viscosity_100_mm2_s": 6.64, "temperature_c": 60}});
    let of = life(&scene(json!({}), 3000.0, oil));
    assert_rounds(of.e, 0.2211, 5e-5);
    assert_rounds(of.y, 1.983, 5e-4);
    assert_rounds(of.equivalent_load_n, 676.5, 0.05);
    assert_rounds(of.basic_l10h, 49_236.0, 0.5);
    assert_rounds(of.nu1_mm2_s, 13.149, 5e-4);
    assert_rounds(of.viscosity_mm2_s, 20.38, 0.01);
    assert_rounds(of.kappa, 20.38 / 13.149, 1e-3);
    assert!(of.reference_l10h_static.is_some() && of.reference_l10h_dynamic.is_none() && of.lambda.is_some());
    assert!(of.a_iso.is_none() && of.notes.is_empty(), "{:?}", of.notes);
    assert_eq!([of.dynamic_load_rating_n, of.static_load_rating_n, of.f0], [14e3, 7850.0, 13.9]);
    let modified = scene(json!({"fatigue_load_limit_n": 335}), 3000.0, json!({"contamination_factor": 0.5}));
    assert!(life(&modified).a_iso.is_some_and(|factor| factor > 1.0));
}

/// Ratings for the life leave the table's rating and the hash of the motion's numbers alone.
#[test]
fn ratings_are_for_the_life_only() {
    let of = derived(&scene(json!({"dynamic_load_rating_n": 20000}), 3000.0, json!({})));
    assert!((of["dynamic_load_rating_n"].as_f64().unwrap() / 14e3 - 1.0).abs() < 0.01, "{of}");
    assert!((of["axial_load_over_rating"].as_f64().unwrap() / (200.0 / 14e3) - 1.0).abs() < 0.01);
    assert_eq!(of["life"]["dynamic_load_rating_n"], 20000.0);
}

#[test]
fn notes_say_what_is_absent() {
    let has = |of: &LifeAnswer, part: &str| of.notes.iter().any(|note| note.contains(part));
    let still = life(&scene(json!({}), 0.0, json!({})));
    assert!(still.basic_l10h.is_none() && still.equivalent_load_n.is_some() && has(&still, "do not turn"), "{still:?}");
    let radial = json!({"operation": {"speed_rpm": 3000, "radial_load_y_n": 1000, "axial_load_n": 50}});
    let radial = life(&scene(json!({}), 3000.0, radial));
    assert!(has(&radial, "does not exceed e") && radial.equivalent_load_n == Some(1000.0) && radial.x.is_none());
    let heavy = json!({"operation": {"speed_rpm": 3000, "radial_load_y_n": 8000}});
    assert!(has(&life(&scene(json!({}), 3000.0, heavy)), "exceeds half"));
    let dirty = life(&scene(json!({}), 3000.0, json!({"contamination_factor": 0.1})));
    assert!(dirty.a_iso.is_none() && has(&dirty, "bearing.fatigue_load_limit_n"));
    let preloaded = json!({"operation": {"speed_rpm": 3000}});
    let preloaded = life(&scene(json!({"radial_clearance_um": -10}), 3000.0, preloaded));
    assert!(preloaded.basic_l10h.is_none() && preloaded.reference_l10h_static.is_some() && has(&preloaded, "no load"));
}

#[test]
fn fields_of_the_life_have_limits() {
    let request = scene(
        json!({"dynamic_load_rating_n": 0, "f0": 0.5, "raceway_roughness_um": 0, "fatigue_load_limit_n": -1}),
        3000.0,
        json!({"contamination_factor": 1.5}),
    );
    let Err(Refusal::Invalid { errors }) = parse_scene_request(request.to_string().as_bytes()) else { panic!() };
    let mut pointers: Vec<_> = errors.iter().map(|error| error.pointer.as_str()).collect();
    pointers.sort_unstable();
    let expected = [
        "bearing/dynamic_load_rating_n",
        "bearing/f0",
        "bearing/fatigue_load_limit_n",
        "bearing/raceway_roughness_um",
        "contamination_factor",
    ];
    assert_eq!(pointers, expected.map(|field| format!("/scene/{field}")));
    assert!(errors.iter().any(|error| error.detail == "1.5: must be from 1e-6 to 1"), "{errors:?}");
}

/// SKF's model and Palmgren's beside the scene; the series is that of the designation.
#[test]
fn empirical_moments_stand_beside() {
    let oil = json!({"lubricant": {"kind": "oil", "viscosity_40_mm2_s": 20, "viscosity_100_mm2_s": 4, "temperature_c": 40},
        "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}});
    let reference = derived(&scene(json!({}), 3000.0, oil.clone()))["friction_reference"].clone();
    let number = |field: &str| reference[field].as_f64();
    assert_rounds(number("skf_rolling_n_mm"), 9.83, 5e-3);
    assert_rounds(number("skf_sliding_n_mm"), 1.99, 5e-3);
    assert_rounds(number("palmgren_viscous_n_mm"), 17.5, 0.05);
    let mut nameless = scene(json!({}), 3000.0, oil);
    let resolved = parse_scene_request(nameless.to_string().as_bytes()).unwrap();
    nameless["scene"] = resolve_answer(&resolved).unwrap().scene;
    let reference = derived(&nameless)["friction_reference"].clone();
    assert!(reference["skf_rolling_n_mm"].is_null() && reference["palmgren_load_n_mm"].is_array(), "{reference}");
    assert!(derived(&scene(json!({}), 0.0, json!({})))["friction_reference"].is_null());
}

/// A run under a load that stands: the dynamic life is near the static one, and parts of the torque add up.
#[test]
fn a_run_states_life_and_torque() {
    let mut request = scene(json!({}), 3000.0, json!({}));
    merge(
        &mut request,
        json!({"kind": "simulation", "settle_s": 0.02, "duration_s": 0.05, "solver": {"rung": "full"},
            "outputs": {"metrics": ["vibration", "life", "friction"], "spectra": []}}),
    );
    let job = parse_job(request.to_string().as_bytes()).unwrap();
    let Ok(Outcome::Simulation(outcome)) = execute(&job, &Control::until(&|| false)) else { panic!("the run failed") };
    let metrics = serde_json::to_value(&outcome.metrics).unwrap();
    let number =
        |pointer: &str| metrics.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer}"));
    let ratio = number("/life/reference_l10h_dynamic") / number("/life/reference_l10h_static");
    assert!((0.5..2.0).contains(&ratio), "{ratio}");
    let places = ["inner/sliding", "inner/rolling", "inner/normal", "outer/sliding", "outer/rolling", "outer/normal"];
    let others = ["pockets", "neighbours", "land", "drag", "churning"];
    let sum: f64 = places.iter().chain(&others).map(|place| number(&format!("/friction/{place}_n_mm"))).sum();
    let total = number("/friction/total_n_mm");
    assert!(total > 0.0 && (sum / total - 1.0).abs() < 1e-12, "{sum} {total}");
    assert!(number("/friction/gap_n_mm").abs() < 1e-3 * number("/friction/drive_n_mm"), "{}", metrics["friction"]);
    let speed = 3000.0 * std::f64::consts::PI / 30.0;
    assert!((number("/friction/power_loss_w") / (1e-3 * total * speed) - 1.0).abs() < 1e-9);
}

/// The simulated torque beside SKF's model: within a factor 2, and larger under each larger load.
#[test]
fn the_torque_of_the_6205_is_near_the_empirical_one() {
    let oil = json!({"lubricant": {"kind": "oil", "viscosity_pa_s": 0.018}});
    let torque = |radial: f64, axial: f64, expected: f64| {
        let mut request = scene(json!({}), 3000.0, oil.clone());
        request["scene"]["operation"] = json!({"speed_rpm": 3000, "radial_load_y_n": radial, "axial_load_n": axial});
        let run = json!({"kind": "simulation", "duration_s": 0.02, "settle_s": 0.02, "solver": {"rung": "full"},
            "outputs": {"metrics": ["friction"], "spectra": []}});
        merge(&mut request, run);
        let job = parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{refusal}"));
        let Ok(Outcome::Simulation(outcome)) = execute(&job, &Control::until(&|| false)) else {
            panic!("the run failed")
        };
        let metrics = serde_json::to_value(&outcome.metrics).unwrap();
        let number = |field: &str| metrics["friction"][field].as_f64().unwrap();
        let reference = |field: &str| metrics["friction"]["reference"][field].as_f64().unwrap();
        let skf = reference("skf_rolling_n_mm") + reference("skf_sliding_n_mm");
        assert!((skf / expected - 1.0).abs() < 3e-3, "{skf} instead of {expected}");
        let total = number("total_n_mm");
        assert!((0.5..2.0).contains(&(total / skf)), "{radial} N, {axial} N: {total} beside {skf} N mm");
        total
    };
    let light = torque(500.0, 0.0, 11.82);
    assert!(torque(1000.0, 0.0, 20.61) > light);
    assert!(torque(500.0, 200.0, 27.61) > light);
}

/// The film's resistance is most of the torque in grease, too. A vibration alone leaves it out, as the article does.
#[test]
fn grease_has_the_torque_of_its_film() {
    let job = |metrics: Value| {
        let mut request = scene(
            json!({}),
            3000.0,
            json!({"lubricant": {"kind": "grease", "viscosity_grade": "iso-vg-100", "temperature_c": 60}}),
        );
        let short = json!({"kind": "simulation", "duration_s": 0.02, "settle_s": 0, "outputs": {"metrics": metrics, "spectra": []}});
        merge(&mut request, short);
        parse_job(request.to_string().as_bytes()).unwrap()
    };
    let omitted = |metrics: Value| {
        let job = job(metrics);
        let answer = crate::contract::resolve_answer(&job).unwrap();
        answer.left_out.iter().any(|term| term.term == "hydrodynamics")
    };
    assert!(omitted(json!(["vibration"])) && !omitted(json!(["vibration", "friction"])));
    let says_so = |metrics: Value| {
        let job = job(metrics);
        let Ok(Outcome::Simulation(outcome)) = execute(&job, &Control::until(&|| false)) else {
            panic!("the run failed")
        };
        outcome.metrics.messages.iter().any(|message| message.code == MessageCode::FrictionAddsForces)
    };
    assert!(says_so(json!(["vibration", "friction"])) && !says_so(json!(["vibration"])));
}
