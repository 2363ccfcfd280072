//! Requests with several errors, or without valid JSON: what is reported, where, and how long it is.

use super::requests::{DIMENSIONS, bearing, job, scene};
use crate::contract::{Refusal, Uploads, parse_accuracy_request, parse_batch, parse_job, parse_job_or_scene};

/// Missing fields and wrong types hide no other errors; errors of numbers state unit and range.
#[test]
fn wrong_types_and_missing_fields_are_reported_together() {
    let body = r#"{"kind":"simulation","duration_s":"1 s","scene":{"bearing":{"preset":"6205","cage":{"land":{}}},
        "operation":{"speed_rpm":"3000"},"spindle":{"mass_kg":-1}}}"#;
    let Err(Refusal::Invalid { errors }) = parse_job(body.as_bytes()) else { panic!("it is wrong") };
    let reported: Vec<(&str, &str)> = errors.iter().map(|e| (e.pointer.as_str(), e.detail.as_str())).collect();
    for (pointer, detail) in [
        ("/duration_s", "expected a number, from 1e-6 to 1000 s"),
        ("/scene/operation/speed_rpm", "from -500000 to 500000 r/min"),
        ("/scene/bearing/cage/land/clearance_mm", "required"),
        ("/scene/bearing/cage/land/diameter_mm", "required"),
        ("/scene/bearing/cage/land/width_mm", "required"),
    ] {
        assert!(reported.iter().any(|(p, d)| *p == pointer && d.contains(detail)), "{pointer}: {reported:?}");
    }
}

/// A refusal is much shorter than the request: forty errors in a key of a million characters, each twice as long in a pointer.
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
        let reported = parse_job(job.as_bytes()).expect_err("no such name").to_string();
        assert!(reported.len() < 5000, "{}", reported.len());
    }
}

#[test]
fn invalid_json_is_distinguished() {
    let deep = "[".repeat(100_000);
    for body in ["", "{", "{}{}", "nope", "{\"kind\":NaN}", &deep, "{\"a\":\"\\ud800\"}"] {
        assert!(matches!(parse_job(body.as_bytes()), Err(Refusal::NotJson { .. })), "{body:.40}");
    }
    assert!(matches!(parse_job(b"{\"kind\":\"\xff\"}"), Err(Refusal::NotJson { .. })));
}

#[test]
fn several_errors_are_reported_at_once() {
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

/// Each wrong field of each part is reported: ranges, names, missing fields and inconsistencies.
#[test]
fn all_errors_are_reported_in_one_response() {
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
    let mut reported = pointers(parse_job(body.as_bytes()));
    reported.sort();
    assert_eq!(reported, wanted);
}

/// An unknown bearing, or a part that cannot be read, hides no other errors and causes no further ones.
#[test]
fn substitutes_for_wrong_parts_cause_no_errors() {
    let reported = |bearing: &str| {
        let body = format!(
            r#"{{"kind":"simulation","scene":{{"bearing":{bearing},"operation":{{"speed_rpm":1}},"spindle":{{"mass_kg":0}}}}}}"#
        );
        pointers(parse_job(body.as_bytes()))
    };
    assert_eq!(reported(r#""6250""#), ["/scene/bearing", "/scene/spindle/mass_kg"]);
    assert_eq!(
        reported(r#"{"preset":"6250","ball_diameter_mm":30,"radial_clearance_um":90,"cage":{"mass_g":0}}"#),
        ["/scene/bearing/preset", "/scene/bearing/cage/mass_g", "/scene/spindle/mass_kg"]
    );
    assert_eq!(
        reported(r#"{"preset":6205,"ball_count":65}"#),
        ["/scene/bearing/preset", "/scene/bearing/ball_count", "/scene/spindle/mass_kg"]
    );
    let damping = scene(r#""damping":{"raceway":{"law":"viscos","viscous_n_s_per_m":10},"pocket":{"restitution":2}}"#);
    assert_eq!(
        pointers(parse_job(damping.as_bytes())),
        ["/scene/damping/raceway/law", "/scene/damping/pocket/restitution"]
    );
}

/// A length in metres is reported at its own field, not at fields that are inconsistent because of it.
#[test]
fn lengths_in_metres_are_reported_at_their_own_fields() {
    let reported = |fields: &str| {
        let Err(Refusal::Invalid { errors }) = parse_job(bearing(fields).as_bytes()) else {
            panic!("accepted: {fields}")
        };
        errors.into_iter().map(|error| (error.pointer, error.detail)).collect::<Vec<_>>()
    };
    let ball = reported(r#""preset":"6205","ball_diameter_mm":0.0127"#);
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
        let reported = reported(&format!(r#"{wrong},"radial_clearance_um":12.5"#));
        assert!(
            reported.len() == 1 && reported[0].0.ends_with(name) && reported[0].1.contains("lengths are in mm"),
            "{reported:?}"
        );
    }
    let all = reported(
        r#""outer_diameter_mm":0.052,"inner_diameter_mm":0.025,"width_mm":0.015,"ball_count":9,"ball_diameter_mm":0.00794,"pitch_diameter_mm":0.03904"#,
    );
    assert!(all.len() == 5 && all.iter().all(|(_, detail)| detail.contains("lengths are in mm")), "{all:?}");
}

#[test]
fn a_bare_array_is_refused_with_the_form_of_a_batch() {
    let reported =
        |body: &str| parse_batch(body.as_bytes(), &Uploads::default(), &|| false).map(|_| ()).unwrap_err().to_string();
    let wanted = "must be an object `{\"jobs\": […]}`";
    let array = reported(&format!("[{}]", job(r#""priority":1"#)));
    assert!(array.contains(&format!("an array: {wanted}, with this array as its field `jobs`")), "{array}");
    assert!(
        reported("[[]]").contains(wanted)
            && reported("7").contains(wanted)
            && reported(r#"{"job":[]}"#).contains(wanted)
    );
    let single = parse_job(b"[]").map(|_| ()).unwrap_err().to_string();
    assert!(single.contains(r#"several jobs are a batch, `{"jobs": […]}`"#), "{single}");
}

fn pointers(refused: Result<crate::contract::Job, Refusal>) -> Vec<String> {
    let Err(Refusal::Invalid { errors }) = refused else { panic!("accepted") };
    errors.into_iter().map(|error| error.pointer).collect()
}

#[test]
fn a_wrong_type_does_not_hide_other_errors() {
    let body = r#"{"kind":"simulation","duration_s":-1,"priority":"high","colour":"red","labels":["a",1],
        "scene":{"bearing":{"preset":"608","ball_diameter_mm":"8","cage":[]},
        "operation":{"speed_rpm":1,"radial_load_y_n":true}}}"#;
    let reported = pointers(parse_job(body.as_bytes()));
    for pointer in [
        "/duration_s",
        "/priority",
        "/colour",
        "/labels/1",
        "/scene/bearing/ball_diameter_mm",
        "/scene/bearing/cage",
        "/scene/operation/radial_load_y_n",
    ] {
        assert_eq!(reported.iter().filter(|reported| *reported == pointer).count(), 1, "{pointer}: {reported:?}");
    }
    assert_eq!(reported.len(), 7, "{reported:?}");
    // Without its speed the operation cannot be read: only wrong types are reported, each once.
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

/// Bytes of editors and shells: a byte-order mark is skipped; UTF-16 and numbers that JSON does not have are named with their place.
#[test]
fn foreign_bytes_are_skipped_or_named() {
    let job = r#"{"kind":"simulation","scene":{"bearing":"6205","operation":{"speed_rpm":3000}}}"#;
    assert!(parse_job(format!("\u{feff}{job}").as_bytes()).is_ok());
    assert!(
        crate::contract::parse_batch(format!("\u{feff}{{\"jobs\":[{job}]}}").as_bytes(), &Uploads::default(), &|| {
            false
        })
        .is_ok()
    );
    let detail = |body: &[u8]| match parse_job(body) {
        Err(Refusal::NotJson { detail }) => detail,
        other => panic!("{:?}", other.map(|_| "a job")),
    };
    let utf16: Vec<u8> = job.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(detail(&[b"\xff\xfe", &utf16[..]].concat()).contains("UTF-16"));
    assert!(detail(&utf16).contains("UTF-16"));
    for name in ["NaN", "Infinity", "-Infinity"] {
        let detail = detail(job.replace("3000", name).as_bytes());
        assert!(detail.starts_with(&format!("{name} at /scene/operation/speed_rpm: ")), "{detail}");
    }
}
