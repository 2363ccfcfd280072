//! How long a run has to go on until its start is forgotten.

use raceway::numerics::ode::Method;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::result::metrics::{ChannelMetrics, Summary};
use raceway::simulation::solve::run::run;
use raceway::simulation::solve::startup::{decay_rate, rings_on, settling_time, turning_time};
use serde_json::{Value, json};

use crate::article_run::{Y, Z, patient, settings};
use crate::scenes::{article, changed, scene};

/// A 6204 with a spindle of 1.29 kg: across its load of 55 N little damps it.
fn lightly_damped() -> Value {
    json!({
        "bearing": { "preset": "6204" },
        "operation": { "speed_rpm": 2710, "radial_load_y_n": 54.9 },
        "spindle": { "mass_kg": 1.29, "balance_grade": 0.4 }
    })
}

/// Levels of y and z [dB] after settling for a time [s], and what is warned of.
fn levels(scene: &Scene, settle: f64) -> ([f64; 2], Option<String>) {
    let rung = Some(ModelLevel::RadiallyCondensed);
    let settings = RunSettings { rung, model_tolerance_db: 0.05, settle, duration: 0.145, ..settings() };
    let summary = run(scene, &settings, &patient()).unwrap().summary;
    let level = |channel| summary.channels.iter().find(|(of, _)| *of == channel).and_then(|(_, m)| m.level_db).unwrap();
    ([Y, Z].map(level), summary.settling)
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// What three turns of the cage leave of the start is decibels here, and is warned of; after the time that damping sets, nothing is left.
#[test]
fn a_lightly_damped_spindle_settles_in_the_time_that_its_contacts_set() {
    let scene = scene(&lightly_damped());
    let time = settling_time(&scene).unwrap();
    let (long, _) = levels(&scene, 2.0 * time);
    let (settled, warning) = levels(&scene, time);
    let (ringing, warned) = levels(&scene, 0.174);
    println!("{time} s: {} dB; 0.174 s: {} dB", apart(settled, long), apart(ringing, long));
    assert!(apart(settled, long) < 0.1 && warning.is_none());
    assert!(apart(ringing, long) > 1.0 && warned.is_some_and(|warning| warning.contains("settle_s")));
}

/// Damping grows with the load and mass slows its work; which way a load points does not matter.
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
    // A wider zone of contact helps beyond the load itself.
    assert!((2.0..3.0).contains(&(hard / one)), "{one} {hard}");
    let aslant = rate(json!({ "speed_rpm": 50_000, "radial_load_y_n": 0.0, "radial_load_z_n": 200.0 }), 0.05).unwrap();
    assert!((aslant / one - 1.0).abs() < 0.1, "{one} {aslant}");
}

/// Along its axis a spindle is damped by what its contacts lean that way alone: much longer than across, and the less they lean the longer.
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

/// Where all contacts lean and carry, the cage rings along its axis on films that hardly damp it there; under the damping at the start that is gone
/// after three turns of the cage, where a run without it is tens of decibels off. A ball that does not carry, a spindle whose vibration decays
/// slowly, a fixed step and a start at no time have none of it, and what may ring then is told of.
#[test]
fn what_rings_along_the_axis_is_damped_at_the_start() {
    const X: Channel = Channel::Spindle(Axis::X, Motion::Acceleration);
    let pressed_with = |mass: f64, radial: f64, axial: f64| {
        let operation = json!({ "speed_rpm": 4536, "radial_load_y_n": radial, "axial_load_n": axial });
        let changes = json!({ "operation": operation, "spindle": { "mass_kg": mass, "balance_grade": 2.5 } });
        scene(&changed(lightly_damped(), changes))
    };
    let pressed = |radial: f64, axial: f64| pressed_with(0.34, radial, axial);
    let scene = pressed(0.0, 242.0);
    let made = |scene: &Scene, settle: f64, fixed_step: Option<f64>| {
        let method = if fixed_step.is_some() { Method::SemiImplicit } else { Method::Auto };
        let tightened = fixed_step.is_none().then_some(1e-5);
        let settings = RunSettings { method, tightened, fixed_step, settle, duration: 0.1, ..settings() };
        run(scene, &settings, &patient()).unwrap().summary
    };
    let damped = |summary: &Summary| summary.solver.method_reason.contains("damped at first");
    let level = |summary: &Summary| {
        let of = |(one, metrics): &(Channel, ChannelMetrics)| metrics.level_db.filter(|_| *one == X);
        summary.channels.iter().find_map(of).unwrap()
    };
    let turns = turning_time(&scene);
    let (soon, late, ringing) = (made(&scene, turns, None), made(&scene, 1.0, None), made(&scene, turns, Some(5.5e-6)));
    println!("{} dB, long after {}, undamped {}", level(&soon), level(&late), level(&ringing));
    assert!(damped(&soon) && damped(&late) && !damped(&ringing));
    assert!((level(&soon) - level(&late)).abs() < 0.2 && level(&ringing) > level(&late) + 20.0);
    assert_eq!((&soon.accuracy.warning, &soon.settling), (&None, &None));
    assert!(!damped(&made(&pressed(300.0, 30.0), turns, None)) && !damped(&made(&scene, 0.0, None)));
    let heavy = made(&pressed_with(10.0, 0.0, 242.0), turns, None);
    assert!(!damped(&heavy) && heavy.settling.is_some());
    assert!(ringing.settling.is_some_and(|words| words.contains("the cage is hardly damped")));
}

/// At changing speed nothing is waited for, and the result says that the start may still ring.
#[test]
fn a_changing_speed_is_not_waited_for_but_told_of() {
    let speed = json!({ "operation": { "speed_rpm": [{ "at_s": 0, "rpm": 2710 }, { "at_s": 1, "rpm": 2720 }] } });
    let scene = scene(&changed(lightly_damped(), speed));
    let (_, settling) = levels(&scene, 0.174);
    assert_eq!(settling_time(&scene), None);
    assert!(settling.is_some_and(|words| words.contains("Hold the first speed")));
}

/// However little damps and however short a time is, words and advice are such that one can follow them.
#[test]
fn next_to_no_damping_is_told_in_few_words() {
    let faint = json!({ "damping": { "raceway": { "law": "viscous", "viscous_n_s_per_m": 1e-300 } } });
    let scene = scene(&changed(article(), faint));
    let words = rings_on(&scene, 1e-320).unwrap();
    assert!(
        words.len() < 250 && words.contains("more than 1000 s") && words.contains("No time is long enough"),
        "{words}"
    );
    assert_eq!(settling_time(&scene), Some(5.0));
}

/// Without damping, without load and where the speed changes, nothing is known of it.
#[test]
fn no_time_is_set_where_nothing_decays() {
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

/// Attempts at a run share the first part of a long time to settle, and their levels are those of a run that shares nothing.
#[test]
fn what_is_shared_leaves_levels_as_they_are() {
    let changes =
        json!({ "operation": { "speed_rpm": 8000, "radial_load_y_n": 150.0 }, "spindle": { "mass_kg": 0.4 } });
    let scene = scene(&changed(lightly_damped(), changes));
    let last = turning_time(&scene);
    let made = |settle: f64, tightened: Option<f64>| {
        let settings = RunSettings {
            rung: Some(ModelLevel::Full),
            model_tolerance_db: 0.05,
            tightened,
            settle,
            duration: 0.1,
            ..settings()
        };
        run(&scene, &settings, &patient()).unwrap().summary
    };
    let shares = |summary: &Summary| summary.solver.method_reason.contains("settled once");
    let (shared, own) = (made(3.5 * last, Some(1e-5)), made(3.5 * last, None));
    assert!(shares(&shared) && !shares(&own) && !shares(&made(2.9 * last, Some(1e-5))));
    for channel in [Y, Z] {
        let level = |summary: &Summary| {
            let of = |(one, metrics): &(Channel, ChannelMetrics)| metrics.level_db.filter(|_| *one == channel);
            summary.channels.iter().find_map(of).unwrap()
        };
        let stated = shared.accuracy.level_errors.of(channel).unwrap();
        let apart = (level(&shared) - level(&own)).abs();
        println!("{apart} dB, stated {stated}, {}", shared.scatter.of(channel).unwrap());
        assert!(apart < stated.max(0.002) && stated < 0.02);
    }
    // Its steps count.
    let work = &shared.solver.statistics;
    assert!((work.advanced / (3.5 * last + 0.1) - 1.0).abs() < 1e-2 && work.steps as f64 * 7.5e-6 > 3.0 * last);
}

/// What beats more slowly than the kept time does not show in it: the level is held against that of a later stretch.
#[test]
fn slow_beats_show_in_a_later_stretch() {
    let scene = scene(&json!({
        "bearing": { "preset": "6203" },
        "operation": { "speed_rpm": 2680, "radial_load_y_n": 85.0 },
        "spindle": { "mass_kg": 0.203, "balance_grade": 6.3 }
    }));
    let made = |settle: f64| {
        let settings =
            RunSettings { model_tolerance_db: 0.05, tightened: Some(1e-5), settle, duration: 0.1, ..settings() };
        let summary = run(&scene, &settings, &patient()).unwrap().summary;
        let of = |(one, metrics): &(Channel, ChannelMetrics)| metrics.level_db.filter(|_| *one == Z);
        (summary.channels.iter().find_map(of).unwrap(), summary)
    };
    let ((level, summary), (later, _)) = (made(0.194), made(0.394));
    let (scatter, stated) = (summary.scatter.of(Z).unwrap(), summary.accuracy.level_errors.of(Z).unwrap());
    println!("{level} dB, later {later} dB; scatter {scatter} dB, stated {stated} dB");
    assert!((level - later).abs() > 0.5 && scatter > 0.9 * (level - later).abs() && stated >= scatter);
}

/// Steps of 7.5 µs blow up after 38 ms: all attempts share what shorter ones lead to.
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
        // The way to the result is looked at, not its last digit.
        model_tolerance_db: 5.0,
        outputs: Outputs { contacts: false, cage: false, ..settings().outputs },
        settle: settling_time(&scene).unwrap(),
        duration: 0.01,
        ..settings()
    };
    let summary = run(&scene, &settings, &patient()).unwrap().summary;
    let reason = &summary.solver.method_reason;
    assert!(reason.contains("settled once") && reason.contains("in steps of 1.87 µs"), "{reason}");
    assert!(summary.channels.iter().all(|(_, metrics)| metrics.rms.is_finite()));
}
