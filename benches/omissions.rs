//! What each term costs and what leaving it out changes: the dynamics without it beside the whole ones.
//!
//! `cargo bench --bench omissions` runs the scenes of `scenes/mod.rs`, `-- extremes` those outside of them, `-- FIRST LAST` some. Each
//! motion is integrated by `auto` at a relative tolerance of 1e-6 over four windows of 0.1 s (or of 0.05 s and 20 ball passages, if that is
//! longer) after settling; a level is the mean power of the windows, 0–20 kHz, the spread the standard deviation of the windows' levels.

mod scenes;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::{Method, OdeSystem};
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::observer::Observer;
use raceway::simulation::model::terms::{Grounds, Needs};
use raceway::simulation::recording::sampling::RATE;
use raceway::simulation::result::metrics::channel_metrics;
use raceway::simulation::solve::judgement::{self, Judge, Omission};
use serde_json::{Value, json};

const WINDOW: f64 = 0.1;
const WINDOWS: usize = 4;
const TOLERANCE: f64 = 1e-6;
const CHANNELS: [Channel; 4] = [
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
    Channel::Spindle(Axis::Y, Motion::Velocity),
    Channel::Spindle(Axis::Z, Motion::Velocity),
];

/// What lies outside of the scenes, by name: light, slow, dry, flooded, preloaded, axially loaded and rattling bearings.
fn extremes() -> Vec<(&'static str, Scene)> {
    let article = |name, bearing: Value, rest: Value| {
        let mut json = json!({
            "bearing": { "preset": "article-integrated" },
            "operation": { "speed_rpm": 50_000, "radial_load_y_n": 200 }
        });
        merge(&mut json["bearing"], bearing);
        merge(&mut json, rest);
        (name, json)
    };
    let operation = |speed: f64, load: f64| json!({ "operation": { "speed_rpm": speed, "radial_load_y_n": load } });
    let axial = |load: f64, axial: f64| json!({ "operation": { "speed_rpm": 50_000, "radial_load_y_n": load, "axial_load_n": axial } });
    let none = || json!({});
    let catalogue = |name, preset: &str, speed: f64, load: f64| {
        let json = json!({ "bearing": preset, "operation": { "speed_rpm": speed, "radial_load_y_n": load } });
        (name, json)
    };
    [
        article("5 N", none(), operation(50_000.0, 5.0)),
        article("20 N", none(), operation(50_000.0, 20.0)),
        article("1000 r/min", none(), operation(1000.0, 200.0)),
        article("3000 r/min, 50 N", none(), operation(3000.0, 50.0)),
        article("dry, Coulomb", none(), json!({ "lubricant": "dry" })),
        article("dry, Coulomb, film", json!({ "cage": { "film": "empirical-11" } }), json!({ "lubricant": "dry" })),
        article("oil", none(), json!({ "lubricant": "oil" })),
        article("oil, fill 0.5", none(), json!({ "lubricant": { "kind": "oil", "fill": 0.5 } })),
        article("Eyring oil", none(), json!({ "lubricant": { "kind": "oil", "traction": { "law": "eyring" } } })),
        article(
            "traction from 0.1 m/s",
            none(),
            json!({ "lubricant": { "traction": { "law": "four_parameter", "at_slip_m_s": 0.1 } } }),
        ),
        article("preload −3 µm", json!({ "radial_clearance_um": -3 }), none()),
        article(
            "preload, closed seats",
            json!({ "radial_clearance_um": -3, "cage": { "seat": "closed", "offset_mm": 0 } }),
            none(),
        ),
        article("axial 30 N", none(), axial(50.0, 30.0)),
        article("axial 100 N", none(), axial(20.0, 100.0)),
        article("no film", json!({ "cage": { "film": "none" } }), none()),
        article(
            "land",
            json!({ "cage": { "land": { "clearance_mm": 0.2, "diameter_mm": 14.6, "width_mm": 1 } } }),
            none(),
        ),
        catalogue("6205, 500 N, 1797 r/min", "6205", 1797.0, 500.0),
        catalogue("6205, 2000 N, 6000 r/min", "6205", 6000.0, 2000.0),
        catalogue("608, 50 N, 20 000 r/min", "608", 20_000.0, 50.0),
    ]
    .map(|(name, json)| {
        let text = json.to_string();
        (name, scene_from_json(&text).unwrap_or_else(|fault| panic!("{text}: {fault:?}")))
    })
    .into()
}

/// Sets fields of an object, objects within it field by field.
fn merge(into: &mut Value, changes: Value) {
    match (into, changes) {
        (Value::Object(fields), Value::Object(changes)) => {
            for (name, value) in changes {
                merge(fields.entry(name).or_insert(Value::Null), value);
            }
        }
        (into, value) => *into = value,
    }
}

/// Leaves something out; with what is said of it beforehand, where that is bounded.
struct Case {
    name: String,
    needs: Needs,
    bound: Option<f64>,
}

/// Every single omission that changes the equations of a scene, and all together that the default tolerance leaves out where
/// levels alone are asked for.
fn cases(scene: &Scene, whole: &Needs) -> Vec<Case> {
    let judge = Judge::new(scene, whole).expect("a scene at rest");
    let judged = |name: &str, omission: Omission| {
        let mut needs = whole.clone();
        omission.leave_out(&mut needs);
        Case { name: name.into(), needs, bound: judge.as_ref().and_then(|judge| judge.bound(omission)) }
    };
    let plain = |name: &str, leave_out: fn(&mut Needs)| {
        let mut needs = whole.clone();
        leave_out(&mut needs);
        Case { name: name.into(), needs, bound: None }
    };
    let default = judgement::within(whole.clone(), scene, &outputs(), 0.05);
    let by_judgement = default.left_out.iter().filter(|left_out| left_out.by == Grounds::Judgement);
    let bound = by_judgement.filter_map(|left_out| left_out.bound).map(|(bound, _)| bound).sum();
    let mut cases = vec![
        judged("6 points", Omission::Strips(6)),
        judged("4 points", Omission::Strips(4)),
        judged("2 points", Omission::Strips(2)),
        judged("drag", Omission::Drag),
        judged("churning", Omission::Churning),
        plain("spin", |n| n.raceway.spin = false),
        plain("conformity", |n| n.raceway.conformity = false),
        plain("pocket friction", |n| n.pocket.friction = false),
        plain("land", |n| n.land = false),
        Case { name: "within 0.05 dB".into(), needs: default, bound: Some(bound) },
    ];
    cases.retain(|case| {
        Needs { left_out: Vec::new(), ..case.needs.clone() } != Needs { left_out: Vec::new(), ..whole.clone() }
    });
    cases
}

struct Levels {
    /// Level of the mean power, and spread of the windows' levels [dB].
    level: [f64; 4],
    spread: [f64; 4],
    /// Largest contact load [N], cage speed [rad/s], largest slip [m/s] and pocket load [N].
    quantities: [f64; 4],
    /// State at the end.
    state: Vec<f64>,
    model: Model,
    /// CPU time of the run [s].
    time: f64,
}

fn settings(scene: &Scene, outputs: Outputs) -> RunSettings {
    let cage = 0.43 * scene.operating_speed() / std::f64::consts::TAU;
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: TOLERANCE,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: (3.0 / cage).max(0.02),
        duration: window(scene) * WINDOWS as f64,
        outputs,
    }
}

fn window(scene: &Scene) -> f64 {
    let passage = 2.3 / (scene.operating_speed() / std::f64::consts::TAU) / scene.bearing.parameters.ball_count as f64;
    WINDOW.max(20.0 * passage).min(0.3)
}

fn outputs() -> Outputs {
    Outputs { vibration: true, contacts: false, cage: false, spectra: Vec::new(), series: Vec::new() }
}

fn levels(scene: &Scene, needs: &Needs) -> Levels {
    let settings = settings(scene, outputs());
    let model = Model::new(scene, needs);
    let start = start_state(&model).expect("a scene at rest");
    let begin = cpu_time();
    let mut observer = Observer::new(&model, needs, &settings);
    let tolerances = model.mechanism().layout.tolerances(TOLERANCE);
    let mut integrator = Method::Auto.start(&model, 0.0, &start, tolerances, None);
    while observer.next_look().is_some() {
        integrator.step(observer.end()).expect("a step");
        observer.after(integrator.as_ref());
    }
    let time = cpu_time() - begin;
    let state = integrator.state().to_vec();
    drop(integrator);
    let recording = observer.finish();
    let length = (window(scene) * RATE) as usize;
    let slip = recording.contacts.inner.max_slip.max(recording.contacts.outer.max_slip);
    let quantities =
        [recording.quantities().max_load, recording.quantities().cage_speed, slip, recording.max_pocket_load];
    let mut found = Levels { level: [0.0; 4], spread: [0.0; 4], quantities, state, model, time };
    for (c, channel) in CHANNELS.into_iter().enumerate() {
        let signal = recording.signal(channel).expect("kept");
        let power: Vec<f64> = signal
            .chunks_exact(length)
            .take(WINDOWS)
            .map(|window| (channel_metrics(channel, window, 0.0).rms / channel.scale()).powi(2))
            .collect();
        let n = power.len() as f64;
        let db: Vec<f64> = power.iter().map(|power| 10.0 * power.log10()).collect();
        let mean = db.iter().sum::<f64>() / n;
        found.level[c] = 10.0 * (power.iter().sum::<f64>() / n).log10();
        found.spread[c] = (db.iter().map(|level| (level - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    }
    found
}

/// Times of one evaluation of dy/dt of two models [s], each at its own state: least of several means, taken in turn.
fn evaluations(whole: &Levels, lean: &Levels) -> [f64; 2] {
    const COUNT: u32 = 100;
    let mut rate = vec![0.0; whole.state.len()];
    let mut least = [f64::INFINITY; 2];
    for _ in 0..60 {
        for (least, of) in least.iter_mut().zip([whole, lean]) {
            let begin = cpu_time();
            for _ in 0..COUNT {
                of.model.derivative(0.1, std::hint::black_box(&of.state), &mut rate);
            }
            *least = least.min((cpu_time() - begin) / f64::from(COUNT));
        }
    }
    least
}

#[cfg(target_os = "linux")]
fn cpu_time() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[cfg(not(target_os = "linux"))]
fn cpu_time() -> f64 {
    std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

fn named() -> Vec<(String, Scene)> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    if arguments.iter().any(|argument| argument == "extremes") {
        return extremes().into_iter().map(|(name, scene)| (name.to_owned(), scene)).collect();
    }
    let numbers: Vec<usize> = arguments.iter().filter_map(|argument| argument.parse().ok()).collect();
    let (first, last) =
        (numbers.first().copied().unwrap_or(1), numbers.get(1).copied().unwrap_or(scenes::SCENES.len()));
    (first..=last)
        .map(|number| {
            let (speed, load, clearance, balls, mass, grade) = scenes::SCENES[number - 1];
            let name = format!("{number}: {speed} r/min, {load} N, {clearance} µm, {balls}, {mass} g, G {grade}");
            (name, scenes::scene(number - 1).0)
        })
        .collect()
}

/// What an omission has shown over the scenes.
#[derive(Default)]
struct Shown {
    evaluation: Vec<f64>,
    run: Vec<f64>,
    off: [Vec<f64>; 4],
    bounds: Vec<f64>,
    used: Vec<f64>,
    quantities: [Vec<f64>; 4],
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NAN, f64::max)
}

fn main() {
    let mut shown: Vec<(String, Shown)> = Vec::new();
    let mut spreads: [Vec<f64>; 4] = Default::default();
    let decibels = |values: &[f64]| values.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(" ");
    for (name, scene) in named() {
        let needs = Needs::of(&scene, &outputs(), None).expect("a scene");
        let whole = levels(&scene, &needs);
        let judged = Judge::new(&scene, &needs).expect("a scene at rest").is_some();
        println!(
            "{name}: {}, {} strips, {:.2} s, {}; spread {}",
            needs.rung.name(),
            needs.raceway.strips,
            whole.time,
            if judged { "judged" } else { "not judged" },
            decibels(&whole.spread)
        );
        spreads.iter_mut().zip(whole.spread).for_each(|(all, one)| all.push(one));
        for case in cases(&scene, &needs) {
            let lean = levels(&scene, &case.needs);
            let off: [f64; 4] = std::array::from_fn(|c| lean.level[c] - whole.level[c]);
            let worst = off.into_iter().fold(0.0, |worst: f64, off| worst.max(off.abs()));
            let [before, after] = evaluations(&whole, &lean);
            let moved: [f64; 4] = std::array::from_fn(|q| (lean.quantities[q] / whole.quantities[q] - 1.0).abs());
            println!(
                "    {:25} {} dB, bound {:.4}, {:.3} of it; load, cage speed, slip, pocket {} %; evaluation {:.3} of {:.0} ns, run {:.3}",
                case.name,
                decibels(&off),
                case.bound.unwrap_or(f64::NAN),
                worst / case.bound.unwrap_or(f64::NAN),
                decibels(&moved.map(|share| 100.0 * share)),
                after / before,
                1e9 * before,
                lean.time / whole.time
            );
            let at = shown.iter().position(|(of, _)| *of == case.name).unwrap_or_else(|| {
                shown.push((case.name.clone(), Shown::default()));
                shown.len() - 1
            });
            let all = &mut shown[at].1;
            all.evaluation.push(after / before);
            all.run.push(lean.time / whole.time);
            all.off.iter_mut().zip(off).for_each(|(all, one)| all.push(one.abs()));
            all.quantities.iter_mut().zip(moved).for_each(|(all, one)| all.push(one));
            if let Some(bound) = case.bound {
                all.bounds.push(bound);
                all.used.push(worst / bound);
            }
        }
    }
    println!(
        "\nspread, median and largest: {}; {}",
        decibels(&spreads.each_ref().map(|s| median(s))),
        decibels(&spreads.each_ref().map(|s| largest(s)))
    );
    println!(
        "\n| left out | scenes | evaluation, median | run, median | a_y, a_z, v_y, v_z, median dB | the same, largest | bound, least and largest dB | effect over bound, median and largest | load, cage speed, slip, pocket, largest % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, all) in &shown {
        println!(
            "| {name} | {} | {:.3} | {:.3} | {} | {} | {:.4} {:.4} | {:.3} {:.3} | {} |",
            all.evaluation.len(),
            median(&all.evaluation),
            median(&all.run),
            decibels(&all.off.each_ref().map(|s| median(s))),
            decibels(&all.off.each_ref().map(|s| largest(s))),
            all.bounds.iter().copied().fold(f64::NAN, f64::min),
            largest(&all.bounds),
            median(&all.used),
            largest(&all.used),
            decibels(&all.quantities.each_ref().map(|s| 100.0 * largest(s)))
        );
    }
}
