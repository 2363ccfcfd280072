//! Balls of unequal size and pockets of uneven spacing: displacements that equilibria demand, the same in time on each model level, and
//! deviations of 0 that change nothing.

use std::f64::consts::TAU;

use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Mechanism;
use raceway::simulation::model::equilibrium::{equilibrium, start_state};
use raceway::simulation::model::failure::SimulationError;
use raceway::simulation::model::inapplicable::Inapplicable;
use raceway::simulation::model::surfaces::averaged_surfaces;
use raceway::simulation::result::run_result::RunResult;
use raceway::simulation::solve::eligibility::active_terms;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

use crate::article_run::{patient, settings};
use crate::scenes::{advance, article, changed, disturbed, model_on, needs, rates, scene};
use crate::waviness::{run_on, slow};

/// Levels that carry balls of unequal size and pockets of uneven spacing.
const LEVELS: [ModelLevel; 4] =
    [ModelLevel::Full, ModelLevel::Planar, ModelLevel::RadiallyCondensed, ModelLevel::SpindleOnly];

/// Balls of some numbers with a diameter that deviates [µm].
fn balls(deviations: &[(u32, f64)]) -> Value {
    let one = |&(ball, diameter): &(u32, f64)| json!({ "ball": ball, "diameter_um": diameter });
    json!({ "surfaces": { "balls": deviations.iter().map(one).collect::<Vec<_>>() } })
}

/// The pocket of the third of seven balls off its place [mrad].
fn pocket(deviation: f64) -> Value {
    json!({ "bearing": { "cage": { "pocket_spacing_mrad": [0, 0, deviation, 0, 0, 0, 0] } } })
}

/// Eight balls, of which two opposite ones are 1 µm larger.
fn two_opposite() -> Value {
    changed(json!({ "bearing": { "ball_count": 8 } }), balls(&[(2, 1.0), (6, 1.0)]))
}

/// Amplitudes [nm] of the displacements in y and z at a multiple of FTF, from equilibria at rest over a turn of the cage on massless balls.
fn at_rest(json: &Value, multiple: f64) -> [f64; 2] {
    const PLACES: usize = 112;
    let scene = scene(&changed(json.clone(), json!({ "gravity_m_s2": 0 })));
    let mechanism = Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar)));
    let mut sums = [[0.0; 2]; 2];
    for place in 0..PLACES {
        let turned = TAU * place as f64 / PLACES as f64;
        let mut m = mechanism.clone();
        // In the frame of the balls the load turns backwards.
        let [_, y, z] = m.load;
        let (sine, cosine) = turned.sin_cos();
        m.load = [0.0, y * cosine + z * sine, z * cosine - y * sine];
        let [_, y, z] = equilibrium(&m, 0.0).unwrap().spindle;
        let (s, c) = (multiple * turned).sin_cos();
        for (sum, found) in sums.iter_mut().zip([y * cosine - z * sine, y * sine + z * cosine]) {
            *sum = [sum[0] + found * c, sum[1] + found * s];
        }
    }
    sums.map(|[c, s]| 1e9 * 2.0 / PLACES as f64 * c.hypot(s))
}

fn assert_near(name: &str, found: [f64; 2], expected: [f64; 2], share: f64) {
    let is_near = |(found, expected): (f64, f64)| (found - expected).abs() <= share * expected + 2e-3;
    assert!(found.into_iter().zip(expected).all(is_near), "{name}: {found:?} nm for {expected:?} nm");
}

/// Preload of 2 µm on each diameter: one ball moves the spindle by (2/Z) Δd at FTF, to first order. A pocket off by ε moves it by
/// (4/3)(D/Z) ε. Two opposite balls move it under load alone, and at 2·FTF.
#[test]
fn unequal_balls_move_the_spindle_at_multiples_of_the_cage_speed() {
    let preloaded = |change: Value| slow(-4.0, 0.0, change);
    assert_near("+0.05 µm", at_rest(&preloaded(balls(&[(3, 0.05)])), 1.0), [14.32; 2], 2e-3);
    assert_near("+1 µm", at_rest(&preloaded(balls(&[(3, 1.0)])), 1.0), [299.3; 2], 2e-3);
    assert_near("a pocket", at_rest(&preloaded(pocket(1.0)), 1.0), [0.3810; 2], 5e-3);
    for multiple in [1.0, 2.0, 3.0] {
        assert_near("two opposite", at_rest(&preloaded(two_opposite()), multiple), [0.0; 2], 0.0);
    }
    // An uneven load gives all multiples of FTF.
    let [alike, loaded] = [slow(-4.0, 0.0, pocket(10.0)), slow(5.0, 200.0, pocket(10.0))];
    for multiple in [2.0, 3.0] {
        assert!(at_rest(&alike, multiple).iter().all(|amplitude| *amplitude < 0.05), "{multiple}·FTF");
        assert!(at_rest(&loaded, multiple).iter().all(|amplitude| *amplitude > 10.0), "{multiple}·FTF");
    }
    let loaded = slow(-4.0, 50.0, two_opposite());
    assert_near("two opposite, 50 N", at_rest(&loaded, 2.0), [62.1, 60.1], 3e-3);
    assert_near("two opposite, 50 N, at FTF", at_rest(&loaded, 1.0), [0.0; 2], 0.0);
}

/// Amplitudes [nm] of the lines of the displacements in y and z at a multiple of FTF; 0 without a line.
fn lines(result: &RunResult, multiple: f64) -> [f64; 2] {
    let frequency = multiple * result.summary.frequencies.cage;
    [Axis::Y, Axis::Z].map(|axis| {
        let channel = Channel::Spindle(axis, Motion::Displacement);
        let near =
            result.summary.lines.iter().filter(|(of, line)| *of == channel && (line.frequency - frequency).abs() < 0.2);
        near.map(|(_, line)| 1e3 * line.amplitude).fold(0.0, f64::max)
    })
}

/// Labels of the lines of the displacements above 1 % of the strongest.
fn labels(result: &RunResult) -> Vec<&str> {
    let strongest = result.summary.lines.iter().map(|(_, line)| line.amplitude).fold(0.0, f64::max);
    let lines = result.summary.lines.iter().filter(|(_, line)| line.amplitude > 0.01 * strongest);
    let mut labels: Vec<&str> = lines.map(|(_, line)| &line.label[..]).collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}

/// The same in time, on each model level, with the label of the line and without any other.
#[test]
fn a_run_with_unequal_balls_moves_as_its_equilibria() {
    for level in LEVELS {
        for (name, change, expected) in [("ball", balls(&[(3, 0.05)]), 14.32), ("pocket", pocket(10.0), 3.810)] {
            let result = run_on(&scene(&slow(-4.0, 0.0, change)), level);
            assert_near(&format!("{level:?}, {name}"), lines(&result, 1.0), [expected; 2], 0.01);
            // Single precision does not resolve the acceleration of such a slow motion. Its lines then have no label.
            let label = if level == ModelLevel::RadiallyCondensed { "" } else { "FTF" };
            assert_eq!(labels(&result), [label], "{level:?}, {name}");
        }
    }
}

/// Two opposite balls under 50 N: 2·FTF and none at FTF.
#[test]
fn two_opposite_balls_move_a_loaded_run_twice_a_cage_turn() {
    for level in [ModelLevel::RadiallyCondensed, ModelLevel::SpindleOnly] {
        let result = run_on(&scene(&slow(-4.0, 50.0, two_opposite())), level);
        assert_near(&format!("{level:?}"), lines(&result, 2.0), [62.1, 60.1], 0.02);
        assert!(labels(&result).contains(&"2·FTF"), "{level:?}: {:?}", labels(&result));
        assert!(lines(&result, 1.0).iter().all(|amplitude| *amplitude < 0.1), "{level:?}: {:?}", lines(&result, 1.0));
    }
}

/// Under equal loads, larger balls of a 6205 orbit slower by γ/(1 − γ) Δd/d: 3.2e-5 for 1 µm, with γ = 0.203 and d = 7.94 mm.
#[test]
fn larger_balls_orbit_slower() {
    let orbit_speed = |clearance_um: f64, deviation: f64| {
        let all: Vec<(u32, f64)> = (1..=9).map(|ball| (ball, deviation)).collect();
        let json = json!({
            "bearing": { "preset": "6205", "radial_clearance_um": clearance_um },
            "operation": { "speed_rpm": 1797 },
            "terms": { "cage": "off", "drag": "off", "churning": "off" },
            "gravity_m_s2": 0
        });
        let model = model_on(&changed(json, balls(&all)), Some(ModelLevel::Planar));
        let (m, time) = (model.mechanism(), 0.02);
        let end = advance(&model, &start_state(&model).unwrap(), (0.0, time), 1e-6, |_| {});
        1.0 + m.layout.ball(&end, 0).arc_velocity / (m.pitch_radius * m.orbit_ratio * m.rotation.inner.at(time).1)
    };
    let lag = 1.0 - orbit_speed(-2.0, 1.0) / orbit_speed(-4.0, 0.0);
    assert!((lag / 3.217e-5 - 1.0).abs() < 0.01, "{lag:e}");
}

/// Deviations of 0 change no bit.
#[test]
fn deviations_of_0_are_ideal() {
    let none = changed(
        changed(balls(&[(2, 0.0)]), pocket(0.0)),
        json!({ "surfaces": { "every_ball": { "diameter_spread_um": 0 } } }),
    );
    for rung in [ModelLevel::Full, ModelLevel::Planar] {
        let (ideal, none) = (model_on(&article(), Some(rung)), model_on(&changed(article(), none.clone()), Some(rung)));
        let state = disturbed(&ideal, 4);
        assert_eq!(rates(&ideal, 2.3e-4, &state), rates(&none, 2.3e-4, &state));
    }
}

/// Drawn diameters leave the drawn phases of waves as they are.
#[test]
fn a_surface_more_changes_no_other_drawn_number() {
    let waves = json!({ "surfaces": { "outer": { "random_waviness": { "amplitude_nm": 5, "to_order": 50 } } } });
    let phases = |json: &Value| {
        let scene = scene(json);
        let averaged = averaged_surfaces(&Mechanism::new(&scene, &needs(&scene, Some(ModelLevel::Planar))), &scene);
        averaged.unwrap().outer.waves.kept.iter().map(|kept| kept.wave).collect::<Vec<_>>()
    };
    let alone = changed(article(), waves);
    let more = json!({ "surfaces": {
        "every_ball": { "diameter_spread_um": 0.3 },
        "inner": { "random_waviness": { "amplitude_nm": 9 } }
    } });
    assert_eq!(phases(&alone), phases(&changed(alone.clone(), more)));
}

/// The level `periodic` states why it does not apply.
#[test]
fn no_motion_repeats_with_unequal_balls() {
    for (change, expected) in
        [(balls(&[(1, 0.1)]), Inapplicable::UnequalBalls), (pocket(1.0), Inapplicable::UnevenPockets)]
    {
        let scene = scene(&changed(article(), change));
        let settings = RunSettings { rung: Some(ModelLevel::Periodic), model_tolerance_db: 1.0, ..settings() };
        let settings = RunSettings { outputs: Outputs::vibration(), ..settings };
        let refused = active_terms(&scene, &settings.outputs, settings.rung);
        let reason = refused.unwrap_err().to_string();
        assert!(reason.contains(&expected.to_string()), "{reason}");
    }
}

/// 64 balls, all different, in uneven pockets at 30 000 r/min: a run on each level ends, and the reduced ones are near the planar one.
#[test]
fn sixty_four_different_balls_end_well() {
    let deviations: Vec<f64> = (0..64).map(|pocket| 2.0 * (f64::from(pocket) * 0.7).sin()).collect();
    let scene = scene(&json!({
        "bearing": {
            "preset": "6205", "ball_count": 64, "ball_diameter_mm": 3, "pitch_diameter_mm": 75,
            "outer_diameter_mm": 90, "inner_diameter_mm": 60, "radial_clearance_um": -4,
            "cage": { "pocket_spacing_mrad": deviations, "pocket_clearance_mm": 0.1 }
        },
        "operation": { "speed_rpm": 30_000, "radial_load_y_n": 300 },
        "surfaces": { "every_ball": { "diameter_spread_um": 2 }, "seed": 3 }
    }));
    let levels = |level: ModelLevel| {
        let settings = RunSettings {
            rung: Some(level),
            model_tolerance_db: 1.0,
            settle: 0.01,
            duration: 0.02,
            outputs: Outputs::vibration(),
            ..settings()
        };
        let result: Result<RunResult, SimulationError> = simulate(&scene, &settings, &patient());
        let channels = result.unwrap().summary.channels;
        [Axis::Y, Axis::Z].map(|axis| {
            let of = Channel::Spindle(axis, Motion::Acceleration);
            channels.iter().find(|(channel, _)| *channel == of).and_then(|(_, metrics)| metrics.level_db).unwrap()
        })
    };
    let planar = levels(ModelLevel::Planar);
    // Balls of `spindle_only` do not lag in their pockets.
    for (level, tolerance) in [(ModelLevel::RadiallyCondensed, 0.15), (ModelLevel::SpindleOnly, 2.0)] {
        let found = levels(level);
        let off = [0, 1].map(|axis| (found[axis] - planar[axis]).abs());
        assert!(off.iter().all(|off| *off < tolerance), "{level:?}: {found:?} dB for {planar:?} dB");
    }
}
