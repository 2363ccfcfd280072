//! The periodic orbit of the spindle-only model over a grid of speeds, clearances and loads, with its cost.
//!
//! Every scene is either right or rejected by its Floquet multipliers. Right is a level within 0.01 dB of the spindle-only
//! model in time. `cargo bench --bench periodic` runs the article's bearing with a spindle of 50 g. Times are processor time
//! of one thread, medians of five.

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::{periodic, spindle_only};
use raceway::simulation::recording::record::Recording;
use raceway::simulation::recording::sampling::BAND;
use raceway::simulation::result::metrics::channel_metrics;
use rustix::time::{ClockId, clock_gettime};
use serde_json::json;

/// Speeds [1000 r/min], clearances [µm] and loads [N] of the grid.
const SPEEDS: [f64; 6] = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
const CLEARANCES: [f64; 4] = [2.0, 5.0, 7.5, 10.0];
const LOADS: [f64; 7] = [50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 400.0];
const RUNS: usize = 5;
/// Largest deviation of a right level [dB].
const RIGHT: f64 = 0.01;
const SIGNALS: [(Axis, Motion); 4] = [
    (Axis::Y, Motion::Acceleration),
    (Axis::Z, Motion::Acceleration),
    (Axis::Y, Motion::Velocity),
    (Axis::Z, Motion::Velocity),
];

fn scene(speed: f64, clearance: f64, load: f64) -> Scene {
    let json = json!({
        "bearing": { "preset": "article-integrated", "radial_clearance_um": clearance },
        "spindle": { "mass_kg": 0.05 },
        "operation": { "speed_rpm": 1e3 * speed, "radial_load_y_n": load }
    });
    scene_from_json(&json.to_string()).expect("a scene")
}

fn cpu_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn levels(recording: &Recording) -> [f64; 4] {
    SIGNALS.map(|(axis, motion)| {
        let channel = Channel::Spindle(axis, motion);
        channel_metrics(channel, recording.signal(channel).expect("always kept"), 0.0).rms
    })
}

fn main() {
    // A quarter of the usual step, so that the deviation is that of the periodic orbit.
    let settings = RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: 1e-6,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: Some(2.5e-6),
        settle: 0.3,
        duration: 0.3,
        outputs: Outputs::vibration(),
    };
    let control = Control::until(&|| false);
    println!("krpm, µm, N: radius, worst of the levels of y and z, acceleration and velocity, against rung 3 in time");
    let (mut refused, mut right, mut wrong, mut worst) = (0, 0, 0, 0.0_f64);
    let mut times: Vec<(f64, f64)> = Vec::new();
    let mut extended: Vec<f64> = Vec::new();
    for speed in SPEEDS {
        for clearance in CLEARANCES {
            for load in LOADS {
                let scene = scene(speed, clearance, load);
                let mut took: Vec<f64> = (0..RUNS)
                    .map(|_| {
                        let begin = cpu_time();
                        let levels = periodic::passage(&scene, &settings).map(|passage| passage.rms(BAND));
                        let _ = std::hint::black_box(levels);
                        cpu_time() - begin
                    })
                    .collect();
                took.sort_by(f64::total_cmp);
                let (in_time, _) = spindle_only::simulate(&scene, &settings, &control).expect("rung 3 runs");
                let begin = cpu_time();
                let periodic = periodic::simulate(&scene, &settings, &control);
                extended.push(cpu_time() - begin);
                match periodic {
                    Ok((recording, _)) => {
                        let difference = levels(&recording)
                            .iter()
                            .zip(levels(&in_time))
                            .map(|(a, b)| (20.0 * (a / b).log10()).abs())
                            .fold(0.0, f64::max);
                        let radius = periodic::passage(&scene, &settings).expect("as before").orbit.radius();
                        worst = worst.max(difference);
                        times.push((speed, took[RUNS / 2]));
                        if difference <= RIGHT {
                            right += 1;
                        } else {
                            wrong += 1;
                            println!("{speed:>3} {clearance:>5} {load:>4}: radius {radius:.3}, {difference:.4} dB");
                        }
                    }
                    Err(error) => {
                        refused += 1;
                        println!("{speed:>3} {clearance:>5} {load:>4}: {error} ({:.2} ms)", 1e3 * took[RUNS / 2]);
                    }
                }
            }
        }
    }
    println!("{right} right, {wrong} off by more than {RIGHT} dB (worst {worst:.4}), {refused} refused");
    for speed in SPEEDS {
        let mut of: Vec<f64> = times.iter().filter(|(s, _)| *s == speed).map(|(_, time)| 1e3 * time).collect();
        of.sort_by(f64::total_cmp);
        if let (Some(least), Some(most)) = (of.first(), of.last()) {
            println!("{speed} krpm: orbit and levels in {least:.3} … {:.3} … {most:.3} ms", of[of.len() / 2]);
        }
    }
    extended.sort_by(f64::total_cmp);
    println!("with 0.3 s of recording: median {:.2} ms", 1e3 * extended[extended.len() / 2]);
}
