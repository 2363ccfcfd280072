//! `POST /v1/scenes/resolve`, `GET /v1/presets`.

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

#[test]
fn presets_are_listed() {
    let presets = start().get("/v1/presets").json();
    for pointer in ["/bearings/article-integrated", "/bearings/6205", "/materials/gcr15", "/lubricants/grease"] {
        assert!(presets.pointer(pointer).is_some(), "{pointer}");
    }
}
