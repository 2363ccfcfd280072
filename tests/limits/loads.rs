//! Loads on the spindle: what acts at each time, and what a preloaded bearing at rest answers, in each direction an oscillator of one degree
//! of freedom.

use std::f64::consts::{PI, TAU};

use raceway::numerics::ode::Method;
use raceway::simulation::error::codes::{Ineligible, NotEligibleReason};
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::equilibrium::{spindle_stiffness, start_state};
use raceway::simulation::model::inapplicable::Inapplicable;
use raceway::simulation::solve::eligibility::Eligibility;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::{Y, lines};
use crate::scenes::{article, changed, disturbed, everything, model, rates, scene};

const DISPLACEMENT: Channel = Channel::Spindle(Axis::Y, Motion::Displacement);
const LEVELS: [ModelLevel; 4] =
    [ModelLevel::Full, ModelLevel::Planar, ModelLevel::RadiallyCondensed, ModelLevel::SpindleOnly];

fn with_loads(base: Value, loads: Value) -> Value {
    changed(base, json!({ "operation": { "loads": loads } }))
}

fn settings(rung: Option<ModelLevel>, settle: f64, duration: f64) -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung,
        relative_tolerance: 1e-8,
        tightened: None,
        model_tolerance_db: 0.05,
        fixed_step: None,
        settle,
        duration,
        outputs: Outputs { series: vec![DISPLACEMENT], ..Outputs::vibration() },
    }
}

/// Displacements of the spindle along Y [m].
fn displacements(json: &Value, settings: &RunSettings) -> Vec<f64> {
    let result = simulate(&scene(json), settings, &Control::until(&|| false)).unwrap();
    result.series[0].values.iter().map(|value| 1e-6 * value).collect()
}

/// The article's bearing at rest with a preload alone: Y and Z are not coupled, and every ball stays in contact.
fn preloaded(law: &str) -> Value {
    changed(
        article(),
        json!({
            "gravity_m_s2": 0,
            "bearing": { "radial_clearance_um": -20 },
            "operation": { "speed_rpm": 0, "radial_load_y_n": 0 },
            "damping": { "raceway": { "law": law } }
        }),
    )
}

/// Stiffness [N/m] along Y and frequency [rad/s] of the spindle on its balls.
fn oscillator(json: &Value) -> (f64, f64) {
    let model = model(json);
    let stiffness = spindle_stiffness(model.mechanism(), 0.0).unwrap()[(1, 1)];
    (stiffness, (stiffness / model.mechanism().spindle_mass).sqrt())
}

/// A constant load is a radial load, to the last bit.
#[test]
fn a_constant_load_is_the_radial_load() {
    let radial = article();
    let loads =
        json!([{ "direction": "y", "constant_n": 150 }, { "on": "spindle", "direction": "y", "constant_n": 50 }]);
    let constant = with_loads(changed(article(), json!({ "operation": { "radial_load_y_n": 0 } })), loads);
    let [radial, constant] = [radial, constant].map(|json| model(&json));
    let state = disturbed(&radial, 3);
    assert_eq!(start_state(&radial).unwrap(), start_state(&constant).unwrap());
    assert_eq!(rates(&radial, 0.01, &state), rates(&constant, 0.01, &state));
}

/// A rotating load of order 1 is an unbalance of the same force: rates agree to rounding of the force.
#[test]
fn a_rotating_load_is_an_unbalance() {
    let speed = 50_000.0 * PI / 30.0;
    let force = 0.3e-6 * speed * speed;
    let rotating = with_loads(article(), json!([{ "rotating": { "amplitude_n": force, "order": 1 } }]));
    let unbalanced = changed(article(), json!({ "spindle": { "unbalance_g_mm": 0.3 } }));
    let (rotating, unbalanced) = (model(&rotating), model(&unbalanced));
    let state = disturbed(&rotating, 5);
    for time in [0.0, 1.7e-3, 0.4] {
        let [a, b] = [&rotating, &unbalanced].map(|model| rates(model, time, &state));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / (a.abs() + 1.0)).fold(0.0, f64::max);
        assert!(apart < 1e-12, "{apart}");
    }
}

/// The power of loads, F·v and M·β̇, is what they add to the rate of the kinetic energy of a spindle that moves and tilts.
#[test]
fn loads_do_work_on_the_spindle_alone() {
    let free = changed(everything(), json!({ "spindle": { "tilt": "free" } }));
    let loads = json!([
        { "direction": "x", "harmonic": { "amplitude_n": 7, "frequency_hz": 900, "phase_deg": 20 } },
        { "direction": "z", "points": [{ "at_s": 0, "n": 0 }, { "at_s": 0.01, "n": 40 }] },
        { "rotating": { "amplitude_n": 9, "order": 2, "phase_deg": -50 } },
        { "direction": "about_y", "shock": { "peak_n_m": 0.3, "at_s": 0.001, "duration_s": 0.01 } },
        { "direction": "about_z", "harmonic": { "amplitude_n_m": 0.2, "order": 3 } }
    ]);
    let (free, loaded) = (model(&free), model(&with_loads(free, loads)));
    let (m, time) = (loaded.mechanism(), 0.004);
    let state = disturbed(&free, 8);
    let spindle = m.layout.spindle(&state);
    let [with, without] = [&loaded, &free].map(|model| m.layout.spindle(&rates(model, time, &state)));
    let transverse = m.spindle_inertia.unwrap().transverse;
    let mut gained = 0.0;
    for axis in 0..3 {
        gained += m.spindle_mass * (with.velocity[axis] - without.velocity[axis]) * spindle.velocity[axis];
    }
    for axis in 0..2 {
        gained += transverse * (with.tilt_rate[axis] - without.tilt_rate[axis]) * spindle.tilt_rate[axis];
    }
    let angle = m.rotation.inner.at(time).0;
    let turning = 2.0 * angle - 50_f64.to_radians();
    let force = [
        7.0 * (TAU * 900.0 * time + 20_f64.to_radians()).cos(),
        9.0 * turning.cos(),
        4000.0 * time + 9.0 * turning.sin(),
    ];
    let moment = [0.3 * (PI * 0.3).sin(), 0.2 * (3.0 * angle).cos()];
    let power = force.iter().zip(spindle.velocity).chain(moment.iter().zip(spindle.tilt_rate)).map(|(a, b)| a * b);
    let power = power.sum::<f64>();
    // The accelerations by the contacts, which cancel, are a thousand times as large.
    assert!((gained - power).abs() < 1e-9 * power.abs(), "{gained} {power}");
}

/// Constant moments tilt the start into their equilibrium: tilt rates do not change, to the residual of the equilibrium.
#[test]
fn a_run_starts_in_equilibrium_with_moments() {
    let loads =
        json!([{ "direction": "about_z", "constant_n_m": 0.05 }, { "direction": "about_y", "constant_n_m": -0.02 }]);
    let standing = json!({
        "gravity_m_s2": 0,
        "operation": { "speed_rpm": 0, "radial_load_y_n": 20, "axial_load_n": 60 },
        "spindle": { "tilt": "free" }
    });
    let model = model(&with_loads(changed(article(), standing), loads));
    let state = start_state(&model).unwrap();
    let rate = model.mechanism().layout.spindle(&rates(&model, 0.0, &state)).tilt_rate;
    let inertia = model.mechanism().spindle_inertia.unwrap().transverse;
    assert!(rate.iter().all(|rate| (inertia * rate).abs() < 1e-8), "{rate:?}");
}

/// A force of 2 N at a 40th of the resonance moves the spindle by F/K, and by the share (f/f₀)² more.
#[test]
fn a_slow_harmonic_force_acts_as_a_static_one() {
    let base = preloaded("restitution");
    let (stiffness, natural) = oscillator(&base);
    let frequency = natural / TAU / 40.0;
    let load =
        json!([{ "direction": "y", "harmonic": { "amplitude_n": 2, "frequency_hz": frequency, "phase_deg": -90 } }]);
    for level in LEVELS {
        let y = displacements(&with_loads(base.clone(), load.clone()), &settings(Some(level), 0.02, 2.0 / frequency));
        let (least, most) = y.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), y| (least.min(*y), most.max(*y)));
        let ratio = 0.5 * (most - least) * stiffness / 2.0;
        assert!((ratio - 1.0 - 1.0 / 1600.0).abs() < 1e-3, "{level:?}: {ratio}");
    }
}

/// A half sine as long as half a period of an undamped oscillator moves it by π/2 times the static displacement, when it ends, and for ever.
#[test]
fn a_shock_of_half_a_period_has_the_response_factor_of_half_pi() {
    let base = preloaded("none");
    let (stiffness, natural) = oscillator(&base);
    let load = json!([{ "direction": "y", "shock": { "peak_n": 1, "at_s": 2e-3, "duration_s": PI / natural } }]);
    for level in LEVELS {
        let y = displacements(&with_loads(base.clone(), load.clone()), &settings(Some(level), 1e-3, 0.01));
        let most = y.iter().copied().fold(0.0, f64::max);
        let factor = (most - y[0]) * stiffness;
        assert!((factor - 0.5 * PI).abs() < 0.01, "{level:?}: {factor}");
    }
}

/// No step of error control passes over a shock that is much shorter than the steps before it: the spindle gets its whole momentum 2 F d/π.
#[test]
fn a_short_shock_is_not_missed() {
    let base = preloaded("none");
    let (_, natural) = oscillator(&base);
    let shock = json!([{ "direction": "y", "shock": { "peak_n": 40, "at_s": 5e-3, "duration_s": 1e-5 } }]);
    let json = with_loads(base, shock);
    for method in [Method::Gear, Method::Radau, Method::DormandPrince] {
        let settings = RunSettings { method, relative_tolerance: 1e-3, ..settings(None, 1e-3, 0.006) };
        let y = displacements(&json, &settings);
        let most = y.iter().copied().fold(0.0, f64::max);
        let expected = 2.0 / PI * 40.0 * 1e-5 / (0.05 * natural);
        // At this tolerance Gear damps the first quarter of a period, too.
        let ratio = (most - y[0]) / expected;
        assert!((0.95..1.02).contains(&ratio), "{method:?}: {ratio}");
    }
}

/// A line at the frequency of a harmonic load is named for it.
#[test]
fn a_harmonic_load_names_its_line() {
    let json =
        with_loads(article(), json!([{ "direction": "y", "harmonic": { "amplitude_n": 20, "frequency_hz": 1500 } }]));
    let settings = RunSettings { model_tolerance_db: 0.0, ..crate::article_run::settings() };
    let result = simulate(&scene(&json), &settings, &Control::until(&|| false)).unwrap();
    let load = lines(&result, Y).into_iter().find(|line| line.label == "load");
    assert!(load.is_some_and(|line| (line.frequency - 1500.0).abs() < 5.0), "{:?}", lines(&result, Y));
}

/// Loads that do not repeat leave no reduced model; a periodic load leaves all but the one whose motion repeats with the balls.
#[test]
fn reduced_models_represent_periodic_loads() {
    let settings = RunSettings { relative_tolerance: 1e-5, tightened: Some(1e-6), ..settings(None, 0.02, 0.4) };
    let settings = RunSettings { outputs: Outputs::vibration(), ..settings };
    let eligible = |loads: Value| Eligibility::of(&scene(&with_loads(article(), loads)), &settings).unwrap();
    let shocked = eligible(json!([{ "direction": "y", "shock": { "peak_n": 9, "at_s": 0.05, "duration_s": 0.001 } }]));
    assert_eq!(shocked.levels.len(), 1);
    assert_eq!(shocked.not_eligible[0].reason, NotEligibleReason::Known(Ineligible::LoadsChange));
    let shaken = eligible(json!([{ "direction": "z", "harmonic": { "amplitude_n": 9, "frequency_hz": 300 } }]));
    assert!(shaken.levels.contains(&ModelLevel::RadiallyCondensed), "{:?}", shaken.not_eligible);
    assert!(!shaken.levels.contains(&ModelLevel::Periodic));
    let reason = NotEligibleReason::CannotRepresent(Inapplicable::LoadsVary);
    assert!(shaken.not_eligible.iter().any(|level| level.reason == reason), "{:?}", shaken.not_eligible);
}
