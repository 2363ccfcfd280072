//! Which rung a scene is simulated on, and what the result says of it.

use raceway::numerics::ode::Method;
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::terms::Grounds;
use raceway::simulation::result::metrics::Summary;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::ladder::needs;
use raceway::simulation::solve::run::run;
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient, settings};
use crate::scenes::{article, changed, scene};

/// 20 ms to settle, 40 ms kept; `all`: contacts and cage, too.
fn asked(all: bool, rung: Option<ModelLevel>) -> RunSettings {
    let outputs = Outputs { contacts: all, cage: all, ..settings().outputs };
    RunSettings { rung, model_tolerance_db: 0.05, settle: 0.02, duration: 0.04, outputs, ..settings() }
}

fn simulate(json: &Value, settings: &RunSettings) -> RunResult {
    run(&scene(json), settings, &patient()).unwrap()
}

/// Levels of y and z [dB].
fn levels(result: &RunResult) -> [f64; 2] {
    [Y, Z].map(|channel| {
        let found = result.summary.channels.iter().find(|(of, _)| *of == channel);
        found.and_then(|(_, metrics)| metrics.level_db).unwrap()
    })
}

fn apart(a: &RunResult, b: &RunResult) -> f64 {
    let (a, b) = (levels(a), levels(b));
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// What is chosen is within what was asked, and what it states of itself is right within a factor of three.
#[test]
fn the_leanest_rung_that_is_confirmed_makes_the_result() {
    let full = simulate(&article(), &asked(true, Some(ModelLevel::Full)));
    for (all, expected) in [(true, "radially_condensed"), (false, "periodic")] {
        let result = simulate(&article(), &asked(all, None));
        let (solver, accuracy) = (&result.summary.solver, &result.summary.accuracy);
        let (off, stated) = (apart(&result, &full), accuracy.level_error_db().unwrap());
        println!("{}: {off:.4} dB off, {stated:.4} stated; {}", solver.rung, solver.check);
        assert_eq!(solver.rung, expected);
        assert!(off < 0.05 && off < 3.0 * stated && stated <= 0.05, "{off} {stated}");
        assert_eq!((&accuracy.warning, result.summary.contacts.is_some()), (&None, all));
        let bound = |term: &str| {
            let left_out = result.left_out.iter().find(|left_out| left_out.term == term)?;
            (left_out.by == Grounds::Judgement).then_some(left_out.bound?.0)
        };
        assert_eq!(bound("ball_radial_dynamics"), Some(stated));
        assert_eq!(bound("cage_tilt"), Some(stated));
    }
}

/// A heavy shaft under little load bounces on its balls long after a check from the start, which tells nothing of that: by name the rung
/// warns, by itself it is not taken.
#[test]
fn a_spindle_that_is_thrown_about_is_left_to_the_dynamics() {
    let light = json!({ "bearing": "6205", "operation": { "speed_rpm": 6000, "radial_load_y_n": 18.3 } });
    let asked = |rung| RunSettings { settle: 0.1, duration: 0.1, ..asked(false, rung) };
    let chosen = simulate(&light, &asked(None)).summary;
    assert_eq!(chosen.solver.rung, "full");
    assert!(chosen.solver.check.contains("thrown about"), "{}", chosen.solver.check);
    let condensed = simulate(&light, &asked(Some(ModelLevel::RadiallyCondensed))).summary;
    assert!(condensed.accuracy.warning.unwrap().contains("thrown about"));
}

/// Largest load and cage speed are those of the full dynamics, too.
#[test]
fn contacts_and_cage_of_the_condensed_rung_are_those_of_the_full_dynamics() {
    let full = simulate(&article(), &asked(true, Some(ModelLevel::Full))).summary;
    let lean = simulate(&article(), &asked(true, Some(ModelLevel::RadiallyCondensed))).summary;
    let near = |a: f64, b: f64, within: f64| assert!((a / b - 1.0).abs() < within, "{a} {b}");
    let (a, b) = (lean.contacts.unwrap().raceway, full.contacts.unwrap().raceway);
    near(a.inner.max_load, b.inner.max_load, 5e-3);
    near(a.outer.max_load, b.outer.max_load, 5e-3);
    near(a.inner.max_slip, b.inner.max_slip, 0.05);
    near(a.inner.min_film_thickness.unwrap(), b.inner.min_film_thickness.unwrap(), 0.02);
    let (a, b) = (lean.cage.unwrap(), full.cage.unwrap());
    near(a.speed, b.speed, 1e-4);
    near(a.ball_spin, b.ball_spin, 1e-3);
    near(lean.frequencies.ball_pass_outer, full.frequencies.ball_pass_outer, 1e-4);
}

/// What is stated of the largest load holds over a time that its check has not seen, in bearings of several sizes, speeds and
/// contacts, against the full dynamics with all terms at a tight tolerance.
#[test]
fn the_stated_error_of_the_largest_load_holds() {
    let scene = |bearing: &str, speed: f64, load: f64, grade: f64| {
        let operation = json!({ "speed_rpm": speed, "radial_load_y_n": load });
        json!({ "bearing": bearing, "operation": operation, "spindle": { "balance_grade": grade } })
    };
    for (json, duration) in [
        (scene("6205", 3000.0, 500.0, 6.3), 0.06),
        (scene("6205", 9000.0, 1000.0, 1.0), 0.04),
        (scene("608", 20_000.0, 100.0, 2.5), 0.03),
        (scene("article-deep-groove", 30_000.0, 400.0, 6.3), 0.02),
        (article(), 0.02),
    ] {
        let asked = RunSettings { duration, ..asked(true, Some(ModelLevel::RadiallyCondensed)) };
        let exact = RunSettings {
            rung: Some(ModelLevel::Full),
            model_tolerance_db: 0.0,
            relative_tolerance: 1e-8,
            ..asked.clone()
        };
        let [lean, full] = [&asked, &exact].map(|settings| simulate(&json, settings).summary);
        let largest = |summary: &Summary| {
            let raceway = &summary.contacts.as_ref().unwrap().raceway;
            raceway.inner.max_load.max(raceway.outer.max_load)
        };
        let off = (largest(&lean) / largest(&full) - 1.0).abs();
        let stated = lean.accuracy.quantity_errors.unwrap().max_load;
        println!("{}: {off:.2e} off, {stated:.2e} stated", json["bearing"]);
        assert!(off <= stated && stated < 5e-4, "{json}: {off:e} {stated:e}");
    }
}

/// Reduced rungs are left where they do not serve, and the result says why.
#[test]
fn the_dynamics_are_taken_where_no_reduced_rung_serves() {
    let rung_of = |changes: Value, settings: &RunSettings| {
        let solver = simulate(&changed(article(), changes), settings).summary.solver;
        (solver.rung, solver.check)
    };
    let chaotic = json!({ "bearing": { "cage": { "film": "none" } } });
    let (rung, why) = rung_of(chaotic, &asked(true, None));
    assert!(rung == "full" && why.contains("radially_condensed was not confirmed: 6.000 ms on the rung full"), "{why}");
    let axial = json!({ "operation": { "axial_load_n": 12 } });
    let plain = json!({});
    let closed = json!({ "bearing": { "cage": { "seat": "closed", "offset_mm": 0 } } });
    let ramp = json!({ "operation": { "speed_rpm": [{ "at_s": 0, "rpm": 20_000 }, { "at_s": 0.06, "rpm": 25_000 }] } });
    let exact = RunSettings { model_tolerance_db: 0.0, ..asked(true, None) };
    let gear = RunSettings { method: Method::Gear, ..asked(true, None) };
    let short = RunSettings { settle: 5e-3, duration: 5e-3, ..asked(true, None) };
    for (name, changes, settings, rung) in [
        ("an axial load", axial, &asked(true, None), "full"),
        ("no tolerance", plain.clone(), &exact, "full"),
        ("no tolerance, nothing leaves the plane", closed, &exact, "planar"),
        ("a method by name", plain.clone(), &gear, "full"),
        ("not worth a check", plain.clone(), &short, "full"),
        ("speeds that a check does not see", ramp, &asked(true, None), "full"),
    ] {
        assert_eq!(rung_of(changes, settings).0, rung, "{name}");
    }
}

/// P_d 10 µm at 40 000 r/min: the motion repeats after two balls, not after one.
#[test]
fn a_periodic_motion_that_is_unstable_is_never_the_answer() {
    let json =
        changed(article(), json!({ "bearing": { "radial_clearance_um": 10 }, "operation": { "speed_rpm": 40_000 } }));
    let chosen = simulate(&json, &asked(false, None)).summary.solver;
    assert_ne!(chosen.rung, "periodic");
    let by_name = run(&scene(&json), &asked(false, Some(ModelLevel::Periodic)), &patient());
    let words = by_name.unwrap_err().to_string();
    assert!(words.contains("the rung periodic does not serve"), "{words}");
}

/// Without load and weight the spindle floats between the balls: every place is as good, and no disturbance dies out.
#[test]
fn a_spindle_that_nothing_holds_has_no_periodic_motion() {
    let json = changed(article(), json!({ "operation": { "radial_load_y_n": 0 }, "terms": { "gravity": "off" } }));
    let words = run(&scene(&json), &asked(false, Some(ModelLevel::Periodic)), &patient()).unwrap_err().to_string();
    assert!(words.contains("it touches no ball"), "{words}");
    assert_ne!(simulate(&json, &asked(false, None)).summary.solver.rung, "periodic");
}

/// A rung asked for by name is run and checked, and warns where it is not confirmed.
#[test]
fn a_rung_by_name_that_is_not_confirmed_warns() {
    let settings = RunSettings { model_tolerance_db: 1e-3, ..asked(false, Some(ModelLevel::SpindleOnly)) };
    let summary = simulate(&article(), &settings).summary;
    assert_eq!((summary.solver.rung, summary.solver.method), ("spindle_only", "adams_moulton"));
    let warning = summary.accuracy.warning.unwrap();
    assert!(warning.contains("spindle_only was asked for and is not confirmed within 0.0007 dB"), "{warning}");
}

/// Nothing turns, or hardly: a check is no longer than the run.
#[test]
fn rungs_by_name_of_a_bearing_at_rest_end() {
    for rpm in [0.0, 1e-3] {
        let json = changed(article(), json!({ "operation": { "speed_rpm": rpm } }));
        for rung in [ModelLevel::RadiallyCondensed, ModelLevel::SpindleOnly] {
            let brief = RunSettings { settle: 2e-3, duration: 4e-3, ..asked(false, Some(rung)) };
            let summary = simulate(&json, &brief).summary;
            assert_eq!(summary.solver.rung, rung.name());
        }
    }
}

/// A check from the start tells nothing of a speed that changes later, nor of less than it compares.
#[test]
fn rungs_by_name_whose_check_tells_nothing_say_so() {
    let slows = json!({ "operation": { "speed_rpm": [{ "at_s": 0, "rpm": 50_000 }, { "at_s": 0.03, "rpm": 3_000 }] } });
    let brief = RunSettings { settle: 1e-3, duration: 5e-4, ..asked(false, Some(ModelLevel::SpindleOnly)) };
    for (changes, settings, words) in [
        (slows, asked(false, Some(ModelLevel::RadiallyCondensed)), "the speed varies"),
        (json!({}), brief, "less is kept than a check compares"),
    ] {
        let accuracy = simulate(&changed(article(), changes), &settings).summary.accuracy;
        assert_eq!((accuracy.level_error_db(), accuracy.quantity_errors), (None, None));
        assert!(accuracy.warning.is_some_and(|warning| warning.contains(words)));
    }
}

/// The rung that it is checked against does not hold at 500 000 r/min.
#[test]
fn a_rung_by_name_is_run_even_where_its_check_fails() {
    // A cage so light that the rung above needs steps too short to be worth it.
    let light = json!({ "mass_g": 1e-6, "axial_inertia_kg_m2": 4e-14, "transverse_inertia_kg_m2": 2e-14 });
    let json = changed(article(), json!({ "bearing": { "cage": light } }));
    let summary = simulate(&json, &asked(false, Some(ModelLevel::SpindleOnly))).summary;
    assert!(summary.solver.check.starts_with("not checked: "), "{}", summary.solver.check);
    assert!(summary.accuracy.warning.is_some() && summary.accuracy.level_error_db().is_none());
}

/// A speed that rises so fast throws balls against the walls of their pockets, which steps of 9.8 µs do not bear.
#[test]
fn a_rung_by_name_takes_shorter_steps_where_its_own_lose_the_motion() {
    let rising = json!([{ "at_s": 0.02, "rpm": 3000 }, { "at_s": 0.025, "rpm": 60_000 }]);
    let json = changed(article(), json!({ "operation": { "speed_rpm": rising } }));
    let made = |rung| simulate(&json, &asked(false, Some(rung)));
    let (condensed, full) = (made(ModelLevel::RadiallyCondensed), made(ModelLevel::Full));
    let steps = condensed.summary.solver.statistics.steps;
    println!("{steps} steps, {} dB apart", apart(&condensed, &full));
    assert!(steps > 20_000 && apart(&condensed, &full) < 0.1, "{steps}, {}", apart(&condensed, &full));
}

#[test]
fn a_reduced_run_can_be_stopped_and_repeats_bit_for_bit() {
    let settings = asked(true, None);
    let stopped = run(&scene(&article()), &settings, &Control::until(&|| true));
    assert!(
        matches!(stopped, Err(raceway::simulation::model::failure::SimulationError::Stopped { .. })),
        "{stopped:?}"
    );
    let (a, b) = (simulate(&article(), &settings), simulate(&article(), &settings));
    assert_eq!((a.spectra, a.summary.channels, a.left_out), (b.spectra, b.summary.channels, b.left_out));
}

/// What goes on after a check is not what was checked: balls that wander in wide pockets, of a cage that does not tilt.
#[test]
fn slow_motions_that_go_on_after_the_check_are_left_to_the_dynamics() {
    let wide = json!({
        "bearing": { "preset": "608", "cage": { "pocket_clearance_mm": 0.4, "seat": "closed", "offset_mm": 0 } },
        "operation": { "speed_rpm": 20000, "radial_load_y_n": 50 }
    });
    let loose = RunSettings { relative_tolerance: 1e-3, model_tolerance_db: 0.1, ..asked(true, None) };
    let result = simulate(&wide, &loose);
    let solver = &result.summary.solver;
    assert!(solver.rung == "planar" && solver.check.contains("after the check"), "{}: {}", solver.rung, solver.check);
    let named = simulate(&wide, &RunSettings { rung: Some(ModelLevel::RadiallyCondensed), ..loose });
    let warning = named.summary.accuracy.warning.unwrap();
    assert!(warning.contains("after the check"), "{warning}");
}

/// A heavy spindle with much unbalance and wide clearance: a check of its first milliseconds finds 0.04 dB, while its levels are chance.
/// Finer steps tell, and what they tell is stated where the rung was asked for by name.
#[test]
fn a_run_that_finer_steps_take_elsewhere_is_left_to_the_dynamics() {
    let heavy = json!({
        "bearing": { "preset": "article-integrated", "inner_groove_curvature": 0.532, "radial_clearance_um": 14 },
        "operation": { "speed_rpm": 44200, "radial_load_y_n": 177 },
        "spindle": { "mass_kg": 0.39, "balance_grade": 16 }
    });
    let loose = RunSettings {
        settle: 0.03,
        duration: 0.1,
        relative_tolerance: 1e-3,
        model_tolerance_db: 0.2,
        ..asked(false, None)
    };
    let result = simulate(&heavy, &loose).summary;
    let (rung, check) = (result.solver.rung, &result.solver.check);
    assert!(rung == "full" && check.contains("finer steps take another course"), "{rung}: {check}");
    let named = simulate(&heavy, &RunSettings { rung: Some(ModelLevel::RadiallyCondensed), ..loose }).summary;
    assert!(named.accuracy.level_error_db() > Some(0.3), "{:?}", named.accuracy);
}

/// In a viscous lubricant at low speed a small tilt of cage and balls grows over tenths of a second, to 7° and 2 dB. A check sees
/// its beginning, and rungs that are checked in the plane are not tried.
#[test]
fn balls_that_leave_the_plane_are_left_to_the_dynamics() {
    let outputs = Outputs { contacts: false, cage: false, ..settings().outputs };
    let settings = RunSettings { outputs, duration: 0.1, model_tolerance_db: 0.2, ..asked(false, None) };
    let scenes = [
        json!({
            "bearing": { "preset": "article-deep-groove", "ball_count": 6 },
            "operation": { "speed_rpm": 7360, "radial_load_y_n": 253, "radial_load_z_n": 133 }
        }),
        json!({
            "bearing": "608", "operation": { "speed_rpm": 3830, "radial_load_y_n": 111 },
            "spindle": { "mass_kg": 0.0329 }
        }),
        json!({ "bearing": "6205", "operation": { "speed_rpm": 3000, "radial_load_y_n": 20 } }),
    ];
    for json in scenes {
        let solver = simulate(&json, &settings).summary.solver;
        assert_eq!(solver.rung, "full", "{}", solver.check);
        assert!(solver.check.contains("balls leave the plane"), "{}", solver.check);
        assert!(solver.check.contains("spindle_only and periodic were not tried"), "{}", solver.check);
    }
}

/// A heavy crown cage far off its balls tilts them, levels are off by 4.5 dB in the plane: no rung that is checked in the plane
/// is tried, and one asked for by name states no error.
#[test]
fn a_crown_cage_that_may_tilt_its_balls_is_not_left_to_checks_in_the_plane() {
    let json = json!({
        "bearing": { "preset": "article-integrated", "cage": { "mass_g": 5.2, "offset_mm": 2.8 } },
        "operation": { "speed_rpm": 8215, "radial_load_y_n": 293 }
    });
    let chosen = simulate(&json, &RunSettings { model_tolerance_db: 0.5, ..asked(false, None) }).summary.solver;
    assert_eq!(chosen.rung, "full", "{}", chosen.check);
    assert!(chosen.check.contains("spindle_only and periodic were not tried: so heavy a cage"), "{}", chosen.check);
    let named = simulate(&json, &asked(false, Some(ModelLevel::SpindleOnly))).summary.accuracy;
    assert_eq!(named.level_error_db(), None);
    assert!(named.warning.as_ref().is_some_and(|warning| warning.contains("so heavy a cage")), "{named:?}");
    let closed = changed(json, json!({ "bearing": { "cage": { "seat": "closed", "offset_mm": 0 } } }));
    let chosen = simulate(&closed, &RunSettings { model_tolerance_db: 0.5, ..asked(false, None) }).summary.solver;
    assert!(["periodic", "spindle_only"].contains(&chosen.rung), "{} {}", chosen.rung, chosen.check);
}

/// A level that goes up and down along the run by decibels (slow beats of a lightly loaded, unbalanced spindle): a check of its beginning
/// does not stand for the rest; levels were 0.1 dB off for 0.01.
#[test]
fn a_level_that_scatters_along_the_run_is_left_to_the_dynamics() {
    let json = json!({
        "bearing": { "preset": "6205", "cage": { "offset_mm": 0.602 }, "materials": { "ball": "si3n4" } },
        "operation": { "speed_rpm": 2712, "radial_load_y_n": 28.4 }, "spindle": { "balance_grade": 0.4 },
        "gravity_m_s2": 0
    });
    let settings = RunSettings { settle: 0.07, duration: 0.123, model_tolerance_db: 0.05, ..asked(false, None) };
    let solver = simulate(&json, &settings).summary.solver;
    assert_eq!(solver.rung, "full", "{}", solver.check);
    assert!(solver.check.contains("scatters by"), "{}", solver.check);
}

/// A beat that is slower than the kept time is told on a reduced rung, too, by a later stretch: parts of the kept one differ by a third of it.
#[test]
fn a_slow_beat_is_told_on_a_reduced_rung() {
    let json = json!({
        "bearing": { "preset": "608", "radial_clearance_um": 29.8 },
        "operation": { "speed_rpm": 17_400, "radial_load_y_n": 348 },
        "spindle": { "mass_kg": 0.374, "balance_grade": 16 }
    });
    let settings = RunSettings { settle: 0.0664, duration: 0.1, ..asked(false, None) };
    let kept = simulate(&json, &settings);
    assert_eq!(kept.summary.solver.rung, "radially_condensed", "{}", kept.summary.solver.check);
    let long_after =
        simulate(&json, &RunSettings { settle: 3.0, rung: Some(ModelLevel::RadiallyCondensed), ..settings });
    let scatter = kept.summary.scatter.of(Y).unwrap();
    let off = (levels(&kept)[0] - levels(&long_after)[0]).abs();
    assert!(off > 0.5 && off < 2.0 * scatter, "{off} dB off, {scatter} dB stated");
}

/// What judgement leaves out is in the repetition: a bound that is too small shows, and the run is made again with all terms.
#[test]
fn a_bound_that_does_not_hold_is_found_out() {
    let json = json!({
        "bearing": "6205", "operation": { "speed_rpm": 5000, "radial_load_y_n": 500 }, "lubricant": "oil"
    });
    let settings =
        RunSettings { relative_tolerance: 1e-3, tightened: Some(1e-5), ..asked(false, Some(ModelLevel::Full)) };
    let settings = RunSettings { settle: 0.1, duration: 0.05, ..settings };
    let judged = needs(&scene(&json), &settings.outputs, settings.rung, 0.05).unwrap();
    assert!(judged.left_out.iter().any(|one| one.term == "churning" && one.by == Grounds::Judgement));
    let result = simulate(&json, &settings);
    assert!(result.left_out.iter().all(|one| one.by != Grounds::Judgement), "{:?}", result.left_out);
    let whole = simulate(&json, &RunSettings { model_tolerance_db: 0.0, relative_tolerance: 1e-5, ..settings });
    let stated = result.summary.accuracy.level_error_db().unwrap();
    assert!(stated <= 0.025 && apart(&result, &whole) < 2.0 * stated + 1e-3, "{stated} {}", apart(&result, &whole));
}
