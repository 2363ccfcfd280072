//! Bearings on a rigid spindle, and a list of one bearing.

use raceway_core::machine::simulate::simulate_on;
use raceway_core::simulation::input::control::Control;
use serde_json::{Value, json};

use crate::contract::json::problem::Refusal;
use crate::contract::{Job, MachinePlanAnswer, parse_job, plan_machine};

fn parsed(job: &Value) -> Result<Job, Vec<(String, String)>> {
    parse_job(job.to_string().as_bytes()).map_err(|refusal| match refusal {
        Refusal::Invalid { errors } => errors.into_iter().map(|error| (error.pointer, error.detail)).collect(),
        other => panic!("{other:?}"),
    })
}

fn simulation(scene: Value) -> Value {
    json!({ "kind": "simulation", "duration_s": 0.1, "scene": scene })
}

/// One bearing at the mass centre is the scene of the bearing alone, and the same work.
#[test]
fn a_list_of_one_bearing_is_the_bearing() {
    let operation = json!({ "speed_rpm": 3000, "radial_load_y_n": 300 });
    let surfaces = json!({ "outer": { "waviness": [{ "order": 8, "amplitude_nm": 20 }] } });
    let alone = json!({ "bearing": { "preset": "6205", "radial_clearance_um": 5 }, "lubricant": "oil",
        "surfaces": surfaces, "operation": operation, "spindle": { "mass_kg": 2 } });
    let item = json!({ "name": "A", "bearing": { "preset": "6205", "radial_clearance_um": 5 }, "lubricant": "oil",
        "surfaces": surfaces, "at_mm": 40, "faces": "+x", "start_azimuth_deg": 0, "outer_ring": { "seat": "rigid" } });
    let listed = json!({ "bearings": [item], "operation": operation, "spindle": { "mass_kg": 2, "centre_mm": 40 } });
    let (one, other) = (parsed(&simulation(alone)).unwrap(), parsed(&simulation(listed)).unwrap());
    assert_eq!(one.scene(), other.scene());
    assert_eq!((one.canonical(), one.scene_json()), (other.canonical(), other.scene_json()));
}

/// Errors point at the list, and what only a machine has is refused with the way to it.
#[test]
fn errors_of_a_list_point_at_it() {
    let with = |item: Value, scene: Value| {
        let mut whole = json!({ "bearings": [item], "operation": { "speed_rpm": 3000 } });
        scene.as_object().unwrap().iter().for_each(|(field, value)| whole[field] = value.clone());
        parsed(&simulation(whole)).unwrap_err()
    };
    let none = json!({});
    for (item, scene, pointer, detail) in [
        (json!({ "bearing": "nope" }), &none, "/scene/bearings/0/bearing", "nope"),
        (
            json!({ "bearing": { "preset": "608", "ball_count": 1 } }),
            &none,
            "/scene/bearings/0/bearing/ball_count",
            "1",
        ),
        (json!({ "name": "A" }), &none, "/scene/bearings/0/bearing", "required"),
        (json!({ "bearing": "608", "faces": "-x" }), &none, "/scene/bearings/0/faces", "machine"),
        (json!({ "bearing": "608", "start_azimuth_deg": 3 }), &none, "/scene/bearings/0/start_azimuth_deg", "machine"),
        (
            json!({ "bearing": "608", "outer_ring": { "offset_um": { "x": 1 } } }),
            &none,
            "/scene/bearings/0/outer_ring",
            "rigid",
        ),
        (json!({ "bearing": "608", "colour": "red" }), &none, "/scene/bearings/0/colour", "unknown"),
        (
            json!({ "bearing": "608", "lubricant": "oil" }),
            &json!({ "lubricant": "oil" }),
            "/scene/bearings/0/lubricant",
            "too",
        ),
        (
            json!({ "bearing": "608", "at_mm": 10 }),
            &json!({ "spindle": { "centre_mm": 20 } }),
            "/scene/bearings/0/at_mm",
            "20 mm",
        ),
        (json!({ "bearing": "608" }), &json!({ "bearing": "608" }), "/scene/bearings", "either"),
    ] {
        let errors = with(item, scene.clone());
        let found = errors.iter().any(|(at, text)| at == pointer && text.contains(detail));
        assert!(found, "{pointer}: {errors:?}");
    }
    let two = json!({ "bearings": [{ "bearing": "608" }, { "bearing": "608" }], "operation": { "speed_rpm": 3000 } });
    let errors = parsed(&simulation(two)).unwrap_err();
    assert!(errors.iter().any(|(at, text)| at == "/scene/bearings" && text.contains("machine")), "{errors:?}");
}

fn machine(kind: &str, spindle: Value) -> Value {
    let bearing =
        |name: &str, at: f64, faces: &str| json!({ "name": name, "bearing": "6205", "at_mm": at, "faces": faces });
    json!({ "kind": kind, "scene": {
        "bearings": [bearing("A", 40.0, "+x"), bearing("B", 260.0, "-x")],
        "preloads": [{ "between": ["A", "B"], "force_n": 200 }],
        "spindle": spindle,
        "operation": { "speed_rpm": 6000, "radial_load_y_n": 100 }
    } })
}

/// A rigid spindle has the mass of both bearings by default, its centre between them, and tilts.
#[test]
fn bearings_without_a_shaft_hold_a_rigid_spindle() {
    for kind in ["rotor", "machine"] {
        let job = parsed(&machine(kind, json!({ "unbalance_g_mm": 20 }))).unwrap();
        let spindle = &job.scene_json()["spindle"];
        let alone = parsed(&simulation(json!({ "bearing": "6205", "operation": { "speed_rpm": 1 } }))).unwrap();
        let mass = alone.scene_json()["spindle"]["mass_kg"].as_f64().unwrap();
        assert_eq!(spindle["centre_mm"], 150.0);
        assert_eq!((&spindle["tilt"], &spindle["axial"]), (&json!("free"), &json!("fixed")));
        assert!((spindle["mass_kg"].as_f64().unwrap() / (2.0 * mass) - 1.0).abs() < 1e-12);
        // The job with all its defaults is the same work.
        assert_eq!(parsed(&job.complete()).unwrap().canonical(), job.canonical());
    }
}

/// A speed after the record leaves the run of a constant one, in all its bearings.
#[test]
fn a_speed_after_the_record_does_not_count() {
    let mut request = machine("machine", json!({}));
    request["settle_s"] = json!(0.1);
    request["duration_s"] = json!(0.1);
    request["scene"]["operation"]["speed_rpm"] = json!([{ "at_s": 100, "rpm": 1000 }, { "at_s": 200, "rpm": 60000 }]);
    let Job::Machine(job) = parsed(&request).unwrap() else { panic!("another kind") };
    assert!(job.machine.speed.is_constant());
    assert!(job.machine.bearings.iter().all(|bearing| bearing.scene.operating_speeds().inner < 105.0));
}

/// A light shaft with clearance, held by a support: its linear whirl throws balls into raceways, so that no motion follows. It starts at rest.
#[test]
fn a_loose_shaft_starts_without_its_linear_whirl() {
    let bearing =
        |name: &str, at: f64, faces: &str| json!({ "name": name, "bearing": "608", "at_mm": at, "faces": faces });
    let disc =
        |at: f64, mass: f64, inertia: f64| json!({ "at_mm": at, "mass_kg": mass, "transverse_inertia_kg_m2": inertia });
    let request = json!({ "kind": "machine", "settle_s": 0.01, "duration_s": 0.01, "step_us": 5, "scene": {
        "shaft": { "sections": [{ "length_mm": 69.2, "outer_diameter_mm": 8, "inner_diameter_mm": 5.9 }],
                   "discs": [disc(58.7, 4.42e-3, 1.65e-7), disc(48.6, 1.288e-2, 5.8e-7)],
                   "unbalances": [{ "at_mm": 6.2, "unbalance_g_mm": 1.435, "phase_deg": -59 }] },
        "bearings": [bearing("A", 19.5, "+x"), bearing("B", 45.0, "-x")],
        "supports": [{ "at_mm": 13.6, "stiffness_n_per_um": [0, 1.61, 0.13], "damping_n_s_per_m": [0, 27.7, 484] }],
        "operation": { "speed_rpm": 17200, "radial_load_y_n": 0.186 }
    } });
    let Job::Machine(job) = parsed(&request).unwrap() else { panic!("another kind") };
    let result = simulate_on(job.level, &job.machine, &job.settings, &Control::until(&|| false)).unwrap();
    let largest = result.bearings.iter().map(|bearing| bearing.record.inner_load).fold(0.0, f64::max);
    assert!((0.1..1000.0).contains(&largest), "{largest} N");
}

/// Cage bending, heat and fits are described, and come later.
#[test]
fn later_fields_are_named() {
    let mut job = machine("machine", json!({}));
    job["scene"]["thermal"] = json!({});
    job["scene"]["fits"] = json!({});
    job["scene"]["bearings"][1]["bearing"] = json!({ "preset": "6205", "cage": { "flexibility": { "harmonics": 3 } } });
    let errors = parsed(&job).unwrap_err();
    for pointer in ["/scene/thermal", "/scene/fits", "/scene/bearings/1/bearing/cage/flexibility"] {
        assert!(errors.iter().any(|(at, text)| at == pointer && text.contains("not supported yet")), "{errors:?}");
    }
    assert_eq!(errors.len(), 3, "{errors:?}");
}

#[test]
fn wrong_spindles_are_named() {
    let errors = |spindle: Value| parsed(&machine("machine", spindle)).unwrap_err();
    for (spindle, pointer) in [
        (json!({ "mass_kg": 0 }), "/scene/spindle/mass_kg"),
        (json!({ "centre_mm": 300 }), ""),
        (json!({ "centre_mm": -1 }), "/scene/spindle/centre_mm"),
        (json!({ "axial": { "offset_um": 3 } }), "/scene/spindle/axial"),
        (json!({ "transverse_inertia_kg_m2": 1, "axial_inertia_kg_m2": 3 }), "/scene/spindle/axial_inertia_kg_m2"),
        (json!({ "unbalance_g_mm": 1, "balance_grade": 1 }), "/scene/spindle/balance_grade"),
    ] {
        if pointer.is_empty() {
            // A mass centre beyond the bearings is an overhang.
            assert!(parsed(&machine("machine", spindle)).is_ok());
            continue;
        }
        let found = errors(spindle.clone());
        assert!(found.iter().any(|(at, _)| at == pointer), "{spindle}: {found:?}");
    }
    let mut both = machine("machine", json!({}));
    both["scene"]["shaft"] = json!({ "sections": [{ "length_mm": 300, "outer_diameter_mm": 25 }] });
    assert!(parsed(&both).unwrap_err().iter().any(|(at, _)| at == "/scene/spindle"));
    both["scene"].as_object_mut().unwrap().remove("spindle");
    assert!(parsed(&both).is_ok());
}

/// A spring on a sliding ring reaches the other bearing through the shaft, which is then free along X unless it is fixed.
#[test]
fn a_spring_frees_the_shaft_along_its_axis() {
    for body in ["shaft", "spindle"] {
        let mut job = machine("rotor", json!({}));
        let scene = &mut job["scene"];
        if body == "shaft" {
            scene["shaft"] = json!({ "sections": [{ "length_mm": 300, "outer_diameter_mm": 25 }] });
            scene.as_object_mut().unwrap().remove("spindle");
        }
        let axial = |job: &Value| parsed(job).unwrap().scene_json()[body]["axial"].clone();
        assert_eq!(axial(&job), "fixed");
        job["scene"].as_object_mut().unwrap().remove("preloads");
        job["scene"]["bearings"][1]["outer_ring"] = json!({ "seat": "sliding", "spring_force_n": 150 });
        assert_eq!(axial(&job), "free");
        job["scene"][body]["axial"] = json!("fixed");
        assert_eq!(axial(&job), "fixed");
    }
}

/// Each bearing draws its own surfaces; a given seed stays.
#[test]
fn drawn_surfaces_of_bearings_differ() {
    let mut job = machine("machine", json!({}));
    for bearing in 0..2 {
        job["scene"]["bearings"][bearing]["surfaces"] = json!({ "preset": "standard" });
    }
    let seeds = |job: &Value| {
        let scene = parsed(job).unwrap().scene_json().clone();
        [0, 1].map(|bearing| scene["bearings"][bearing]["surfaces"]["seed"].as_u64().unwrap())
    };
    assert_eq!(seeds(&job), [1, 2]);
    job["scene"]["bearings"][1]["surfaces"]["seed"] = json!(1);
    assert_eq!(seeds(&job), [1, 1]);
}

/// A machine takes a level that can represent it; another is refused with its cause. Without `solver` the job is the same work as ever.
#[test]
fn a_machine_takes_the_level_that_can_represent_it() {
    let with = |solver: Value, is_preloaded: bool| {
        let mut job = machine("machine", json!({}));
        if !is_preloaded {
            job["scene"]["preloads"] = json!([]);
        }
        if !solver.is_null() {
            job["solver"] = solver;
        }
        parsed(&job)
    };
    let plain = with(Value::Null, false).unwrap();
    assert!(plain.complete().get("solver").is_none());
    let levels = ["spindle_only", "radially_condensed", "planar"].map(|name| json!({ "rung": name }));
    for solver in levels.into_iter().chain([json!({ "model_tolerance_db": 0.5 })]) {
        let job = with(solver.clone(), false).unwrap();
        assert_eq!(job.complete()["solver"], solver);
        assert_ne!(job.canonical(), plain.canonical());
        assert_eq!(parsed(&job.complete()).unwrap().canonical(), job.canonical());
    }
    for (solver, pointer, detail) in [
        (json!({ "rung": "radially_condensed" }), "/solver/rung", "bearing A"),
        (
            json!({ "rung": "periodic" }),
            "/solver/rung",
            "available: `full`, `spindle_only`, `radially_condensed`, `planar`",
        ),
        (json!({ "model_tolerance_db": 21 }), "/solver/model_tolerance_db", "20 dB"),
        (json!({ "rung": "full", "model_tolerance_db": 0.5 }), "/solver/model_tolerance_db", "goes without `rung`"),
        (json!({ "method": "auto" }), "/solver/method", "unknown"),
    ] {
        let errors = with(solver, true).unwrap_err();
        let found = errors.iter().any(|(at, text)| at == pointer && text.contains(detail));
        assert!(found, "{pointer}: {errors:?}");
    }
}

/// Terms of shaft and housing may be off in analyses and in runs. A housing with a sensor stays, and a hinge alone holds no shaft.
#[test]
fn terms_of_shaft_and_housing_are_switched() {
    let with = |kind: &str, terms: Value| {
        let mut job = machine(kind, json!({}));
        job["scene"]["terms"] = terms;
        job
    };
    for kind in ["rotor", "machine"] {
        let job = parsed(&with(kind, json!({ "tilt": "off" }))).unwrap();
        let terms = json!({ "shaft_bending": "auto", "tilt": "off", "gyroscopic": "auto", "housing": "auto" });
        assert_eq!(job.scene_json()["terms"], terms);
        assert_eq!(parsed(&job.complete()).unwrap().canonical(), job.canonical());
        assert_ne!(job.canonical(), parsed(&machine(kind, json!({}))).unwrap().canonical());
        let errors = parsed(&with(kind, json!({ "drag": "off", "gyroscopic": "no" }))).unwrap_err();
        let pointers: Vec<&str> = errors.iter().map(|(at, _)| at.as_str()).collect();
        assert_eq!(pointers, ["/scene/terms/drag", "/scene/terms/gyroscopic"], "{errors:?}");
    }
    let mut heard = with("machine", json!({ "housing": "off" }));
    heard["scene"]["housing"] = json!({
        "bodies": [{ "name": "head", "mass_kg": 8, "at_mm": 150, "inertia_kg_m2": [0.02, 0.05, 0.05] }],
        "mounts": [{ "body": "head", "stiffness_n_per_um": [50, 20, 50], "tilt_n_m_per_mrad": [20, 20] }],
    });
    heard["scene"]["bearings"][0]["outer_ring"] = json!({ "on": "head" });
    assert!(parsed(&heard).is_ok());
    heard["outputs"] = json!({ "series": ["head.y.acceleration"] });
    assert!(parsed(&heard).unwrap_err().iter().any(|(at, _)| at == "/outputs/series/0"));
    heard.as_object_mut().unwrap().remove("outputs");
    heard["scene"]["sensors"] = json!([{ "name": "acc", "on": "head", "at_mm": 40, "direction": "y" }]);
    let errors = parsed(&heard).unwrap_err();
    assert!(errors.iter().any(|(at, text)| at == "/scene/terms/housing" && text.contains("`acc`")), "{errors:?}");
    let mut hinged = with("rotor", json!({ "tilt": "off" }));
    hinged["scene"]["bearings"].as_array_mut().unwrap().truncate(1);
    hinged["scene"].as_object_mut().unwrap().remove("preloads");
    hinged["scene"]["spindle"]["tilt"] = json!("free");
    let errors = parsed(&hinged).unwrap_err();
    let names_term = |(at, text): &(String, String)| at == "/scene/terms/tilt" && text.contains("hinges");
    assert!(errors.iter().any(names_term), "{errors:?}");
    hinged["scene"]["spindle"]["tilt"] = json!("held");
    assert!(parsed(&hinged).is_ok());
}

/// Outer rings turn in rigid, sliding and elastic seats on the ground, the last ones at a constant speed; none turns on a body.
#[test]
fn outer_rings_turn_in_seats_on_the_ground() {
    let with = |ring: Value, speed: Value| {
        let mut job = machine("machine", json!({}));
        let scene = job["scene"].as_object_mut().unwrap();
        scene.remove("preloads");
        scene["bearings"][1]["outer_ring"] = ring;
        scene["operation"]["outer_speed_rpm"] = speed;
        scene.insert(
            "housing".to_owned(),
            json!({
                "bodies": [{ "name": "head", "mass_kg": 8, "at_mm": 150, "inertia_kg_m2": [0.02, 0.05, 0.05] }],
                "mounts": [{ "body": "head", "stiffness_n_per_um": [50, 20, 50], "tilt_n_m_per_mrad": [20, 20] }],
            }),
        );
        parsed(&job)
    };
    let (sliding, elastic) = (
        json!({ "seat": "sliding", "spring_force_n": 150 }),
        json!({ "seat": "elastic", "stiffness_n_per_um": [200, 400] }),
    );
    let (constant, profile) = (json!(-2000), json!([{ "at_s": 0, "rpm": 0 }, { "at_s": 1, "rpm": 2000 }]));
    for (ring, speed) in [(&sliding, &constant), (&sliding, &profile), (&elastic, &constant)] {
        assert!(with(ring.clone(), speed.clone()).is_ok(), "{ring} {speed}");
    }
    let refused = |ring: Value, speed: &Value, pointer: &str| {
        let errors = with(ring, speed.clone()).unwrap_err();
        let [(at, _)] = &errors[..] else { panic!("one error: {errors:?}") };
        assert_eq!(at, pointer);
    };
    refused(elastic, &profile, "/scene/bearings/1/outer_ring/seat");
    refused(json!({ "on": "head" }), &constant, "/scene/bearings/1/outer_ring/on");
}

/// An elastic seat has damping by default. A stiffness that is refused causes no error of the damping that follows from it.
#[test]
fn elastic_seats_have_damping() {
    let with = |ring: Value| {
        let mut job = machine("machine", json!({}));
        job["scene"]["bearings"][1]["outer_ring"] = ring;
        parsed(&job)
    };
    let job = with(json!({ "seat": "elastic", "stiffness_n_per_um": [100, 400], "mass_kg": 0.04 })).unwrap();
    let ring = &job.scene_json()["bearings"][1]["outer_ring"];
    assert_eq!(ring["damping_n_s_per_m"], json!([20.0, 40.0]));
    assert!(ring["tilt_damping_n_m_s_per_rad"].as_f64().unwrap() > 0.0);
    for (field, wrong) in [("stiffness_n_per_um", json!([-5, 1e300])), ("tilt_n_m_per_mrad", json!(-1))] {
        let mut ring = json!({ "seat": "elastic", "stiffness_n_per_um": [100, 400] });
        ring[field] = wrong;
        let errors = with(ring).unwrap_err();
        let is_of_field = |(at, text): &(String, String)| at.contains(field) && !text.contains("NaN");
        assert!(!errors.is_empty() && errors.iter().all(is_of_field), "{errors:?}");
    }
}

/// A plan has the job with its defaults, what follows of each bearing, and a time that grows with the record and the levels that may be tried.
#[test]
fn a_machine_is_planned_without_a_run() {
    let plan = |change: &dyn Fn(&mut Value)| {
        let mut job = machine("machine", json!({}));
        job["scene"]["bearings"][1]["bearing"] = json!("6205/C3");
        change(&mut job);
        let Ok(Job::Machine(job)) = parsed(&job) else { panic!("a machine") };
        let answer = plan_machine(&job, &|| false).unwrap();
        assert_eq!(parsed(&answer.job).unwrap().canonical(), job.complete().to_string());
        answer
    };
    let usual = plan(&|_| {});
    let [a, b] = &usual.bearings[..] else { panic!("two bearings") };
    assert_eq!((a.name.as_str(), b.name.as_str()), ("A", "B"));
    assert!(b.designation.is_some() && b.radial_clearance_um > a.radial_clearance_um);
    let [warning] = &usual.warnings[..] else { panic!("one warning: {:?}", usual.warnings) };
    assert_eq!(warning.pointer, "/scene/bearings/1/bearing/radial_clearance_group");
    assert!((a.dynamic_load_rating_n / 14_000.0 - 1.0).abs() < 0.05, "{}", a.dynamic_load_rating_n);
    assert!((a.frequencies_hz.ball_pass_outer / 358.5 - 1.0).abs() < 0.01, "{:?}", a.frequencies_hz);
    assert!(usual.defaults.contains(&"/duration_s".to_owned()));
    assert!(usual.coordinates >= 4 && (usual.step_us - 5.5).abs() < 1e-9, "{usual:?}");
    let likely = |plan: &MachinePlanAnswer| plan.cost.estimated_wall_time_s.unwrap();
    let long = plan(&|job| job["duration_s"] = json!(2));
    assert!(likely(&long) > 2.0 * likely(&usual) && usual.cost.most_wall_time_s.unwrap() > likely(&usual));
    assert_eq!(plan(&|job| job["step_us"] = json!(2)).step_us, 2.0);
    assert!(usual.left_out.is_empty());
    let lean = plan(&|job| job["scene"]["terms"] = json!({ "tilt": "off", "shaft_bending": "off" }));
    // A rigid spindle has no bending to leave out.
    let [tilt] = &lean.left_out[..] else { panic!("one term: {:?}", lean.left_out) };
    assert!(tilt.term == "tilt" && tilt.bound.is_some_and(|bound| bound > 0.1) && tilt.unit.as_deref() == Some("dB"));
}
