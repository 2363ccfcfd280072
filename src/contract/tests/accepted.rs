//! Good requests: extremes, defaults, and the way back from the resolved scene.

use serde_json::{Value, json};

use crate::contract::job::comparison::Comparison;
use crate::contract::{
    Job, JobKind, Simulation, parse_accuracy_request, parse_job, parse_job_or_scene, parse_scene_request,
    presets_answer, scene_from_json,
};
use raceway_core::physics::bearing::Fit;
use raceway_core::physics::cage::PocketFilm;
use raceway_core::physics::presets;
use raceway_core::physics::spindle::{AxialHold, Unbalance};

/// Data that all runs of the job share.
fn base(request: &Value) -> Simulation {
    job(request).base().unwrap().clone()
}

fn job(request: &Value) -> Job {
    parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{request}: {refusal}"))
}

fn article(operation: Value) -> Value {
    json!({"kind": "simulation", "scene": {"bearing": "article-integrated", "operation": operation}})
}

/// A speed and a load that change after the record leave the model levels of constant ones.
#[test]
fn changes_after_the_record_do_not_count() {
    let operation = json!({
        "speed_rpm": [{"at_s": 100, "rpm": 6000}, {"at_s": 200, "rpm": 50000}],
        "radial_load_y_n": 200,
        "loads": [{"direction": "y", "points": [{"at_s": 0, "n": 0}, {"at_s": 50, "n": 0}, {"at_s": 60, "n": 9}]}],
    });
    let times = |mut request: Value| {
        (request["settle_s"], request["duration_s"]) = (json!(0.02), json!(0.1));
        request
    };
    let levels = |operation| base(&times(article(operation))).model_levels;
    assert!(levels(operation.clone()).len() > 1);
    assert_eq!(levels(operation), levels(json!({"speed_rpm": 6000, "radial_load_y_n": 200})));
}

#[test]
fn extremes_are_accepted() {
    for operation in [
        json!({"speed_rpm": 0}),
        json!({"speed_rpm": 50000}),
        json!({"speed_rpm": -50000, "radial_load_y_n": -200}),
        json!({"speed_rpm": 500000}),
        json!({"speed_rpm": -0.0}),
        json!({"speed_rpm": [{"at_s": 0, "rpm": 0}, {"at_s": 0.1, "rpm": 50000}]}),
        json!({"speed_rpm": 50000, "axial_load_n": -20}),
    ] {
        job(&article(operation));
    }
    for clearance in [0.0, -3.0] {
        let bearing = json!({"preset": "article-integrated", "radial_clearance_um": clearance});
        let job = job(&json!({"kind": "simulation", "scene": {"bearing": bearing, "operation": {"speed_rpm": 1}}}));
        assert_eq!(job.scene().unwrap().bearing.free_contact_angle, 0.0);
    }
}

/// The article's case in SI (the model's table of the article's case).
#[test]
fn the_article_is_what_its_tables_say() {
    let job = job(&article(json!({"speed_rpm": 50000, "radial_load_y_n": 200})));
    let scene = job.scene().unwrap();
    let bearing = &scene.bearing.parameters;
    assert_eq!((bearing.ball_count, bearing.ball_diameter, bearing.pitch_diameter), (7, 2.778e-3, 13e-3));
    assert_eq!(bearing.fit, Fit::RadialClearance(5e-6));
    assert_eq!(bearing.raceway_material.inner.elastic_modulus, 219e9);
    assert!((scene.cage.mass - 0.13e-3).abs() < 1e-18);
    assert_eq!((scene.cage.axial_inertia, scene.cage.offset), (5.5e-9, 0.7e-3));
    assert_eq!((scene.cage.pocket_clearance, scene.cage.film), (0.051e-3, PocketFilm::Wedge));
    assert_eq!((scene.spindle.mass, scene.spindle.axial), (0.05, AxialHold::Fixed));
    assert_eq!(scene.spindle.unbalance, Unbalance::None);
    assert_eq!((scene.lubricant.viscosity, scene.lubricant.fill), (0.02, 0.05));
    assert_eq!(scene.operation.load, [0.0, 200.0, 0.0]);
    assert!((scene.operating_speed() - 5_235.987_755_98).abs() < 1e-6);
    let (settings, submission) = (&job.base().unwrap().settings, job.submission());
    assert_eq!((settings.settle, settings.duration), (0.02, 0.1));
    assert_eq!((settings.relative_tolerance, settings.tightened), (1e-3, Some(1e-5)));
    assert_eq!(settings.model_tolerance_db, 0.05);
    assert_eq!((submission.priority, submission.reuse, settings.outputs.spectra.len()), (2, true, 2));
}

/// As loose as the level allows only where the run may choose, and nothing asks for every value.
#[test]
fn a_tolerance_left_out_is_chosen_for_levels() {
    let of = |solver: Value, outputs: Value| {
        let mut request = article(json!({"speed_rpm": 50000}));
        (request["solver"], request["outputs"]) = (solver, outputs);
        let settings = base(&request).settings;
        (settings.relative_tolerance, settings.tightened)
    };
    assert_eq!(of(json!({"rung": "full"}), json!({})), (1e-3, Some(1e-5)));
    assert_eq!(of(json!({"relative_tolerance": 1e-4}), json!({})), (1e-4, None));
    assert_eq!(of(json!({"method": "gear"}), json!({})), (1e-5, None));
    assert_eq!(of(json!({"model_tolerance_db": 0}), json!({})), (1e-5, None));
    assert_eq!(of(json!({}), json!({"series": ["spindle.y.acceleration"]})), (1e-5, None));
}

#[test]
fn times_follow_the_cage() {
    let loaded = |rpm: f64| base(&article(json!({"speed_rpm": rpm, "radial_load_y_n": 200})));
    let slow = loaded(600.0);
    assert!((slow.settings.settle - 3.0 / (10.0 * 0.393_154)).abs() < 1e-3);
    assert!((slow.settings.duration - 20.0 / (7.0 * 10.0 * 0.393_154)).abs() < 1e-3);
    let crawling = loaded(1.0);
    assert_eq!((crawling.settings.settle, crawling.settings.duration), (1.0, 1.0));
    let still = loaded(0.0);
    assert_eq!((still.settings.settle, still.settings.duration), (0.02, 0.1));
    // A speed that changes is followed to its last point.
    let up_to = |at_s: f64| {
        let points = json!([{ "at_s": 0, "rpm": 0 }, { "at_s": at_s, "rpm": 30_000 }]);
        let settings = base(&article(json!({ "speed_rpm": points, "radial_load_y_n": 200 }))).settings;
        settings.settle + settings.duration
    };
    assert!((up_to(1.0) - 1.0).abs() < 1e-5 && (up_to(0.01) - 0.12).abs() < 1e-5 && up_to(100.0) < 11.0);
}

/// Its own weight alone hardly damps a spindle; at changing speed the time would leave out what is asked for.
#[test]
fn a_lightly_loaded_spindle_is_given_time_to_settle() {
    let settle = |speed: Value| base(&article(json!({"speed_rpm": speed}))).settings.settle;
    let light = settle(json!(50_000));
    assert!((0.1..=5.0).contains(&light), "{light}");
    assert!(settle(json!([{"at_s": 0, "rpm": 50_000}, {"at_s": 1, "rpm": 40_000}])) < light);
}

#[test]
fn defaults_follow_what_is_given() {
    let scene = |fields: Value| {
        let mut scene = json!({"bearing": "608", "operation": {"speed_rpm": 1000}});
        scene.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        scene_from_json(&scene.to_string()).unwrap()
    };
    assert_eq!(scene(json!({"lubricant": "dry"})).cage.film, PocketFilm::None);
    assert_eq!(scene(json!({"operation": {"speed_rpm": 1, "axial_load_n": 1}})).spindle.axial, AxialHold::Free);
    assert_eq!(scene(json!({"spindle": {"axial": {"offset_um": 5}}})).spindle.axial, AxialHold::Offset(5e-6));
    assert_eq!(scene(json!({"spindle": {"balance_grade": 6.3}})).spindle.unbalance, Unbalance::Grade(6.3e-3));
    let angle = scene(json!({"bearing": {"preset": "608", "contact_angle_deg": 15, "ball_count": 7.0}}));
    assert!((angle.bearing.free_contact_angle.to_degrees() - 15.0).abs() < 1e-9);
}

/// The job that resolving prints can be posted again, gives the same scene to the bit, and then has no defaults.
#[test]
fn resolved_scenes_resolve_to_themselves() {
    let dimensions = json!({"outer_diameter_mm": 62, "inner_diameter_mm": 30, "width_mm": 16, "ball_count": 9,
        "ball_diameter_mm": 9.525, "pitch_diameter_mm": 46.0, "type": "angular_contact"});
    let mut bearings: Vec<Value> = presets::bearing_names().map(Value::from).collect();
    bearings.push(dimensions);
    bearings.push(json!({"preset": "608", "contact_angle_deg": 12.3, "materials": {"ball": "si3n4"},
        "cage": {"film": {"stiffness_n_per_m": 1e4, "damping_n_s_per_m": 1}, "land": {"clearance_mm": 0.1, "diameter_mm": 18, "width_mm": 1}}}));
    for bearing in bearings {
        for lubricant in ["grease", "oil", "dry"] {
            let body = json!({"scene": {"bearing": bearing, "lubricant": lubricant,
                "operation": {"speed_rpm": 12345.678, "radial_load_y_n": 0.1, "axial_load_n": 3}}});
            let first = parse_scene_request(body.to_string().as_bytes()).unwrap();
            let again = json!({"scene": first.scene_json()}).to_string();
            let second = parse_scene_request(again.as_bytes()).unwrap();
            assert_eq!(first.scene(), second.scene());
            assert_eq!(first.scene_json(), second.scene_json());
            assert_eq!(first.canonical(), second.canonical());
            let left: Vec<_> = second
                .base()
                .unwrap()
                .resolved
                .defaults
                .iter()
                .filter(|pointer| pointer.starts_with("/scene"))
                .collect();
            assert!(left.is_empty(), "{left:?}");
        }
    }
}

#[test]
fn equal_work_has_one_canonical_form() {
    let short = job(&article(json!({"speed_rpm": 50000})));
    let mut long = article(json!({"speed_rpm": 5e4, "radial_load_z_n": 0}));
    long["solver"] = json!({"method": "auto"});
    long["labels"] = json!(["a"]);
    long["duration_s"] = json!(0.1);
    assert_eq!(short.canonical(), job(&long).canonical());
    long["duration_s"] = json!(0.2);
    assert_ne!(short.canonical(), job(&long).canonical());
}

fn comparison(request: &Value) -> Comparison {
    let Job::Accuracy(comparison) = job(request) else { panic!("{request}") };
    comparison
}

#[test]
fn an_accuracy_job_has_its_defaults_and_resolves_to_itself() {
    let mut request = article(json!({"speed_rpm": 50000}));
    request["kind"] = json!("accuracy");
    let short = comparison(&request);
    let plan = &short.plan;
    let names: Vec<_> = plan.methods.iter().map(|method| method.name()).collect();
    assert_eq!(names, ["gear", "fine_abm", "dormand_prince", "radau", "auto"]);
    let settings = &short.base.settings;
    assert_eq!(plan.relative_tolerances, [1e-3, 1e-4, 1e-5, 1e-6, 1e-7]);
    assert_eq!(
        (plan.repetitions, settings.settle, settings.duration, short.base.submission.reuse),
        (1, 0.02, 0.02, false)
    );
    let again = comparison(&short.complete());
    assert_eq!((&again.plan, again.complete()), (&short.plan, short.complete()));
    request["solver"] = json!({"rung": "planar", "model_tolerance_db": 0});
    request["outputs"] = json!({"metrics": ["vibration"]});
    request["reuse"] = json!(false);
    let chosen = base(&request);
    assert_eq!(chosen.settings.rung, Some(raceway_core::simulation::input::model_level::ModelLevel::Planar));
    assert!(!chosen.settings.outputs.cage && chosen.settings.outputs.spectra.is_empty());
}

fn repetitions(job: &Job) -> Option<u32> {
    let Job::Accuracy(comparison) = job else { return None };
    Some(comparison.plan.repetitions)
}

#[test]
fn a_scene_alone_makes_a_job() {
    let scene = json!({"bearing": "608", "operation": {"speed_rpm": 3000}}).to_string();
    let job = parse_accuracy_request(scene.as_bytes(), Some(5)).unwrap();
    assert_eq!(repetitions(&job), Some(5));
    assert_eq!(parse_job_or_scene(scene.as_bytes()).unwrap().kind(), JobKind::Simulation);
    let body = json!({"scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}}).to_string();
    let job = parse_accuracy_request(body.as_bytes(), Some(5)).unwrap();
    assert_eq!(repetitions(&job), Some(5));
    let body = json!({"repetitions": 2, "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}}).to_string();
    assert_eq!(repetitions(&parse_accuracy_request(body.as_bytes(), Some(5)).unwrap()), Some(2));
}

#[test]
fn methods_that_take_fixed_steps_get_them() {
    for method in ["dormand_prince", "fine_abm"] {
        let mut request = article(json!({"speed_rpm": 50000}));
        request["solver"] = json!({"method": method, "fixed_step_us": 0.5});
        assert_eq!(base(&request).settings.fixed_step, Some(5e-7));
    }
    for rung in ["radially_condensed", "spindle_only"] {
        let mut request = article(json!({"speed_rpm": 50000, "radial_load_y_n": 200}));
        request["solver"] = json!({"rung": rung, "fixed_step_us": 2});
        request["outputs"] = json!({"metrics": ["vibration"]});
        assert_eq!(base(&request).settings.fixed_step, Some(2e-6));
    }
}

#[test]
fn every_preset_states_what_it_sets() {
    let answer = serde_json::to_value(presets_answer()).unwrap();
    assert_eq!(answer["bearings"]["6205"]["bearing"]["ball_count"], 9);
    assert_eq!(answer["lubricants"]["oil"]["lubricant"]["traction"]["maximum"], 0.05);
    assert_eq!(answer["materials"]["pa46"]["poisson_ratio"], 0.39);
    for (name, preset) in answer["bearings"].as_object().unwrap() {
        let scene = json!({"bearing": preset["bearing"], "operation": {"speed_rpm": 1},
            "spindle": {"mass_kg": preset["spindle_mass_kg"]}, "lubricant": preset["lubricant"]});
        let named = json!({"bearing": name, "operation": {"speed_rpm": 1}});
        assert_eq!(scene_from_json(&scene.to_string()).unwrap(), scene_from_json(&named.to_string()).unwrap());
    }
}

/// Decimal text to double and back loses nothing, so that a scene printed with 17 digits stays the same scene.
#[test]
fn long_decimals_survive_the_way_through_text() {
    let mut number = 0.1_f64;
    for _ in 0..2000 {
        number = (number * 997.0 + 0.123_456_789).fract();
        let text = format!("{{\"value\":{number}}}");
        assert_eq!(
            crate::contract::json::strict::read(text.as_bytes()).unwrap()["value"].as_f64(),
            Some(number),
            "{text}"
        );
    }
}
