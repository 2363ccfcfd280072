//! Studies: axes, points, and what their results say together.

use serde_json::{Value, json};

use crate::contract::{PointEnd, Row, Study, TableAnswer, parse_job};

fn request(axes: Value) -> Value {
    json!({ "kind": "study", "scene": { "bearing": "article-integrated", "operation": { "speed_rpm": 50000 } }, "axes": axes })
}

fn study(axes: Value) -> Study {
    let request = request(axes);
    let job = parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{request}: {refusal}"));
    job.into_study().expect("a study")
}

fn refused(request: &Value) -> String {
    parse_job(request.to_string().as_bytes()).map(|_| ()).expect_err("refused").to_string()
}

#[test]
fn values_are_listed_or_spaced() {
    let study = study(json!([
        { "path": "/operation/speed_rpm", "values": [10000, 30000] },
        { "path": "/spindle/mass_kg", "from": 0.02, "to": 0.2, "count": 3, "scale": "log" },
        { "path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.54, "count": 4 },
    ]));
    assert_eq!(study.points, 24);
    assert_eq!(study.axes[1].values, [0.02, 0.0632455532, 0.2].map(Value::from));
    assert_eq!(study.axes[2].values, [0.51, 0.52, 0.53, 0.54].map(Value::from));
    assert_eq!(study.values(23), [&json!(30000), &json!(0.2), &json!(0.54)]);
}

/// The kind of a part decides its other fields: a dry bearing has not the viscosity of the grease that it would have had.
#[test]
fn a_kind_comes_with_its_own_defaults() {
    let kinds = ["dry", "oil"];
    let found = study(json!([{ "path": "/lubricant/kind", "values": kinds }]));
    let law = study(json!([{ "path": "/damping/raceway/law", "values": ["none"] }]));
    for (point, kind) in kinds.into_iter().enumerate() {
        let mut scene = json!({ "bearing": "article-integrated", "operation": { "speed_rpm": 50000 } });
        scene["lubricant"] = json!({ "kind": kind });
        let job = json!({ "kind": "simulation", "scene": scene });
        let expected = parse_job(job.to_string().as_bytes()).unwrap().scene_json();
        assert_eq!(found.point(point).unwrap().scene_json(), expected, "{kind}");
    }
    assert_eq!(law.point(0).unwrap().scene_json()["damping"]["raceway"]["law"], "none");
}

/// A point is the simulation that the request with its values would be: what follows from a value follows.
#[test]
fn a_point_is_the_request_with_its_values() {
    let both = study(json!([
        { "path": "/operation/axial_load_n", "values": [0, 12] },
        { "path": "/bearing/cage/pocket_clearance_mm", "values": [0.04] },
        { "path": "/lubricant/viscosity_pa_s", "values": [0.05] },
        { "path": "/bearing/materials/ball/elastic_modulus_gpa", "values": [310] },
    ]));
    let (unloaded, loaded) = (both.point(0).unwrap(), both.point(1).unwrap());
    let complete = loaded.scene_json();
    assert_eq!(unloaded.scene_json()["spindle"]["axial"], "fixed");
    assert_eq!(complete["spindle"]["axial"], "free");
    assert_eq!(complete["bearing"]["cage"]["pocket_clearance_mm"], 0.04);
    assert_eq!(complete["lubricant"]["viscosity_pa_s"], 0.05);
    assert_eq!(complete["bearing"]["materials"]["ball"]["elastic_modulus_gpa"], 310.0);
    // All else is that of the preset.
    let mut base = parse_job(
        json!({ "kind": "simulation", "scene": { "bearing": "article-integrated",
            "operation": { "speed_rpm": 50000, "axial_load_n": 12 } } })
        .to_string()
        .as_bytes(),
    )
    .unwrap()
    .scene_json();
    base["bearing"]["cage"]["pocket_clearance_mm"] = json!(0.04);
    base["lubricant"]["viscosity_pa_s"] = json!(0.05);
    base["bearing"]["materials"]["ball"]["elastic_modulus_gpa"] = json!(310.0);
    let materials = |scene: &mut Value| scene["bearing"].as_object_mut().unwrap().remove("materials");
    let (mut of_point, mut of_base) = (complete, base);
    assert_eq!(
        materials(&mut of_point).unwrap()["ball"]["poisson_ratio"],
        materials(&mut of_base).unwrap()["ball"]["poisson_ratio"]
    );
    assert_eq!(of_point, of_base);
}

#[test]
fn an_axial_load_can_be_a_share_of_the_rating() {
    let study = study(json!([
        { "quantity": "axial_load_over_rating", "values": [0.005] },
        { "path": "/bearing/ball_count", "values": [7, 6] },
    ]));
    let load = |point: usize| study.point(point).unwrap().scene().operation.load[0];
    assert!((load(0) / (0.005 * 1786.0) - 1.0).abs() < 3e-3, "{}", load(0));
    assert!((load(1) / load(0) - (6.0_f64 / 7.0).powf(2.0 / 3.0)).abs() < 1e-3);
}

#[test]
fn wrong_axes_are_refused_with_their_place() {
    let path = "/spindle/mass_kg";
    for (axes, told) in [
        (json!([]), "/axes: 0 axes: must be from 1 to 4"),
        (json!([{ "values": [1] }]), "/axes/0: takes either `path` or `quantity`"),
        (json!([{ "path": "spindle", "values": [1] }]), "/axes/0/path: must be a JSON pointer"),
        (json!([{ "path": path }]), "/axes/0: takes either `values` or all of"),
        (json!([{ "path": path, "values": [] }]), "/axes/0/values: 0 values"),
        (json!([{ "path": path, "values": [1, 2, 1] }]), "/axes/0/values/2: given more than once"),
        (json!([{ "path": path, "values": [[1]] }]), "/axes/0/values/0: must be a number or a name"),
        (json!([{ "path": path, "from": -1, "to": 1, "count": 3, "scale": "log" }]), "/axes/0/scale: `log` needs"),
        (json!([{ "path": path, "from": 1, "to": 1, "count": 3 }]), "/axes/0/to: the same as `from`"),
        (json!([{ "path": path, "from": 1, "to": 2, "count": 1 }]), "/axes/0/count: 1: must be from 2"),
        (json!([{ "path": path, "from": 1, "to": 2, "count": 3, "scale": "cubic" }]), "unknown scale `cubic`"),
        (json!([{ "quantity": "luck", "values": [1] }]), "/axes/0/quantity: unknown quantity `luck`"),
        (json!([{ "quantity": "axial_load_over_rating", "values": ["much"] }]), "takes numbers"),
        (
            json!([{ "path": path, "values": [1] }, { "path": path, "values": [2] }]),
            "/axes/1: `/spindle/mass_kg` is already varied",
        ),
        (
            json!([{ "path": path, "from": 1, "to": 2, "count": 101 }, { "path": "/operation/speed_rpm", "from": 1, "to": 2, "count": 100 }]),
            "/axes: a grid of 10100 points: at most 10000",
        ),
        (json!([{ "path": "/spindle/colour", "values": [1, 2] }]), "/axes/0/path: unknown field `colour`"),
        (json!([{ "path": "/nothing/here", "values": [1] }]), "/axes/0/path: the scene has no `/nothing`"),
        (json!([[]]), "/axes/0"),
        (json!([{ "path": path, "values": [1, 1.0] }]), "/axes/0/values/1: given more than once"),
        (json!([{ "path": path, "values": ["x".repeat(201)] }]), "/axes/0/values/0: more than 200 characters"),
        (json!([{ "path": format!("/{}", "x".repeat(200)), "values": [1] }]), "/axes/0/path: 201 characters"),
        (json!([{ "path": path, "from": -1e308, "to": 1e308, "count": 3 }]), "/axes/0/to: too far from"),
        (json!([{ "path": path, "from": 1e-300, "to": 1e300, "count": 3, "scale": "log" }]), "/axes/0/to: too far"),
        (json!([{ "path": path, "from": 500, "to": 500.0000001, "count": 4 }]), "/axes/0/to: too close to `from`"),
        (
            json!([{ "path": "/lubricant", "values": ["grease", "oil"] }, { "path": "/lubricant/fill", "values": [0.1] }]),
            "/axes/1: `/lubricant/fill` sets the field of the axis `/lubricant`, or a part of it",
        ),
        (
            json!([{ "path": "/operation/axial_load_n", "values": [1] }, { "quantity": "axial_load_over_rating", "values": [0.01] }]),
            "/axes/1: `axial_load_over_rating` sets the field of the axis `/operation/axial_load_n`",
        ),
    ] {
        let found = refused(&request(axes.clone()));
        assert!(found.contains(told), "{axes}: {found}");
    }
    let mut with_signals = request(json!([{ "path": path, "values": [0.1] }]));
    with_signals["outputs"] = json!({ "series": ["cage.speed"] });
    assert!(refused(&with_signals).contains("/outputs/series: a job of kind `study` keeps no signals"));
    let mut simulation = request(json!([{ "path": path, "values": [0.1] }]));
    simulation["kind"] = json!("simulation");
    assert!(refused(&simulation).contains("/axes: goes with the kinds `study` and `optimum`"));
}

/// Each check of a value builds a scene.
#[test]
fn no_value_of_a_refused_grid_is_checked() {
    let negative = |count: i32| (1..=count).map(|k| -f64::from(k)).collect::<Vec<_>>();
    let of = |count| {
        let values = negative(count);
        refused(&request(json!([
            { "path": "/spindle/mass_kg", "values": values }, { "path": "/operation/speed_rpm", "values": values },
        ])))
    };
    assert!(of(2).contains("/axes/0/values/0"));
    let found = of(450);
    assert!(found.contains("/axes: a grid of 202500 points") && !found.contains("/values/"), "{found}");
}

/// Values that fit each other only in places make rows; a value that can be nowhere is refused.
#[test]
fn a_point_that_cannot_be_built_says_why() {
    let study = study(json!([
        { "path": "/bearing/ball_count", "values": [7, 12] },
        { "path": "/bearing/ball_diameter_mm", "values": [2.778, 4.0] }
    ]));
    assert!(study.point(3).is_err() && (0..3).all(|point| study.point(point).is_ok()));
    let row = Row::queued(&study, 3).ended(PointEnd::Failed(study.point(3).unwrap_err().into()));
    let error = row.error.expect("an error");
    assert_eq!((error.cause.as_str(), error.errors[0].pointer.as_str()), ("invalid", "/scene/bearing/ball_count"));
}

#[test]
fn values_that_can_be_nowhere_are_refused_one_by_one() {
    for (axes, told) in [
        (
            json!([{ "path": "/bearing", "values": ["6205", "608", "6250"] }]),
            vec!["/axes/0/values/2: unknown bearing `6250`; known are `article-integrated`"],
        ),
        (
            json!([{ "path": "/lubricant", "values": ["greese", "oil"] }, { "path": "/spindle/mass_kg", "values": [0.05, -1, "much"] }]),
            vec![
                "/axes/0/values/0: unknown lubricant `greese`",
                "/axes/1/values/1: -1 kg: must be from 1e-9",
                "/axes/1/values/2: invalid type: string",
            ],
        ),
        (
            json!([{ "path": "/bearing/ball_diameter_mm", "values": [2.778, 6] }]),
            vec!["/axes/0/values/1: `/bearing/ball_count`: 7 balls of 6.0000 mm overlap"],
        ),
        (
            json!([{ "path": "/bearing/inner_groove_curvature", "from": 0.4, "to": 0.53, "count": 10000 }]),
            vec!["/axes/0/from: 0.4: must be above 0.5 and at most 1", "/axes/0/count: at 0.40"],
        ),
        (
            json!([{ "path": "/bearing/ball_count", "from": 6, "to": 8, "count": 4 }]),
            vec!["/axes/0/count: at 6.66666667: 6.66666667: must be a whole number"],
        ),
        (json!([{ "path": "/scene/spindle/mass_kg", "values": [1] }]), vec!["/axes/0/path: the scene has no `/scene`"]),
    ] {
        let found = refused(&request(axes.clone()));
        assert!(told.iter().all(|told| found.contains(told)) && !found.contains("`/scene/"), "{axes}: {found}");
        assert_eq!(found.matches("/axes/").count(), told.len(), "{found}");
    }
    let mut request = request(json!([{ "path": "/bearing", "values": ["6205", "6250"] }]));
    request["priority"] = json!(9);
    let both = refused(&request);
    assert!(both.contains("/axes/0/values/1") && both.contains("/priority"), "{both}");
}

#[test]
fn the_table_tells_the_best_point_and_what_may_be_as_good() {
    let study = study(json!([{ "path": "/spindle/mass_kg", "values": [0.02, 0.05, 0.1, 0.2] }]));
    let row = |point: usize, level: f64, error: f64| {
        let metrics = json!({
            "channels": { "spindle.y.acceleration": { "level_db": level, "peak": level } },
            "kinematics": { "cage_slip": level - 60.1 },
            "solver": { "rung": "full" },
            "accuracy": { "level_error_db": error, "cage_slip_error": 0.0098 }
        });
        Row::queued(&study, point).ended(PointEnd::Succeeded(metrics))
    };
    let failed = PointEnd::Failed(crate::contract::RunFailure::Cancelled.into());
    let rows = vec![row(0, 63.0, 0.1), row(1, 60.0, 0.1), row(2, 60.15, 0.1), Row::queued(&study, 3).ended(failed)];
    let table = TableAnswer::of(&study, rows);
    assert_eq!((table.points, table.ended, table.succeeded), (4, 4, 3));
    let level = "/channels/spindle.y.acceleration/level_db";
    let best = &table.best[level];
    assert_eq!((&best.point["/spindle/mass_kg"], best.value, best.as_good), (&json!(0.05), 60.0, Some(2)));
    assert_eq!(best.within.as_ref().unwrap()["/spindle/mass_kg"], json!([0.05, 0.1]));
    assert_eq!((best.goal.as_str(), best.error), ("minimum", Some(0.1)));
    let peak = &table.best["/channels/spindle.y.acceleration/peak"];
    assert_eq!(
        (peak.value, peak.error, peak.as_good, &peak.within),
        (60.0, None, None, &None),
        "its error is not known"
    );
    let slip = &table.best["/kinematics/cage_slip"];
    assert_eq!(
        (slip.goal.as_str(), &slip.point["/spindle/mass_kg"], slip.as_good),
        ("nearest_zero", &json!(0.1), Some(1))
    );
    let either_sign = vec![row(0, 60.0, 0.1), row(1, 60.12, 0.1), row(2, 60.15, 0.1), row(3, 63.0, 0.1)];
    let slip = TableAnswer::of(&study, either_sign).best["/kinematics/cage_slip"].clone();
    assert!((slip.value - 0.02).abs() < 1e-9 && (slip.error.unwrap() - 0.0098).abs() < 1e-9, "{slip:?}");
    let trend = &table.trends[level];
    assert_eq!((trend.span, trend.resolved), (3.0, Some(true)));
    let columns = [
        "/accuracy/cage_slip_error",
        "/accuracy/level_error_db",
        level,
        "/channels/spindle.y.acceleration/peak",
        "/kinematics/cage_slip",
    ];
    assert_eq!(table.columns(), columns);
    let csv = crate::contract::answer::csv::table_csv(&table);
    assert_eq!(csv.lines().count(), 5);
    assert!(csv.starts_with("/spindle/mass_kg,status,error,/solver/rung,/accuracy/cage_slip_error,"), "{csv}");
    assert!(csv.lines().nth(2).unwrap().starts_with("0.05,succeeded,,full,0.0098,0.1,60.0,60.0,-0.1"), "{csv}");
    assert!(csv.lines().nth(4).unwrap().starts_with("0.2,failed,the run was cancelled,,,,"), "{csv}");
}

#[test]
fn a_study_resolves_to_its_points_and_the_cost_of_one() {
    let request = request(json!([{ "path": "/spindle/mass_kg", "values": [0.02, 0.05, 0.1] }]));
    let answer = crate::contract::resolve_answer(&parse_job(request.to_string().as_bytes()).unwrap()).unwrap();
    assert_eq!((answer.points, answer.rungs.len()), (Some(3), 2));
    let (estimate, most) = (answer.cost.estimated_wall_time_s.unwrap(), answer.cost.most_wall_time_s.unwrap());
    assert!(most > 2.0 * estimate, "{estimate} {most}");
}

/// Each value takes the whole scene to check: of a long list beside a large scene some are, the first and the last among them.
#[test]
fn long_lists_are_checked_in_places() {
    let profile: Vec<Value> = (0..1000).map(|i| json!({ "at_s": i, "rpm": 1000 + i })).collect();
    let refused = |wrong: usize| {
        let mut values: Vec<f64> = (1..=10_000).map(f64::from).collect();
        values[wrong] = -1e9;
        let axes = json!([{ "path": "/operation/radial_load_y_n", "values": values }]);
        let job = json!({ "kind": "study", "duration_s": 0.01, "axes": axes,
            "scene": { "bearing": "6205", "operation": { "speed_rpm": profile.clone() } } });
        parse_job(job.to_string().as_bytes()).err().map(|refusal| refusal.to_string())
    };
    for wrong in [0, 9999] {
        assert!(refused(wrong).is_some_and(|told| told.contains(&format!("/axes/0/values/{wrong}"))), "{wrong}");
    }
    assert_eq!(refused(1), None);
}

/// Radial loads y + z = x + u, u uniform ± ½: the narrow valley at 0 is best without scatter, the wide one at 3 with it.
#[test]
fn a_study_over_uncertain_inputs_shows_a_statistic_at_each_point() {
    let mut request = request(json!([{ "path": "/operation/radial_load_y_n", "values": [0, 1.5, 3] }]));
    request["inputs"] = json!([{ "path": "/operation/radial_load_z_n",
        "distribution": { "type": "uniform", "from": -0.5, "to": 0.5 } }]);
    let job = parse_job(request.to_string().as_bytes()).unwrap_or_else(|refusal| panic!("{request}: {refusal}"));
    let study = job.into_study().expect("a study");
    assert_eq!((study.points, study.samples()), (96, 32));
    let row = |number: usize| {
        let operation = study.point(number).unwrap().scene_json()["operation"].take();
        let z = operation["radial_load_y_n"].as_f64().unwrap() + operation["radial_load_z_n"].as_f64().unwrap();
        let level = (20.0 * z.abs()).min(4.0 + (z - 3.0).abs());
        Row::queued(&study, number).ended(PointEnd::Succeeded(json!({
            "channels": { "spindle.y.acceleration": { "level_db": level, "level_error_db": 1e-3, "resolved": number != 40 } },
            "messages": [{ "code": "a", "severity": "warning" }, { "code": if number == 40 { "b" } else { "c" } }],
        })))
    };
    let failed = || PointEnd::Failed(crate::contract::RunFailure::Cancelled.into());
    let rows = |ended: usize| (0..96).map(|k| if k < ended { row(k) } else { Row::queued(&study, k) }).collect();
    let table = TableAnswer::of(&study, rows(96));
    let level = "/channels/spindle.y.acceleration/level_db";
    assert_eq!((table.points, table.ended, table.succeeded), (3, 3, 3));
    let column = table.column(level);
    let [narrow, _, wide] = [0, 1, 2].map(|point| column[point].unwrap());
    // P90 of 20 |u| is 9 but for the other valley, of 4 + |u| 4.45.
    assert!((narrow.0 - 7.4).abs() < 0.2 && (wide.0 - 4.45).abs() < 0.03, "{narrow:?} {wide:?}");
    assert!(wide.1.is_some_and(|error| error < 0.15), "{wide:?}");
    assert_eq!(table.best[level].point["/operation/radial_load_y_n"], json!(3));
    let middle = &table.rows[1];
    assert_eq!(middle.samples.as_ref().unwrap().succeeded, 32);
    let codes: Vec<&Value> = middle.metrics.as_ref().unwrap()["messages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|message| &message["code"])
        .collect();
    assert_eq!(codes, ["a", "c", "b"]);
    assert_eq!(middle.text("/messages/warning").as_deref(), Some("a"));

    let half = TableAnswer::of(&study, rows(40));
    let statuses: Vec<_> = half.rows.iter().map(|row| serde_json::to_value(row.status).unwrap()).collect();
    assert_eq!(statuses, ["succeeded", "running", "queued"]);
    assert!(half.rows[1].metrics.is_none());
    let without = (0..96).map(|k| if k < 32 { Row::queued(&study, k).ended(failed()) } else { row(k) }).collect();
    let without = TableAnswer::of(&study, without);
    assert_eq!((without.rows[0].error.is_some(), without.succeeded, without.ended), (true, 2, 3));

    // The same samples at every point.
    let z = |number: usize| study.point(number).unwrap().scene_json()["operation"]["radial_load_z_n"].take();
    assert_eq!((z(3), z(3)), (z(35), z(67)));
    let refused_with = |field: &str, value: Value| {
        let mut wrong = request.clone();
        wrong[field] = value;
        refused(&wrong)
    };
    assert!(refused_with("samples", json!(4096)).contains("/samples: 4096: 3 points are 12288 simulations"));
    assert!(refused_with("design", json!("sobol")).contains("/design: goes with the kind `uncertainty`"));
    let same =
        json!([{ "path": "/operation/radial_load_y_n", "distribution": { "type": "uniform", "from": 0, "to": 1 } }]);
    assert!(refused_with("inputs", same).contains("/inputs/0: `/operation/radial_load_y_n` is already varied"));
    let unknown = json!([{ "path": "/operation/nonsense", "distribution": { "type": "uniform", "from": 0, "to": 1 } }]);
    assert!(refused_with("inputs", unknown).contains("/inputs/0/path"));
    let mut alone = request.clone();
    alone.as_object_mut().unwrap().remove("inputs");
    alone["statistic"] = json!("mean");
    assert!(refused(&alone).contains("/statistic: `study` takes it with `inputs` only"));
}
