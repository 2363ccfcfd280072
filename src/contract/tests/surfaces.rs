//! Surfaces of the raceways: fields, defaults, refusals, and what `resolve` tells of them.

use serde_json::{Value, json};

use super::requests::scene;
use crate::contract::{Job, Refusal, parse_job, parse_scene_request, resolve_answer};

fn wavy(surfaces: Value) -> String {
    scene(&format!(r#""surfaces":{surfaces}"#))
}

/// Each wrong number has its own pointer, unit and range.
#[test]
fn wrong_surfaces_are_refused() {
    let inner = |fields: Value| json!({ "inner": fields });
    let wave = |order: Value, amplitude: f64, phase: f64| {
        let good = json!({ "order": 8, "amplitude_nm": 10 });
        inner(json!({ "waviness": [good, { "order": order, "amplitude_nm": amplitude, "phase_deg": phase }] }))
    };
    let random = |fields: Value| inner(json!({ "random_waviness": fields }));
    let defect = |fields: Value| {
        let good = json!({ "azimuth_deg": 90, "length_mm": 0.2, "depth_um": 10 });
        inner(json!({ "defects": [good, fields] }))
    };
    let balls = |fields: Value| json!({ "balls": [{ "ball": 2, "diameter_um": 1 }, fields] });
    let every_ball = |fields: Value| json!({ "every_ball": fields });
    let apart = |index: i32| json!({ "azimuth_deg": 20 * index, "length_mm": 0.1, "depth_um": 3 });
    let many_defects: Vec<Value> = (0..17).map(apart).collect();
    let many = vec![json!({ "order": 8, "amplitude_nm": 10 }); 65];
    for (surfaces, pointer, words) in [
        (wave(json!(0), 1.0, 0.0), "inner/waviness/1/order", "0: must be from 1 to 100000"),
        (wave(json!(2.5), 1.0, 0.0), "inner/waviness/1/order", "2.5: must be a whole number from 1 to 100000"),
        (wave(json!(2), -1.0, 0.0), "inner/waviness/1/amplitude_nm", "-1 nm: must be from 0 to 100000 nm"),
        (wave(json!(2), 2e5, 0.0), "inner/waviness/1/amplitude_nm", "200000 nm: must be from 0 to 100000 nm"),
        (wave(json!(2), 1.0, 400.0), "inner/waviness/1/phase_deg", "400 °: must be from -360 to 360 °"),
        (inner(json!({ "waviness": [{ "order": 3 }] })), "inner/waviness/0/amplitude_nm", "required, but missing"),
        (inner(json!({ "waviness": many })), "inner/waviness", "65 waves: at most 64"),
        (random(json!({})), "inner/random_waviness/amplitude_nm", "required, but missing"),
        (
            random(json!({ "amplitude_nm": 1, "exponent": 5 })),
            "inner/random_waviness/exponent",
            "5: must be from 0 to 4",
        ),
        (
            random(json!({ "amplitude_nm": 1, "from_order": 0 })),
            "inner/random_waviness/from_order",
            "0: must be from 1",
        ),
        (
            random(json!({ "amplitude_nm": 1, "from_order": 9, "to_order": 8 })),
            "inner/random_waviness/to_order",
            "8 is below from_order, 9",
        ),
        (json!({ "seed": -1 }), "seed", "-1: must be a whole number from 0 to 9007199254740991"),
        (defect(json!({ "depth_um": 3 })), "inner/defects/1/length_mm", "required, but missing"),
        (defect(json!({ "length_mm": 1 })), "inner/defects/1/depth_um", "required, but missing"),
        (
            defect(json!({ "length_mm": 0, "depth_um": 3 })),
            "inner/defects/1/length_mm",
            "0 mm: must be above 0 and at most 10000 mm",
        ),
        (
            defect(json!({ "length_mm": 0.1, "depth_um": 1001 })),
            "inner/defects/1/depth_um",
            "1001 µm: must be from 0 to 1000 µm",
        ),
        (
            defect(json!({ "length_mm": 0.1, "depth_um": 3, "azimuth_deg": 361 })),
            "inner/defects/1/azimuth_deg",
            "361 °: must be from -360 to 360 °",
        ),
        (
            defect(json!({ "length_mm": 0.1, "depth_um": 3, "width_mm": 0 })),
            "inner/defects/1/width_mm",
            "0 mm: must be above 0",
        ),
        (
            defect(json!({ "length_mm": 0.1, "depth_um": 3, "across_mm": 0.2 })),
            "inner/defects/1/across_mm",
            "give width_mm",
        ),
        (defect(json!({ "length_mm": 0.1, "depth_um": 3, "shape": "round" })), "inner/defects/1/shape", "half_sine"),
        (
            defect(json!({ "length_mm": 0.1, "depth_um": 3, "azimuth_deg": 90.2 })),
            "inner/defects/1",
            "the outlines of items 0 and 1 overlap",
        ),
        (
            inner(json!({ "defects": [{ "length_mm": 80, "depth_um": 3 }] })),
            "inner/defects/0/length_mm",
            "80.0000 mm: must be below",
        ),
        (inner(json!({ "defects": many_defects })), "inner/defects", "17 defects: at most 16"),
        (
            inner(json!({ "axial_waviness": [{ "order": 1, "amplitude_nm": 1e6 }] })),
            "inner/axial_waviness/0/amplitude_nm",
            "must be from 0 to 100000 nm",
        ),
        (balls(json!({})), "balls/1/ball", "required, but missing"),
        (balls(json!({ "ball": 0 })), "balls/1/ball", "0: must be from 1 to 64"),
        (balls(json!({ "ball": 1.5 })), "balls/1/ball", "1.5: must be a whole number from 1 to 64"),
        (balls(json!({ "ball": 8 })), "balls/1/ball", "8: the bearing has 7 balls"),
        (balls(json!({ "ball": 2, "diameter_um": 1 })), "balls/1/ball", "items 0 and 1 are both of ball 2"),
        (balls(json!({ "ball": 3, "diameter_um": -6000 })), "balls/1/diameter_um", "must be from -5000 to 5000 µm"),
        (balls(json!({ "ball": 3, "diameter_um": 30 })), "balls/1/diameter_um", "30 µm: at most"),
        (every_ball(json!({ "diameter_spread_um": -1 })), "every_ball/diameter_spread_um", "must be from 0 to 5000 µm"),
        (every_ball(json!({ "diameter_spread_um": 30 })), "every_ball/diameter_spread_um", "30 µm: at most"),
        (
            balls(
                json!({ "ball": 3, "defects": [{ "diameter_mm": 0.5, "depth_um": 5 }, { "diameter_mm": 0.5, "depth_um": 5 }] }),
            ),
            "balls/1/defects/1",
            "the outlines of defects 0 and 1 of ball 3 overlap",
        ),
        (
            inner(json!({ "defects": [{ "length_mm": 1, "depth_um": 3, "width_mm": 1, "across_mm": 5 }] })),
            "inner/defects/0/across_mm",
            "5 mm with a width of 1 mm",
        ),
        (json!({ "preset": "new" }), "preset", "known: `precision`, `standard`, `worn`"),
        (
            balls(json!({ "ball": 3, "waviness": [{ "order": 3, "amplitude_nm": -1 }] })),
            "balls/1/waviness/0/amplitude_nm",
            "must be from 0 to",
        ),
        (
            balls(json!({ "ball": 3, "defects": [{ "diameter_mm": 0.1, "depth_um": 1, "latitude_deg": 91 }] })),
            "balls/1/defects/0/latitude_deg",
            "91 °: must be from -90 to 90 °",
        ),
        (
            balls(json!({ "ball": 3, "defects": [{ "diameter_mm": 2.75, "depth_um": 1 }] })),
            "balls/1/defects/0/diameter_mm",
            "2.75 mm: must be below",
        ),
    ] {
        let body = wavy(surfaces);
        let Err(Refusal::Invalid { errors }) = parse_job(body.as_bytes()) else { panic!("{body}") };
        let pointer = format!("/scene/surfaces/{pointer}");
        let [error] = &errors[..] else { panic!("{body}: {errors:?}") };
        assert!(error.pointer == pointer && error.detail.contains(words), "{body}: {error:?}");
    }
}

/// The resolved scene names the defaults and is the same scene when sent again; without surfaces it has no such field.
#[test]
fn surfaces_have_defaults() {
    let body = wavy(json!({
        "inner": { "waviness": [{ "order": 8, "amplitude_nm": 10 }] },
        "outer": { "random_waviness": { "amplitude_nm": 5 } }
    }));
    let job = parse_job(body.as_bytes()).unwrap();
    let complete = job.scene_json();
    assert_eq!(
        complete["surfaces"],
        json!({
            "inner": { "waviness": [{ "order": 8, "amplitude_nm": 10.0, "phase_deg": 0.0 }] },
            "outer": { "random_waviness": { "amplitude_nm": 5.0, "at_order": 10, "exponent": 1.0, "from_order": 2 } },
            "seed": 1
        })
    );
    let again = json!({ "kind": "simulation", "scene": complete });
    assert_eq!(parse_job(again.to_string().as_bytes()).unwrap().scene_json(), complete);
    assert_eq!(parse_job(scene(r#""gravity_m_s2":9.81"#).as_bytes()).unwrap().scene_json().get("surfaces"), None);
}

/// A preset gives random waviness to the raceways that have none, and names it among the defaults. Given fields win.
#[test]
fn a_preset_fills_random_waviness() {
    let resolve = |surfaces: Value| {
        let request = json!({ "scene": {
            "bearing": "6205",
            "operation": { "speed_rpm": 1797, "radial_load_y_n": 500 },
            "surfaces": surfaces
        } });
        serde_json::to_value(resolve_answer(&parse_scene_request(request.to_string().as_bytes()).unwrap()).unwrap())
            .unwrap()
    };
    for (preset, amplitude) in [("precision", 1.0), ("standard", 5.0), ("worn", 25.0)] {
        let answer = resolve(json!({ "preset": preset }));
        let waviness = json!({ "amplitude_nm": amplitude, "at_order": 10, "exponent": 1.0, "from_order": 2 });
        let surface = json!({ "random_waviness": waviness });
        assert_eq!(
            answer["scene"]["surfaces"],
            json!({ "preset": preset, "inner": surface, "outer": surface, "seed": 1 })
        );
        let defaults = answer["defaults"].as_array().unwrap();
        for ring in ["inner", "outer"] {
            let pointer = format!("/scene/surfaces/{ring}/random_waviness/amplitude_nm");
            assert!(defaults.contains(&json!(pointer)), "{defaults:?}");
            assert!(answer["derived"]["surfaces"][ring]["kept"].as_u64().unwrap() > 100, "{answer}");
        }
    }
    let own = json!({ "random_waviness": { "amplitude_nm": 3 }, "defects": [{ "length_mm": 1, "depth_um": 10 }] });
    let mixed = resolve(json!({ "preset": "worn", "outer": own }));
    let surfaces = &mixed["scene"]["surfaces"];
    assert_eq!(surfaces["outer"]["random_waviness"]["amplitude_nm"], 3.0);
    assert_eq!(surfaces["inner"]["random_waviness"]["amplitude_nm"], 25.0);
    assert_eq!(mixed["derived"]["surfaces"]["outer"]["defects"].as_array().unwrap().len(), 1);
    assert!(!mixed["defaults"].to_string().contains("outer/random_waviness/amplitude_nm"));
    assert_eq!(resolve(surfaces.clone())["scene"]["surfaces"], *surfaces, "the resolved scene is the same work");
}

/// Spectra that do not separate lines an orbit frequency apart have a warning; the windows of others hold eight turns of the cage.
#[test]
fn short_spectra_of_waves_have_a_warning() {
    let of = |duration: f64, amplitude: f64| {
        let request = json!({ "kind": "simulation", "duration_s": duration, "scene": {
            "bearing": "6205",
            "operation": { "speed_rpm": 600, "radial_load_y_n": 500 },
            "surfaces": { "outer": { "waviness": [{ "order": 10, "amplitude_nm": amplitude }] } }
        } });
        let job = parse_job(request.to_string().as_bytes()).unwrap();
        let messages = serde_json::to_value(resolve_answer(&job).unwrap()).unwrap()["messages"].clone();
        let of_time = messages.as_array().unwrap().iter().filter(|one| one["code"] == "merged-cage-lines").count();
        let Job::Simulation(simulation) = job else { panic!("no simulation") };
        (simulation.settings.outputs.longest_window, of_time)
    };
    let (window, warnings) = of(2.0, 10.0);
    assert!((window * 3.982 - 8.0).abs() < 0.05 && warnings == 0, "{window} s, {warnings}");
    assert_eq!(of(0.5, 10.0).1, 1);
    assert_eq!(of(0.5, 0.0), (1.0, 0));
}

/// Ten turns of the cage are recorded, and only the dynamics are tried.
#[test]
fn waves_take_ten_turns_of_the_cage() {
    let of = |amplitude: f64| {
        let scene = json!({
            "bearing": "6205",
            "operation": { "speed_rpm": 600, "radial_load_y_n": 500 },
            "surfaces": { "outer": { "waviness": [
                { "order": 10, "amplitude_nm": amplitude },
                { "order": 90_000, "amplitude_nm": amplitude },
            ] } }
        });
        let request = json!({ "scene": scene }).to_string();
        serde_json::to_value(resolve_answer(&parse_scene_request(request.as_bytes()).unwrap()).unwrap()).unwrap()
    };
    let (wavy, ideal) = (of(10.0), of(0.0));
    let turns = wavy["duration_s"].as_f64().unwrap() * wavy["derived"]["frequencies_hz"]["cage"].as_f64().unwrap();
    assert!((turns - 10.0).abs() < 1e-3, "{turns}");
    assert!(ideal["duration_s"].as_f64().unwrap() < 1.01 && ideal["derived"].get("surfaces").is_none());
    assert_eq!(wavy["rungs"], json!(["radially_condensed", "full"]));
    assert!(ideal["rungs"].as_array().unwrap().len() > 1, "{}", ideal["rungs"]);
    let outer = &wavy["derived"]["surfaces"]["outer"];
    assert_eq!(outer["left_out"], json!([{ "from_order": 90_000, "to_order": 90_000, "reason": "averaged" }]));
    assert!(outer["waves"][0]["averaging"].as_f64().unwrap() > 0.999 && outer["kept"] == 1, "{outer}");
}

/// A study varies each number of a surface.
#[test]
fn a_study_varies_waves() {
    for path in [
        "/surfaces/inner/waviness/0/amplitude_nm",
        "/surfaces/inner/waviness/0/order",
        "/surfaces/inner/waviness/0/phase_deg",
        "/surfaces/outer/random_waviness/exponent",
        "/surfaces/outer/random_waviness/to_order",
        "/surfaces/outer/defects/0/length_mm",
        "/surfaces/outer/defects/0/depth_um",
        "/surfaces/outer/defects/0/azimuth_deg",
        "/surfaces/balls/1/diameter_um",
        "/surfaces/balls/1/ball",
        "/surfaces/every_ball/diameter_spread_um",
        "/bearing/cage/pocket_spacing_mrad/4",
        "/surfaces/seed",
    ] {
        let request = json!({
            "kind": "study",
            "scene": {
                "bearing": { "preset": "article-integrated", "cage": { "pocket_spacing_mrad": [0, 0, 1, 0, 0, -1, 0] } },
                "operation": { "speed_rpm": 50000 },
                "surfaces": {
                    "balls": [{ "ball": 1 }, { "ball": 6, "diameter_um": 0.3 }],
                    "every_ball": {},
                    "inner": { "waviness": [{ "order": 8, "amplitude_nm": 10 }] },
                    "outer": {
                        "random_waviness": { "amplitude_nm": 5 },
                        "defects": [{ "length_mm": 0.3, "depth_um": 3 }]
                    }
                }
            },
            "axes": [{ "path": path, "values": [2, 3] }]
        });
        let study = parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{path}: {refusal}"));
        let point = study.into_study().unwrap().point(1).unwrap().scene_json();
        assert_eq!(point.pointer(path).and_then(Value::as_f64), Some(3.0), "{path}");
    }
}

/// An item has one name: with two, both axes would vary the same field and one would have no effect.
#[test]
fn an_item_of_a_list_has_one_name() {
    for item in ["00", "+0", "-1", "1", "18446744073709551616"] {
        let request = json!({
            "kind": "study",
            "scene": {
                "bearing": "6205", "operation": { "speed_rpm": 1797 },
                "surfaces": { "outer": { "defects": [{ "length_mm": 0.3, "depth_um": 3 }] } }
            },
            "axes": [{ "path": format!("/surfaces/outer/defects/{item}/length_mm"), "values": [1, 2] }]
        });
        let refused = parse_job(request.to_string().as_bytes()).map(|_| ()).expect_err(item).to_string();
        let expected = format!("/axes/0/path: `/surfaces/outer/defects` has no item {item}");
        assert!(refused.contains(&expected), "{refused}");
    }
}

/// Balls have defaults, and `resolve` tells each diameter, drawn or given. Ten turns of the cage are recorded.
#[test]
fn resolve_tells_of_balls() {
    let answer = resolved(json!({ "balls": [{ "ball": 2 }], "every_ball": { "diameter_spread_um": 0.5 } }), 600.0);
    let sizes = |answer: &Value| -> Vec<f64> {
        let balls = answer["derived"]["surfaces"]["balls"].as_array().unwrap();
        (1..)
            .zip(balls)
            .map(|(number, ball)| {
                assert_eq!(ball["ball"], number);
                ball["diameter_um"].as_f64().unwrap()
            })
            .collect()
    };
    let drawn = sizes(&answer);
    let spread = drawn.iter().copied().fold(f64::MIN, f64::max) - drawn.iter().copied().fold(f64::MAX, f64::min);
    assert!(drawn.len() == 9 && (spread - 0.5).abs() < 1e-9 && drawn.iter().sum::<f64>().abs() < 1e-9, "{drawn:?}");
    assert_eq!(answer["scene"]["surfaces"]["balls"], json!([{ "ball": 2, "diameter_um": 0.0 }]));
    let turns = answer["duration_s"].as_f64().unwrap() * answer["derived"]["frequencies_hz"]["cage"].as_f64().unwrap();
    assert!((turns - 10.0).abs() < 1e-3, "{turns}");
    let own = sizes(&resolved(
        json!({ "balls": [{ "ball": 2, "diameter_um": 1 }], "every_ball": { "diameter_spread_um": 0.5 } }),
        600.0,
    ));
    assert!((own[1] - drawn[1] - 1.0).abs() < 1e-9 && own[2] == drawn[2], "{own:?}");
}

/// Pockets keep a ball and half their clearance between their centres; each has its deviation.
#[test]
fn wrong_pockets_are_refused() {
    let at = "/scene/bearing/cage/pocket_spacing_mrad";
    for (spacing, pointer, words) in [
        (json!([0, 1]), at.to_owned(), "2 values: the cage has 7 pockets"),
        (json!([0, 0, 600, 0, 0, 0, 0]), at.to_owned(), "pockets 3 and 4 are 1.9"),
        (json!([0, 0, 0, 0, 0, 0, 1001]), format!("{at}/6"), "1001 mrad: must be from -1000 to 1000 mrad"),
        (json!(["1", 0]), format!("{at}/0"), "expected a number"),
    ] {
        let bearing = json!({ "preset": "article-integrated", "cage": { "pocket_spacing_mrad": spacing } });
        let body =
            json!({ "kind": "simulation", "scene": { "bearing": bearing, "operation": { "speed_rpm": 50_000 } } });
        let Err(Refusal::Invalid { errors }) = parse_job(body.to_string().as_bytes()) else { panic!("{body}") };
        let [error] = &errors[..] else { panic!("{body}: {errors:?}") };
        assert!(error.pointer.starts_with(&pointer) && error.detail.contains(words), "{body}: {error:?}");
    }
    let clamped = json!({ "balls": [{ "ball": 1, "diameter_um": 20 }] });
    let tight = json!({ "preset": "article-integrated", "cage": { "pocket_clearance_mm": 0.015 } });
    let scene = json!({ "bearing": tight, "operation": { "speed_rpm": 50_000 }, "surfaces": clamped });
    let Err(Refusal::Invalid { errors }) =
        parse_job(json!({ "kind": "simulation", "scene": scene }).to_string().as_bytes())
    else {
        panic!("{scene}")
    };
    assert!(errors.len() == 1 && errors[0].detail.contains("its pocket leaves 15.0000 µm"), "{errors:?}");
    assert_eq!(errors[0].pointer, "/scene/surfaces/balls/0/diameter_um");
}

/// A 6205 with surfaces, and the answer of `resolve`.
fn resolved(surfaces: Value, speed: f64) -> Value {
    let operation = json!({ "speed_rpm": speed, "radial_load_y_n": 500 });
    let request = json!({ "scene": { "bearing": "6205", "operation": operation, "surfaces": surfaces } });
    serde_json::to_value(resolve_answer(&parse_scene_request(request.to_string().as_bytes()).unwrap()).unwrap())
        .unwrap()
}

/// Drop, fall, times, load and step of each defect; only the dynamics are tried.
#[test]
fn resolve_tells_of_defects() {
    let slot = json!({ "length_mm": 1, "depth_um": 10 });
    let away = json!({ "azimuth_deg": 180, "length_mm": 0.5, "width_mm": 0.5, "depth_um": 100 });
    let surfaces = json!({ "outer": { "defects": [slot, away] }, "inner": { "defects": [slot] } });
    let answer = resolved(surfaces.clone(), 1797.0);
    assert_eq!(answer["rungs"], json!(["full"]));
    let defects = |ring: &str| answer["derived"]["surfaces"][ring]["defects"].clone();
    let (outer, inner) = (defects("outer"), defects("inner"));
    let number = |of: &Value, field: &str| of[field].as_f64().unwrap_or_else(|| panic!("{field}: {of}"));
    for (of, field, expected) in [
        (&outer[0], "edge_drop_um", 26.16),
        (&inner[0], "edge_drop_um", 39.5),
        (&outer[0], "contact_speed_m_s", 1.7607),
        (&outer[0], "impact_beside_middle_us", 134.8),
        // Half of 1 mm at 1.7607 m/s, and the time beside the middle; the design estimates 392.5.
        (&outer[0], "entry_to_impact_us", 284.0 + 134.8),
        (&outer[0], "fall_um", 10.0),
        (&inner[0], "longest_step_us", 13.0),
        (&outer[0], "longest_step_us", 17.5),
    ] {
        assert!((number(of, field) / expected - 1.0).abs() < 0.05, "{field}: {of}");
    }
    assert!(outer[0]["reaches_floor"] == true && outer[1]["reaches_floor"] == false);
    assert!(outer[0]["in_load_zone"] == true && outer[1]["in_load_zone"] == false && inner[0]["in_load_zone"] == true);
    assert!(
        (0.2..0.6).contains(&number(&outer[1], "width_over_contact")) && outer[0].get("width_over_contact").is_none()
    );
    assert!(number(&outer[1], "fall_um") < 0.3 * number(&outer[1], "edge_drop_um"), "{}", outer[1]);
    // At rest nothing takes time.
    let still = resolved(surfaces, 0.0)["derived"]["surfaces"]["outer"]["defects"][0].clone();
    assert!(still.get("longest_step_us").is_none() && still.get("impact_beside_middle_us").is_none(), "{still}");
}

/// Defects that leave no ideal raceway, steps that would pass over one, and a planar model of a defect beside the middle.
#[test]
fn defects_refuse_what_cannot_resolve_them() {
    let of = |defect: Value, solver: Value| {
        json!({
            "kind": "simulation",
            "scene": {
                "bearing": "6205",
                "operation": { "speed_rpm": 20_000, "radial_load_y_n": 500 },
                "surfaces": { "outer": { "defects": [defect] } }
            },
            "solver": solver
        })
    };
    let slot = json!({ "length_mm": 1, "depth_um": 10 });
    let aside = json!({ "length_mm": 1, "depth_um": 10, "width_mm": 1, "across_mm": 0.5 });
    for (job, pointer, words) in [
        (
            of(json!({ "length_mm": 147.6, "depth_um": 10 }), json!({})),
            "/scene/surfaces/outer/defects/0/length_mm",
            "must be below",
        ),
        (
            of(slot, json!({ "method": "dormand_prince", "fixed_step_us": 5 })),
            "/solver/fixed_step_us",
            "5 µs: at most 1.",
        ),
        (of(aside, json!({ "rung": "planar" })), "/solver/rung", "across_mm"),
    ] {
        let Err(Refusal::Invalid { errors }) = parse_job(job.to_string().as_bytes()) else { panic!("{job}") };
        let [error] = &errors[..] else { panic!("{job}: {errors:?}") };
        assert!(error.pointer == pointer && error.detail.contains(words), "{error:?}");
    }
}
