//! The radially condensed model against the full model: level error and run time.
//!
//! | command | runs |
//! |---|---|
//! | `cargo bench --bench rungs [-- FIRST LAST]` | the scenes of these numbers, by default all, with several steps |
//! | `-- others` | contacts outside the range of the short traction formula, with the formulas that replace it |
//! | `-- chosen` | plain jobs on the model that the program chooses, at model tolerances of 0.05 and 0.2 dB |
//!
//! The full model runs by `auto` at a relative tolerance of 1e-7 over four windows of 0.1 s after settling. A level is the mean
//! power of the windows, 0–20 kHz. The spread is the standard deviation of the windows' levels. Run time is the processor time
//! of the thread for 0.02 + 0.1 s, the least of several runs. `RUNGS_REFERENCE=DIR` names a folder that stores the levels of the
//! full model between runs.

mod scenes;

use std::path::PathBuf;

use raceway::contract::scene_from_json;
use raceway::numerics::ode::Method;
use raceway::physics::cage::PocketSeat;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::input::control::Control;
use raceway::simulation::input::model_level::ModelLevel;
use raceway::simulation::input::scene::Scene;
use raceway::simulation::input::settings::{Outputs, RunSettings};
use raceway::simulation::model::radially_condensed::{RadiallyCondensed, StepRatio};
use raceway::simulation::recording::record::Recording;
use raceway::simulation::recording::sampling::RATE;
use raceway::simulation::result::metrics::Summary;
use raceway::simulation::result::metrics::channel_metrics;
use raceway::simulation::solve::run::simulate;
use scenes::{SCENES, scene};

const WINDOW: f64 = 0.1;
const WINDOWS: usize = 4;
const RATIOS: [StepRatio; 5] =
    [StepRatio::LONG[0], StepRatio::LONG[1], StepRatio::LONG[2], StepRatio::LONG[3], StepRatio::of_steps(1)];
const TIMED_RUNS: usize = 7;
const CHANNELS: [Channel; 4] = [
    Channel::Spindle(Axis::Y, Motion::Acceleration),
    Channel::Spindle(Axis::Z, Motion::Acceleration),
    Channel::Spindle(Axis::Y, Motion::Velocity),
    Channel::Spindle(Axis::Z, Motion::Velocity),
];

fn settings(scene: &Scene, duration: f64) -> RunSettings {
    let cage = 0.43 * scene.operating_speed() / std::f64::consts::TAU;
    RunSettings {
        method: Method::Auto,
        rung: None,
        relative_tolerance: 1e-7,
        tightened: None,
        model_tolerance_db: 0.0,
        fixed_step: None,
        settle: (3.0 / cage).max(0.02),
        duration,
        outputs: Outputs { series: CHANNELS.to_vec(), ..Outputs::vibration() },
    }
}

const CONTROL: Control<'static> = Control::until(&|| false);

/// Rms of each window of each channel [SI].
type Levels = [[f64; WINDOWS]; 4];

fn levels(signal: impl Fn(Channel) -> Vec<f64>) -> Levels {
    let length = (WINDOW * RATE) as usize;
    CHANNELS.map(|channel| {
        let signal = signal(channel);
        std::array::from_fn(|w| {
            channel_metrics(channel, &signal[w * length..(w + 1) * length], 0.0).rms / channel.scale()
        })
    })
}

fn of_recording(recording: &Recording) -> Levels {
    levels(|channel| recording.signal(channel).expect("kept").to_vec())
}

fn full(scene: &Scene, text: &str) -> (Levels, f64) {
    let kept = std::env::var_os("RUNGS_REFERENCE").map(|dir| {
        let name: String = text.chars().filter(|c| c.is_ascii_digit() || ".,".contains(*c)).collect();
        PathBuf::from(dir).join(name)
    });
    if let Some(text) = kept.as_ref().and_then(|path| std::fs::read_to_string(path).ok()) {
        return serde_json::from_str(&text).expect("written by this program");
    }
    let settings = settings(scene, WINDOW * WINDOWS as f64);
    let begin = cpu_time();
    let result = simulate(scene, &settings, &CONTROL).expect("the full dynamics run");
    let speed = (settings.settle + settings.duration) / (cpu_time() - begin);
    let found = levels(|channel| {
        let series = result.series.iter().find(|series| series.channel == channel).expect("kept");
        series.values.iter().map(|value| value / channel.scale()).collect()
    });
    if let Some(path) = kept {
        std::fs::write(path, serde_json::to_string(&(found, speed)).expect("numbers")).expect("a folder");
    }
    (found, speed)
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

/// Level of the mean power [dB re 1], and the standard deviation of the windows' levels.
fn mean_and_spread(windows: &[f64; WINDOWS]) -> (f64, f64) {
    let n = WINDOWS as f64;
    let power = windows.iter().map(|rms| rms * rms).sum::<f64>() / n;
    let db = windows.map(|rms| 20.0 * rms.log10());
    let mean = db.iter().sum::<f64>() / n;
    let variance = db.iter().map(|level| (level - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (10.0 * power.log10(), variance.sqrt())
}

/// Plain runs of 0.02 + 0.1 s on the chosen model, with all metrics and with vibration only, beside `full`.
///
/// Prints the larger level error of a_y and a_z. The last lines count scenes on a spindle-only model, and scenes with an error
/// beyond the tolerance.
fn chosen() {
    println!(
        "| r/min | N | P_d µm | balls | g | G | all metrics: dB off, stated | ms | vibration only: dB off, stated | ms | at 0.2 dB | ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    let cases = [(true, 0.05), (false, 0.05), (false, 0.2)];
    let (mut admitted, mut wrong) = (cases.map(|_| 0), cases.map(|_| 0));
    for (number, (speed, load, clearance, balls, mass, grade)) in SCENES.into_iter().enumerate() {
        let (scene, _) = scene(number);
        let plain = |rung: Option<ModelLevel>, all: bool, tolerance_db: f64| {
            let outputs = Outputs { contacts: all, cage: all, spectra: CHANNELS[..2].to_vec(), ..Outputs::vibration() };
            let settings = RunSettings {
                rung,
                relative_tolerance: 1e-5,
                model_tolerance_db: tolerance_db,
                settle: 0.02,
                outputs,
                ..settings(&scene, 0.1)
            };
            simulate(&scene, &settings, &CONTROL).expect("the scenes run").summary
        };
        let level = |summary: &Summary, channel: Channel| {
            let found = summary.channels.iter().find(|(of, _)| *of == channel);
            found.and_then(|(_, metrics)| metrics.level_db).expect("the scenes vibrate")
        };
        let full = plain(Some(ModelLevel::Full), true, 0.05);
        let mut line = format!("| {speed} | {load} | {clearance} | {balls} | {mass} | {grade} |");
        for (case, (all, tolerance)) in cases.into_iter().enumerate() {
            let found = plain(None, all, tolerance);
            let off = CHANNELS[..2].iter().map(|c| (level(&found, *c) - level(&full, *c)).abs()).fold(0.0, f64::max);
            let stated = found.accuracy.level_error_db().expect("a level is judged");
            let level = found.solver.level;
            admitted[case] += usize::from([ModelLevel::SpindleOnly, ModelLevel::Periodic].contains(&level));
            wrong[case] += usize::from(off > tolerance);
            line += &format!(" `{}` {off:.4}, {stated:.4} | {:.0} |", level.name(), 1e3 * found.solver.wall_time);
        }
        println!("{line}");
    }
    for (case, (all, tolerance)) in cases.into_iter().enumerate() {
        let metrics = if all { "all metrics" } else { "vibration only" };
        println!(
            "{metrics}, {tolerance} dB: the spindle alone in {} of {} scenes, {} off by more",
            admitted[case],
            SCENES.len(),
            wrong[case]
        );
    }
}

/// Contacts outside the range of the short traction formula. Wide contacts use the strips of the full model, oil its contacts.
/// Each with bearing, speed [r/min] and load [N].
const OTHERS: [(&str, &str, f64, f64); 8] = [
    ("f 0.52", r#"{ "preset": "article-integrated" }"#, 50_000.0, 200.0),
    (
        "f 0.51",
        r#"{ "preset": "article-integrated", "inner_groove_curvature": 0.51, "outer_groove_curvature": 0.51 }"#,
        50_000.0,
        200.0,
    ),
    (
        "f 0.51",
        r#"{ "preset": "article-integrated", "inner_groove_curvature": 0.51, "outer_groove_curvature": 0.51 }"#,
        50_000.0,
        400.0,
    ),
    (
        "f 0.51",
        r#"{ "preset": "608", "inner_groove_curvature": 0.51, "outer_groove_curvature": 0.51 }"#,
        10_000.0,
        500.0,
    ),
    ("0.01 Pa s", r#"{ "preset": "article-integrated" }"#, 50_000.0, 200.0),
    ("0.05 Pa s", r#"{ "preset": "article-integrated" }"#, 50_000.0, 200.0),
    ("0.01 Pa s", r#"{ "preset": "6205" }"#, 10_000.0, 500.0),
    ("0.05 Pa s", r#"{ "preset": "6205" }"#, 10_000.0, 500.0),
];

fn others() {
    println!(
        "| bearing | r/min | N | | step µs | error a_y, a_z, v_y, v_z dB | × real time | through the contacts of the full model: × |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (what, bearing, speed, load) in OTHERS {
        let bearing: serde_json::Value = serde_json::from_str(bearing).expect("JSON");
        let name = bearing["preset"].clone();
        let mut json = serde_json::json!({
            "bearing": bearing, "operation": { "speed_rpm": speed, "radial_load_y_n": load }
        });
        if let Some(viscosity) = what.strip_suffix(" Pa s") {
            let viscosity: f64 = viscosity.parse().expect("a number");
            json["lubricant"] = serde_json::json!({ "kind": "oil", "viscosity_pa_s": viscosity });
        }
        let text = json.to_string();
        let scene = scene_from_json(&text).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        let (reference, _) = full(&scene, &text);
        let long = settings(&scene, WINDOW * WINDOWS as f64);
        let model = RadiallyCondensed::new(&scene, &long.outputs).expect("a scene in the plane");
        let ratio = model.step_ratio_for(&long);
        let found = of_recording(&model.run(&long, ratio, &CONTROL).expect("the scenes run").0);
        let level = |windows: &[f64; WINDOWS]| mean_and_spread(windows).0;
        let errors: Vec<String> = (0..4).map(|c| format!("{:.3}", level(&found[c]) - level(&reference[c]))).collect();
        println!(
            "| {} | {speed} | {load} | {what} | {:.2} | {} | {:.1} | {:.1} |",
            name.as_str().unwrap_or_default(),
            1e6 * ratio.step(),
            errors.join(" "),
            real_time_factor(&scene, ratio, |model| model),
            real_time_factor(&scene, ratio, RadiallyCondensed::with_general_traction)
        );
    }
}

fn main() {
    raceway::commands::allocator::keep_memory_for_next_run();
    if std::env::args().any(|argument| argument == "chosen") {
        return chosen();
    }
    if std::env::args().any(|argument| argument == "others") {
        return others();
    }
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|argument| argument.parse().ok()).collect();
    let (first, last) = (numbers.first().copied().unwrap_or(1), numbers.get(1).copied().unwrap_or(SCENES.len()));
    println!(
        "| scene | r/min | N | P_d µm | balls | g | G | rms full a_y, a_z m/s² | spread a_y, a_z, v_y, v_z dB | full × | step µs | error a_y, a_z, v_y, v_z dB | × real time |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let mut summary = RATIOS.map(|_| (Vec::new(), Vec::new()));
    let (mut within, mut figures) = (RATIOS.map(|_| 0), 0);
    for (number, &(speed, load, clearance, balls, mass, grade)) in SCENES.iter().enumerate().take(last).skip(first - 1)
    {
        let (scene, text) = scene(number);
        assert!(scene.cage.seat == PocketSeat::Open || scene.cage.offset == 0.0);
        let (reference, full_speed) = full(&scene, &text);
        let reference = reference.map(|windows| mean_and_spread(&windows));
        figures += 4;
        for (i, ratio) in RATIOS.into_iter().enumerate() {
            let long = settings(&scene, WINDOW * WINDOWS as f64);
            let model = RadiallyCondensed::new(&scene, &long.outputs).expect("a scene in the plane");
            let (errors, factor) = match model.run(&long, ratio, &CONTROL) {
                Ok((recording, _)) => {
                    let found = of_recording(&recording).map(|windows| mean_and_spread(&windows));
                    let errors: [f64; 4] = std::array::from_fn(|c| found[c].0 - reference[c].0);
                    (errors, real_time_factor(&scene, ratio, |model| model))
                }
                Err(fault) => {
                    println!("{fault}");
                    ([f64::NAN; 4], f64::NAN)
                }
            };
            within[i] += errors.iter().zip(&reference).filter(|(e, r)| e.abs() <= 0.05 + 2.0 * r.1).count();
            summary[i].0.extend(errors.map(f64::abs));
            summary[i].1.push(factor);
            let decibels = |values: &[f64]| values.iter().map(|v| format!("{v:.3}")).collect::<Vec<_>>().join(" ");
            let accelerations =
                format!("{:.2} {:.2}", 10f64.powf(0.05 * reference[0].0), 10f64.powf(0.05 * reference[1].0));
            println!(
                "| {} | {speed} | {load} | {clearance} | {balls} | {mass} | {grade} | {accelerations} | {} | {full_speed:.2} | {:.2} | {} | {factor:.1} |",
                number + 1,
                decibels(&reference.map(|r| r.1)),
                ratio.step() * 1e6,
                decibels(&errors)
            );
        }
    }
    println!();
    println!(
        "| step µs | figures within 0.05 dB + 2 spreads | median error dB | worst error dB | least, median × real time |"
    );
    println!("|---|---|---|---|---|");
    for (i, (mut errors, mut factors)) in summary.into_iter().enumerate() {
        errors.sort_by(f64::total_cmp);
        factors.sort_by(f64::total_cmp);
        let step = RATIOS[i].step() * 1e6;
        let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        println!(
            "| {step:.2} | {} of {figures} | {median:.3} | {worst:.3} | {:.0}, {:.0} |",
            within[i],
            factors[0],
            factors[factors.len() / 2]
        );
    }
}

/// Simulated time over processor time, model and recording included. `change` replaces parts of the model.
fn real_time_factor(scene: &Scene, ratio: StepRatio, change: impl Fn(RadiallyCondensed) -> RadiallyCondensed) -> f64 {
    let settings = RunSettings { settle: 0.02, ..settings(scene, 0.1) };
    let once = || {
        let begin = cpu_time();
        let model = change(RadiallyCondensed::new(scene, &settings.outputs).expect("a scene in the plane"));
        let recording = model.run(&settings, ratio, &CONTROL).expect("it ran before");
        std::hint::black_box(&recording);
        cpu_time() - begin
    };
    0.12 / (0..TIMED_RUNS).map(|_| once()).fold(f64::INFINITY, f64::min)
}
