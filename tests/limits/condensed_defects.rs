//! Defects of the raceways on the radially condensed model, against the planar dynamics and against its own limits.

use raceway::numerics::ode::Method;
use raceway::numerics::spectrum::Spectrum;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::inapplicable::Inapplicable;
use raceway::simulation::model::radially_condensed::{RadiallyCondensed, inapplicability};
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient};
use crate::defects::{averaged, defect, line, motor, on_outer};
use crate::scenes::{changed, scene};

fn on_inner(defect: Value) -> Value {
    json!({ "inner": { "defects": [defect] } })
}

fn outputs() -> Outputs {
    Outputs { spectra: vec![Y, Z], ..Outputs::vibration() }
}

/// A run in fixed steps [s] after 50 ms of settling; `None`: those of the model.
fn run_on(json: &Value, level: ModelLevel, fixed_step: Option<f64>, duration: f64) -> RunResult {
    let settings = RunSettings {
        method: if fixed_step.is_some() { Method::SemiImplicit } else { Method::Auto },
        rung: Some(level),
        relative_tolerance: 1e-5,
        tightened: None,
        model_tolerance_db: 0.05,
        fixed_step,
        settle: 0.05,
        duration,
        outputs: outputs(),
    };
    simulate(&scene(json), &settings, &patient()).unwrap()
}

fn envelope(result: &RunResult) -> &Spectrum {
    &result.spectra.iter().find(|spectra| spectra.channel == Y).unwrap().envelope
}

/// Levels and the first three lines of the envelope where defects carry their balls, and the passages over them.
#[test]
fn levels_and_envelopes_over_defects_are_those_of_the_dynamics() {
    for (surfaces, is_inner) in [
        (on_outer(defect(0.0, 1.0, 3.0)), false),
        (on_outer(defect(0.0, 1.0, 10.0)), false),
        (on_inner(defect(0.0, 0.5, 2.0)), true),
    ] {
        let json = motor(surfaces);
        let found = run_on(&json, ModelLevel::RadiallyCondensed, None, 0.3);
        let expected = run_on(&json, ModelLevel::Planar, Some(2.5e-6), 0.3);
        for channel in [Y, Z] {
            let level = |result: &RunResult| {
                result.summary.channels.iter().find(|(of, _)| *of == channel).unwrap().1.level_db.unwrap()
            };
            let off = level(&found) - level(&expected);
            assert!(off.abs() < 0.05, "{channel} inner {is_inner}: {off} dB");
        }
        let f = expected.summary.frequencies;
        let first = if is_inner { f.ball_pass_inner } else { f.ball_pass_outer };
        for order in [1.0, 2.0, 3.0] {
            let [found, expected] = [&found, &expected].map(|result| line(envelope(result), order * first));
            let off = 20.0 * (found / expected).log10();
            assert!(off.abs() < 0.1, "line {order}, inner {is_inner}: {off} dB");
        }
        // The largest impact may be that of another ball: times over the defect are compared, not entries.
        let [found, expected] = [&found, &expected].map(|result| {
            let passages = &result.plot_data.impact.as_ref().unwrap().passages;
            passages.iter().map(|passage| passage.exit - passage.entry).sum::<f64>() / passages.len() as f64
        });
        assert!((found / expected - 1.0).abs() < 0.01, "time over the defect {found} s, {expected} s");
    }
}

/// A ball leaves deep defects, and outer ones outside the load zone. Defects of balls and beside the groove's bottom have reasons of their own.
#[test]
fn defects_that_balls_may_leave_are_refused() {
    let reason = |surfaces: Value| inapplicability(&scene(&motor(surfaces)), &outputs());
    assert_eq!(reason(on_outer(defect(0.0, 1.0, 3.0))), None);
    assert_eq!(reason(on_inner(defect(0.0, 0.5, 2.0))), None);
    // An inner defect turns through the load zone, wherever it is at the start.
    assert_eq!(reason(on_inner(defect(180.0, 0.5, 2.0))), None);
    let held = |surfaces: Value| match reason(surfaces) {
        Some(Inapplicable::BallLeavesDefect { ring, load, needed }) => (ring, load, needed),
        found => panic!("{found:?}"),
    };
    // Outside the load zone the centrifugal force of 0.225 N less the weight of 0.020 N presses a ball outwards. The path turns by up to
    // 1.5 m_b ρ_x v_c² at 0.8 b from the edge, 2.0 N.
    let (ring, load, needed) = held(on_outer(defect(180.0, 1.0, 50.0)));
    assert!(ring == "outer" && (load / 0.205 - 1.0).abs() < 0.02 && (1.8..2.0).contains(&needed), "{load} {needed}");
    // Under the load the fall takes the whole approach before the ball reaches the floor.
    for (of, surfaces) in [("outer", on_outer(defect(0.0, 1.0, 20.0))), ("inner", on_inner(defect(0.0, 1.0, 50.0)))] {
        let (ring, load, needed) = held(surfaces);
        assert!(ring == of && load < 0.5 && load <= needed, "{ring} {load} {needed}");
    }
    // The approach of both contacts is 10.25 µm.
    assert_eq!(reason(on_outer(defect(0.0, 1.0, 10.0))), None);
    let of_ball = json!({ "balls": [{ "ball": 1, "defects": [{ "diameter_mm": 0.4, "depth_um": 2 }] }] });
    assert_eq!(reason(of_ball), Some(Inapplicable::BallDefects));
    let aside = json!({ "length_mm": 0.5, "width_mm": 0.5, "across_mm": 0.1, "depth_um": 2 });
    assert_eq!(reason(on_outer(aside)), Some(Inapplicable::DefectBesideBottom));
}

/// A ball that is fast enough leaves a defect that carries it at a lower speed.
#[test]
fn fast_balls_leave_shallow_defects() {
    let at = |speed_rpm: u32| {
        let fast = json!({ "operation": { "speed_rpm": speed_rpm } });
        inapplicability(&scene(&changed(motor(on_outer(defect(0.0, 1.0, 3.0))), fast)), &outputs())
    };
    assert_eq!(at(30_000), None);
    let Some(Inapplicable::BallLeavesDefect { ring: "outer", load, needed }) = at(100_000) else {
        panic!("{:?}", at(100_000))
    };
    assert!(load > 100.0 && needed > load, "{load} {needed}");
}

/// All steps that the model may take are at most b/(4 v_c).
#[test]
fn steps_resolve_the_path_over_a_defect() {
    for (surfaces, is_inner) in [(on_outer(defect(0.0, 1.0, 3.0)), false), (on_inner(defect(0.0, 0.5, 2.0)), true)] {
        let json = motor(surfaces);
        let of_both = averaged(&json);
        let recess = if is_inner { of_both.inner.defects[0] } else { of_both.outer.defects[0] };
        let model = RadiallyCondensed::new(&scene(&json), &outputs()).unwrap();
        let longest = 0.25 * recess.contact.half_width / recess.contact.speed;
        for ratio in std::iter::once(model.step_ratio()).chain(model.longer_step_ratios()) {
            assert!(ratio.step() <= longest, "{} {longest}", ratio.step());
        }
    }
}
