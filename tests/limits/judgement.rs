//! Single terms left out by judgement: what leaving each out changes is within the bound that was stated before the run.

use raceway::physics::raceway::{RacewayContact, RelativeMotion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::terms::{Grounds, Needs};
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::judgement::{Judge, Omission, within};
use raceway::simulation::solve::run::run;
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient, settings};
use crate::scenes::{article, changed, scene};

/// Scenes of different loads, clearances, speeds, numbers of balls, masses and lubricants.
fn scenes() -> Vec<(&'static str, Value)> {
    let speed_and_load =
        |rpm: f64, newtons: f64| json!({ "operation": { "speed_rpm": rpm, "radial_load_y_n": newtons } });
    let bearing =
        |balls: u32, clearance: f64| json!({ "bearing": { "ball_count": balls, "radial_clearance_um": clearance } });
    let closed = json!({ "bearing": { "radial_clearance_um": 3, "cage": { "seat": "closed", "offset_mm": 0 } } });
    vec![
        ("article", json!({})),
        ("unbalance", json!({ "spindle": { "balance_grade": 6.3 } })),
        ("small clearance", bearing(7, 2.0)),
        ("large clearance, eight balls", bearing(8, 10.0)),
        ("six balls", bearing(6, 5.0)),
        ("50 N", speed_and_load(50_000.0, 50.0)),
        ("400 N", speed_and_load(50_000.0, 400.0)),
        ("60 000 r/min", speed_and_load(60_000.0, 200.0)),
        ("20 000 r/min", speed_and_load(20_000.0, 100.0)),
        ("heavy spindle", json!({ "spindle": { "mass_kg": 0.1 } })),
        ("oil", json!({ "lubricant": "oil" })),
        ("air in place of a mixture", json!({ "lubricant": { "fill": 0 } })),
        ("in the plane", closed),
    ]
}

fn levels_only() -> Outputs {
    Outputs { contacts: false, cage: false, ..settings().outputs }
}

/// 20 ms to settle and 20 ms kept on the dynamics; `tolerance_db` of the model.
fn asked(tolerance_db: f64, outputs: Outputs) -> RunSettings {
    RunSettings {
        model_tolerance_db: tolerance_db,
        rung: Some(ModelLevel::Full),
        duration: 0.02,
        outputs,
        ..settings()
    }
}

fn levels(result: &RunResult) -> [f64; 2] {
    [Y, Z].map(|channel| {
        let found = result.summary.channels.iter().find(|(of, _)| *of == channel);
        found.and_then(|(_, metrics)| metrics.level_db).unwrap()
    })
}

/// By judgement: name and bound of each.
fn judged(needs: &Needs) -> Vec<(&'static str, f64)> {
    let by_judgement = needs.left_out.iter().filter(|left_out| left_out.by == Grounds::Judgement);
    by_judgement.map(|left_out| (left_out.term, left_out.bound.unwrap().0)).collect()
}

fn needs(scene: &Scene, outputs: &Outputs, tolerance_db: f64) -> Needs {
    within(Needs::of(scene, outputs, Some(ModelLevel::Full)).unwrap(), scene, outputs, tolerance_db)
}

/// Errors of integration, of level and repetition, at 1e-5 [dB].
const INTEGRATION: f64 = 2e-3;

/// With a tolerance that lets one term go after the other, and with the default one.
#[test]
fn what_is_left_out_changes_levels_by_no_more_than_its_bound() {
    let mut compared = 0;
    for (name, changes) in scenes() {
        let json = changed(article(), changes);
        let outputs = levels_only();
        let whole = levels(&run(&scene(&json), &asked(0.0, outputs.clone()), &patient()).unwrap());
        let every = judged(&needs(&scene(&json), &outputs, 20.0));
        for tolerance in [0.05, 20.0] {
            let all = judged(&needs(&scene(&json), &outputs, tolerance));
            let bound: f64 = all.iter().map(|(_, bound)| bound).sum();
            if all.is_empty() || (tolerance == 20.0 && bound > 3.0) {
                continue;
            }
            let lean = run(&scene(&json), &asked(tolerance, outputs.clone()), &patient()).unwrap();
            let found = levels(&lean);
            let off = (found[0] - whole[0]).abs().max((found[1] - whole[1]).abs());
            println!("{name}, {tolerance} dB: {off:.4} of {bound:.4} dB, {all:?}");
            assert!(off <= bound + INTEGRATION && bound <= tolerance, "{name}: {off} {bound}");
            // Made again with all terms, or the repetition has them.
            let whole = lean.left_out.iter().all(|one| one.by != Grounds::Judgement);
            assert!(
                whole || lean.summary.solver.check.contains("judgement has left out"),
                "{}",
                lean.summary.solver.check
            );
            compared += 1;
        }
        assert!(!every.is_empty(), "{name}");
    }
    assert!(compared >= 20, "{compared}");
}

/// No tolerance, a term that is on, outputs that it moves, a rattling cage, a speed that varies: it stays in.
#[test]
fn terms_stay_in_where_nothing_lets_them_go() {
    let outputs = levels_only();
    let names = |changes: Value, outputs: &Outputs, tolerance: f64| -> Vec<&'static str> {
        let all = judged(&needs(&scene(&changed(article(), changes)), outputs, tolerance));
        all.into_iter().map(|(name, _)| name).collect()
    };
    assert_eq!(names(json!({}), &outputs, 20.0), ["strips", "drag", "churning"]);
    assert_eq!(names(json!({}), &outputs, 0.0), [""; 0]);
    assert_eq!(names(json!({}), &settings().outputs, 20.0), ["strips"]);
    for (term, left) in [
        ("conformity", &["drag", "churning"][..]),
        ("spin", &["drag", "churning"]),
        ("drag", &["strips", "churning"]),
        ("churning", &["strips", "drag"]),
    ] {
        assert_eq!(names(json!({ "terms": { term: "on" } }), &outputs, 20.0), left, "{term}");
    }
    let ramp = json!([{ "at_s": 0, "rpm": 40_000 }, { "at_s": 1, "rpm": 50_000 }]);
    for changes in [
        json!({ "bearing": { "cage": { "film": "none" } } }),
        json!({ "operation": { "speed_rpm": ramp } }),
        json!({ "operation": { "speed_rpm": 1000 } }),
        json!({ "operation": { "radial_load_y_n": 5 } }),
        json!({ "operation": { "axial_load_n": 30 } }),
        json!({ "lubricant": { "traction": { "law": "four_parameter", "at_slip_m_s": 0.1 } } }),
        json!({ "operation": { "misalignment_mrad": { "y": 1, "z": 0 } } }),
    ] {
        assert_eq!(names(changes.clone(), &outputs, 20.0), [""; 0], "{changes}");
    }
}

/// Bounds of drag fall with its force: air instead of a mixture with a twentieth of grease.
#[test]
fn bounds_follow_the_forces() {
    let bound = |lubricant: Value, omission: Omission| {
        let scene = scene(&changed(article(), json!({ "lubricant": lubricant })));
        let needs = Needs::of(&scene, &levels_only(), Some(ModelLevel::Full)).unwrap();
        let judge = Judge::new(&scene, &needs).unwrap().unwrap();
        judge.bound(omission).unwrap()
    };
    for omission in [Omission::Drag, Omission::Churning] {
        assert!(bound(json!({ "fill": 0.0 }), omission) < 0.1 * bound(json!({ "fill": 0.05 }), omission));
    }
    let points = [2, 4, 6].map(|points| bound(json!({ "fill": 0.05 }), Omission::Strips(points)));
    assert!(points[0] > points[1] && points[1] > points[2], "{points:?}");
}

/// Without spin about the normal a strip and its image slip alike: half of them give the same to rounding.
#[test]
fn folded_strips_are_an_identity() {
    let scene = scene(&article());
    let needs = Needs::of(&scene, &levels_only(), Some(ModelLevel::Full)).unwrap();
    let damping = scene.raceway_damping.resolve();
    let pair = |spin: bool| {
        let terms = raceway::physics::raceway::RacewayTerms { spin, ..needs.raceway };
        RacewayContact::pair(&scene.bearing, &scene.lubricant, damping, terms)
    };
    // A ball 3 µm into the outer raceway, none of whose motion turns about the normal there.
    let motion = RelativeMotion {
        radius: 6.5e-3 + 4.25e-6,
        velocity: [0.0, 0.0, 13.4],
        spin: [-11_600.0, 0.0, 500.0],
        orbit_speed: 2060.0,
        ..RelativeMotion::default()
    };
    let (with, without) = (pair(true).outer.load::<false>(&motion), pair(false).outer.load::<false>(&motion));
    assert!(with.normal > 1.0);
    for k in 0..3 {
        assert!((with.force[k] - without.force[k]).abs() <= 1e-14 * with.normal, "{with:?} {without:?}");
        assert!((with.moment[k] - without.moment[k]).abs() <= 1e-17 * with.normal, "{with:?} {without:?}");
    }
}

/// Where churning was left out, and the repetition with all terms was off by 0.7 dB, that was once taken for noise of the steps:
/// the run without churning was repeated at tighter tolerances, and stood still there.
#[test]
fn terms_left_out_are_not_taken_for_noise() {
    let scene = scene(&changed(
        article(),
        json!({ "operation": { "speed_rpm": 10_000, "radial_load_y_n": 50 }, "lubricant": { "viscosity_pa_s": 0.2 } }),
    ));
    let all = run(&scene, &asked(0.0, levels_only()), &patient()).unwrap();
    let chosen = run(&scene, &asked(0.05, levels_only()), &patient()).unwrap();
    let stated = chosen.summary.accuracy.level_error_db().unwrap();
    for (all, chosen) in levels(&all).into_iter().zip(levels(&chosen)) {
        assert!((all - chosen).abs() < 0.05 && (all - chosen).abs() < 3.0 * stated + 1e-3, "{all} {chosen} {stated}");
    }
}
