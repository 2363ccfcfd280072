//! Wrong requests, each with the field that is named and words of the reason.

use crate::contract::{Refusal, parse_accuracy_request, parse_batch, parse_job, parse_job_or_scene};

/// A job of the article's bearing with `operation` replaced.
fn operation(fields: &str) -> String {
    format!(r#"{{"kind":"simulation","scene":{{"bearing":"article-integrated","operation":{{{fields}}}}}}}"#)
}

/// A job with further fields of the scene.
fn scene(fields: &str) -> String {
    format!(
        r#"{{"kind":"simulation","scene":{{"bearing":"article-integrated","operation":{{"speed_rpm":50000}},{fields}}}}}"#
    )
}

/// A job with fields of the bearing changed in the article's preset.
fn preset(fields: &str) -> String {
    bearing(&format!(r#""preset":"article-integrated",{fields}"#))
}

/// A job with this bearing object.
fn bearing(fields: &str) -> String {
    format!(r#"{{"kind":"simulation","scene":{{"bearing":{{{fields}}},"operation":{{"speed_rpm":50000}}}}}}"#)
}

/// A job with further fields at the top.
fn job(fields: &str) -> String {
    format!(
        r#"{{"kind":"simulation","scene":{{"bearing":"article-integrated","operation":{{"speed_rpm":50000}}}},{fields}}}"#
    )
}

const DIMENSIONS: &str = r#""outer_diameter_mm":52,"inner_diameter_mm":25,"width_mm":15,"ball_count":9,"ball_diameter_mm":7.94,"pitch_diameter_mm":39.04"#;

fn check(cases: &[(String, &str, &str)]) {
    let mut wrong = String::new();
    for (body, pointer, words) in cases {
        match parse_job(body.as_bytes()) {
            Err(Refusal::Invalid { errors }) => {
                let hit = errors.iter().any(|error| error.pointer == *pointer && error.detail.contains(words));
                if !hit || errors.len() > 1 {
                    wrong += &format!("{body}\n  wanted {pointer}: {words}\n  got {errors:?}\n");
                }
            }
            other => wrong += &format!("{body}\n  wanted {pointer}: {words}\n  got {:?}\n", other.map(|_| "a job")),
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn impossible_bearings_are_refused() {
    let b = |name: &str| format!("/scene/bearing/{name}");
    let cases = [
        (r#""ball_diameter_mm":-1"#, b("ball_diameter_mm"), "-1 mm: must be from 0.1 to 500 mm"),
        (r#""ball_diameter_mm":0"#, b("ball_diameter_mm"), "0 mm: must be from 0.1 to 500 mm"),
        (r#""pitch_diameter_mm":0"#, b("pitch_diameter_mm"), "must be from 0.1"),
        (r#""outer_diameter_mm":-18"#, b("outer_diameter_mm"), "-18 mm"),
        (r#""inner_diameter_mm":0"#, b("inner_diameter_mm"), "from 0.1"),
        (r#""width_mm":-5.9"#, b("width_mm"), "-5.9 mm"),
        (r#""ball_count":0"#, b("ball_count"), "0: must be from 2 to 64"),
        (r#""ball_count":1"#, b("ball_count"), "1: must be"),
        (r#""ball_count":-3"#, b("ball_count"), "-3: must be a whole number from 2 to 64"),
        (r#""ball_count":7.5"#, b("ball_count"), "7.5: must be a whole number"),
        (r#""ball_count":1e30"#, b("ball_count"), "whole number"),
        (r#""ball_count":65"#, b("ball_count"), "from 2 to 64"),
        (r#""ball_count":15"#, b("ball_count"), "overlap on a pitch circle"),
        (r#""outer_diameter_mm":15"#, b("outer_diameter_mm"), "leaves no outer ring"),
        (r#""inner_diameter_mm":12"#, b("inner_diameter_mm"), "leaves no inner raceway"),
        (r#""inner_groove_curvature":0.5"#, b("inner_groove_curvature"), "0.5: must be above 0.5 and at most 1"),
        (r#""outer_groove_curvature":0.4"#, b("outer_groove_curvature"), "0.4: must be above 0.5"),
        (r#""radial_clearance_um":500"#, b("radial_clearance_um"), "leaves no contact angle"),
        (r#""radial_clearance_um":-500"#, b("radial_clearance_um"), "at least -55.560 µm"),
        (r#""contact_angle_deg":61"#, b("contact_angle_deg"), "61 °: must be from 0 to 60 °"),
        (r#""contact_angle_deg":15,"radial_clearance_um":5"#, b("contact_angle_deg"), "give either"),
        (r#""type":"roller""#, b("type"), "unknown variant"),
        (r#""cage":{"mass_g":0}"#, b("cage/mass_g"), "from 1e-9"),
        (
            r#""cage":{"film":"wedge","pocket_clearance_mm":1e-6}"#,
            b("cage/pocket_clearance_mm"),
            "1e-6 mm: must be from 0.001",
        ),
        (r#""cage":{"mass_g":-0.1}"#, b("cage/mass_g"), "-0.1 g"),
        (r#""cage":{"film":"oil"}"#, b("cage/film"), "unknown variant"),
        (r#""cage":{"seat":1}"#, b("cage/seat"), "wrong type: expected `"),
        (r#""cage":{"seat":{}}"#, b("cage/seat"), "wrong type: expected `"),
        (
            r#""cage":{"film":{"stiffness_n_per_m":-1,"damping_n_s_per_m":3}}"#,
            b("cage/film/stiffness_n_per_m"),
            "-1 N/m",
        ),
        (r#""cage":{"film":{"stiffness_n_per_m":1}}"#, b("cage/film/damping_n_s_per_m"), "required"),
        (
            r#""cage":{"land":{"clearance_mm":0,"diameter_mm":1,"width_mm":1}}"#,
            b("cage/land/clearance_mm"),
            "from 0.001 to 100 mm",
        ),
        (r#""cage":{"bar_stiffness_n_per_m":0}"#, b("cage/bar_stiffness_n_per_m"), "from 1 to"),
        (r#""materials":{"ball":"cheese"}"#, b("materials/ball"), "known are `gcr15`"),
        (
            r#""materials":{"ball":{"elastic_modulus_gpa":210,"density_kg_m3":7800}}"#,
            b("materials/ball/poisson_ratio"),
            "required",
        ),
        (
            r#""materials":{"ball":{"elastic_modulus_gpa":0,"poisson_ratio":0.3,"density_kg_m3":7800}}"#,
            b("materials/ball/elastic_modulus_gpa"),
            "0 GPa: must be from 0.001 to 2000 GPa",
        ),
    ]
    .map(|(fields, pointer, words)| (preset(fields), pointer, words));
    check(&cases.each_ref().map(|case| (case.0.clone(), case.1.as_str(), case.2)));
}

#[test]
fn impossible_scenes_are_refused() {
    check(&[
        (bearing(r#""preset":"9999""#), "/scene/bearing/preset", "known are `article-integrated`"),
        (bearing(&DIMENSIONS.replace(r#""ball_count":9,"#, "")), "/scene/bearing/ball_count", "required"),
        (operation(""), "/scene/operation/speed_rpm", "required"),
        (operation(r#""speed_rpm":500001"#), "/scene/operation/speed_rpm", "500001 r/min: must be from -500000 to 500000"),
        (operation(r#""speed_rpm":[]"#), "/scene/operation/speed_rpm", "at least one point"),
        (operation(r#""speed_rpm":[{"at_s":0,"rpm":1},{"at_s":0,"rpm":2}]"#), "/scene/operation/speed_rpm", "times must rise"),
        (operation(r#""speed_rpm":[{"at_s":0,"rpm":1},{"at_s":1,"rpm":6e5}]"#), "/scene/operation/speed_rpm/1/rpm", "600000 r/min"),
        (operation(r#""speed_rpm":[{"at_s":-1,"rpm":1}]"#), "/scene/operation/speed_rpm/0/at_s", "-1 s"),
        (operation(r#""speed_rpm":[{"at_s":0}]"#), "/scene/operation/speed_rpm/0/rpm", "required"),
        (operation(r#""speed_rpm":[[0,1]]"#), "/scene/operation/speed_rpm/0", "expected an object"),
        (operation(r#""speed_rpm":1,"radial_load_y_n":1e8"#), "/scene/operation/radial_load_y_n", "100000000 N"),
        (operation(r#""speed_rpm":1,"misalignment_mrad":{"y":21}"#), "/scene/operation/misalignment_mrad/y", "21 mrad"),
        (scene(r#""spindle":{"mass_kg":-1}"#), "/scene/spindle/mass_kg", "-1 kg"),
        (scene(r#""spindle":{"mass_kg":0}"#), "/scene/spindle/mass_kg", "0 kg: must be from 1e-9 to 1000000 kg"),
        (scene(r#""spindle":{"unbalance_g_mm":1,"balance_grade":6.3}"#), "/scene/spindle/balance_grade", "not both"),
        (scene(r#""spindle":{"axial":"loose"}"#), "/scene/spindle/axial", "unknown variant"),
        (scene(r#""spindle":{"axial":{}}"#), "/scene/spindle/axial", "`offset_um`"),
        (scene(r#""spindle":{"axial":{"offset_um":"1"}}"#), "/scene/spindle/axial/offset_um", "expected a number"),
        (scene(r#""spindle":{"axial":{"offset_um":1e6}}"#), "/scene/spindle/axial/offset_um", "1000000 µm"),
        (scene(r#""lubricant":"water""#), "/scene/lubricant", "known are `grease`"),
        (scene(r#""lubricant":{"viscosity_pa_s":-1}"#), "/scene/lubricant/viscosity_pa_s", "-1 Pa·s"),
        (scene(r#""lubricant":{"fill":2}"#), "/scene/lubricant/fill", "from 0 to 1"),
        (scene(r#""lubricant":{"traction":{"law":"slide_roll","a":1,"b":1,"c":1}}"#), "/scene/lubricant/traction/d", "required"),
        (scene(r#""lubricant":{"traction":{"law":"coulomb","a":1}}"#), "/scene/lubricant/traction/a", "takes `coefficient`"),
        (scene(r#""lubricant":{"traction":{"maximum":0.01}}"#), "/scene/lubricant/traction/maximum", "must be at least"),
        (scene(r#""lubricant":{"traction":"coulomb"}"#), "/scene/lubricant/traction", r#"{"law": "coulomb"}"#),
        (scene(r#""damping":{"raceway":{"restitution":1.1}}"#), "/scene/damping/raceway/restitution", "from 0.05 to 1"),
        (scene(r#""damping":{"pocket":{"at_speed_m_s":0}}"#), "/scene/damping/pocket/at_speed_m_s", "0 m/s"),
        (scene(r#""damping":{"pocket":{"law":"viscous"}}"#), "/scene/damping/pocket/viscous_n_s_per_m", "required"),
        (scene(r#""damping":{"raceway":{"law":"none","restitution":1}}"#), "/scene/damping/raceway/restitution", "no other field"),
        (scene(r#""terms":{"magic":"on"}"#), "/scene/terms/magic", "unknown field"),
        (scene(r#""terms":{"drag":"maybe"}"#), "/scene/terms/drag", "unknown variant"),
        (scene(r#""terms":{"ball_spin_dynamics":"off"}"#), "/scene/terms/ball_spin_dynamics", "cannot be switched off"),
        (scene(r#""gravity_m_s2":1001"#), "/scene/gravity_m_s2", "1001 m/s²"),
        (
            r#"{"kind":"simulation","scene":{"bearing":"nope","operation":{"speed_rpm":1}}}"#.into(),
            "/scene/bearing",
            "no bearing is called `nope`",
        ),
        (
            r#"{"kind":"simulation","scene":{"bearing":"608","operation":{"speed_rpm":1,"axial_load_n":10},"spindle":{"axial":"fixed"}}}"#.into(),
            "/scene/spindle/axial",
            "axial load of 10 N",
        ),
    ]);
}

#[test]
fn impossible_jobs_are_refused() {
    check(&[
        (job(r#""duration_s":0"#), "/duration_s", "0 s: must be from 1e-6 to 1000 s"),
        (job(r#""duration_s":1e-300"#), "/duration_s", "1e-300 s: must be from 1e-6 to 1000 s"),
        (job(r#""duration_s":-1"#), "/duration_s", "-1 s"),
        (job(r#""duration_s":3600"#), "/duration_s", "3600 s: must be from 1e-6 to 1000 s"),
        (
            job(r#""duration_s":23.401,"outputs":{"series":["cage.speed"]}"#),
            "/duration_s",
            "23.401 s: must be from 1e-6 to 23.4 s: /outputs/series would take more than 1 GiB",
        ),
        (job(r#""settle_s":-0.1"#), "/settle_s", "-0.1 s: must be from 0"),
        (job(r#""priority":5"#), "/priority", "5: must be from 1 to 4"),
        (job(r#""priority":0"#), "/priority", "0: must be"),
        (job(r#""keep_for_s":-5"#), "/keep_for_s", "-5 s"),
        (job(r#""labels":"a""#), "/labels", "expected an array"),
        (job(r#""labels":[1]"#), "/labels/0", "expected a string"),
        (job(r#""labels":["a","b\u0000"]"#), "/labels/1", "control characters"),
        (job(&format!(r#""labels":["{}"]"#, "x".repeat(201))), "/labels/0", "201 characters"),
        (job(&format!(r#""labels":[{}]"#, vec![r#""a""#; 17].join(","))), "/labels", "at most 16"),
        (job(r#""reuse":"yes""#), "/reuse", "expected a boolean"),
        (job(r#""solver":{"method":"runge_kutta_4"}"#), "/solver/method", "not available in this version"),
        (job(r#""solver":{"method":"shooting"}"#), "/solver/method", "goes with the rung `periodic`"),
        (job(r#""solver":{"method":"euler"}"#), "/solver/method", "unknown"),
        (job(r#""solver":{"rung":"periodic"}"#), "/solver/rung", "contacts are asked for"),
        (
            job(r#""solver":{"rung":"periodic","method":"gear"},"outputs":{"metrics":["vibration"]}"#),
            "/solver/rung",
            "the method must be `auto`",
        ),
        (
            job(
                r#""solver":{"rung":"spindle_only","fixed_step_us":1,"method":"dormand_prince"},"outputs":{"metrics":["vibration"]}"#,
            ),
            "/solver/rung",
            "without a fixed step",
        ),
        (scene(r#""terms":{"cage_tilt":"off"}},"solver":{"rung":"full""#), "/solver/rung", "terms.cage_tilt is off"),
        (
            scene(r#""spindle":{"axial":{"offset_um":5}},"terms":{"cage_tilt":"off"}"#),
            "/scene/terms/cage_tilt",
            "the scene moves along X",
        ),
        (job(r#""solver":{"rung":"condensed"}"#), "/solver/rung", "available: `full`, `planar`, `radially_condensed`"),
        (
            job(r#""solver":{"relative_tolerance":1e-13}"#),
            "/solver/relative_tolerance",
            "1e-13: must be from 1e-12 to 0.01",
        ),
        (job(r#""solver":{"relative_tolerance":0}"#), "/solver/relative_tolerance", "0: must be"),
        (job(r#""solver":{"model_tolerance_db":-1}"#), "/solver/model_tolerance_db", "-1 dB"),
        (
            job(r#""solver":{"fixed_step_us":1}"#),
            "/solver/fixed_step_us",
            "goes with the methods `fine_abm`, `dormand_prince`, not with `auto`",
        ),
        (job(r#""solver":{"method":"gear","fixed_step_us":1}"#), "/solver/fixed_step_us", "not with `gear`"),
        (job(r#""solver":{"method":"dormand_prince","fixed_step_us":0}"#), "/solver/fixed_step_us", "0 µs"),
        (job(r#""outputs":{"metrics":["noise"]}"#), "/outputs/metrics/0", "unknown variant"),
        (job(r#""outputs":{"metrics":["cage","cage"]}"#), "/outputs/metrics/1", "more than once"),
        (job(r#""outputs":{"spectra":["spindle.q.acceleration"]}"#), "/outputs/spectra/0", "channels are spindle."),
        (job(r#""outputs":{"spectra":["spindle.x.velocity"]}"#), "/outputs/spectra/0", "axial direction is free"),
        (job(r#""outputs":{"series":["cage.speed","cage.speed"]}"#), "/outputs/series/1", "more than once"),
        (job(r#""outputs":{"series":["ball.8.spin"]}"#), "/outputs/series/0", "N = 1…7"),
        (
            job(&format!(r#""outputs":{{"series":[{}]}}"#, vec![r#""cage.speed""#; 65].join(","))),
            "/outputs/series",
            "at most 64",
        ),
        (r#"{"kind":"guess"}"#.into(), "/kind", "kinds are `simulation`, `study`"),
        (r#"{"kind":7}"#.into(), "/kind", "must be a string"),
        (r#"{"scene":{}}"#.into(), "/kind", "required"),
        (r#"{"kind":"simulation"}"#.into(), "/scene", "required"),
        ("[]".into(), "", "must be an object"),
        ("7".into(), "", "must be an object"),
    ]);
}

/// What is missing or of another type hides no other fault, and a number's unit and range are told.
#[test]
fn types_and_gaps_are_told_together() {
    let body = r#"{"kind":"simulation","duration_s":"1 s","scene":{"bearing":{"preset":"6205","cage":{"land":{}}},
        "operation":{"speed_rpm":"3000"},"spindle":{"mass_kg":-1}}}"#;
    let Err(Refusal::Invalid { errors }) = parse_job(body.as_bytes()) else { panic!("it is wrong") };
    let told: Vec<(&str, &str)> = errors.iter().map(|e| (e.pointer.as_str(), e.detail.as_str())).collect();
    for (pointer, detail) in [
        ("/duration_s", "expected a number, from 1e-6 to 1000 s"),
        ("/scene/operation/speed_rpm", "from -500000 to 500000 r/min"),
        ("/scene/bearing/cage/land/clearance_mm", "required"),
        ("/scene/bearing/cage/land/diameter_mm", "required"),
        ("/scene/bearing/cage/land/width_mm", "required"),
    ] {
        assert!(told.iter().any(|(p, d)| *p == pointer && d.contains(detail)), "{pointer}: {told:?}");
    }
}

/// A refusal is not manifold what was sent: forty faults in a key of a million characters, each twice as long in a pointer.
#[test]
fn refusals_are_short() {
    let body = format!(r#"{{"{}":[{}null]}}"#, "~".repeat(1_000_000), "null,".repeat(39));
    let Err(Refusal::Invalid { errors }) = parse_job(body.as_bytes()) else { panic!("null is no value") };
    let bytes: usize = errors.iter().map(|error| error.pointer.len() + error.detail.len()).sum();
    assert!(errors.len() > 30 && bytes < 20_000, "{} errors of {bytes} bytes", errors.len());
    let long = "\\u0001".repeat(100_000);
    for job in [
        format!(r#"{{"kind":"simulation","scene":{{"bearing":"{long}","operation":{{"speed_rpm":3000}}}}}}"#),
        format!(r#"{{"kind":"simulation","{long}":1}}"#),
        format!(r#"{{"kind":"{long}"}}"#),
    ] {
        let told = parse_job(job.as_bytes()).expect_err("no such name").to_string();
        assert!(told.len() < 5000, "{}", told.len());
    }
}

#[test]
fn impossible_accuracy_jobs_are_refused() {
    let job = |fields: &str| job(fields).replace("\"simulation\"", "\"accuracy\"");
    let many = |count: i32| (0..count).map(|k| format!("{}e-9", k + 1)).collect::<Vec<_>>().join(",");
    check(&[
        (job(r#""methods":[]"#), "/methods", "0 methods: must be from 1 to 5"),
        (job(r#""methods":["gear","gear"]"#), "/methods/1", "more than once"),
        (job(r#""methods":["euler"]"#), "/methods/0", "unknown; available: `auto`, `gear`"),
        (job(r#""methods":["shooting"]"#), "/methods/0", "goes with the rung `periodic`"),
        (job(r#""methods":"gear""#), "/methods", "expected an array"),
        (job(r#""relative_tolerances":[]"#), "/relative_tolerances", "0 tolerances: must be from 1 to 12"),
        (job(&format!(r#""relative_tolerances":[{}]"#, many(13))), "/relative_tolerances", "13 tolerances"),
        (job(r#""relative_tolerances":[1e-3,1e-13]"#), "/relative_tolerances/1", "1e-13: must be from 1e-12 to 0.01"),
        (job(r#""relative_tolerances":[0.1]"#), "/relative_tolerances/0", "0.1: must be"),
        (job(r#""relative_tolerances":[1e-3,0.001]"#), "/relative_tolerances/1", "more than once"),
        (job(r#""relative_tolerances":["1e-3"]"#), "/relative_tolerances/0", "expected a number"),
        (job(r#""repetitions":0"#), "/repetitions", "0: must be from 1 to 9"),
        (job(r#""repetitions":10"#), "/repetitions", "10: must be"),
        (job(r#""repetitions":1.5"#), "/repetitions", "1.5: must be a whole number from 1 to 9"),
        (job(r#""repetitions":-1"#), "/repetitions", "-1: must be a whole number from 1 to 9"),
        (job(r#""solver":{"method":"gear"}"#), "/solver/method", "takes /methods"),
        (job(r#""solver":{"relative_tolerance":1e-5}"#), "/solver/relative_tolerance", "takes /relative_tolerances"),
        (job(r#""solver":{"fixed_step_us":1}"#), "/solver/fixed_step_us", "with error control"),
        (job(r#""solver":{"rung":"periodic"}"#), "/solver/rung", "compared on `full` or `planar`, not on `periodic`"),
        (job(r#""outputs":{"spectra":[]}"#), "/outputs/spectra", "keeps no signals"),
        (job(r#""outputs":{"series":["cage.speed"]}"#), "/outputs/series", "keeps no signals"),
        (job(r#""reuse":true"#), "/reuse", "no other answers it"),
        (job(r#""duration_s":0"#), "/duration_s", "0 s: must be from 1e-6 to 1000 s"),
        (job(r#""duration_s":3000"#), "/duration_s", "3000 s: must be from 1e-6 to 1000 s"),
    ]);
}

#[test]
fn fields_of_accuracy_jobs_are_refused_elsewhere() {
    check(&[
        (job(r#""methods":["gear"]"#), "/methods", "goes with the kind `accuracy`, not with `simulation`"),
        (job(r#""relative_tolerances":[1e-3]"#), "/relative_tolerances", "goes with the kind `accuracy`"),
        (job(r#""repetitions":3"#), "/repetitions", "goes with the kind `accuracy`"),
    ]);
    let body = job(r#""settle_s":0"#);
    let refused = parse_accuracy_request(body.as_bytes(), None);
    assert!(refused.is_err_and(|refusal| refusal.to_string().contains("must be `accuracy`, not `simulation`")));
}

#[test]
fn wrong_json_is_refused_where_it_stands() {
    check(&[
        (operation(r#""speed_rpm":"fast""#), "/scene/operation/speed_rpm", "a number or an array"),
        (operation(r#""speed_rpm":1e999"#), "/scene/operation/speed_rpm", "beyond double precision"),
        (operation(r#""speed_rpm":1,"speed_rpm":2"#), "/scene/operation/speed_rpm", "more than once"),
        (operation(r#""speed_rpm":1,"radial_load_y_n":null"#), "/scene/operation/radial_load_y_n", "null is no value"),
        (
            operation(r#""speed_rpm":1,"radial_load_y_n":"200""#),
            "/scene/operation/radial_load_y_n",
            "expected a number",
        ),
        (operation(r#""speed_rpm":1,"a/b~c":2"#), "/scene/operation/a~1b~0c", "unknown field"),
        (operation(r#""speed_rpm":1,"x":{"y":[{"z":1,"z":2}]}"#), "/scene/operation/x/y/0/z", "more than once"),
        (preset(r#""cage":{"mass_g":1,"mass_g":1}"#), "/scene/bearing/cage/mass_g", "more than once"),
        (preset(r#""cage":[]"#), "/scene/bearing/cage", "expected an object"),
        (preset(r#""cage":{"weight":1}"#), "/scene/bearing/cage/weight", "unknown field"),
        (preset(r#""preset":"608""#), "/scene/bearing/preset", "more than once"),
        (scene(r#""spindle":[0.05]"#), "/scene/spindle", "expected an object"),
        (scene(r#""lubricant":["grease"]"#), "/scene/lubricant", "a name or an object"),
        (scene(r#""terms":null"#), "/scene/terms", "null is no value"),
        (job(r#""outputs":{"spectra":[null]}"#), "/outputs/spectra/0", "null is no value"),
        (job(r#""colour":"red""#), "/colour", "unknown field"),
        (job(r#""kind":"simulation""#), "/kind", "more than once"),
        (r#"{"kind":"simulation","scene":[]}"#.into(), "/scene", "expected an object"),
    ]);
}

#[test]
fn text_that_is_no_json_is_told_apart() {
    let deep = "[".repeat(100_000);
    for body in ["", "{", "{}{}", "nope", "{\"kind\":NaN}", &deep, "{\"a\":\"\\ud800\"}"] {
        assert!(matches!(parse_job(body.as_bytes()), Err(Refusal::NotJson { .. })), "{body:.40}");
    }
    assert!(matches!(parse_job(b"{\"kind\":\"\xff\"}"), Err(Refusal::NotJson { .. })));
}

#[test]
fn several_faults_are_told_at_once() {
    let body = r#"{"kind":"simulation","duration_s":-1,"priority":9,"solver":{"method":"shooting"},
        "scene":{"bearing":{"preset":"608","ball_diameter_mm":-1,"cage":{"mass_g":-1}},
        "operation":{"speed_rpm":1e6,"radial_load_y_n":1},"spindle":{"mass_kg":0}}}"#;
    let Err(Refusal::Invalid { errors }) = parse_job(body.as_bytes()) else { panic!("accepted") };
    let pointers: Vec<_> = errors.iter().map(|error| error.pointer.as_str()).collect();
    assert!(pointers.contains(&"/scene/operation/speed_rpm"), "{pointers:?}");
    assert!(
        pointers.contains(&"/duration_s") && pointers.contains(&"/priority") && pointers.contains(&"/solver/method")
    );
    let missing = parse_job(bearing(r#""ball_count":9"#).as_bytes());
    assert!(matches!(missing, Err(Refusal::Invalid { errors }) if errors.len() == 5));
}

/// Every wrong field of every part, whatever else is wrong: ranges, names, what is missing and what does not fit.
#[test]
fn all_faults_are_told_in_one_answer() {
    let body = r#"{"kind":"simulation","duration_s":-1,"settle_s":-1,"solver":{"model_tolerance_db":-1},"outputs":{"series":["cage.speed"]},
        "scene":{"bearing":{"preset":"6205","width_mm":-1,"inner_groove_curvature":0.4,"outer_groove_curvature":0.4,"ball_count":30,
            "materials":{"ball":{"elastic_modulus_gpa":0,"poisson_ratio":1,"density_kg_m3":0}},
            "cage":{"mass_g":-1,"friction":3,"land":{"clearance_mm":0,"diameter_mm":0,"width_mm":0}}},
        "operation":{"speed_rpm":[{"at_s":-1,"rpm":1},{"at_s":1,"rpm":6e5}],"radial_load_y_n":1e8,"radial_load_z_n":1e8},
        "spindle":{"mass_kg":0,"unbalance_g_mm":-1},
        "lubricant":{"viscosity_pa_s":-1,"fill":2,"traction":{"maximum":3}},
        "damping":{"raceway":{"restitution":2},"pocket":{"restitution":2,"at_speed_m_s":0}},"gravity_m_s2":1001}}"#;
    let wanted = [
        "/duration_s",
        "/scene/bearing/ball_count",
        "/scene/bearing/cage/friction",
        "/scene/bearing/cage/land/clearance_mm",
        "/scene/bearing/cage/land/diameter_mm",
        "/scene/bearing/cage/land/width_mm",
        "/scene/bearing/cage/mass_g",
        "/scene/bearing/inner_groove_curvature",
        "/scene/bearing/materials/ball/density_kg_m3",
        "/scene/bearing/materials/ball/elastic_modulus_gpa",
        "/scene/bearing/materials/ball/poisson_ratio",
        "/scene/bearing/outer_groove_curvature",
        "/scene/bearing/width_mm",
        "/scene/damping/pocket/at_speed_m_s",
        "/scene/damping/pocket/restitution",
        "/scene/damping/raceway/restitution",
        "/scene/gravity_m_s2",
        "/scene/lubricant/fill",
        "/scene/lubricant/traction/maximum",
        "/scene/lubricant/viscosity_pa_s",
        "/scene/operation/radial_load_y_n",
        "/scene/operation/radial_load_z_n",
        "/scene/operation/speed_rpm/0/at_s",
        "/scene/operation/speed_rpm/1/rpm",
        "/scene/spindle/mass_kg",
        "/scene/spindle/unbalance_g_mm",
        "/settle_s",
        "/solver/model_tolerance_db",
    ];
    let mut told = pointers(parse_job(body.as_bytes()));
    told.sort();
    assert_eq!(told, wanted);
}

/// A bearing that is not known, or a part that cannot be read, keeps no other fault from being told, and makes none of its own.
#[test]
fn what_stands_in_for_a_wrong_part_is_not_judged() {
    let told = |bearing: &str| {
        let body = format!(
            r#"{{"kind":"simulation","scene":{{"bearing":{bearing},"operation":{{"speed_rpm":1}},"spindle":{{"mass_kg":0}}}}}}"#
        );
        pointers(parse_job(body.as_bytes()))
    };
    assert_eq!(told(r#""6250""#), ["/scene/bearing", "/scene/spindle/mass_kg"]);
    assert_eq!(
        told(r#"{"preset":"6250","ball_diameter_mm":30,"radial_clearance_um":90,"cage":{"mass_g":0}}"#),
        ["/scene/bearing/preset", "/scene/bearing/cage/mass_g", "/scene/spindle/mass_kg"]
    );
    assert_eq!(
        told(r#"{"preset":6205,"ball_count":65}"#),
        ["/scene/bearing/preset", "/scene/bearing/ball_count", "/scene/spindle/mass_kg"]
    );
    let damping = scene(r#""damping":{"raceway":{"law":"viscos","viscous_n_s_per_m":10},"pocket":{"restitution":2}}"#);
    assert_eq!(
        pointers(parse_job(damping.as_bytes())),
        ["/scene/damping/raceway/law", "/scene/damping/pocket/restitution"]
    );
}

/// A length in metres is told of where it stands, not of what does not fit because of it.
#[test]
fn lengths_in_metres_are_told_of_themselves() {
    let told = |fields: &str| {
        let Err(Refusal::Invalid { errors }) = parse_job(bearing(fields).as_bytes()) else {
            panic!("accepted: {fields}")
        };
        errors.into_iter().map(|error| (error.pointer, error.detail)).collect::<Vec<_>>()
    };
    let ball = told(r#""preset":"6205","ball_diameter_mm":0.0127"#);
    assert_eq!(ball.len(), 1, "{ball:?}");
    assert_eq!(ball[0].0, "/scene/bearing/ball_diameter_mm");
    assert_eq!(
        ball[0].1,
        "0.0127 mm: less than a 500th of `outer_diameter_mm`, 52 mm; lengths are in mm, not in m: 12.7?"
    );
    for (name, length) in
        [("outer_diameter_mm", "52"), ("inner_diameter_mm", "25"), ("width_mm", "15"), ("pitch_diameter_mm", "39.04")]
    {
        let wrong = DIMENSIONS
            .replace(&format!(r#""{name}":{length}"#), &format!(r#""{name}":0.0{}"#, length.replace('.', "")));
        let told = told(&format!(r#"{wrong},"radial_clearance_um":12.5"#));
        assert!(told.len() == 1 && told[0].0.ends_with(name) && told[0].1.contains("lengths are in mm"), "{told:?}");
    }
    let all = told(
        r#""outer_diameter_mm":0.052,"inner_diameter_mm":0.025,"width_mm":0.015,"ball_count":9,"ball_diameter_mm":0.00794,"pitch_diameter_mm":0.03904"#,
    );
    assert!(all.len() == 5 && all.iter().all(|(_, detail)| detail.contains("lengths are in mm")), "{all:?}");
}

#[test]
fn a_bare_array_is_told_what_a_batch_is() {
    let told = |body: &str| parse_batch(body.as_bytes()).map(|_| ()).unwrap_err().to_string();
    let wanted = "must be an object `{\"jobs\": […]}`";
    let array = told(&format!("[{}]", job(r#""priority":1"#)));
    assert!(array.contains(&format!("an array: {wanted}, with this array as its field `jobs`")), "{array}");
    assert!(told("[[]]").contains(wanted) && told("7").contains(wanted) && told(r#"{"job":[]}"#).contains(wanted));
    let single = parse_job(b"[]").map(|_| ()).unwrap_err().to_string();
    assert!(single.contains(r#"several jobs are a batch, `{"jobs": […]}`"#), "{single}");
}

fn pointers(refused: Result<crate::contract::Job, Refusal>) -> Vec<String> {
    let Err(Refusal::Invalid { errors }) = refused else { panic!("accepted") };
    errors.into_iter().map(|error| error.pointer).collect()
}

#[test]
fn a_wrong_type_does_not_hide_other_faults() {
    let body = r#"{"kind":"simulation","duration_s":-1,"priority":"high","colour":"red","labels":["a",1],
        "scene":{"bearing":{"preset":"608","ball_diameter_mm":"8","cage":[]},
        "operation":{"speed_rpm":1,"radial_load_y_n":true}}}"#;
    let told = pointers(parse_job(body.as_bytes()));
    for pointer in [
        "/duration_s",
        "/priority",
        "/colour",
        "/labels/1",
        "/scene/bearing/ball_diameter_mm",
        "/scene/bearing/cage",
        "/scene/operation/radial_load_y_n",
    ] {
        assert_eq!(told.iter().filter(|told| *told == pointer).count(), 1, "{pointer}: {told:?}");
    }
    assert_eq!(told.len(), 7, "{told:?}");
    // An operation without its speed is none: what is wrong beyond types stays unseen, but nothing is told twice.
    let required = r#"{"kind":"simulation","duration_s":-1,"labels":7,"scene":{"bearing":"608","operation":{"speed_rpm":"fast"}}}"#;
    assert_eq!(pointers(parse_job(required.as_bytes())), ["/labels", "/scene/operation/speed_rpm"]);
}

#[test]
fn errors_of_a_scene_alone_point_into_it() {
    let scene = r#"{"bearing":{"preset":"608","ball_diameter_mm":-1},"operation":{"speed_rpm":1}}"#;
    assert_eq!(pointers(parse_job_or_scene(scene.as_bytes())), ["/bearing/ball_diameter_mm"]);
    assert_eq!(pointers(parse_accuracy_request(scene.as_bytes(), Some(3))), ["/bearing/ball_diameter_mm"]);
    assert_eq!(pointers(parse_job_or_scene(br#"{"bearing":"608"}"#)), ["/operation"]);
    assert_eq!(
        pointers(parse_job_or_scene(br#"{"bearing":"608","operation":{"speed_rpm":1},"duration_s":1}"#)),
        ["/duration_s"]
    );
    let job = format!(r#"{{"scene":{scene}}}"#);
    assert_eq!(pointers(parse_job_or_scene(job.as_bytes())), ["/scene/bearing/ball_diameter_mm"]);
    assert_eq!(pointers(parse_job_or_scene(b"{}")), ["/scene"]);
    assert_eq!(
        pointers(parse_accuracy_request(br#"{"kind":"accuracy","bearing":"608"}"#, None)),
        ["/bearing", "/scene"]
    );
}

#[test]
fn outputs_that_are_no_object_are_refused() {
    use serde_json::json;
    for kind in ["simulation", "study", "optimum", "accuracy"] {
        for outputs in [json!("auto"), json!(["vibration"]), json!(1), json!(null)] {
            let body = json!({
                "kind": kind, "outputs": outputs, "metric": "/channels/spindle.y.acceleration/level_db",
                "axes": [{ "path": "/operation/speed_rpm", "from": 3000, "to": 4000, "count": 2 }],
                "scene": { "bearing": "608", "operation": { "speed_rpm": 3000 } },
            });
            assert!(parse_job(body.to_string().as_bytes()).is_err(), "{body}");
        }
    }
}
