//! The spindle-only model in time and its periodic orbit, against the full model and each other.

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::failure::SimulationError;
use raceway::simulation::model::observer::Observer;
use raceway::simulation::model::periodic::{self, passage};
use raceway::simulation::model::spindle_only::simulate;
use raceway::simulation::model::terms::ActiveTerms;
use raceway::simulation::recording::record::Recording;
use raceway::simulation::result::metrics::channel_metrics;

const QUIET: Control<'static> = Control::until(&|| false);

fn article(clearance_um: f64, load_n: f64, speed_rpm: f64) -> Scene {
    scene_from_json(&format!(
        r#"{{ "bearing": {{ "preset": "article-integrated", "radial_clearance_um": {clearance_um} }},
            "operation": {{ "speed_rpm": {speed_rpm}, "radial_load_y_n": {load_n} }} }}"#
    ))
    .unwrap()
}

fn settings(settle: f64, duration: f64) -> RunSettings {
    RunSettings {
        method: Method::Gear,
        rung: None,
        relative_tolerance: 1e-5,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle,
        duration,
        outputs: Outputs::vibration(),
    }
}

/// rms of accelerations and velocities of y and z, 0–20 kHz.
fn levels(recording: &Recording) -> [f64; 4] {
    let of = |axis, motion| {
        let channel = Channel::Spindle(axis, motion);
        channel_metrics(channel, recording.signal(channel).unwrap(), 0.0).rms
    };
    let [y, z] = [Axis::Y, Axis::Z];
    [of(y, Motion::Acceleration), of(z, Motion::Acceleration), of(y, Motion::Velocity), of(z, Motion::Velocity)]
}

fn worst_db(one: &[f64; 4], other: &[f64; 4]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (20.0 * (a / b).log10()).abs()).fold(0.0, f64::max)
}

fn full(scene: &Scene, settings: &RunSettings) -> [f64; 4] {
    let needs = ActiveTerms::of(scene, &settings.outputs, Some(ModelLevel::Full)).unwrap();
    let model = Model::new(scene, &needs);
    let tolerances = model.mechanism().layout.tolerances(settings.relative_tolerance);
    let start = start_state(&model).unwrap();
    let mut observer = Observer::new(&model, &needs, settings);
    let mut integrator = settings.method.start(&model, 0.0, &start, tolerances, None);
    while integrator.time() < observer.end() {
        integrator.step(observer.end()).unwrap();
        observer.after(integrator.as_ref());
    }
    let recording = observer.finish();
    levels(&recording)
}

#[test]
fn the_spindle_only_model_has_the_levels_of_the_full_model() {
    for (clearance, load, speed) in [(5.0, 200.0, 50_000.0), (5.0, 400.0, 40_000.0)] {
        let (scene, settings) = (article(clearance, load, speed), settings(0.03, 0.03));
        let (recording, _) = simulate(&scene, &settings, &QUIET).unwrap();
        let apart = worst_db(&levels(&recording), &full(&scene, &settings));
        assert!(apart < 0.3, "{clearance} µm, {load} N, {speed} r/min: {apart} dB");
    }
}

#[test]
fn the_periodic_orbit_is_the_limit_of_a_run_in_time() {
    // In the last two a kink of the load has an unfavourable place in the steps of a passage.
    let scenes = [
        (5.0, 200.0, 50_000.0),
        (2.0, 400.0, 30_000.0),
        (5.0, 200.0, 10_000.0),
        (2.0, 100.0, 30_000.0),
        (5.0, 400.0, 40_000.0),
    ];
    for (clearance, load, speed) in scenes {
        let (scene, settings) = (article(clearance, load, speed), settings(0.1, 0.1));
        let (in_time, _) =
            simulate(&scene, &RunSettings { fixed_step: Some(3e-6), ..settings.clone() }, &QUIET).unwrap();
        let (periodic, _) = periodic::simulate(&scene, &settings, &QUIET).unwrap();
        assert_eq!(periodic.signals[0].values().unwrap().len(), in_time.signals[0].values().unwrap().len());
        let apart = worst_db(&levels(&periodic), &levels(&in_time));
        assert!(apart < 0.01, "{clearance} µm, {load} N, {speed} r/min: {apart} dB");
        let orbit = passage(&scene, &settings).unwrap();
        assert!(orbit.orbit.radius() < 0.95);
        let series = orbit.rms(20_000.0);
        // The recording window is not a whole number of passages.
        let apart = worst_db(&[series[4], series[5], 1e3 * series[2], 1e3 * series[3]], &levels(&in_time));
        assert!(apart < 0.2, "{clearance} µm, {load} N, {speed} r/min: {apart} dB");
    }
}

/// P_d 10 µm at 200 N: the period is two ball passages, although an orbit with the period of one exists.
#[test]
fn motions_with_a_period_of_several_balls_are_rejected() {
    for speed in [20_000.0, 40_000.0] {
        let refused = passage(&article(10.0, 200.0, speed), &settings(0.1, 0.1));
        assert!(
            matches!(refused, Err(SimulationError::NotApplicable { rung: "periodic", .. })),
            "{speed}: {refused:?}"
        );
    }
}

#[test]
fn scenes_outside_the_spindle_only_model_are_rejected_with_a_reason() {
    let scene = article(5.0, 200.0, 50_000.0);
    let base = settings(0.01, 0.01);
    let with = |outputs: Outputs| simulate(&scene, &RunSettings { outputs, ..base.clone() }, &QUIET);
    let outputs = &base.outputs;
    assert!(with(outputs.clone()).is_ok());
    assert!(with(Outputs { contacts: true, ..outputs.clone() }).is_err());
    assert!(with(Outputs { cage: true, ..outputs.clone() }).is_err());
    assert!(with(Outputs { series: vec![Channel::CageSpeed], ..outputs.clone() }).is_err());
    let mut misaligned = scene.clone();
    misaligned.operation.misalignment = [1e-3, 0.0];
    let words = simulate(&misaligned, &base, &QUIET).unwrap_err().to_string();
    assert_eq!(words, "rung spindle_only is not applicable: the spindle is misaligned");
    let mut unbalanced = scene.clone();
    unbalanced.spindle.unbalance = raceway::physics::spindle::Unbalance::Grade(6.3e-3);
    assert!(periodic::simulate(&unbalanced, &base, &QUIET).is_err());
}

/// The chosen steps, some longer than the sampling interval, against steps of an eighth of it.
#[test]
fn chosen_steps_have_errors_below_a_hundredth_of_a_decibel() {
    for (clearance, load, speed) in [(5.0, 200.0, 50_000.0), (2.0, 400.0, 30_000.0), (10.0, 400.0, 20_000.0)] {
        let (scene, settings) = (article(clearance, load, speed), settings(0.02, 0.1));
        let (chosen, statistics) = simulate(&scene, &settings, &QUIET).unwrap();
        assert!(statistics.least_step > 1e-5, "{clearance} µm, {load} N, {speed} r/min: {}", statistics.least_step);
        let finer = RunSettings { fixed_step: Some(1.25e-6), ..settings };
        let apart = worst_db(&levels(&chosen), &levels(&simulate(&scene, &finer, &QUIET).unwrap().0));
        assert!(apart < 0.01, "{clearance} µm, {load} N, {speed} r/min: {apart} dB");
    }
}

/// A run without settling time. The first sample is the initial state, and no interpolation uses a time before it.
#[test]
fn a_run_without_settling_records_from_the_start() {
    let (scene, settings) = (article(5.0, 200.0, 50_000.0), settings(0.0, 0.02));
    let velocity = |fixed_step| {
        let (found, _) = simulate(&scene, &RunSettings { fixed_step, ..settings.clone() }, &QUIET).unwrap();
        found.signal(Channel::Spindle(Axis::Y, Motion::Velocity)).unwrap().to_vec()
    };
    let (long, short) = (velocity(None), velocity(Some(1.25e-6)));
    assert_eq!((long.len(), short.len(), short[0]), (2048, 2048, 0.0));
    let apart = |range: std::ops::Range<usize>| {
        range.map(|i| (long[i] - short[i]).abs()).fold(0.0, f64::max)
            / short.iter().fold(0.0, |most: f64, v| most.max(v.abs()))
    };
    assert!(apart(8..200) < 0.02, "{} {}", apart(8..200), apart(0..8));
}

/// G 6.3 on 50 g adds an acceleration of 6.3 mm/s · ω in all directions, and a ramp ends at its speed.
#[test]
fn unbalance_and_ramps_run_in_time() {
    let mut scene = article(5.0, 200.0, 20_000.0);
    let base = settings(0.05, 0.1);
    let quiet = simulate(&scene, &base, &QUIET).unwrap().0;
    scene.spindle.unbalance = raceway::physics::spindle::Unbalance::Grade(6.3e-3);
    let loud = simulate(&scene, &base, &QUIET).unwrap().0;
    let added = levels(&loud)[1].powi(2) - levels(&quiet)[1].powi(2);
    let force = 6.3e-3 * 20_000.0 * std::f64::consts::TAU / 60.0 / 2f64.sqrt();
    assert!((added.max(0.0).sqrt() / force - 1.0).abs() < 0.5, "{added} against {force}²");
    let points = vec![(0.0, 1000.0), (0.1, 3000.0)];
    scene.operation.speed = raceway::physics::operation::SpeedProfile::new(points).unwrap();
    let (ramp, statistics) = simulate(&scene, &base, &QUIET).unwrap();
    assert!((ramp.speeds.shaft - 2750.0).abs() < 1.0);
    assert!(levels(&ramp).iter().all(|level| level.is_finite() && *level > 0.0) && statistics.steps > 5000);
}
