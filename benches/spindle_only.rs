//! The spindle-only model against the full model: error of the levels of y and z [dB], and run time over the step.
//!
//! | command | effect |
//! |---|---|
//! | `cargo bench --bench spindle_only -- reference FILE` | runs the full model once (some minutes) and stores its levels |
//! | `-- against FILE` | compares the spindle-only model and its periodic orbit with these levels |
//! | no option | prints error and run time over the step |
//! | `-- trimmed` | the same, with a C library that returns free memory to the kernel, as it does by default |
//!
//! Times are processor time of one thread, medians of five.

use std::fmt::Write as _;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::simulation::error::report::AccuracyReport;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::Model;
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::model::observer::Observer;
use raceway::simulation::model::terms::ActiveTerms;
use raceway::simulation::model::{periodic, spindle_only};
use raceway::simulation::recording::record::Recording;
use raceway::simulation::recording::sampling::RATE;
use raceway::simulation::result::metrics::{self, channel_metrics};
use rustix::time::{ClockId, clock_gettime};
use serde_json::json;

/// Diametral clearance [µm], radial load [N], speed [1000 r/min], balls, spindle [g].
const SCENES: [(f64, f64, f64, u32, f64); 18] = [
    (5.0, 200.0, 50.0, 7, 50.0),
    (2.0, 200.0, 50.0, 7, 50.0),
    (10.0, 200.0, 50.0, 7, 50.0),
    (5.0, 50.0, 50.0, 7, 50.0),
    (5.0, 100.0, 50.0, 7, 50.0),
    (5.0, 400.0, 50.0, 7, 50.0),
    (5.0, 200.0, 10.0, 7, 50.0),
    (5.0, 200.0, 20.0, 7, 50.0),
    (5.0, 200.0, 30.0, 7, 50.0),
    (5.0, 200.0, 40.0, 7, 50.0),
    (5.0, 200.0, 60.0, 7, 50.0),
    (5.0, 200.0, 50.0, 6, 50.0),
    (5.0, 200.0, 50.0, 8, 50.0),
    (5.0, 200.0, 50.0, 9, 50.0),
    (5.0, 200.0, 50.0, 7, 75.0),
    (5.0, 200.0, 50.0, 7, 100.0),
    (2.0, 400.0, 30.0, 8, 50.0),
    (10.0, 400.0, 20.0, 7, 75.0),
];
const WINDOWS: usize = 4;
const WINDOW: f64 = 0.1;
const SETTLE: f64 = 0.06;
const TOLERANCE: f64 = 1e-7;

fn scene((clearance, load, speed, balls, mass): (f64, f64, f64, u32, f64)) -> Scene {
    let json = json!({
        "bearing": { "preset": "article-integrated", "ball_count": balls, "radial_clearance_um": clearance },
        "spindle": { "mass_kg": 1e-3 * mass },
        "operation": { "speed_rpm": 1e3 * speed, "radial_load_y_n": load }
    });
    scene_from_json(&json.to_string()).expect("a scene")
}

fn settings(duration: f64) -> RunSettings {
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: TOLERANCE,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: SETTLE,
        duration,
        outputs: Outputs::vibration(),
    }
}

/// rms of a_y, a_z [m/s²], v_y, v_z [mm/s], 0–20 kHz, over a window of a recording.
fn levels(recording: &Recording, window: usize) -> [f64; 4] {
    let length = (WINDOW * RATE).round() as usize;
    [
        (Axis::Y, Motion::Acceleration),
        (Axis::Z, Motion::Acceleration),
        (Axis::Y, Motion::Velocity),
        (Axis::Z, Motion::Velocity),
    ]
    .map(|(axis, motion)| {
        let channel = Channel::Spindle(axis, motion);
        let signal = recording.signal(channel).expect("always kept");
        channel_metrics(channel, &signal[window * length..(window + 1) * length], 0.0).rms
    })
}

fn reference(file: &str) {
    for parameters in SCENES {
        let scene = scene(parameters);
        let settings = settings(WINDOWS as f64 * WINDOW);
        let needs = ActiveTerms::of(&scene, &settings.outputs, Some(ModelLevel::Full)).expect("full serves all");
        let model = Model::new(&scene, &needs);
        let start = start_state(&model).expect("an equilibrium");
        let mut observer = Observer::new(&model, &needs, &settings);
        let tolerances = model.mechanism().layout.tolerances(TOLERANCE);
        let begin = std::time::Instant::now();
        let mut integrator = settings.method.start(&model, 0.0, &start, tolerances, None);
        while integrator.time() < observer.end() {
            integrator.step(observer.end()).expect("runs through");
            observer.after(integrator.as_ref());
        }
        let recording = observer.finish();
        let mut line = format!("{parameters:?} cage {:.9}", recording.speeds.cage / recording.speeds.shaft);
        for window in 0..WINDOWS {
            for level in levels(&recording, window) {
                let _ = write!(line, " {level:.9e}");
            }
        }
        println!("{line} {:.1} s {:?}", begin.elapsed().as_secs_f64(), integrator.choice().method);
        let mut all = std::fs::read_to_string(file).unwrap_or_default();
        all += &line;
        all += "\n";
        std::fs::write(file, all).expect("can be written");
    }
}

const QUIET: Control<'static> = Control::until(&|| false);
const RUNS: usize = 5;
/// 20 lg(a/b) [dB]
fn db(a: f64, b: f64) -> f64 {
    20.0 * (a / b).log10()
}

/// Root mean square of the windows' levels.
fn mean(windows: &[[f64; 4]]) -> [f64; 4] {
    std::array::from_fn(|i| (windows.iter().map(|w| w[i] * w[i]).sum::<f64>() / windows.len() as f64).sqrt())
}

fn against(file: &str) {
    let text = std::fs::read_to_string(file).expect("made by `reference`");
    println!(
        "µm, N, krpm, balls, g: rung less full [dB], a_y a_z v_y v_z; spread of full's windows; rung 4 less rung 3"
    );
    for (parameters, line) in SCENES.into_iter().zip(text.lines()) {
        let numbers: Vec<f64> =
            line.split("cage ").nth(1).expect("a line").split(' ').map(|x| x.parse().expect("a number")).collect();
        let windows: Vec<[f64; 4]> = numbers[1..].chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]).collect();
        let full = mean(&windows);
        let spread = windows.iter().flat_map(|w| (0..4).map(|i| db(w[i], full[i]).abs())).fold(0.0, f64::max);
        let (scene, settings) = (scene(parameters), settings(WINDOWS as f64 * WINDOW));
        let (recording, _) = spindle_only::simulate(&scene, &settings, &QUIET).expect("rung 3 runs");
        let rung = mean(&(0..WINDOWS).map(|w| levels(&recording, w)).collect::<Vec<_>>());
        let mut row = format!("{parameters:?}");
        for i in 0..4 {
            let _ = write!(row, " {:+.3}", db(rung[i], full[i]));
        }
        let _ = write!(row, "; {spread:.3};");
        match periodic::simulate(&scene, &settings, &QUIET) {
            Ok((recording, _)) => {
                let periodic = mean(&(0..WINDOWS).map(|w| levels(&recording, w)).collect::<Vec<_>>());
                for i in 0..4 {
                    let _ = write!(row, " {:+.4}", db(periodic[i], rung[i]));
                }
            }
            Err(error) => {
                let _ = write!(row, " {error}");
            }
        }
        println!("{row}");
    }
}

fn cpu_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Prints, for each step, the largest level error over all scenes and the time for 0.12 s.
fn steps() {
    println!("step µs: worst and median error of the levels [dB] against 1.2 µs; ms for 0.12 s; times real time");
    let run = |parameters, step: f64| {
        let settings = RunSettings { fixed_step: Some(1.0001 * step), settle: 0.02, ..settings(0.1) };
        let scene = scene(parameters);
        let mut times = Vec::new();
        let mut found = [0.0; 4];
        for _ in 0..RUNS {
            let begin = cpu_time();
            let (recording, _) = spindle_only::simulate(&scene, &settings, &QUIET).expect("rung 3 runs");
            times.push(cpu_time() - begin);
            found = levels(&recording, 0);
        }
        times.sort_by(f64::total_cmp);
        (found, times[RUNS / 2])
    };
    let exact: Vec<[f64; 4]> = SCENES.iter().map(|p| run(*p, 1.0 / (8.0 * RATE)).0).collect();
    for per_value in [4.0, 2.0, 1.0, 4.0 / 5.0, 2.0 / 3.0, 4.0 / 7.0, 1.0 / 2.0] {
        let step = 1.0 / (per_value * RATE);
        let runs: Vec<([f64; 4], f64)> = SCENES.iter().map(|p| run(*p, step)).collect();
        let mut errors: Vec<f64> = runs
            .iter()
            .zip(&exact)
            .map(|((found, _), exact)| (0..4).map(|i| db(found[i], exact[i]).abs()).fold(0.0, f64::max))
            .collect();
        errors.sort_by(f64::total_cmp);
        let mut times: Vec<f64> = runs.iter().map(|run| run.1).collect();
        times.sort_by(f64::total_cmp);
        let (worst, middle, time) = (errors[errors.len() - 1], errors[errors.len() / 2], times[times.len() / 2]);
        println!("{:>6.2}: {worst:.4} {middle:.4}; {:.3} ms; {:.0}", 1e6 * step, 1e3 * time, 0.12 / time);
    }
}

/// Prints the parts of the run time of a whole job on the article's scene.
fn parts() {
    let scene = scene(SCENES[0]);
    let mut settings = RunSettings { settle: 0.02, ..settings(0.1) };
    settings.outputs.spectra = [Axis::Y, Axis::Z].map(|axis| Channel::Spindle(axis, Motion::Acceleration)).to_vec();
    let mut times: [Vec<f64>; 4] = std::array::from_fn(|_| Vec::new());
    for _ in 0..4 * RUNS + 1 {
        let mut clock = vec![cpu_time()];
        let (recording, _) = spindle_only::simulate(&scene, &settings, &QUIET).expect("rung 3 runs");
        clock.push(cpu_time());
        std::hint::black_box(metrics::vibration(&recording));
        clock.push(cpu_time());
        let spectra = metrics::spectra(&recording, &settings);
        clock.push(cpu_time());
        std::hint::black_box(metrics::lines(
            &scene,
            &recording,
            &spectra,
            metrics::Spectra::Amplitude,
            &AccuracyReport::default(),
        ));
        clock.push(cpu_time());
        for (times, ends) in times.iter_mut().zip(clock.windows(2)) {
            times.push(ends[1] - ends[0]);
        }
    }
    let median = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        1e3 * times[2 * RUNS]
    });
    println!("0.12 s of the article's scene [ms]: run, metrics, spectra, lines {median:.3?}");
}

fn main() {
    if !std::env::args().any(|argument| argument == "trimmed") {
        raceway::commands::allocator::keep_memory_for_next_run();
    }
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["reference", file] => reference(file),
        ["against", file] => against(file),
        _ => {
            steps();
            parts();
        }
    }
}
