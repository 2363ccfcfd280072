//! Duration of the initial transient, and the results before and after its decay.

use raceway::contract::answer::messages::of_warning;
use raceway::numerics::ode::Method;
use raceway::simulation::error::codes::Warning;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Model;
use raceway::simulation::result::metrics::{ChannelMetrics, Summary};
use raceway::simulation::solve::eligibility::active_terms;
use raceway::simulation::solve::run::simulate;
use raceway::simulation::solve::startup::{
    InitialState, StartupPhase, decay_rate, settling_time, start_transient, turning_time,
};
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient, settings, transients};
use crate::scenes::{article, changed, scene};

/// A 6204 with a spindle of 1.29 kg. Its motion normal to the load of 55 N has little damping.
fn lightly_damped() -> Value {
    json!({
        "bearing": { "preset": "6204" },
        "operation": { "speed_rpm": 2710, "radial_load_y_n": 54.9 },
        "spindle": { "mass_kg": 1.29, "balance_grade": 0.4 }
    })
}

/// Levels of y and z [dB] after a settling time [s], and warnings of vibration of the start.
fn levels(scene: &Scene, settle: f64) -> ([f64; 2], Vec<Warning>) {
    let rung = Some(ModelLevel::RadiallyCondensed);
    let settings = RunSettings { rung, model_tolerance_db: 0.05, settle, duration: 0.145, ..settings() };
    let summary = simulate(scene, &settings, &patient()).unwrap().summary;
    let level = |channel| summary.channels.iter().find(|(of, _)| *of == channel).and_then(|(_, m)| m.level_db).unwrap();
    ([Y, Z].map(level), transients(&summary.accuracy).into_iter().cloned().collect())
}

/// Where the attempts at a run begin: after a start-up phase that all of them reuse, or at rest.
fn beginning(scene: &Scene, settings: &RunSettings) -> InitialState {
    let model = Model::new(scene, &active_terms(scene, &settings.outputs, settings.rung).unwrap());
    InitialState::after(&StartupPhase::of(scene, &model, settings), None, &model, &patient()).unwrap()
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// After three cage turns the transient still changes the levels by decibels, with a warning. After the default settling time,
/// which the damping sets, it has decayed.
#[test]
fn a_lightly_damped_spindle_settles_in_the_time_that_its_contacts_set() {
    let scene = scene(&lightly_damped());
    let time = settling_time(&scene).unwrap();
    let (long, _) = levels(&scene, 2.0 * time);
    let (settled, warnings) = levels(&scene, time);
    let (ringing, warned) = levels(&scene, 0.174);
    println!("{time} s: {} dB; 0.174 s: {} dB", apart(settled, long), apart(ringing, long));
    assert!(apart(settled, long) < 0.1 && warnings.is_empty(), "{warnings:?}");
    let asks_for_more = |warning: &Warning| match *warning {
        Warning::StartTransient { settle, required, constant_speed, .. } => {
            constant_speed && settle == 0.174 && required > settle
        }
        _ => false,
    };
    assert!(apart(ringing, long) > 1.0 && warned.iter().any(asks_for_more), "{warned:?}");
}

/// The decay rate grows with the load and falls with the mass. The direction of the load does not matter.
#[test]
fn decay_follows_load_mass_and_no_direction() {
    let rate = |operation: Value, mass: f64| {
        let changes = json!({ "operation": operation, "spindle": { "mass_kg": mass }, "gravity_m_s2": 0 });
        decay_rate(&scene(&changed(article(), changes)))
    };
    let loaded = |load: f64, mass: f64| {
        rate(json!({ "speed_rpm": 50_000, "radial_load_y_n": load, "radial_load_z_n": 0 }), mass).unwrap()
    };
    let (one, heavy, hard) = (loaded(200.0, 0.05), loaded(200.0, 0.5), loaded(400.0, 0.05));
    assert!((one / heavy - 10.0).abs() < 1e-9, "{one} {heavy}");
    // A wider load zone adds to the effect of the load.
    assert!((2.0..3.0).contains(&(hard / one)), "{one} {hard}");
    let aslant = rate(json!({ "speed_rpm": 50_000, "radial_load_y_n": 0.0, "radial_load_z_n": 200.0 }), 0.05).unwrap();
    assert!((aslant / one - 1.0).abs() < 0.1, "{one} {aslant}");
}

/// Axial motion of a spindle is damped only by the axial inclination of its contacts. It decays much more slowly than radial
/// motion, and more slowly for a smaller inclination.
#[test]
fn motion_along_the_axis_decays_slowest() {
    let time = |radial: f64, axial: f64| {
        let load = json!({ "radial_load_y_n": radial, "axial_load_n": axial });
        settling_time(&scene(&changed(lightly_damped(), json!({ "operation": load })))).unwrap()
    };
    let (radial, leaning, steep) = (time(200.0, 0.0), time(200.0, 20.0), time(200.0, 200.0));
    println!("{radial} s, {leaning} s, {steep} s");
    assert!(leaning > 5.0 * radial && steep < 0.2 * leaning);
}

/// With all contacts inclined and loaded, the cage vibrates axially on films with little axial damping. The damping of the
/// start-up phase removes that within three cage turns. A run without it has level errors of tens of decibels.
///
/// The damping is not applied with an unloaded ball, a slowly decaying spindle, a fixed step or no settling time. The result
/// then warns of a possible transient.
#[test]
fn axial_vibration_is_damped_in_the_start_up_phase() {
    const X: Channel = Channel::Spindle(Axis::X, Motion::Acceleration);
    let pressed_with = |mass: f64, radial: f64, axial: f64| {
        let operation = json!({ "speed_rpm": 4536, "radial_load_y_n": radial, "axial_load_n": axial });
        let changes = json!({ "operation": operation, "spindle": { "mass_kg": mass, "balance_grade": 2.5 } });
        scene(&changed(lightly_damped(), changes))
    };
    let pressed = |radial: f64, axial: f64| pressed_with(0.34, radial, axial);
    let scene = pressed(0.0, 242.0);
    let asked = |settle: f64, fixed_step: Option<f64>| {
        let method = if fixed_step.is_some() { Method::SemiImplicit } else { Method::Auto };
        let tightened = fixed_step.is_none().then_some(1e-5);
        RunSettings { method, tightened, fixed_step, settle, duration: 0.1, ..settings() }
    };
    let made = |scene: &Scene, settle: f64, fixed_step: Option<f64>| {
        simulate(scene, &asked(settle, fixed_step), &patient()).unwrap().summary
    };
    let damped =
        |scene: &Scene, settle: f64, fixed_step: Option<f64>| beginning(scene, &asked(settle, fixed_step)).is_damped;
    let level = |summary: &Summary| {
        let of = |(one, metrics): &(Channel, ChannelMetrics)| metrics.level_db.filter(|_| *one == X);
        summary.channels.iter().find_map(of).unwrap()
    };
    let turns = turning_time(&scene);
    let (soon, late, ringing) = (made(&scene, turns, None), made(&scene, 1.0, None), made(&scene, turns, Some(5.5e-6)));
    println!("{} dB, long after {}, undamped {}", level(&soon), level(&late), level(&ringing));
    assert!(damped(&scene, turns, None) && damped(&scene, 1.0, None) && !damped(&scene, turns, Some(5.5e-6)));
    assert!((level(&soon) - level(&late)).abs() < 0.2 && level(&ringing) > level(&late) + 20.0);
    assert!(
        matches!(&soon.accuracy.warnings[..], [Warning::StationarityNotChecked { .. }]),
        "{:?}",
        soon.accuracy.warnings
    );
    assert!(!damped(&pressed(300.0, 30.0), turns, None) && !damped(&scene, 0.0, None));
    let heavy = pressed_with(10.0, 0.0, 242.0);
    assert!(!damped(&heavy, turns, None));
    assert!(!transients(&made(&heavy, turns, None).accuracy).is_empty());
    let of_cage = |warning: &&Warning| matches!(warning, Warning::CageTransient { .. });
    assert!(transients(&ringing.accuracy).iter().any(of_cage), "{:?}", ringing.accuracy.warnings);
}

/// At changing speed there is no default settling time, and the result warns of the transient.
#[test]
fn changing_speed_has_no_default_settling_time_and_warns() {
    let speed = json!({ "operation": { "speed_rpm": [{ "at_s": 0, "rpm": 2710 }, { "at_s": 1, "rpm": 2720 }] } });
    let scene = scene(&changed(lightly_damped(), speed));
    let (_, warnings) = levels(&scene, 0.174);
    assert_eq!(settling_time(&scene), None);
    let changes = |warning: &Warning| matches!(warning, Warning::StartTransient { constant_speed: false, .. });
    assert!(warnings.iter().any(changes), "{warnings:?}");
}

/// With almost no damping and a very short time, the warning and its advice remain short and feasible.
#[test]
fn the_warning_of_almost_no_damping_is_short() {
    let faint = json!({ "damping": { "raceway": { "law": "viscous", "viscous_n_s_per_m": 1e-300 } } });
    let scene = scene(&changed(article(), faint));
    let warning = start_transient(&scene, 1e-320).unwrap();
    let Warning::StartTransient { time_constant, required, .. } = warning else { panic!("{warning:?}") };
    assert!(time_constant > 1000.0 && required > 1000.0, "{warning:?}");
    let words = of_warning(&warning).text;
    assert!(
        words.len() < 250 && words.contains("more than 1000 s") && words.contains("A larger load or more damping"),
        "{words}"
    );
    assert_eq!(settling_time(&scene), Some(5.0));
}

/// Without damping, without load and at changing speed there is no decay rate.
#[test]
fn no_settling_time_is_set_without_decay() {
    assert!(settling_time(&scene(&article())).is_some());
    let without = [
        json!({ "damping": { "raceway": { "law": "none" } } }),
        json!({ "operation": { "radial_load_y_n": 0 }, "gravity_m_s2": 0 }),
        json!({ "operation": { "speed_rpm": [{ "at_s": 0, "rpm": 0 }, { "at_s": 1, "rpm": 5000 }] } }),
    ];
    for change in without {
        assert_eq!(settling_time(&scene(&changed(article(), change.clone()))), None, "{change}");
    }
}

/// All attempts reuse the first part of a long settling time. Their levels are those of a run without the reuse.
#[test]
fn the_reused_start_up_phase_does_not_change_levels() {
    let changes =
        json!({ "operation": { "speed_rpm": 8000, "radial_load_y_n": 150.0 }, "spindle": { "mass_kg": 0.4 } });
    let scene = scene(&changed(lightly_damped(), changes));
    let last = turning_time(&scene);
    let asked = |settle: f64, tightened: Option<f64>| RunSettings {
        rung: Some(ModelLevel::Full),
        model_tolerance_db: 0.05,
        tightened,
        settle,
        duration: 0.1,
        ..settings()
    };
    let made =
        |settle: f64, tightened: Option<f64>| simulate(&scene, &asked(settle, tightened), &patient()).unwrap().summary;
    let shares = |settle: f64, tightened: Option<f64>| beginning(&scene, &asked(settle, tightened)).time > 0.0;
    let (shared, own) = (made(3.5 * last, Some(1e-5)), made(3.5 * last, None));
    assert!(shares(3.5 * last, Some(1e-5)) && !shares(3.5 * last, None) && !shares(2.9 * last, Some(1e-5)));
    for channel in [Y, Z] {
        let level = |summary: &Summary| {
            let of = |(one, metrics): &(Channel, ChannelMetrics)| metrics.level_db.filter(|_| *one == channel);
            summary.channels.iter().find_map(of).unwrap()
        };
        let stated = shared.accuracy.level_errors.of(channel).unwrap();
        let apart = (level(&shared) - level(&own)).abs();
        println!("{apart} dB, stated {stated}, {}", shared.accuracy.level_scatter.of(channel).unwrap());
        assert!(apart < stated.max(0.002) && stated < 0.02);
    }
    // The steps of the reused part are counted, too.
    let work = &shared.solver.statistics;
    assert!((work.advanced / (3.5 * last + 0.1) - 1.0).abs() < 1e-2 && work.steps as f64 * 7.5e-6 > 3.0 * last);
}

/// A beat slower than the recorded time does not appear in it. A second window reveals it.
#[test]
fn slow_beats_appear_in_a_second_window() {
    let scene = scene(&json!({
        "bearing": { "preset": "6203" },
        "operation": { "speed_rpm": 2680, "radial_load_y_n": 85.0 },
        "spindle": { "mass_kg": 0.203, "balance_grade": 6.3 }
    }));
    let made = |settle: f64| {
        let settings =
            RunSettings { model_tolerance_db: 0.05, tightened: Some(1e-5), settle, duration: 0.1, ..settings() };
        let summary = simulate(&scene, &settings, &patient()).unwrap().summary;
        let of = |(one, metrics): &(Channel, ChannelMetrics)| metrics.level_db.filter(|_| *one == Z);
        (summary.channels.iter().find_map(of).unwrap(), summary)
    };
    let ((level, summary), (later, _)) = (made(0.194), made(0.394));
    let (scatter, stated) =
        (summary.accuracy.level_scatter.of(Z).unwrap(), summary.accuracy.level_errors.of(Z).unwrap());
    println!("{level} dB, later {later} dB; scatter {scatter} dB, stated {stated} dB");
    assert!((level - later).abs() > 0.5 && scatter > 0.9 * (level - later).abs() && stated >= scatter);
}

/// Steps of 7.5 µs diverge after 38 ms. All attempts reuse the state that shorter steps reach.
#[test]
fn viscous_oil_that_is_too_stiff_for_long_steps_settles_once_in_shorter_ones() {
    let scene = scene(&json!({
        "bearing": { "preset": "6206", "radial_clearance_um": 11.4 },
        "operation": { "speed_rpm": 7512, "radial_load_y_n": 86.9 },
        "spindle": { "mass_kg": 2.489, "balance_grade": 16 },
        "lubricant": { "kind": "oil", "viscosity_pa_s": 0.096 }
    }));
    let settings = RunSettings {
        method: Method::Auto,
        rung: Some(ModelLevel::Full),
        relative_tolerance: 1e-3,
        tightened: Some(1e-5),
        // The test compares the path to the result, not its last digit.
        model_tolerance_db: 5.0,
        outputs: Outputs { contacts: false, cage: false, ..settings().outputs },
        settle: settling_time(&scene).unwrap(),
        duration: 0.01,
        ..settings()
    };
    let summary = simulate(&scene, &settings, &patient()).unwrap().summary;
    let InitialState { time, work, .. } = beginning(&scene, &settings);
    let step = work.advanced / work.steps as f64;
    assert!(time > 0.0 && (step - 1.875e-6).abs() < 1e-9, "{time} {step:?}");
    assert!(summary.channels.iter().all(|(_, metrics)| metrics.rms.is_finite()));
}
