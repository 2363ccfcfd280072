//! `POST /v1/scenes/resolve`, `GET /v1/presets`, `GET /v1/catalogue`.

use serde_json::json;

use crate::common::Server;
use crate::server::start;

#[test]
fn a_scene_is_resolved_without_a_job() {
    let server = start();
    let scene = json!({ "bearing": "6205", "operation": { "speed_rpm": 6000, "radial_load_y_n": 500 } });
    let answer = server.post("/v1/scenes/resolve", &json!({ "scene": scene }));
    assert_eq!(answer.status, 200, "{answer:?}");
    let resolved = answer.json();
    for pointer in ["/scene/bearing", "/derived/inner_stiffness_n_per_m1_5", "/left_out", "/cost/states"] {
        assert!(resolved.pointer(pointer).is_some(), "{pointer}");
    }
    let again = server.post("/v1/scenes/resolve", &json!({ "scene": resolved["scene"] })).json();
    assert_eq!(again["scene"], resolved["scene"]);
    assert_eq!(server.get("/v1/jobs").json()["jobs"], json!([]));
    let wrong = server.post("/v1/scenes/resolve", &json!({ "scene": { "bearing": 3 } })).problem(422);
    assert!(wrong["errors"][0]["pointer"].as_str().is_some_and(|pointer| pointer.starts_with("/scene")));
}

/// 64 balls that all differ, on wavy raceways, are averaged over many positions of the cage. Meanwhile the service answers others.
#[test]
fn the_service_answers_others_while_it_resolves_a_heavy_scene() {
    let server = start();
    let scene = json!({
        "bearing": {
            "type": "deep_groove", "ball_count": 64, "ball_diameter_mm": 4, "pitch_diameter_mm": 100,
            "outer_diameter_mm": 115, "inner_diameter_mm": 85, "width_mm": 12,
            "inner_groove_curvature": 0.52, "outer_groove_curvature": 0.53, "radial_clearance_um": 5
        },
        "operation": { "speed_rpm": 3000, "radial_load_y_n": 300 },
        "surfaces": {
            "preset": "worn",
            "every_ball": { "diameter_spread_um": 0.5, "random_waviness": { "amplitude_nm": 10, "to_order": 100 } }
        }
    });
    std::thread::scope(|scope| {
        // As many as there are threads for HTTP.
        let heavy: Vec<_> = (0..2)
            .map(|_| scope.spawn(|| server.post("/v1/scenes/resolve", &json!({ "scene": scene })).status))
            .collect();
        let mut answered = 0;
        while !heavy.iter().any(|resolve| resolve.is_finished()) {
            assert_eq!(server.get("/health/live").status, 200);
            answered += 1;
        }
        // The last answer may have waited for the scene.
        assert!(answered > 1, "{answered}");
        heavy.into_iter().for_each(|resolve| assert_eq!(resolve.join().ok(), Some(200)));
    });
}

#[test]
fn presets_are_listed() {
    let presets = start().get("/v1/presets").json();
    for pointer in ["/bearings/article-integrated", "/bearings/6205", "/materials/gcr15", "/lubricants/grease"] {
        assert!(presets.pointer(pointer).is_some(), "{pointer}");
    }
}

#[test]
fn the_catalogue_is_searched() {
    let server = start();
    let found = server.get("/v1/catalogue?series=62&bore_mm=25").json();
    assert_eq!(found["count"], 1);
    let bearing = &found["bearings"][0];
    assert_eq!((&bearing["designation"], &bearing["confidence"]), (&"6205".into(), &"high".into()));
    assert_eq!(bearing["frequencies"]["bpfo"], 3.585);
    assert_eq!(server.get("/v1/catalogue").json()["count"], 394);
    assert_eq!(server.get("/v1/catalogue?q=nothing").json()["count"], 0);
    for query in ["bore_mm=NaN", "min_c_kn=inf", "bore_mm=-1", "bore_mm=x", "unknown=1", "q=1&q=2"] {
        server.get(&format!("/v1/catalogue?{query}")).problem(400);
    }
}
