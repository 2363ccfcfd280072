//! The full model in a plain job, with fixed steps where they are accepted, beside error control: real-time factor with
//! verification included, and level error.
//!
//! `cargo bench --bench fixed_steps` runs the scenes of `benches/scenes/mod.rs`, then four of them with an axial load of 12 N and
//! nothing omitted. The reference is `gear` at 1e-6 with all terms over the same time. Times are medians of
//! `RUNS` runs of 0.02 + 0.1 s on one core, both ways in turn.
//!
//! Bearings with rattling cages follow, once each, over 0.05 + 0.5 s, beside error control at 1e-3 and 1e-5. Their motion is
//! chaotic, so that only statistics are compared.

mod scenes;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::result::metrics::Summary;
use raceway::simulation::solve::run::simulate;
use serde_json::{Value, json};

const RUNS: usize = 5;
const CHANNELS: [Channel; 4] = [
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
    Channel::Spindle(Axis::Y, Motion::Velocity),
    Channel::Spindle(Axis::Z, Motion::Velocity),
];
/// Numbers of the scenes that also run with an axial load.
const AXIAL: [usize; 4] = [0, 2, 7, 17];

fn main() {
    raceway::commands::allocator::keep_memory_for_next_run();
    println!(
        "| scene | × real time | by | steps | errors a_y, a_z, v_y, v_z dB | stated dB | by error control: × | by | steps | errors dB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let (mut factors, mut errors) = (Vec::new(), Vec::new());
    for number in 0..scenes::SCENES.len() {
        let (factor, error) = line(&format!("{:?}", scenes::SCENES[number]), &scenes::scene(number).0);
        factors.push(factor);
        errors.push(error);
    }
    for number in AXIAL {
        let mut json: Value = serde_json::from_str(&scenes::scene(number).1).expect("JSON of a scene");
        json["operation"]["axial_load_n"] = 12.into();
        json["terms"] = json!({ "drag": "on", "churning": "on", "conformity": "on", "spin": "on" });
        let scene = scene_from_json(&json.to_string()).expect("an axial load moves a spindle that is free");
        line(&format!("{:?}, 12 N axial, nothing omitted", scenes::SCENES[number]), &scene);
    }
    factors.sort_by(f64::total_cmp);
    println!(
        "\n{} scenes without axial load: {:.2} × real time least, {:.2} in the median; worst error {:.4} dB",
        factors.len(),
        factors[0],
        factors[factors.len() / 2],
        errors.into_iter().fold(0.0, f64::max)
    );
    println!(
        "\n| rattling | × real time | by | a_y, a_z less those at 1e-5, dB | stated, and at 1e-5 | load, pocket load, cage's orbit over those at 1e-5 | by error control at 1e-3: × | a_y, a_z |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for json in rattling() {
        rattling_line(&json);
    }
}

/// Scenes whose balls rattle in the cage pockets.
fn rattling() -> [Value; 7] {
    let dry = |preset: &str, speed: f64, load: f64| {
        json!({
            "bearing": { "preset": preset, "cage": { "film": "none" } },
            "operation": { "speed_rpm": speed, "radial_load_y_n": load },
        })
    };
    let mut without_oil = dry("article-integrated", 50e3, 200.0);
    without_oil["lubricant"] = json!({ "kind": "dry" });
    [
        dry("article-integrated", 50e3, 200.0),
        dry("article-integrated", 20e3, 200.0),
        dry("article-integrated", 30e3, 20.0),
        dry("article-deep-groove", 50e3, 200.0),
        dry("608", 30e3, 60.0),
        dry("6205", 10e3, 300.0),
        without_oil,
    ]
}

/// Prints the line of a scene whose motion is chaotic.
fn rattling_line(json: &Value) {
    let scene = scene_from_json(&json.to_string()).expect("a cage may rattle");
    let plain = RunSettings { settle: 0.05, duration: 0.5, ..plain() };
    let at = |relative_tolerance| RunSettings { tightened: None, relative_tolerance, ..plain.clone() };
    let [stepped, loose, tight] = [&plain, &at(1e-3), &at(1e-5)]
        .map(|settings| simulate(&scene, settings, &Control::until(&|| false)).expect("the scene runs").summary);
    let levels = |summary: &Summary| {
        let off = |channel| 20.0 * (rms(summary, channel) / rms(&tight, channel)).log10();
        format!("{:+.3} {:+.3}", off(CHANNELS[0]), off(CHANNELS[1]))
    };
    let stated = |summary: &Summary| summary.accuracy.level_error_db().unwrap_or(f64::NAN);
    let peaks = |summary: &Summary| {
        let (contacts, cage) =
            (summary.contacts.as_ref().expect("asked for"), summary.cage.as_ref().expect("asked for"));
        [contacts.raceway.outer.max_load, cage.max_pocket_load, cage.orbit_radius]
    };
    let (found, expected) = (peaks(&stepped), peaks(&tight));
    let factor = |summary: &Summary| (plain.settle + plain.duration) / summary.solver.wall_time;
    println!(
        "| {}, {} r/min, {} N{} | {:.2} | {} | {} | {:.3}, {:.3} | {:.3}, {:.2}, {:.2} | {:.2} | {} |",
        json["bearing"]["preset"].as_str().unwrap_or_default(),
        json["operation"]["speed_rpm"],
        json["operation"]["radial_load_y_n"],
        if json["lubricant"].is_object() { ", dry" } else { "" },
        factor(&stepped),
        stepped.solver.method,
        levels(&stepped),
        stated(&stepped),
        stated(&tight),
        found[0] / expected[0],
        found[1] / expected[1],
        found[2] / expected[2],
        factor(&loose),
        levels(&loose)
    );
}

/// Settings of a plain job on `full`.
fn plain() -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung: Some(ModelLevel::Full),
        relative_tolerance: 1e-3,
        tightened: Some(1e-5),
        model_tolerance_db: 0.05,
        fixed_step: None,
        settle: 0.02,
        duration: 0.1,
        outputs: Outputs { contacts: true, cage: true, ..Outputs::vibration() },
    }
}

/// Prints a line of the table and returns real-time factor and largest level error [dB] of the plain job.
fn line(name: &str, scene: &Scene) -> (f64, f64) {
    let plain = plain();
    let controlled = RunSettings { tightened: None, ..plain.clone() };
    let exact =
        RunSettings { method: Method::Gear, relative_tolerance: 1e-6, model_tolerance_db: 0.0, ..controlled.clone() };
    let once =
        |settings: &RunSettings| simulate(scene, settings, &Control::until(&|| false)).expect("the scene runs").summary;
    let exact = once(&exact);
    let (mut times, mut found) = ([Vec::new(), Vec::new()], None);
    for _ in 0..RUNS {
        let both = [&plain, &controlled].map(once);
        for (times, summary) in times.iter_mut().zip(&both) {
            times.push(summary.solver.wall_time);
        }
        found = Some(both);
    }
    let both = found.expect("at least one run");
    let factor = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        (plain.settle + plain.duration) / times[RUNS / 2]
    };
    let factors = times.each_mut().map(factor);
    let errors = both
        .each_ref()
        .map(|summary| CHANNELS.map(|channel| 20.0 * (rms(summary, channel) / rms(&exact, channel)).log10()));
    let words = |errors: &[f64; 4]| errors.map(|error| format!("{error:+.4}")).join(" ");
    let [stepped, by_control] = &both;
    println!(
        "| {name} | {:.2} | {} | {} | {} | {:.4} | {:.2} | {} | {} | {} |",
        factors[0],
        stepped.solver.method,
        stepped.solver.statistics.steps,
        words(&errors[0]),
        // A spindle with a slow axial transient states a larger error along its axis.
        CHANNELS.iter().filter_map(|channel| stepped.accuracy.level_errors.of(*channel)).fold(0.0, f64::max),
        factors[1],
        by_control.solver.method,
        by_control.solver.statistics.steps,
        words(&errors[1])
    );
    (factors[0], errors[0].into_iter().fold(0.0, |worst, error| f64::max(worst, error.abs())))
}

fn rms(summary: &Summary, channel: Channel) -> f64 {
    summary.channels.iter().find(|(of, _)| *of == channel).map_or(f64::NAN, |(_, metrics)| metrics.rms)
}
