//! What each term costs and what leaving it out changes: the dynamics without it beside the whole ones.
//!
//! `cargo bench --bench omissions` runs the scenes of `scenes/mod.rs`, `-- extremes` those outside of them, `-- FIRST LAST` some. Each
//! motion is integrated by `auto` at a relative tolerance of 1e-6 over four windows of 0.1 s (or of 0.05 s and 20 ball passages, if that is
//! longer) after settling; a level is the mean power of the windows, 0–20 kHz, the spread the standard deviation of the windows' levels.

mod scenes;

use std::time::Instant;

use raceway::numerics::ode::{Method, OdeSystem};
use raceway::simulation::channel::{Axis, Channel, Motion};
use raceway::simulation::metrics::channel_metrics;
use raceway::simulation::model::Model;
use raceway::simulation::needs::Needs;
use raceway::simulation::observe::{Observer, RATE};
use raceway::simulation::run::{Outputs, RunSettings, start_state};
use raceway::simulation::scene::Scene;

const WINDOW: f64 = 0.1;
const WINDOWS: usize = 4;
const TOLERANCE: f64 = 1e-6;
const CHANNELS: [Channel; 4] = [
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
    Channel::Spindle(Axis::Y, Motion::Velocity),
    Channel::Spindle(Axis::Z, Motion::Velocity),
];

/// A term and how it is left out.
type Omission = (&'static str, fn(&mut Needs));

fn gauss(needs: &mut Needs, points: usize) {
    (needs.raceway.gauss, needs.raceway.strips) = (true, points);
}

const OMISSIONS: [Omission; 12] = [
    ("ball gravity", |n| n.ball_gravity = false),
    ("drag", |n| n.drag = false),
    ("churning", |n| n.churning = false),
    ("drag+churning", |n| (n.drag, n.churning) = (false, false)),
    ("spin", |n| n.raceway.spin = false),
    ("conformity", |n| n.raceway.conformity = false),
    ("pocket friction", |n| n.pocket.friction = false),
    ("land", |n| n.land = false),
    ("6 points", |n| gauss(n, 6)),
    ("4 points", |n| gauss(n, 4)),
    ("2 points", |n| gauss(n, 2)),
    ("4 points, no spin", |n| {
        gauss(n, 4);
        n.raceway.spin = false;
    }),
];

struct Levels {
    /// Level of the mean power, and spread of the windows' levels [dB].
    level: [f64; 4],
    spread: [f64; 4],
    /// Of one evaluation of dy/dt [s].
    evaluation: f64,
    /// Of the run [s].
    time: f64,
}

fn settings(scene: &Scene, outputs: Outputs) -> RunSettings {
    let cage = 0.43 * scene.operating_speed() / std::f64::consts::TAU;
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: TOLERANCE,
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
    let begin = Instant::now();
    let mut observer = Observer::new(&model, needs, &settings);
    let tolerances = model.mechanism().layout.tolerances(TOLERANCE);
    let mut integrator = Method::Auto.start(&model, 0.0, &start, tolerances, None);
    while observer.next_look().is_some() {
        integrator.step(observer.end()).expect("a step");
        observer.after(integrator.as_ref());
    }
    let time = begin.elapsed().as_secs_f64();
    let state = integrator.state().to_vec();
    let recording = observer.finish();
    let length = (window(scene) * RATE) as usize;
    let mut found = Levels { level: [0.0; 4], spread: [0.0; 4], evaluation: evaluation(&model, &state), time };
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

/// Time of one evaluation of dy/dt, least of several means [s].
fn evaluation(model: &Model, state: &[f64]) -> f64 {
    const COUNT: u32 = 200;
    let mut rate = vec![0.0; state.len()];
    let mut mean = || {
        let begin = Instant::now();
        for _ in 0..COUNT {
            model.derivative(0.1, std::hint::black_box(state), &mut rate);
        }
        begin.elapsed().as_secs_f64() / f64::from(COUNT)
    };
    (0..25).map(|_| mean()).fold(f64::INFINITY, f64::min)
}

fn named() -> Vec<(String, Scene)> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    if arguments.iter().any(|argument| argument == "extremes") {
        return scenes::extremes().into_iter().map(|(name, scene)| (name.to_owned(), scene)).collect();
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

fn main() {
    for (name, scene) in named() {
        let needs = Needs::of(&scene, &outputs(), None).expect("a scene");
        let whole = if std::env::var_os("JUDGE").is_some() { Levels { level: [0.0; 4], spread: [0.0; 4], evaluation: 0.0, time: 0.0 } } else { levels(&scene, &needs) };
        let decibels = |values: &[f64]| values.iter().map(|v| format!("{v:8.4}")).collect::<Vec<_>>().join(" ");
        println!(
            "{name}: {}, {} strips, {:.2} µs, {:.2} s; rms a_y {:.3} a_z {:.3}; spread {}",
            needs.rung.name(),
            needs.raceway.strips,
            1e6 * whole.evaluation,
            whole.time,
            10f64.powf(0.05 * whole.level[0]),
            10f64.powf(0.05 * whole.level[1]),
            decibels(&whole.spread)
        );
        if let Ok(judge) = raceway::simulation::judgement::Judge::new(&scene, &needs) {
            let g = |points| judge.traction(raceway::physics::raceway::RacewayTerms { gauss: true, strips: points, ..needs.raceway });
            println!(
                "  JUDGE exc {:?} load {} drag {} churning {} ball_gravity {} six {} four {} two {} conf {} spin {}",
                judge.excitation, judge.load, judge.drag(), judge.churning(), judge.weight(), g(6), g(4), g(2),
                judge.traction(raceway::physics::raceway::RacewayTerms { conformity: false, ..needs.raceway }),
                judge.traction(raceway::physics::raceway::RacewayTerms { spin: false, ..needs.raceway }),
            );
        }
        if std::env::var_os("JUDGE").is_some() {
            continue;
        }
        for (term, omit) in OMISSIONS {
            let mut without = needs.clone();
            omit(&mut without);
            if without == needs {
                continue;
            }
            let lean = levels(&scene, &without);
            let off: Vec<f64> = (0..4).map(|c| lean.level[c] - whole.level[c]).collect();
            println!(
                "    {term:18} {}   {:.3} of the evaluation, {:.3} of the run",
                decibels(&off),
                lean.evaluation / whole.evaluation,
                lean.time / whole.time
            );
        }
    }
}
