//! Wrong requests, each with the pointer and a part of the reason.

use super::requests::{DIMENSIONS, bearing, job, operation, preset, scene};
use crate::contract::{Refusal, parse_accuracy_request, parse_job};

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
        (scene(r#""spindle":{"tilt":"loose"}"#), "/scene/spindle/tilt", "expected `held` or `free`"),
        (scene(r#""spindle":{"axial_inertia_kg_m2":1e-5}"#), "/scene/spindle/axial_inertia_kg_m2", "goes with `tilt` free"),
        (
            scene(r#""spindle":{"tilt":"free","transverse_inertia_kg_m2":0}"#),
            "/scene/spindle/transverse_inertia_kg_m2",
            "0 kg m²: must be from",
        ),
        (operation(r#""speed_rpm":1,"misalignment_mrad":{"y":21}"#), "/scene/operation/misalignment_mrad/y", "21 mrad"),
        (
            operation(r#""speed_rpm":1,"initial_perturbation":{"speed_mm_s":-1}"#),
            "/scene/operation/initial_perturbation/speed_mm_s",
            "-1 mm/s: must be from 0 to 10000 mm/s",
        ),
        (
            operation(r#""speed_rpm":1,"initial_perturbation":{"seed":1}"#),
            "/scene/operation/initial_perturbation/speed_mm_s",
            "required",
        ),
        (
            operation(r#""speed_rpm":1,"initial_perturbation":{"speed_mm_s":1,"seed":-1}"#),
            "/scene/operation/initial_perturbation/seed",
            "-1: must be a whole number from 0 to 4294967295",
        ),
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
            "unknown bearing `nope`",
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
            "23.401 s: must be from 1e-6 to 23.4 s: the kept series would take more than 512 MiB",
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
            "the method must be `auto`",
        ),
        (scene(r#""terms":{"cage_tilt":"off"}},"solver":{"rung":"full""#), "/solver/rung", "terms.cage_tilt is off"),
        (
            scene(r#""terms":{"cage":"off"}},"solver":{"rung":"radially_condensed""#),
            "/solver/rung",
            "without a cage balls touch each other",
        ),
        (
            scene(
                r#""terms":{"cage":"off"}},"outputs":{"metrics":["vibration"]},"solver":{"rung":"spindle_only""#,
            ),
            "/solver/rung",
            "without a cage",
        ),
        (
            r#"{"kind":"simulation","scene":{"bearing":"article-integrated","operation":{"speed_rpm":1,"initial_perturbation":{"speed_mm_s":1}}},"solver":{"rung":"radially_condensed"}}"#
                .into(),
            "/solver/rung",
            "initial_perturbation",
        ),
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
            "goes with the methods `fine_abm`, `dormand_prince`, and with the rungs `radially_condensed` and `spindle_only`, not with `auto`",
        ),
        (job(r#""solver":{"method":"gear","fixed_step_us":1}"#), "/solver/fixed_step_us", "not with `gear`"),
        (job(r#""solver":{"method":"dormand_prince","fixed_step_us":0}"#), "/solver/fixed_step_us", "0 µs"),
        (job(r#""outputs":{"metrics":["noise"]}"#), "/outputs/metrics/0", "unknown variant"),
        (job(r#""outputs":{"metrics":["cage","cage"]}"#), "/outputs/metrics/1", "more than once"),
        (job(r#""outputs":{"spectra":["spindle.q.acceleration"]}"#), "/outputs/spectra/0", "channels are spindle."),
        (job(r#""outputs":{"spectra":["spindle.x.velocity"]}"#), "/outputs/spectra/0", "axial direction is free"),
        (job(r#""outputs":{"series":["cage.speed","cage.speed"]}"#), "/outputs/series/1", "more than once"),
        (
            job(r#""outputs":{"envelope_band_hz":[9,20000]}"#),
            "/outputs/envelope_band_hz/0",
            "9 Hz: must be from 10 to 25600 Hz",
        ),
        (job(r#""outputs":{"envelope_band_hz":[2000,26000]}"#), "/outputs/envelope_band_hz/1", "26000 Hz: must be"),
        (job(r#""outputs":{"envelope_band_hz":[300,300]}"#), "/outputs/envelope_band_hz", "300 Hz is not below 300 Hz"),
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
        (job(r#""outputs":{"envelope_band_hz":[100,200]}"#), "/outputs/envelope_band_hz", "keeps no signals"),
        (job(r#""reuse":true"#), "/reuse", "its result is never reused"),
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
fn wrong_json_is_refused_with_its_pointer() {
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

/// Nothing is recorded of a shaft without bearings and sensors, so that no channel can be named.
#[test]
fn a_shaft_alone_needs_a_sensor() {
    let support = r#"{"at_mm":0,"stiffness_n_per_um":[0,50,50],"tilt_n_m_per_mrad":[1,1]}"#;
    let scene = format!(
        r#"{{"shaft":{{"sections":[{{"length_mm":300,"outer_diameter_mm":25}}]}},"supports":[{support}],"operation":{{"speed_rpm":50000}}}}"#
    );
    let outputs = r#"{"series":["A.y.acceleration"],"orders":{"tracks":["1"]}}"#;
    let body = format!(r#"{{"kind":"machine","scene":{scene},"outputs":{outputs}}}"#);
    check(&[(body, "/scene/sensors", "without ball bearings nothing else is recorded")]);
}

/// Loads of balls are channels of a machine where the bearing has the ball; pockets are none.
#[test]
fn a_load_of_a_ball_needs_the_ball() {
    let of = |channel: &str| {
        let scene = r#"{"bearings":[{"name":"A","bearing":"6205","at_mm":40}],"operation":{"speed_rpm":5000}}"#;
        format!(r#"{{"kind":"machine","scene":{scene},"outputs":{{"series":["A.ball.9.inner.load","{channel}"]}}}}"#)
    };
    let channels = ["A.ball.10.inner.load", "A.ball.0.outer.load", "B.ball.1.inner.load", "A.ball.1.pocket.load"];
    for channel in channels {
        check(&[(of(channel), "/outputs/series/1", "A.ball.1.inner.load, A.ball.1.outer.load")]);
    }
    check(&[(of("A.ball.9.inner.load"), "/outputs/series/1", "more than once")]);
    let alike = of("A.ball.8.inner.load").replacen('{', r#"{"solver":{"rung":"spindle_only"},"#, 1);
    check(&[(alike, "/solver/rung", "does not tell balls apart")]);
}

/// A sensor measures along a vector of any length that its part can move along.
#[test]
fn a_sensor_needs_a_direction_in_which_its_part_moves() {
    let of = |direction: &str| {
        let sensor = format!(r#"{{"name":"probe","at_mm":100,"direction":{direction}}}"#);
        let supports = r#"[{"at_mm":0,"stiffness_n_per_um":[0,50,50],"tilt_n_m_per_mrad":[1,1]}]"#;
        let sections = r#"[{"length_mm":300,"outer_diameter_mm":25}]"#;
        let scene = format!(
            r#"{{"shaft":{{"sections":{sections}}},"supports":{supports},"sensors":[{sensor}],"operation":{{"speed_rpm":5000}}}}"#
        );
        format!(r#"{{"kind":"machine","scene":{scene}}}"#)
    };
    check(&[
        (of("[0,0,0]"), "/scene/sensors/0/direction", "must have one part that is not 0"),
        (of("[1,1,0]"), "/scene/sensors/0/direction", "does not move along X"),
        (of("[0,1]"), "/scene/sensors/0/direction", "3"),
        (of("45"), "/scene/sensors/0/direction", "three numbers"),
    ]);
}

/// A body of a housing is recorded also where no bearing is, by default with its orders.
#[test]
fn a_housing_without_bearings_has_channels() {
    let scene = r#"{"shaft":{"sections":[{"length_mm":300,"outer_diameter_mm":25}]},
        "supports":[{"at_mm":0,"stiffness_n_per_um":[0,50,50],"tilt_n_m_per_mrad":[1,1]}],
        "housing":{"bodies":[{"name":"frame","mass_kg":5,"at_mm":150}],"mounts":[{"body":"frame","stiffness_n_per_um":[9,9,9],"tilt_n_m_per_mrad":[1,1]}]},
        "operation":{"speed_rpm":3000}}"#;
    let outputs = r#"{"series":["A.y.acceleration"],"orders":{"tracks":["1"]}}"#;
    let body = format!(r#"{{"kind":"machine","scene":{scene},"outputs":{outputs}}}"#);
    check(&[(body, "/outputs/series/0", "frame.y.acceleration")]);
}
